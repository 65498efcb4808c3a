//! A sea without end: a few waves drawn from a spectrum, summed where they are asked for.
//!
//! The grid of a map makes its waves repeat with the patch. Here `M` wave vectors are drawn at random from
//! all of the plane that a map of such facets resolves, so that nothing repeats:
//!
//! `z(x, t) = sum_m a_m cos(theta_m)`, `theta_m = K_m.x - omega_m t + phi_m`, `a_m^2/2 = p_c/(M w_c)`
//!
//! | symbol | is | unit |
//! | --- | --- | --- |
//! | `p_c` | height variance of a cell of the plane, `Psi K^2 dlnK dphi` | m^2 |
//! | `w_c` | probability of the cell: its mean share of the variances of heights, slopes and velocities | 1 |
//! | `phi_m` | random phase | rad |
//!
//! Cells are drawn by one random number and equal steps along their sum (systematic sampling), in which a
//! train of swell gets as many waves as its share asks. Slopes are the gradient of `z`, velocities those of
//! the orbital motion, and the modulation that of [`surface::modulation`](super::surface::modulation).
//!
//! Limits: linear waves; sums of `M` waves are Gaussian but for their fourth moment, `3 - 1.5/M`; no ship's.

use std::f64::consts::{PI, TAU};

use rand::RngExt;

use super::spectrum::{Spectrum, WaveVector};
use super::surface::modulation::{Strength, transfer_per_m};
use crate::rng::{Room, stream};
use crate::scene::water::Dispersion;

/// Waves.
const WAVES: usize = 192;
/// Longest wave, m.
const LONGEST_M: f64 = 2000.0;
/// Cells from the longest to the shortest wave, and around.
const RADII: usize = 320;
const AZIMUTHS: usize = 180;

/// One of the waves.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    k: [f64; 2],
    omega_radps: f64,
    phase_rad: f64,
    amplitude_m: f64,
    /// Horizontal over vertical motion.
    excursion: f64,
    /// Tensor of the modulation over the height, real and imaginary part, 1/m.
    modulation: [[f64; 2]; 3],
}

/// What the sea is at a place and a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waters {
    /// Height, m.
    pub height_m: f64,
    /// Slopes along x and y.
    pub slope: [f64; 2],
    /// Velocity of the water, x, y, z, m/s.
    pub velocity_mps: [f64; 3],
    /// Modulation xx, yy, xy.
    pub strain: [f64; 3],
}

/// The waves, and what they are on average.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveSum {
    waves: Vec<Wave>,
    strength: Strength,
    /// Covariance of slopes, xx, xy, yy.
    slopes: [f64; 3],
}

