//! A recording as a continuous signal, of any length: read segment by segment.
//!
//! ```text
//! s_j = A x_{j mod N} , or 0 from j = N on
//! A^-2 = sum_j |x_j|^2 / N * int S(v) (H(v)^2 + H(1 - |v|)^2) dv / int S(v) dv ,   |v| < 1/2
//! ```
//!
//! `x` samples of the file, `N` of them, `S` their power spectrum over cycles a sample, `H` the interpolation
//! (`shaping`). `A` makes the mean power 1. Up to 2^22 samples all are looked at for that, of longer files 64
//! stretches of 65536, the first and the last among them. An integer type has 0 at the middle of its scale,
//! of unsigned ones at half of it.
//!
//! What lies within 0.416 of the rate of the samples off the middle is radiated as it is. Beyond, up to half
//! of the rate, it fades, and an image of it appears between 0.5 and 0.584.
//!
//! The file stays open and is read at places, by any thread. It must stay as it is: a length, a time of
//! change or a sample that is not what it was ends the run.

use std::fs::{File, Metadata};
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use num_complex::Complex64;

use super::WaveformError;
use super::iq_fault::{IqFault, IqFaults};
use super::shaping::response;
use super::sigmf::{self, Described};
use super::stream::Signal;
use crate::inputs;
use crate::scene::radar::{AfterEnd, Component, Datatype, IqFile, RawIq};

/// Samples that are looked at: a stretch, and the most.
const STRETCH: u64 = 1 << 16;
const MOST: u64 = 1 << 22;
/// Samples whose power is found together, and of a transform.
const FRAME: usize = 256;
/// Power that a sample may have.
const MOST_POWER: f64 = 1e300;
/// Samples that are read at a time.
const PIECE: usize = 4096;
/// A beginning that is weaker than this, over the mean, is not what is planned by.
const WEAK: f64 = 0.1;

/// A recording that is radiated.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    samples: Samples,
    after: AfterEnd,
    scale: f64,
    bandwidth_hz: f64,
    typical: u64,
    /// Mean power of frames over that of all, stretch by stretch.
    frames: Vec<Vec<f64>>,
}

/// Samples of a file.
#[derive(Debug)]
struct Samples {
    file: File,
    of: RawIq,
    /// Bytes before the first.
    skipped: u64,
    count: u64,
    /// Length and time of change.
    was: (u64, Option<SystemTime>),
}

fn state(data: &Metadata) -> (u64, Option<SystemTime>) {
    (data.len(), data.modified().ok())
}

impl Recording {
    /// Opens a recording and looks at its samples.
    ///
    /// # Errors
    /// All that is wrong with the metadata, or with the samples.
    pub fn open(of: &IqFile) -> Result<Self, WaveformError> {
        let faulty = |faults| WaveformError::IqFile { path: of.path.clone(), faults: IqFaults(faults) };
        let samples = Samples::open(of).map_err(faulty)?;
        let looked = Looked::at(&samples).map_err(|fault| faulty(vec![fault]))?;
        Ok(Self {
            path: of.path.clone(),
            after: of.after,
            scale: looked.power.sqrt().recip(),
            bandwidth_hz: looked.occupied * samples.of.rate_hz,
            typical: looked.typical,
            frames: looked.frames,
            samples,
        })
    }
}

impl Signal for Recording {
    fn name(&self) -> &str {
        "iq-file"
    }

    fn rate_hz(&self) -> f64 {
        self.samples.of.rate_hz
    }

    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn fill(&self, first: u64, out: &mut [Complex64]) -> Result<(), WaveformError> {
        let (mut at, mut rest, count) = (first, out, self.samples.count);
        let faulty = |fault| WaveformError::IqFile { path: self.path.clone(), faults: IqFaults(vec![fault]) };
        self.samples.check().map_err(faulty)?;
        while !rest.is_empty() {
            let place = match self.after {
                AfterEnd::Repeat => at % count,
                AfterEnd::Silence => at,
            };
            if place >= count {
                rest.fill(Complex64::ZERO);
                break;
            }
            let most = usize::try_from(count - place).unwrap_or(usize::MAX);
            let (now, later) = rest.split_at_mut(most.min(rest.len()));
            self.samples.read(place, now).map_err(faulty)?;
            now.iter_mut().for_each(|sample| *sample *= self.scale);
            at = at.wrapping_add(now.len() as u64);
            rest = later;
        }
        Ok(())
    }

    fn typical(&self) -> u64 {
        self.typical
    }

