//! The receiver: thermal noise, samples, converter.
//!
//! Noise. White at the input with `k T0 F` watts per hertz, shaped by the receive filter, added per bin of
//! the `N`-point transform of period `N/fs`:
//!
//! ```text
//! S[k] += H(f_k) sqrt(k T0 F N / (2 fs)) (x + j y) ,   x, y ~ N(0, 1) independent
//! s[j]  = (fs/N) sum_k e^{+j 2 pi j k/N} S[k]
//! ```
//!
//! so a sample has variance `k T0 F (fs/N) sum |H|^2 = k T0 B_n F`, `B_n = 0.875 fs`
//! ([`ReceiveFilter::noise_bandwidth_hz`]): circular Gaussian, sqrt(W). `T0 = 290 K`. The numbers of pulse
//! `n`, channel `c` come from the stream (seed, receiver noise, n, c), whatever was asked before and by whom.
//!
//! Of blocks that follow each other without a gap the noise has none either: white samples, 32 of them at
//! either end those of the next block, pass the filter, `S[k] += H(f_k) sqrt(k T0 F / (2 fs)) W[k]` with `W`
//! their transform.
//!
//! Between the two stands the [`front_end`](super::front_end), where it is not ideal.
//!
//! Converter. Mid-rise, I and Q apart, saturating: with `b` bits and full scale `A` the step is
//! `D = 2A/2^b`, the code `i = floor(x/D)` held in `[-2^(b-1), 2^(b-1) - 1]`, its value `(i + 1/2) D`.
//!
//! ```
//! use nereus::radar::receiver::thermal_noise_w;
//! use nereus::units::Decibels;
//! // 60 MHz: -126.2 dBW
//! let noise = Decibels::from_power_ratio(thermal_noise_w(60e6, Decibels(0.0)));
//! assert!((noise.0 + 126.19).abs() < 0.01);
//! ```

use std::f64::consts::TAU;
use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::{Complex32, Complex64};
use rand_distr::{Distribution, StandardNormal};

use super::clock::ChannelClock;
use super::filter::{ReceiveFilter, bin_frequency_hz};
use super::front_end::FrontEnd;
use super::waveform::Waveform;
use super::window::GUARD_SAMPLES;
use crate::pulse::converter::Level;
use crate::pulse::{Pulse, SampleFormat, Samples, flags};
use crate::rng::{Room, stream};
use crate::scene::Radar;
use crate::scene::radar::Adc;
use crate::units::{BOLTZMANN_J_PER_K, Decibels, NOISE_TEMPERATURE_K};

/// `k T0 B F`, W: thermal noise in a bandwidth.
pub fn thermal_noise_w(bandwidth_hz: f64, noise_figure: Decibels) -> f64 {
    BOLTZMANN_J_PER_K * NOISE_TEMPERATURE_K * bandwidth_hz * noise_figure.power_ratio()
}

/// From the spectra of a pulse to its samples.
#[derive(Clone)]
pub struct Receiver {
    seed: u64,
    sample_rate_hz: f64,
    window_samples: usize,
    channels: usize,
    /// Channels of a pulse behind those that are received.
    behind: usize,
    noise_variance_w: f64,
    /// `(bin, H sqrt(k T0 F N / (2 fs)))` where the filter passes anything; empty without noise.
    noise_bins: Vec<(usize, f64)>,
    adc: Option<Adc>,
    front_end: Option<FrontEnd>,
    transform: Arc<dyn Fft<f64>>,
    /// Of blocks whose noise goes on from one to the next.
    unbroken: Option<Arc<dyn Fft<f64>>>,
}

/// What a thread needs to receive without allocating.
#[derive(Clone, Debug)]
pub struct ReceiverScratch {
    transform: Vec<Complex64>,
    /// White samples of a block and of its neighbours; empty where noise is drawn bin by bin.
    white: Vec<Complex64>,
    /// Derivatives of the samples; empty without jitter.
    derivatives: Vec<Complex64>,
    /// By channel; empty without a converter.
    levels: Vec<Level>,
}

impl ReceiverScratch {
    /// What the converter of each channel was fed with since the last reset; empty without one.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Forgets that.
    pub fn reset_levels(&mut self) {
        self.levels.fill(Level::default());
    }
}

