//! The waves of a ship that a map leaves out, as a local spectrum: what a facet's Bragg scattering sees of
//! them.
//!
//! A map holds waves up to its band limit W(k) ([`nodes`](super::nodes)). Shorter ones are inside its facets.
//! A facet of side d resolves places to `s = d/sqrt(12)` (the standard deviation of its square), and wave
//! vectors by `1/(2 s)`, no better. So its local spectrum is the squared Fourier transform of what was left
//! out under a Gaussian window of that size. Of free waves it is an integral over their directions,
//! `t = tan theta`:
//!
//! `Psi(x, y; K) = (s^2/2 pi) [|Z(K)|^2 + |Z(-K)|^2]`,
//! `Z(K) = int A sqrt(1 - W^2) exp(-j k0 sqrt(1 + t^2) (x + y t) - s^2 |K - K(t)|^2) dt/(1 + t^2)`,
//!
//! `K(t) = k0 sqrt(1 + t^2) (1, t)` ahead and to port. It is symmetrised and two-sided (`int int Psi dK` is
//! the variance over a period), and by Parseval its integral over a cut across the wake is, at every
//! distance, the energy left out,
//!
//! `int pi |A|^2 (1 - W^2) sqrt(1 + t^2)/[k0 (1 + t^2)^2 (1 + 2 t^2)] dt`.
//!
//! | symbol | unit | meaning |
//! | --- | --- | --- |
//! | A | m | amplitude of the free waves ([`kochin`](super::kochin)) |
//! | k0 = g/V^2 | rad/m | wave number of the transverse waves |
//! | x, y | m | astern and to starboard of midship |
//! | K | rad/m | wave vector |
//! | Psi | m^4 | spectrum |
//!
//! Little of the integral counts: t with K(t) near K, and whose rays pass near the facet, `|y| = c x`,
//! `c = t/(1 + 2 t^2)`, from anywhere on the hull. So short waves lie near the track, those of one K on two
//! thin lines (four, where bow and stern are resolved).
//!
//! **What ends them.** Viscosity: an amplitude `exp(-2 nu K^2 a)`, `a = x/(V (1 - cos^2 theta/2))` the age of
//! a ray from midship. Breaking: no spectrum is larger than that of a wave of steepness [`STEEPEST`], which
//! thin-ship theory does not know: its slopes do not converge. Both can be set aside ([`Losses`]). Turbulence
//! in the strip behind a stern damps them with the waves of the wind, as the [kind](crate::scattering::kind)
//! of the facet has it.
//!
//! Source: rays of Kelvin waves in Munk, Scully-Power and Zachariasen, Proc. R. Soc. A 412, 231 (1987), who
//! explain the bright narrow V of satellite images at L band by them. Limits: gravity waves (surface tension
//! would add 7 % to the squared frequency at 100 rad/m and 29 % at 200 rad/m), far field, thin hulls: the
//! short waves of a hull are those of its ends, where the theory is at its weakest, and the kinks of a
//! table's panels have their part in them. The wave's own Doppler is not modelled, as for Bragg waves of the
//! wind, nor do these waves add to the slopes of specular points.
//!
//! ```
//! use nereus::sea::wake::{Course, Reach, Settings, ShortWaves, Wigley};
//! let hull = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };
//! let course = Course::straight([0.0, 0.0], 0.0, 9.0);
//! let settings = Settings::new(1.0, Reach::disc(0.0));
//! let waves = ShortWaves::new(course, hull.length_m, &settings, 60.0, |t| hull.amplitude_m(9.0, t))?;
//! // 20 rad/m: t = 12.8, on the rays of the bow 450 m astern of midship.
//! let k0 = 9.81 / 81.0;
//! let t = (20.0f64 / k0 - 1.0).sqrt();
//! let place = [450.0, 500.0 * t / (1.0 + 2.0 * t * t)];
//! let sec = (1.0 + t * t).sqrt();
//! assert!(waves.psi_m4(place, [k0 * sec, -k0 * t * sec]) > 1e-9);
//! // Nothing outside the wedge, or ahead.
//! assert_eq!(waves.psi_m4([450.0, 200.0], [k0 * sec, -k0 * t * sec]), 0.0);
//! assert_eq!(waves.psi_m4([-60.0, 1.0], [k0 * sec, -k0 * t * sec]), 0.0);
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::course::Course;
use super::free_waves::{LEAST_FACETS_A_WAVE, LEAST_SPEED_MPS, Settings};
use super::upstream::Window;
use crate::sea::GRAVITY_MPS2;
use crate::sea::wake::fault::{LENGTH_RANGE_M, WakeError};

