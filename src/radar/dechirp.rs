//! Dechirp on reception: what is received times the conjugate of the waveform, delayed.
//!
//! ```text
//! y(t) = r(t) conj p(t - t_r) ,   s[j] = (h * y)(t_w + j/fs)
//! ```
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `t` | time after the emission of the window's own pulse | s |
//! | `r` | what is received, mixed with the carrier, behind the front end | sqrt(W) |
//! | `p` | waveform, 0 before its begin and after its end | - |
//! | `t_r` | delay of the reference | s |
//! | `h` | receive filter of the sample rate `fs` ([`ReceiveFilter`]) | Hz |
//! | `t_w` | first sample | s |
//!
//! A linear sweep of rate `mu` that comes back with the delay `tau` gives a tone while both last, from
//! `max(tau, t_r)` to `min(tau, t_r) + Tc`:
//!
//! ```text
//! y(t) = a e^{-j 2 pi f0 tau} e^{j 2 pi f_b (t - Tc/2)} e^{j pi mu (tau^2 - t_r^2)} ,
//! f_b = -mu (tau - t_r)
//! ```
//!
//! so that a rising sweep has negative beat frequencies beyond the reference, and positive ones before it.
//! Doppler adds `-f0 dtau/dt`, as it does elsewhere. Tones beyond half the sample rate are filtered away.
//!
//! The front end is the receive filter of a rate [`factor`] times as high, so that it passes at least 0.6 of
//! the bandwidth to either side. Echoes are made at that rate, in windows that begin and end [`LEAD`] samples
//! of `fs` earlier and later, for what the filter rings into the window. All that is received goes this way:
//! echoes, the direct path, emitters. Noise is white before and after, and is added behind.

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::Complex64;

use super::filter::{ReceiveFilter, bin_frequency_hz};
use super::phasor::phasor;
use super::waveform::Waveform;
use crate::pulse::Pulse;
use crate::scene::Radar;
use crate::scene::radar::{Gate, Window};
use crate::units::{fast_len, next_product_of};

/// Samples before and after a window that the filter looks at.
pub const LEAD: usize = super::window::GUARD_SAMPLES;
/// Rate of the front end over the bandwidth, at least.
const WIDER: f64 = 1.5;

/// How often the front end's rate holds the sample rate: the least whole number without large primes whose
/// product with it is 1.5 times the bandwidth.
pub fn factor(bandwidth_hz: f64, sample_rate_hz: f64) -> usize {
    let least = (WIDER * bandwidth_hz / sample_rate_hz).ceil().clamp(1.0, 1e9) as usize;
    next_product_of(&[2, 3, 5], least)
}

/// The radar as its front end receives: `None` of a radar without dechirp.
pub(crate) fn front_end(radar: &Radar, bandwidth_hz: f64) -> Option<Radar> {
    radar.dechirp?;
    let times = factor(bandwidth_hz, radar.sample_rate_hz);
    let lead_s = LEAD as f64 / radar.sample_rate_hz;
    let earlier = |gate: &Gate| match gate {
        Gate::Fixed { start_s } => Gate::Fixed { start_s: start_s - lead_s },
        Gate::Follow { aim, lead_s: own_s, aim_from } => {
            Gate::Follow { aim: aim.clone(), lead_s: own_s + lead_s, aim_from: *aim_from }
        }
    };
    let mut wide = radar.clone();
    wide.dechirp = None;
    wide.sample_rate_hz = times as f64 * radar.sample_rate_hz;
    wide.window =
        Window { samples: times * (radar.window.samples + 2 * LEAD), gate: earlier(&radar.window.gate) };
    for receiver in &mut wide.receivers {
        receiver.gate = receiver.gate.as_ref().map(earlier);
    }
    Some(wide)
}

/// A bin that the receive filter passes.
#[derive(Clone, Copy, Debug)]
struct Bin {
    k: usize,
    wide_k: usize,
    /// Filter, scale, and the way from the first sample of the front end to that of the window.
    factor: Complex64,
}

/// From spectra of the front end to those of the receiver. Immutable, shared by all threads.
#[derive(Clone)]
pub(crate) struct Dechirp {
    delay_s: f64,
    lead_s: f64,
    wide_hz: f64,
    wide_samples: usize,
    waveform: Arc<dyn Waveform>,
    /// Receiver of each channel.
    receivers: Vec<usize>,
    inverse: Arc<dyn Fft<f64>>,
    forward: Arc<dyn Fft<f64>>,
    bins: Vec<Bin>,
    fft_len: usize,
}

