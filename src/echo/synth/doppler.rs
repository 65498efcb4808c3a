//! Doppler within a pulse.
//!
//! The echo of a scatterer path carries `e^{-j 2 pi nu t'}`, `nu = f0 r`, while the pulse `p(t')` passes; in
//! frequency, `P(f + nu)`. A block and pair have a mean rate: with `nu = nu0 + nu'`, `P(f + nu0)` is in the
//! replica, exact and free. What is left, `nu'`, is done in one of four ways (`c = Tc/2`,
//! `p0 = p e^{-j 2 pi nu0 t'}`):
//!
//! - **[`Doppler::Mean`]** `p0 e^{-j 2 pi nu' c}`: the right phase in mid-pulse. Any waveform; relative rms
//!   error `2 pi nu' Tc / sqrt 12`.
//! - **[`Doppler::Shift`]** for a linear sweep of rate `mu`. Completing the square, with `D = nu'/mu`,
//!   `p0(t' - D) e^{-j 2 pi (nu' c + nu'^2/(2 mu) + nu0 nu'/mu)}` is `p0(t') e^{-j 2 pi nu' t'}` wherever
//!   both pulses are on: a delay and a phase, which cost nothing. They differ by a strip of length `D` at
//!   either end. Without a filter the strips have the share `2 |D| / Tc = 2 |nu'| / B` of the energy; while
//!   `|D| fs << 1` they are two impulses that the receive filter cuts to `2 D^2 B_n / Tc`, that is rms
//!   `(nu'/B) sqrt(2 B_n Tc)`, `B_n = 0.875 fs`.
//! - **[`Doppler::Taylor`]** `e^{-j 2 pi nu' c} [p0 - j 2 pi nu' (t' - c) p0]`: a second layer of grids with
//!   weights `nu'` and the spectrum of `(t' - c) p0`, which is `(j/2 pi) d/df` of the centred spectrum
//!   (8-point central differences, step `1/(16 Tc)`, relative error 4e-9). Any waveform, twice the cost;
//!   error `(2 pi nu' Tc)^2 / (2 sqrt 80)`.
//! - **[`Doppler::ShiftTaylor`]** for a linear sweep: `Shift`, and a second layer with the strips to first
//!   order in `nu'`. It is that of `Taylor` less what the shift has of it already,
//!   `(t' - c) p0 - (f + nu0)/mu p0` in frequency, which vanishes but for both ends of the pulse. Twice the
//!   cost of `Shift`, whose error is left times `pi |D| sqrt(B_n^2/12 + B^2/4)`: of the long pulse below -100
//!   dB at 100 Hz, -60 dB at 1 kHz.
//!
//! [`error_power`] for `B = 60` MHz, `fs = 100` MHz, mean 3 kHz (which is gone), dB:
//!
//! | `B Tc` | `nu'` | Mean | Shift | Taylor |
//! | --- | --- | --- | --- | --- |
//! | 20 | 1 kHz | -64.5 | -78 | -132 |
//! | 20 | 7.4 kHz | -47 | -60.5 | -98 |
//! | 20 | 14.8 kHz | -41 | -54.5 | -86 |
//! | 1e4 | 1 kHz | useless | -51 | useless |
//! | 1e4 | 7.4 kHz | useless | -37.5 | useless |
//! | 1e4 | 14.8 kHz | useless | -33.6 | useless |
//!
//! It evaluates `sum |H (P(f + nu) - approximation)|^2 / sum |H P|^2` itself, for any waveform. The strips of
//! `|D| fs` above 1 (the last two rows) tend to `2 |nu'| / B`. A scene whose spread of Doppler is too wide
//! for its pulse is split: scatterer paths sorted into bands of Doppler, a block each, spectra added. A
//! scatterer path whose `nu'` changes within the block is followed: its delay and phase are set at every
//! node.
//!
//! # Stretch of the envelope
//!
//! A delay that grows at the rate `r` stretches the pulse with its carrier: the reference has
//! `(1 + r) P((1 + r) f + f0 r)` ([`reference`](mod@crate::echo::reference)). With [`Envelope::Stretched`]
//! the replica has the stretch of the mean rate, exact and free. The rest `r' = nu'/f0` moves the middle of
//! the pulse by `r' c`, which is a delay, and turns the middle phase of a linear sweep by the mean of the
//! quadratic term, `-mu r' Tc^2/12` turns: both are free. What is left of a linear sweep is
//! `2 pi B Tc |r'| / sqrt 180`, rms.
//!
//! [`Envelope::Rigid`] has no stretch at all, and costs `2 pi B Tc |r| / sqrt 30` ([`rigid_error_power`]) of
//! a linear sweep: -89 dB for `B Tc = 20` at `r` = 1.5e-6 (aircraft). It is taken where the plan finds that
//! this does not count.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::radar::filter::{ReceiveFilter, bin_frequency_hz};
use crate::radar::phasor::phasor;
use crate::radar::waveform::{Waveform, looked_at};

