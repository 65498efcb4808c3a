//! Known errors of what a platform reports.
//!
//! A report is made at an **epoch**, arrives `latency` later, and is used until the next one has arrived. For
//! each axis of position (East, North, up, m), velocity (m/s) and attitude (roll, pitch, heading, rad;
//! heading clockwise) the error at epoch `k`, time `t` after pulse 0, is
//!
//! ```text
//! e = b + a sin(2 pi f t + p) + s [t >= t_s] + r t     bias, sinusoid, step, ramp: known exactly
//!   + g_k + w_k + n_k                                   Gauss-Markov, walk, white
//! g_k = g_(k-1) e^(-dt/tau) + sg sqrt(1 - e^(-2 dt/tau)) x    (exact for every dt)
//! w_k = w_(k-1) + W sqrt(dt) x ,   n_k = sw x ,   x ~ N(0, 1)
//! ```
//!
//! and what is reported is `truth + e`, rounded to the quantisation. A bias may also be drawn once, N(0,
//! sb^2). The velocity error holds the derivative of the known part of the position error (sinusoid and ramp;
//! a step has none), as if the platform had really moved so. Noise of position and velocity is independent:
//! receivers find the two from different observables. An error `l` of the lever arm (body) adds `C l` to the
//! position and `w x C l` to the velocity.
//!
//! Reports arrive `max(0, latency + jitter x)` after their epoch; their time stamps are right, so a jitter of
//! arrival changes the age of what is at hand and nothing else. Dropouts are a Markov chain of two states in
//! steps `dt` between epochs: lost with `1 - e^(-dt r)` (`r` dropouts per second of good reception), back
//! with `1 - e^(-dt/m)` (`m` the mean length). Pulse 0 finds reception good.
//!
//! Every number comes from the stream (seed, report errors, platform and axis, epoch), and the processes
//! start at epoch 0, in both directions (a stationary Gauss-Markov process runs backwards as it does
//! forwards). So an error is a function of its epoch alone, whatever part of a run is asked. The series are
//! made when a run is built; what they may take is bounded by [`MOST_VALUES`].
//!
//! Limits: axes are independent; noise between epochs does not exist; nothing is filtered, so a report of an
//! inertial system must be given as what its filter leaves ([`preset`]).
//!
//! ```
//! use nereus::motion::errors::{ErrorModel, Errors, Circumstances};
//! use nereus::time::PulseTimes;
//! let mut model = ErrorModel::default();
//! model.axes[2].step = 3.0;
//! model.axes[2].step_at_s = 10.0;
//! let times = PulseTimes::uniform(222.0)?;
//! let errors = Errors::new(&model, &Circumstances { seed: 1, platform: 0, times: &times, pulses: 222, before_s: 0.0 })?;
//! assert_eq!((errors.value(2, 0, 9.9), errors.value(2, 0, 10.0)), (0.0, 3.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod preset;
mod series;

use std::f64::consts::TAU;

use thiserror::Error;

use crate::frames::{Body, Vector};

pub use series::{Circumstances, Errors, LatestReport};

/// Axes of an error model: position, velocity, attitude.
pub const AXES: usize = 9;
/// First axis of the velocity.
pub const VELOCITY: usize = 3;
/// First axis of the attitude.
pub const ATTITUDE: usize = 6;
/// Most values that the series of one platform may hold (256 MiB).
pub const MOST_VALUES: u64 = 1 << 25;

/// Errors of what a platform reports, or of where it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorModel {
    /// Which trajectory the platform's track is.
    pub recorded: Recorded,
    /// Reports per second from pulse 0 on; `None`: one at every pulse.
    pub rate_hz: Option<f64>,
    /// From the epoch of a report to its arrival, s.
    pub latency_s: f64,
    /// Standard deviation of the arrival, s.
    pub jitter_s: f64,
    /// What is done until the next report arrives.
    pub between: Between,
    /// Reports that are lost.
    pub dropouts: Option<Dropouts>,
    /// Error of the lever arm from antenna to reference point, m.
    pub lever_arm_error: Vector<Body>,
    /// Position East, North, up (m); velocity (m/s); roll, pitch, heading (rad).
    pub axes: [AxisErrors; AXES],
    /// Least step of a reported position (m), velocity (m/s), angle (rad); 0: none.
    pub quantisation: [f64; 3],
}

impl Default for ErrorModel {
    fn default() -> Self {
        Self {
            recorded: Recorded::Truth,
            rate_hz: None,
            latency_s: 0.0,
            jitter_s: 0.0,
            between: Between::Extrapolate,
            dropouts: None,
            lever_arm_error: Vector::ZERO,
            axes: [AxisErrors::default(); AXES],
            quantisation: [0.0; 3],
        }
    }
}

/// Which trajectory a track is. Either way the error is the report less the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Recorded {
    /// What happened: errors are added to the report.
    Truth,
    /// What the platform reported: the true motion differs from it by the error, which must be smooth.
    Reported,
}

/// What a consumer does with a report that is not of this very instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Between {
    /// Moves the position on with the reported velocity; the attitude is held.
    Extrapolate,
    /// Takes it as it is.
    Hold,
}

/// Reports that are lost for a while.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropouts {
    /// Dropouts per hour of good reception.
    pub per_hour: f64,
    /// Mean length, s.
    pub mean_s: f64,
    /// What is done meanwhile.
    pub during: Between,
}

