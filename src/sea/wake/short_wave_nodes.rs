//! The short waves of a ship on nodes: [`ShortWaves::psi_m4`] for the many facets of a fast echo.
//!
//! The integral over t is one over the wave number to the side, `ky = k0 t sqrt(1 + t^2)`, and all that does
//! not depend on the facet is tabulated at nodes `h` apart:
//!
//! `Z(K) = sum G_n exp(-j (kx_n x - ky_n y) - s^2 |K - K_n|^2 - l_n x) w_n`,
//! `G = A sqrt(1 - W^2)/(1 + t^2) h dt/dky`, `l = 2 nu K^2/[V (1 - cos^2 theta/2)]`,
//!
//! with the weight `w` that ends waves far from their rays, as in the integral. A facet needs the nodes
//! within six deviations of its wave vector, some tens of them, evaluated side by side in f32 (phases in
//! f64).
//!
//! **Error.** The sum over all nodes is the integral plus its images, `2 pi/h` to either side. A place that
//! is `|y - c x|` off the rays and sees a hull of `+-L/2` needs `h < 2 pi/(|y - c x| + c L/2 + 1.25 r)`, r
//! the distance from a ray within which waves count in full: there the image is below `exp(-12.5)`, -108 dB
//! of the waves on the ray. Nodes stand in levels, each twice as dense as the one before, and a facet takes
//! the first that is dense enough; where not even the densest is, it takes the integral. Amplitudes are as
//! the integral has them: straight between the nodes of its table, which in the mean adds a twelfth of the
//! second difference, and leaves images fifty lengths of the ship away. Rounding is 1e-6. What is left
//! against the integral is that this ends at six deviations, where 1.2e-4 of an amplitude remains: 1e-5 of
//! the largest nearby, rms, and 2e-4 at worst (`tests/physics/wake_short_nodes.rs`).
//!
//! Limits: rays of t below 1.5 cross, and the ends of waves there are steeper than nodes are close. Facets
//! that see them (facets much finer than the waves, steep incidence) take the integral, at its price.
//!
//! | symbol | unit | meaning |
//! | --- | --- | --- |
//! | x, y | m | astern of midship, and to the side to which the waves run |
//! | kx, ky | rad/m | wave numbers ahead and to that side |
//! | c | 1 | `t/(1 + 2 t^2)`: rays are `y = c x` |
//! | s | m | deviation of places within a facet |
//!
//! ```
//! use nereus::cpu::Variant;
//! use nereus::sea::wake::{Course, Reach, Settings, ShortWaveNodes, ShortWaves, Wigley};
//! let hull = Wigley { length_m: 100.0, beam_m: 13.0, draught_m: 4.3 };
//! let course = Course::straight([0.0, 0.0], 0.0, 9.0);
//! let settings = Settings::new(1.0, Reach::disc(0.0));
//! let waves = ShortWaves::new(course, hull.length_m, &settings, 60.0, |t| hull.amplitude_m(9.0, t))?;
//! let nodes = ShortWaveNodes::new(waves.clone());
//! // 20 rad/m, on the rays of the bow 450 m astern of midship.
//! let (place_m, k_radpm) = ([450.0, 19.4], [1.6, -19.9]);
//! let [found, exact] = [nodes.psi_m4(Variant::fastest(), place_m, k_radpm), waves.psi_m4(place_m, k_radpm)];
//! assert!(exact > 1e-9 && (found / exact - 1.0).abs() < 1e-4);
//! # Ok::<(), nereus::sea::wake::WakeError>(())
//! ```

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::course::Course;
use super::short_waves::{LEAST_SHORT, PLACE_REACH, SLANT, STEEPEST_RAY, ShortWaves, WAVE_REACH};
use crate::cpu::{Task, Variant};
use crate::units::{SINE_OF_HALF_TURNS, cos_sin_of_turns, exponential};

/// Nodes side by side.
const GROUP: usize = 8;
/// Levels, and most intervals of one: the densest reaches over 16 deviations of a wave vector.
const LEVELS: i32 = 8;
const INTERVALS: f64 = 2048.0;
/// Largest distance of nodes over the deviation of a wave vector: images are `4 pi s` away, `exp(-39)`.
const COARSEST: f64 = 1.0;
/// By how much more than the reach of full waves an image is to be away.
const CLEARANCE: f64 = 1.25;
/// Distances of a place from a ray beyond which waves of all rays cancel there, in deviations and in Fresnel
/// widths: at six deviations the transform of a Gaussian window has fallen to `exp(-18)`.
const SEEN_REACH: [f64; 2] = [6.0, 4.0];
/// Share of the waves that scatter up to which waves of t below [`LEAST_SHORT`] are left out.
const UNSEEN: f64 = 1e-5;