    fn steadiness(&self, samples: u64, all: u64) -> f64 {
        let count = usize::try_from(samples.div_ceil(FRAME as u64)).unwrap_or(usize::MAX).max(1);
        let of = |frames: &Vec<f64>| {
            let count = count.min(frames.len()).max(1);
            frames.windows(count).map(|own| own.iter().sum::<f64>() / count as f64).fold(0.0, f64::max)
        };
        let most = self.frames.iter().map(of).fold(1.0, f64::max);
        let lasts = match self.after {
            AfterEnd::Repeat => 1.0,
            AfterEnd::Silence => (self.samples.count as f64 / all.max(1) as f64).min(1.0),
        };
        lasts / most
    }
}

impl Samples {
    fn open(of: &IqFile) -> Result<Self, Vec<IqFault>> {
        let described = match of.raw {
            Some(raw) => Described { samples: of.path.clone(), of: raw, around: [0, 0] },
            None => sigmf::read(&of.path)?,
        };
        let Described { samples: path, of: raw, around: [before, behind] } = described;
        let unread = |source: io::Error| match of.path == path {
            true => vec![IqFault::Unread(source)],
            false => vec![IqFault::NoSamples { path: path.clone(), source }],
        };
        let file = open(&path).map_err(unread)?;
        let was = state(&file.metadata().map_err(unread)?);
        let (bytes, size) =
            (was.0.saturating_sub(before).saturating_sub(behind), raw.datatype.bytes() as u64);
        let (count, more) = (bytes / size, bytes % size);
        if more > 0 {
            return Err(vec![IqFault::Ragged { bytes, datatype: raw.datatype.name(), more }]);
        }
        if count == 0 {
            return Err(vec![IqFault::Empty]);
        }
        Ok(Self { file, of: raw, skipped: before, count, was })
    }

    /// Whether it is the file that was opened.
    fn check(&self) -> Result<(), IqFault> {
        if state(&self.file.metadata()?) == self.was { Ok(()) } else { Err(IqFault::Changed) }
    }

    /// Samples from one on, as many as there are.
    fn read(&self, first: u64, out: &mut [Complex64]) -> Result<(), IqFault> {
        let size = self.of.datatype.bytes();
        let mut bytes = vec![0; size * PIECE.min(out.len())];
        let mut at = first;
        for piece in out.chunks_mut(PIECE) {
            let own = &mut bytes[..size * piece.len()];
            let shorter = |error: io::Error| match error.kind() {
                io::ErrorKind::UnexpectedEof => IqFault::Changed,
                _ => IqFault::Unread(error),
            };
            self.file.read_exact_at(own, self.skipped + at * size as u64).map_err(shorter)?;
            decode(self.of.datatype, own, piece);
            let fits = |sample: &Complex64| sample.norm_sqr() < MOST_POWER;
            if let Some(place) = piece.iter().position(|sample| !fits(sample)) {
                return Err(IqFault::NotFinite { number: at + place as u64 });
            }
            at += piece.len() as u64;
        }
        Ok(())
    }
}

fn open(path: &Path) -> io::Result<File> {
    let file = inputs::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder; allowed: a regular file"));
    }
    Ok(file)
}

/// Samples of as many bytes as they have.
fn decode(datatype: Datatype, bytes: &[u8], out: &mut [Complex64]) {
    let Datatype { component, is_big_endian } = datatype;
    /// Values of a type, less what its zero is.
    fn all<const N: usize>(
        (bytes, out): (&[u8], &mut [Complex64]),
        is_big_endian: bool,
        value: impl Fn([u8; N]) -> f64,
    ) {
        let of = |own: &[u8]| {
            let mut one = [0; N];
            one.copy_from_slice(own);
            if is_big_endian {
                one.reverse();
            }
            value(one)
        };
        for (sample, own) in out.iter_mut().zip(bytes.chunks_exact(2 * N)) {
            *sample = Complex64::new(of(&own[..N]), of(&own[N..]));
        }
    }
    let to = (bytes, out);
    match component {
        Component::F64 => all(to, is_big_endian, f64::from_le_bytes),
        Component::F32 => all(to, is_big_endian, |own| f32::from_le_bytes(own).into()),
        Component::I32 => all(to, is_big_endian, |own| i32::from_le_bytes(own).into()),
        Component::I16 => all(to, is_big_endian, |own| i16::from_le_bytes(own).into()),
        Component::I8 => all(to, is_big_endian, |own| i8::from_le_bytes(own).into()),
        Component::U32 => all(to, is_big_endian, |own| f64::from(u32::from_le_bytes(own)) - 2_147_483_648.0),
        Component::U16 => all(to, is_big_endian, |own| f64::from(u16::from_le_bytes(own)) - 32_768.0),
        Component::U8 => all(to, is_big_endian, |own| f64::from(u8::from_le_bytes(own)) - 128.0),
    }
}

