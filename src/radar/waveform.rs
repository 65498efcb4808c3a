//! The transmitted baseband pulse.
//!
//! A pulse `p(t)` starts at `t = 0` and has unit amplitude (amplitude 1 is the transmitter's peak power); its
//! spectrum is
//!
//! ```text
//! P(f) = int p(t) e^{-j 2 pi f t} dt        [s]
//! ```
//!
//! `f` baseband frequency, Hz. The echo of a scatterer path needs `P` off the grid of any transform
//! (intra-pulse Doppler shifts it by `f0 dtau/dt`), so [`Waveform::spectrum`] is defined, and exact, at every
//! frequency.
//!
//! | waveform | `p(t)` | limits |
//! | --- | --- | --- |
//! | [`Lfm`] | linear sweep, up or down, or `B = 0`: plain pulse | `B Tc <= 1e8` |
//! | [`Triangular`] | linear sweep up and down again | `B Tc <= 2e8` |
//! | [`Nlfm`] | nonlinear sweep, by a taper of its power spectrum | `4 <= B Tc <= 2e4` |
//! | [`Coded`] | chips of equal length: phase codes, or one chip: a plain pulse | 65536 chips |
//! | [`Sampled`] | samples from a file, band-limited to their rate | 131072 samples |
//! | [`InTurn`] | several of these, emission by emission | |
//! | [`Stream`] | a continuous signal, a segment with every emission: [`Noise`], [`Television`], [`Broadcast`], [`CoarseCode`], [`Recording`] | 64 to 1048576 samples a segment |
//!
//! ```
//! use nereus::radar::waveform::{Lfm, Waveform};
//! use nereus::scene::radar::Sweep;
//! let pulse = Lfm::new(60e6, 0.333e-6, Sweep::Up)?;
//! // The flat top of a chirp's spectrum is near sqrt(Tc/B), with Fresnel ripples about it.
//! let flat = (0.333e-6f64 / 60e6).sqrt();
//! assert!((pulse.spectrum(0.0).norm() / flat - 1.0).abs() < 0.2);
//! # Ok::<(), nereus::radar::waveform::WaveformError>(())
//! ```

mod coded;
mod drooping;
mod dvb_t;
mod fm;
mod frequencies;
mod fresnel;
mod gps_ca;
mod gridded;
mod in_turn;
mod iq_fault;
mod iq_file;
mod lfm;
mod nlfm;
mod noise;
mod offset;
mod sampled;
mod sigmf;
mod shaping;
mod stream;
mod table;
mod triangular;

use std::f64::consts::PI;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use num_complex::Complex64;
use thiserror::Error;

use crate::radar::phasor::phasor;
use crate::scene;
use crate::scene::radar::{Band, Source};
use crate::units::spanned_samples;

pub use coded::Coded;
pub use drooping::Drooping;
pub use dvb_t::Television;
pub use fm::Broadcast;
pub use frequencies::Frequencies;
pub use gps_ca::CoarseCode;
pub use in_turn::InTurn;
pub use iq_fault::{IqFault, IqFaults};
pub use iq_file::Recording;
pub use lfm::Lfm;
pub use nlfm::{MAX_NONLINEAR, MIN_NONLINEAR, Nlfm, SIDELOBES_DB};
pub use noise::Noise;
pub(crate) use offset::offset;
pub use sampled::{MAX_SAMPLES, Sampled};
pub use stream::{SEGMENT_SAMPLES, Signal, Stream};
pub use triangular::Triangular;

/// Largest time-bandwidth product of a sweep: the spectrum is then still exact to 1e-7 of its peak.
pub const MAX_TIME_BANDWIDTH: f64 = 1e8;

/// A transmitted baseband pulse that starts at `t = 0`.
pub trait Waveform: Send + Sync {
    /// What it is, in a word or two.
    fn name(&self) -> &str;

    /// Length of the pulse, s.
    fn duration_s(&self) -> f64;

    /// Swept or occupied bandwidth, Hz.
    fn bandwidth_hz(&self) -> f64;

