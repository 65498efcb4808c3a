//! Windows from the spectra of emissions, each of which radiates something else.
//!
//! ```text
//! e_k[i] = fs/N sum_m S_k[m] e^{j 2 pi i m / N}     echo of emission k, sample i from t_k + t_0 on
//! s[j]   = sum_k e_k[j - d_k] ,   d_k = (t_k + t_0 - t_n - t_w) fs
//! ```
//!
//! `t_k` emissions, `t_n + t_w` the first sample of the window. All of an emission's echo lies within `N`, so
//! it is transformed once for all windows that receive a part of it. What `d_k` has beyond a whole number
//! turns the spectrum.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex64;

use super::refit::fade;
use crate::radar::filter::bin_frequency_hz;
use crate::radar::waveform::Waveform;
use crate::radar::window::{GUARD_SAMPLES, RINGING_OF_PULSES};
use crate::units::fast_len;

/// Samples kept beyond either end of what an emission returns, of segments and of pulses: what the receive
/// filter rings. Windows that receive nothing but that of a pulse show where it is cut off.
const RINGING_SAMPLES: [usize; 2] = [2 * GUARD_SAMPLES, RINGING_OF_PULSES];
/// Rests of a sample that are as good as equal.
const EQUAL: f64 = 1e-7;

/// How the echo of every emission lies on the axis of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// From an emission to the origin of its spectrum, s: the last sample that the shortest delay has of it.
    pub origin_s: f64,
    /// Samples from there to the end of what the longest delay has.
    pub samples: usize,
    /// Samples of an emission.
    pub pulse: usize,
    /// Samples that are kept beyond either end.
    pub ringing: usize,
}

impl Span {
    /// For delays within these, s, of such emissions.
    pub fn new((least_s, most_s): (f64, f64), waveform: &dyn Waveform, sample_rate_hz: f64) -> Self {
        let pulse = waveform.span_samples(sample_rate_hz);
        let ringing = Self::ringing(waveform);
        // Origins are whole samples after their emissions.
        let first = (least_s * sample_rate_hz).floor();
        let samples = (most_s * sample_rate_hz - first).ceil().max(0.0) as usize + 1;
        Self { origin_s: (first + pulse as f64) / sample_rate_hz, samples, pulse, ringing }
    }

    /// Samples kept beyond either end.
    pub fn ringing(waveform: &dyn Waveform) -> usize {
        RINGING_SAMPLES[usize::from(!waveform.is_stream())]
    }

    /// Samples of an echo, from the origin on.
    fn reach(&self) -> Range<isize> {
        let ringing = self.ringing as isize;
        -(self.pulse as isize) - ringing..self.samples as isize + ringing
    }
}

/// When the windows of channels start, s, by the pairs of these: one for all, or each its own.
pub(crate) fn channel_starts<'a>(
    starts_s: &'a [f64],
    windows: &'a [usize],
    channel_pairs: &'a [usize],
) -> impl Iterator<Item = f64> + 'a {
    channel_pairs.iter().map(|pair| {
        let window = windows.get(*pair).copied().filter(|_| starts_s.len() > 1).unwrap_or(0);
        starts_s.get(window).copied().unwrap_or(0.0)
    })
}

/// Adds echoes of emissions in windows.
pub(crate) struct Joined {
    sample_rate_hz: f64,
    window_samples: usize,
    span: Span,
    /// Of an emission's spectrum.
    len: usize,
    inverse: Arc<dyn Fft<f64>>,
    forward: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
    /// `[channel][sample]` of a window and its guards.
    sums: Vec<Complex64>,
    /// Memory of echoes that are no longer needed.
    spare: Vec<Vec<Complex64>>,
}

/// The echo of an emission, `[channel][sample]`.
pub(crate) struct Echo {
    pub emission: u64,
    rest: f64,
    samples: Vec<Complex64>,
}

impl Joined {
    /// Bins of the spectrum of a window of so many samples.
    pub fn out_len(window_samples: usize) -> usize {
        fast_len(window_samples + 2 * GUARD_SAMPLES)
    }

    /// Of spectra of `len` bins.
    pub fn new(span: Span, sample_rate_hz: f64, window_samples: usize, len: usize) -> Self {
        let (inverse, forward) =
            (nereus_fft::inverse(len), nereus_fft::forward(Self::out_len(window_samples)));
        let scratch = inverse.get_inplace_scratch_len().max(forward.get_inplace_scratch_len());
        let (scratch, sums, spare) = (vec![Complex64::ZERO; scratch], Vec::new(), Vec::new());
        Self { sample_rate_hz, window_samples, span, len, inverse, forward, scratch, sums, spare }
    }

