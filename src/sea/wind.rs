//! Wind: one record for a whole run.
//!
//! Neutral profile of Cardone (1969) and Pierson and Stacy (1973), u* in cm/s and lengths in cm:
//!
//! `U(z) = (u*/0.4) ln(z/z0)`, `z0 = 0.684/u* + 4.28e-5 u*^2 - 0.0443`,
//!
//! and the drag of Wu (1982): `u* = U10 sqrt((0.8 + 0.065 U10) 1e-3)`, SI. Every spectrum and slope law
//! asks for the wind at its own height (Cox-Munk 12.5 m, Pierson-Moskowitz and Fung-Lee 19.5 m,
//! Elfouhaily and JONSWAP 10 m) or for its own u* (Fung-Lee Cardone's, Elfouhaily Wu's), so the record
//! carries all of them, from one profile.
//!
//! Limits: 0 to 40 m/s at 10 m; fitted to about 25 m/s, extrapolated above. Cardone's z0 grows without
//! bound as u* falls: below u* = 0.4 cm/s (U10 about 0.06 m/s) the speed is taken proportional to u*.
//! Under U10 = 0.3 m/s the sea is flat ([`Wind::is_calm`]).
//!
//! ```
//! use nereus::scene::water::WindProfile;
//! use nereus::sea::wind::Wind;
//! let wind = Wind::from_friction_velocity(0.36, WindProfile::Cardone, 0.0)?;
//! assert!((wind.u19_5_mps - 9.969).abs() < 1e-3);
//! # Ok::<(), nereus::sea::wind::WindError>(())
//! ```

use crate::scene::water::{WindGiven, WindProfile, WindStrength};

/// Strongest wind allowed, m/s (given, and at 10 m).
pub const MAX_SPEED_MPS: f64 = 40.0;
/// Wind at 10 m below which no waves are raised, m/s.
pub const CALM_BELOW_MPS: f64 = 0.3;
/// Wind at 10 m above which profile, drag and spectra are extrapolations, m/s.
pub const EXTRAPOLATED_ABOVE_MPS: f64 = 25.0;
/// Heights at which a speed may be given, m.
pub const HEIGHT_RANGE_M: [f64; 2] = [1.0, 100.0];

const KARMAN: f64 = 0.4;
/// Interval of u* in which Cardone's profile is inverted, m/s.
const USTAR_BRACKET_MPS: [f64; 2] = [0.004, 3.0];

/// The wind of a run, at every height and in every law that is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Friction velocity in Cardone's profile, m/s.
    pub ustar_cardone_mps: f64,
    /// Friction velocity by Wu's drag from U10, m/s.
    pub ustar_wu_mps: f64,
    /// Speed at 10 m, m/s.
    pub u10_mps: f64,
    /// Speed at 12.5 m, m/s.
    pub u12_5_mps: f64,
    /// Speed at 19.5 m, m/s.
    pub u19_5_mps: f64,
    /// Direction it blows towards, from +x counter-clockwise, radians.
    pub direction_rad: f64,
}

/// What is wrong with a wind.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WindError {
    /// Speed out of range.
    #[error("wind of {speed_mps} m/s: allowed are 0 to {MAX_SPEED_MPS} m/s")]
    Speed {
        /// The speed given, m/s.
        speed_mps: f64,
    },
    /// The speed at 10 m that follows is out of range.
    #[error("this wind means {u10_mps:.1} m/s or more at 10 m: allowed are 0 to {MAX_SPEED_MPS} m/s")]
    SpeedAt10m {
        /// The speed at 10 m, m/s (a lower bound).
        u10_mps: f64,
    },
    /// Height out of range.
    #[error("wind given at {height_m} m: allowed are {} to {} m", HEIGHT_RANGE_M[0], HEIGHT_RANGE_M[1])]
    Height {
        /// The height given, m.
        height_m: f64,
    },
    /// Friction velocity out of range.
    #[error("friction velocity of {ustar_mps} m/s: allowed are 0 to {} m/s", USTAR_BRACKET_MPS[1])]
    FrictionVelocity {
        /// The friction velocity given, m/s.
        ustar_mps: f64,
    },
    /// Direction not a number.
    #[error("wind direction of {direction_rad} rad: it must be finite")]
    Direction {
        /// The direction given, radians.
        direction_rad: f64,
    },
}

