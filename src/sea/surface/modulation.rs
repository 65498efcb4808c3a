//! How long waves modulate short ones: the relaxation-rate model.
//!
//! A long wave `z = Re a e^{j(K.x - omega t)}` stretches and contracts the surface. Short waves of wave
//! vector `k` along a unit direction `b` gain energy where it contracts, and relax to their equilibrium with
//! the wind at a rate `mu` (Keller and Wright 1975; Alpers and Hasselmann 1978): their spectral density is
//! `Psi (1 + m)`, `m = Re R a e^{j(K.x - omega t)}`,
//!
//! `R = 4.5 (K.b)^2/K q omega (omega - j mu)/(omega^2 + mu^2)`.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `R` | transfer function of the height (Alpers, Ross and Rufenach 1981: `q = 1`) | 1/m |
//! | `q` | horizontal over vertical orbital motion, `coth(K d)`: the contraction is that of the water | 1 |
//! | `4.5` | minus the logarithmic slope of the action of short waves, `Psi ~ k^-4` | 1 |
//! | `mu` | relaxation rate | 1/s |
//!
//! `mu -> 0` puts most short waves on the crests; what `mu` delays puts them on the forward faces, so that
//! a sea is rougher where it leans downwind.
//!
//! `R` is quadratic in `b`: `m = M_xx b_x^2 + M_yy b_y^2 + 2 M_xy b_x b_y` with three fields that no
//! direction enters ([`Fields::modulation`](super::Fields)). They modulate by the positive factor of a facet
//!
//! `exp(m - s^2/2)`, `s^2` the variance of `m` over the sea ([`Strength`]):
//!
//! mean 1 and covariance with slopes and velocities exactly that of `1 + m`, since `m` is Gaussian.
//! The exponent ends at +-[`MOST`]. Limits: `K << k`; one rate for all facets of a run; waves of ships
//! modulate nothing; no feedback of the waves on the wind.
//!
//! ```
//! use nereus::sea::surface::modulation::{look, transfer_per_m};
//! // A wave of 6 s: most roughness 32 degrees ahead of the crest.
//! let r = transfer_per_m([0.112, 0.0], 1.0 / 0.112, 1.048, 0.65, look([1.0, 0.0]));
//! assert!((r.arg().to_degrees() + 31.8).abs() < 0.1 && r.norm() > 0.4);
//! ```

use num_complex::Complex64;

use super::Surface;
use super::fields::Real;

/// Minus the logarithmic slope of the action of short waves.
pub const CONTRACTION: f64 = 4.5;
/// Largest exponent of a factor: 13 dB.
pub const MOST: f64 = 3.0;
/// Keeps what no wave has finite: square of a frequency, 1/s^2, and of a horizontal direction.
pub const TINY: f64 = 1e-9;

/// `omega (omega - j mu)/(omega^2 + mu^2)`, real and imaginary part.
#[inline(always)]
pub(super) fn parts<T: Real>(omega_rad_s: T, relaxation_per_s: T) -> (T, T) {
    let square = omega_rad_s * omega_rad_s;
    let scale = T::one() / (square + relaxation_per_s * relaxation_per_s + T::round_from(TINY));
    (square * scale, -(omega_rad_s * relaxation_per_s * scale))
}

/// What a direction takes of the tensor: `b_x^2, b_y^2, 2 b_x b_y`, `b` the direction of a Bragg wave vector
/// or of the vector `k_s - k_i` it is the horizontal part of. Nothing from straight above.
#[inline]
pub fn look([x, y]: [f64; 2]) -> [f64; 3] {
    let scale = 1.0 / (x * x + y * y + TINY);
    [x * x * scale, y * y * scale, 2.0 * x * y * scale]
}

/// Transfer function, 1/m, of a wave vector, rad/m, with its `q/K`, m, for a [`look`].
pub fn transfer_per_m(
    [kx, ky]: [f64; 2],
    excursion_m: f64,
    omega_rad_s: f64,
    relaxation_per_s: f64,
    look: [f64; 3],
) -> Complex64 {
    let (re, im) = parts(omega_rad_s, relaxation_per_s);
    let stretch = kx * kx * look[0] + ky * ky * look[1] + kx * ky * look[2];
    CONTRACTION * excursion_m * stretch * Complex64::new(re, im)
}

/// Covariance of the tensor's entries over the waves of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Strength {
    /// Of xx, yy, xy.
    pub covariance: [[f64; 3]; 3],
}

impl Strength {
    /// Of a surface whose short waves relax at a rate, 1/s: a mean over all its places and times.
    pub fn of(surface: &Surface, relaxation_per_s: f64) -> Self {
        let (grid, dispersion) = (surface.grid(), surface.dispersion());
        let dk = grid.wave_number_step_rad_m();
        let mut covariance = [[0.0; 3]; 3];
        for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
            for (j, amplitude) in row.iter().enumerate() {
                let (Some(mx), Some(my)) = (grid.wave_index_x(i), grid.wave_index_y(j)) else { continue };
                let energy = 2.0 * amplitude.norm_sqr();
                if energy == 0.0 {
                    continue;
                }
                let [kx, ky] = [mx as f64 * dk[0], my as f64 * dk[1]];
                let k = kx.hypot(ky);
                let (re, im) = parts(dispersion.angular_frequency_rad_s(k), relaxation_per_s);
                let scale = CONTRACTION * dispersion.excursion_ratio(k) / k;
                let power = energy * scale * scale * (re * re + im * im);
                let entries = [kx * kx, ky * ky, kx * ky];
                for (a, row) in entries.iter().zip(&mut covariance) {
                    for (b, sum) in entries.iter().zip(row) {
                        *sum += power * a * b;
                    }
                }
            }
        }
        Self { covariance }
    }

    /// Variance of `m` for a [`look`].
    #[inline]
    pub fn variance(&self, look: [f64; 3]) -> f64 {
        let of_row = |row: &[f64; 3]| row[0] * look[0] + row[1] * look[1] + row[2] * look[2];
        let [a, b, c] = self.covariance.each_ref().map(of_row);
        a * look[0] + b * look[1] + c * look[2]
    }

    /// Factor on the density of Bragg waves, where the map has the tensor xx, yy, xy.
    #[inline]
    pub fn factor(&self, tensor: [f64; 3], look: [f64; 3]) -> f64 {
        let m = tensor[0] * look[0] + tensor[1] * look[1] + tensor[2] * look[2];
        (m - 0.5 * self.variance(look)).clamp(-MOST, MOST).exp()
    }
}
