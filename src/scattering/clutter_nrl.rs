//! The NRL sea clutter model: measured backscatter of the sea, put into one formula.
//!
//! Nothing of a scene is computed with it. It is what the facets are compared with (`docs/sigma0.md`).
//!
//! `sigma0 = c1 + c2 log10(sin g) + (27.5 + c3 g) log10(f) / (1 + 0.95 g)
//! + c4 (1 + s)^(1/(2 + 0.085 g + 0.033 s)) + c5 g^2` dB
//!
//! with `g` the grazing angle in degrees, `f` the carrier in GHz, `s` the sea state as Nathanson counts it
//! (0: wind below 4 knots) and
//!
//! | | c1 | c2 | c3 | c4 | c5 |
//! | --- | --- | --- | --- | --- | --- |
//! | HH | -73.0 | 20.781 | 7.351 | 25.65 | 0.0054 |
//! | VV | -50.796 | 25.93 | 0.7093 | 21.588 | 0.00211 |
//!
//! Source: Gregers-Hansen and Mital, An Improved Empirical Model for Radar Sea Clutter Reflectivity,
//! NRL/MR/5310--12-9346 (2012), equation 7 and the listing of its appendix B; also IEEE TAES 48, 3512 (2012).
//! Table 1 of the report rounds (20.78, -50.79, 21.58); the listing has one digit more. Confirmed by two
//! things made elsewhere: the worked example of the `seareflectivity` page of a commercial toolbox (HH, all
//! five digits it prints, which Table 1 misses), and the mean deviations that the report prints for both
//! polarisations, recomputed from Nathanson's 553 measured values. The last digit of `c1` and `c4` of VV (up
//! to 0.02 dB) rests on the listing alone.
//!
//! Limits: carrier 0.5 to 35 GHz, grazing angle 0.1 to 60 degrees, sea state 0 to 6 (fractions allowed), HH
//! and VV. It is a mean over upwind, downwind and crosswind, in decibels, and holds the shadows and the
//! propagation of the measurements. It was fitted to Nathanson's tables with a mean absolute deviation of 2.6
//! dB; single entries are 11 dB off.
//!
//! Sea state and wind, the report's equations 5 and 3, for a sea fully risen:
//!
//! `h = 0.04 + 0.1 s^2.1`, `U = 7.18 h^0.4`
//!
//! with `h` the significant wave height, m, and `U` the wind, m/s, at a height that is not stated (taken as
//! 10 m here). Sea states 0 to 6 are winds of 2.0 to 12.9 m/s. (Equation 4, the inverse of 3, is misprinted:
//! the exponent is 2.5.)
//!
//! ```
//! use nereus::scattering::clutter_nrl::{SeaState, sigma0};
//! // Moderate sea, X band, one degree.
//! let sea = SeaState::new(3.0)?;
//! let measured = sigma0(9.3e9, 1f64.to_radians(), sea)?;
//! assert!((10.0 * measured.hh.log10() + 43.8).abs() < 0.05);
//! assert!((sea.wind_mps() - 7.3).abs() < 0.05);
//! assert!(SeaState::of_wind(15.0).is_err());
//! # Ok::<(), nereus::scattering::clutter_nrl::ClutterError>(())
//! ```

use crate::units::Decibels;

/// Carriers of the measurements, GHz.
const CARRIERS_GHZ: [f64; 2] = [0.5, 35.0];
/// Grazing angles of the measurements, degrees.
pub const GRAZING_DEG: [f64; 2] = [0.1, 60.0];
/// Sea states of the measurements.
const SEA_STATES: [f64; 2] = [0.0, 6.0];

/// `c1` to `c5`, HH.
const HH: [f64; 5] = [-73.0, 20.781, 7.351, 25.65, 0.0054];
/// `c1` to `c5`, VV.
const VV: [f64; 5] = [-50.796, 25.93, 0.7093, 21.588, 0.00211];

