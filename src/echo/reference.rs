//! The f64 reference echo, written from the equation. Everything faster is measured against it.
//!
//! # Filtered, exact within the pulse (reference B')
//!
//! Receiver-filtered, with the motion during the pulse as an exact term. For the channel of a pair, on an
//! `N`-point transform that starts at the window's first sample:
//!
//! ```text
//! S[k] = H(f_k) sum_n a_n e^{-j 2 pi f0 tau_n} Q_n(f_k) e^{-j 2 pi f_k d_n} ,  d_n = o_n + tau_n - t_w
//! Q_n(f) = (1 + r_n) P((1 + r_n) f + f0 r_n)
//! s[j] = (fs/N) sum_k e^{+j 2 pi j k/N} S[k]
//! ```
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `a_n` | amplitude of scatterer path `n` in this channel, no carrier phase | sqrt(W) |
//! | `tau_n`, `r_n` | its delay and delay rate by the time of emission, for the channel's pair | s, - |
//! | `o_n` | its emission after the window's own emission | s |
//! | `t_w` | first sample after the emission | s |
//! | `f0`, `fs`, `f_k` | carrier, complex sample rate, baseband frequency of bin `k` | Hz |
//! | `P`, `H` | spectrum of the pulse ([`Waveform`]), receive filter ([`ReceiveFilter`]) | s, - |
//!
//! What leaves `u` after the beginning of the pulse arrives at `x = u + tau(u) - tau(0) = (1 + r) u` after
//! the beginning of the echo, with the phase of its emission: after mixing with the carrier at arrival,
//!
//! ```text
//! q(x) = p(u) e^{j 2 pi f0 (u - x)} = p(x/(1 + r)) e^{-j 2 pi f0 r x/(1 + r)}
//! Q(f) = int q(x) e^{-j 2 pi f x} dx = (1 + r) int p(u) e^{-j 2 pi ((1 + r) f + f0 r) u} du
//! ```
//!
//! So carrier and envelope are stretched alike, and the Doppler shift is `-f0 r/(1 + r)`. With the envelope
//! left as it was (`P(f + f0 r)`) the error is `2 pi B Tc |r| / sqrt 30` for a linear sweep: -89 dB at 20 x
//! 1.5e-6 (aircraft), -17.8 dB at 4000 x 2.8e-5 (Ka from orbit). The factor `1 + r` is that of the integral:
//! `|q|` is that of the pulse, the change of field strength on reflection at something that moves (`r`, -86
//! dB at 5e-5, the same for all samples of an echo) is not modelled. Neglected: acceleration within the
//! pulse. The phase `f0 tau` is taken modulo one turn in f64: from orbit (5e7 turns) it is exact to 5e-8 rad.
//!
//! The transform is periodic. Its length leaves [`GUARD_SAMPLES`] and more between the window and the image
//! of a pulse; echoes that cannot reach the window (further than [`GUARD_SAMPLES`] from it) are left out and
//! counted. What the filter rings across that guard is some -70 dB of an echo: little beside echoes alike,
//! but not beside those from a thousand times as far away. There
//! [`far_guard_samples`](crate::radar::window::far_guard_samples) keeps images as far from the window's end
//! as the window is long: what wraps is then no more than what rings there anyhow.
//!
//! # Time-sampled, unfiltered (reference A)
//!
//! [`raw_samples`]: `q` sampled in time with no filter. A rectangular chirp is not band-limited, so A and B'
//! differ by some -20 dB; A is for tests of delay, phase and Doppler conventions.
//!
//! ```
//! use std::sync::Arc;
//! use nereus::echo::reference::ReferenceEcho;
//! use nereus::radar::waveform::Lfm;
//! use nereus::paths::list::ScattererPaths;
//! use nereus::scene::radar::Sweep;
//! use num_complex::Complex64;
//!
//! let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up)?);
//! let echo = ReferenceEcho::new(pulse, 10e9, 100e6, 256, vec![0]);
//! let mut paths = ScattererPaths::new(1, 1, 1);
//! paths.emission_offset_s.push(0.0);
//! paths.delay_s[0].push(24.1e-6);
//! paths.delay_rate[0].push(0.0);
//! paths.amplitude[0].push(Complex64::new(1e-6, 0.0));
//! let mut spectrum = vec![Complex64::ZERO; echo.fft_len()];
//! let coverage = echo.spectrum(&paths, 23.6e-6, &mut spectrum);
//! assert_eq!(coverage.outside, 0);
//! # Ok::<(), nereus::radar::waveform::WaveformError>(())
//! ```

use std::sync::Arc;