/// Bins that are looked at of a continuous signal.
const SAMPLED_BINS: usize = 2048;

/// What is done about the Doppler of a scatterer path that differs from the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Doppler {
    /// The right phase in the middle of the pulse.
    Mean,
    /// A delay and a phase; linear sweeps only.
    Shift,
    /// Two layers, first order about the middle of the pulse.
    Taylor,
    /// A delay and a phase, and a second layer with what these leave to first order; linear sweeps only.
    ShiftTaylor,
}

impl Doppler {
    /// Whether it takes a linear sweep.
    pub fn needs_sweep(self) -> bool {
        matches!(self, Self::Shift | Self::ShiftTaylor)
    }

    /// Whether it takes a second layer of grids.
    pub fn has_moments(self) -> bool {
        matches!(self, Self::Taylor | Self::ShiftTaylor)
    }
}

/// What is done about the stretch of the pulse by a delay that changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Envelope {
    /// Nothing: the envelope keeps its length.
    Rigid,
    /// That of the mean rate is exact; off the mean the pulse has the right middle.
    Stretched,
}

/// A scatterer path's Doppler off the mean as a delay and a phase; all of them linear in it but for the
/// square of a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Correction {
    /// Turns per Hz, the sign reversed: the time from the beginning of the pulse at which its phase is right.
    pub middle_s: f64,
    /// Half the length of the pulse, s.
    half_s: f64,
    /// Rate of the sweep whose Doppler becomes a delay, Hz/s.
    sweep: Option<f64>,
    /// Frequency in the middle of the sweep, Hz.
    sweep_middle_hz: f64,
    /// Stretch per Hz, 1/Hz: `1/f0`, 0 of rigid envelopes.
    stretch: f64,
}

impl Correction {
    pub fn new(doppler: Doppler, envelope: Envelope, waveform: &dyn Waveform, carrier_hz: f64) -> Self {
        let half_s = 0.5 * waveform.duration_s();
        let mu = waveform.sweep_rate_hz_per_s();
        let stretch = match envelope {
            Envelope::Rigid => 0.0,
            Envelope::Stretched => 1.0 / carrier_hz,
        };
        Self {
            middle_s: half_s + mu.unwrap_or(0.0) * half_s * half_s * stretch / 3.0,
            half_s,
            sweep: mu.filter(|_| doppler.needs_sweep()),
            sweep_middle_hz: waveform.sweep_middle_hz(),
            stretch,
        }
    }

    /// Spectrum of the second layer at a bin of frequency `f_hz`, where an echo of the mean has the spectrum
    /// of the pulse at `at_hz`, per Hz off the mean: the derivative of what this leaves,
    ///
    /// `-j 2 pi [(1 + f/f0) M - (mu c^2/(3 f0) + (f + nu0 - f_c)/mu) P]` ,
    ///
    /// `M` the spectrum of `(t' - c) p`, `f_c` the middle of the sweep; without `1/mu` where nothing is
    /// shifted, without `1/f0` of rigid envelopes.
    pub fn moment(&self, waveform: &dyn Waveform, (f_hz, at_hz): (f64, f64), mean_hz: f64) -> Complex64 {
        let shifted_s = self.sweep.map_or(0.0, |mu| (f_hz + self.about_hz(mean_hz)) / mu);
        // One of several pulses in turn may be shorter than what this was made for.
        let half_s = 0.5 * waveform.duration_s();
        let earlier_s = f_hz * self.stretch * (half_s - self.half_s);
        let known = waveform.spectrum(at_hz) * (self.middle_s - half_s - earlier_s + shifted_s);
        let all = waveform.moment_spectrum(at_hz) * (1.0 + f_hz * self.stretch);
        Complex64::I * (-2.0 * PI) * (all - known)
    }

