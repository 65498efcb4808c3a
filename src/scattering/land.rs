//! Land as constant-gamma clutter.
//!
//! `sigma0_pq = gamma_pq sqrt(sin a_i sin a_s)`, with the local grazing angles `a` of both rays on the facet
//! (`sigma0 = gamma sin a` in backscatter: Barton 1985, "Land clutter models for radar design and analysis",
//! Proc. IEEE 73(2), 198-204), times the facet's own area. The three of VV, HH and cross-polarisation have a
//! random phase each: they are uncorrelated. `S_hv = -S_vh` in forward-scatter alignment, so that the land
//! is reciprocal.
//!
//! Below about [`LEAST_GRAZING`] the law falls off: `sin a` becomes `sin^4 a / (sin a + LEAST_GRAZING)^3`
//! (-1.2 dB at ten times it), so that a facet that turns away fades smoothly.
//!
//! **Limits.** Median values of a kind of terrain: no buildings, no wind in the trees, no specular return
//! from steep faces.

use glam::DVec3;
use num_complex::Complex64;

use super::tilt::{NO_ECHO, Path, ScatterMatrix};
use crate::scene::Land;

/// Grazing angle, rad, at which the law is an eighth of constant gamma.
pub const LEAST_GRAZING: f64 = 1e-3;

/// How land scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandScattering {
    /// Roots of gamma of VV, HH and cross-polarisation.
    pub(super) root_gamma: [f64; 3],
}

impl LandScattering {
    /// That of a land.
    pub fn new(land: &Land) -> Self {
        let over_vv = [1.0, land.hh_over_vv, land.cross_over_vv];
        Self { root_gamma: over_vv.map(|ratio| (land.gamma * ratio).sqrt()) }
    }

    /// The matrix of a facet, sqrt(m^2), entries `[p][q]` (v, h), from unit directions to and from it, its
    /// slopes and its phasors of VV, HH and cross-polarisation.
    pub fn matrix(
        &self,
        [incident, scattered]: [DVec3; 2],
        slope: [f64; 2],
        footprint_m2: f64,
        phasors: [Complex64; 3],
    ) -> ScatterMatrix {
        let path = Path::new(incident, scattered);
        let upright = DVec3::new(-slope[0], -slope[1], 1.0);
        let Some((cos_i, cos_s)) = path.local_cosines(upright.normalize()) else { return NO_ECHO };
        let scale = (footprint_m2 * upright.length()).sqrt() * root_grazing(cos_i) * root_grazing(cos_s);
        let [vv, hh, cross] = [0, 1, 2].map(|i| phasors[i] * (scale * self.root_gamma[i]));
        [[vv, cross], [-cross, hh]]
    }
}

/// Fourth root of the law's sine of a grazing angle.
fn root_grazing(sine: f64) -> f64 {
    sine / (sine + LEAST_GRAZING).powf(0.75)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn land() -> LandScattering {
        LandScattering { root_gamma: [0.1f64, 0.08, 0.02].map(f64::sqrt) }
    }

    /// Backscatter at 30 degrees: gamma times the sine, within the fall-off of 0.03 dB.
    #[test]
    fn backscatter_is_gamma_times_the_sine_of_grazing() {
        let down = DVec3::new(0.75f64.sqrt(), 0.0, -0.5);
        let [[vv, vh], [hv, hh]] = land().matrix([down, -down], [0.0; 2], 4.0, [Complex64::I; 3]);
        let db = |power: f64, expected: f64| (10.0 * (power / expected).log10()).abs();
        assert!(db(vv.norm_sqr(), 4.0 * 0.1 * 0.5) < 0.03 && db(hh.norm_sqr(), 4.0 * 0.08 * 0.5) < 0.03);
        assert!(db(vh.norm_sqr(), 4.0 * 0.02 * 0.5) < 0.03);
        // Reciprocity in backscatter.
        assert_eq!(hv, -vh);
        // A slope towards the radar of 30 degrees: the ray comes at a right angle to it.
        let slope = -(60f64.to_radians().tan());
        let [[steep, _], _] = land().matrix([down, -down], [-slope, 0.0], 4.0, [Complex64::ONE; 3]);
        assert!(db(steep.norm_sqr(), 4.0 / 60f64.to_radians().cos() * 0.1) < 0.03);
    }

    #[test]
    fn what_turns_away_returns_nothing() {
        let low = DVec3::new(1.0, 0.0, -0.1).normalize();
        assert_eq!(land().matrix([low, -low], [-0.2, 0.0], 1.0, [Complex64::ONE; 3]), NO_ECHO);
    }
}