impl Wind {
    /// The record that follows from what the user knows.
    ///
    /// # Errors
    /// A wind out of range.
    pub fn resolve(given: &WindGiven) -> Result<Self, WindError> {
        match given.strength {
            WindStrength::FrictionVelocity { ustar_mps } => {
                Self::from_friction_velocity(ustar_mps, given.profile, given.direction_rad)
            }
            WindStrength::Speed { speed_mps, height_m } => {
                Self::from_speed(speed_mps, height_m, given.profile, given.direction_rad)
            }
        }
    }

    /// From the friction velocity of the chosen profile, m/s.
    ///
    /// # Errors
    /// A friction velocity or direction out of range.
    pub fn from_friction_velocity(
        ustar_mps: f64,
        profile: WindProfile,
        direction_rad: f64,
    ) -> Result<Self, WindError> {
        if !(0.0..=USTAR_BRACKET_MPS[1]).contains(&ustar_mps) {
            return Err(WindError::FrictionVelocity { ustar_mps });
        }
        let speed_at = |height_m| match profile {
            WindProfile::Cardone => cardone_speed_mps(ustar_mps, height_m),
            WindProfile::Wu => wu_speed_mps(wu_speed_at_10m_mps(ustar_mps), height_m),
        };
        let wind = Self::of_profile(speed_at, direction_rad)?;
        Ok(match profile {
            WindProfile::Cardone => Self { ustar_cardone_mps: ustar_mps, ..wind },
            WindProfile::Wu => Self { ustar_wu_mps: ustar_mps, ..wind },
        })
    }

    /// From the mean speed (m/s) at a height (m), carried to other heights by the chosen profile.
    ///
    /// # Errors
    /// A speed, height or direction out of range.
    pub fn from_speed(
        speed_mps: f64,
        height_m: f64,
        profile: WindProfile,
        direction_rad: f64,
    ) -> Result<Self, WindError> {
        if !(0.0..=MAX_SPEED_MPS).contains(&speed_mps) {
            return Err(WindError::Speed { speed_mps });
        }
        if !(HEIGHT_RANGE_M[0]..=HEIGHT_RANGE_M[1]).contains(&height_m) {
            return Err(WindError::Height { height_m });
        }
        let mut wind = match profile {
            WindProfile::Cardone => {
                let strongest_mps = cardone_speed_mps(USTAR_BRACKET_MPS[1], height_m);
                if speed_mps > strongest_mps {
                    return Err(WindError::SpeedAt10m {
                        u10_mps: cardone_speed_mps(USTAR_BRACKET_MPS[1], 10.0),
                    });
                }
                let ustar_mps = cardone_friction_velocity_mps(speed_mps, height_m);
                let wind = Self::of_profile(|z_m| cardone_speed_mps(ustar_mps, z_m), direction_rad)?;
                Self { ustar_cardone_mps: ustar_mps, ..wind }
            }
            WindProfile::Wu => {
                // Twice the limit brackets any legal input: over 1 to 100 m the profile changes U10 by
                // less than a factor of two.
                let u10_mps =
                    bisect([0.0, 2.0 * MAX_SPEED_MPS], |u10| wu_speed_mps(u10, height_m) - speed_mps);
                Self::of_profile(|z_m| wu_speed_mps(u10_mps, z_m), direction_rad)?
            }
        };
        // What was given comes back as given, not to within a rounding of the inversion.
        for (at_m, speed) in
            [(10.0, &mut wind.u10_mps), (12.5, &mut wind.u12_5_mps), (19.5, &mut wind.u19_5_mps)]
        {
            if at_m == height_m {
                *speed = speed_mps;
            }
        }
        Ok(wind)
    }

