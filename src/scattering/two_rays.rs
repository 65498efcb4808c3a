//! The straight ray to a facet, and the one that the water before it reflects.
//!
//! At a grazing angle `psi` the mean sea reflects a wave almost wholly and turns its sign. A facet at the
//! height `z` that leans towards the antenna is met by both waves; one-way, its field is that of the straight
//! ray times
//!
//! `F = |1 - rho g e^{-2 j k z sin psi}|`
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `k` | wave number | rad/m |
//! | `z` | height above the mean sea | m |
//! | `rho` | share of the reflected field that waves leave coherent ([`roughness`](super::roughness)) | |
//! | `g` | amplitude that the facet returns of the reflected wave, over that of the straight one | |
//!
//! Near grazing a facet returns an amplitude as the cosine of its local angle, `s + tan psi` for its slope
//! `s` towards the antenna, and `s - tan psi` from below: `g` is the ratio of both (none below 0), averaged
//! over the tilts within the facet by the rule of [`two_scale`](super::two_scale). So smooth level water has
//! `F = 1`: its own reflection is in its scattering already.
//!
//! Over Gaussian heights of the deviation `h`, `F^2` tends to `(2 k h sin psi)^2` as the angle falls,
//! Katzin's critical angle (Proc. IRE 45 (1957) 44): both ways together the echo falls as its fourth power.
//! With heights of `2.5 h` from crest to trough that is the interference factor of the Georgia Tech model
//! (Horst, Dyer and Tuley 1978) less 2 dB one-way at most (as recalled).
//!
//! Limits: a coefficient of -1, that of both polarisations at grazing (V in X band: -0.95 at 0.2 degrees,
//! -0.75 at 1 degree); the phase is left out; standard atmosphere: a duct fills what interference takes away.
//!
//! ```
//! use nereus::scattering::two_rays::TwoRays;
//! let rays = TwoRays { wavenumber_radpm: 200.0, height_rms_m: 0.5, slope_rms: 0.1 };
//! // A crest leans towards an antenna at 0.1 degrees; level water seen from 20 degrees.
//! let sine = 0.1f64.to_radians().sin();
//! assert!((rays.field(0.3, sine, 0.2) - 2.0 * (200.0 * 0.3 * sine).sin()).abs() < 0.03);
//! assert_eq!(rays.field(0.3, 0.34, 0.0), 1.0);
//! ```

use super::roughness::coherent;

/// Nodes of the tilts within a facet, in standard deviations, and their weights.
const TILTS: [(f64, f64); 3] =
    [(-1.732_050_807_568_877_2, 1.0 / 6.0), (0.0, 2.0 / 3.0), (1.732_050_807_568_877_2, 1.0 / 6.0)];

/// A sea that reflects before its own facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoRays {
    /// Wave number of the carrier, rad/m.
    pub wavenumber_radpm: f64,
    /// Standard deviation of the height of the sea, m.
    pub height_rms_m: f64,
    /// Standard deviation of the slopes within a facet, along one axis.
    pub slope_rms: f64,
}

