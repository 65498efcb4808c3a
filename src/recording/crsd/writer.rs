//! A CRSD file under way: arrays of records at planned places, pulled together at the end.
//!
//! The file has, in this order, a header of text, the XML, and the blocks Support, PPP, PVP and Signal, in
//! which every array follows the one before without a gap. How long arrays are must be known before the first
//! sample is written: they are planned from the pulses of the run, and written where they will be. Fewer
//! pulses leave gaps at their ends. Then the arrays behind are moved down, in place; header and XML, which
//! state where everything is, are written last, into room kept for them. Nothing but a buffer for each array
//! is held in memory.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use num_complex::{Complex, Complex32};

use super::description::{Channel, Description, FLAT, Sequence, Signal};
use super::document::{self, Blocks, XML_AT};
use super::fault::CrsdError;
use super::pattern::GainArray;
use super::records::{Grid, Known, PPP, PVP, Record, bytes};
use super::states::{PulseRow, State, state};
use crate::time::TimeTag;

/// Blocks begin at multiples of this.
const ALIGNED: u64 = 64;
/// What an array holds back before it is written.
const BUFFER: usize = 1 << 20;
const WRITING: &str = "writing the CRSD file";

/// Samples of a pulse, channel by channel.
#[derive(Clone, Copy, Debug)]
pub enum PulseSamples<'a> {
    /// sqrt(W).
    Cf32(&'a [Complex32]),
    /// Codes.
    Ci16(&'a [Complex<i16>]),
}

/// An array of records.
#[derive(Debug)]
struct Array {
    /// Where it is in the file.
    at: u64,
    record: usize,
    planned: u64,
    written: u64,
    buffer: Vec<u8>,
}

impl Array {
    fn bytes(&self) -> u64 {
        self.written * self.record as u64
    }
}

/// A CRSD file under way.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
    description: Arc<Description>,
    grid: Option<Grid>,
    last_opening: Vec<Option<TimeTag>>,
    support: Vec<u8>,
    /// PPP of every sequence, PVP of every channel, signal of every channel.
    arrays: Vec<Array>,
    planned: u64,
    pulses: u64,
}

fn aligned(at: u64) -> u64 {
    at.next_multiple_of(ALIGNED)
}

impl Writer {
    /// Plans a file in which sequence `i` has at most `planned[i]` pulses.
    ///
    /// # Errors
    /// A sequence with fewer than two pulses.
    pub fn new(
        path: &Path,
        file: File,
        description: Description,
        planned: &[u64],
    ) -> Result<Self, CrsdError> {
        let of = |sequence: usize| planned.get(sequence).copied().unwrap_or(0);
        description.check_planned(planned)?;
        let support = support(&description);
        let names: usize = description.channels.iter().map(|c| c.id.len()).sum::<usize>()
            + description.ends.iter().map(|end| end.name.len() + end.platform.len()).sum::<usize>();
        let parts = description.channels.len() + description.sequences.len() + description.ends.len();
        let room = (64 << 10) + (16 << 10) * parts + 64 * names;
        let mut at = aligned(XML_AT + room as u64) + support.len() as u64;
        let mut arrays = Vec::new();
        let mut plan = |record: usize, planned: u64| {
            at = aligned(at);
            arrays.push(Array { at, record, planned, written: 0, buffer: Vec::new() });
            at += planned * record as u64;
        };
        for sequence in 0..description.sequences.len() {
            plan(bytes(&PPP), of(sequence));
        }
        for channel in &description.channels {
            plan(bytes(&PVP), of(channel.sequence));
        }
        let vector = description.header.layout.samples * description.signal.bytes();
        for channel in &description.channels {
            plan(vector, of(channel.sequence));
        }
        let last_opening = vec![None; description.channels.len()];
        let planned = planned.iter().copied().max().unwrap_or(0);
        let path = path.to_owned();
        Ok(Self {
            path,
            file,
            description: Arc::new(description),
            grid: None,
            last_opening,
            support,
            arrays,
            planned,
            pulses: 0,
        })
    }