    fn of_profile(speed_at: impl Fn(f64) -> f64, direction_rad: f64) -> Result<Self, WindError> {
        if !direction_rad.is_finite() {
            return Err(WindError::Direction { direction_rad });
        }
        let u10_mps = speed_at(10.0);
        // A rounding above the limit is the limit.
        if u10_mps > MAX_SPEED_MPS * (1.0 + 1e-12) {
            return Err(WindError::SpeedAt10m { u10_mps });
        }
        let u19_5_mps = speed_at(19.5);
        Ok(Self {
            ustar_cardone_mps: cardone_friction_velocity_mps(u19_5_mps, 19.5),
            ustar_wu_mps: wu_friction_velocity_mps(u10_mps),
            u10_mps,
            u12_5_mps: speed_at(12.5),
            u19_5_mps,
            direction_rad,
        })
    }

    /// Whether it is too weak to raise waves: the wind sea is exactly flat.
    pub fn is_calm(&self) -> bool {
        self.u10_mps < CALM_BELOW_MPS
    }

    /// Whether it is stronger than the data behind the laws, and the linear sea a rough model.
    pub fn is_extrapolated(&self) -> bool {
        self.u10_mps > EXTRAPOLATED_ABOVE_MPS
    }
}

/// Roughness length z0 of Cardone's profile, m, for u* in m/s; below 0.4 cm/s that of 0.4 cm/s, from where on
/// down the speed is proportional to u*.
pub fn cardone_roughness_m(ustar_mps: f64) -> f64 {
    let ustar_cmps = 100.0 * ustar_mps.max(USTAR_BRACKET_MPS[0]);
    0.01 * (0.684 / ustar_cmps + 4.28e-5 * ustar_cmps * ustar_cmps - 0.0443)
}

/// Speed of Cardone's profile, m/s, at a height of at least 1 m.
pub fn cardone_speed_mps(ustar_mps: f64, height_m: f64) -> f64 {
    let lowest = USTAR_BRACKET_MPS[0];
    if ustar_mps < lowest {
        return ustar_mps / lowest * cardone_speed_mps(lowest, height_m);
    }
    ustar_mps / KARMAN * (height_m / cardone_roughness_m(ustar_mps)).ln()
}

/// Friction velocity for which Cardone's profile has the given speed at a height (1 m or more), m/s;
/// at most 3 m/s.
pub fn cardone_friction_velocity_mps(speed_mps: f64, height_m: f64) -> f64 {
    // The profile rises with u* throughout, the linear piece below 0.4 cm/s included.
    bisect([0.0, USTAR_BRACKET_MPS[1]], |ustar| cardone_speed_mps(ustar, height_m) - speed_mps)
}

/// Friction velocity by Wu's drag from the speed at 10 m, m/s.
pub fn wu_friction_velocity_mps(u10_mps: f64) -> f64 {
    u10_mps * ((0.8 + 0.065 * u10_mps) * 1e-3).sqrt()
}

/// Speed at 10 m that has the given friction velocity by Wu's drag, m/s.
pub fn wu_speed_at_10m_mps(ustar_mps: f64) -> f64 {
    bisect([0.0, 100.0], |u10| wu_friction_velocity_mps(u10) - ustar_mps)
}

/// Logarithmic profile through U10 with Wu's friction velocity, m/s.
pub fn wu_speed_mps(u10_mps: f64, height_m: f64) -> f64 {
    u10_mps + wu_friction_velocity_mps(u10_mps) / KARMAN * (height_m / 10.0).ln()
}

/// Zero of a rising function in an interval, to the last bit; an end when there is none inside.
fn bisect([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    if f(low) >= 0.0 {
        return low;
    }
    // 1100 halvings reach the smallest number; the loop ends when the interval cannot be halved.
    for _ in 0..1100 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
