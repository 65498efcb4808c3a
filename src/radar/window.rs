//! A receive window on the time axis of its own emission.

use crate::scene::Radar;

/// Samples at both ends of the window whose scatterer paths still reach into it through the receive filter.
pub const GUARD_SAMPLES: usize = 32;
/// Rounding of a delay, s.
const ROUNDING_S: f64 = 1e-12;

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

    /// Whether echoes that begin at `begin_s` after each emission, one every `interval_s`, are received: one
    /// of them from end to end; or of pulses longer than half the window half of each, by all windows.
    pub(crate) fn receives(&self, begin_s: f64, interval_s: f64) -> bool {
        let Self { open_s, close_s, pulse_s, .. } = *self;
        let turns = |since_s: f64| since_s / interval_s;
        let latest = turns(close_s - pulse_s - begin_s + ROUNDING_S).floor();
        if latest >= turns(open_s - begin_s - ROUNDING_S).ceil() {
            return true;
        }
        if pulse_s <= 0.5 * (close_s - open_s) {
            return false;
        }
        // No echo is whole in the window, so that few of them reach into it.
        let (mut turn, mut received_s) = (turns(open_s - pulse_s - begin_s).ceil(), 0.0);
        while turn * interval_s + begin_s < close_s && received_s < 0.5 * pulse_s {
            let begin_s = turn * interval_s + begin_s;
            received_s += ((begin_s + pulse_s).min(close_s) - begin_s.max(open_s)).max(0.0);
            turn += 1.0;
        }
        received_s >= 0.5 * pulse_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Echoes of 1 us and of nearly the whole interval of 1 ms, in windows of nearly the whole interval.
    #[test]
    fn long_pulses_are_received_by_halves() {
        let window =
            |open_s: f64, close_s: f64, pulse_s: f64| Window { open_s, close_s, guard_s: 0.0, pulse_s };
        let short = window(15e-6, 30e-6, 1e-6);
        assert!([15e-6, 29e-6, 1.02e-3, -980e-6].iter().all(|begin| short.receives(*begin, 1e-3)));
        assert!([14.9e-6, 29.1e-6, 400e-6].iter().all(|begin| !short.receives(*begin, 1e-3)));
        // Full duty: whatever the delay, the window is full of echo.
        let full = window(0.0, 0.999e-3, 0.99e-3);
        assert!([0.0, 20e-6, 300e-6, 900e-6].iter().all(|begin| full.receives(*begin, 1e-3)));
        // One long pulse in a slow rhythm is received where half of it is.
        assert!(full.receives(0.4e-3, 1.0) && !full.receives(0.6e-3, 1.0));
    }
}