    /// The band about the carrier.
    fn band(&self) -> Band {
        Band::about(0.0, self.bandwidth_hz())
    }

    /// Width of the side lobes of the spectrum far from the band, Hz: one over what is between two edges.
    fn lobe_hz(&self) -> f64 {
        self.duration_s().recip()
    }

    /// `P(f)`, seconds, at any baseband frequency.
    fn spectrum(&self, f_hz: f64) -> Complex64;

    /// [`Self::spectrum`] at many frequencies.
    fn spectra(&self, f_hz: &[f64], out: &mut [Complex64]) {
        out.iter_mut().zip(f_hz).for_each(|(out, f_hz)| *out = self.spectrum(*f_hz));
    }

    /// [`Self::spectra`] at frequencies that other waveforms are read at, too.
    fn spectra_at(&self, at: &mut Frequencies, out: &mut [Complex64]) {
        self.spectra(at.hz(), out);
    }

    /// `p(t)`, dimensionless.
    fn sample(&self, t_s: f64) -> Complex64;

    /// Spectrum of `(t - Tc/2) p(t)`, s^2, at any baseband frequency.
    fn moment_spectrum(&self, f_hz: f64) -> Complex64 {
        by_differences(self, f_hz)
    }

    /// What an emission radiates; `None` where all are this pulse.
    ///
    /// # Errors
    /// A file that can no longer be read.
    fn of_emission(&self, _emission: u64) -> Result<Option<Arc<dyn Waveform>>, WaveformError> {
        Ok(None)
    }

    /// The pulses that emissions radiate in turn; none where all are this pulse, and where no two are alike.
    fn in_turn(&self) -> &[Arc<dyn Waveform>] {
        &[]
    }

    /// Places among [`Self::in_turn`] of those of which errors are predicted, in the name of all.
    fn extremes(&self) -> &[usize] {
        &[]
    }

    /// Whether all emissions are this pulse.
    fn is_one(&self) -> bool {
        self.in_turn().is_empty() && !self.is_stream()
    }

    /// Mean power of the first so many emissions over the greatest that one has; 1 where all are alike.
    fn steadiness(&self, _emissions: u64) -> f64 {
        1.0
    }

    /// [`Self::of_emission`] of the first of these and of as many more as are found with it.
    ///
    /// # Errors
    /// Those of [`Self::of_emission`].
    fn of_emissions(&self, emissions: Range<u64>) -> Result<Vec<Arc<dyn Waveform>>, WaveformError> {
        Ok(self.of_emission(emissions.start)?.into_iter().collect())
    }

    /// Whether it is a continuous signal, of which no two segments are alike ([`Self::of_emission`]).
    fn is_stream(&self) -> bool {
        false
    }

    /// Rate of a linear sweep, Hz/s, negative when it falls; `None` for anything else.
    fn sweep_rate_hz_per_s(&self) -> Option<f64> {
        None
    }

    /// Frequency in the middle of a linear sweep, Hz.
    fn sweep_middle_hz(&self) -> f64 {
        0.0
    }

    /// Samples that the pulse spans at a rate ([`spanned_samples`]).
    fn span_samples(&self, sample_rate_hz: f64) -> usize {
        spanned_samples(self.duration_s(), sample_rate_hz)
    }
}

/// The pulses in turn; of any other waveform itself.
pub(crate) fn pulses(waveform: &dyn Waveform) -> Vec<&dyn Waveform> {
    match waveform.in_turn() {
        [] => vec![waveform],
        pulses => pulses.iter().map(AsRef::as_ref).collect(),
    }
}

/// What errors are predicted of: the waveform, or of its pulses in turn those that stand for all.
pub(crate) fn looked_at(waveform: &dyn Waveform) -> Vec<&dyn Waveform> {
    match waveform.extremes() {
        [] => vec![waveform],
        places => places.iter().filter_map(|n| waveform.in_turn().get(*n)).map(AsRef::as_ref).collect(),
    }
}

