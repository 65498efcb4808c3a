//! Modulation of short waves as facets have it: by the waves of the map, and by those between map and cutoff.
//!
//! Waves of the map give each facet a factor of its own ([`Strength`](crate::sea::surface::modulation)).
//! Waves between the map and `K_cut` are tilts within the facet, which are rougher where they lean downwind.
//! The weights of the nine sub-facets, at nodes `n_u, n_c` in standard deviations along and across the wind,
//! become
//!
//! `w e^{g_u n_u + g_c n_c}/(N(g_u) N(g_c))`, `N(g) = 2/3 + cosh(sqrt(3) g)/3`,
//! `g_i = 1/s_i integral of Im R K_i Psi dK`:
//!
//! the covariance of roughness and slope over its standard deviation, from the transfer function `R` of the
//! waves of the map and the spectrum in the wave convention. So what the sea returns upwind and downwind does
//! not depend on the size of facets. The mean roughness stays. `g` ends at +-1.
//!
//! ```
//! use nereus::scattering::modulation::weight;
//! let nodes = [(0.0, 2.0 / 3.0), (-3f64.sqrt(), 1.0 / 6.0), (3f64.sqrt(), 1.0 / 6.0)];
//! let mean: f64 = nodes.iter().map(|(node, w)| w * weight([0.2, 0.0], [*node, 0.0])).sum();
//! let slope: f64 = nodes.iter().map(|(node, w)| w * node * weight([0.2, 0.0], [*node, 0.0])).sum();
//! assert!((mean - 1.0).abs() < 1e-12 && (slope - 0.2).abs() < 0.01);
//! ```

use super::slope_pdf::MeanSquareSlope;
use crate::scene::sea::Modulation;
use crate::scene::water::Dispersion;
use crate::sea::spectrum::light_wind::relaxation_per_s;
use crate::sea::surface::modulation::transfer_per_m;

/// Largest covariance over the standard deviation.
const MOST: f64 = 1.0;

/// Rate at which the Bragg waves of a radar relax, 1/s: that of waves seen at 45 degrees, `K = sqrt(2) k`.
pub fn of_bragg_waves_per_s(wavenumber_radpm: f64, ustar_mps: f64) -> f64 {
    relaxation_per_s(std::f64::consts::SQRT_2 * wavenumber_radpm, ustar_mps)
}

/// Rate of a choice, 1/s; `None` where nothing is modulated.
pub(super) fn rate_per_s(modulation: Modulation, wavenumber_radpm: f64, ustar_mps: f64) -> Option<f64> {
    match modulation {
        Modulation::Off => None,
        Modulation::Relaxation { rate_per_s } => {
            Some(rate_per_s.unwrap_or_else(|| of_bragg_waves_per_s(wavenumber_radpm, ustar_mps)))
        }
    }
}

/// Covariance of the roughness of sub-facets with their slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TiltBias {
    /// Along and across the wind, for each entry of a [`look`](crate::sea::surface::modulation::look) on the
    /// axes of the medium, over the standard deviation of the slope.
    pub(super) of: [[f64; 3]; 2],
}

impl TiltBias {
    /// Adds waves of a wave vector on the axes of the medium, rad/m, at an angle to the wind, and of a power,
    /// m^2, in the wave convention.
    pub(super) fn add(
        &mut self,
        k: [f64; 2],
        off_wind_rad: f64,
        power_m2: f64,
        dispersion: Dispersion,
        relaxation_per_s: f64,
    ) {
        let magnitude = k[0].hypot(k[1]);
        let (across, along) = off_wind_rad.sin_cos();
        let excursion_m = dispersion.excursion_ratio(magnitude) / magnitude;
        let omega = dispersion.angular_frequency_rad_s(magnitude);
        for (entry, look) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
            let r = transfer_per_m(k, excursion_m, omega, relaxation_per_s, look);
            self.of[0][entry] += r.im * magnitude * along * power_m2;
            self.of[1][entry] += r.im * magnitude * across * power_m2;
        }
    }

    /// The sum of what was added over the standard deviations of the slopes.
    pub(super) fn over(self, slopes: MeanSquareSlope) -> Self {
        let slopes = slopes.floored();
        let [up, cross] = [slopes.up.sqrt(), slopes.cross.sqrt()];
        Self { of: [self.of[0].map(|c| c / up), self.of[1].map(|c| c / cross)] }
    }

    /// `g` along and across the wind for a look on the axes of the medium.
    #[inline]
    pub fn at(&self, look: [f64; 3]) -> [f64; 2] {
        let of = |row: &[f64; 3]| row[0] * look[0] + row[1] * look[1] + row[2] * look[2];
        self.of.each_ref().map(|row| of(row).clamp(-MOST, MOST))
    }
}

/// Factor on the weight of a node, in standard deviations.
#[inline]
pub fn weight(bias: [f64; 2], node: [f64; 2]) -> f64 {
    let of = |g: f64, n: f64| (g * n).exp() / (2.0 / 3.0 + (3f64.sqrt() * g).cosh() / 3.0);
    of(bias[0], node[0]) * of(bias[1], node[1])
}