/// Steepness (wave number times amplitude) of the steepest wave: Stokes' limit, `0.141 pi`.
pub const STEEPEST: f64 = 0.443;
/// Kinematic viscosity of water at 20 degrees Celsius, m^2/s.
pub const VISCOSITY_M2PS: f64 = 1.0e-6;
/// Deviations of a wave vector that count: `exp(-18)` is 1.5e-8 of the power.
pub(super) const WAVE_REACH: f64 = 6.0;
/// Distances of a place from a ray up to which waves count in full, and beyond which not at all, in
/// deviations and in Fresnel widths; in between the integrand falls as a raised cosine, so that its end makes
/// no waves. The transform of a Gaussian window has fallen to `exp(-12.5)` at 5 deviations.
pub(super) const PLACE_REACH: [[f64; 2]; 2] = [[5.0, 3.0], [9.0, 9.0]];
/// Below this t rays lie so close that the integral is not shortened by them.
pub(super) const LEAST_SHORT: f64 = 1.5;
/// `c` of the steepest ray.
pub(super) const STEEPEST_RAY: f64 = 0.353_553_390_593_273_8;
/// Most of `sqrt(1 + c^2)`, by which a ray sees a facet wider.
pub(super) const SLANT: f64 = 1.061;
/// Steps of the integral: at least 12 deviations in 32, and a phase of one radian a step.
const STEPS: [f64; 2] = [32.0, 2048.0];
/// Phase of a wave from one end of the ship against midship, from node to node of the table, radians: linear
/// interpolation loses an eighth of its square, 0.05 %.
const STEP_RAD: f64 = 0.0625;
/// Largest step in t, which resolves `1/(1 + t^2)`.
const LARGEST_STEP: f64 = 1.0 / 16.0;
/// Most nodes of the table: the shortest waves of slow, long ships are left out.
const MOST_NODES: f64 = 262_144.0;

/// What takes energy from short waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Losses {
    /// Kinematic viscosity, m^2/s; 0 for none.
    pub viscosity_m2ps: f64,
    /// Steepest wave, wave number times amplitude; infinite for no bound.
    pub steepest: f64,
}

impl Losses {
    /// Waves that nothing damps.
    pub const NONE: Self = Self { viscosity_m2ps: 0.0, steepest: f64::INFINITY };
}

impl Default for Losses {
    fn default() -> Self {
        Self { viscosity_m2ps: VISCOSITY_M2PS, steepest: STEEPEST }
    }
}

/// The short waves of one ship.
#[derive(Clone, Debug, PartialEq)]
pub struct ShortWaves {
    pub(super) course: Course,
    window: Window,
    pub(super) k0_radpm: f64,
    pub(super) half_m: f64,
    /// Deviation of places within a facet, m.
    pub(super) place_m: f64,
    pub(super) losses: Losses,
    pub(super) step: f64,
    /// Per node `A sqrt(1 - W^2)/(1 + t^2)`, m.
    pub(super) amplitudes_m: Vec<Complex64>,
}