/// [`Waveform::moment_spectrum`] by 8-point central differences of the spectrum, step `1/(16 Tc)`.
fn by_differences<W: Waveform + ?Sized>(waveform: &W, f_hz: f64) -> Complex64 {
    let half_s = 0.5 * waveform.duration_s();
    let step_hz = 1.0 / (32.0 * half_s);
    let centred = |f: f64| waveform.spectrum(f) * phasor(f * half_s);
    let weights = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
    let mut slope = Complex64::ZERO;
    for (i, weight) in weights.iter().enumerate() {
        let h = step_hz * (i + 1) as f64;
        slope += (centred(f_hz + h) - centred(f_hz - h)) * *weight;
    }
    Complex64::I / (2.0 * PI) * slope / step_hz * phasor(-f_hz * half_s)
}

/// The waveform of a description. Reads the file of a sampled one.
///
/// # Errors
/// A file that cannot be read, or a pulse out of range.
pub fn from_description(description: &scene::radar::Waveform) -> Result<Arc<dyn Waveform>, WaveformError> {
    Ok(match description {
        scene::radar::Waveform::Lfm { bandwidth_hz, duration_s, sweep } => {
            Arc::new(Lfm::new(*bandwidth_hz, *duration_s, *sweep)?)
        }
        scene::radar::Waveform::Triangular { bandwidth_hz, duration_s } => {
            Arc::new(Triangular::new(*bandwidth_hz, *duration_s)?)
        }
        scene::radar::Waveform::Nlfm { bandwidth_hz, duration_s, sweep, taper } => {
            Arc::new(Nlfm::new(*bandwidth_hz, *duration_s, *sweep, *taper)?)
        }
        scene::radar::Waveform::Drooping { of, droop_db } => {
            Arc::new(Drooping::new(from_description(of)?, *droop_db))
        }
        scene::radar::Waveform::Offset { of, offset_hz } => offset(from_description(of)?, *offset_hz),
        scene::radar::Waveform::InTurn { of, .. } => {
            Arc::new(InTurn::new(of.iter().map(from_description).collect::<Result<_, _>>()?))
        }
        scene::radar::Waveform::Cw { duration_s } => Arc::new(Coded::plain(*duration_s)?),
        scene::radar::Waveform::PhaseCode { code, chip_s } => Arc::new(Coded::new(*code, *chip_s)?),
        scene::radar::Waveform::Samples { path, rate_hz } => Arc::new(Sampled::from_file(path, *rate_hz)?),
        scene::radar::Waveform::Stream { source, interval_s } => {
            let signal: Arc<dyn Signal> = match source {
                Source::Noise { bandwidth_hz, seed } => Arc::new(Noise::new(*bandwidth_hz, *seed)),
                Source::DvbT { of, seed } => Arc::new(Television::new(*of, *seed)),
                Source::Fm { of, seed } => Arc::new(Broadcast::new(*of, *seed)),
                Source::GpsCa { prn, seed } => Arc::new(CoarseCode::new(*prn, *seed)),
                Source::IqFile(of) => Arc::new(Recording::open(of)?),
            };
            Arc::new(Stream::new(signal, *interval_s)?)
        }
    })
}