/// The short waves of one ship, tabulated.
#[derive(Clone, Debug, PartialEq)]
pub struct ShortWaveNodes {
    waves: ShortWaves,
    /// Largest amplitude of the table for waves on rays that cross.
    longest_m: f64,
    levels: Vec<Level>,
}

/// Nodes of one distance.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    step_radpm: f64,
    groups: Vec<Nodes>,
}

/// Some nodes, side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Nodes {
    /// Wave numbers ahead and to the side, turns/m.
    ahead: [f64; GROUP],
    aside: [f64; GROUP],
    /// G, m.
    re: [f32; GROUP],
    im: [f32; GROUP],
    /// Exponent of the loss in a metre, 1/m.
    loss: [f32; GROUP],
    /// c, and `1/sqrt(1 + c^2)`.
    ray: [f32; GROUP],
    slant: [f32; GROUP],
    /// Fresnel width over the root of the distance, m^(1/2).
    fresnel: [f32; GROUP],
}

impl ShortWaveNodes {
    /// Tabulates the waves of a ship.
    pub fn new(waves: ShortWaves) -> Self {
        let mut own = Self { waves, longest_m: 0.0, levels: Vec::new() };
        if own.waves.is_empty() {
            return own;
        }
        let long = (LEAST_SHORT / own.waves.step) as usize;
        let longest = own.waves.amplitudes_m.iter().take(long.saturating_add(1));
        own.longest_m = longest.fold(0.0f64, |most, amplitude| most.max(amplitude.norm()));
        let most = own.waves.most();
        let end_radpm = own.waves.k0_radpm * most * most.hypot(1.0);
        let even = own.even_amplitudes();
        let coarsest_radpm = COARSEST * own.waves.deviation_radpm();
        own.levels =
            (0..LEVELS).map(|n| own.level(coarsest_radpm / 2f64.powi(n), end_radpm, &even)).collect();
        own
    }

    /// The ship's course.
    pub fn course(&self) -> &Course {
        self.waves.course()
    }

    /// The waves that were tabulated.
    pub fn waves(&self) -> &ShortWaves {
        &self.waves
    }

    /// Their spectrum as [`ShortWaves::psi_m4`] has it.
    pub fn psi_m4(&self, variant: Variant, place_m: [f64; 2], k_radpm: [f64; 2]) -> f64 {
        let transform = |place, wave, range| self.transform(variant, place, wave, range);
        self.waves.spectrum_m4(place_m, k_radpm, transform)
    }

    /// Where waves of at least a wave number may be.
    pub fn wedge(&self, least_radpm: f64) -> Wedge {
        let waves = &self.waves;
        let over_k0 = (least_radpm - WAVE_REACH * waves.deviation_radpm()) / waves.k0_radpm;
        let from = (over_k0 - 1.0).max(0.0).sqrt();
        let [deviations, widths] = PLACE_REACH[1];
        Wedge {
            empty: waves.is_empty(),
            half_m: waves.half_m,
            ray: if from < LEAST_SHORT { STEEPEST_RAY } else { from / (1.0 + 2.0 * from * from) },
            beside_m: SLANT * deviations * waves.place_m,
            per_root: SLANT * widths * fresnel(from, waves.k0_radpm),
        }
    }

    /// Amplitudes of the table of which the integral is that of lines between its own: an even function of t,
    /// in the mean a twelfth of the second difference more.
    fn even_amplitudes(&self) -> Vec<Complex64> {
        let table = &self.waves.amplitudes_m;
        let last = table.len() - 1;
        let second = |n: usize| table[n + 1] - 2.0 * table[n] + table[n.abs_diff(1)];
        (0..=last).map(|n| if n < last { table[n] + second(n) / 12.0 } else { table[n] }).collect()
    }

    fn level(&self, step_radpm: f64, end_radpm: f64, even: &[Complex64]) -> Level {
        let waves = &self.waves;
        let (k0, losses) = (waves.k0_radpm, waves.losses);
        let intervals = (end_radpm / step_radpm).ceil().min(INTERVALS);
        let mut groups = vec![Nodes::default(); (intervals as usize + 1).div_ceil(GROUP)];
        for n in 0..groups.len() * GROUP {
            let (nodes, i) = (&mut groups[n / GROUP], n % GROUP);
            let ky = step_radpm * n as f64;
            // (ky/k0)^2 = t^2 (1 + t^2).
            let q2 = (ky / k0).powi(2);
            let t2 = 2.0 * q2 / (1.0 + (1.0 + 4.0 * q2).sqrt());
            let (t, sec2) = (t2.sqrt(), 1.0 + t2);
            let (sec, bend) = (sec2.sqrt(), 1.0 + 2.0 * t2);
            let dt = step_radpm * sec / (k0 * bend);
            let amplitude = if t < waves.most() { cubic(even, t / waves.step) * dt } else { Complex64::ZERO };
            let c = t / bend;
            nodes.ahead[i] = k0 * sec / TAU;
            nodes.aside[i] = ky / TAU;
            (nodes.re[i], nodes.im[i]) = (amplitude.re as f32, amplitude.im as f32);
            let k = k0 * sec2;
            nodes.loss[i] =
                (2.0 * losses.viscosity_m2ps * k * k / (waves.course.speed_mps * (1.0 - 0.5 / sec2))) as f32;
            nodes.ray[i] = c as f32;
            nodes.slant[i] = (1.0 / (1.0 + c * c).sqrt()) as f32;
            nodes.fresnel[i] = fresnel(t, k0) as f32;
        }
        Level { step_radpm, groups }
    }