    /// Takes the pulse of a row; rows around it show where antennas are between emissions.
    ///
    /// # Errors
    /// A pulse beyond those planned, windows that overlap, what is no number, and what the system refuses.
    pub(super) fn push(
        &mut self,
        rows: &[PulseRow],
        at: usize,
        samples: PulseSamples,
    ) -> Result<(), CrsdError> {
        let row = &rows[at];
        let description = Arc::clone(&self.description);
        let header = &description.header;
        let opening = row.time.plus(row.window_start_s);
        if !row.window_start_s.is_finite() {
            return Err(CrsdError::NotFinite { pulse: row.index, what: "pulse/window_start_s".to_owned() });
        }
        let rate_hz = header.sample_rate_hz;
        let shift_s = self.grid.get_or_insert(Grid::new(opening, rate_hz)).shift_s(opening);
        let middle_s = 0.5 * header.pulse_s;
        for (place, sequence) in description.sequences.iter().enumerate() {
            if description.is_in(row.tx_pol, place) {
                let state = state(&description, rows, at, sequence.end, middle_s)?;
                let emission = row.time.plus(middle_s).plus(shift_s);
                let record =
                    description.pulse_record(sequence, &state, emission, shift_s, (row.index, row.flags));
                self.append(place, row.index, |buffer| buffer.extend(record.0))?;
            }
        }
        let (sequences, channels) = (description.sequences.len(), description.channels.len());
        // Channels of one antenna share its state.
        let mut known: Vec<Option<State>> = vec![None; description.ends.len()];
        for (place, channel) in description.channels.iter().enumerate() {
            if !description.is_in(row.tx_pol, channel.sequence) {
                continue;
            }
            self.check_apart(place, row.index, opening)?;
            let state = match known[channel.end] {
                Some(state) => state,
                None => state(&description, rows, at, channel.end, row.window_start_s)?,
            };
            known[channel.end] = Some(state);
            let pulse = self.arrays[channel.sequence].written as i64 - 1;
            let record = description.vector_record(&state, opening, shift_s, row.window_start_s, pulse);
            self.append(sequences + place, row.index, |buffer| buffer.extend(record.0))?;
            self.append_samples(sequences + channels + place, channel, row.index, samples)?;
        }
        self.pulses += 1;
        Ok(())
    }

    /// Whether the window of a channel that opens now begins when the one before has ended.
    fn check_apart(&mut self, place: usize, pulse: u64, opening: TimeTag) -> Result<(), CrsdError> {
        let header = &self.description.header;
        let window_s = header.layout.samples as f64 / header.sample_rate_hz;
        let Some(last) = self.last_opening[place].replace(opening) else { return Ok(()) };
        let apart_s = opening.since(last);
        if apart_s >= window_s {
            return Ok(());
        }
        let channel = self.description.channels[place].id.clone();
        Err(CrsdError::Overlap { pulse, channel, apart_s, window_s })
    }

    fn append_samples(
        &mut self,
        array: usize,
        channel: &Channel,
        pulse: u64,
        samples: PulseSamples,
    ) -> Result<(), CrsdError> {
        let count = self.description.header.layout.samples;
        let range = channel.place * count..(channel.place + 1) * count;
        let signal = self.description.signal;
        let bad =
            |what: &str| CrsdError::NotFinite { pulse, what: format!("{what} of channel {}", channel.id) };
        match samples {
            PulseSamples::Cf32(all) => {
                let values = all.get(range).ok_or_else(|| bad("a sample"))?;
                if values.iter().any(|z| !(z.re.is_finite() && z.im.is_finite())) {
                    return Err(bad("a sample"));
                }
                self.append(array, pulse, |buffer| {
                    for z in values {
                        buffer.extend(z.re.to_be_bytes());
                        buffer.extend(z.im.to_be_bytes());
                    }
                })
            }
            PulseSamples::Ci16(all) => {
                let codes = all.get(range).ok_or_else(|| bad("a sample"))?;
                self.append(array, pulse, |buffer| {
                    codes.iter().for_each(|code| encode(signal, *code, buffer))
                })
            }
        }
    }

    fn append(&mut self, array: usize, pulse: u64, fill: impl FnOnce(&mut Vec<u8>)) -> Result<(), CrsdError> {
        let planned = self.planned;
        let array = &mut self.arrays[array];
        if array.written == array.planned {
            return Err(CrsdError::Room { pulse, planned });
        }
        fill(&mut array.buffer);
        array.written += 1;
        if array.buffer.len() >= BUFFER {
            Self::write_buffer(&mut self.file, &self.path, array)?;
        }
        Ok(())
    }

    fn write_buffer(file: &mut File, path: &Path, array: &mut Array) -> Result<(), CrsdError> {
        let at = array.at + array.bytes() - array.buffer.len() as u64;
        let io = |source| CrsdError::io(path, WRITING)(source);
        file.seek(SeekFrom::Start(at)).map_err(io)?;
        file.write_all(&array.buffer).map_err(io)?;
        array.buffer.clear();
        Ok(())
    }