use num_complex::Complex64;

use crate::paths::list::ScattererPaths;
use crate::radar::filter::{RINGING_SAMPLES, ReceiveFilter, bin_frequency_hz};
use crate::radar::phasor::phasor;
use crate::radar::waveform::{Waveform, WaveformError};
use crate::units::fast_len;

/// Samples between the window and the nearest image of a pulse, on either side.
pub const GUARD_SAMPLES: usize = RINGING_SAMPLES;

/// How the echoes of a pulse lie in its window. Counted per scatterer path and pair, those of zero amplitude
/// not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coverage {
    /// Echoes of which a part lies before or after the window.
    pub cut: usize,
    /// Echoes that lie wholly outside.
    pub outside: usize,
}

impl Coverage {
    /// Whether every echo lies in the window from end to end.
    pub fn is_complete(&self) -> bool {
        *self == Self::default()
    }
}

/// The reference echo of one radar.
pub struct ReferenceEcho {
    waveform: Arc<dyn Waveform>,
    carrier_hz: f64,
    sample_rate_hz: f64,
    fft_len: usize,
    window_s: f64,
    /// Delays beyond this from the window (pulse length apart) are left out; infinite for a periodic echo.
    guard_s: f64,
    /// For each pair, its channels.
    channels_of_pair: Vec<Vec<usize>>,
    /// Window of each pair; empty where all have the first.
    windows: Vec<usize>,
    /// `(bin, f_k, H(f_k))` where the filter passes anything.
    bins: Vec<(usize, f64, f64)>,
    /// 1, or 0 when what moves stands still while a pulse passes.
    rate_factor: f64,
}

impl ReferenceEcho {
    /// For windows of `window_samples`; `channel_pairs[c]` is the pair of channel `c`.
    ///
    /// The transform gets the least fast length that holds the window, the pulse and two guards.
    pub fn new(
        waveform: Arc<dyn Waveform>,
        carrier_hz: f64,
        sample_rate_hz: f64,
        window_samples: usize,
        channel_pairs: Vec<usize>,
    ) -> Self {
        Self::with_guard(waveform, carrier_hz, sample_rate_hz, window_samples, channel_pairs, GUARD_SAMPLES)
    }

    /// The same with guards of so many samples, [`GUARD_SAMPLES`] at least.
    pub fn with_guard(
        waveform: Arc<dyn Waveform>,
        carrier_hz: f64,
        sample_rate_hz: f64,
        window_samples: usize,
        channel_pairs: Vec<usize>,
        guard_samples: usize,
    ) -> Self {
        let pulse_samples = waveform.span_samples(sample_rate_hz);
        let fft_len = fast_len(window_samples + pulse_samples + 2 * guard_samples.max(GUARD_SAMPLES));
        let mut echo =
            Self::with_period(waveform, carrier_hz, sample_rate_hz, window_samples, channel_pairs, fft_len);
        echo.guard_s = GUARD_SAMPLES as f64 / sample_rate_hz;
        echo
    }

    /// On a transform of exactly `fft_len` samples, whatever wraps: the periodic form of the equation. No
    /// scatterer path is left out.
    pub fn with_period(
        waveform: Arc<dyn Waveform>,
        carrier_hz: f64,
        sample_rate_hz: f64,
        window_samples: usize,
        channel_pairs: Vec<usize>,
        fft_len: usize,
    ) -> Self {
        let filter = ReceiveFilter::new(sample_rate_hz);
        let bins = (0..fft_len)
            .map(|k| {
                let f_hz = bin_frequency_hz(k, fft_len, sample_rate_hz);
                (k, f_hz, filter.response(f_hz))
            })
            .filter(|(_, _, h)| *h != 0.0)
            .collect();
        let pairs = channel_pairs.iter().map(|p| p + 1).max().unwrap_or(0);
        let mut channels_of_pair = vec![Vec::new(); pairs];
        for (channel, pair) in channel_pairs.iter().enumerate() {
            channels_of_pair[*pair].push(channel);
        }
        Self {
            waveform,
            carrier_hz,
            sample_rate_hz,
            fft_len,
            window_s: window_samples as f64 / sample_rate_hz,
            guard_s: f64::INFINITY,
            channels_of_pair,
            windows: Vec::new(),
            bins,
            rate_factor: 1.0,
        }
    }

    /// The same with `r_n := 0` within the pulse (filtered, frozen: reference B): everything stands still
    /// while a pulse passes.
    pub fn neglect_intra_pulse_doppler(mut self) -> Self {
        self.rate_factor = 0.0;
        self
    }

