//! Readings of an encoder -> turns and sweeps.
//!
//! A **turn** ends where the antenna has come round once since the first pulse. A **sweep** ends where it
//! turns back: at the farthest reading before it comes back by a quarter of the sector. A sweep of less than
//! that at the ends of a recording is not counted. A beam that jumps **comes back** to its first
//! direction.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// How an antenna scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// It turns without end.
    Rotation {
        /// Rate, rad/s, clockwise from above.
        rate_rad_per_s: f64,
    },
    /// It goes to and fro.
    Sector {
        /// From end to end, rad.
        width_rad: f64,
    },
    /// It jumps from direction to direction.
    Steps,
}

/// A turn, a sweep of a sector, or a row of directions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scan {
    /// Places of its pulses.
    pub pulses: Range<usize>,
    /// Whether it goes all the way.
    pub is_whole: bool,
    /// Whether its azimuth grows.
    pub is_clockwise: bool,
}

/// An angle between -pi and pi, rad.
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    let angle_rad = angle_rad.rem_euclid(TAU);
    if angle_rad > PI { angle_rad - TAU } else { angle_rad }
}

/// Turns or sweeps in readings of the azimuth, rad, at ascending times, s. Whole ones come within
/// `tolerance_rad` of their length.
pub fn scans(motion: Motion, readings_rad: &[f64], times_s: &[f64], tolerance_rad: f64) -> Vec<Scan> {
    let count = readings_rad.len().min(times_s.len());
    let (readings_rad, times_s) = (&readings_rad[..count], &times_s[..count]);
    match motion {
        _ if count == 0 => Vec::new(),
        Motion::Rotation { rate_rad_per_s } => turns(rate_rad_per_s, readings_rad, times_s, tolerance_rad),
        Motion::Sector { width_rad } => sweeps(width_rad, readings_rad, tolerance_rad),
        Motion::Steps => rows(readings_rad),
    }
}

/// Half the way from the first direction of a beam that jumps to the nearest other one, rad. Readings in one
/// direction differ by their noise: what they mostly differ by from pulse to pulse, if that is little.
fn near_rad(readings_rad: &[f64]) -> f64 {
    let apart = |a: f64, b: f64| wrapped(a - b).abs();
    let mut steps: Vec<f64> = readings_rad.windows(2).map(|pair| apart(pair[1], pair[0])).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let [usual, most] = [steps.get(steps.len() / 2), steps.last()].map(|step| step.copied().unwrap_or(0.0));
    let noise_rad = if 10.0 * usual < most { 5.0 * usual } else { 0.0 };
    let others = readings_rad.iter().map(|reading| apart(*reading, readings_rad[0]));
    0.5 * others.filter(|off| *off > noise_rad + 1e-9).reduce(f64::min).unwrap_or(PI)
}

fn rows(readings_rad: &[f64]) -> Vec<Scan> {
    let near_rad = near_rad(readings_rad);
    let (mut begins, mut was_away) = (vec![0], false);
    for (place, reading) in readings_rad.iter().enumerate() {
        let is_away = wrapped(reading - readings_rad[0]).abs() > near_rad;
        if was_away && !is_away {
            begins.push(place);
        }
        was_away = is_away;
    }
    let whole = begins.windows(2).map(|pair| pair[1] - pair[0]).max();
    begins.push(readings_rad.len());
    let row = |pair: &[usize]| {
        let span_rad = wrapped(readings_rad[pair[1] - 1] - readings_rad[pair[0]]);
        let is_whole = whole.is_none_or(|pulses| pair[1] - pair[0] >= pulses);
        Scan { pulses: pair[0]..pair[1], is_whole, is_clockwise: span_rad >= 0.0 }
    };
    begins.windows(2).map(row).collect()
}