    /// Whether facets see next to nothing of the long waves when their wave vector is so long, rad/m.
    fn is_short(&self, k_radpm: f64) -> bool {
        let waves = &self.waves;
        let t = (k_radpm / waves.k0_radpm - 1.0).max(0.0).sqrt();
        let beyond_radpm = k_radpm - waves.k0_radpm * (1.0 + LEAST_SHORT * LEAST_SHORT);
        t > LEAST_SHORT && {
            let seen = (-(waves.place_m * beyond_radpm).powi(2)).exp();
            self.longest_m * seen < UNSEEN * waves.amplitude_m(t.min(waves.most())).norm()
        }
    }

    /// [`ShortWaves::transform`] on nodes.
    fn transform(&self, variant: Variant, place_m: [f64; 2], wave: [f64; 2], range: [f64; 2]) -> Complex64 {
        let waves = &self.waves;
        if wave.iter().any(|k| *k < -WAVE_REACH * waves.deviation_radpm()) {
            return Complex64::ZERO;
        }
        let [x_m, y_m] = place_m;
        let long = range[0] < LEAST_SHORT && !self.is_short(wave[0].hypot(wave[1]));
        let shortened = if long { range } else { [range[0].max(LEAST_SHORT), range[1]] };
        let Some([from, to]) = waves.rays(x_m, y_m, shortened) else { return Complex64::ZERO };
        if !long && waves.rays_within(x_m, y_m, shortened, SEEN_REACH).is_none() {
            return Complex64::ZERO;
        }
        let off_m = |t: f64| {
            let c = t / (1.0 + 2.0 * t * t);
            [(y_m - c * x_m).abs(), c * waves.half_m]
        };
        // Convex functions of c: their largest values are those of the ends.
        let [[near_m, hull_m], [far_m, less_m]] = [off_m(from), off_m(to)];
        let turning_m = (near_m + hull_m).max(far_m + less_m);
        let most_off_m = (near_m - hull_m).max(far_m - less_m);
        // Waves that have ended turn unseen.
        let turning_m = turning_m.min(SLANT * waves.reach_m(x_m, from)[1] + 2.0 * hull_m);
        let full_m = waves.reach_m(x_m, from)[0];
        let step_radpm = (TAU / (turning_m + CLEARANCE * full_m)).min(COARSEST * waves.deviation_radpm());
        let dense_enough = |level: &&Level| level.step_radpm <= step_radpm;
        let place =
            |t: f64, level: &Level| (waves.k0_radpm * t * t.hypot(1.0) / level.step_radpm) as usize / GROUP;
        let long_enough = |level: &&Level| place(to, level) < level.groups.len();
        // A table that was cut ends in the midst of waves.
        let held = !long && to < waves.most();
        let level = self.levels.iter().find(dense_enough).filter(long_enough).filter(|_| held);
        let Some(level) = level else { return waves.transform(place_m, wave, range) };
        let groups = &level.groups[place(from, level)..=place(to, level)];
        let downstream_m = x_m.max(0.0);
        let sum = Sum {
            groups,
            place_m,
            wave: wave.map(|k| k / TAU),
            square_m2: (TAU * TAU * waves.place_m * waves.place_m) as f32,
            half_m: waves.half_m as f32,
            downstream_m: downstream_m as f32,
            reach_m: PLACE_REACH
                .map(|[deviations, widths]| [deviations * waves.place_m, widths * downstream_m.sqrt()])
                .map(|reach_m| reach_m.map(|c| c as f32)),
        };
        // The least reach is that of the last rays.
        let [re, im] = if most_off_m <= waves.reach_m(x_m, to)[0] {
            variant.run(Full(sum))
        } else {
            variant.run(Ending(sum))
        };
        Complex64::new(f64::from(re), f64::from(im))
    }
}