impl ShortWaves {
    /// For a ship of a length, m, on the facets and under the band limit of its map (how far it reaches does
    /// not matter), for wave vectors up to `shortest_radpm`. Without speed there are none; where the map
    /// shows no waves of the ship because all are too short, all of them are here.
    ///
    /// # Errors
    /// As [`Wake::new`](super::Wake::new), and a `shortest_radpm` that is no wave number.
    pub fn new(
        course: Course,
        length_m: f64,
        settings: &Settings,
        shortest_radpm: f64,
        amplitude_m: impl Fn(f64) -> Complex64,
    ) -> Result<Self, WakeError> {
        course.check()?;
        if !(LENGTH_RANGE_M[0]..=LENGTH_RANGE_M[1]).contains(&length_m) {
            return Err(WakeError::Length { length_m });
        }
        let band = settings.band()?;
        if !(shortest_radpm > 0.0 && shortest_radpm.is_finite()) {
            return Err(WakeError::Cutoff { cutoff_rad_m: shortest_radpm });
        }
        let place_m = settings.facet_m / 12f64.sqrt();
        let k0_radpm = GRAVITY_MPS2 / (course.speed_mps * course.speed_mps);
        let none = Self {
            course,
            window: settings.upstream.window(length_m).fading(settings.fade_m),
            k0_radpm,
            half_m: 0.5 * length_m,
            place_m,
            losses: Losses::default(),
            step: (STEP_RAD / (0.5 * k0_radpm * length_m)).min(LARGEST_STEP),
            amplitudes_m: Vec::new(),
        };
        let over_k0 = (shortest_radpm + WAVE_REACH / (2.0 * place_m)) / k0_radpm;
        if course.speed_mps < LEAST_SPEED_MPS || over_k0 <= 1.0 {
            return Ok(none);
        }
        let count = ((over_k0 - 1.0).sqrt() / none.step).ceil().clamp(1.0, MOST_NODES);
        let on_map = TAU / k0_radpm >= LEAST_FACETS_A_WAVE * settings.facet_m;
        let node = |i: usize| {
            let t = none.step * i as f64;
            let amplitude = amplitude_m(t);
            if !(amplitude.re.is_finite() && amplitude.im.is_finite()) {
                return Err(WakeError::Amplitude { tan_theta: t });
            }
            let sec2 = 1.0 + t * t;
            let over = k0_radpm * sec2 / band.cutoff_rad_m;
            // 1 - W^2 without a difference.
            let left_out = if on_map { -(-2.0 * over.powi(4)).exp_m1() } else { 1.0 };
            Ok(amplitude * (left_out.sqrt() / sec2))
        };
        let amplitudes_m = (0..=count as usize).map(node).collect::<Result<_, _>>()?;
        Ok(Self { amplitudes_m, ..none })
    }

    /// The same with other losses.
    pub fn with_losses(self, losses: Losses) -> Self {
        Self { losses, ..self }
    }

    /// The ship's course.
    pub fn course(&self) -> &Course {
        &self.course
    }

    /// Deviation of a wave vector, rad/m.
    pub(super) fn deviation_radpm(&self) -> f64 {
        0.5 / self.place_m
    }

    /// Last t of the table.
    pub(super) fn most(&self) -> f64 {
        self.step * (self.amplitudes_m.len() - 1) as f64
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.amplitudes_m.is_empty()
    }

    /// Their energy over a cut across the whole wake, half a squared amplitude times metres, m^3, before
    /// losses: the trapezoid of the table.
    pub fn energy_m3(&self) -> f64 {
        let last = self.amplitudes_m.len().saturating_sub(1);
        let energy = |(i, amplitude): (usize, &Complex64)| {
            let t2 = (self.step * i as f64).powi(2);
            let weight = if i == 0 || i == last { 0.5 } else { 1.0 };
            weight * amplitude.norm_sqr() * (1.0 + t2).sqrt() / (1.0 + 2.0 * t2)
        };
        TAU * self.step / self.k0_radpm * self.amplitudes_m.iter().enumerate().map(energy).sum::<f64>()
    }