fn turns(rate_rad_per_s: f64, readings_rad: &[f64], times_s: &[f64], tolerance_rad: f64) -> Vec<Scan> {
    let is_clockwise = rate_rad_per_s >= 0.0;
    let sign = if is_clockwise { 1.0 } else { -1.0 };
    // Turned so far, about what the rate predicts: right while it errs by less than half a turn.
    let mut passed_rad = 0.0;
    let (mut found, mut begin, mut turn) = (Vec::new(), 0, 0.0);
    for place in 1..readings_rad.len() {
        let predicted = rate_rad_per_s * (times_s[place] - times_s[place - 1]);
        let step = predicted + wrapped(readings_rad[place] - readings_rad[place - 1] - predicted);
        passed_rad += sign * step;
        let now = ((passed_rad + 1e-9) / TAU).floor();
        if now > turn {
            found.push(Scan { pulses: begin..place, is_whole: true, is_clockwise });
            (begin, turn) = (place, now);
        }
    }
    // The last pulse stands for the step after it, too.
    let step_rad = passed_rad / (readings_rad.len() - 1).max(1) as f64;
    let is_whole = passed_rad + step_rad + tolerance_rad >= TAU * (turn + 1.0);
    found.push(Scan { pulses: begin..readings_rad.len(), is_whole, is_clockwise });
    found
}