impl Receiver {
    /// The receiver of a radar, for spectra of `fft_len` bins in `channels` channels. `fft_len` holds the
    /// window and what must not wrap into it: take it from the reference echo.
    pub fn new(radar: &Radar, seed: u64, fft_len: usize, channels: usize) -> Self {
        let fs = radar.sample_rate_hz;
        let filter = ReceiveFilter::new(fs);
        let per_hz = radar.noise_figure_db.map(|db| thermal_noise_w(1.0, Decibels(db)));
        let noise_bins = per_hz.map_or_else(Vec::new, |w_per_hz| {
            let scale = (w_per_hz * fft_len as f64 / (2.0 * fs)).sqrt();
            (0..fft_len)
                .map(|k| (k, scale * filter.response(bin_frequency_hz(k, fft_len, fs))))
                .filter(|(_, s)| *s != 0.0)
                .collect()
        });
        Self {
            seed,
            sample_rate_hz: fs,
            window_samples: radar.window.samples,
            channels,
            behind: 0,
            noise_variance_w: per_hz.unwrap_or(0.0) * filter.noise_bandwidth_hz(),
            noise_bins,
            adc: radar.adc,
            front_end: None,
            transform: nereus_fft::inverse(fft_len),
            unbroken: radar.sent.as_ref().map(|_| nereus_fft::forward(fft_len)),
        }
    }

    /// The same with a front end that is not ideal, if it is not.
    pub fn with_front_end(self, front_end: Option<FrontEnd>) -> Self {
        Self { front_end, ..self }
    }

    /// What multiplies the echo of a pulse; `None` where all are alike.
    pub(crate) fn transmitted(&self, pulse: u64) -> Option<Complex64> {
        self.front_end.as_ref()?.transmitted(pulse)
    }

    /// The same for pulses that have more channels, which something else fills.
    pub fn with_behind(self, behind: usize) -> Self {
        Self { behind, ..self }
    }

    /// Bins of a spectrum.
    pub fn fft_len(&self) -> usize {
        self.transform.len()
    }

    /// Whether it receives without a gap.
    pub fn is_continuous(&self) -> bool {
        self.unbroken.is_some()
    }

    /// Samples of a spectrum, in its place.
    pub(super) fn inverse(&self, bins: &mut [Complex64], scratch: &mut ReceiverScratch) {
        let scale = self.sample_rate_hz / self.transform.len() as f64;
        self.transform.process_with_scratch(bins, &mut scratch.transform);
        bins.iter_mut().for_each(|bin| *bin *= scale);
    }

    /// Samples of the noise of a channel.
    pub(super) fn noise(
        &self,
        pulse_index: u64,
        channel: usize,
        bins: &mut [Complex64],
        scratch: &mut ReceiverScratch,
    ) {
        bins.fill(Complex64::ZERO);
        self.add_noise(pulse_index, channel, bins, scratch);
        self.inverse(bins, scratch);
    }

    /// Holds samples of a pulse from one place on as this receiver does; returns how many parts saturated.
    pub(super) fn put(
        &self,
        pulse: &mut Pulse,
        from: usize,
        count: usize,
        value: impl Fn(usize) -> Complex64,
    ) -> usize {
        let mut saturated = 0;
        match (&mut pulse.samples, &self.adc) {
            (Samples::Cf32(out), _) => {
                for (i, to) in out.iter_mut().skip(from).take(count).enumerate() {
                    let sample = value(i);
                    *to = Complex32::new(sample.re as f32, sample.im as f32);
                }
            }
            (Samples::Ci16(out), Some(adc)) => {
                for (i, to) in out.iter_mut().skip(from).take(count).enumerate() {
                    let sample = value(i);
                    *to = [sample.re, sample.im].map(|x| {
                        let (code, clipped) = convert(adc, x);
                        saturated += usize::from(clipped);
                        code
                    });
                }
            }
            (Samples::Ci16(_), None) => {}
        }
        saturated
    }

    /// Scratch memory for one thread.
    pub fn scratch(&self) -> ReceiverScratch {
        let levels = if self.adc.is_some() { self.channels } else { 0 };
        let forward = self.unbroken.as_ref();
        let transform = self.transform.get_inplace_scratch_len();
        let transform = transform.max(forward.map_or(0, |forward| forward.get_inplace_scratch_len()));
        ReceiverScratch {
            transform: vec![Complex64::ZERO; transform],
            white: vec![Complex64::ZERO; forward.map_or(0, |forward| forward.len())],
            derivatives: match self.front_end.as_ref().is_some_and(FrontEnd::jitters) {
                true => vec![Complex64::ZERO; self.transform.len()],
                false => Vec::new(),
            },
            levels: vec![Level::default(); levels],
        }
    }

    /// Complex sample rate, Hz.
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// Variance of the noise of a complex sample, W; zero for a noiseless receiver.
    pub fn noise_variance_w(&self) -> f64 {
        self.noise_variance_w
    }

