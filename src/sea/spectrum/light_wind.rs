//! Short waves in light wind: none below a threshold, and never fewer in more wind.
//!
//! Elfouhaily's long waves were fitted to `K < 10 kp`. In light wind their branch reaches the Bragg waves of
//! a radar, which then *grow* as the wind falls: at 300 rad/m from 3 to 1 m/s by 6 dB. What scatters is
//! therefore `F Psi`:
//!
//! * **Growth**: at every K, along and across the wind, let `U_m` be the wind, of those up to 12 m/s, beyond
//!   which `Psi` only grows. In less wind short waves are in equilibrium with it, `Psi(U) = Psi(U_m) u*/u*_m`
//!   (Phillips 1985, 1988), or as published where that is less. From 5 to 15 rad/m the law comes in gradually
//!   (raised cosine of `ln K`): longer waves stay as published. (Elfouhaily, and with Fung and Lee's
//!   spreading.)
//! * **Threshold**: the wind feeds a wave at the rate `0.04 (u*/c)^2 omega` (Plant 1982), viscosity drains it
//!   at `4 nu K^2`; below `u*_t = c sqrt(100 nu K^2/omega)` it dies (Donelan and Pierson 1987). 8 cm/s at 300
//!   rad/m. Shorter waves than the slowest, of 370 rad/m, ride on those and share their threshold. Gusts of
//!   25 % smooth it (Plant 2000): a factor `N((u*/u*_t - 1)/0.25)`, `N` the normal law.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `u*` | friction velocity of Wu's drag | m/s |
//! | `c`, `omega` | phase speed, angular frequency, with surface tension | m/s, rad/s |
//! | `nu` | viscosity of water, 1.05e-6 | m^2/s |
//!
//! Above twice the threshold and above `U_m` (at most 8 m/s from 20 rad/m on) the factor is 1. Heights of the
//! map are not changed.
//!
//! ```
//! use nereus::scene::water::{Development, SpectrumKind, WindProfile};
//! use nereus::sea::spectrum::{LightWind, Spectrum, WaveVector};
//! use nereus::sea::wind::Wind;
//! let kind = SpectrumKind::Elfouhaily { development: Development::default() };
//! let psi = |u10_mps| {
//!     let wind = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, 0.0)?;
//!     let sea = LightWind::new(&kind, &wind)?;
//!     Ok::<_, Box<dyn std::error::Error>>(sea.symmetric_m4(WaveVector::new(300.0, 0.0)))
//! };
//! assert!(psi(1.0)? < psi(3.0)? && psi(3.0)? < psi(10.0)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::spreading::Heading;
use super::{Combined, Spectrum, SpectrumError, SwellTrain, WaveVector, of_kind};
use crate::scene::water::{SpectrumKind, Water, WindProfile};
use crate::sea::dispersion::CAPILLARY_PEAK_RAD_M;
use crate::sea::spectrum::spreading::phase_speed_mps;
use crate::sea::wind::{CALM_BELOW_MPS, Wind};

/// Viscosity of water at 18 degrees Celsius, m^2/s.
const VISCOSITY_M2PS: f64 = 1.05e-6;
/// Plant's growth rate over `(u*/c)^2 omega`.
const GROWTH: f64 = 0.04;
/// Standard deviation of the wind over its mean.
const GUSTS: f64 = 0.25;
/// Where the law of growth begins and where it holds whole, rad/m.
const GROWN_RADPM: [f64; 2] = [5.0, 15.0];
/// Strongest wind that is compared, m/s at 10 m. (In a gale the crosswind part of Elfouhaily's short waves
/// falls with more wind, as his spreading narrows: that is no matter of light wind.)
const FRESH_MPS: f64 = 12.0;
/// Winds that are compared.
const WINDS: usize = 96;
/// Wave numbers of the table: from, to, rad/m, and how many.
const FROM_RADPM: f64 = 1.0;
const TO_RADPM: f64 = 1e4;
const NODES: usize = 256;

/// Friction velocity below which a wave dies, m/s.
pub fn threshold_mps(k_rad_m: f64) -> f64 {
    let k = k_rad_m.min(CAPILLARY_PEAK_RAD_M);
    let c = phase_speed_mps(k);
    c * (4.0 * VISCOSITY_M2PS * k / (GROWTH * c)).sqrt()
}

/// Rate at which a wave returns to its equilibrium with the wind, 1/s: that of its growth (Plant 1982, 1989),
/// or of its decay by viscosity where that is faster.
pub fn relaxation_per_s(k_rad_m: f64, ustar_mps: f64) -> f64 {
    let c = phase_speed_mps(k_rad_m);
    (GROWTH * (ustar_mps / c).powi(2) * c * k_rad_m).max(4.0 * VISCOSITY_M2PS * k_rad_m * k_rad_m)
}