/// Why there is no such waveform.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WaveformError {
    /// Swept bandwidth out of range.
    #[error("waveform bandwidth {bandwidth_hz} Hz is not allowed: 0 (no modulation) or more, finite")]
    Bandwidth {
        /// What was asked.
        bandwidth_hz: f64,
    },
    /// Pulse length out of range.
    #[error("pulse length {duration_s} s is not allowed: more than 0, finite")]
    Duration {
        /// What was asked.
        duration_s: f64,
    },
    /// Bandwidth times pulse length out of range.
    #[error("time-bandwidth product {product} is not allowed: at most {MAX_TIME_BANDWIDTH:e}")]
    TimeBandwidth {
        /// What was asked.
        product: f64,
    },
    /// Bandwidth times length of a nonlinear sweep out of range.
    #[error(
        "time-bandwidth product {product} of a nonlinear sweep is not allowed: {MIN_NONLINEAR} to {MAX_NONLINEAR}"
    )]
    Nonlinear {
        /// What was asked.
        product: f64,
    },
    /// Side lobes of a taper out of range.
    #[error(
        "side lobes of {sidelobe_db} dB are not allowed: {} to {} dB below the peak",
        SIDELOBES_DB[0],
        SIDELOBES_DB[1]
    )]
    Sidelobe {
        /// What was asked, dB.
        sidelobe_db: f64,
    },
    /// Length of a chip out of range.
    #[error("chip length {chip_s} s is not allowed: more than 0, finite")]
    Chip {
        /// What was asked.
        chip_s: f64,
    },
    /// A code that does not exist.
    #[error("a {code} code of {chips} chips does not exist: {allowed}")]
    Code {
        /// The code.
        code: &'static str,
        /// Chips that were asked.
        chips: usize,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Segments of a continuous signal out of range.
    #[error(
        "a segment of {samples} samples is not allowed: {} to {}, by the rate of the signal times the pulse interval",
        SEGMENT_SAMPLES[0],
        SEGMENT_SAMPLES[1]
    )]
    Segment {
        /// Samples of an interval.
        samples: f64,
    },
    /// Rate of the samples out of range.
    #[error("waveform sample rate {rate_hz} Hz is not allowed: more than 0, finite")]
    Rate {
        /// What was asked.
        rate_hz: f64,
    },
    /// The file cannot be read.
    #[error("waveform file {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file can be read, but does not hold a pulse.
    #[error("waveform file {}: {faults}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        faults: SampleFaults,
    },
    /// A recording of a continuous signal that cannot be radiated.
    #[error("IQ file {}: {faults}", path.display())]
    IqFile {
        /// Samples, or their metadata.
        path: PathBuf,
        /// What is wrong with it.
        faults: IqFaults,
    },
    /// Samples given in memory do not make a pulse.
    #[error("waveform samples: {0}")]
    Samples(SampleFaults),
}

/// Everything wrong with the samples of a waveform.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleFaults {
    /// The first of them (at most [`SampleFaults::SHOWN`]).
    pub shown: Vec<SampleFault>,
    /// How many there are.
    pub total: usize,
}

impl SampleFaults {
    /// Faults kept with their text; the rest are counted.
    pub const SHOWN: usize = 20;

    fn push(&mut self, fault: SampleFault) {
        self.total += 1;
        if self.shown.len() < Self::SHOWN {
            self.shown.push(fault);
        }
    }

    fn is_empty(&self) -> bool {
        self.total == 0
    }
}

impl fmt::Display for SampleFaults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.shown.iter().enumerate() {
            write!(f, "{}{fault}", if i == 0 { "" } else { "; " })?;
        }
        if self.total > self.shown.len() {
            write!(f, "; and {} more", self.total - self.shown.len())?;
        }
        Ok(())
    }
}

/// One fault of the samples of a waveform. Lines count from 1.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SampleFault {
    /// A line does not have two values.
    #[error("line {line}: '{text}' has {found} value(s), a sample is 're,im'")]
    Columns {
        /// Where.
        line: usize,
        /// Beginning of the line.
        text: String,
        /// Values found.
        found: usize,
    },
    /// A value is not a finite number.
    #[error("line {line}: '{text}' is not a finite number")]
    Number {
        /// Where.
        line: usize,
        /// Beginning of the value.
        text: String,
    },
    /// A sample in memory is not finite.
    #[error("sample {index} is not finite")]
    NotFinite {
        /// Which.
        index: usize,
    },
    /// Too many samples.
    #[error("more than {MAX_SAMPLES} samples")]
    TooMany,
    /// More bytes than that number of samples can need.
    #[error("longer than {allowed} bytes")]
    TooLong {
        /// What is allowed.
        allowed: u64,
    },
    /// No samples, or all of them zero.
    #[error("no sample differs from zero")]
    Silent,
}
