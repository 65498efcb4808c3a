//! How much of a sea two antennas see on average, where no map says which facets hide each other.
//!
//! Of a Gaussian surface of slope deviation `s` along the line of sight, seen at the grazing angle `psi`,
//! a place that does not turn away is seen with the probability `1/(1 + L(psi))`,
//!
//! `L = [sqrt(2/pi) (s/mu) e^{-mu^2/(2 s^2)} - erfc(mu/(sqrt(2) s))]/2`, `mu = tan(psi)`
//!
//! (B. G. Smith, IEEE Trans. Antennas Propag. 15 (1967) 668). At a height of `h` standard deviations it is
//! `Phi(h)^L`, `Phi` the normal distribution, of which that is the mean: crests are seen, and with them the
//! water that runs with the waves. Two antennas see it with the exponent `L_1 + L_2 - r min(L_1, L_2)`:
//! `r = 1` where both look along one azimuth, since the higher one then sees all that the lower one does,
//! `r = 0` where they are independent (C. Bourlier, G. Berginc and J. Saillard, IEEE Trans. Antennas Propag.
//! 50 (2002) 312). Between, `r` is the cosine of the angle between both azimuths, at least 0.
//!
//! Limits: Gaussian slopes, independent of heights.
//!
//! ```
//! use nereus::geometry::shadow::smith::{lambda, seen};
//! // At a grazing angle of the slopes' deviation 8 in a hundred of the mean level are hidden.
//! let both = |tangent, height| seen([lambda(tangent, 0.1); 2], 1.0, height);
//! assert!((both(0.1, 0.0) - 0.944).abs() < 1e-3);
//! // Far below it troughs, and no crest of three deviations.
//! assert!(both(0.005, -1.0) < 0.01 && both(0.005, 3.0) > 0.9);
//! assert_eq!(seen([lambda(1.0, 0.0); 2], 1.0, -3.0), 1.0);
//! ```

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// `L` of a tangent of the grazing angle and a deviation of slopes; infinite from below.
pub fn lambda(tangent: f64, slope_rms: f64) -> f64 {
    if slope_rms <= 0.0 {
        return if tangent > 0.0 { 0.0 } else { f64::INFINITY };
    }
    let v = tangent / slope_rms;
    if v <= 0.0 {
        return f64::INFINITY;
    }
    let hidden = (2.0 / PI).sqrt() / v * (-0.5 * v * v).exp() - libm::erfc(v * FRAC_1_SQRT_2);
    0.5 * hidden.max(0.0)
}

/// Share that both antennas see of what turns away from neither, at a height in standard deviations.
pub fn seen([one, other]: [f64; 2], common: f64, height: f64) -> f64 {
    let (low, high) = (one.min(other), one.max(other));
    let exponent = high + (1.0 - common.clamp(0.0, 1.0)) * low;
    if exponent == 0.0 {
        return 1.0;
    }
    let below = 0.5 * libm::erfc(-height * FRAC_1_SQRT_2);
    if exponent.is_finite() { below.powf(exponent) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over Gaussian heights the mean is `1/(1 + L)`.
    #[test]
    fn the_mean_over_heights_is_smiths() {
        for tangent in [0.01, 0.03, 0.1, 0.3] {
            let of = lambda(tangent, 0.1);
            let (mut sum, mut weight) = (0.0, 0.0);
            for n in -6000..=6000 {
                let h = f64::from(n) / 1000.0;
                let own = (-0.5 * h * h).exp();
                sum += own * seen([of; 2], 1.0, h);
                weight += own;
            }
            assert!((sum / weight * (1.0 + of) - 1.0).abs() < 1e-3, "{tangent}: {}", sum / weight);
        }
    }
}