    /// How this receiver holds samples: slots must be laid out for it.
    pub fn sample_format(&self) -> SampleFormat {
        if self.adc.is_some() { SampleFormat::Ci16 } else { SampleFormat::Cf32 }
    }

    /// Makes the samples of `pulse` from its spectra `[channel][bin]` (overwritten) and returns how many real
    /// or imaginary parts saturated the converter, which also sets or clears its flag.
    ///
    /// Allocates nothing, unless the slot was laid out for another format or size: then its samples are
    /// replaced.
    pub fn receive(
        &self,
        spectrum: &mut [Complex64],
        pulse: &mut Pulse,
        scratch: &mut ReceiverScratch,
    ) -> usize {
        self.receive_by(&[], spectrum, pulse, scratch)
    }

    /// The same with clock errors, one for each channel; none: ideal clocks.
    pub fn receive_by(
        &self,
        clocks: &[ChannelClock],
        spectrum: &mut [Complex64],
        pulse: &mut Pulse,
        scratch: &mut ReceiverScratch,
    ) -> usize {
        let fft_len = self.transform.len();
        let len = (self.channels + self.behind) * self.window_samples;
        match (&pulse.samples, &self.adc) {
            (Samples::Cf32(v), None) if v.len() == len => {}
            (Samples::Ci16(v), Some(_)) if v.len() == len => {}
            (_, None) => pulse.samples = Samples::Cf32(vec![Complex32::ZERO; len]),
            (_, Some(_)) => pulse.samples = Samples::Ci16(vec![[0; 2]; len]),
        }
        let scale = self.sample_rate_hz / fft_len as f64;
        let mut saturated = 0;
        for (channel, bins) in spectrum.chunks_exact_mut(fft_len).take(self.channels).enumerate() {
            if let Some(clock) = clocks.get(channel) {
                clock.delay(bins, |k| bin_frequency_hz(k, fft_len, self.sample_rate_hz));
            }
            self.add_noise(pulse.index, channel, bins, scratch);
            let ReceiverScratch { transform, derivatives, .. } = scratch;
            for (k, (derivative, bin)) in derivatives.iter_mut().zip(bins.iter()).enumerate() {
                *derivative =
                    bin * Complex64::new(0.0, TAU * bin_frequency_hz(k, fft_len, self.sample_rate_hz));
            }
            self.transform.process_with_scratch(bins, transform);
            if !derivatives.is_empty() {
                self.transform.process_with_scratch(derivatives, transform);
            }
            let taken = self.window_samples;
            if let Some(clock) = clocks.get(channel) {
                clock.turn(&mut bins[..taken]);
                let many = taken.min(derivatives.len());
                clock.turn(&mut derivatives[..many]);
            }
            if let Some(front_end) = &self.front_end {
                front_end.apply(pulse, channel, scale, &mut bins[..taken], derivatives);
            }
            let window = channel * self.window_samples..(channel + 1) * self.window_samples;
            match (&mut pulse.samples, &self.adc) {
                (Samples::Cf32(out), _) => {
                    for (to, from) in out[window].iter_mut().zip(bins.iter()) {
                        *to = Complex32::new((from.re * scale) as f32, (from.im * scale) as f32);
                    }
                }
                (Samples::Ci16(out), Some(adc)) => {
                    let (steps, mut level) = (scale / adc.step(), Level::default());
                    for (to, from) in out[window].iter_mut().zip(bins.iter()) {
                        let mut beyond = 0;
                        *to = [from.re, from.im].map(|x| {
                            let (code, clipped) = convert(adc, x * scale);
                            beyond += usize::from(clipped);
                            code
                        });
                        saturated += beyond;
                        level.take([from.re * steps, from.im * steps], beyond > 0);
                    }
                    if let Some(of) = scratch.levels.get_mut(channel) {
                        of.add(&level);
                    }
                }
                // The samples were replaced above.
                (Samples::Ci16(_), None) => {}
            }
        }
        pulse.flags &= !flags::ADC_SATURATED;
        if saturated > 0 {
            pulse.flags |= flags::ADC_SATURATED;
        }
        saturated
    }

