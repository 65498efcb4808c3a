//! Turbulence of the air that a platform flies through, as it is asked for. What it does is the business of
//! `motion::turbulence`.

use crate::units::KNOT_MPS;

/// Wind at 20 ft of light, moderate and severe turbulence (15, 30, 45 knots), m/s.
pub const LEVELS_MPS: [f64; 3] = [15.0 * KNOT_MPS, 30.0 * KNOT_MPS, 45.0 * KNOT_MPS];

/// Gusts and how an aircraft answers them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gusts {
    /// Wind at 20 ft (6.1 m) above the sea, m/s.
    pub wind20_mps: f64,
    /// Height above the sea for which scales hold, m; `None`: the platform's at pulse 0.
    pub height_m: Option<f64>,
    /// Speed through the air, m/s; `None`: the platform's speed at pulse 0.
    pub airspeed_mps: Option<f64>,
    /// Cut-off of the aircraft's answer, Hz.
    pub cutoff_hz: f64,
    /// Velocity of the aircraft over that of the air, below the cut-off.
    pub velocity_gain: f64,
    /// Angle of the aircraft over gust by airspeed, below the cut-off.
    pub attitude_gain: f64,
    /// Time in which it is steered back to its track, s; `None`: it drifts.
    pub hold_s: Option<f64>,
}

impl Gusts {
    /// Gusts of a wind at 20 ft, answered as most aircraft do.
    pub fn of_wind(wind20_mps: f64) -> Self {
        Self {
            wind20_mps,
            height_m: None,
            airspeed_mps: None,
            cutoff_hz: 0.5,
            velocity_gain: 1.0,
            attitude_gain: 1.0,
            hold_s: Some(30.0),
        }
    }
}
