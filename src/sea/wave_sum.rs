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
use crate::cpu::{Task, Variant};
use crate::rng::{Room, stream};
use crate::scene::water::Dispersion;

/// Waves.
const WAVES: usize = 192;
/// Sums of them at a place: of cosines or of sines, and lanes in which they are summed.
const SUMS: usize = 9;
const PARTS: usize = 6;
const LANES: usize = 8;
/// Adding it rounds a number below `2^22` to the nearest integer.
const TO_INTEGER: f32 = 12_582_912.0;
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
    rows: Rows,
    strength: Strength,
    /// Covariance of slopes, xx, xy, yy.
    slopes: [f64; 3],
    height_variance_m2: f64,
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
        let rows = Rows::new(&waves);
        let mut built =
            Self { waves, rows, strength: Strength::default(), slopes: [0.0; 3], height_variance_m2: 0.0 };
        for wave in &built.waves {
            let power_m2 = 0.5 * wave.amplitude_m * wave.amplitude_m;
            let [x, y] = wave.k;
            built.height_variance_m2 += power_m2;
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

    /// Rms height, m.
    pub fn height_rms_m(&self) -> f64 {
        self.height_variance_m2.sqrt()
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

    /// What the sea is at a place, m, and a time after pulse 0, s.
    pub fn at(&self, place_m: [f64; 2], t_s: f64) -> Waters {
        self.beside(&self.about(place_m, t_s), place_m)
    }

    /// The waves about a place, m, at a time after pulse 0, s.
    pub fn about(&self, middle_m: [f64; 2], t_s: f64) -> Nearby {
        let mut turns = [0.0; WAVES];
        for (turns, wave) in turns.iter_mut().zip(&self.waves) {
            let phase_rad = wave.k[0] * middle_m[0] + wave.k[1] * middle_m[1] - wave.omega_radps * t_s;
            // Far away, waves have thousands of turns.
            let all = (phase_rad + wave.phase_rad) / TAU;
            *turns = (all - all.round()) as f32;
        }
        Nearby { middle_m, turns }
    }

    /// What the sea is at a place, m, near another: rounded by 1e-7 of the waves between both.
    pub fn beside(&self, nearby: &Nearby, place_m: [f64; 2]) -> Waters {
        let away_m = [0, 1].map(|i| (place_m[i] - nearby.middle_m[i]) as f32);
        let sums = Variant::fastest().run(Sums { of: &self.rows, turns: &nearby.turns, away_m });
        let [height, u, v, sx, sy, w, xx, yy, xy] = sums.map(f64::from);
        Waters { height_m: height, slope: [sx, sy], velocity_mps: [u, v, w], strain: [xx, yy, xy] }
    }
}

/// Phases of the waves at a place and a time.
#[derive(Clone, Copy, Debug)]
pub struct Nearby {
    middle_m: [f64; 2],
    /// From -1/2 to 1/2.
    turns: [f32; WAVES],
}

impl Nearby {
    /// The same of a sea that has no more in common with it than its spectrum: with other phases, turns.
    pub fn with_phases(&self, mut phases: impl FnMut() -> f32) -> Self {
        Self { turns: self.turns.map(|_| phases() - 0.5), ..*self }
    }
}

/// The waves as rows: turns a metre along x and y, and what cosine and sine of a phase add to sums.
#[derive(Clone, Debug, PartialEq)]
struct Rows {
    turns_per_m: [[f32; WAVES]; 2],
    /// Of height, horizontal velocities and modulation.
    cosines: [[f32; WAVES]; PARTS],
    /// Of slopes, vertical velocity and modulation.
    sines: [[f32; WAVES]; PARTS],
}

impl Rows {
    fn new(waves: &[Wave]) -> Self {
        let empty = [[0.0; WAVES]; PARTS];
        let mut rows = Self { turns_per_m: [[0.0; WAVES]; 2], cosines: empty, sines: empty };
        for (n, wave) in waves.iter().enumerate().take(WAVES) {
            let ([kx, ky], a, omega) = (wave.k, wave.amplitude_m, wave.omega_radps);
            rows.turns_per_m.iter_mut().zip([kx, ky]).for_each(|(row, k)| row[n] = (k / TAU) as f32);
            let level = a * wave.excursion * omega / kx.hypot(ky);
            let [xx, yy, xy] = wave.modulation;
            let cosines = [a, kx * level, ky * level, a * xx[0], a * yy[0], a * xy[0]];
            let sines = [-kx * a, -ky * a, omega * a, -a * xx[1], -a * yy[1], -a * xy[1]];
            rows.cosines.iter_mut().zip(cosines).for_each(|(row, own)| row[n] = own as f32);
            rows.sines.iter_mut().zip(sines).for_each(|(row, own)| row[n] = own as f32);
        }
        rows
    }
}

/// Height, horizontal velocities, slopes, vertical velocity, modulation at a place: without fused products,
/// so that all instruction sets agree.
struct Sums<'a> {
    of: &'a Rows,
    turns: &'a [f32; WAVES],
    away_m: [f32; 2],
}

