//! Which platform misreports what, and since when.
//!
//! A quantity counts as misreported where its error was at least its [`Quantity::least`] in the last second;
//! the worst of that second is shown. It has been so since the error rose above half of that, and has not
//! stayed below for longer than [`DIP_S`]: errors that swing through zero are one error. Where a change of
//! the log falls into the interval in which that happened, it names the pulse exactly. An error that grows by
//! a ramp or a dropout passes the half long after that has begun: there, the change is its begin.

use serde::Serialize;

use super::history::{Instant, Sample};
use crate::pulse::log::Entry;

/// A platform that reports something else than the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Misreport {
    /// Which.
    pub platform: String,
    /// What it reports wrongly.
    pub quantity: &'static str,
    /// By how much.
    pub error: f64,
    /// Unit of the error.
    pub unit: &'static str,
    /// Direction, where one component is most of it.
    pub direction: Option<&'static str>,
    /// First pulse that is known to have it; `None`: as far back as is known.
    pub since_pulse: Option<u64>,
    /// Emission of that pulse after that of pulse 0, s.
    pub since_s: Option<f64>,
    /// The change that made it.
    pub cause: Option<String>,
}

/// The time before the last point that counts as now, s.
const NOW_S: f64 = 1.0;
/// How long an error may be small and still go on, s.
const DIP_S: f64 = 2.0;

