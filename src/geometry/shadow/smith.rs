//! How much of a sea two antennas see on average, where no map says which facets hide each other.
//!
//! Of a Gaussian surface of slope deviation `s` along the line of sight, seen at the grazing angle `psi`,
//! a place that does not turn away is seen with the probability `1/(1 + L(psi))`,
//!
//! `L = [sqrt(2/pi) (s/mu) e^{-mu^2/(2 s^2)} - erfc(mu/(sqrt(2) s))]/2`, `mu = tan(psi)`
//!
//! (B. G. Smith, IEEE Trans. Antennas Propag. 15 (1967) 668). By two antennas it is seen with
//! `1/(1 + L_1 + L_2 - r min(L_1, L_2))`: `r = 1` where both look along one azimuth, since the higher one
//! then sees all that the lower one does, `r = 0` where they are independent (C. Bourlier, G. Berginc and
//! J. Saillard, IEEE Trans. Antennas Propag. 50 (2002) 312). Between, `r` is the cosine of the angle between
//! both azimuths, at least 0.
//!
//! Limits: Gaussian slopes, independent of heights.
//!
//! ```
//! use nereus::geometry::shadow::smith::{lambda, seen};
//! // At a grazing angle of the slopes' deviation 8 in a hundred are hidden, far below nearly all.
//! assert!((seen([lambda(0.1, 0.1); 2], 1.0) - 0.923).abs() < 1e-3);
//! assert!(seen([lambda(0.001, 0.1); 2], 1.0) < 0.03);
//! assert_eq!(seen([lambda(1.0, 0.0); 2], 1.0), 1.0);
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

/// Share that both antennas see of what turns away from neither.
pub fn seen([one, other]: [f64; 2], common: f64) -> f64 {
    let (low, high) = (one.min(other), one.max(other));
    if high.is_finite() { 1.0 / (1.0 + high + (1.0 - common.clamp(0.0, 1.0)) * low) } else { 0.0 }
}
