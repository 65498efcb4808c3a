//! The radar equation in amplitude.
//!
//! Over a scatterer with legs `R_t`, `R_r` and matrix `S` (sqrt(m^2)):
//!
//! `a = sqrt(P lambda^2 / ((4 pi)^3 L)) g_t g_r / (R_t R_r)  (e_r^T S e_t)  10^(-A (R_t + R_r) / 20)`
//! sqrt(W)
//!
//! and straight from transmitter to receiver over `R`:
//!
//! `a = sqrt(P lambda^2 / ((4 pi)^2 L)) g_t g_r / R  (e_r . e_t)  10^(-A R / 20)`
//!
//! with `P` the peak power per polarisation (W), `L` the system losses (ratio), `A` the one-way atmospheric
//! attenuation (dB/m), `g` field gains, `e` polarisation components ([`crate::radar::polarisation::field`]).
//! On the direct path transmitter and receiver share the direction `k` and its basis, so the product is that
//! of the two field vectors, `S = 1`. The carrier phase is not in `a`.
//!
//! **Limit.** Far field. A leg shorter than a wavelength carries nothing (a target in the antenna, a
//! receiver that shares the transmitter's phase centre): the equation would return more than was sent.
//!
//! ```
//! use nereus::radar::link::Link;
//! let link = Link::new(1.0, 0.03, 0.0, 0.0);
//! let a = link.scattered(3000.0, 3000.0);
//! let p = 0.03f64.powi(2) / ((4.0 * std::f64::consts::PI).powi(3) * 3000f64.powi(4));
//! assert!((a * a / p - 1.0).abs() < 1e-12);
//! ```

use std::f64::consts::PI;

use crate::geometry::light_time::Path;
use crate::scattering::lanes::exponential;
use crate::units::{Decibels, SPEED_OF_LIGHT_MPS};

/// The constants of one transmitter's link budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    scattered_scale: f64,
    direct_scale: f64,
    neper_per_m: f64,
    shortest_m: f64,
}

impl Link {
    /// From peak power (W), wavelength (m), system losses (dB) and one-way attenuation (dB/km).
    pub fn new(power_w: f64, wavelength_m: f64, losses_db: f64, atmosphere_db_per_km: f64) -> Self {
        let root = power_w.sqrt() * wavelength_m * Decibels(-losses_db).amplitude_ratio();
        Self {
            scattered_scale: root / (4.0 * PI).powf(1.5),
            direct_scale: root / (4.0 * PI),
            neper_per_m: atmosphere_db_per_km * 1e-3 * std::f64::consts::LN_10 / 20.0,
            shortest_m: wavelength_m,
        }
    }

    /// Amplitude over a scatterer of 1 m^2 between isotropic, matched antennas, sqrt(W).
    pub fn scattered(&self, tx_leg_m: f64, rx_leg_m: f64) -> f64 {
        if tx_leg_m < self.shortest_m || rx_leg_m < self.shortest_m {
            return 0.0;
        }
        self.scattered_scale / (tx_leg_m * rx_leg_m) * self.air(tx_leg_m + rx_leg_m)
    }

    /// The same over the legs of a path.
    pub fn scattered_over(&self, path: &Path) -> f64 {
        self.scattered(path.tx_leg_s * SPEED_OF_LIGHT_MPS, path.rx_leg_s * SPEED_OF_LIGHT_MPS)
    }

    /// Amplitude of the direct path between isotropic, matched antennas, sqrt(W).
    pub fn direct(&self, range_m: f64) -> f64 {
        if range_m < self.shortest_m {
            return 0.0;
        }
        self.direct_scale / range_m * self.air(range_m)
    }

    /// The same in f32, for facets side by side.
    pub fn in_air(&self) -> LaneLink {
        LaneLink {
            scale: self.scattered_scale as f32,
            neper_per_m: self.neper_per_m as f32,
            shortest_m: self.shortest_m as f32,
        }
    }

    fn air(&self, way_m: f64) -> f64 {
        if self.neper_per_m == 0.0 { 1.0 } else { (-self.neper_per_m * way_m).exp() }
    }
}

/// [`Link::scattered`] in f32, without branches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneLink {
    scale: f32,
    neper_per_m: f32,
    shortest_m: f32,
}

impl LaneLink {
    /// Amplitude over a scatterer of 1 m^2 between isotropic, matched antennas, sqrt(W).
    #[inline(always)]
    pub fn scattered(&self, tx_leg_m: f32, rx_leg_m: f32) -> f32 {
        let near = tx_leg_m < self.shortest_m || rx_leg_m < self.shortest_m;
        let spread = self.scale / (tx_leg_m.max(self.shortest_m) * rx_leg_m.max(self.shortest_m));
        let air = match self.neper_per_m {
            0.0 => 1.0,
            neper_per_m => exponential(-neper_per_m * (tx_leg_m + rx_leg_m)),
        };
        if near { 0.0 } else { spread * air }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        let (p, lambda, r_t, r_r) = (25e3, 0.032, 4100.0, 2900.0);
        let link = Link::new(p, lambda, 3.0, 0.01);
        let loss = 10f64.powf(0.3);
        let air = 10f64.powf(-0.01 * (r_t + r_r) / 1e3 / 10.0);
        let power = p * lambda * lambda / ((4.0 * PI).powi(3) * loss * (r_t * r_r).powi(2)) * air;
        assert!((link.scattered(r_t, r_r).powi(2) / power - 1.0).abs() < 1e-12);
        let friis = p * (lambda / (4.0 * PI * r_t)).powi(2) / loss * 10f64.powf(-0.01 * r_t / 1e4);
        assert!((link.direct(r_t).powi(2) / friis - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_from_inside_the_antenna() {
        let link = Link::new(1.0, 0.03, 0.0, 0.0);
        assert_eq!(
            (link.scattered(0.0, 100.0), link.scattered(100.0, 0.0), link.direct(0.0)),
            (0.0, 0.0, 0.0)
        );
    }
}
