//! Shapes of sea clutter as they were measured.
//!
//! Source: K. D. Ward, C. J. Baker, S. Watts, IEE Proc. F 137, 51 (1990), with the dependence on azimuth of
//! S. Watts, D. C. Wicks, IEEE Radar Conference 1990. Logarithms are decimal; the values that the MaRS paper
//! prints follow from natural ones.
//!
//! ```
//! use nereus::clutter::sea_shape;
//! assert!((sea_shape(1.0, [1.0, 0.75], 0.0, true) - 1.5814e-2).abs() < 1e-6);
//! ```

/// Grazing angles of the measurements, degrees.
pub const GRAZING_DEG: [f64; 2] = [0.1, 10.0];

/// Shape of sea clutter by Ward, Baker and Watts:
/// `log10 nu = (2/3) log10 g + (5/8) log10(D_a D_r / 4.2) - cos(2 psi)/3 - k_p`, `g` grazing angle in degrees
/// (0.1 to 10), `D_a`, `D_r` the resolution, m, `psi` from the direction of the swell, rad; `k_p` 1 for VV,
/// 1.7 for HH.
pub fn sea_shape(grazing_deg: f64, resolution_m: [f64; 2], psi_rad: f64, vertical: bool) -> f64 {
    let polarisation = if vertical { 1.0 } else { 1.7 };
    let log = 2.0 / 3.0 * grazing_deg.log10() + 0.625 * (resolution_m[0] * resolution_m[1] / 4.2).log10()
        - (2.0 * psi_rad).cos() / 3.0
        - polarisation;
    10f64.powf(log)
}
