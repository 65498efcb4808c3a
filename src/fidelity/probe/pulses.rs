//! Which pulses of a run are looked at.

use crate::scene::Radar;

/// Longest block, units of pulses.
pub const LONGEST: u64 = 64;
/// A unit is as many whole pulses as there are at this rate, and one at least, Hz.
const UNIT_HZ: f64 = 240.0;
/// The same for errors that are [`is_coarse`].
const COARSE_UNIT_HZ: f64 = 110.0;
/// Errors from here up are coarse, dB.
const COARSE_DB: f64 = -45.0;
/// Most pulses of a unit.
const MOST_UNIT: u64 = 16;

/// Pulses of a unit, by which what changes from pulse to pulse is looked at. What nodes leave is a matter of
/// their distance in time: at a high PRF every so many pulses show as much as all. Of a run of few pulses all
/// are looked at.
pub fn unit_of(radar: &Radar, pulses: u64, coarse: bool) -> u64 {
    let unit_hz = if coarse { COARSE_UNIT_HZ } else { UNIT_HZ };
    let of_prf = (radar.emissions.mean_prf_hz() / unit_hz).floor().max(1.0) as u64;
    of_prf.min(pulses.div_ceil(LONGEST)).clamp(1, MOST_UNIT)
}

/// Pulses from one at which points are looked at to the next, where a unit is so long: as for errors that are
/// not coarse, a part of it. Gains and aspects of points change faster than nodes ask for.
pub fn point_step(radar: &Radar, unit: u64) -> u64 {
    let finest = (radar.emissions.mean_prf_hz() / UNIT_HZ).floor().max(1.0) as u64;
    (1..=unit).rev().find(|step| unit.is_multiple_of(*step) && *step <= finest).unwrap_or(1)
}

/// Whether nodes may lie twice as far apart as for finer errors: then units are longer.
pub fn is_coarse(error_db: f64) -> bool {
    error_db >= COARSE_DB
}

/// The golden ratio less one: its multiples lie apart however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Numbers of `count` pulses about the middle of as many equal parts of a run, by turns at every place of a
/// cycle of so many pulses.
pub fn spread_over(pulses: u64, count: u64, cycle: u64) -> impl Iterator<Item = u64> {
    let middle = move |n: u64| u128::from(pulses) * u128::from(2 * n + 1) / u128::from(2 * count.max(1));
    let of_cycle = move |middle: u64, n: u64| middle - middle % cycle + n % cycle;
    (0..count).map(move |n| of_cycle(middle(n) as u64, n).min(pulses.saturating_sub(1)))
}

/// The same for beams that come round: no distance between two pulses is that of others, so that no period
/// of a beam meets one direction alone.
pub fn scattered_over(pulses: u64, count: u64, cycle: u64) -> impl Iterator<Item = u64> {
    let part = pulses as f64 / count.max(1) as f64;
    let within = move |n: u64| ((n as f64 + (n as f64 * GOLDEN).fract()) * part) as u64;
    let of_cycle = move |at: u64, n: u64| at - at % cycle + n % cycle;
    (0..count).map(move |n| of_cycle(within(n), n).min(pulses.saturating_sub(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pulses_are_spread_over_places_of_a_cycle() {
        assert_eq!(spread_over(100, 4, 1).collect::<Vec<_>>(), [12, 37, 62, 87]);
        // Every second pulse would all be of one polarisation.
        let found: Vec<u64> = spread_over(128, 64, 2).collect();
        assert_eq!(found.iter().filter(|pulse| *pulse % 2 == 0).count(), 32);
        assert_eq!(spread_over(3, 3, 4).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn no_period_of_a_beam_meets_one_direction_alone() {
        // Five directions of 50 pulses, and parts of 250.
        let mut met = [0; 5];
        scattered_over(72_000, 288, 1).for_each(|pulse| met[(pulse / 50 % 5) as usize] += 1);
        assert!(met.iter().all(|n| (50..65).contains(n)), "{met:?}");
        assert!(scattered_over(72_000, 288, 1).is_sorted());
        assert!(scattered_over(10, 10, 1).all(|pulse| pulse < 10));
    }
}
