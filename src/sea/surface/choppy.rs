//! Choppy waves: crests that are sharper and higher than troughs, to second order in the steepness.
//!
//! Particles of the surface run on the circles of linear waves: the facet of grid point `x_0` is at
//! `x = x_0 + D(x_0, t)`, the horizontal displacement of [`super`], so that facets crowd on crests
//! (Gerstner's wave; Nouguier, Guerin and Chapron 2009). What follows from it, with `S = grad D` (symmetric)
//! and `h` the linear height:
//!
//! | quantity | value | unit |
//! | --- | --- | --- |
//! | horizontal area over that of the grid | `J = det(I + S)` | 1 |
//! | height | `z = h + k (h^2 + \|D\|^2)/2 + z_0` | m |
//! | slope in the displaced plane | `(I + S)^-1 grad z` | 1 |
//! | horizontal velocity | `dD/dt`, the orbital velocity of linear waves | m/s |
//! | vertical velocity | `dh/dt + k (h dh/dt + D.dD/dt)` | m/s |
//!
//! **The level**, `k (h^2 + |D|^2)/2`, is half of `k` times the squared envelope. Displacement alone lowers
//! the mean level of a group of waves by as much, and a Gaussian sea that is only displaced has no skewness
//! at all. `z_0` makes the mean height over horizontal space zero: `E[z J] = 0` with
//! `z_0 = sum (K - k) s(K)`, `s` the variance of a wave.
//!
//! **The wave number `k`** follows from the second-order theory of Longuet-Higgins (1963), deep water:
//!
//! `k = sum sum M(K_1, K_2) s_1 s_2 / sum sum s_1 s_2`, skewness `3 k sum sum s_1 s_2/(sum s)^(3/2)`,
//!
//! with [`interaction_radpm`] for M, `min(K_1, K_2)` of waves that run the same way. A wave paired with
//! itself counts half: amplitudes are drawn, and their fourth powers are twice as much in the mean as of
//! waves of fixed height. The skewness of the height at second order is then his for any spectrum, and
//! Tayfun's (1980) for a narrow one; a single wave is that of Stokes. How it is shared between sum and
//! difference of frequencies is not his but for a narrow spectrum. The waves are those of the map, sorted by
//! octaves in eighths and by direction in steps of 15 degrees.
//!
//! **Folds**: where `J` would be less than [`LEAST_AREA`], all of `S` is reduced at that facet until `J` is
//! as large; height and place stay. The mean of `J` over a map is 1 but for that.
//!
//! Limits: deep water; no drift of the particles (Stokes), no change of frequencies with height; waves
//! shorter than two facets are not displaced; those of ships move facets, but change neither `J` nor `k`.
//!
//! ```
//! use nereus::sea::surface::choppy::interaction_radpm;
//! assert!((interaction_radpm([0.1, 0.0], [0.4, 0.0]) - 0.1).abs() < 1e-12);
//! // Waves that meet head on: as much as one of them alone.
//! assert!((interaction_radpm([0.1, 0.0], [-0.1, 0.0]) - 0.1).abs() < 1e-12);
//! ```

use std::f64::consts::TAU;

use super::fields::Real;
use super::{Fields, Surface};
use crate::cpu::{Task, Variant};

/// Least horizontal area of a facet over that of the grid.
pub const LEAST_AREA: f64 = 0.2;
/// Classes of waves an octave, and around the compass.
const AN_OCTAVE: f64 = 8.0;
const AROUND: usize = 24;
/// Variance of the height below which a surface is flat, m^2: 1e-20 m, where squares of it are still numbers.
const LEAST_VARIANCE_M2: f64 = 1e-40;
/// Octaves of wave numbers a map may have, and more.
const MOST_CLASSES: usize = 32 * 8;

/// What makes a surface choppy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choppy {
    /// Wave number `k` of the level, rad/m.
    pub level_radpm: f64,
    /// Variance of the linear height, m^2.
    pub variance_m2: f64,
    /// `z_0`, m.
    pub offset_m: f64,
    /// `sum sum s_1 s_2`, m^4.
    pub pairs_m4: f64,
}

/// Waves of about the same length and direction: variance, m^2, and its first moments.
#[derive(Clone, Copy, Default)]
struct Class {
    variance_m2: f64,
    moment: [f64; 3],
}

