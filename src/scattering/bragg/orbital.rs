//! Orbital velocities of the waves that are too short for the height map and longer than a Bragg wave: they
//! carry the Bragg waves of a facet to and fro, and so widen their lines.
//!
//! In a wave of frequency `omega` along `K` the water moves up and down, and `coth(K d)` times as far along
//! `K`, a quarter of a period apart. Velocities along a direction `q` thus have the variance
//!
//! `sigma_v^2 = integral of omega^2 [(q.K/|K|)^2 coth^2(K d) + q_z^2] Psi(K)`
//!
//! over the waves outside of the map's square `|K_x|, |K_y| < pi/dx` and shorter than `|K| < K_B`. The
//! integral over directions is kept as a symmetric tensor, over wave number as a running sum.

use glam::DVec3;

use super::group::{GROUP, Looks};
use super::{octaves, octaves_f32, of_octaves};
use crate::scene::water::Dispersion;
use crate::sea::spectrum::{Spectrum, WaveVector};

/// Steps in an octave.
const STEPS_PER_OCTAVE: f64 = 40.0;
/// Most steps, whatever range is asked.
const MOST_STEPS: usize = 4096;
/// Directions over half a turn.
const AZIMUTHS: usize = 64;

/// Variances of velocities: xx, xy, yy, zz, (m/s)^2.
type Tensor = [f64; 4];

/// Running integrals over wave number.
#[derive(Clone, Debug, PartialEq)]
pub struct SubFacetVelocities {
    octaves_from: f64,
    steps_per_octave: f64,
    sums: Vec<Tensor>,
    /// The same in single precision.
    sums_f32: Vec<[f32; 4]>,
}

impl SubFacetVelocities {
    /// Of the waves beyond a map that resolves `|K_x|, |K_y| < resolved_radpm`, up to `to_radpm`.
    pub fn new(spectrum: &dyn Spectrum, dispersion: Dispersion, resolved_radpm: f64, to_radpm: f64) -> Self {
        let octaves_from = octaves(resolved_radpm.max(f64::MIN_POSITIVE));
        let span = octaves(to_radpm) - octaves_from;
        if !(span > 0.0 && span.is_finite()) {
            return Self {
                octaves_from,
                steps_per_octave: 0.0,
                sums: vec![[0.0; 4]],
                sums_f32: vec![[0.0; 4]],
            };
        }
        let steps = ((span * STEPS_PER_OCTAVE).ceil() as usize).clamp(1, MOST_STEPS);
        let steps_per_octave = steps as f64 / span;
        let of = |step: usize| {
            let k = of_octaves(octaves_from + step as f64 / steps_per_octave);
            (k.ln(), ring(spectrum, dispersion, resolved_radpm, k))
        };
        let mut before = of(0);
        let mut sums = vec![[0.0; 4]];
        let mut sum = [0.0; 4];
        for step in 1..=steps {
            let next = of(step);
            let half = 0.5 * (next.0 - before.0);
            sum = std::array::from_fn(|i| sum[i] + half * (before.1[i] + next.1[i]));
            sums.push(sum);
            before = next;
        }
        let sums_f32 = sums.iter().map(|sum| sum.map(|part| part as f32)).collect();
        Self { octaves_from, steps_per_octave, sums, sums_f32 }
    }

    /// Sums up to a wave number.
    #[inline(always)]
    fn tensor(&self, to_radpm: f64) -> Tensor {
        let last = self.sums.len() - 1;
        let place = (octaves(to_radpm) - self.octaves_from) * self.steps_per_octave;
        let place = if place > 0.0 { place.min(last as f64) } else { 0.0 };
        let step = (place as usize).min(last.saturating_sub(1));
        let share = place - step as f64;
        let [low, high] = [self.sums[step], self.sums[(step + 1).min(last)]];
        std::array::from_fn(|i| low[i] + share * (high[i] - low[i]))
    }

    /// Mean square of `q.v` over the waves up to a wave number: of q in rad/m, (rad/s)^2; of a unit vector,
    /// (m/s)^2.
    #[inline]
    pub fn mean_square(&self, q: DVec3, to_radpm: f64) -> f64 {
        let [xx, xy, yy, zz] = self.tensor(to_radpm);
        (q.x * q.x * xx + 2.0 * q.x * q.y * xy + q.y * q.y * yy + q.z * q.z * zz).max(0.0)
    }