    /// What the file holds.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Pulses taken.
    pub fn pulses(&self) -> u64 {
        self.pulses
    }

    /// The channel that has too few pulses for a file, if any.
    pub fn too_few(&self) -> Option<CrsdError> {
        let short =
            self.description.channels.iter().find(|channel| self.arrays[channel.sequence].written < 2)?;
        Some(CrsdError::FewPulses { channel: short.id.clone(), pulses: self.arrays[short.sequence].written })
    }

    /// Completes the file, and returns its length.
    ///
    /// # Errors
    /// A channel with fewer than two pulses, and what the system refuses.
    pub fn finish(mut self) -> Result<u64, CrsdError> {
        if let Some(short) = self.too_few() {
            return Err(short);
        }
        for array in &mut self.arrays {
            Self::write_buffer(&mut self.file, &self.path, array)?;
        }
        let blocks = self.pull_together()?;
        let path = self.path.clone();
        let io = |source| CrsdError::io(&path, WRITING)(source);
        let (_, end) = (blocks.signal.0, blocks.signal.0 + blocks.signal.1);
        let xml = document::xml(&self.facts()?).map_err(io)?;
        let header = document::file_header(&blocks, xml.len());
        if XML_AT + xml.len() as u64 + 2 > blocks.support.0 || header.len() as u64 > XML_AT {
            let words = format!("{} bytes of XML are more than the room kept for them", xml.len());
            return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidData, words)));
        }
        self.file.seek(SeekFrom::Start(0)).map_err(io)?;
        self.file.write_all(&header).map_err(io)?;
        self.file.seek(SeekFrom::Start(XML_AT)).map_err(io)?;
        self.file.write_all(&xml).and_then(|()| self.file.write_all(document::SECTION_END)).map_err(io)?;
        self.file.seek(SeekFrom::Start(blocks.support.0)).map_err(io)?;
        self.file.write_all(&self.support).map_err(io)?;
        self.file.set_len(end).and_then(|()| self.file.sync_all()).map_err(io)?;
        Ok(end)
    }

    /// Moves arrays down to where the ones before them end; blocks stay aligned.
    fn pull_together(&mut self) -> Result<Blocks, CrsdError> {
        let sequences = self.description.sequences.len();
        let channels = self.description.channels.len();
        let support_at = self.arrays[0].at - aligned(self.support.len() as u64);
        let support = (support_at, self.support.len() as u64);
        let mut end = support.0 + support.1;
        let mut block = |of: std::ops::Range<usize>| -> Result<(u64, u64), CrsdError> {
            let begin = aligned(end);
            self.write_zeros(end, begin - end)?;
            end = begin;
            for place in of {
                let (from, length) = (self.arrays[place].at, self.arrays[place].bytes());
                self.move_down(from, end, length)?;
                self.arrays[place].at = end;
                end += length;
            }
            Ok((begin, end - begin))
        };
        Ok(Blocks {
            support,
            ppp: block(0..sequences)?,
            pvp: block(sequences..sequences + channels)?,
            signal: block(sequences + channels..sequences + 2 * channels)?,
        })
    }

    fn write_zeros(&mut self, at: u64, count: u64) -> Result<(), CrsdError> {
        let io = |source| CrsdError::io(&self.path, WRITING)(source);
        self.file.seek(SeekFrom::Start(at)).map_err(io)?;
        self.file
            .write_all(&vec![0; count as usize])
            .map_err(|source| CrsdError::io(&self.path, WRITING)(source))
    }

    fn move_down(&mut self, from: u64, to: u64, length: u64) -> Result<(), CrsdError> {
        if from == to {
            return Ok(());
        }
        let mut piece = vec![0; BUFFER];
        let mut done = 0;
        while done < length {
            let count = (length - done).min(BUFFER as u64) as usize;
            self.read_at(from + done, &mut piece[..count])?;
            let written =
                self.file.seek(SeekFrom::Start(to + done)).and_then(|_| self.file.write_all(&piece[..count]));
            written.map_err(|source| CrsdError::io(&self.path, WRITING)(source))?;
            done += count as u64;
        }
        Ok(())
    }

    fn read_at(&mut self, at: u64, into: &mut [u8]) -> Result<(), CrsdError> {
        let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(into));
        read.map_err(|source| CrsdError::io(&self.path, "reading the CRSD file back")(source))
    }

    fn record(&mut self, array: usize, place: u64) -> Result<Vec<u8>, CrsdError> {
        let mut bytes = vec![0; self.arrays[array].record];
        let at = self.arrays[array].at + place * self.arrays[array].record as u64;
        self.read_at(at, &mut bytes)?;
        Ok(bytes)
    }

    /// The first, the middle and the last record of an array.
    fn three(
        &mut self,
        array: usize,
        fields: &'static [super::records::Field],
    ) -> Result<[Known<'static>; 3], CrsdError> {
        let count = self.arrays[array].written;
        let mut at = |place| Ok::<_, CrsdError>(Known { fields, bytes: self.record(array, place)? });
        Ok([at(0)?, at(count / 2)?, at(count - 1)?])
    }

    fn facts(&mut self) -> Result<document::Facts, CrsdError> {
        let sequences = self.description.sequences.len();
        let channels = self.description.channels.len();
        let pulses = (0..sequences).map(|i| self.three(i, &PPP)).collect::<Result<_, _>>()?;
        let vectors = (0..channels).map(|i| self.three(sequences + i, &PVP)).collect::<Result<_, _>>()?;
        let counts = self.arrays[..sequences].iter().map(|array| array.written).collect();
        Ok(document::Facts { description: Arc::clone(&self.description), pulses, vectors, counts })
    }
}