    /// Their spectrum, m^4, at a distance astern and to starboard of midship, m, for a wave vector ahead and
    /// to port, rad/m. Zero where a window of a facet's size is over.
    pub fn psi_m4(&self, place_m: [f64; 2], k_radpm: [f64; 2]) -> f64 {
        self.spectrum_m4(place_m, k_radpm, |place, wave, range| self.transform(place, wave, range))
    }

    /// The same with another way to find [`Self::transform`].
    pub(super) fn spectrum_m4(
        &self,
        [astern_m, starboard_m]: [f64; 2],
        [ahead_radpm, port_radpm]: [f64; 2],
        transform: impl Fn([f64; 2], [f64; 2], [f64; 2]) -> Complex64,
    ) -> f64 {
        // What is no number is at no place.
        if self.is_empty() || astern_m.is_nan() || astern_m <= -self.half_m || !starboard_m.is_finite() {
            return 0.0;
        }
        let faded = self.window.at(astern_m).value;
        let k_radpm = ahead_radpm.hypot(port_radpm);
        let deviation_radpm = 0.5 / self.place_m;
        let furthest = (k_radpm + WAVE_REACH * deviation_radpm) / self.k0_radpm;
        if faded == 0.0 || furthest.is_nan() || furthest <= 1.0 {
            return 0.0;
        }
        let nearest = (k_radpm - WAVE_REACH * deviation_radpm) / self.k0_radpm;
        let most = self.step * (self.amplitudes_m.len() - 1) as f64;
        let range = [(nearest - 1.0).max(0.0).sqrt(), (furthest - 1.0).sqrt().min(most)];
        let mut sums = [Complex64::ZERO; 2];
        for side in [1.0, -1.0] {
            let place = [astern_m, side * starboard_m];
            // Waves of the starboard side run to starboard.
            let wave = [ahead_radpm, -side * port_radpm];
            sums[0] += transform(place, wave, range);
            sums[1] += transform(place, wave.map(|k| -k), range);
        }
        let scale = 0.5 * self.place_m * self.place_m / PI;
        let steepest_m = self.losses.steepest / k_radpm;
        // Of one wave of amplitude a the spectrum at its own wave vector is a^2 s^2/(2 pi).
        (scale * (sums[0].norm_sqr() + sums[1].norm_sqr()) * faded * faded)
            .min(scale * steepest_m * steepest_m)
    }

    /// Z of the waves that run to one side, at a place astern and to that side, for a wave vector ahead and
    /// to that side.
    pub(super) fn transform(&self, [x_m, y_m]: [f64; 2], wave: [f64; 2], range: [f64; 2]) -> Complex64 {
        // Waves run ahead and to their own side.
        if wave.iter().any(|k| *k < -WAVE_REACH / (2.0 * self.place_m)) {
            return Complex64::ZERO;
        }
        let Some([from, to]) = self.rays(x_m, y_m, range) else { return Complex64::ZERO };
        let s2 = self.place_m * self.place_m;
        let rate = |t: f64| {
            let sec = t.hypot(1.0);
            self.k0_radpm * ((t * x_m - (1.0 + 2.0 * t * t) * y_m).abs() + t * self.half_m) / sec
        };
        // Between two stationary points the phase runs fastest about t = x/(4 y).
        let between = if y_m > 0.0 { (0.25 * x_m / y_m).clamp(from, to) } else { from };
        let turns = (to - from) * rate(from).max(rate(to)).max(rate(between));
        let steps = turns.ceil().clamp(STEPS[0], STEPS[1]);
        let width = (to - from) / steps;
        let mut sum = Complex64::ZERO;
        for i in 0..=steps as usize {
            let t = from + width * i as f64;
            let sec2 = 1.0 + t * t;
            let sec = sec2.sqrt();
            let [kx, ky] = [self.k0_radpm * sec, self.k0_radpm * sec * t];
            let exponent = s2 * ((wave[0] - kx).powi(2) + (wave[1] - ky).powi(2));
            if exponent > WAVE_REACH * WAVE_REACH {
                continue;
            }
            let c = t / (1.0 + 2.0 * t * t);
            let off_m = ((y_m - c * x_m).abs() - c * self.half_m) / (1.0 + c * c).sqrt();
            let reach_m = self.reach_m(x_m, t);
            if off_m >= reach_m[1] {
                continue;
            }
            let mut weight = 1.0;
            if off_m > reach_m[0] {
                weight = 0.5 + 0.5 * (PI * (off_m - reach_m[0]) / (reach_m[1] - reach_m[0])).cos();
            }
            let k = self.k0_radpm * sec2;
            if self.losses.viscosity_m2ps > 0.0 {
                let age_s = x_m.max(0.0) / (self.course.speed_mps * (1.0 - 0.5 / sec2));
                weight *= (-2.0 * self.losses.viscosity_m2ps * k * k * age_s).exp();
            }
            if i == 0 || i == steps as usize {
                weight *= 0.5;
            }
            // To its own side a wave has t < 0 on the starboard side and t > 0 on the port side: x - |t| |y|.
            let phase = Complex64::cis(-self.k0_radpm * sec * (x_m - t * y_m));
            sum += self.amplitude_m(t) * phase * (weight * (-exponent).exp());
        }
        sum * width
    }

