//! When receivers take samples.

use super::antenna::{self, AimKeys, aim_keys};
use super::place::SurfaceKeys;
use super::{Ground, Names};
use crate::config::choices::GateKind;
use crate::config::error::Problem;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::scene::radar::{Gate, Window};
use crate::time::PulseTimes;
use crate::units::spanned_samples;

/// The window, and whether it is a block of those that follow each other.
pub(super) fn window(
    section: Section<'_>,
    sample_rate_hz: Option<f64>,
    pulse_s: Option<f64>,
    ground: &Ground,
    platforms: &Names,
) -> Option<(Window, bool)> {
    use keys::window::{FOLLOW, GATE, SAMPLES, START_US};
    let samples = section.count(&SAMPLES);
    let Some(kind) = section.choice::<GateKind>(&GATE) else {
        // Report faults of the other keys as well.
        opening(&section, [&START_US, &FOLLOW], ground, platforms);
        section.finish();
        return None;
    };
    if kind == GateKind::Continuous {
        section.idle(&[&START_US, &FOLLOW], "gate = \"continuous\"");
        let samples = samples.and_then(|samples| usize::try_from(samples).ok());
        let blocks = samples.zip(sample_rate_hz).filter(|(n, hz)| PulseTimes::blocks(*n, *hz).is_err());
        if let Some((samples, hz)) = blocks {
            let found = format!("a block of {} s", samples as f64 / hz);
            section.fault(&SAMPLES, Problem::Type { found, allowed: "1e-9 to 1000 s".to_owned() });
        }
        section.finish();
        return Some((Window { samples: samples?, gate: Gate::Fixed { start_s: 0.0 } }, true));
    }
    if let (Some(samples), Some(sample_rate_hz), Some(pulse_s)) = (samples, sample_rate_hz, pulse_s) {
        let window_s = samples as f64 / sample_rate_hz;
        // A pulse of a whole number of samples must pass although its product with the rate is rounded.
        let least = spanned_samples(pulse_s, sample_rate_hz) as u64;
        if samples < least {
            section.fault(&SAMPLES, Problem::ShortWindow { samples, window_s, pulse_s, least });
        }
    }
    let gate = gate(&section, [&START_US, &FOLLOW], ground, platforms);
    section.finish();
    Some((Window { samples: usize::try_from(samples?).ok()?, gate: gate? }, false))
}

/// Where a window starts, by one of the keys.
pub(super) fn gate(
    section: &Section<'_>,
    keys: [&'static Key; 2],
    ground: &Ground,
    platforms: &Names,
) -> Option<Gate> {
    let written = section.exactly_one(&keys);
    let opening = opening(section, keys, ground, platforms);
    written?;
    opening
}

/// The same, whichever of them are written.
fn opening(
    section: &Section<'_>,
    [start_us, follows]: [&'static Key; 2],
    ground: &Ground,
    platforms: &Names,
) -> Option<Gate> {
    let fixed = section.number(start_us).map(|us| Gate::Fixed { start_s: us / 1e6 });
    let follow = section.section(follows).and_then(|s| follow(s, ground, platforms));
    fixed.or(follow)
}

fn follow(section: Section<'_>, ground: &Ground, platforms: &Names) -> Option<Gate> {
    use keys::follow as k;
    let aim_keys = aim_keys!(follow);
    let aim =
        section.choice(&k::KIND).and_then(|kind| antenna::aim(&section, kind, &aim_keys, ground, platforms));
    let lead_us = section.number(&k::LEAD_US);
    let aim_from = section.choice(&k::AIM_FROM);
    section.finish();
    Some(Gate::Follow { aim: aim?, lead_s: lead_us? / 1e6, aim_from: aim_from? })
}