    fn add_noise(
        &self,
        pulse_index: u64,
        channel: usize,
        bins: &mut [Complex64],
        scratch: &mut ReceiverScratch,
    ) {
        if self.noise_bins.is_empty() {
            return;
        }
        if let Some(forward) = &self.unbroken {
            return self.add_unbroken_noise((pulse_index, channel), forward.as_ref(), bins, scratch);
        }
        let mut numbers = stream(self.seed, Room::ReceiverNoise, pulse_index, channel as u64);
        for &(k, scale) in &self.noise_bins {
            let re: f64 = StandardNormal.sample(&mut numbers);
            let im: f64 = StandardNormal.sample(&mut numbers);
            bins[k] += Complex64::new(re, im) * scale;
        }
    }

    fn add_unbroken_noise(
        &self,
        (block, channel): (u64, usize),
        forward: &dyn Fft<f64>,
        bins: &mut [Complex64],
        scratch: &mut ReceiverScratch,
    ) {
        let ReceiverScratch { transform, white, .. } = scratch;
        let (n, len) = (self.window_samples, white.len());
        let edge = GUARD_SAMPLES.min(n / 2);
        white.fill(Complex64::ZERO);
        // Of each block the first samples are drawn first, then the last: all that its neighbours need.
        let mut draw = |block: u64, places: &mut dyn Iterator<Item = usize>, skipped: usize| {
            let mut numbers = stream(self.seed, Room::ReceiverNoise, block, channel as u64);
            let mut next =
                || Complex64::new(StandardNormal.sample(&mut numbers), StandardNormal.sample(&mut numbers));
            for _ in 0..skipped {
                next();
            }
            places.for_each(|place| white[place] = next());
        };
        draw(block, &mut (0..edge).chain(n - edge..n).chain(edge..n - edge), 0);
        draw(block.wrapping_add(1), &mut (n..n + edge), 0);
        draw(block.wrapping_sub(1), &mut (len - edge..len), edge);
        forward.process_with_scratch(white, transform);
        let share = 1.0 / (len as f64).sqrt();
        for &(k, scale) in &self.noise_bins {
            bins[k] += white[k] * (scale * share);
        }
    }

    /// The transmitted pulse after the receive filter, `q(i/fs)` with `Q(f) = P(f) H(f)`, unit amplitude, for
    /// every sample of the pulse: `i = 0 .. ceil(Tc fs) - 1`.
    ///
    /// Entry 0 is the start of the pulse (no lead), so `sum_i s[j + i] conj(replica[i])` peaks at the `j` of
    /// the scatterer path's delay, where it is `a e^{-j 2 pi f0 tau} sum |replica|^2`. What the filter rings
    /// before and after the pulse is cut on both sides, so the peak stays where it is (within 1.5e-2 sample
    /// for a short chirp).
    pub fn replica(&self, waveform: &dyn Waveform) -> Vec<Complex32> {
        let fs = self.sample_rate_hz;
        let len = waveform.span_samples(fs);
        // 4096 samples of room: what rings that far has fallen by t^-3 to 1e-9.
        let period = (2 * len + 4096).next_power_of_two();
        let filter = ReceiveFilter::new(fs);
        let mut bins: Vec<Complex64> = (0..period)
            .map(|k| {
                let f_hz = bin_frequency_hz(k, period, fs);
                let response = filter.response(f_hz);
                if response == 0.0 { Complex64::ZERO } else { waveform.spectrum(f_hz) * response }
            })
            .collect();
        nereus_fft::inverse(period).process(&mut bins);
        let scale = fs / period as f64;
        bins.iter().take(len).map(|q| Complex32::new((q.re * scale) as f32, (q.im * scale) as f32)).collect()
    }
}

/// The code of a voltage, and whether it lies outside full scale.
fn convert(adc: &Adc, x: f64) -> (i16, bool) {
    let half = f64::from(1u32 << (adc.bits - 1));
    let code = (x / adc.step()).floor();
    let held = code.clamp(-half, half - 1.0);
    (held as i16, held != code)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_one_and_sixteen_bits() {
        let one = Adc { bits: 1, full_scale: 2.0 };
        assert_eq!(one.step(), 2.0);
        for (x, expected) in [
            (0.0, (0, false)),
            (-1e-9, (-1, false)),
            (1.999, (0, false)),
            (2.0, (0, true)),
            (-2.1, (-1, true)),
        ] {
            assert_eq!(convert(&one, x), expected, "{x}");
        }
        let sixteen = Adc { bits: 16, full_scale: 1.0 };
        for (x, expected) in [
            (-1.0, (-32768, false)),
            (1.0 - 1e-9, (32767, false)),
            (1.0, (32767, true)),
            (-1.0001, (-32768, true)),
            (f64::INFINITY, (32767, true)),
        ] {
            assert_eq!(convert(&sixteen, x), expected, "{x}");
        }
    }
}