    /// The same of a group of facets.
    #[inline(always)]
    pub(super) fn mean_squares(&self, [x, y, z]: &Looks, to_radpm: &[f32; GROUP], out: &mut [f32; GROUP]) {
        let last = self.sums_f32.len() - 1;
        let (octaves_from, steps_per_octave) = (self.octaves_from as f32, self.steps_per_octave as f32);
        let mut places = [0.0; GROUP];
        for i in 0..GROUP {
            let place = (octaves_f32(to_radpm[i]) - octaves_from) * steps_per_octave;
            places[i] = if place > 0.0 { place.min(last as f32) } else { 0.0 };
        }
        let [mut xx, mut xy, mut yy, mut zz] = [[0.0; GROUP]; 4];
        for i in 0..GROUP {
            let step = (places[i] as usize).min(last.saturating_sub(1));
            let share = places[i] - step as f32;
            let (low, high) = (&self.sums_f32[step], &self.sums_f32[(step + 1).min(last)]);
            xx[i] = low[0] + share * (high[0] - low[0]);
            xy[i] = low[1] + share * (high[1] - low[1]);
            yy[i] = low[2] + share * (high[2] - low[2]);
            zz[i] = low[3] + share * (high[3] - low[3]);
        }
        for i in 0..GROUP {
            let sum =
                x[i] * x[i] * xx[i] + 2.0 * x[i] * y[i] * xy[i] + y[i] * y[i] * yy[i] + z[i] * z[i] * zz[i];
            out[i] = sum.max(0.0);
        }
    }

    /// Largest rms velocity along East, North or up, of all waves, m/s.
    pub fn largest_rms_mps(&self) -> f64 {
        let [xx, _, yy, zz] = self.sums[self.sums.len() - 1];
        xx.max(yy).max(zz).sqrt()
    }
}

/// Variances per unit of `ln K` of the waves on a circle.
fn ring(spectrum: &dyn Spectrum, dispersion: Dispersion, resolved_radpm: f64, k: f64) -> Tensor {
    let omega = dispersion.angular_frequency_rad_s(k);
    let along = dispersion.excursion_ratio(k).powi(2);
    // dKx dKy = K^2 dlnK dphi, both halves of the circle.
    let weight = 2.0 * omega * omega * k * k * std::f64::consts::PI / AZIMUTHS as f64;
    let mut sum = [0.0; 4];
    for step in 0..AZIMUTHS {
        let (sin, cos) = (std::f64::consts::PI * (step as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
        if k * cos.abs().max(sin.abs()) < resolved_radpm {
            continue;
        }
        let density = weight * spectrum.symmetric_m4(WaveVector::new(k * cos, k * sin)).max(0.0);
        for (sum, part) in sum.iter_mut().zip([along * cos * cos, along * cos * sin, along * sin * sin, 1.0])
        {
            *sum += part * density;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Psi = B K^-4` from everywhere: `S = 2 pi B K^-3`, and with `omega^2 = g K` the vertical variance is
    /// `2 pi g B (1/K_1 - 1/K_2)`, along any level direction half of it.
    #[derive(Debug)]
    struct Saturated;
    const B: f64 = 1e-3;

    impl Spectrum for Saturated {
        fn omnidirectional_m3(&self, k: f64) -> f64 {
            std::f64::consts::TAU * B / k.powi(3)
        }
        fn spreading_per_rad(&self, _: WaveVector) -> f64 {
            0.5 / std::f64::consts::PI
        }
        fn peak_rad_m(&self) -> f64 {
            0.1
        }
    }

    #[test]
    fn a_saturated_sea_has_the_closed_form() {
        let (from, to) = (3.0, 50.0);
        let waves = SubFacetVelocities::new(&Saturated, Dispersion::default(), from, to);
        // Outside of a square the lower bound is from/max(|cos|, |sin|): its inverse means 2 sqrt 2/pi of
        // 1/from.
        let mean = 2.0 * std::f64::consts::SQRT_2 / std::f64::consts::PI;
        let expected = std::f64::consts::TAU * crate::sea::GRAVITY_MPS2 * B * (mean / from - 1.0 / to);
        let up = waves.mean_square(DVec3::Z, to);
        assert!((up / expected - 1.0).abs() < 5e-3, "{up} {expected}");
        for turn in 0..8 {
            let (sin, cos) = f64::from(turn).sin_cos();
            let level = waves.mean_square(DVec3::new(cos, sin, 0.0), to);
            assert!((level / up - 0.5).abs() < 1e-3, "{level} {up}");
        }
        // Nothing below the map's waves, all beyond the last, and twice the vector is four times the square.
        assert_eq!(waves.mean_square(DVec3::Z, 2.9), 0.0);
        assert_eq!(waves.mean_square(DVec3::Z, 1e9), up);
        assert!((waves.mean_square(2.0 * DVec3::Z, to) / up - 4.0).abs() < 1e-12);
        let none = SubFacetVelocities::new(&Saturated, Dispersion::default(), 60.0, 50.0);
        assert_eq!((none.mean_square(DVec3::ONE, 55.0), none.largest_rms_mps()), (0.0, 0.0));
    }

    /// Two maps of the same sea: what the finer one resolves more is what the coarser one has within facets.
    #[test]
    fn waves_are_within_facets_or_on_the_map() {
        let of = |resolved| SubFacetVelocities::new(&Saturated, Dispersion::default(), resolved, 40.0);
        let between = of(2.0).mean_square(DVec3::Z, 40.0) - of(8.0).mean_square(DVec3::Z, 40.0);
        let mean = 2.0 * std::f64::consts::SQRT_2 / std::f64::consts::PI;
        let expected = std::f64::consts::TAU * crate::sea::GRAVITY_MPS2 * B * mean * (0.5 - 0.125);
        assert!((between / expected - 1.0).abs() < 5e-3, "{between} {expected}");
    }
}
