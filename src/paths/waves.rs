//! The waves of a surface one by one, and what they do to something that floats, at time samples of the run.
//!
//! Sums over waves are found at instants `apart_s` apart, each once, by whoever comes first, and are quintic
//! Hermite in between.

use std::sync::OnceLock;

use num_complex::Complex64;

use crate::sea::surface::Surface;

/// Turn of the fastest wave from time sample to time sample, rad; and the longest time between time samples,
/// s.
pub(super) const TURN_RAD: f64 = 0.5;
pub(super) const LONGEST_S: f64 = 0.2;
/// Knots that are kept; later ones are summed whenever they are needed.
const MOST_KNOTS: f64 = 1_048_576.0;

/// A wave of a surface: wave vector, rad/m, its length, angular frequency, rad/s, and complex amplitude at
/// the origin and pulse 0, m, both halves of the plane together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    pub k: [f64; 2],
    pub length: f64,
    pub omega: f64,
    pub amplitude: Complex64,
}

impl Component {
    /// Frequency with which something that moves meets it, rad/s.
    pub fn met(&self, velocity_mps: [f64; 2]) -> f64 {
        met(self.omega, self.k, velocity_mps)
    }
}

/// Frequency with which something that moves meets a wave, rad/s.
pub(super) fn met(omega: f64, k: [f64; 2], velocity_mps: [f64; 2]) -> f64 {
    omega - k[0] * velocity_mps[0] - k[1] * velocity_mps[1]
}

/// The waves of a surface.
pub(super) fn components(surface: &Surface) -> impl Iterator<Item = Component> + '_ {
    let (grid, dispersion) = (surface.grid(), surface.dispersion());
    let step = grid.wave_number_step_rad_m();
    let rows = surface.amplitude_m().chunks_exact(grid.ny()).enumerate();
    rows.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, amplitude)| (i, j, *amplitude))).filter_map(
        move |(i, j, amplitude)| {
            let (mx, my) = (grid.wave_index_x(i)?, grid.wave_index_y(j)?);
            if amplitude == Complex64::ZERO {
                return None;
            }
            let k = [mx as f64 * step[0], my as f64 * step[1]];
            let length = k[0].hypot(k[1]);
            // The conjugate of the sum at -K stands for the other half: twice the real part.
            let (omega, amplitude) = (dispersion.angular_frequency_rad_s(length), 2.0 * amplitude);
            Some(Component { k, length, omega, amplitude })
        },
    )
}

/// Sums at time samples of a run.
#[derive(Debug)]
pub(super) struct Series<K> {
    apart_s: f64,
    knots: Vec<OnceLock<K>>,
}

impl<K: Copy> Series<K> {
    /// For waves that are met no faster, rad/s, in a run whose last emission is `last_s` after pulse 0.
    pub fn new(fastest_radps: f64, last_s: f64) -> Self {
        let apart_s = TURN_RAD / fastest_radps.max(TURN_RAD / LONGEST_S);
        // Between 2 and MOST_KNOTS: the cast is exact.
        let count = (last_s / apart_s + 3.0).clamp(2.0, MOST_KNOTS) as usize;
        Self { apart_s, knots: std::iter::repeat_with(OnceLock::new).take(count).collect() }
    }

    pub fn apart_s(&self) -> f64 {
        self.apart_s
    }

    /// How many are kept.
    pub fn len(&self) -> usize {
        self.knots.len()
    }

    /// The time sample before a time, and how far it is to the next: 0 to 1.
    pub fn before(&self, elapsed_s: f64) -> (usize, f64) {
        let at = (elapsed_s / self.apart_s).max(0.0);
        (at.floor() as usize, at.fract())
    }

    /// A time sample; `sum` finds it for its time after pulse 0, s.
    pub fn knot(&self, number: usize, sum: impl FnOnce(f64) -> K) -> K {
        let sum = || sum(number as f64 * self.apart_s);
        match self.knots.get(number) {
            Some(knot) => *knot.get_or_init(sum),
            None => sum(),
        }
    }
}

/// Value and rate a share `s` of the way from one time sample to another, `h` apart: `[value, rate,
/// acceleration]` at both.
pub(super) fn quintic(h: f64, s: f64, [z0, v0, a0]: [f64; 3], [z1, v1, a1]: [f64; 3]) -> [f64; 2] {
    let (c1, c2) = (h * v0, 0.5 * h * h * a0);
    let (d, e, f) = (z1 - z0 - c1 - c2, h * v1 - c1 - 2.0 * c2, h * h * a1 - 2.0 * c2);
    let (c3, c4, c5) = (10.0 * d - 4.0 * e + 0.5 * f, 7.0 * e - 15.0 * d - f, 6.0 * d - 3.0 * e + 0.5 * f);
    let z = z0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5))));
    let rate = c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)));
    [z, rate / h]
}