/// What platforms report.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    least: f64,
    error: fn(&Sample) -> [f64; 3],
    directions: [[&'static str; 2]; 3],
}

/// The quantities; errors below the least are those of good navigation.
const QUANTITIES: [Quantity; 3] = [
    Quantity {
        name: "position",
        unit: "m",
        least: 1.0,
        error: |sample| sample.position_m,
        directions: [
            ["too far west", "too far east"],
            ["too far south", "too far north"],
            ["too low", "too high"],
        ],
    },
    Quantity {
        name: "velocity",
        unit: "m/s",
        least: 0.2,
        error: |sample| sample.velocity_mps,
        directions: [["west", "east"], ["south", "north"], ["down", "up"]],
    },
    Quantity {
        name: "attitude",
        unit: "deg",
        least: 0.2,
        error: |sample| sample.attitude_deg,
        directions: [
            ["in roll, to port", "in roll, to starboard"],
            ["nose too low", "nose too high"],
            ["in heading, to port", "in heading, to starboard"],
        ],
    },
];

fn size(error: [f64; 3]) -> f64 {
    error.iter().map(|part| part * part).sum::<f64>().sqrt()
}

/// Whether a change has to do with a quantity of a report.
fn concerns(change: &str, quantity: &str) -> bool {
    change.contains(&format!(" {quantity}."))
        || (quantity == "velocity" && change.starts_with("ramp position."))
        || ["dropout", "latency", "clear"].iter().any(|kind| change.starts_with(kind))
}

/// Whether the error that a change makes grows with time.
fn grows(change: &str) -> bool {
    change.starts_with("ramp") || change.starts_with("dropout")
}

/// Emission of a pulse, between the points around it.
fn time_of(points: &[Instant], pulse: u64) -> Option<f64> {
    let after = points.partition_point(|point| point.pulse < pulse);
    let (next, Some(before)) = (points.get(after)?, after.checked_sub(1)) else {
        return Some(points[0].time_s);
    };
    let before = &points[before];
    let share = (pulse - before.pulse) as f64 / (next.pulse - before.pulse) as f64;
    Some(before.time_s + share * (next.time_s - before.time_s))
}

/// First point of an error that is still there: from it on it was never below a level for long.
fn begin(points: &[Instant], level: f64, error: impl Fn(&Instant) -> f64) -> usize {
    let mut begin = points.len() - 1;
    for (place, point) in points.iter().enumerate().rev() {
        let size = error(point);
        if size >= level {
            begin = place;
        } else if size < level && points[begin].time_s - point.time_s > DIP_S {
            break;
        }
    }
    begin
}

/// What is misreported at the last of these points.
pub fn misreports(points: &[Instant], platforms: &[String], log: &[Entry]) -> Vec<Misreport> {
    let Some(last) = points.last() else { return Vec::new() };
    let lately = points.iter().rev().take_while(|point| last.time_s - point.time_s <= NOW_S);
    let mut found = Vec::new();
    for (place, platform) in platforms.iter().enumerate() {
        for quantity in &QUANTITIES {
            let of = |point: &Instant| point.platforms.get(place).map(quantity.error);
            let total_of = |point: &Instant| of(point).map_or(0.0, size);
            // What is no number is nowhere reported or true.
            let Some(error) = lately
                .clone()
                .filter_map(of)
                .filter(|error| size(*error) >= quantity.least)
                .max_by(|a, b| size(*a).total_cmp(&size(*b)))
            else {
                continue;
            };
            let total = size(error);
            let first = begin(points, 0.5 * total, total_of);
            let before = first.checked_sub(1).map(|before| points[before].pulse);
            let of_it = |entry: &&Entry| entry.platform == *platform && concerns(&entry.text, quantity.name);
            let until = |pulse: u64| move |entry: &&Entry| entry.pulse <= pulse;
            let cause = before.and_then(|before| {
                let at = log
                    .iter()
                    .filter(of_it)
                    .rfind(|entry| entry.pulse > before && entry.pulse <= points[first].pulse);
                // What an earlier step added is there at once: what grows goes on beside it.
                let earlier = || {
                    let lasting = |entry: &&Entry| !entry.text.starts_with("step");
                    log.iter()
                        .filter(of_it)
                        .filter(until(before))
                        .rfind(lasting)
                        .filter(|entry| grows(&entry.text))
                };
                at.or_else(earlier)
            });
            let since = cause.map(|entry| entry.pulse).or(before.map(|_| points[first].pulse));
            let direction = (0..3)
                .find(|axis| error[*axis].abs() > 0.9 * total)
                .map(|axis| quantity.directions[axis][usize::from(error[axis] > 0.0)]);
            found.push(Misreport {
                platform: platform.clone(),
                quantity: quantity.name,
                error: total,
                unit: quantity.unit,
                direction,
                since_pulse: since,
                since_s: since.and_then(|pulse| time_of(points, pulse)),
                cause: cause.map(|entry| entry.text.clone()),
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulse::log::Origin;

    fn points(error: impl Fn(u64) -> f64) -> Vec<Instant> {
        let sample = |n| Sample { position_m: [0.1, 0.0, error(n)], ..Sample::default() };
        let at = |n: u64| Instant {
            pulse: n,
            time_s: n as f64 * 0.01,
            platforms: vec![Sample::default(), sample(n)],
        };
        (0..800).step_by(4).map(at).collect()
    }

    #[test]
    fn a_step_is_known_to_the_pulse() {
        let names = ["mast".to_owned(), "aircraft".to_owned()];
        let step = Entry {
            pulse: 42,
            time_ns: 0,
            platform: "aircraft".to_owned(),
            text: "step position.up 5 m".to_owned(),
            origin: Origin::Control,
        };
        let other = Entry { platform: "mast".to_owned(), pulse: 43, ..step.clone() };
        let log = [step, other];
        let found = misreports(&points(|n| if n >= 42 { 5.2 } else { 0.2 }), &names, &log);
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!(
            (one.platform.as_str(), one.quantity, one.since_pulse),
            ("aircraft", "position", Some(42))
        );
        assert_eq!((one.direction, one.cause.as_deref()), (Some("too high"), Some("step position.up 5 m")));
        assert!((one.error - 5.2).abs() < 0.01 && (one.since_s.unwrap() - 0.42).abs() < 1e-9);
        // Without a log, the first point that has it.
        assert_eq!(
            misreports(&points(|n| if n >= 42 { -5.2 } else { 0.2 }), &names, &[])[0].since_pulse,
            Some(44)
        );
        // From the beginning, and not at all.
        assert_eq!(misreports(&points(|_| 3.0), &names, &log)[0].since_pulse, None);
        assert!(misreports(&points(|n| if n < 600 { 9.0 } else { 0.3 }), &names, &log).is_empty());
        assert!(misreports(&points(|_| f64::NAN), &names, &log).is_empty());
    }

    /// An error that swings through zero has one begin, not one in every period.
    #[test]
    fn an_error_that_swings_began_once() {
        let swing = |n: u64| if n < 100 { 0.0 } else { 4.0 * (n as f64 * 0.05).sin() };
        let names = ["mast".to_owned(), "aircraft".to_owned()];
        let found = misreports(&points(swing), &names, &[]);
        let [one] = &found[..] else { panic!("{found:?}") };
        assert!((3.9..4.1).contains(&one.error), "{one:?}");
        assert!((100..150).contains(&one.since_pulse.unwrap()), "{one:?}");
    }

    /// A ramp has acted since its change, however large it has become.
    #[test]
    fn a_ramp_began_with_its_change() {
        let names = ["mast".to_owned(), "aircraft".to_owned()];
        let at = |pulse, text: &str| Entry {
            pulse,
            time_ns: 0,
            platform: "aircraft".to_owned(),
            text: text.to_owned(),
            origin: Origin::Scenario,
        };
        let grown = |n: u64| n.saturating_sub(101) as f64 * 0.1;
        let ramp = at(101, "ramp position.up 10 m/s");
        let log = [ramp.clone(), at(300, "step position.up 0.1 m"), at(302, "step attitude.roll 1 deg")];
        let found = misreports(&points(grown), &names, &log);
        assert_eq!((found[0].since_pulse, found[0].cause.as_deref()), (Some(101), Some(ramp.text.as_str())));
        assert!((found[0].since_s.unwrap() - 1.01).abs() < 1e-9, "{found:?}");
        // A change of something else does not make it, even where the half is passed.
        let half =
            points(grown).iter().find(|point| point.platforms[1].position_m[2] >= 34.75).unwrap().pulse;
        let found = misreports(&points(grown), &names, &[ramp.clone(), at(half, "step attitude.roll 1 deg")]);
        assert_eq!(found[0].since_pulse, Some(101));
        // What has been cleared is over.
        let found = misreports(&points(grown), &names, &[ramp, at(150, "clear")]);
        assert_eq!((found[0].cause.as_deref(), found[0].since_pulse), (None, Some(half)));
    }
}