/// A code as `2 code + 1`, or as its half where that does not fit.
fn encode(signal: Signal, code: Complex<i16>, buffer: &mut Vec<u8>) {
    for part in [code.re, code.im] {
        let odd = 2 * i32::from(part) + 1;
        match signal {
            Signal::Ci2 => buffer.extend((odd as i8).to_be_bytes()),
            Signal::Ci4 => buffer.extend((odd as i16).to_be_bytes()),
            Signal::Cf8 => buffer.extend((0.5 * odd as f32).to_be_bytes()),
        }
    }
}

/// The support block: the gains of every antenna, an element that is the same everywhere, a flat response,
/// the pulse behind the receive filter.
fn support(description: &Description) -> Vec<u8> {
    let element = GainArray::flat();
    let arrays = description.ends.iter().map(|end| &end.array).chain([&element]);
    let values = arrays.flat_map(|array| array.values.iter().flatten().copied());
    let response = [1.0_f32, 0.0].repeat(document::RESPONSE_COLUMNS);
    let replica = description.header.replica.iter().flat_map(|z| [z.re, z.im]);
    values.chain(response).chain(replica).flat_map(canonical).collect()
}

/// Bytes of a value; what is none has those of `NODATA`.
fn canonical(value: f32) -> [u8; 4] {
    if value.is_nan() { 0x7fc0_0000_u32.to_be_bytes() } else { value.to_be_bytes() }
}

impl Description {
    fn pulse_record(
        &self,
        sequence: &Sequence,
        state: &State,
        emission: TimeTag,
        shift_s: f64,
        (index, flags): (u64, u32),
    ) -> Record {
        let header = &self.header;
        let mut record = Record::default();
        record
            .time(emission, header.start.seconds())
            .motion(state)
            .real(header.carrier_hz - 0.5 * header.bandwidth_hz)
            .real(header.carrier_hz + 0.5 * header.bandwidth_hz)
            .real(header.pulse_s)
            .cycles(header.carrier_hz, 0.5 * header.pulse_s)
            .real(header.carrier_hz)
            .real(self.sweep_hz_s)
            .real(sequence.intensity_dbw)
            .axes(state)
            .whole(0)
            .real(0.0 - shift_s)
            .whole(index as i64)
            .whole(flags.into());
        record
    }

    fn vector_record(
        &self,
        state: &State,
        opening: TimeTag,
        shift_s: f64,
        window_start_s: f64,
        pulse: i64,
    ) -> Record {
        let header = &self.header;
        let mut record = Record::default();
        record
            .time(opening.plus(shift_s), header.start.seconds())
            .motion(state)
            .real(header.carrier_hz - 0.5 * FLAT * header.sample_rate_hz)
            .real(header.carrier_hz + 0.5 * FLAT * header.sample_rate_hz)
            .cycles(header.carrier_hz, window_start_s)
            .real(header.carrier_hz)
            .real(0.0)
            .real(0.0)
            .axes(state)
            .whole(1)
            .real(self.scale)
            .real(0.0)
            .whole(pulse)
            .real(0.0 - shift_s);
        record
    }
}
