//! What a sender describes of its radar: waveform, receive filter, replica, antennas, emitters. Senders of
//! earlier versions do not; a recording of what they send cannot be focused.

use std::collections::BTreeMap;

use num_complex::Complex32;

use super::packet::{Malformed, Words};
use crate::pulse::flags::MOST_CLASS;
use crate::recording::instrument::{
    AntennaRow, EmitterRow, FilterRow, GateRow, Instrument, Look, PulseRow, WaveformRow,
};

/// Most antennas (and as many emitters) and longest replica that are taken.
pub(super) const ANTENNAS: u32 = 1024;
pub(super) const REPLICA: u32 = 1 << 20;
/// Most pulses in turn.
pub(super) const TURNS: u32 = 1024;
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
    /// Error of each class of pulses, dB; empty where there is one.
    pub error_classes_db: Vec<f64>,
    /// Pulses in turn that are described; 0 where all are alike.
    pub turns: u32,
}

/// One of several pulses in turn.
#[derive(Clone, Debug, PartialEq)]
pub struct PulseDescription {
    /// Its number, and how many there are.
    pub number: [u32; 2],
    /// What is said of it.
    pub row: PulseRow,
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
    /// What is said of it: all but the names of platforms.
    pub row: AntennaRow,
    /// Number of its platform.
    pub platform: u32,
    /// Where it looks.
    pub look: Aimed,
    /// What a window of its own follows.
    pub follows: Option<Aimed>,
}

