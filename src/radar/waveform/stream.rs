//! A continuous signal, radiated in segments without a gap.
//!
//! ```text
//! s(t) = sum_j s_j h(R t - j)                        the signal, j = 0, 1, ..  (shaping)
//! p_k(u) = sum_{k q <= j < (k+1) q} s_j h(R u - K - (j - k q))    segment k, u from its emission t_k = k T
//! P_k(f) = H(f/R)/R sum_j s_j e^{-j 2 pi f (K + j - k q)/R}
//! ```
//!
//! `R` rate of the samples, Hz; `T` interval of the emissions, s; `q = R T` samples an interval, whole or
//! not; `K` reach of the interpolation. Every sample belongs to one segment, so that all segments together
//! are `s(t - K/R)`, exactly: the signal as a converter's filter of finite length puts it out, `K` samples
//! late. A segment is `T + 2 K/R` long, for it has the tails of its samples.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use super::frequencies::Frequencies;
use super::gridded::{Gridded, Plan, Room};
use super::shaping::{REACH, kernel, response};
use super::{Waveform, WaveformError};
use crate::cpu::{Task, Variant};
use crate::radar::phasor::phasor;

/// Samples of a segment: the least, and the most.
pub const SEGMENT_SAMPLES: [f64; 2] = [64.0, 1_048_576.0];

/// Samples of the segments that are made together, at most: those of one may be more.
const SAMPLES_TOGETHER: u64 = 1 << 16;

/// Samples of a continuous signal, of mean power 1 once they are interpolated.
pub trait Signal: Send + Sync {
    /// What it is, in a word or two.
    fn name(&self) -> &str;

    /// Rate of the samples, Hz.
    fn rate_hz(&self) -> f64;

    /// Occupied bandwidth, Hz.
    fn bandwidth_hz(&self) -> f64;

    /// Fills in the samples from one on, whatever was asked before.
    ///
    /// # Errors
    /// A file that can no longer be read.
    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError>;

    /// A sample from which on it is as strong as it mostly is: what is planned goes by the segment there.
    fn typical(&self) -> u64 {
        0
    }

    /// Mean power of the first `all` samples over the greatest of `samples` in a row.
    fn steadiness(&self, _samples: u64, _all: u64) -> f64 {
        1.0
    }
}

/// A continuous signal in segments.
#[derive(Clone)]
pub struct Stream {
    signal: Arc<dyn Signal>,
    /// Samples of an interval, whole and the rest.
    whole: u64,
    rest: f64,
    duration_s: f64,
    plan: Plan,
    /// The segment of [`Signal::typical`].
    typical: Arc<Segment>,
}

/// One segment of a continuous signal.
struct Segment {
    name: String,
    rate_hz: f64,
    bandwidth_hz: f64,
    duration_s: f64,
    samples: Vec<Complex64>,
    /// When the first sample has its peak, samples after the emission.
    at: f64,
    plan: Plan,
    sum: Gridded,
    /// Of samples times their number from the middle.
    moment: OnceLock<Gridded>,
}

impl Stream {
    /// A signal whose segments leave at this interval, s.
    ///
    /// # Errors
    /// Segments of too few or too many samples, a file that can no longer be read.
    pub fn new(signal: Arc<dyn Signal>, interval_s: f64) -> Result<Self, WaveformError> {
        let rate_hz = signal.rate_hz();
        let samples = rate_hz * interval_s;
        // That of a whole number is that number.
        let samples = if (samples - samples.round()).abs() < 1e-9 { samples.round() } else { samples };
        let [least, most] = SEGMENT_SAMPLES;
        if !(least..=most).contains(&samples) {
            return Err(WaveformError::Segment { samples });
        }
        let (whole, rest) = (samples.floor(), samples.fract());
        let duration_s = interval_s + 2.0 * REACH as f64 / rate_hz;
        let plan = Plan::new(whole as usize + 2);
        let typical = (signal.typical() as f64 / samples) as u64;
        let typical = segment(&signal, &plan, duration_s, (whole as u64, rest), typical)?;
        Ok(Self { signal, whole: whole as u64, rest, duration_s, plan, typical: Arc::new(typical) })
    }
}

/// The first sample at or after `k` intervals, and how much later it is, samples.
fn bound((whole, rest): (u64, f64), k: u64) -> (u64, f64) {
    let beyond = k as f64 * rest;
    let (floor, fraction) = (beyond.floor(), beyond.fract());
    let before = k.wrapping_mul(whole).wrapping_add(floor as u64);
    if fraction > 0.0 { (before.wrapping_add(1), 1.0 - fraction) } else { (before, 0.0) }
}

fn segment(
    signal: &Arc<dyn Signal>,
    plan: &Plan,
    duration_s: f64,
    interval: (u64, f64),
    k: u64,
) -> Result<Segment, WaveformError> {
    let ((from, late), (to, _)) = (bound(interval, k), bound(interval, k.wrapping_add(1)));
    let mut samples = vec![Complex64::ZERO; to.wrapping_sub(from) as usize];
    signal.fill(from, &mut samples)?;
    Ok(segment_of(signal, (plan, &mut plan.room()), duration_s, late, samples))
}