impl TwoRays {
    /// Field at a facet over that of the straight ray, 0 to 2: of its height above the mean sea, m, the sine
    /// of the grazing angle, and its slope towards the antenna. 1 below the horizon and for what is not a
    /// number.
    pub fn field(&self, height_m: f64, grazing_sine: f64, slope: f64) -> f64 {
        if grazing_sine.is_nan() || grazing_sine <= 0.0 {
            return 1.0;
        }
        let tangent = grazing_sine / (1.0 - grazing_sine * grazing_sine).max(0.0).sqrt();
        let returned = |slope: f64| -> f64 {
            TILTS.iter().map(|(tilt, weight)| weight * (slope + tilt * self.slope_rms).max(0.0)).sum()
        };
        let mirrored = returned(slope - tangent);
        if mirrored <= 0.0 {
            return 1.0;
        }
        let share = coherent(self.wavenumber_radpm, self.height_rms_m, grazing_sine) * mirrored
            / returned(slope + tangent);
        let phase = 2.0 * self.wavenumber_radpm * height_m * grazing_sine;
        // |1 - share e^{j phase}|, without cancelling where both rays nearly do.
        let field = (1.0 - share).hypot(2.0 * share.max(0.0).sqrt() * (0.5 * phase).sin());
        if field.is_finite() { field } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAYS: TwoRays = TwoRays { wavenumber_radpm: 200.0, height_rms_m: 0.5, slope_rms: 0.1 };

    /// Mean of the one-way power over Gaussian heights, of facets much steeper than the rays.
    fn mean_power(rays: &TwoRays, sine: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for n in -600..=600 {
            let t = f64::from(n) / 100.0;
            let weight = (-0.5 * t * t).exp();
            sum += weight * rays.field(t * rays.height_rms_m, sine, 100.0).powi(2);
            weights += weight;
        }
        sum / weights
    }

    #[test]
    fn the_mean_over_heights_is_the_closed_form() {
        for sine in [1e-5, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2] {
            let x = 2.0 * (RAYS.wavenumber_radpm * RAYS.height_rms_m * sine).powi(2);
            let rho = coherent(RAYS.wavenumber_radpm, RAYS.height_rms_m, sine);
            // E cos(2 k z sin psi) of a normal z.
            let expected = 1.0 - 2.0 * rho * (-x).exp() + rho * rho;
            let found = mean_power(&RAYS, sine);
            // The share of a slope of 100 is short of one by twice the sine over it.
            assert!((found / expected - 1.0).abs() < 2e-2, "{sine}: {found} {expected}");
        }
    }

    #[test]
    fn it_falls_as_the_interference_factor_of_the_georgia_tech_model() {
        let [k, h] = [RAYS.wavenumber_radpm, RAYS.height_rms_m];
        let wavelength_m = std::f64::consts::TAU / k;
        for sine in [1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1] {
            // sigma_phi of crests 2.5 h above troughs; one way is the root of the factor.
            let s = (14.4 * wavelength_m + 5.5) * sine * 2.5 * h / wavelength_m;
            let theirs = s.powi(2) / (1.0 + s.powi(4)).sqrt();
            let apart_db = 10.0 * (mean_power(&RAYS, sine) / theirs).log10();
            assert!(apart_db.abs() < 2.0, "{sine}: {apart_db} dB");
        }
        // Both ways: the fourth power of the angle.
        let fall = mean_power(&RAYS, 1e-4) / mean_power(&RAYS, 1e-5);
        assert!((10.0 * fall.powi(2).log10() - 40.0).abs() < 0.1, "{fall}");
    }

    #[test]
    fn only_what_leans_towards_the_antenna_is_met_by_both() {
        let level = TwoRays { slope_rms: 0.0, ..RAYS };
        for sine in [1e-6, 1e-3, 0.1, 1.0] {
            for slope in [0.0, -0.2, 0.5 * sine] {
                assert_eq!(level.field(0.3, sine, slope), 1.0, "{sine} {slope}");
            }
        }
        // Steeper than the ray by more and more: from the straight ray alone to both.
        let at = |slope: f64| level.field(0.0, 1e-3, slope);
        assert!(at(0.001_1) > at(0.002) && at(0.002) > at(0.01) && at(0.1) < 0.1);
        for (height_m, sine, slope) in
            [(f64::NAN, 1e-3, 0.1), (0.1, f64::NAN, 0.1), (0.1, 1e-3, f64::NAN), (0.1, -1e-3, 0.1)]
        {
            assert_eq!(RAYS.field(height_m, sine, slope), 1.0);
        }
        for sine in [1e-9, 0.5, 1.0, 1.0 + 1e-15] {
            assert!((0.0..=2.0).contains(&RAYS.field(10.0, sine, 1.0)));
        }
    }
}