    /// How far from the rays of t waves reach, x astern, m: where they begin to be left out, and where all
    /// are. The Fresnel width is the root of the rate at which rays of successive wave numbers part,
    /// `|dy/dky|` (of short waves; near the cusp a bound).
    pub(super) fn reach_m(&self, x_m: f64, t: f64) -> [f64; 2] {
        let fresnel_m = self.fresnel_m(x_m, t);
        PLACE_REACH.map(|[deviations, widths]| deviations * self.place_m + widths * fresnel_m)
    }

    fn fresnel_m(&self, x_m: f64, t: f64) -> f64 {
        (x_m.max(0.0) * (1.0 + t * t).sqrt() / self.k0_radpm).sqrt() / (1.0 + 2.0 * t * t)
    }

    /// Range of t whose rays pass near a place, from anywhere on the hull, within another.
    pub(super) fn rays(&self, x_m: f64, y_m: f64, range: [f64; 2]) -> Option<[f64; 2]> {
        self.rays_within(x_m, y_m, range, PLACE_REACH[1])
    }

    /// The same of rays within so many deviations and Fresnel widths.
    pub(super) fn rays_within(
        &self,
        x_m: f64,
        y_m: f64,
        [from, to]: [f64; 2],
        [deviations, widths]: [f64; 2],
    ) -> Option<[f64; 2]> {
        // Rays of larger t lie nearer to the track, and closer to each other.
        let fresnel_m = self.fresnel_m(x_m, from.max(LEAST_SHORT));
        let reach_m = SLANT * (deviations * self.place_m + widths * fresnel_m);
        let inner = (y_m - reach_m) / (x_m + self.half_m);
        let outer = if x_m > self.half_m { (y_m + reach_m) / (x_m - self.half_m) } else { STEEPEST_RAY };
        if inner > STEEPEST_RAY || outer <= 0.0 {
            return None;
        }
        // t of a ray short of the steepest: 2 c t^2 - t + c = 0.
        let root = |c: f64| (1.0 - 8.0 * c * c).max(0.0).sqrt();
        let short = |c: f64| if c > 0.0 { (1.0 + root(c)) / (4.0 * c) } else { f64::INFINITY };
        let to = to.min(short(inner).max(LEAST_SHORT));
        let from = if from < LEAST_SHORT { from } else { from.max(short(outer.min(STEEPEST_RAY))) };
        (to > from).then_some([from, to])
    }

    pub(super) fn amplitude_m(&self, t: f64) -> Complex64 {
        let place = t / self.step;
        let node = (place as usize).min(self.amplitudes_m.len() - 2);
        let [low, high] = [self.amplitudes_m[node], self.amplitudes_m[node + 1]];
        low + (high - low) * (place - node as f64)
    }
}
