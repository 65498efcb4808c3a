//! Where the waves that tilt facets end and those that scatter begin.

use std::f64::consts::PI;

/// `H(K)`: 0 below the octave centred on the cutoff, 1 above it, a raised cosine in `log K` between.
///
/// ```
/// use nereus::scattering::splitting::high_pass;
/// assert_eq!((high_pass(7.0, 10.0), high_pass(15.0, 10.0)), (0.0, 1.0));
/// assert!((high_pass(10.0, 10.0) - 0.5).abs() < 1e-15);
/// ```
#[inline]
pub fn high_pass(wavenumber_radpm: f64, cut_radpm: f64) -> f64 {
    const HALF_OCTAVE: f64 = std::f64::consts::SQRT_2;
    if wavenumber_radpm >= cut_radpm * HALF_OCTAVE {
        1.0
    } else if wavenumber_radpm * HALF_OCTAVE <= cut_radpm {
        0.0
    } else {
        0.5 * (1.0 + (PI * (wavenumber_radpm / cut_radpm).log2()).sin())
    }
}
