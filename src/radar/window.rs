//! A receive window on the time axis of its own emission.

use crate::scene::Radar;

/// Samples at both ends of the window whose scatterer paths still reach into it through the receive filter.
pub const GUARD_SAMPLES: usize = 32;

/// What is received: from when to when, after the emission of the window's own pulse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) open_s: f64,
    pub(crate) close_s: f64,
    pub(crate) guard_s: f64,
    /// Length of the waveform.
    pub(crate) pulse_s: f64,
}

impl Window {
    /// Receives everything.
    pub(crate) const UNBOUNDED: Self =
        Self { open_s: f64::NEG_INFINITY, close_s: f64::INFINITY, guard_s: 0.0, pulse_s: 0.0 };

    pub(crate) fn new(radar: &Radar, open_s: f64, pulse_s: f64) -> Self {
        let close_s = open_s + radar.window.samples as f64 / radar.sample_rate_hz;
        Self { open_s, close_s, guard_s: GUARD_SAMPLES as f64 / radar.sample_rate_hz, pulse_s }
    }

    /// Whether an echo that begins at `begin_s` reaches into the window.
    pub(crate) fn touches(&self, begin_s: f64) -> bool {
        begin_s <= self.close_s + self.guard_s && begin_s + self.pulse_s >= self.open_s - self.guard_s
    }

    /// Whether an echo that begins at `begin_s` lies in the window from end to end.
    pub(crate) fn holds(&self, begin_s: f64) -> bool {
        begin_s >= self.open_s && begin_s + self.pulse_s <= self.close_s
    }
}