/// Half the sum of the kernels of sum and difference frequency of two waves in deep water, rad/m: what
/// `s_1 s_2` are multiplied by in a third of the third moment of the height (Longuet-Higgins 1963, in the
/// form of Sharma and Dean 1981).
pub fn interaction_radpm(first: [f64; 2], second: [f64; 2]) -> f64 {
    let (k1, k2) = (first[0].hypot(first[1]), second[0].hypot(second[1]));
    let product = k1 * k2;
    if product == 0.0 {
        return 0.0;
    }
    let dot = first[0] * second[0] + first[1] * second[1];
    let apart = (first[0] - second[0]).hypot(first[1] - second[1]);
    let together = (first[0] + second[0]).hypot(first[1] + second[1]);
    let (slow, fast) = ((k1.sqrt() - k2.sqrt()).powi(2), (k1.sqrt() + k2.sqrt()).powi(2));
    // The difference of a wave from itself is level; the ratio ends there at 0.
    let difference = if slow > 0.0 { 2.0 * slow * (dot + product) / (slow - apart) } else { 0.0 };
    let sum = 2.0 * fast * (dot - product) / (fast - together);
    0.5 * (difference + sum - 2.0 * dot) / product.sqrt() + k1 + k2
}

impl Choppy {
    /// Of the waves of a surface.
    pub fn of(surface: &Surface) -> Self {
        let grid = surface.grid();
        let step = grid.wave_number_step_rad_m();
        let least_radpm = step[0].min(step[1]);
        let mut alone = [0.0; 2];
        let mut classes = vec![Class::default(); MOST_CLASSES * AROUND];
        for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
            for (j, amplitude) in row.iter().enumerate() {
                let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else { continue };
                let variance_m2 = 2.0 * amplitude.norm_sqr();
                if variance_m2 == 0.0 {
                    continue;
                }
                let [kx, ky] = [mx as f64 * step[0], my as f64 * step[1]];
                let k = kx.hypot(ky);
                // Both casts are of small numbers that are not negative.
                let length = ((k / least_radpm).log2() * AN_OCTAVE).max(0.0) as usize;
                let towards = (ky.atan2(kx) / TAU * AROUND as f64 + 1.5 * AROUND as f64) as usize % AROUND;
                let class = &mut classes[length.min(MOST_CLASSES - 1) * AROUND + towards];
                class.variance_m2 += variance_m2;
                let square_m4 = variance_m2 * variance_m2;
                alone = [alone[0] + square_m4, alone[1] + k * square_m4];
                for (moment, value) in class.moment.iter_mut().zip([kx, ky, k]) {
                    *moment += variance_m2 * value;
                }
            }
        }
        classes.retain(|class| class.variance_m2 > 0.0);
        Self::of_classes(&classes, alone)
    }

    /// Of classes, and of `s^2` and `M s^2` of the waves alone.
    fn of_classes(classes: &[Class], alone: [f64; 2]) -> Self {
        let waves: Vec<(f64, [f64; 2])> = classes
            .iter()
            .map(|Class { variance_m2, moment: [x, y, k] }| {
                let (mean_radpm, length) = (k / variance_m2, x.hypot(*y).max(f64::MIN_POSITIVE));
                (*variance_m2, [mean_radpm * (x / length), mean_radpm * (y / length)])
            })
            .collect();
        let variance_m2: f64 = waves.iter().map(|(variance_m2, _)| variance_m2).sum();
        if variance_m2 < LEAST_VARIANCE_M2 {
            return Self::default();
        }
        let mut sum = -0.5 * alone[1];
        for (n, (of, wave)) in waves.iter().enumerate() {
            let later = waves[n + 1..].iter().map(|(with, other)| with * interaction_radpm(*wave, *other));
            sum += of * (of * interaction_radpm(*wave, *wave) + 2.0 * later.sum::<f64>());
        }
        let pairs_m4 = variance_m2 * variance_m2 - 0.5 * alone[0];
        let level_radpm = sum / pairs_m4;
        let lowered_m: f64 = classes.iter().map(|class| class.moment[2]).sum();
        Self { level_radpm, variance_m2, offset_m: lowered_m - level_radpm * variance_m2, pairs_m4 }
    }

    /// Skewness of the height over horizontal space that is expected at second order.
    pub fn skewness(&self) -> f64 {
        if self.variance_m2 > 0.0 {
            3.0 * self.level_radpm * self.pairs_m4 / self.variance_m2.powf(1.5)
        } else {
            0.0
        }
    }

    /// How far the height may exceed the linear one where that is at most so many deviations, m.
    pub(crate) fn most_m(&self, deviations: f64) -> f64 {
        self.level_radpm * deviations * deviations * self.variance_m2 + self.offset_m.abs()
    }

    /// Fields of linear waves, of which [`Selection::choppy`](super::Selection) has made sure that they are
    /// there, become those of choppy ones.
    pub(crate) fn apply<T: Real>(&self, fields: &mut Fields<T>) {
        Variant::fastest().run(Displace { of: *self, fields });
    }
}

