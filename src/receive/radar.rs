//! What a sender describes of its radar: waveform, receive filter, replica, antennas. Senders of earlier
//! versions do not; a recording of what they send cannot be focused.

use std::collections::BTreeMap;

use num_complex::Complex32;

use super::packet::{Malformed, Words};
use crate::recording::instrument::{AntennaRow, FilterRow, Instrument, Look, WaveformRow};

/// Most antennas and longest replica that are taken.
pub(super) const ANTENNAS: u32 = 1024;
pub(super) const REPLICA: u32 = 1 << 20;
/// Samples that a piece of the replica has at least, but the last one.
const PIECE: u32 = 32;

/// Waveform and receive filter, and where the window looks.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalDescription {
    /// The transmitted pulse.
    pub waveform: WaveformRow,
    /// The receive filter.
    pub filter: FilterRow,
    /// The sea is a sphere of that many radii of the Earth; none: a plane.
    pub earth_radius_factor: Option<f64>,
    /// Middle of the scene, East and North, m.
    pub middle_m: [f64; 2],
    /// What the window follows.
    pub window: Aimed,
}

/// A place to look at: its kind, the number of a platform, six numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aimed {
    kind: u32,
    platform: u32,
    numbers: [f64; 6],
}

/// A piece of the replica.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplicaPiece {
    /// Place of its first sample.
    pub first: u32,
    /// Samples of every piece but the last.
    pub piece: u32,
    /// Samples of the replica.
    pub of: u32,
    /// Its samples.
    pub samples: Vec<Complex32>,
}

/// An antenna.
#[derive(Clone, Debug, PartialEq)]
pub struct AntennaDescription {
    /// Its number, and how many there are.
    pub number: [u32; 2],
    /// Whether it transmits.
    pub transmits: bool,
    /// Number of its platform.
    pub platform: u32,
    /// Phase centre in the body frame, m.
    pub lever_arm_m: [f64; 3],
    /// Width and height of its aperture, m, where it has one.
    pub aperture_m: Option<[f64; 2]>,
    /// Where it looks.
    pub look: Aimed,
    /// Its name.
    pub name: String,
    /// Kind of its pattern.
    pub pattern: String,
}

/// Numbers that can be calculated with.
fn finite<const N: usize>(words: &mut Words<'_>) -> Result<[f64; N], Malformed> {
    let values = words.f64s()?;
    let fine = values.iter().all(|value| value.is_finite());
    fine.then_some(values).ok_or(Malformed::Value("a length or a frequency that is no number"))
}

/// A number that may be missing.
fn optional(words: &mut Words<'_>) -> Result<Option<f64>, Malformed> {
    Ok(Some(words.f64()?).filter(|value| value.is_finite()))
}

fn aimed(words: &mut Words<'_>) -> Result<Aimed, Malformed> {
    let (kind, platform) = (words.u32()?, words.u32()?);
    if kind > 2 {
        return Err(Malformed::Value("such a place to look at"));
    }
    Ok(Aimed { kind, platform, numbers: finite(words)? })
}

pub(super) fn signal(words: &mut Words<'_>) -> Result<SignalDescription, Malformed> {
    let (sweep_hz_per_s, rate_hz) = (optional(words)?, optional(words)?);
    let [flat_hz, zero_hz] = finite(words)?;
    Ok(SignalDescription {
        earth_radius_factor: optional(words)?,
        middle_m: finite(words)?,
        window: aimed(words)?,
        waveform: WaveformRow { kind: words.text()?, sweep_hz_per_s, rate_hz },
        filter: FilterRow { kind: words.text()?, flat_hz, zero_hz },
    })
}

pub(super) fn replica(mut words: Words<'_>) -> Result<ReplicaPiece, Malformed> {
    let [first, piece, of] = [words.u32()?, words.u32()?, words.u32()?];
    words.u32()?;
    if of > REPLICA || piece < PIECE || first >= of || !first.is_multiple_of(piece) {
        return Err(Malformed::Value("such a piece of a replica"));
    }
    let count = piece.min(of - first) as usize;
    let (pairs, rest) = words.bytes(8 * count)?.as_chunks::<8>();
    debug_assert!(rest.is_empty());
    let part = |bytes: &[u8; 8], at: usize| {
        bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(f32::NAN, f32::from_be_bytes)
    };
    let samples: Vec<Complex32> =
        pairs.iter().map(|bytes| Complex32::new(part(bytes, 0), part(bytes, 4))).collect();
    if !samples.iter().all(|sample| sample.is_finite()) {
        return Err(Malformed::Value("a sample of a replica that is no number"));
    }
    Ok(ReplicaPiece { first, piece, of, samples })
}

pub(super) fn antenna(words: &mut Words<'_>) -> Result<AntennaDescription, Malformed> {
    let number = [words.u32()?, words.u32()?];
    let (receives, platform) = (words.u32()?, words.u32()?);
    let lever_arm_m = finite(words)?;
    let aperture_m = match [optional(words)?, optional(words)?] {
        [Some(width_m), Some(height_m)] => Some([width_m, height_m]),
        _ => None,
    };
    let look = aimed(words)?;
    Ok(AntennaDescription {
        number,
        transmits: receives == 0,
        platform,
        lever_arm_m,
        aperture_m,
        look,
        name: words.text()?,
        pattern: words.text()?,
    })
}