/// What a thread needs to dechirp without allocating.
pub(crate) struct DechirpScratch {
    received: Vec<Complex64>,
    mixed: Vec<Complex64>,
    transform: Vec<Complex64>,
    /// Conjugate of the reference, and for which start of the window, s.
    reference: (f64, Vec<Complex64>),
    /// Spectra of all channels.
    spectrum: Vec<Complex64>,
}

impl Dechirp {
    /// Of a radar and its front end, whose spectra have so many bins.
    pub fn new(radar: &Radar, wide: &Radar, wide_len: usize, waveform: Arc<dyn Waveform>) -> Option<Self> {
        let delay_s = radar.dechirp?.delay_s;
        let (fs, wide_hz) = (radar.sample_rate_hz, wide.sample_rate_hz);
        let fft_len = fast_len(radar.window.samples + 2 * LEAD);
        let times = (wide_hz / fs).round() as usize;
        let filter = ReceiveFilter::new(fs);
        let of = |k: usize| {
            let f_hz = bin_frequency_hz(k, fft_len, fs);
            let wide_k = if f_hz < 0.0 { (times - 1) * fft_len + k } else { k };
            let factor = phasor(f_hz * LEAD as f64 / fs) * (filter.response(f_hz) / wide_hz);
            Bin { k, wide_k, factor }
        };
        Some(Self {
            delay_s,
            lead_s: LEAD as f64 / fs,
            wide_hz,
            wide_samples: wide.window.samples,
            waveform,
            receivers: radar.channels.iter().map(|channel| channel.receiver).collect(),
            inverse: nereus_fft::inverse(wide_len),
            forward: nereus_fft::forward(times * fft_len),
            bins: (0..fft_len).map(of).filter(|bin| bin.factor != Complex64::ZERO).collect(),
            fft_len,
        })
    }

    /// Bins of a spectrum of the front end.
    pub fn wide_len(&self) -> usize {
        self.inverse.len()
    }

    /// Bins of a spectrum behind it.
    pub fn fft_len(&self) -> usize {
        self.fft_len
    }

    /// Scratch memory for one thread.
    pub fn scratch(&self) -> DechirpScratch {
        let lens = [self.inverse.get_inplace_scratch_len(), self.forward.get_inplace_scratch_len()];
        let of = |len: usize| vec![Complex64::ZERO; len];
        DechirpScratch {
            received: of(self.inverse.len()),
            mixed: of(self.forward.len()),
            transform: of(lens[0].max(lens[1])),
            reference: (f64::NAN, of(self.wide_samples)),
            spectrum: of(self.receivers.len() * self.fft_len),
        }
    }

    /// Puts the windows of a record where its samples begin.
    pub fn place(&self, pulse: &mut Pulse) {
        pulse.window_start_s += self.lead_s;
        pulse.receiver_window_start_s.iter_mut().for_each(|start_s| *start_s += self.lead_s);
    }

    /// The spectra of all channels of a placed pulse, from those of the front end.
    pub fn apply<'s>(
        &self,
        wide: &[Complex64],
        pulse: &Pulse,
        scratch: &'s mut DechirpScratch,
    ) -> &'s mut [Complex64] {
        let DechirpScratch { received, mixed, transform, reference, spectrum } = scratch;
        let scale = self.wide_hz / self.inverse.len() as f64;
        spectrum.fill(Complex64::ZERO);
        let channels = wide.chunks_exact(self.inverse.len()).zip(spectrum.chunks_exact_mut(self.fft_len));
        for ((own, out), receiver) in channels.zip(&self.receivers) {
            let start_s = pulse.window_start_of(*receiver) - self.lead_s - self.delay_s;
            if reference.0 != start_s {
                let of = |j: usize| self.waveform.sample(start_s + j as f64 / self.wide_hz).conj();
                reference.1.iter_mut().enumerate().for_each(|(j, value)| *value = of(j));
                reference.0 = start_s;
            }
            received.copy_from_slice(own);
            self.inverse.process_with_scratch(received, transform);
            mixed.fill(Complex64::ZERO);
            for ((to, from), conjugate) in mixed.iter_mut().zip(received.iter()).zip(&reference.1) {
                *to = from * conjugate * scale;
            }
            self.forward.process_with_scratch(mixed, transform);
            for bin in &self.bins {
                out[bin.k] = mixed[bin.wide_k] * bin.factor;
            }
        }
        spectrum
    }
}
