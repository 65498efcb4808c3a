//! Changes of reports that a scenario has.

use super::Names;
use crate::config::error::Problem;
use crate::config::keys;
use crate::config::section::Section;
use crate::motion::changes::{Change, ChangeFault, Event, MOST_CHANGES};
use crate::scene::Radar;

/// Part of an interval by which a pulse may come before a time as written and still count: rounding of
/// decimals.
const SLACK: f64 = 1e-6;

/// `[[event]]`, in the order as written.
pub(super) fn events(
    root: &Section<'_>,
    platforms: &Names,
    radar: Option<&Radar>,
    duration_s: Option<f64>,
) -> Option<Vec<Event>> {
    let sections = root.sections(&keys::root::EVENT);
    let count = sections.len() as u64;
    if count > MOST_CHANGES as u64 {
        let allowed = MOST_CHANGES as u64;
        root.fault(&keys::root::EVENT, Problem::TooMany { count, what: "events", allowed });
    }
    let events: Vec<Option<Event>> =
        sections.into_iter().map(|section| event(section, platforms, radar, duration_s)).collect();
    events.into_iter().collect()
}

fn event(
    section: Section<'_>,
    platforms: &Names,
    radar: Option<&Radar>,
    duration_s: Option<f64>,
) -> Option<Event> {
    use keys::event::{AT_S, CHANGE, PLATFORM, PULSE};
    let written = section.exactly_one(&[&PULSE, &AT_S]);
    let (pulse, at_s) = (section.count(&PULSE), section.number(&AT_S));
    let platform = platforms.find_or_only(&section, &PLATFORM);
    let change = section.line(&CHANGE).and_then(|text| {
        let change = text.parse::<Change>();
        change.map_err(|error| section.fault(&CHANGE, Problem::Refused { error: error.to_string() })).ok()
    });
    let times = radar.map(|radar| &radar.emissions);
    let first = match (pulse, at_s, times) {
        (Some(pulse), ..) => Some(pulse),
        (None, Some(at_s), Some(times)) => {
            Some(if at_s > 0.0 { times.count_within(at_s - SLACK * times.shortest_pri_s()) } else { 0 })
        }
        _ => None,
    };
    if let (Some(pulse), Some(times), Some(duration_s)) = (first, times, duration_s) {
        let end = times.count_within(duration_s);
        if pulse >= end {
            let key = if section.has(&AT_S) { &AT_S } else { &PULSE };
            let error = ChangeFault::AfterTheEnd { pulse, end }.to_string();
            section.fault(key, Problem::Refused { error });
        }
    }
    section.finish();
    written?;
    Some(Event { pulse: first?, platform: platform?, change: change? })
}