impl Task for Sums<'_> {
    type Output = [f32; SUMS];

    // Lanes are counted: so they become vectors.
    #[inline(always)]
    #[allow(clippy::needless_range_loop)]
    fn run(self) -> [f32; SUMS] {
        let Self { of: Rows { turns_per_m: [along_x, along_y], cosines, sines }, turns, away_m: [x, y] } =
            self;
        // Of cosines, of sines, of both.
        let mut sums = [[[0.0f32; LANES]; 3]; 3];
        for group in 0..WAVES / LANES {
            let (mut cosine, mut sine) = ([0.0f32; LANES], [0.0f32; LANES]);
            for lane in 0..LANES {
                let n = group * LANES + lane;
                let own = turns[n] + along_x[n] * x + along_y[n] * y;
                let rest = own - ((own + TO_INTEGER) - TO_INTEGER);
                (sine[lane], cosine[lane]) = sin_cos_of_turns(rest);
            }
            for s in 0..3 {
                for lane in 0..LANES {
                    let n = group * LANES + lane;
                    sums[0][s][lane] += cosines[s][n] * cosine[lane];
                    sums[1][s][lane] += sines[s][n] * sine[lane];
                    sums[2][s][lane] += cosines[3 + s][n] * cosine[lane] + sines[3 + s][n] * sine[lane];
                }
            }
        }
        let mut out = [0.0; SUMS];
        for (sum, lanes) in out.iter_mut().zip(sums.as_flattened()) {
            for lane in 0..LANES {
                *sum += lanes[lane];
            }
        }
        out
    }
}

