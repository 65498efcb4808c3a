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
//! **Rain** attenuates H and V unlike each other ([`crate::radar::rain`]). `A` holds the least that it takes
//! of a level path, at H, V or circular polarisation; a channel has by its ports `p` and `q` in addition
//!
//! `10^(-(B_p(theta_t) R_t + B_q(theta_r) R_r) / 20)` ,
//! `B_p(theta) = gamma_circ + (gamma_p - gamma_circ) cos^2(theta) - A_rain` ,
//!
//! `theta` the elevation of a leg (the Recommendation's law to first order in what H and V differ by). On the
//! direct path each port has half of the way. The polarisation is what the port is named after, whatever the
//! tilt of the antenna; what leaks from the other one is attenuated as the port is, and rain turns none.
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
use std::ops::{Add, Mul, Neg, Sub};

use crate::geometry::light_time::Path;
use crate::radar::rain::Attenuation;
use crate::scattering::lanes::exponential;
use crate::scene::radar::{Polarisation, Radar};
use crate::units::{Decibels, SPEED_OF_LIGHT_MPS};

/// The constants of one transmitter's link budget.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    scattered_scale: f64,
    direct_scale: f64,
    neper_per_m: f64,
    rain: OfPorts<f64>,
    shortest_m: f64,
}

/// Attenuation of the field, 1/m.
fn neper_per_m(db_per_km: f64) -> f64 {
    db_per_km * 1e-3 * std::f64::consts::LN_10 / 20.0
}

impl Link {
    /// Of a radar's transmitter, in its air and rain.
    pub fn of(radar: &Radar, transmitter: usize) -> Self {
        let Attenuation { h, v, circular } = Attenuation::new(radar.carrier_hz, radar.rain_mmph);
        let least = h.min(v).min(circular);
        let rain = OfPorts {
            circular_per_m: neper_per_m(circular - least),
            level_per_m: [h, v].map(|own| neper_per_m(own - circular)),
        };
        let (power_w, air) = (radar.transmitters[transmitter].power_w, radar.atmosphere_db_per_km + least);
        Self { rain, ..Self::new(power_w, radar.wavelength_m(), radar.losses_db, air) }
    }

    /// From peak power (W), wavelength (m), system losses (dB) and one-way attenuation (dB/km).
    pub fn new(power_w: f64, wavelength_m: f64, losses_db: f64, atmosphere_db_per_km: f64) -> Self {
        let root = power_w.sqrt() * wavelength_m * Decibels(-losses_db).amplitude_ratio();
        Self {
            scattered_scale: root / (4.0 * PI).powf(1.5),
            direct_scale: root / (4.0 * PI),
            neper_per_m: neper_per_m(atmosphere_db_per_km),
            rain: OfPorts::default(),
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

    /// What rain leaves of the amplitude of a channel beyond [`Self::scattered`], whose ports are those of
    /// transmitter and receiver: over legs of such lengths, m, and sines of elevation.
    pub fn in_rain(&self, ports: [Polarisation; 2], legs_m: [f64; 2], rises: [f64; 2]) -> f64 {
        if self.rain == OfPorts::default() {
            return 1.0;
        }
        self.rain.neper(ports, legs_m, rises).exp()
    }

    /// The same of the legs of a path over a scatterer.
    pub fn in_rain_over(&self, ports: [Polarisation; 2], path: &Path) -> f64 {
        let legs_m = [path.tx_leg_s, path.rx_leg_s].map(|leg_s| leg_s * SPEED_OF_LIGHT_MPS);
        self.in_rain(ports, legs_m, [path.incident.z, path.scattered.z])
    }

    /// The same of the direct path.
    pub fn in_rain_direct(&self, ports: [Polarisation; 2], path: &Path) -> f64 {
        self.in_rain(ports, [0.5 * path.delay_s * SPEED_OF_LIGHT_MPS; 2], [path.incident.z; 2])
    }

    /// What rain takes of ports, in f32; `None` where it takes the same of all.
    pub fn lanes_in_rain(&self) -> Option<OfPorts<f32>> {
        let OfPorts { circular_per_m, level_per_m } = self.rain;
        (self.rain != OfPorts::default()).then(|| OfPorts {
            circular_per_m: circular_per_m as f32,
            level_per_m: level_per_m.map(|of| of as f32),
        })
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

/// What rain takes of the fields of ports beyond the least of all, 1/m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OfPorts<T> {
    circular_per_m: T,
    /// Of H and of V on a level path, beyond that of circular polarisation.
    level_per_m: [T; 2],
}

impl<T> OfPorts<T>
where
    T: Copy + From<f32> + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Neg<Output = T>,
{
    /// Logarithm of what is left of the amplitude of a channel.
    #[inline(always)]
    pub fn neper(&self, ports: [Polarisation; 2], legs_m: [T; 2], rises: [T; 2]) -> T {
        let of = |port: Polarisation| match port {
            Polarisation::H => self.level_per_m[0],
            Polarisation::V => self.level_per_m[1],
            Polarisation::R | Polarisation::L => T::from(0.0),
        };
        let [sent, received] = ports.map(of);
        let [tx, rx] = rises.map(|rise| T::from(1.0) - rise * rise);
        -((self.circular_per_m + sent * tx) * legs_m[0] + (self.circular_per_m + received * rx) * legs_m[1])
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