/// Share of a wave that winds about a friction velocity sustain, 0 to 1.
fn sustained(k_rad_m: f64, ustar_mps: f64) -> f64 {
    let deviation = (ustar_mps / threshold_mps(k_rad_m) - 1.0) / GUSTS;
    0.5 * libm::erfc(-deviation * std::f64::consts::FRAC_1_SQRT_2)
}

/// How far the law of growth holds, 0 to 1.
fn grown(k_rad_m: f64) -> f64 {
    let [from, to] = GROWN_RADPM;
    let share = ((k_rad_m / from).ln() / (to / from).ln()).clamp(0.0, 1.0);
    0.5 * (1.0 - (std::f64::consts::PI * share).cos())
}

/// A wind sea as radars see it.
#[derive(Debug)]
pub struct LightWind {
    wind_sea: Box<dyn Spectrum>,
    heading: Heading,
    /// By wave number: factor along the wind, factor across, anisotropy of the wind sea.
    rows: Vec<[f64; 3]>,
}

impl LightWind {
    /// The wind sea of a kind and a wind.
    ///
    /// # Errors
    /// Those of the spectrum.
    pub fn new(kind: &SpectrumKind, wind: &Wind) -> Result<Self, SpectrumError> {
        let wind_sea = of_kind(kind, wind)?;
        let heading = Heading::new(wind.direction_rad);
        let winds = match kind {
            _ if wind.is_calm() => return Ok(Self { wind_sea, heading, rows: Vec::new() }),
            SpectrumKind::Elfouhaily { .. } | SpectrumKind::ElfouhailyFungLee { .. } => winds(kind, wind),
            _ => Vec::new(),
        };
        let axes = [wind.direction_rad, wind.direction_rad + std::f64::consts::FRAC_PI_2];
        let row = |node: usize| {
            let k = FROM_RADPM * (TO_RADPM / FROM_RADPM).powf(node as f64 / (NODES - 1) as f64);
            let sustained = sustained(k, wind.ustar_wu_mps);
            let own = axes.map(|azimuth| wind_sea.symmetric_m4(WaveVector::polar(k, azimuth)));
            let [along, across] = [0, 1].map(|axis| {
                let of_wind = |(x, sea): &(f64, Box<dyn Spectrum>)| {
                    (*x, sea.symmetric_m4(WaveVector::polar(k, axes[axis])).ln())
                };
                let curve: Vec<(f64, f64)> = winds.iter().map(of_wind).collect();
                sustained * (grown(k) * excess(&curve, wind.ustar_wu_mps.ln(), own[axis].ln())).exp()
            });
            let sum = own[0] + own[1];
            [along, across, if sum > 0.0 { (own[0] - own[1]) / sum } else { 0.0 }]
        };
        let rows = (0..NODES).map(row).collect();
        Ok(Self { wind_sea, heading, rows })
    }

    /// Factors along and across the wind, and anisotropy, at a wave number.
    fn row(&self, k_rad_m: f64) -> [f64; 3] {
        if self.rows.is_empty() || k_rad_m.is_nan() || k_rad_m <= 0.0 {
            return [1.0, 1.0, 0.0];
        }
        let place = (k_rad_m / FROM_RADPM).ln() / (TO_RADPM / FROM_RADPM).ln() * (NODES - 1) as f64;
        let place = place.clamp(0.0, (NODES - 1) as f64);
        let node = (place as usize).min(NODES - 2);
        let share = place - node as f64;
        // Cubics without a kink: tables of what scatters are made from it.
        let at = |node: usize| &self.rows[node.min(NODES - 1)];
        let [before, low, high, after] = [at(node.saturating_sub(1)), at(node), at(node + 1), at(node + 2)];
        std::array::from_fn(|i| {
            let rise = high[i] - low[i];
            let [bend, unbend] = [high[i] - before[i], after[i] - low[i]].map(|of_two| 0.5 * of_two - rise);
            let value = low[i] + share * (rise + (1.0 - share) * (bend * (1.0 - share) - unbend * share));
            // Factors, and a share of the sum.
            if i < 2 { value.max(0.0) } else { value.clamp(-1.0, 1.0) }
        })
    }

    /// Factor on the density at a wave vector.
    fn factor(&self, k: WaveVector) -> f64 {
        let [along, across, e] = self.row(k.magnitude());
        let [x, y] = self.heading.resolve(k);
        let weights = [(1.0 + e) * x * x, (1.0 - e) * y * y];
        let sum = weights[0] + weights[1];
        if sum > 0.0 { (along * weights[0] + across * weights[1]) / sum } else { 1.0 }
    }

