//! A receive window on the time axis of its own emission.

use crate::scene::Radar;

/// Samples at both ends of the window whose scatterer paths still reach into it through the receive filter.
pub const GUARD_SAMPLES: usize = 32;
/// The same of a pulse that is made by itself, whatever windows receive of it: what is cut off there lies 100
/// dB and more below it.
pub(crate) const RINGING_OF_PULSES: usize = 256;
/// Rounding of a delay, s.
const ROUNDING_S: f64 = 1e-12;

/// Samples between a window that holds echoes from near by and from far away and the image of a pulse, on
/// either side: images then lie as far from its end as it is long.
pub fn far_guard_samples(window_samples: usize) -> usize {
    GUARD_SAMPLES + window_samples.div_ceil(2)
}

/// What the filter rings of an echo beyond either of its ends, in samples of full power, and the samples in
/// which that falls off: by their fifth power, as its impulse response falls by the third. Within 3 dB of
/// what sweeps of half to 0.8 of the sample rate leave from 4 to 32 samples on.
const RINGING: f64 = 0.15;
const RINGING_SAMPLES: f64 = 2.0;

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

    /// What lies between the first start and the last end of some windows, one at least.
    pub(crate) fn hull(windows: impl IntoIterator<Item = Self>) -> Self {
        windows.into_iter().reduce(Self::hull_with).unwrap_or(Self::UNBOUNDED)
    }

    /// What lies between the first start and the last end of two.
    pub(crate) fn hull_with(self, other: Self) -> Self {
        let (open_s, close_s) = (self.open_s.min(other.open_s), self.close_s.max(other.close_s));
        Self { open_s, close_s, ..self }
    }

    /// Whether an echo that begins at `begin_s` reaches into the window.
    pub(crate) fn touches(&self, begin_s: f64) -> bool {
        self.touches_within(begin_s, 0.0)
    }

    /// Whether one does that begins within `slack_s` of it.
    pub(crate) fn touches_within(&self, begin_s: f64, slack_s: f64) -> bool {
        begin_s - slack_s <= self.close_s + self.guard_s
            && begin_s + slack_s + self.pulse_s >= self.open_s - self.guard_s
    }

    /// How much an echo that begins at `begin_s` counts: 1 where a part of it lies in the window, else the
    /// share of its energy that the filter rings into it, about; 0 for one that does not touch it.
    pub(crate) fn share(&self, begin_s: f64) -> f64 {
        let apart_s = (self.open_s - (begin_s + self.pulse_s)).max(begin_s - self.close_s);
        if apart_s <= 0.0 {
            return 1.0;
        }
        if !self.touches(begin_s) {
            return 0.0;
        }
        let per_s = GUARD_SAMPLES as f64 / self.guard_s;
        let falls = (apart_s * per_s / RINGING_SAMPLES).powi(5);
        RINGING / (1.0 + falls) / (self.pulse_s * per_s).max(1.0)
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
    use crate::radar::filter::ReceiveFilter;
    use crate::radar::waveform::{Lfm, Waveform};
    use crate::scene::radar::Sweep;

    /// The share against the energy of a filtered sweep beyond its end, on samples a sixteenth apart.
    #[test]
    fn what_rings_into_a_window_is_known() {
        let (samples, fine) = (40.0, 16usize);
        let n = 4096 * fine;
        for band in [0.5, 0.72, 0.8] {
            let pulse = Lfm::new(band, samples, Sweep::Up).unwrap();
            let filter = ReceiveFilter::new(1.0);
            let mut out: Vec<_> = (0..n)
                .map(|k| {
                    let f = if 2 * k < n { k as f64 } else { k as f64 - n as f64 } / 4096.0;
                    if f.abs() < 0.5 { pulse.spectrum(f) * filter.response(f) } else { 0.0.into() }
                })
                .collect();
            nereus_fft::inverse(n).process(&mut out);
            // Sums over time of |q|^2, q of unit amplitude.
            let power = |from: f64, to: f64| -> f64 {
                let of = |j: usize| (out[j] / 4096.0).norm_sqr() / fine as f64;
                ((from * fine as f64) as usize..(to * fine as f64) as usize).map(of).sum()
            };
            let window = Window { open_s: 100.0, close_s: 1000.0, guard_s: 32.0, pulse_s: samples };
            for apart in [4.0, 7.0, 12.0, 20.0, 31.0] {
                let wanted = power(samples + apart, samples + 1000.0) / samples;
                let found = window.share(window.open_s - samples - apart);
                let db = 10.0 * (found / wanted).log10();
                println!("band {band}, {apart} samples apart: {db:.1} dB");
                assert!((-10.0..8.0).contains(&db), "{band} {apart}: {db}");
            }
        }
        let window = Window { open_s: 100.0, close_s: 1000.0, guard_s: 32.0, pulse_s: 40.0 };
        assert_eq!([60.0, 100.0, 999.0, 1000.0].map(|begin_s| window.share(begin_s)), [1.0; 4]);
        assert_eq!([20.0, 1040.0, f64::NAN].map(|begin_s| window.share(begin_s)), [0.0; 3]);
        assert_eq!(Window::UNBOUNDED.share(7.0), 1.0);
    }

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