/// Where waves may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wedge {
    empty: bool,
    half_m: f64,
    ray: f64,
    beside_m: f64,
    per_root: f64,
}

impl Wedge {
    /// Whether they may be at a place astern and to either side of midship, m. If they may, they may be
    /// further astern and nearer to the track.
    #[inline]
    pub fn holds(&self, [astern_m, starboard_m]: [f64; 2]) -> bool {
        let reach_m = self.beside_m + self.per_root * astern_m.max(0.0).sqrt();
        // Beside the hull the integral has waves of either end, to both sides.
        let from_end_m = astern_m.max(self.half_m) + self.half_m;
        !self.empty && astern_m > -self.half_m && starboard_m.abs() <= self.ray * from_end_m + reach_m
    }
}

/// Fresnel width over the root of the distance, m^(1/2).
fn fresnel(t: f64, k0_radpm: f64) -> f64 {
    (t.hypot(1.0) / k0_radpm).sqrt() / (1.0 + 2.0 * t * t)
}

/// Between the entries of an even function, through four of them.
fn cubic(even: &[Complex64], place: f64) -> Complex64 {
    let last = even.len() - 1;
    let low = (place as usize).min(last - 1);
    let p = (place - low as f64).min(1.0);
    let at = |n: usize| even[n.min(last)];
    let weights = [
        -p * (p - 1.0) * (p - 2.0) / 6.0,
        (p + 1.0) * (p - 1.0) * (p - 2.0) / 2.0,
        -(p + 1.0) * p * (p - 2.0) / 2.0,
        (p + 1.0) * p * (p - 1.0) / 6.0,
    ];
    let values = [at(low.abs_diff(1)), at(low), at(low + 1), at(low + 2)];
    weights.iter().zip(values).map(|(weight, value)| value * *weight).sum()
}

/// Z of some nodes.
struct Sum<'a> {
    groups: &'a [Nodes],
    place_m: [f64; 2],
    /// Wave vector, turns/m.
    wave: [f64; 2],
    /// Square of the deviation of places, times that of a turn.
    square_m2: f32,
    half_m: f32,
    downstream_m: f32,
    /// Distances from a ray at which waves begin to end and have ended: alone, and for each Fresnel width of
    /// a metre.
    reach_m: [[f32; 2]; 2],
}

/// Where all waves are in full.
struct Full<'a>(Sum<'a>);

/// Where some end.
struct Ending<'a>(Sum<'a>);

impl Task for Full<'_> {
    type Output = [f32; 2];

    #[inline(always)]
    fn run(self) -> [f32; 2] {
        self.0.run::<false>()
    }
}

impl Task for Ending<'_> {
    type Output = [f32; 2];

    #[inline(always)]
    fn run(self) -> [f32; 2] {
        self.0.run::<true>()
    }
}

impl Sum<'_> {
    #[inline(always)]
    fn run<const ENDS: bool>(self) -> [f32; 2] {
        let Self { groups, place_m: [x_m, y_m], wave, square_m2, half_m, downstream_m, reach_m } = self;
        let [x32_m, y32_m] = [x_m as f32, y_m as f32];
        let (mut re, mut im) = ([0.0f32; GROUP], [0.0f32; GROUP]);
        for nodes in groups {
            for i in 0..GROUP {
                let (cos, sin) = cos_sin_of_turns(nodes.aside[i] * y_m - nodes.ahead[i] * x_m);
                let (u, v) = ((wave[0] - nodes.ahead[i]) as f32, (wave[1] - nodes.aside[i]) as f32);
                let mut weight = exponential(-(square_m2 * (u * u + v * v) + nodes.loss[i] * downstream_m));
                if ENDS {
                    let ray = nodes.ray[i];
                    let off_m = ((y32_m - ray * x32_m).abs() - ray * half_m) * nodes.slant[i];
                    let [[near, near_root], [far, far_root]] = reach_m;
                    let begin_m = near + near_root * nodes.fresnel[i];
                    let end_m = far + far_root * nodes.fresnel[i];
                    let share = ((off_m - begin_m) / (end_m - begin_m)).clamp(0.0, 1.0);
                    weight *= raised_cosine(share);
                }
                re[i] += weight * (nodes.re[i] * cos - nodes.im[i] * sin);
                im[i] += weight * (nodes.re[i] * sin + nodes.im[i] * cos);
            }
        }
        [re, im].map(|row| row.iter().sum())
    }
}

/// From 1 to 0 over the unit interval.
#[inline(always)]
fn raised_cosine(share: f32) -> f32 {
    let t = 0.5 * share;
    let z = t * t;
    let c = SINE_OF_HALF_TURNS;
    let sine = t * (c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * c[4]))));
    1.0 - sine * sine
}
