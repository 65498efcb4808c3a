//! Physical constants, and decibels.
//!
//! Quantities carry their unit in the name (`carrier_hz`, `delay_s`, `range_m`); the few numbers
//! that are easy to mistake for one another at the door of a room are newtypes.

/// Speed of light in vacuum, m/s (exact).
pub const SPEED_OF_LIGHT_MPS: f64 = 299_792_458.0;
/// Boltzmann constant, J/K (exact).
pub const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;
/// Reference noise temperature T0, K (IEEE definition of the noise figure).
pub const NOISE_TEMPERATURE_K: f64 = 290.0;
/// Mean Earth radius used for the drop of the sea surface, m.
pub const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// One international foot, m (exact).
pub const FOOT_M: f64 = 0.3048;
/// One knot, m/s (exact).
pub const KNOT_MPS: f64 = 1852.0 / 3600.0;

/// A power ratio in decibels.
///
/// ```
/// use nereus::units::Decibels;
/// assert!((Decibels(3.0).power_ratio() - 1.995_262_314_968_88).abs() < 1e-12);
/// assert!((Decibels::from_power_ratio(100.0).0 - 20.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Decibels(pub f64);

impl Decibels {
    /// `10^(dB/10)`.
    pub fn power_ratio(self) -> f64 {
        10f64.powf(self.0 / 10.0)
    }

    /// `10^(dB/20)`.
    pub fn amplitude_ratio(self) -> f64 {
        10f64.powf(self.0 / 20.0)
    }

    /// `10 log10(ratio)`; minus infinity for zero.
    pub fn from_power_ratio(ratio: f64) -> Self {
        Self(10.0 * ratio.log10())
    }
}