impl WaveSum {
    /// Waves of a spectrum that a map of such facets resolves, modulating at a rate if they do.
    pub fn new(
        spectrum: &dyn Spectrum,
        dispersion: Dispersion,
        facet_m: f64,
        relaxation_per_s: Option<f64>,
        seed: u64,
    ) -> Self {
        let (from, to) = (TAU / LONGEST_M, PI / facet_m);
        let step = (std::f64::consts::SQRT_2 * to / from).ln().max(0.0) / RADII as f64;
        let turn = TAU / AZIMUTHS as f64;
        let at = |cell: f64, azimuth: f64| (from * (step * cell).exp(), turn * azimuth);
        let mut cells = Vec::with_capacity(RADII * AZIMUTHS);
        let mut sums = [0.0; 3];
        for radius in 0..RADII {
            for azimuth in 0..AZIMUTHS {
                let (k, rad) = at(radius as f64 + 0.5, azimuth as f64 + 0.5);
                let (sin, cos) = rad.sin_cos();
                let resolved = (k * cos).abs() < to && (k * sin).abs() < to;
                let psi_m4 = if resolved { spectrum.wave_m4(WaveVector::polar(k, rad)) } else { 0.0 };
                let power_m2 = psi_m4.max(0.0) * k * k * step * turn;
                let omega = dispersion.angular_frequency_rad_s(k);
                let of = [power_m2, power_m2 * k * k, power_m2 * omega * omega];
                sums.iter_mut().zip(of).for_each(|(sum, own)| *sum += own);
                cells.push((power_m2, of));
            }
        }
        let mut rng = stream(seed, Room::FarWave, 0, 0);
        let (mut drawn, mut waves) = (rng.random::<f64>(), Vec::with_capacity(WAVES));
        let mut sum = 0.0;
        for (number, (power_m2, of)) in cells.into_iter().enumerate() {
            let share = of.iter().zip(sums).map(|(own, all)| if all > 0.0 { own / all / 3.0 } else { 0.0 });
            let probability: f64 = share.sum();
            sum += WAVES as f64 * probability;
            while drawn < sum && waves.len() < WAVES {
                drawn += 1.0;
                let [along, around, phase] = [(); 3].map(|()| rng.random::<f64>());
                let (k, rad) = at((number / AZIMUTHS) as f64 + along, (number % AZIMUTHS) as f64 + around);
                let (sin, cos) = rad.sin_cos();
                let k_vector = [k * cos, k * sin];
                let (omega_radps, excursion) =
                    (dispersion.angular_frequency_rad_s(k), dispersion.excursion_ratio(k));
                let modulation = relaxation_per_s.map_or([[0.0; 2]; 3], |rate| {
                    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|look| {
                        let r = transfer_per_m(k_vector, excursion / k, omega_radps, rate, look);
                        [r.re, r.im]
                    })
                });
                waves.push(Wave {
                    k: k_vector,
                    omega_radps,
                    phase_rad: TAU * phase,
                    amplitude_m: (2.0 * power_m2 / (WAVES as f64 * probability)).sqrt(),
                    excursion,
                    modulation,
                });
            }
        }
        let mut built = Self { waves, strength: Strength::default(), slopes: [0.0; 3] };
        for wave in &built.waves {
            let power_m2 = 0.5 * wave.amplitude_m * wave.amplitude_m;
            let [x, y] = wave.k;
            built.slopes.iter_mut().zip([x * x, x * y, y * y]).for_each(|(sum, k2)| *sum += power_m2 * k2);
            for (a, row) in wave.modulation.iter().zip(&mut built.strength.covariance) {
                for (b, entry) in wave.modulation.iter().zip(row) {
                    *entry += power_m2 * (a[0] * b[0] + a[1] * b[1]);
                }
            }
        }
        built
    }

    /// Strength of the modulation.
    pub fn strength(&self) -> &Strength {
        &self.strength
    }

    /// Rms slope along a horizontal direction.
    pub fn slope_rms(&self, [x, y]: [f64; 2]) -> f64 {
        let [xx, xy, yy] = self.slopes;
        let length2 = x * x + y * y;
        if length2 > 0.0 {
            ((xx * x * x + 2.0 * xy * x * y + yy * y * y).max(0.0) / length2).sqrt()
        } else {
            (0.5 * (xx + yy)).sqrt()
        }
    }

    /// What the sea is at a place, m, and a time after pulse 0, s; with other phases, turns of each wave, of
    /// a sea that has no more in common with it than its spectrum.
    pub fn at(&self, [x, y]: [f64; 2], t_s: f64, mut phases: impl FnMut() -> f64) -> Waters {
        let mut waters = Waters::default();
        for wave in &self.waves {
            let [kx, ky] = wave.k;
            // Turns: far away, waves have thousands.
            let turns = (kx * x + ky * y - wave.omega_radps * t_s) / TAU;
            let theta = TAU * (turns - turns.floor() + phases()) + wave.phase_rad;
            let (sin, cos) = theta.sin_cos();
            let (along, across) = (wave.amplitude_m * cos, wave.amplitude_m * sin);
            let omega = wave.omega_radps;
            waters.height_m += along;
            waters.slope[0] -= kx * across;
            waters.slope[1] -= ky * across;
            let horizontal = wave.excursion * omega * along / kx.hypot(ky);
            waters.velocity_mps[0] += kx * horizontal;
            waters.velocity_mps[1] += ky * horizontal;
            waters.velocity_mps[2] += omega * across;
            for (sum, [re, im]) in waters.strain.iter_mut().zip(wave.modulation) {
                *sum += re * along - im * across;
            }
        }
        waters
    }
}
