//! Bands of frequencies about a carrier.

/// What lies from one frequency to another, both less the carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Lower end, Hz.
    pub from_hz: f64,
    /// Upper end, Hz.
    pub to_hz: f64,
}

impl Band {
    /// So wide, about a frequency.
    pub fn about(middle_hz: f64, width_hz: f64) -> Self {
        Self { from_hz: middle_hz - 0.5 * width_hz, to_hz: middle_hz + 0.5 * width_hz }
    }

    /// The one that holds both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { from_hz: self.from_hz.min(other.from_hz), to_hz: self.to_hz.max(other.to_hz) }
    }

    /// So much higher.
    #[must_use]
    pub fn shifted(self, by_hz: f64) -> Self {
        Self { from_hz: self.from_hz + by_hz, to_hz: self.to_hz + by_hz }
    }

    /// From end to end, Hz.
    pub fn width_hz(self) -> f64 {
        self.to_hz - self.from_hz
    }

    /// Its middle less the carrier, Hz.
    pub fn middle_hz(self) -> f64 {
        0.5 * (self.from_hz + self.to_hz)
    }

    /// How far from the carrier it reaches, Hz.
    pub fn reach_hz(self) -> f64 {
        self.to_hz.max(-self.from_hz)
    }
}
