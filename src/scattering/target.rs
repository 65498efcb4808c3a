//! Point targets at an instant.
//!
//! A target keeps a straight course, `x(t) = x_0 + v t` with `t` from the emission of pulse 0, or follows a
//! [trajectory](crate::scene::trajectory). It scatters the same in every direction: its matrix `S[p][q]` (p
//! received, q transmitted, order (v, h), sqrt(m^2)) holds in the forward-scatter bases of
//! [`crate::geometry::bistatic`]. While a pulse is on its way it moves straight on.
//!
//! ```
//! use nereus::frames::{Point, Vector};
//! use nereus::scattering::target::Scatterer;
//! use nereus::scene::Target;
//! let (position, velocity) = (Point::new(10.0, 0.0, 1.0), Vector::new(0.5, 0.0, 0.0));
//! let buoy = Target::new("buoy", position, velocity, Target::sphere(4.0));
//! assert_eq!(Scatterer::at(&buoy, 2.0).position, Point::new(11.0, 0.0, 1.0));
//! ```
//!
//! **Fluctuation** (Swerling's cases). The radar cross section is `sigma = sigma_0 X`, `sigma_0` that of the
//! matrix and `X` of mean 1:
//!
//! `P(X > x) = e^-x` (cases 1 and 2), `P(X > x) = (1 + 2x) e^-2x` (cases 3 and 4)
//!
//! chi-square of 2 and of 4 degrees of freedom. In cases 1 and 3 one `X` holds for a scan, in cases 2 and 4
//! for a pulse; it is drawn from the seed, the target's number and the number of the scan or pulse alone, and
//! multiplies all channels of the pulse's emission. The phase of the echo does not fluctuate.
//!
//! Source: Swerling, RAND RM-1217 (1954); IRE Trans. IT-6 (1960) 269.
//!
//! Limits: nothing between scan and pulse; a target whose phase centre wanders (glint) is several targets.

use num_complex::Complex64;
use rand::RngExt;

use crate::frames::{Enu, Point, Vector};
use crate::rng::{Room, stream};
use crate::scene::Target;
use crate::scene::target::Swerling;

/// Share of a scan within which a pulse belongs to the next: times are rounded.
const ROUNDING: f64 = 1e-9;
/// Chance that any draw of a run exceeds the bound of [`most_of_run`].
const EXCEEDED: f64 = 1e-6;

/// What scatters at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatterer<'a> {
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Scattering matrix `S[p][q]`, sqrt(m^2), order (v, h).
    pub matrix: &'a [[Complex64; 2]; 2],
}

impl<'a> Scatterer<'a> {
    /// A target `elapsed_s` seconds after the emission of pulse 0.
    pub fn at(target: &'a Target, elapsed_s: f64) -> Self {
        let (position, velocity) = target.at(elapsed_s);
        Self { position, velocity, matrix: &target.scattering }
    }
}

/// Which draw of a target holds at a pulse: the number of its scan, or of the pulse; `None` where nothing
/// fluctuates.
fn draw_number(swerling: Swerling, pulse: u64, elapsed_s: f64) -> Option<u64> {
    match (swerling, swerling.scan_s()) {
        (Swerling::Steady, _) => None,
        // No run has 2^53 scans: the cast is exact.
        (_, Some(scan_s)) => Some((elapsed_s / scan_s + ROUNDING).floor() as u64),
        (_, None) => Some(pulse),
    }
}

/// The draw of a number: chi-square over its mean.
fn drawn(swerling: Swerling, seed: u64, target: u64, number: u64) -> f64 {
    let mut numbers = stream(seed, Room::TargetFluctuation, number, target);
    let mut exponential = || -(1.0 - numbers.random::<f64>()).ln();
    match swerling {
        Swerling::Steady => 1.0,
        Swerling::Case1 { .. } | Swerling::Case2 => exponential(),
        Swerling::Case3 { .. } | Swerling::Case4 => 0.5 * (exponential() + exponential()),
    }
}

/// Radar cross section of a target at a pulse over its mean: `target` is its number in the scene, `elapsed_s`
/// the time from pulse 0 to this one.
///
/// ```
/// use nereus::scattering::target::fluctuation;
/// use nereus::scene::target::Swerling;
/// let scan = Swerling::Case1 { scan_s: 2.0 };
/// assert_eq!(fluctuation(scan, 7, 0, 100, 0.5), fluctuation(scan, 7, 0, 399, 1.995));
/// assert_ne!(fluctuation(scan, 7, 0, 100, 0.5), fluctuation(scan, 7, 0, 400, 2.0));
/// assert_eq!(fluctuation(Swerling::Steady, 7, 0, 100, 0.5), 1.0);
/// ```
pub fn fluctuation(swerling: Swerling, seed: u64, target: u64, pulse: u64, elapsed_s: f64) -> f64 {
    draw_number(swerling, pulse, elapsed_s).map_or(1.0, |number| drawn(swerling, seed, target, number))
}

/// The most that a target returns at any pulse of a run over its mean: the largest of up to `draws` draws, or
/// what more of them stay below but for one run in a million. `length_s` is the time from the first pulse to
/// the last.
pub fn most_of_run(
    swerling: Swerling,
    seed: u64,
    target: u64,
    pulses: u64,
    length_s: f64,
    draws: u64,
) -> f64 {
    let Some(last) = draw_number(swerling, pulses.saturating_sub(1), length_s) else { return 1.0 };
    if last < draws {
        return (0..=last).map(|number| drawn(swerling, seed, target, number)).fold(0.0, f64::max);
    }
    let level = ((last as f64 + 1.0) / EXCEEDED).ln();
    if swerling.case() < 3 {
        return level;
    }
    // (1 + y) e^-y = e^-level of y = 2x, by iteration: every step leaves a twentieth or less.
    0.5 * (0..20).fold(level, |y, _| level + f64::ln_1p(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_of_a_long_run_is_exceeded_once_in_a_million_runs() {
        let pulses = 1u64 << 40;
        let of_run = |chance: f64| assert!((chance * pulses as f64 / 1e-6 - 1.0).abs() < 1e-6, "{chance}");
        let two = most_of_run(Swerling::Case2, 1, 0, pulses, 1e6, 1 << 18);
        of_run((-two).exp());
        let four = most_of_run(Swerling::Case4, 1, 0, pulses, 1e6, 1 << 18);
        of_run((1.0 + 2.0 * four) * (-2.0 * four).exp());
    }

    #[test]
    fn the_most_of_a_short_run_is_its_largest_draw() {
        for swerling in [Swerling::Case1 { scan_s: 0.1 }, Swerling::Case4] {
            let of = |n: u64| fluctuation(swerling, 3, 5, n, n as f64 / 100.0);
            let largest = (0..400).map(of).fold(0.0, f64::max);
            assert_eq!(most_of_run(swerling, 3, 5, 400, 3.99, 1000), largest);
        }
    }
}
