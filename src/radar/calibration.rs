//! Calibration channels: a tone and the transmitted pulse itself, known in closed form.
//!
//! ```text
//! tone      s_n[i] = sqrt(P) e^{j (phi + 2 pi df t)} ,             t = t_n - t_0 + w_n + i/fs
//! loopback  s_n[i] = sqrt(P) e^{j phi} q(i/fs - d) ,               Q(f) = P(f) H(f)
//! ```
//!
//! `P` power, W; `phi` phase, rad; `df` offset from the carrier, Hz; `t_n` emission of pulse `n`, exact;
//! `w_n` start of its window as recorded, s; `q` the pulse after the receive filter ([`super::filter`]), `d`
//! its delay after the window's first sample, s, the same in every window. The tone is that of a source which
//! knows the time; its level is that of samples, whatever the filter does at `df`. Both go through the
//! converter, and through the clocks ([`super::clock`]) of the receiver and, for the loopback, of the
//! transmitter:
//!
//! ```text
//! tone      turned by -2 pi (f_0 + df) x ,  x = x_R + y_R (w_n + i/fs)
//! loopback  turned by -2 pi f_0 x ,         x = x_R - x_T + (y_R - y_T) (w_n + i/fs)
//! ```
//!
//! The loopback goes through a cable without length: what the transmitter's oscillator sends at
//! `t_n + w_n + i/fs` is mixed with the receiver's of that same instant, so a clock that both share leaves no
//! turn at all. An echo left `w_n` earlier, and is turned by what a shared clock does in between
//! ([`super::clock`]). It is sent when the receiver's own window has been open for `d`, so its place in the
//! window shows nothing of clocks. Whole turns are taken off before they cost digits: the phase of a tone is
//! right to 2e-8 turns for any length of run (`df` below 1e8 Hz).
//!
//! The transform that makes the loopback has the period of the echo's, so the whole pulse must lie in the
//! window; what the filter rings beyond that wraps around and is below 1e-6 of the peak. Every other channel
//! is left alone.
//!
//! ```
//! use nereus::radar::calibration::turns;
//! use nereus::time::PulseTimes;
//! // A kilohertz at 200 Hz: five turns from pulse to pulse, a fifth of a turn in 0.2 ms.
//! let times = PulseTimes::uniform(200.0)?;
//! assert!((turns(1000.0, &times, 123_456, 0.2e-3) - 0.2).abs() < 1e-9);
//! # Ok::<(), nereus::time::TimeError>(())
//! ```

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;
use thiserror::Error;

use super::clock::RunningClocks;
use super::filter::{ReceiveFilter, bin_frequency_hz};
use super::receiver::{Receiver, ReceiverScratch};
use super::waveform::{Waveform, pulses};
use crate::pulse::{Pulse, flags};
use crate::scene::Radar;
use crate::scene::calibration::{Calibration, Signal};
use crate::time::{PulseTimes, TimeTag};
use crate::units::in_turn;

/// Why a signal cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CalibrationFault {
    /// A tone that the sample rate cannot hold.
    #[error(
        "calibration '{name}': offset_hz = {offset_hz}: allowed: from {least} to {most} Hz, half the sample rate"
    )]
    Offset {
        /// The channel.
        name: String,
        /// As given.
        offset_hz: f64,
        /// Least.
        least: f64,
        /// Most.
        most: f64,
    },
    /// A pulse that does not lie in the window.
    #[error(
        "calibration '{name}': delay_s = {delay_s}: allowed: from 0 to {most} s, so that the whole pulse is in the window"
    )]
    Delay {
        /// The channel.
        name: String,
        /// As given.
        delay_s: f64,
        /// Most.
        most: f64,
    },
    /// An antenna that is none.
    #[error("calibration '{name}': antenna {place}: allowed: one of the radar's")]
    Antenna {
        /// The channel.
        name: String,
        /// Its place.
        place: usize,
    },
}

/// One channel.
#[derive(Clone, Debug)]
struct Generator {
    of: Calibration,
    /// Amplitude and phase.
    amplitude: Complex64,
    /// Samples of a loopback, of each of the pulses in turn.
    pulses: Vec<Vec<Complex64>>,
}

/// All calibration channels of a radar, which stand behind its channels of echoes.
#[derive(Clone, Debug)]
pub struct Generators {
    list: Vec<Generator>,
    first: usize,
    times: PulseTimes,
    clocks: Option<Arc<RunningClocks>>,
    carrier_hz: f64,
    sample_rate_hz: f64,
    samples: usize,
}

/// What a thread needs.
#[derive(Clone, Debug, Default)]
pub struct GeneratorScratch {
    bins: Vec<Complex64>,
}

/// Turns of a tone `after_s` after the emission of a pulse, since that of pulse 0; whole turns are left out.
pub fn turns(offset_hz: f64, times: &PulseTimes, pulse: u64, after_s: f64) -> f64 {
    let since = times.emission(TimeTag::default(), pulse);
    // Whole hertz times whole seconds are whole turns.
    let seconds = since.seconds() as f64;
    let turns = [offset_hz.fract() * seconds, offset_hz * since.fraction_s(), offset_hz * after_s];
    turns.map(|part| part - part.floor()).iter().sum::<f64>().fract()
}