    /// The same for pairs whose windows are these of several.
    pub fn in_windows(self, of_pairs: Vec<usize>) -> Self {
        Self { windows: of_pairs, ..self }
    }

    /// The same that takes echoes up to so many samples from the window, no more than its transform has room
    /// for.
    pub fn reaching(self, samples: usize) -> Self {
        Self { guard_s: samples as f64 / self.sample_rate_hz, ..self }
    }

    /// What is radiated.
    pub fn waveform(&self) -> &dyn Waveform {
        self.waveform.as_ref()
    }

    /// Length N of the transform, samples.
    pub fn fft_len(&self) -> usize {
        self.fft_len
    }

    /// Complex sample rate, Hz.
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// `S[k]` of every channel, `[channel][bin]`, overwritten; `sqrt(W) s`.
    pub fn spectrum(&self, paths: &ScattererPaths, window_start_s: f64, out: &mut [Complex64]) -> Coverage {
        self.spectrum_in(paths, &[window_start_s], out)
    }

    /// The same with windows that start at these times after the emission, s: one for all pairs, or several
    /// ([`Self::in_windows`]).
    pub fn spectrum_in(&self, paths: &ScattererPaths, starts_s: &[f64], out: &mut [Complex64]) -> Coverage {
        out.fill(Complex64::ZERO);
        self.add_spectrum(self.waveform.as_ref(), paths, starts_s, out)
    }

    /// The same of emission `emission`, whatever that radiates.
    ///
    /// # Errors
    /// A signal that can no longer be read.
    pub fn spectrum_of(
        &self,
        emission: u64,
        paths: &ScattererPaths,
        starts_s: &[f64],
        out: &mut [Complex64],
    ) -> Result<Coverage, WaveformError> {
        let own = self.waveform.of_emission(emission)?;
        out.fill(Complex64::ZERO);
        Ok(self.add_spectrum(own.as_deref().unwrap_or(self.waveform.as_ref()), paths, starts_s, out))
    }

    /// Adds to `out` what windows receive of an emission that radiates something else, no longer than the
    /// pulse that this was made for.
    pub fn add_spectrum(
        &self,
        waveform: &dyn Waveform,
        paths: &ScattererPaths,
        starts_s: &[f64],
        out: &mut [Complex64],
    ) -> Coverage {
        let mut coverage = Coverage::default();
        let pulse_s = self.waveform.duration_s();
        for (pair, channels) in self.channels_of_pair.iter().enumerate() {
            let window_start_s = of_window(starts_s, &self.windows, pair).copied().unwrap_or(f64::NAN);
            for n in 0..paths.len() {
                let delay_s = paths.delay_s[pair][n];
                let place_s = paths.emission_offset_s[n] + delay_s - window_start_s;
                // A scatterer path that this pair does not see has no delay (NaN), or no amplitude.
                if !place_s.is_finite() || channels.iter().all(|&c| paths.amplitude[c][n] == Complex64::ZERO)
                {
                    continue;
                }
                if place_s <= -pulse_s || place_s >= self.window_s {
                    coverage.outside += 1;
                    if place_s < -pulse_s - self.guard_s || place_s > self.window_s + self.guard_s {
                        continue;
                    }
                } else if place_s < 0.0 || place_s + pulse_s > self.window_s {
                    coverage.cut += 1;
                }
                let carrier = phasor(-self.carrier_hz * delay_s);
                let rate = paths.delay_rate[pair][n] * self.rate_factor;
                let (shift_hz, stretch) = (self.carrier_hz * rate, 1.0 + rate);
                let factor = carrier * stretch;
                for &(k, f_hz, response) in &self.bins {
                    let pulse = waveform.spectrum(stretch * f_hz + shift_hz) * phasor(-f_hz * place_s);
                    let common = factor * pulse * response;
                    for &channel in channels {
                        out[channel * self.fft_len + k] += paths.amplitude[channel][n] * common;
                    }
                }
            }
        }
        coverage
    }
}

/// Reference A of one channel of one pair: `out[j]` is the sum over scatterer paths of
/// `a e^{-j 2 pi f0 tau} p(u) e^{-j 2 pi f0 r u}`, `u = (t_w + j/fs - o - tau)/(1 + r)`, overwritten.
pub fn raw_samples(
    waveform: &dyn Waveform,
    carrier_hz: f64,
    sample_rate_hz: f64,
    window_start_s: f64,
    paths: &ScattererPaths,
    pair: usize,
    channel: usize,
    out: &mut [Complex64],
) {
    out.fill(Complex64::ZERO);
    for n in 0..paths.len() {
        let delay_s = paths.delay_s[pair][n];
        let amplitude = paths.amplitude[channel][n] * phasor(-carrier_hz * delay_s);
        if !delay_s.is_finite() || amplitude == Complex64::ZERO {
            continue;
        }
        let rate = paths.delay_rate[pair][n];
        let shift_hz = carrier_hz * rate;
        let place_s = paths.emission_offset_s[n] + delay_s - window_start_s;
        for (j, sample) in out.iter_mut().enumerate() {
            let t_s = (j as f64 / sample_rate_hz - place_s) / (1.0 + rate);
            *sample += amplitude * waveform.sample(t_s) * phasor(-shift_hz * t_s);
        }
    }
}