    /// Its mean over directions.
    fn mean_factor(&self, k_rad_m: f64) -> f64 {
        let [along, across, e] = self.row(k_rad_m);
        0.5 * (along * (1.0 + e) + across * (1.0 - e))
    }

    fn share(&self, k: WaveVector) -> f64 {
        let mean = self.mean_factor(k.magnitude());
        if mean > 0.0 { self.factor(k) / mean } else { 1.0 }
    }
}

/// Seas of the same kind in other winds, with the logarithm of their friction velocity.
fn winds(kind: &SpectrumKind, wind: &Wind) -> Vec<(f64, Box<dyn Spectrum>)> {
    let speed = |i: usize| CALM_BELOW_MPS * (FRESH_MPS / CALM_BELOW_MPS).powf(i as f64 / (WINDS - 1) as f64);
    let of_speed = |u10_mps: f64| {
        let other = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, wind.direction_rad).ok()?;
        // A fetch may be too short for a stronger wind: those are not compared.
        Some((other.ustar_wu_mps.ln(), of_kind(kind, &other).ok()?))
    };
    // The first is a hair above calm.
    (0..WINDS).filter_map(|i| of_speed(speed(i) * (1.0 + 1e-9))).collect()
}

/// Logarithm of the law of growth over the density, at most 0, given the logarithm of the density over that
/// of the friction velocity.
fn excess(curve: &[(f64, f64)], ln_ustar: f64, ln_density: f64) -> f64 {
    let Some(last) = (1..curve.len()).rev().find(|&i| curve[i].1 < curve[i - 1].1) else {
        return 0.0;
    };
    let (x, y) = match curve.get(last + 1) {
        Some(&after) => lowest([curve[last - 1], curve[last], after]),
        None => curve[last],
    };
    if ln_ustar >= x || !ln_density.is_finite() {
        return 0.0;
    }
    (y + ln_ustar - x - ln_density).min(0.0)
}

/// Where the parabola through three points, the lowest in the middle, is lowest.
fn lowest([a, b, c]: [(f64, f64); 3]) -> (f64, f64) {
    let (left, right) = ((b.1 - a.1) / (b.0 - a.0), (c.1 - b.1) / (c.0 - b.0));
    let curvature = (right - left) / (c.0 - a.0);
    if !(curvature > 0.0 && curvature.is_finite()) {
        return b;
    }
    // Slope at b, and the way from there to where it is 0.
    let slope = left + curvature * (b.0 - a.0);
    let step = (-0.5 * slope / curvature).clamp(a.0 - b.0, c.0 - b.0);
    (b.0 + step, b.1 + step * (slope + curvature * step))
}

impl Spectrum for LightWind {
    fn omnidirectional_m3(&self, k_rad_m: f64) -> f64 {
        self.wind_sea.omnidirectional_m3(k_rad_m) * self.mean_factor(k_rad_m)
    }

    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.wind_sea.spreading_per_rad(k) * self.share(k)
    }

    fn symmetric_spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.wind_sea.symmetric_spreading_per_rad(k) * self.share(k)
    }

    fn wave_m4(&self, k: WaveVector) -> f64 {
        self.wind_sea.wave_m4(k) * self.factor(k)
    }

    fn symmetric_m4(&self, k: WaveVector) -> f64 {
        self.wind_sea.symmetric_m4(k) * self.factor(k)
    }

    fn peak_rad_m(&self) -> f64 {
        self.wind_sea.peak_rad_m()
    }

    fn smooth_from_rad_m(&self) -> f64 {
        self.wind_sea.smooth_from_rad_m()
    }
}

/// The spectrum that scatters where it is not that of the heights: a law's wind sea with every swell train. A
/// measured spectrum scatters as it is: its tail already knows the threshold.
///
/// # Errors
/// Those of the spectrum.
pub fn that_scatters(water: &Water, wind: &Wind) -> Result<Option<Box<dyn Spectrum>>, SpectrumError> {
    if matches!(water.spectrum, SpectrumKind::Measured { .. }) {
        return Ok(None);
    }
    let wind_sea: Box<dyn Spectrum> = Box::new(LightWind::new(&water.spectrum, wind)?);
    if water.swell.is_empty() {
        return Ok(Some(wind_sea));
    }
    let mut parts = vec![wind_sea];
    for swell in &water.swell {
        parts.push(Box::new(SwellTrain::new(swell, water.dispersion)?));
    }
    Ok(Some(Box::new(Combined::new(parts))))
}