impl Generators {
    /// Those of a radar whose echoes are transformed with so many bins.
    ///
    /// # Errors
    /// Signals that do not fit the window or the sample rate.
    pub fn new(
        list: &[Calibration],
        radar: &Radar,
        waveform: &dyn Waveform,
        receiver: &Receiver,
        clocks: Option<Arc<RunningClocks>>,
    ) -> Result<Self, CalibrationFault> {
        let fs = radar.sample_rate_hz;
        let made = list.iter().map(|of| {
            let name = of.name.clone();
            let amplitude = Complex64::from_polar(of.power_w.sqrt(), of.phase_rad);
            if of.receiver >= radar.receivers.len() {
                return Err(CalibrationFault::Antenna { name, place: of.receiver });
            }
            let pulses = match of.signal {
                Signal::Tone { offset_hz } if offset_hz.abs() <= 0.5 * fs => Vec::new(),
                Signal::Tone { offset_hz } => {
                    return Err(CalibrationFault::Offset {
                        name,
                        offset_hz,
                        least: -0.5 * fs,
                        most: 0.5 * fs,
                    });
                }
                Signal::Loopback { transmitter, .. } if transmitter >= radar.transmitters.len() => {
                    return Err(CalibrationFault::Antenna { name, place: transmitter });
                }
                Signal::Loopback { delay_s, .. } => {
                    let most = radar.window.samples as f64 / fs - waveform.duration_s();
                    // A rounding more is no echo outside.
                    if !(delay_s >= 0.0 && delay_s <= most + 1e-9 / fs) {
                        return Err(CalibrationFault::Delay { name, delay_s, most: most.max(0.0) });
                    }
                    let of = |pulse: &dyn Waveform| {
                        loopback(pulse, fs, delay_s, amplitude, radar.window.samples, receiver)
                    };
                    pulses(waveform).into_iter().map(of).collect()
                }
            };
            Ok(Generator { of: of.clone(), amplitude, pulses })
        });
        Ok(Self {
            list: made.collect::<Result<_, _>>()?,
            first: radar.channels.len(),
            times: radar.emissions.clone(),
            clocks,
            carrier_hz: radar.carrier_hz,
            sample_rate_hz: fs,
            samples: radar.window.samples,
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Memory of one thread.
    pub fn scratch(&self, receiver: &Receiver) -> GeneratorScratch {
        let noisy = self.list.iter().any(|generator| generator.of.noise);
        GeneratorScratch { bins: vec![Complex64::ZERO; if noisy { receiver.fft_len() } else { 0 }] }
    }

    /// Makes the samples of the calibration channels of a pulse whose index and window are known and whose
    /// echoes have been received.
    pub fn fill(
        &self,
        receiver: &Receiver,
        pulse: &mut Pulse,
        scratch: &mut GeneratorScratch,
        of_receiver: &mut ReceiverScratch,
    ) {
        let index = pulse.index;
        let mut saturated = 0;
        for (place, generator) in self.list.iter().enumerate() {
            let channel = self.first + place;
            let Generator { of, amplitude, pulses } = generator;
            let samples = in_turn(pulses, index).map_or(&[][..], Vec::as_slice);
            let window_s = pulse.window_start_of(of.receiver);
            let apart = |transmitter: Option<usize>| {
                let clocks = self.clocks.as_ref();
                clocks.map_or([0.0; 2], |clocks| clocks.apart(transmitter, of.receiver, index, window_s))
            };
            let (ideal, sent_hz, offset_hz, [x_s, y]) = match of.signal {
                Signal::Tone { offset_hz } => {
                    let ideal = turns(offset_hz, &self.times, index, window_s);
                    (ideal, self.carrier_hz + offset_hz, offset_hz, apart(None))
                }
                Signal::Loopback { transmitter, .. } => (0.0, self.carrier_hz, 0.0, apart(Some(transmitter))),
            };
            let turns = ideal - (sent_hz * x_s).rem_euclid(1.0);
            let per_sample = (offset_hz - sent_hz * y) / self.sample_rate_hz;
            let noise: &[Complex64] = if of.noise {
                receiver.noise(index, channel, &mut scratch.bins, of_receiver);
                &scratch.bins
            } else {
                &[]
            };
            let turned = turns != 0.0 || per_sample != 0.0;
            let value = |i: usize| {
                let signal = match samples.get(i) {
                    Some(sample) if turned => *sample,
                    Some(sample) => return *sample + noise.get(i).copied().unwrap_or_default(),
                    None => *amplitude,
                };
                let turn = Complex64::cis(TAU * (turns + per_sample * i as f64).fract());
                signal * turn + noise.get(i).copied().unwrap_or_default()
            };
            saturated += receiver.put(pulse, channel * self.samples, self.samples, value);
        }
        if saturated > 0 {
            pulse.flags |= flags::ADC_SATURATED;
        }
    }
}

/// The samples of a pulse that begins a delay after the first of them.
fn loopback(
    waveform: &dyn Waveform,
    fs: f64,
    delay_s: f64,
    amplitude: Complex64,
    samples: usize,
    receiver: &Receiver,
) -> Vec<Complex64> {
    let (filter, period) = (ReceiveFilter::new(fs), receiver.fft_len());
    let bin = |k: usize| {
        let f_hz = bin_frequency_hz(k, period, fs);
        let response = filter.response(f_hz);
        if response == 0.0 {
            return Complex64::ZERO;
        }
        amplitude * waveform.spectrum(f_hz) * response * Complex64::cis(-TAU * (f_hz * delay_s).fract())
    };
    let mut bins: Vec<Complex64> = (0..period).map(bin).collect();
    receiver.inverse(&mut bins, &mut receiver.scratch());
    bins.truncate(samples);
    bins
}