/// What a pair has of what is one for all pairs, or one for each window.
pub(super) fn of_window<'a, T>(all: &'a [T], windows: &[usize], pair: usize) -> Option<&'a T> {
    match all {
        [one] => Some(one),
        _ => all.get(windows.get(pair).copied().unwrap_or(0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::waveform::Lfm;
    use crate::scene::radar::Sweep;

    #[test]
    fn fast_lengths_are_smooth_even_and_least() {
        let lengths: Vec<usize> = [0, 1, 7, 256, 354, 361, 1025].map(fast_len).to_vec();
        assert_eq!(lengths, [2, 2, 8, 256, 360, 384, 1080]);
    }

    #[test]
    fn the_period_holds_window_pulse_and_guards() {
        let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
        let echo = ReferenceEcho::new(pulse, 10e9, 100e6, 256, vec![0, 0]);
        assert_eq!(echo.fft_len(), 360);
    }

    #[test]
    fn a_pulse_longer_than_the_window_shows_its_part() {
        // 1 us of pulse, 16 samples of window; the same part of a window that holds it all.
        let pulse = Arc::new(Lfm::new(60e6, 1e-6, Sweep::Up).unwrap());
        let mut paths = ScattererPaths::new(1, 1, 1);
        paths.emission_offset_s.push(0.0);
        paths.delay_s[0].push(20.1e-6);
        paths.delay_rate[0].push(-1e-6);
        paths.amplitude[0].push(Complex64::ONE);
        let samples = |start_s: f64, window: usize| {
            let echo = ReferenceEcho::new(pulse.clone(), 10e9, 100e6, window, vec![0]);
            let n = echo.fft_len();
            let mut out = vec![Complex64::ZERO; n];
            let coverage = echo.spectrum(&paths, start_s, &mut out);
            nereus_fft::inverse(n).process(&mut out);
            out.truncate(window);
            (out.iter().map(|s| s * 100e6 / n as f64).collect::<Vec<_>>(), coverage)
        };
        let (whole, complete) = samples(20e-6, 256);
        let (part, cut) = samples(20.5e-6, 16);
        assert!(complete.is_complete());
        assert_eq!(cut, Coverage { cut: 1, outside: 0 });
        for (a, b) in part.iter().zip(&whole[50..]) {
            // Either folds back what the filter rings beyond its guard, of a unit pulse: below 1e-4.
            assert!((a - b).norm() < 2e-4, "{a} {b}");
        }
    }

    #[test]
    fn coverage_counts_what_the_window_does_not_hold() {
        let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up).unwrap());
        let echo = ReferenceEcho::new(pulse, 10e9, 100e6, 256, vec![0]);
        let mut paths = ScattererPaths::new(1, 1, 8);
        // Window of 2.56 us. Wholly in; cut at either end; outside near; outside far; silent; unseen.
        for (place_s, amplitude) in [
            (1e-6, 1.0),
            (-0.1e-6, 1.0),
            (2.4e-6, 1.0),
            (-0.4e-6, 1.0),
            (1e-3, 1.0),
            (-1e-3, 1.0),
            (9e-3, 0.0),
            (f64::NAN, 1.0),
        ] {
            paths.emission_offset_s.push(0.0);
            paths.delay_s[0].push(20e-6 + place_s);
            paths.delay_rate[0].push(0.0);
            paths.amplitude[0].push(Complex64::new(amplitude, 0.0));
        }
        let mut out = vec![Complex64::new(f64::NAN, 0.0); echo.fft_len()];
        let coverage = echo.spectrum(&paths, 20e-6, &mut out);
        assert_eq!(coverage, Coverage { cut: 2, outside: 3 });
        assert!(!coverage.is_complete());
        assert!(out.iter().all(|s| s.is_finite()));
        paths.clear();
        assert!(echo.spectrum(&paths, 20e-6, &mut out).is_complete());
        assert!(out.iter().all(|s| *s == Complex64::ZERO));
    }
}