impl Aimed {
    /// As recordings have it; `None` beside a platform that there is not.
    fn look(&self, platforms: &[&String]) -> Option<Look> {
        let [a, b, c, d, e, f] = self.numbers;
        Some(match self.kind {
            0 => Look::Body { yaw_rad: a, pitch_rad: b, roll_rad: c },
            1 => Look::Point { position_m: [a, b, c], velocity_mps: [d, e, f] },
            _ => Look::Beside {
                platform: (*platforms.get(self.platform as usize)?).clone(),
                along_m: a,
                across_m: b,
            },
        })
    }
}

/// What has come of the description of the radar.
#[derive(Debug, Default)]
pub(super) struct Radar {
    signal: Option<SignalDescription>,
    antennas: Vec<Option<AntennaDescription>>,
    /// Pieces of the replica by their first samples, and the samples of a piece.
    pieces: BTreeMap<u32, Vec<Complex32>>,
    piece: u32,
}

/// Instrument and replica.
pub(super) type Described = (Instrument, Vec<Complex32>);

impl Radar {
    /// Takes a description of waveform and filter; whether it agrees with an earlier one.
    pub(super) fn learn_signal(&mut self, signal: SignalDescription) -> bool {
        *self.signal.get_or_insert_with(|| signal.clone()) == signal
    }

    /// Takes an antenna.
    pub(super) fn learn_antenna(&mut self, antenna: AntennaDescription) -> bool {
        let [number, of] = antenna.number.map(|n| n as usize);
        if !self.antennas.is_empty() && self.antennas.len() != of {
            return false;
        }
        self.antennas.resize_with(of, || None);
        let Some(known) = self.antennas.get_mut(number) else { return false };
        *known.get_or_insert_with(|| antenna.clone()) == antenna
    }

    /// Takes a piece of the replica, if the run announces it: nothing is held that nobody waits for.
    pub(super) fn learn_piece(&mut self, piece: ReplicaPiece, announced: Option<[u32; 2]>) -> bool {
        let Some([_, of]) = announced else { return true };
        if self.pieces.is_empty() {
            self.piece = piece.piece;
        }
        // Pieces of one length do not overlap.
        if (piece.piece, piece.of) != (self.piece, of) {
            return false;
        }
        *self.pieces.entry(piece.first).or_insert_with(|| piece.samples.clone()) == piece.samples
    }

    /// Forgets waveform and filter.
    pub(super) fn forget_signal(&mut self) {
        self.signal = None;
    }

    /// Forgets what contradicts an antenna: itself, or all where their number has changed.
    pub(super) fn forget_antenna(&mut self, [number, of]: [u32; 2]) {
        let same = self.antennas.len() == of as usize;
        match self.antennas.get_mut(number as usize) {
            Some(known) if same => *known = None,
            _ => self.antennas.clear(),
        }
    }

    /// Forgets what contradicts a piece of the replica: itself, or all where the pieces were of another
    /// length.
    pub(super) fn forget_piece(&mut self, piece: &ReplicaPiece) {
        if piece.piece == self.piece {
            self.pieces.remove(&piece.first);
        } else {
            self.forget_replica();
        }
    }

    /// Forgets the replica.
    pub(super) fn forget_replica(&mut self) {
        self.pieces.clear();
    }

    /// What was announced; `None` until all of it has come, and `Some(None)` where nothing was.
    pub(super) fn described(
        &self,
        announced: Option<[u32; 2]>,
        platforms: &[&String],
    ) -> Option<Option<Described>> {
        let Some([antennas, samples]) = announced else { return Some(None) };
        let signal = self.signal.as_ref()?;
        let known: Vec<&AntennaDescription> =
            self.antennas.iter().map(Option::as_ref).collect::<Option<_>>()?;
        let got: usize = self.pieces.values().map(Vec::len).sum();
        if known.len() != antennas as usize || got != samples as usize {
            return None;
        }
        let row = |antenna: &&AntennaDescription| {
            Some(AntennaRow {
                name: antenna.name.clone(),
                transmits: antenna.transmits,
                platform: (*platforms.get(antenna.platform as usize)?).clone(),
                lever_arm_m: antenna.lever_arm_m,
                pattern: antenna.pattern.clone(),
                aperture_m: antenna.aperture_m,
                look: antenna.look.look(platforms)?,
            })
        };
        let instrument = Instrument {
            waveform: signal.waveform.clone(),
            filter: signal.filter.clone(),
            earth_radius_factor: signal.earth_radius_factor,
            window: match signal.window.kind {
                0 => None,
                _ => Some(signal.window.look(platforms)?),
            },
            continuous: signal.window.kind == 0 && signal.window.platform == 1,
            middle_m: signal.middle_m,
            antennas: known.iter().map(row).collect::<Option<_>>()?,
        };
        Some(Some((instrument, self.pieces.values().flatten().copied().collect())))
    }
}