    /// A mean Doppler from the middle of the sweep on, Hz.
    pub fn about_hz(&self, mean_hz: f64) -> f64 {
        mean_hz - self.sweep_middle_hz
    }

    /// Delay per Hz that replaces Doppler, s, and delay per Hz in all.
    pub fn delays(&self) -> [f64; 2] {
        let shifted = self.sweep.map_or(0.0, |mu| 1.0 / mu);
        // The middle of a stretched pulse.
        [shifted, shifted + self.half_s * self.stretch]
    }

    /// `(turns, delay in s)` to be added to a scatterer path for the part of its Doppler that is not the
    /// mean's.
    pub fn of(&self, mean_hz: f64, residual_hz: f64) -> (f64, f64) {
        let [shifted, all] = self.delays();
        let shift = residual_hz * shifted * (0.5 * residual_hz + self.about_hz(mean_hz));
        (-self.middle_s * residual_hz - shift, residual_hz * all)
    }
}

/// Frequency at which the pulse's spectrum is that of an echo of Doppler `nu = f0 r`, and what multiplies it.
pub(super) fn stretched(envelope: Envelope, carrier_hz: f64, f_hz: f64, doppler_hz: f64) -> (f64, f64) {
    match envelope {
        Envelope::Rigid => (f_hz + doppler_hz, 1.0),
        Envelope::Stretched => {
            let stretch = 1.0 + doppler_hz / carrier_hz;
            (stretch * f_hz + doppler_hz, stretch)
        }
    }
}

/// `|error|^2 / |echo|^2` of an echo of delay rate `rate` whose envelope is left as it was, after the receive
/// filter; of pulses in turn, the largest.
pub fn rigid_error_power(
    waveform: &dyn Waveform,
    carrier_hz: f64,
    sample_rate_hz: f64,
    fft_len: usize,
    rate: f64,
) -> f64 {
    let step = step_of(waveform, fft_len);
    let of = |pulse: &dyn Waveform| {
        relative_power(passed(sample_rate_hz, fft_len).step_by(step).map(|(f_hz, response)| {
            let [exact, rigid] = [Envelope::Stretched, Envelope::Rigid].map(|envelope| {
                let (at_hz, factor) = stretched(envelope, carrier_hz, f_hz, carrier_hz * rate);
                pulse.spectrum(at_hz) * factor
            });
            (response, exact, rigid)
        }))
    };
    looked_at(waveform).into_iter().map(of).fold(0.0, f64::max)
}

/// Bins from one to the next that says enough: of the long transforms of a continuous signal, whose spectrum
/// is random, some thousand do.
fn step_of(waveform: &dyn Waveform, fft_len: usize) -> usize {
    if waveform.is_stream() { (fft_len / SAMPLED_BINS).max(1) } else { 1 }
}

/// Frequencies of the bins of a transform that the receive filter passes, and how much of their power.
fn passed(sample_rate_hz: f64, fft_len: usize) -> impl Iterator<Item = (f64, f64)> {
    let filter = ReceiveFilter::new(sample_rate_hz);
    let of = move |k| {
        let f_hz = bin_frequency_hz(k, fft_len, sample_rate_hz);
        (f_hz, filter.response(f_hz).powi(2))
    };
    (0..fft_len).map(of).filter(|(_, response)| *response != 0.0)
}

