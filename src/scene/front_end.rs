//! What is wrong with the front end of a receiver.

/// Errors and laws between the echo and the converter; by default none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrontEnd {
    /// Gain of I over that of Q, dB.
    pub iq_gain_db: f64,
    /// How far Q is from a quarter turn after I, rad.
    pub iq_phase_rad: f64,
    /// Constant that is added to I and to Q, sqrt(W).
    pub offset: [f64; 2],
    /// Sensitivity time control.
    pub stc: Option<Stc>,
    /// Automatic gain control within the window of a pulse.
    pub agc: Option<Agc>,
    /// Instability of what is transmitted.
    pub instability: Option<Instability>,
    /// Jitter of the sampling clock.
    pub jitter: Option<Jitter>,
    /// While the receiver is blanked: from the begin of an emission until so long after its end, s.
    pub blanked_s: Option<f64>,
}

/// Sensitivity time control: gain that grows with the time since the last emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stc {
    /// From when on the gain is full, s after the begin of the emission.
    pub full_s: f64,
    /// Power of the time by which the power gain grows.
    pub exponent: f64,
    /// Gain at the least, dB below the full one.
    pub depth_db: f64,
}

/// Automatic gain control: gain that falls where samples are strong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agc {
    /// Mean power of samples above which the gain falls, W.
    pub level_w: f64,
    /// Time constant of the mean where power rises, s.
    pub attack_s: f64,
    /// Where it falls, s.
    pub release_s: f64,
    /// Gain at the least, dB below the full one.
    pub depth_db: f64,
}

/// What differs from pulse to pulse in amplitude and phase: of all transmitters, for they share an exciter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instability {
    /// Standard deviation of the level, dB.
    pub level_db: f64,
    /// Standard deviation of the phase, rad.
    pub phase_rad: f64,
}

/// Jitter of the instants at which samples are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jitter {
    /// Standard deviation, s.
    pub rms_s: f64,
    /// Frequency at which the converter meets the carrier, Hz.
    pub intermediate_hz: f64,
}

impl FrontEnd {
    /// Whether it changes nothing.
    pub fn is_ideal(&self) -> bool {
        *self == Self::default()
    }
}