/// An emitter.
#[derive(Clone, Debug, PartialEq)]
pub struct EmitterDescription {
    /// Its antenna; its number, and how many emitters there are.
    pub antenna: AntennaDescription,
    /// What is said of it: all but its antenna and the names of receivers.
    pub row: EmitterRow,
    /// Numbers of the receivers that take it.
    pub receivers: Vec<u32>,
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

/// Kinds of what an antenna looks at; of what a window follows.
const LOOKS: u32 = 3;
const FOLLOWED: u32 = 2;

fn aimed(words: &mut Words<'_>, most: u32) -> Result<Aimed, Malformed> {
    let (kind, platform) = (words.u32()?, words.u32()?);
    if kind > most {
        return Err(Malformed::Value("such a place to look at"));
    }
    Ok(Aimed { kind, platform, numbers: finite(words)? })
}

pub(super) fn signal(words: &mut Words<'_>) -> Result<SignalDescription, Malformed> {
    let (sweep_hz_per_s, rate_hz) = (optional(words)?, optional(words)?);
    let [flat_hz, zero_hz] = finite(words)?;
    let (earth_radius_factor, middle_m) = (optional(words)?, finite(words)?);
    let window = aimed(words, FOLLOWED)?;
    let waveform = WaveformRow { kind: words.text()?, sweep_hz_per_s, rate_hz, pulses: Vec::new() };
    let filter = FilterRow { kind: words.text()?, flat_hz, zero_hz };
    // An addition: the error of each class of pulses, and how many leave in turn.
    let [classes, turns] = if words.is_empty() { [0; 2] } else { [words.u32()?, words.u32()?] };
    if classes > MOST_CLASS + 1 || turns > TURNS {
        return Err(Malformed::Value("so many error classes, or pulses in turn,"));
    }
    let error_classes_db = (0..classes).map(|_| Ok(finite::<1>(words)?[0])).collect::<Result<_, _>>()?;
    Ok(SignalDescription { waveform, filter, earth_radius_factor, middle_m, window, error_classes_db, turns })
}

pub(super) fn pulse(words: &mut Words<'_>) -> Result<PulseDescription, Malformed> {
    let number = [words.u32()?, words.u32()?];
    let [offset_hz, bandwidth_hz, pulse_s] = finite(words)?;
    let sweep_hz_per_s = optional(words)?;
    let row = PulseRow { kind: words.text()?, offset_hz, bandwidth_hz, pulse_s, sweep_hz_per_s };
    if !row.is_legal() {
        return Err(Malformed::Value("such a pulse"));
    }
    Ok(PulseDescription { number, row })
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

/// What the descriptions of antennas and of emitters have in common.
fn mount(words: &mut Words<'_>, number: [u32; 2], transmits: bool) -> Result<AntennaDescription, Malformed> {
    let platform = words.u32()?;
    let lever_arm_m = finite(words)?;
    let aperture_m = match [optional(words)?, optional(words)?] {
        [Some(width_m), Some(height_m)] => Some([width_m, height_m]),
        _ => None,
    };
    let row = AntennaRow { transmits, lever_arm_m, aperture_m, ..AntennaRow::default() };
    Ok(AntennaDescription { number, row, platform, look: aimed(words, LOOKS)?, follows: None })
}

pub(super) fn antenna(words: &mut Words<'_>) -> Result<AntennaDescription, Malformed> {
    let number = [words.u32()?, words.u32()?];
    let transmits = words.u32()? == 0;
    let mut antenna = mount(words, number, transmits)?;
    (antenna.row.name, antenna.row.pattern) = (words.text()?, words.text()?);
    if !words.is_empty() {
        let kind = words.u32()?;
        words.u32()?;
        let [start_s] = finite(words)?;
        antenna.row.window = match kind {
            1 => Some(GateRow::Fixed { start_s }),
            // What it follows is found among the platforms.
            2 => Some(GateRow::Follow { look: Look::default(), lead_s: start_s }),
            _ => None,
        };
        antenna.follows = Some(aimed(words, FOLLOWED)?).filter(|_| kind == 2);
    }
    Ok(antenna)
}

pub(super) fn emitter(words: &mut Words<'_>) -> Result<EmitterDescription, Malformed> {
    let number = [words.u32()?, words.u32()?];
    let received = words.u32()?;
    let mut antenna = mount(words, number, true)?;
    let [carrier_hz, bandwidth_hz, pulse_s] = finite(words)?;
    let (sweep_hz_per_s, rate_hz) = (optional(words)?, optional(words)?);
    let [start_s, prf_hz, power_w] = finite(words)?;
    let (intervals, sent) = (words.u32()?, words.u32()?);
    let pri_s = (0..sent).map(|_| words.f64()).collect::<Result<_, _>>()?;
    let count = words.u32()?;
    let receivers = (0..count).map(|_| words.u32()).collect::<Result<_, _>>()?;
    (antenna.row.name, antenna.row.pattern) = (words.text()?, words.text()?);
    let (polarisation, basis) = (words.text()?, words.text()?);
    let row = EmitterRow {
        antenna: AntennaRow { name: antenna.row.name.clone(), transmits: true, ..AntennaRow::default() },
        waveform: WaveformRow { kind: words.text()?, sweep_hz_per_s, rate_hz, pulses: Vec::new() },
        carrier_hz,
        bandwidth_hz,
        pulse_s,
        start_s,
        prf_hz,
        intervals,
        pri_s,
        power_w,
        polarisation,
        basis,
        receivers: Vec::new(),
        direct_path: received & 1 != 0,
        echo: received & 2 != 0,
    };
    if row.fault(&[]).is_some() {
        return Err(Malformed::Value("such an emitter"));
    }
    Ok(EmitterDescription { antenna, row, receivers })
}

impl AntennaDescription {
    /// As recordings have it; `None` on or beside a platform that there is not.
    fn row(&self, platforms: &[&String]) -> Option<AntennaRow> {
        let mut row = AntennaRow {
            platform: (*platforms.get(self.platform as usize)?).clone(),
            look: self.look.look(platforms)?,
            ..self.row.clone()
        };
        if let (Some(GateRow::Follow { look, .. }), Some(follows)) = (&mut row.window, &self.follows) {
            *look = follows.look(platforms)?;
        }
        Some(row)
    }
}

impl EmitterDescription {
    /// As recordings have it; `None` with a platform or a receiver that there is not.
    fn row(&self, platforms: &[&String], antennas: &[AntennaRow]) -> Option<EmitterRow> {
        let names: Vec<&String> =
            antennas.iter().filter(|antenna| !antenna.transmits).map(|antenna| &antenna.name).collect();
        let receivers = self.receivers.iter().map(|place| Some((*names.get(*place as usize)?).clone()));
        Some(EmitterRow {
            antenna: self.antenna.row(platforms)?,
            receivers: receivers.collect::<Option<_>>()?,
            ..self.row.clone()
        })
    }
}

impl Aimed {
    /// As recordings have it; `None` beside a platform that there is not.
    fn look(&self, platforms: &[&String]) -> Option<Look> {
        let [a, b, c, d, e, f] = self.numbers;
        Some(match self.kind {
            0 => Look::Body { yaw_rad: a, pitch_rad: b, roll_rad: c },
            1 => Look::Point { position_m: [a, b, c], velocity_mps: [d, e, f] },
            3 => Look::Scan {
                level: self.platform != 0,
                rate_deg_per_s: a,
                sector_deg: [b, c],
                elevation_deg: d,
            },
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
    emitters: Vec<Option<EmitterDescription>>,
    pulses: Vec<Option<PulseDescription>>,
    /// Pieces of the replica by their first samples, and the samples of a piece.
    pieces: BTreeMap<u32, Vec<Complex32>>,
    piece: u32,
}

/// Instrument and replica.
pub(super) type Described = (Instrument, Vec<Complex32>);

/// Takes an entry of a list; whether it agrees with an earlier one.
fn learn<T: Clone + PartialEq>(list: &mut Vec<Option<T>>, number: [u32; 2], found: T) -> bool {
    let [number, of] = number.map(|n| n as usize);
    if !list.is_empty() && list.len() != of {
        return false;
    }
    list.resize_with(of, || None);
    let Some(known) = list.get_mut(number) else { return false };
    *known.get_or_insert_with(|| found.clone()) == found
}

/// Forgets what contradicts an entry: itself, or all where their number has changed.
fn forget<T>(list: &mut Vec<Option<T>>, [number, of]: [u32; 2]) {
    let same = list.len() == of as usize;
    match list.get_mut(number as usize) {
        Some(known) if same => *known = None,
        _ => list.clear(),
    }
}

/// All entries of a list, once there are as many as were announced.
fn announced_entries<T>(list: &[Option<T>], count: u32) -> Option<Vec<&T>> {
    let list = if count == 0 { &[] } else { list };
    let entries: Vec<&T> = list.iter().map(Option::as_ref).collect::<Option<_>>()?;
    (entries.len() == count as usize).then_some(entries)
}

impl Radar {
    /// Takes a description of waveform and filter; whether it agrees with an earlier one.
    pub(super) fn learn_signal(&mut self, signal: SignalDescription) -> bool {
        *self.signal.get_or_insert_with(|| signal.clone()) == signal
    }

    /// Takes an antenna.
    pub(super) fn learn_antenna(&mut self, antenna: AntennaDescription) -> bool {
        learn(&mut self.antennas, antenna.number, antenna)
    }

    /// Takes an emitter.
    pub(super) fn learn_emitter(&mut self, emitter: EmitterDescription) -> bool {
        learn(&mut self.emitters, emitter.antenna.number, emitter)
    }

    /// Takes one of several pulses in turn.
    pub(super) fn learn_pulse(&mut self, pulse: PulseDescription) -> bool {
        learn(&mut self.pulses, pulse.number, pulse)
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

    /// Forgets what contradicts an antenna.
    pub(super) fn forget_antenna(&mut self, number: [u32; 2]) {
        forget(&mut self.antennas, number);
    }

    /// Forgets what contradicts an emitter.
    pub(super) fn forget_emitter(&mut self, number: [u32; 2]) {
        forget(&mut self.emitters, number);
    }

    /// Forgets what contradicts one of several pulses in turn.
    pub(super) fn forget_pulse(&mut self, number: [u32; 2]) {
        forget(&mut self.pulses, number);
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
        emitters: u32,
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
        let others = announced_entries(&self.emitters, emitters)?;
        let pulses = announced_entries(&self.pulses, signal.turns)?;
        let antennas =
            known.iter().map(|antenna| antenna.row(platforms)).collect::<Option<Vec<AntennaRow>>>()?;
        let emitters = others.iter().map(|emitter| emitter.row(platforms, &antennas));
        let instrument = Instrument {
            waveform: WaveformRow {
                pulses: pulses.into_iter().map(|pulse| pulse.row.clone()).collect(),
                ..signal.waveform.clone()
            },
            filter: signal.filter.clone(),
            earth_radius_factor: signal.earth_radius_factor,
            window: match signal.window.kind {
                0 => None,
                _ => Some(signal.window.look(platforms)?),
            },
            continuous: signal.window.kind == 0 && signal.window.platform == 1,
            // The wire does not say.
            dechirp_s: None,
            middle_m: signal.middle_m,
            emitters: emitters.collect::<Option<_>>()?,
            antennas,
            error_classes_db: signal.error_classes_db.clone(),
        };
        Some(Some((instrument, self.pieces.values().flatten().copied().collect())))
    }
}