/// A quantity lies outside the measurements behind the model.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("NRL sea clutter model: {quantity} is {value}{unit}, allowed {min} to {max}{unit}")]
pub struct ClutterError {
    /// Which quantity.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Least allowed value.
    pub min: f64,
    /// Greatest allowed value.
    pub max: f64,
    /// Unit of the three values, after a space; empty for a pure number.
    pub unit: &'static str,
}

/// A sea state as Nathanson counts it, 0 to 6.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct SeaState(f64);

impl SeaState {
    /// The sea state of a number, fractions allowed.
    ///
    /// # Errors
    /// A number that the model does not cover.
    pub fn new(number: f64) -> Result<Self, ClutterError> {
        within("sea state", number, SEA_STATES, "").map(|()| Self(number))
    }

    /// The sea state that a wind, m/s, raises in time.
    ///
    /// # Errors
    /// A wind that the model does not cover.
    pub fn of_wind(wind_mps: f64) -> Result<Self, ClutterError> {
        let [least_mps, most_mps] = SEA_STATES.map(|number| Self(number).wind_mps());
        if !(least_mps..=most_mps).contains(&wind_mps) {
            // Printed to the centimetre a second, inwards.
            let (min, max) = ((100.0 * least_mps).ceil() / 100.0, (100.0 * most_mps).floor() / 100.0);
            return Err(ClutterError { quantity: "wind", value: wind_mps, min, max, unit: " m/s" });
        }
        let height_m = (wind_mps / 7.18).powf(2.5);
        // Rounding may carry the ends a hair outside.
        let number = ((height_m - 0.04).max(0.0) / 0.1).powf(1.0 / 2.1);
        Ok(Self(number.min(SEA_STATES[1])))
    }

    /// Its number.
    pub fn number(self) -> f64 {
        self.0
    }

    /// Significant wave height, m.
    pub fn wave_height_m(self) -> f64 {
        0.04 + 0.1 * self.0.powf(2.1)
    }

    /// The wind that raises it in time, m/s.
    pub fn wind_mps(self) -> f64 {
        7.18 * self.wave_height_m().powf(0.4)
    }
}

/// Mean `sigma0` of the sea, power ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Copolar {
    /// Horizontal sent and received.
    pub hh: f64,
    /// Vertical sent and received.
    pub vv: f64,
}

/// Mean `sigma0` of the sea at a carrier, Hz, and a grazing angle, rad.
///
/// # Errors
/// A carrier or an angle that the model does not cover.
pub fn sigma0(carrier_hz: f64, grazing_rad: f64, sea: SeaState) -> Result<Copolar, ClutterError> {
    let carrier_ghz = carrier_hz * 1e-9;
    within("carrier", carrier_ghz, CARRIERS_GHZ, " GHz")?;
    // Compared in radians: degrees that went through radians do not come back to the last bit.
    let [least_rad, most_rad] = GRAZING_DEG.map(f64::to_radians);
    let grazing_deg = grazing_rad.to_degrees();
    if !(least_rad..=most_rad).contains(&grazing_rad) {
        let [min, max] = GRAZING_DEG;
        let (quantity, value, unit) = ("grazing angle", grazing_deg, " degrees");
        return Err(ClutterError { quantity, value, min, max, unit });
    }
    let s = sea.0;
    let sine = grazing_rad.sin().log10();
    let decades = carrier_ghz.log10() / (1.0 + 0.95 * grazing_deg);
    let rough = (1.0 + s).powf(1.0 / (2.0 + 0.085 * grazing_deg + 0.033 * s));
    let level = |[c1, c2, c3, c4, c5]: [f64; 5]| {
        let steep = c5 * grazing_deg * grazing_deg;
        Decibels(c1 + c2 * sine + (27.5 + c3 * grazing_deg) * decades + c4 * rough + steep).power_ratio()
    };
    Ok(Copolar { hh: level(HH), vv: level(VV) })
}

/// Refuses what is out of range, not-a-number included.
fn within(
    quantity: &'static str,
    value: f64,
    [min, max]: [f64; 2],
    unit: &'static str,
) -> Result<(), ClutterError> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(ClutterError { quantity, value, min, max, unit }) }
}