/// What was seen of the samples of a file.
struct Looked {
    /// Mean power once they are interpolated.
    power: f64,
    /// Width of the band about 0 that holds 99 % of the power, cycles a sample.
    occupied: f64,
    typical: u64,
    frames: Vec<Vec<f64>>,
}

impl Looked {
    fn at(samples: &Samples) -> Result<Self, IqFault> {
        let stretches = stretches(samples.count);
        let transform = nereus_fft::forward(FRAME);
        let mut spectrum = vec![0.0; FRAME];
        let mut values = Vec::new();
        let (mut energy, mut looked, mut frames) = (0.0, 0, Vec::new());
        for (first, count) in &stretches {
            values.clear();
            values.resize(*count as usize, Complex64::ZERO);
            samples.read(*first, &mut values)?;
            let mut own = Vec::with_capacity(values.len() / FRAME + 1);
            for frame in values.chunks(FRAME) {
                let of_frame: f64 = frame.iter().map(Complex64::norm_sqr).sum();
                energy += of_frame;
                own.push(of_frame / frame.len() as f64);
                let mut bins = vec![Complex64::ZERO; FRAME];
                for (i, (bin, sample)) in bins.iter_mut().zip(frame).enumerate() {
                    let turn = std::f64::consts::TAU * (i as f64 + 0.5) / FRAME as f64;
                    *bin = sample * (0.5 - 0.5 * turn.cos());
                }
                transform.process(&mut bins);
                spectrum.iter_mut().zip(&bins).for_each(|(sum, bin)| *sum += bin.norm_sqr());
            }
            looked += count;
            frames.push(own);
        }
        let mean = energy / looked as f64;
        if mean <= 0.0 {
            return Err(IqFault::Silent { looked });
        }
        frames.iter_mut().flatten().for_each(|power| *power /= mean);
        let of_stretch = |own: &Vec<f64>| own.iter().sum::<f64>() / own.len().max(1) as f64;
        let strongest =
            (0..frames.len()).max_by(|a, b| of_stretch(&frames[*a]).total_cmp(&of_stretch(&frames[*b])));
        let begins = frames.first().and_then(|own| own.first()).copied().unwrap_or(0.0);
        let typical = match strongest {
            Some(place) if begins < WEAK => {
                let strong =
                    (0..frames[place].len()).max_by(|a, b| frames[place][*a].total_cmp(&frames[place][*b]));
                stretches[place].0 + (strong.unwrap_or(0) * FRAME) as u64
            }
            _ => 0,
        };
        let (kept, occupied) = of_spectrum(&spectrum);
        Ok(Self { power: mean * kept, occupied, typical, frames })
    }
}

/// Stretches that are looked at: where each begins, and how many samples it has.
fn stretches(count: u64) -> Vec<(u64, u64)> {
    if count <= MOST {
        return (0..count.div_ceil(STRETCH))
            .map(|i| (i * STRETCH, STRETCH.min(count - i * STRETCH)))
            .collect();
    }
    let last = MOST / STRETCH - 1;
    let begins = |i: u64| (u128::from(count - STRETCH) * u128::from(i) / u128::from(last)) as u64;
    (0..=last).map(|i| (begins(i), STRETCH)).collect()
}

/// Of a power spectrum of [`FRAME`] bins: how much an interpolation leaves of it, and the width of the band
/// about 0 that holds 99 % of it.
fn of_spectrum(bins: &[f64]) -> (f64, f64) {
    let total: f64 = bins.iter().sum();
    let left = |(k, power): (usize, &f64)| {
        let v = k.min(FRAME - k) as f64 / FRAME as f64;
        power * (response(v)[0].powi(2) + response(1.0 - v)[0].powi(2))
    };
    let kept = bins.iter().enumerate().map(left).sum::<f64>() / total;
    let mut held = bins[0];
    for m in 1..FRAME / 2 {
        if held >= 0.99 * total {
            return (kept, (2 * m - 1) as f64 / FRAME as f64);
        }
        held += bins[m] + bins[FRAME - m];
    }
    (kept, 1.0)
}

#[cfg(test)]
mod tests;
