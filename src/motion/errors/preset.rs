//! Classes of navigation, as error models.
//!
//! | class | position (1 sigma) | velocity | roll, pitch | heading | reports | latency |
//! | --- | --- | --- | --- | --- | --- | --- |
//! | `sps`: satellites, standard service | 1.5 m horizontal, 3 m vertical | 0.05 m/s | - | 1 Hz | 100 ms |
//! | `rtk`: with carrier phase | 0.015 m, 0.03 m | 0.03 m/s | - | 10 Hz | 50 ms |
//! | `tactical`: aided by a tactical inertial unit | 1.5 m | 0.03 m/s | 0.02 deg | 0.08 deg | 100 Hz | 20 ms |
//! | `navigation`: navigation grade, carrier phase | 0.05 m | 0.005 m/s | 0.005 deg | 0.02 deg | 200 Hz | 20 ms |
//!
//! Position, attitude, and the velocity of inertial systems are Gauss-Markov processes of 100 s; the velocity
//! of satellites alone is white. Typical catalogue figures, from no single source; rates and latencies lie
//! within what such receivers have (1 to 10 Hz and 20 to 100 ms, inertial systems 100 to 400 Hz). Biases of
//! gyroscopes and accelerometers are not drawn apart: an aided filter has taken them out but for what the
//! table states, and what they do in a long dropout is not modelled.
//!
//! ```
//! use nereus::motion::errors::preset::Class;
//! assert_eq!(Class::Sps.model().axes[2].gm_sigma, 3.0);
//! ```

use super::{ATTITUDE, AxisErrors, ErrorModel, VELOCITY};

/// Correlation time, s.
const TAU_S: f64 = 100.0;

/// A class of navigation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Class {
    /// Satellites, standard positioning service.
    Sps,
    /// Satellites with carrier phase (real-time kinematic).
    Rtk,
    /// Tactical inertial unit aided by satellites.
    Tactical,
    /// Navigation-grade inertial unit, carrier phase, processed.
    Navigation,
}

impl Class {
    /// Its errors.
    pub fn model(self) -> ErrorModel {
        // Horizontal and vertical position, velocity; roll and pitch, heading (deg); rate, latency.
        let (position_m, velocity_mps, attitude_deg, rate_hz, latency_s): (_, _, [f64; 2], _, _) = match self
        {
            Self::Sps => ([1.5, 3.0], 0.05, [0.0, 0.0], 1.0, 0.1),
            Self::Rtk => ([0.015, 0.03], 0.03, [0.0, 0.0], 10.0, 0.05),
            Self::Tactical => ([1.5, 1.5], 0.03, [0.02, 0.08], 100.0, 0.02),
            Self::Navigation => ([0.05, 0.05], 0.005, [0.005, 0.02], 200.0, 0.02),
        };
        let slow = |sigma: f64| match sigma > 0.0 {
            true => AxisErrors { gm_sigma: sigma, gm_tau_s: TAU_S, ..AxisErrors::default() },
            false => AxisErrors::default(),
        };
        let mut model = ErrorModel { rate_hz: Some(rate_hz), latency_s, ..ErrorModel::default() };
        for axis in 0..3 {
            model.axes[axis] = slow(position_m[usize::from(axis == 2)]);
            model.axes[VELOCITY + axis] = match self {
                Self::Sps | Self::Rtk => AxisErrors { white: velocity_mps, ..AxisErrors::default() },
                Self::Tactical | Self::Navigation => slow(velocity_mps),
            };
            model.axes[ATTITUDE + axis] = slow(attitude_deg[usize::from(axis == 2)].to_radians());
        }
        model
    }
}
