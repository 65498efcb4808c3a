//! What waves leave of the field that the mean surface of the sea reflects.
//!
//! `rho = e^-x I_0(x)` , `x = 2 (k s sin psi)^2`
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `k` | wave number | rad/m |
//! | `s` | standard deviation of the height | m |
//! | `psi` | grazing angle | rad |
//! | `I_0` | modified Bessel function of the first kind: Abramowitz and Stegun, Handbook of Mathematical Functions (1964), 9.8.1 and 9.8.2, off by 2e-7 | |
//!
//! Source: Miller, Brown and Vegh, IEE Proc. F 131 (1984) 114, by the densities of heights at points that are
//! seen; measurements lie about it, and above Ament's `e^-x` (Proc. IRE 41 (1953) 142) for
//! `k s sin psi > 0.7`.
//!
//! Limits: the coherent field alone; what waves scatter about the specular direction is not in it.
//!
//! ```
//! use nereus::scattering::roughness::coherent;
//! assert_eq!(coherent(209.0, 0.0, 0.1), 1.0);
//! assert!((coherent(1.0, 0.5f64.sqrt(), 1.0) - 0.465_759_6).abs() < 1e-6);
//! ```

/// Coefficients of Abramowitz and Stegun 9.8.1 in `(x/3.75)^2`, and of 9.8.2 in `3.75/x`.
const NEAR: [f64; 7] = [1.0, 3.5156229, 3.0899424, 1.2067492, 0.2659732, 0.0360768, 0.0045813];
const FAR: [f64; 9] = [
    0.39894228,
    0.01328592,
    0.00225319,
    -0.00157565,
    0.00916281,
    -0.02057706,
    0.02635537,
    -0.01647633,
    0.00392377,
];

/// Share of the reflected field that stays coherent, at a wave number, rad/m, of waves of a standard
/// deviation, m.
pub fn coherent(wave_number_rad_m: f64, height_rms_m: f64, grazing_sine: f64) -> f64 {
    let x = 2.0 * (wave_number_rad_m * height_rms_m * grazing_sine).powi(2);
    let sum = |terms: &[f64], at: f64| terms.iter().rev().fold(0.0, |sum, term| sum * at + term);
    if x < 3.75 { (-x).exp() * sum(&NEAR, (x / 3.75).powi(2)) } else { sum(&FAR, 3.75 / x) / x.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_mean_over_a_sinusoid() {
        for x in [0.0, 1e-6, 0.3, 1.0, 3.0, 3.749, 3.751, 10.0, 200.0, 1e6] {
            // I_0(x) e^-x = mean of e^(x (cos t - 1)), by the trapezoidal rule of a periodic function.
            let points = 100_000;
            let term =
                |n: i32| (x * ((f64::from(n) / f64::from(points) * std::f64::consts::TAU).cos() - 1.0)).exp();
            let mean = (0..points).map(term).sum::<f64>() / f64::from(points);
            let found = coherent(1.0, (0.5 * x).sqrt(), 1.0);
            assert!((found - mean).abs() < 3e-7 * mean.max(0.1), "{x}: {found} {mean}");
        }
    }
}