fn sweeps(width_rad: f64, readings_rad: &[f64], tolerance_rad: f64) -> Vec<Scan> {
    // Of a wide sector the way over the ends may be shorter: readings follow each other.
    let mut before = readings_rad[0];
    let places: Vec<f64> = readings_rad
        .iter()
        .map(|reading| {
            before += wrapped(reading - before);
            before
        })
        .collect();
    let least = 0.25 * width_rad;
    let (mut low, mut high, mut clockwise) = (0, 0, None);
    let mut turned = vec![0];
    for (place, at) in places.iter().enumerate() {
        if clockwise != Some(false) && *at > places[high] {
            high = place;
        }
        if clockwise != Some(true) && *at < places[low] {
            low = place;
        }
        if clockwise != Some(false) && places[high] - at > least {
            turned.push(high);
            (clockwise, low) = (Some(false), place);
        } else if clockwise != Some(true) && at - places[low] > least {
            turned.push(low);
            (clockwise, high) = (Some(true), place);
        }
    }
    turned.push(match clockwise {
        Some(true) => high + 1,
        Some(false) => low + 1,
        None => places.len(),
    });
    let sweep = |pair: &[usize]| {
        let span_rad = places[pair[1] - 1] - places[pair[0]];
        // The last pulse stands for the step after it, too.
        let step_rad = span_rad.abs() / (pair[1] - pair[0] - 1).max(1) as f64;
        let is_whole = span_rad.abs() + step_rad + tolerance_rad >= width_rad;
        let found = Scan { pulses: pair[0]..pair[1], is_whole, is_clockwise: span_rad >= 0.0 };
        (span_rad.abs() >= least || clockwise.is_none()).then_some(found)
    };
    turned.windows(2).filter(|pair| pair[0] < pair[1]).filter_map(sweep).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::scan::direction;
    use crate::scene::radar::ScanLaw;

    /// Readings of a law, wrapped and in steps of so many bits.
    fn readings(law: &ScanLaw, count: usize, step_s: f64) -> (Vec<f64>, Vec<f64>) {
        let quantum = TAU / 4096.0;
        let times: Vec<f64> = (0..count).map(|i| i as f64 * step_s).collect();
        let read = |t: &f64| (direction(law, *t)[0] / quantum).round() * quantum;
        (times.iter().map(|t| read(t).rem_euclid(TAU)).collect(), times)
    }

    #[test]
    fn a_beam_that_jumps_comes_back_to_its_first_direction() {
        let degrees: [&[f64]; 5] = [
            &[-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0],
            &[350.0, 355.0, 0.0, 5.0, 10.0, 15.0, 20.0],
            &[0.0, 10.0, 20.0, 30.0, -30.0, -20.0, -10.0],
            &[0.0, 51.0, 102.0, 153.0, 204.0, 255.0, 306.0],
            &[5.0, -40.0, 12.0, 80.0, -3.0, 44.0, 29.0],
        ];
        for azimuths in degrees {
            for dwell_pulses in [1, 5] {
                let directions_rad = azimuths.iter().map(|az| [az.to_radians(), 0.0]).collect();
                let dwell_s = 0.01 * dwell_pulses as f64;
                let law = ScanLaw::Steps { directions_rad, dwell_pulses, dwell_s };
                let all = 7 * dwell_pulses as usize;
                let (readings, times) = readings(&law, 2 * all + all / 2, 0.01);
                let found = scans(Motion::Steps, &readings, &times, 0.0);
                let rows: Vec<_> = found.iter().map(|row| (row.pulses.clone(), row.is_whole)).collect();
                let part = (2 * all..2 * all + all / 2, false);
                assert_eq!(rows, [(0..all, true), (all..2 * all, true), part], "{azimuths:?}");
            }
        }
        // One direction is one row.
        assert_eq!(scans(Motion::Steps, &[0.1; 9], &[0.0; 9], 0.0).len(), 1);
    }

    #[test]
    fn turns_either_way_end_after_a_round() {
        for rate in [2.5, -2.5] {
            let law = ScanLaw::Rotation { rate_rad_per_s: rate, start_rad: 6.1, elevation_rad: 0.0 };
            let step_s = TAU / 2.5 / 500.0;
            let (read, times) = readings(&law, 1250, step_s);
            let found = scans(Motion::Rotation { rate_rad_per_s: rate }, &read, &times, 0.01);
            assert_eq!(found.len(), 3, "{found:?}");
            for (n, scan) in found.iter().enumerate() {
                assert_eq!((scan.is_whole, scan.is_clockwise), (n < 2, rate > 0.0));
                // Half a step of the encoder is a fifth of the way between pulses.
                assert!(scan.pulses.start.abs_diff(500 * n) <= 1, "{found:?}");
            }
            let whole = scans(Motion::Rotation { rate_rad_per_s: rate }, &read[..500], &times, 0.01);
            assert!(whole.len() == 1 && whole[0].is_whole, "{whole:?}");
        }
    }

    #[test]
    fn a_fast_turn_is_followed_by_its_rate() {
        // 200 degrees from pulse to pulse.
        let rate = 200f64.to_radians();
        let law = ScanLaw::Rotation { rate_rad_per_s: rate, start_rad: 0.0, elevation_rad: 0.0 };
        let (read, times) = readings(&law, 10, 1.0);
        assert_eq!(scans(Motion::Rotation { rate_rad_per_s: rate }, &read, &times, 0.01).len(), 6);
    }

    #[test]
    fn sweeps_go_to_and_fro() {
        for ends in [[-0.4, 0.9], [2.8, 3.6], [0.7, -0.7], [-PI, PI], [-4.0, 5.0]] {
            let law = ScanLaw::Sector {
                from_rad: ends[0],
                to_rad: ends[1],
                rate_rad_per_s: 1.0,
                turn_s: 0.1,
                elevations_rad: vec![0.0],
            };
            let width = (ends[1] - ends[0]).abs();
            let period_s = width + 0.1;
            let count = (3.5 * period_s / 1e-3) as usize;
            let (read, times) = readings(&law, count, 1e-3);
            let found = scans(Motion::Sector { width_rad: width }, &read, &times, 0.01);
            assert_eq!(found.len(), 4, "{ends:?} {found:?}");
            for (n, scan) in found.iter().enumerate() {
                let clockwise = (ends[1] > ends[0]) ^ (n % 2 == 1);
                assert_eq!((scan.is_whole, scan.is_clockwise), (n < 3, clockwise), "{ends:?} {n}");
                // It turns back in the middle of a turn.
                let begin_s = (n as f64 * period_s - 0.05).max(0.0);
                assert!((times[scan.pulses.start] - begin_s).abs() < 0.03, "{ends:?} {n} {scan:?}");
            }
        }
    }

    #[test]
    fn few_pulses_are_a_part_of_a_scan() {
        let sector = Motion::Sector { width_rad: 1.0 };
        let part = scans(sector, &[6.0, 6.01, 6.02], &[0.0, 0.1, 0.2], 0.01);
        assert_eq!(part, [Scan { pulses: 0..3, is_whole: false, is_clockwise: true }]);
        assert_eq!(scans(sector, &[], &[], 0.01), []);
    }
}
