//! Signals known in closed form, as they are described. What makes them is `radar::calibration`.

/// A channel that carries such a signal in place of an echo.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Name of the channel.
    pub name: String,
    /// Index of the receiver that takes it, with its clock.
    pub receiver: usize,
    /// Power of the signal at the converter, W.
    pub power_w: f64,
    /// Its phase, rad.
    pub phase_rad: f64,
    /// Whether the receiver's noise is added.
    pub noise: bool,
    /// Which signal.
    pub signal: Signal,
}

/// A signal known in closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Signal {
    /// Continuous, so far above the carrier.
    Tone {
        /// Hz.
        offset_hz: f64,
    },
    /// The transmitted pulse, so long after the window has opened.
    Loopback {
        /// Index of the transmitter.
        transmitter: usize,
        /// s.
        delay_s: f64,
    },
}

impl Signal {
    /// As written.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Tone { .. } => "tone",
            Self::Loopback { .. } => "loopback",
        }
    }
}
