//! The radar equation in amplitude.
//!
//! For a path of legs R_t, R_r by way of a scatterer of matrix S (forward-scatter alignment, sqrt(m^2)):
//!
//! ```text
//! a = sqrt(P lambda^2 / ((4 pi)^3 L)) g_t g_r / (R_t R_r) (e_r^T S e_t) 10^(-alpha (R_t + R_r)/20)
//! ```
//!
//! and for the direct path
//!
//! ```text
//! a = sqrt(P lambda^2 / ((4 pi)^2 L)) g_t g_r / R (e_r^T e_t) 10^(-alpha R/20)
//! ```
//!
//! in sqrt(W), without the carrier phase. P: peak power, W; L: losses (power ratio); g: field gains; e: components (v, h)
//! of the ports' unit fields; alpha: one-way attenuation in dB per metre. `|a|^2 = P G_t G_r lambda^2 sigma /
//! ((4 pi)^3 R_t^2 R_r^2 L)`. A leg shorter than a wavelength counts as a wavelength: nothing is in the near field.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::scene::Radar;
use crate::units::Decibels;

/// The constants of a radar's paths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    wavelength_m: f64,
    scattered: f64,
    direct: f64,
    attenuation_db_per_m: f64,
}

impl Link {
    /// The constants for one watt.
    pub fn new(radar: &Radar) -> Self {
        let wavelength_m = radar.wavelength_m();
        let loss = Decibels(-radar.losses_db).amplitude_ratio();
        Self {
            wavelength_m,
            scattered: wavelength_m / (4.0 * PI).powf(1.5) * loss,
            direct: wavelength_m / (4.0 * PI) * loss,
            attenuation_db_per_m: radar.atmosphere_db_per_km * 1e-3,
        }
    }

    /// What multiplies `g_t g_r (e_r^T S e_t)` on a scattered path, sqrt(W)/m.
    pub fn scattered(&self, power_w: f64, tx_range_m: f64, rx_range_m: f64) -> f64 {
        let spread = tx_range_m.max(self.wavelength_m) * rx_range_m.max(self.wavelength_m);
        power_w.sqrt() * self.scattered / spread * self.air(tx_range_m + rx_range_m)
    }

    /// What multiplies `g_t g_r (e_r^T e_t)` on the direct path, sqrt(W).
    pub fn direct(&self, power_w: f64, range_m: f64) -> f64 {
        power_w.sqrt() * self.direct / range_m.max(self.wavelength_m) * self.air(range_m)
    }

    fn air(&self, path_m: f64) -> f64 {
        Decibels(-self.attenuation_db_per_m * path_m).amplitude_ratio()
    }
}

/// `e_r^T S e_t`, components in the order (v, h), rows of S received.
pub fn received(rx: [Complex64; 2], scattering: &[[Complex64; 2]; 2], tx: [Complex64; 2]) -> Complex64 {
    (0..2).map(|p| rx[p] * (scattering[p][0] * tx[0] + scattering[p][1] * tx[1])).sum()
}