/// The error of one axis, in its unit: m, m/s or rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisErrors {
    /// Constant, exactly.
    pub bias: f64,
    /// Standard deviation of a constant that is drawn once.
    pub bias_sigma: f64,
    /// Standard deviation of noise that is new at every epoch.
    pub white: f64,
    /// Random walk, unit per root second.
    pub walk: f64,
    /// Standard deviation of a first-order Gauss-Markov process.
    pub gm_sigma: f64,
    /// Its correlation time, s.
    pub gm_tau_s: f64,
    /// Amplitude of a sinusoid.
    pub sinusoid: f64,
    /// Its frequency, Hz.
    pub sinusoid_hz: f64,
    /// Its phase at pulse 0, rad.
    pub sinusoid_phase_rad: f64,
    /// Size of a step.
    pub step: f64,
    /// When, s after pulse 0.
    pub step_at_s: f64,
    /// Growth from pulse 0 on, unit per second.
    pub ramp: f64,
}

impl AxisErrors {
    /// Constant, sinusoid, step and ramp at `t_s` after pulse 0, with first and second derivative (those of a
    /// step are left out).
    pub fn known(&self, t_s: f64) -> [f64; 3] {
        let step = if t_s >= self.step_at_s { self.step } else { 0.0 };
        let mut jet = [self.bias + step + self.ramp * t_s, self.ramp, 0.0];
        if self.sinusoid != 0.0 {
            let w = TAU * self.sinusoid_hz;
            // Whole turns are taken off before they cost digits.
            let turns = self.sinusoid_hz * t_s;
            let (sine, cosine) = (TAU * (turns - turns.floor()) + self.sinusoid_phase_rad).sin_cos();
            jet[0] += self.sinusoid * sine;
            jet[1] += self.sinusoid * w * cosine;
            jet[2] -= self.sinusoid * w * w * sine;
        }
        jet
    }

    /// Whether it changes from epoch to epoch by chance.
    pub fn is_random(&self) -> bool {
        self.white > 0.0 || self.walk > 0.0 || self.gm_sigma > 0.0
    }
}

/// Why there are no errors.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ErrorsFault {
    /// Series that do not fit.
    #[error(
        "errors of its report take {values} values ({epochs} epochs); allowed: at most {MOST_VALUES}; \
         a lower errors.rate_hz or a shorter run"
    )]
    TooLong {
        /// Values of all series.
        values: u64,
        /// Epochs of each.
        epochs: u64,
    },
    /// A number that no model can have.
    #[error("errors: {name} = {value} is not allowed: {allowed}")]
    Value {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Something that jumps, where the true motion is to follow it.
    #[error(
        "errors: {what} cannot be the motion of a platform (recorded = \"reported\"); \
         allowed: bias, ramp, sinusoid, walk and Gauss-Markov of position and attitude"
    )]
    NotSmooth {
        /// What jumps.
        what: &'static str,
    },
}

impl ErrorModel {
    /// Whether all numbers are such that the model has a meaning.
    ///
    /// # Errors
    /// Numbers that are not finite, or negative where they may not be; jumps of the true motion.
    pub fn check(&self) -> Result<(), ErrorsFault> {
        let refuse = |name, value, allowed| Err(ErrorsFault::Value { name, value, allowed });
        let [q_m, q_mps, q_rad] = self.quantisation;
        let sizes = [
            ("latency_s", self.latency_s),
            ("jitter_s", self.jitter_s),
            ("quantisation, m", q_m),
            ("quantisation, m/s", q_mps),
            ("quantisation, rad", q_rad),
        ];
        let drops = self.dropouts.iter().flat_map(|d| [("per_hour", d.per_hour), ("mean_s", d.mean_s)]);
        let axes = self.axes.iter().flat_map(|axis| {
            let AxisErrors { bias_sigma, white, walk, gm_sigma, gm_tau_s, sinusoid_hz, .. } = *axis;
            let sizes = [bias_sigma, white, walk, gm_sigma, gm_tau_s, sinusoid_hz];
            let names = ["bias_sigma", "white", "walk", "gm_sigma", "gm_tau_s", "sinusoid_hz"];
            names.into_iter().zip(sizes)
        });
        for (name, value) in sizes.into_iter().chain(drops).chain(axes) {
            if !(value.is_finite() && value >= 0.0) {
                return refuse(name, value, "a finite number, not negative");
            }
        }
        for axis in &self.axes {
            let any =
                [axis.bias, axis.sinusoid, axis.sinusoid_phase_rad, axis.step, axis.step_at_s, axis.ramp];
            if let Some(value) = any.into_iter().find(|value| !value.is_finite()) {
                return refuse("a known error", value, "a finite number");
            }
            if axis.gm_sigma > 0.0 && axis.gm_tau_s <= 0.0 {
                return refuse("gm_tau_s", axis.gm_tau_s, "above 0 with a Gauss-Markov process");
            }
        }
        if let Some(value) = self.rate_hz.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return refuse("rate_hz", value, "a finite number above 0");
        }
        if self.recorded == Recorded::Reported {
            let jumps = [
                ("white noise", self.axes.iter().any(|axis| axis.white > 0.0)),
                ("a step", self.axes.iter().any(|axis| axis.step != 0.0)),
                ("quantisation", self.quantisation != [0.0; 3]),
                ("an error of the lever arm", self.lever_arm_error != Vector::ZERO),
                (
                    "an error of the velocity (it follows from the position)",
                    self.axes[VELOCITY..ATTITUDE].iter().any(|axis| *axis != AxisErrors::default()),
                ),
            ];
            if let Some((what, _)) = jumps.into_iter().find(|(_, met)| *met) {
                return Err(ErrorsFault::NotSmooth { what });
            }
        }
        Ok(())
    }
}