    /// From the first sample of a window to the origin of an emission so long after its pulse, samples: whole
    /// and the rest. `start_s`: from the pulse to the window.
    fn place(&self, offset_s: f64, start_s: f64) -> (isize, f64) {
        let samples = (offset_s + self.span.origin_s - start_s) * self.sample_rate_hz;
        let whole = samples.round();
        (whole as isize, samples - whole)
    }

    /// From the spectra of the channels of an emission, later by the rest of a sample, to its samples.
    fn echo(&mut self, emission: u64, rest: f64, mut spectrum: Vec<Complex64>) -> Echo {
        let (len, scale) = (self.len, self.sample_rate_hz / self.len as f64);
        for bins in spectrum.chunks_exact_mut(len) {
            if rest.abs() > EQUAL {
                for (k, bin) in bins.iter_mut().enumerate() {
                    *bin *= Complex64::cis(-TAU * rest * bin_frequency_hz(k, len, 1.0));
                }
            }
            self.inverse.process_with_scratch(bins, &mut self.scratch);
            bins.iter_mut().for_each(|sample| *sample *= scale);
        }
        Echo { emission, rest, samples: spectrum }
    }

    /// Empties the windows of so many channels.
    pub fn clear(&mut self, channels: usize) {
        self.sums.clear();
        self.sums.resize(channels * (self.window_samples + 2 * GUARD_SAMPLES), Complex64::ZERO);
    }

    /// Forgets all echoes but those of some emissions; their memory stays.
    pub fn keep(&mut self, echoes: &mut Vec<Echo>, emissions: &Range<u64>) {
        let gone = echoes.extract_if(.., |echo| !emissions.contains(&echo.emission));
        self.spare.extend(gone.map(|echo| echo.samples));
    }

    /// Adds the channels of an emission so long after the pulse of their windows, which start so long after
    /// that pulse, s; its echoes that are known are kept, others are made of the spectra of its channels,
    /// `[channel][bin]`, which `fill` writes over what it is given.
    pub fn take<E>(
        &mut self,
        echoes: &mut Vec<Echo>,
        (emission, offset_s): (u64, f64),
        starts_s: impl Iterator<Item = f64>,
        mut fill: impl FnMut(&mut [Complex64]) -> Result<(), E>,
    ) -> Result<(), E> {
        for (channel, start_s) in starts_s.enumerate() {
            let (later, rest) = self.place(offset_s, start_s);
            let known = echoes.iter().position(|echo| echo.is(emission, rest));
            let at = match known {
                Some(at) => at,
                None => {
                    let channels = self.sums.len() / (self.window_samples + 2 * GUARD_SAMPLES);
                    let mut bins = self.spare.pop().unwrap_or_default();
                    bins.resize(channels * self.len, Complex64::ZERO);
                    fill(&mut bins)?;
                    echoes.push(self.echo(emission, rest, bins));
                    echoes.len() - 1
                }
            };
            self.add(channel, &echoes[at], later);
        }
        Ok(())
    }

    /// Adds a channel of an echo whose origin lies so many samples after the first of the window.
    fn add(&mut self, channel: usize, echo: &Echo, later: isize) {
        let (room, guard) = (self.window_samples + 2 * GUARD_SAMPLES, GUARD_SAMPLES as isize);
        let samples = &echo.samples[channel * self.len..][..self.len];
        let sums = &mut self.sums[channel * room..][..room];
        let reach = self.span.reach();
        // Samples of the echo that fall on the window and its guards.
        let from = (reach.start).max(-guard - later);
        let to = reach.end.min(room as isize - guard - later);
        for i in from..to {
            let own = if i < 0 { i + self.len as isize } else { i };
            sums[(i + later + guard) as usize] += samples[own as usize];
        }
    }

    /// The spectrum of a channel.
    pub fn spectrum(&mut self, channel: usize, out: &mut [Complex64]) {
        let (room, guard) = (self.window_samples + 2 * GUARD_SAMPLES, GUARD_SAMPLES);
        let sums = &self.sums[channel * room..][..room];
        out.fill(Complex64::ZERO);
        let len = out.len();
        let scale = self.sample_rate_hz.recip();
        for (j, sample) in sums.iter().enumerate() {
            let beyond = guard.saturating_sub(j).max((j + 1).saturating_sub(guard + self.window_samples));
            let to = if j < guard { len + j - guard } else { j - guard };
            out[to] = sample * (scale * fade(beyond));
        }
        self.forward.process_with_scratch(out, &mut self.scratch);
    }
}

impl Echo {
    /// Whether it is that of an emission, later by such a rest of a sample.
    fn is(&self, emission: u64, rest: f64) -> bool {
        self.emission == emission && (self.rest - rest).abs() < EQUAL
    }
}