fn segment_of(
    signal: &Arc<dyn Signal>,
    (plan, room): (&Plan, &mut Room),
    duration_s: f64,
    late: f64,
    samples: Vec<Complex64>,
) -> Segment {
    let sum = plan.gridded(samples.len(), |j| samples[j], room);
    Segment {
        name: signal.name().to_owned(),
        rate_hz: signal.rate_hz(),
        bandwidth_hz: signal.bandwidth_hz(),
        duration_s,
        samples,
        at: REACH as f64 + late,
        plan: plan.clone(),
        sum,
        moment: OnceLock::new(),
    }
}

impl Segment {
    /// From the emission to the sample in the middle, samples.
    #[inline(always)]
    fn middle(&self) -> f64 {
        self.at + (self.samples.len() / 2) as f64
    }

    /// `P_k(f)`.
    #[inline(always)]
    fn transform(&self, f_hz: f64) -> Complex64 {
        let v = f_hz / self.rate_hz;
        let [passed, _] = response(v);
        if passed == 0.0 {
            return Complex64::ZERO;
        }
        self.sum.at(v) * phasor(-v * self.middle()) * (passed / self.rate_hz)
    }
}

/// The transform of a segment at many frequencies.
struct Spectra<'a> {
    segment: &'a Segment,
    f_hz: &'a [f64],
    out: &'a mut [Complex64],
}

impl Task for Spectra<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { segment, f_hz, out } = self;
        for (f_hz, out) in f_hz.iter().zip(out) {
            *out = segment.transform(*f_hz);
        }
    }
}

impl Waveform for Segment {
    fn name(&self) -> &str {
        &self.name
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        self.transform(f_hz)
    }

    fn spectra(&self, f_hz: &[f64], out: &mut [Complex64]) {
        Variant::fastest().run(Spectra { segment: self, f_hz, out });
    }

    fn spectra_at(&self, at: &mut Frequencies, out: &mut [Complex64]) {
        at.read((&self.sum, self.rate_hz, self.middle()), out);
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        let place = t_s * self.rate_hz - self.at;
        let from = (place - REACH as f64).max(0.0) as usize;
        let to = ((place + REACH as f64 + 1.0).max(0.0) as usize).min(self.samples.len());
        let own = self.samples.get(from..to.max(from)).unwrap_or_default();
        own.iter().enumerate().map(|(i, sample)| sample * kernel(place - (from + i) as f64)).sum()
    }

    fn moment_spectrum(&self, f_hz: f64) -> Complex64 {
        let v = f_hz / self.rate_hz;
        let [passed, slope] = response(v);
        if passed == 0.0 && slope == 0.0 {
            return Complex64::ZERO;
        }
        let by_number = self.moment.get_or_init(|| {
            let middle = (self.samples.len() / 2) as f64;
            let of = |j: usize| self.samples[j] * (j as f64 - middle);
            self.plan.gridded(self.samples.len(), of, &mut self.plan.room())
        });
        let sum = self.sum.at(v);
        let off = self.middle() - 0.5 * self.duration_s * self.rate_hz;
        let of_samples = (by_number.at(v) + sum * off) * passed;
        let of_kernel = Complex64::I * sum * (slope / std::f64::consts::TAU);
        (of_samples + of_kernel) * phasor(-v * self.middle()) / (self.rate_hz * self.rate_hz)
    }
}

/// What is said of it, and its spectrum, are those of one segment: 0, unless that is much weaker than others.
impl Waveform for Stream {
    fn name(&self) -> &str {
        self.signal.name()
    }

    fn duration_s(&self) -> f64 {
        self.duration_s
    }

    fn bandwidth_hz(&self) -> f64 {
        self.signal.bandwidth_hz()
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        self.typical.spectrum(f_hz)
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        self.typical.sample(t_s)
    }

    fn moment_spectrum(&self, f_hz: f64) -> Complex64 {
        self.typical.moment_spectrum(f_hz)
    }

    fn of_emission(&self, emission: u64) -> Result<Option<Arc<dyn Waveform>>, WaveformError> {
        let Self { signal, plan, duration_s, .. } = self;
        let own = segment(signal, plan, *duration_s, (self.whole, self.rest), emission)?;
        Ok(Some(Arc::new(own)))
    }

    fn steadiness(&self, emissions: u64) -> f64 {
        let all = (self.whole as f64 + self.rest) * emissions as f64;
        self.signal.steadiness(self.whole, all as u64)
    }

    fn of_emissions(&self, emissions: Range<u64>) -> Result<Vec<Arc<dyn Waveform>>, WaveformError> {
        let Self { signal, plan, duration_s, whole, rest, .. } = self;
        let together = (SAMPLES_TOGETHER / (whole + 1)).max(1);
        let bounds: Vec<_> = (0..=together.min(emissions.end.saturating_sub(emissions.start)))
            .map(|n| bound((*whole, *rest), emissions.start.wrapping_add(n)))
            .collect();
        let [Some((from, _)), Some((to, _))] = [bounds.first(), bounds.last()] else { return Ok(Vec::new()) };
        let mut samples = vec![Complex64::ZERO; to.wrapping_sub(*from) as usize];
        signal.fill(*from, &mut samples)?;
        let mut room = plan.room();
        let cut = |of: &[(u64, f64)]| {
            let [begin, end] = [of[0].0, of[1].0].map(|sample| sample.wrapping_sub(*from) as usize);
            let own = samples[begin..end].to_vec();
            Arc::new(segment_of(signal, (plan, &mut room), *duration_s, of[0].1, own)) as Arc<dyn Waveform>
        };
        Ok(bounds.windows(2).map(cut).collect())
    }

    fn is_stream(&self) -> bool {
        true
    }
}