/// Sine and cosine of -1/2 to 1/2 turns, within 4e-6: those of a quarter of the angle by Taylor's series,
/// doubled twice.
#[inline(always)]
pub(crate) fn sin_cos_of_turns(turns: f32) -> (f32, f32) {
    let y = 0.25 * std::f32::consts::TAU * turns;
    let z = y * y;
    let sin = y * (1.0 - z * (1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * (1.0 / 362_880.0)))));
    let cos = 1.0
        - z * (0.5 - z * (1.0 / 24.0 - z * (1.0 / 720.0 - z * (1.0 / 40320.0 - z * (1.0 / 3_628_800.0)))));
    let (sin, cos) = (2.0 * sin * cos, cos * cos - sin * sin);
    (2.0 * sin * cos, cos * cos - sin * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::water::{Development, WindProfile};
    use crate::sea::spectrum::Elfouhaily;
    use crate::sea::wind::Wind;

    #[test]
    fn series_of_sine_and_cosine() {
        for n in -500..=500 {
            let turns = n as f32 / 1000.0;
            let (sin, cos) = sin_cos_of_turns(turns);
            let exact = (std::f64::consts::TAU * f64::from(turns)).sin_cos();
            assert!((f64::from(sin) - exact.0).abs() < 4e-6 && (f64::from(cos) - exact.1).abs() < 4e-6);
        }
    }

    /// Variances over places and times are those of the spectrum: of height, slopes and vertical velocity.
    #[test]
    fn variances_are_those_of_the_spectrum() {
        let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.4).unwrap();
        let spectrum = Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap();
        let (dispersion, facet_m) = (Dispersion::default(), 2.0);
        let mut expected = [0.0; 4];
        let (from, to) = (TAU / LONGEST_M, PI / facet_m);
        let step = (std::f64::consts::SQRT_2 * to / from).ln() / 2000.0;
        for n in 0..2000 {
            let k = from * (step * (f64::from(n) + 0.5)).exp();
            for azimuth in 0..120 {
                let (sin, cos) = (TAU * (f64::from(azimuth) + 0.5) / 120.0).sin_cos();
                if (k * cos).abs().max((k * sin).abs()) < to {
                    let power =
                        spectrum.wave_m4(WaveVector::new(k * cos, k * sin)) * k * k * step * TAU / 120.0;
                    let omega = dispersion.angular_frequency_rad_s(k);
                    let of = [1.0, k * k * cos * cos, k * k * sin * sin, omega * omega];
                    expected.iter_mut().zip(of).for_each(|(sum, own)| *sum += power * own);
                }
            }
        }
        let mut found = [0.0; 4];
        let (seeds, places) = (8, 400);
        for seed in 0..seeds {
            let waves = WaveSum::new(&spectrum, dispersion, facet_m, Some(1.0), seed);
            for n in 0..places {
                let place_m = [f64::from(n) * 173.0, f64::from(n % 7) * 311.0];
                let Waters { height_m, slope, velocity_mps, .. } = waves.at(place_m, f64::from(n));
                let of = [height_m, slope[0], slope[1], velocity_mps[2]];
                let share = 1.0 / (seeds as f64 * f64::from(places));
                found.iter_mut().zip(of).for_each(|(sum, own)| *sum += share * own * own);
            }
        }
        println!("found {found:?}, expected {expected:?}");
        // 3200 places, many of them independent: 4 in a hundred; three of them.
        assert!(found.iter().zip(expected).all(|(found, expected)| (found / expected - 1.0).abs() < 0.12));
    }

    /// Beside a place as at the place itself.
    #[test]
    fn places_nearby_are_those_far_from_it() {
        let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.0).unwrap();
        let spectrum = Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap();
        let waves = WaveSum::new(&spectrum, Dispersion::default(), 2.0, Some(1.0), 9);
        let nearby = waves.about([20_000.0, -13_000.0], 77.0);
        for n in 0..100 {
            let place_m = [20_000.0 + 7.0 * f64::from(n), -13_000.0 - 3.0 * f64::from(n)];
            let (one, other) = (waves.beside(&nearby, place_m), waves.at(place_m, 77.0));
            assert!((one.height_m - other.height_m).abs() < 1e-3 * waves.height_rms_m(), "{n}");
            let off = [0, 1].map(|i| (one.slope[i] - other.slope[i]).abs() / waves.slope_rms([1.0, 0.0]));
            assert!(off[0].max(off[1]) < 3e-3, "{n}: {off:?}");
        }
    }

    /// What is seen at a place is seen a wave's way further, later: swell travels at its phase speed.
    #[test]
    fn swell_travels_at_its_phase_speed() {
        let wind = Wind::from_speed(5.0, 10.0, WindProfile::Cardone, 0.0).unwrap();
        let spectrum = Elfouhaily::new(&wind, Development::InverseWaveAge(0.84)).unwrap();
        let waves = WaveSum::new(&spectrum, Dispersion::default(), 4.0, None, 5);
        let one =
            WaveSum { rows: Rows::new(&waves.waves[..1]), waves: waves.waves[..1].to_vec(), ..waves.clone() };
        let [kx, ky] = waves.waves[0].k;
        let (k, omega) = (kx.hypot(ky), waves.waves[0].omega_radps);
        let [x, y] = [1234.0, -567.0];
        let (t_s, later_s) = (3.0, 4.5);
        let way_m = omega / k * (later_s - t_s);
        let there = one.at([x + kx / k * way_m, y + ky / k * way_m], later_s);
        let here = one.at([x, y], t_s);
        assert!((there.height_m - here.height_m).abs() < 1e-4 * waves.waves[0].amplitude_m);
        assert!((omega / k - (9.81 / k).sqrt()).abs() < 0.01 * omega / k);
    }
}
