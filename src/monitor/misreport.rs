//! Which platform misreports what, and since when.
//!
//! A quantity counts as misreported where its error is at least its [`Quantity::least`]. It has been so since the
//! error rose above half of what it is now and stayed there. Where a change of the log falls into the interval in
//! which that happened, it names the pulse exactly.

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

/// What is misreported at the last of these points.
pub fn misreports(points: &[Instant], platforms: &[String], log: &[Entry]) -> Vec<Misreport> {
    let Some(last) = points.last() else { return Vec::new() };
    let mut found = Vec::new();
    for (place, platform) in platforms.iter().enumerate() {
        let Some(now) = last.platforms.get(place) else { continue };
        for quantity in &QUANTITIES {
            let error = (quantity.error)(now);
            let total = size(error);
            // What is no number is nowhere reported or true.
            if total.is_nan() || total < quantity.least {
                continue;
            }
            let small = |point: &Instant| {
                point.platforms.get(place).is_none_or(|sample| size((quantity.error)(sample)) < 0.5 * total)
            };
            let before = points.iter().rposition(small);
            let first = before.and_then(|before| Some((points.get(before)?, points.get(before + 1)?)));
            let cause = first.and_then(|(before, first)| {
                let within = |entry: &&Entry| {
                    entry.platform == *platform && entry.pulse > before.pulse && entry.pulse <= first.pulse
                };
                log.iter().rfind(within).map(|entry| {
                    let share = (entry.pulse - before.pulse) as f64 / (first.pulse - before.pulse) as f64;
                    (entry, before.time_s + share * (first.time_s - before.time_s))
                })
            });
            let direction = (0..3)
                .find(|axis| error[*axis].abs() > 0.9 * total)
                .map(|axis| quantity.directions[axis][usize::from(error[axis] > 0.0)]);
            found.push(Misreport {
                platform: platform.clone(),
                quantity: quantity.name,
                error: total,
                unit: quantity.unit,
                direction,
                since_pulse: cause.map(|(entry, _)| entry.pulse).or(first.map(|(_, first)| first.pulse)),
                since_s: cause.map(|(_, time_s)| time_s).or(first.map(|(_, first)| first.time_s)),
                cause: cause.map(|(entry, _)| entry.text.clone()),
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
        (0..100).step_by(4).map(at).collect()
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
        assert!(misreports(&points(|n| if n < 50 { 9.0 } else { 0.3 }), &names, &log).is_empty());
        assert!(misreports(&points(|_| f64::NAN), &names, &log).is_empty());
    }
}