/// `sum |H (b - a)|^2 / sum |H a|^2` over bins, each `(|H|^2, a, b)`.
fn relative_power(bins: impl Iterator<Item = (f64, Complex64, Complex64)>) -> f64 {
    let (mut wrong, mut all) = (0.0, 0.0);
    for (response, exact, other) in bins {
        wrong += response * (other - exact).norm_sqr();
        all += response * exact.norm_sqr();
    }
    if all > 0.0 { wrong / all } else { 0.0 }
}

/// Expected `|error|^2 / |echo|^2` of a scatterer path `residual_hz` off the mean `mean_hz`, after the
/// receive filter: against an exact echo of the same [`Envelope`], so that of a rigid one
/// [`rigid_error_power`] is still to be added.
pub fn error_power(
    doppler: (Doppler, Envelope),
    waveform: &dyn Waveform,
    carrier_hz: f64,
    sample_rate_hz: f64,
    fft_len: usize,
    mean_hz: f64,
    residual_hz: f64,
) -> f64 {
    // That of the mean is exact.
    if residual_hz == 0.0 {
        return 0.0;
    }
    MeanEcho::new(doppler, waveform, carrier_hz, sample_rate_hz, fft_len, mean_hz).error_power(residual_hz)
}

/// The echo of a mean Doppler, from which the fast echo makes those of other Dopplers.
pub struct MeanEcho<'a> {
    doppler: Doppler,
    envelope: Envelope,
    waveform: &'a dyn Waveform,
    carrier_hz: f64,
    mean_hz: f64,
    /// Of every pulse that is looked at.
    bins: Vec<(&'a dyn Waveform, Vec<Bin>)>,
}

/// A bin of a transform that the receive filter passes.
struct Bin {
    f_hz: f64,
    /// Of the filter, as a power.
    response: f64,
    factor: f64,
    spectrum: Complex64,
    /// [`Correction::moment`].
    moment: Complex64,
}

impl<'a> MeanEcho<'a> {
    /// At the bins of a transform.
    pub fn new(
        (doppler, envelope): (Doppler, Envelope),
        waveform: &'a dyn Waveform,
        carrier_hz: f64,
        sample_rate_hz: f64,
        fft_len: usize,
        mean_hz: f64,
    ) -> Self {
        let correction = Correction::new(doppler, envelope, waveform, carrier_hz);
        let of = |pulse: &dyn Waveform, (f_hz, response): (f64, f64)| {
            let (at_hz, factor) = stretched(envelope, carrier_hz, f_hz, mean_hz);
            let spectrum = pulse.spectrum(at_hz) * factor;
            let moment = match doppler.has_moments() {
                true => correction.moment(pulse, (f_hz, at_hz), mean_hz),
                false => Complex64::ZERO,
            };
            Bin { f_hz, response, factor, spectrum, moment }
        };
        let step = step_of(waveform, fft_len);
        let passed: Vec<(f64, f64)> = passed(sample_rate_hz, fft_len).step_by(step).collect();
        let of_pulse = |pulse| (pulse, passed.iter().map(|bin| of(pulse, *bin)).collect());
        let bins = looked_at(waveform).into_iter().map(of_pulse).collect();
        Self { doppler, envelope, waveform, carrier_hz, mean_hz, bins }
    }

    /// As [`error_power`] has it.
    pub fn error_power(&self, residual_hz: f64) -> f64 {
        let Self { doppler, envelope, waveform, carrier_hz, mean_hz, .. } = *self;
        let correction = Correction::new(doppler, envelope, waveform, carrier_hz);
        let (turns, delay_s) = correction.of(mean_hz, residual_hz);
        let of = |(pulse, bins): &(&dyn Waveform, Vec<Bin>)| {
            relative_power(bins.iter().map(|bin| {
                let (at_hz, factor) = stretched(envelope, carrier_hz, bin.f_hz, mean_hz + residual_hz);
                let exact = pulse.spectrum(at_hz) * factor;
                let fast = bin.spectrum + bin.moment * (residual_hz * bin.factor);
                (bin.response, exact, fast * phasor(turns - bin.f_hz * delay_s))
            }))
        };
        self.bins.iter().map(of).fold(0.0, f64::max)
    }
}