struct Displace<'a, T> {
    of: Choppy,
    fields: &'a mut Fields<T>,
}

impl<T: Real> Task for Displace<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.of.displace(self.fields);
    }
}

impl Choppy {
    #[inline(always)]
    fn displace<T: Real>(&self, fields: &mut Fields<T>) {
        let (k, offset) = (T::round_from(self.level_radpm), T::round_from(self.offset_m));
        let half = T::round_from(0.5);
        let n = fields.area.len();
        let [sxx, syy, sxy] = fields.stretch.each_ref().map(|column| &column[..n]);
        let [dx, dy] = fields.displacement_m.each_ref().map(|column| &column[..n]);
        let [u, v, w] = fields.velocity_mps.each_mut().map(|column| &mut column[..n]);
        let [ax, ay, az] = fields.acceleration_mps2.each_mut().map(Vec::as_mut_slice);
        let [slope_x, slope_y] = fields.slope.each_mut().map(|column| &mut column[..n]);
        let (height, area) = (&mut fields.height_m[..n], &mut fields.area[..n]);
        // Acceleration first: it needs the vertical velocity of linear waves.
        if ax.len() == n && ay.len() == n && az.len() == n {
            for i in 0..n {
                let speeds = u[i] * u[i] + v[i] * v[i] + w[i] * w[i];
                az[i] = az[i] + k * (speeds + height[i] * az[i] + dx[i] * ax[i] + dy[i] * ay[i]);
            }
        }
        for i in 0..n {
            let (h, [dx, dy]) = (height[i], [dx[i], dy[i]]);
            let ([xx, yy, xy], found) = unfolded([sxx[i], syy[i], sxy[i]]);
            let level_x = k * (h * slope_x[i] + xx * dx + xy * dy);
            let level_y = k * (h * slope_y[i] + xy * dx + yy * dy);
            let (gx, gy) = (slope_x[i] + level_x, slope_y[i] + level_y);
            let (along_x, along_y) = (T::one() + xx, T::one() + yy);
            slope_x[i] = (along_y * gx - xy * gy) / found;
            slope_y[i] = (along_x * gy - xy * gx) / found;
            height[i] = h + half * k * (h * h + dx * dx + dy * dy) + offset;
            w[i] = w[i] + k * (h * w[i] + dx * u[i] + dy * v[i]);
            area[i] = found;
        }
    }
}

/// The gradient of the displacement, xx, yy, xy, without folds, and the area that is left.
#[inline(always)]
fn unfolded<T: Real>([xx, yy, xy]: [T; 3]) -> ([T; 3], T) {
    let (trace, determinant) = (xx + yy, xx * yy - xy * xy);
    let area = T::one() + trace + determinant;
    // Both stretches are negative in the second case, and their product is not.
    if area.widen() >= LEAST_AREA && trace.widen() > -1.0 {
        return ([xx, yy, xy], area);
    }
    let share = T::round_from(share(trace.widen(), determinant.widen()));
    let reduced = [xx * share, yy * share, xy * share];
    (reduced, T::one() + trace * share + determinant * share * share)
}

/// Least share of a gradient of a trace and a determinant at which the area is as small as allowed; at most
/// 1.
fn share(trace: f64, determinant: f64) -> f64 {
    let room = 1.0 - LEAST_AREA;
    // The gradient is symmetric: its discriminant is not negative but for rounding.
    let root = (trace * trace - 4.0 * determinant * room).max(0.0).sqrt();
    let share = 2.0 * room / (root - trace);
    if share > 0.0 { share.min(1.0) } else { 1.0 }
}
