//! A recording as SigMF, the form in which tools of software radio exchange samples.
//!
//! A channel is a SigMF recording: samples one after the other (`.sigmf-data`), and what they are
//! (`.sigmf-meta`): one capture, an annotation a pulse. Several channels are tied together by a collection
//! (`.sigmf-collection`). `docs/formats.md` lists what stands where.
//!
//! Samples are those of the recording, bit for bit: `cf32_le`, or of an ADC its counts, `ci16_le`. Windows
//! follow each other without the time between them: a tool that draws them draws no gap, and the annotation
//! states when each was taken.
//!
//! The recording is read in blocks, twice: its samples, then what is known of each pulse. Files are made
//! under other names and get their own when all are complete: data first, since it is the metadata that makes
//! a recording.
//!
//! Source: SigMF 1.2. Limits: times in nanoseconds, from 1678 to 2262.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Value, json};
use sha2::{Digest, Sha512};

use super::columns::{Column, Rows, columns};
use super::fault::RecordingError;
use super::header::Header;
use super::source::Source;
use super::{RECEIVER_WINDOWS, check_instants};
use crate::files::{self, Draft, FileFault, Holding, Recognised};
use crate::frames::{Earth, Geodetic, Point, SceneFrame};
use crate::inputs;
use crate::pulse::{SampleFormat, flags};

/// Version of the specification that is written.
const VERSION: &str = "1.2.0";
/// Samples that are read at a time, bytes in the file; pulses of which all else is.
const BLOCK_BYTES: usize = 4 << 20;
const BLOCK_PULSES: usize = 1024;
/// What an action on an output is called.
const WRITING: &str = "writing the SigMF file";

/// What is exported, and where to.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Where to: the name of the SigMF recording, with or without one of its endings.
    pub out: PathBuf,
    /// Channels by name; all, if none is named.
    pub channels: Vec<String>,
    /// Pulses by number; all, if there is no range.
    pub pulses: Option<Range<u64>>,
    /// Overwrite what an earlier export has left.
    pub force: bool,
}

/// What was exported.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Exported {
    /// Pulses.
    pub pulses: usize,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Samples of a channel.
    pub samples: u64,
    /// SigMF's name of their type.
    pub datatype: &'static str,
    /// The files.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub out: Vec<PathBuf>,
}

/// A recording that is exported.
struct Job<'a> {
    path: &'a Path,
    source: Source,
    columns: Vec<Column>,
    /// Rows that are exported.
    rows: Range<usize>,
    frame: Option<SceneFrame>,
}

/// A file under way, and its hash.
struct Part {
    draft: Draft,
    file: BufWriter<File>,
    hash: Sha512,
}

/// A channel, and the files of its SigMF recording.
struct Channel {
    place: usize,
    name: String,
    data: PathBuf,
    meta: PathBuf,
}

/// Exports a recording.
///
/// # Errors
/// A recording that cannot be read or is damaged, a channel or pulses that it has not, what stands in the
/// way of the files. Nothing is left under their names then.
pub fn export(path: &Path, settings: &Settings) -> Result<Exported, RecordingError> {
    let job = Job::open(path, settings)?;
    let (channels, collection) = job.plan(settings)?;
    let mut parts = Vec::new();
    let written = job.write(&channels, collection.as_deref(), &mut parts);
    if let Err(error) = written {
        parts.into_iter().for_each(|part| part.draft.abandon());
        return Err(error);
    }
    let mut out = Vec::new();
    let mut parts = parts.into_iter();
    for part in parts.by_ref() {
        match part.draft.finish(settings.force, &recognise) {
            Ok(file) => out.extend(file),
            Err(fault) => {
                parts.for_each(|part| part.draft.abandon());
                return Err(fault.into());
            }
        }
    }
    let header = job.source.header();
    Ok(Exported {
        pulses: job.rows.len(),
        channels: channels.into_iter().map(|channel| channel.name).collect(),
        samples: (job.rows.len() * header.layout.samples) as u64,
        datatype: datatype(header),
        out,
    })
}

fn datatype(header: &Header) -> &'static str {
    match header.layout.format {
        SampleFormat::Cf32 => "cf32_le",
        SampleFormat::Ci16 => "ci16_le",
    }
}

/// Whether a file is one that an export has made: the mark of it is at the beginning of the metadata and of
/// the collection, and samples lie beside their metadata.
fn recognise(path: &Path) -> Recognised {
    let ours = |path: &Path| {
        let start = inputs::beginning(path, 64).unwrap_or_default();
        let text = String::from_utf8_lossy(&start).into_owned();
        text.starts_with(&opening("global")) || text.starts_with(&opening("collection"))
    };
    let is_data = path.extension().is_some_and(|ending| ending == "sigmf-data");
    let is_ours = if is_data { ours(&path.with_extension("sigmf-meta")) } else { ours(path) };
    is_ours.then_some(Holding::File).ok_or("SigMF file of this program")
}

/// How metadata and collections of this program begin.
fn opening(object: &str) -> String {
    format!("{{\"{object}\":{{\"nereus:software\":")
}

impl<'a> Job<'a> {
    fn open(path: &'a Path, settings: &Settings) -> Result<Self, RecordingError> {
        let source = Source::open(path)?;
        let header = source.header();
        let columns = columns(header);
        let frame = header.origin.map(|origin| {
            let place = Geodetic::from_deg(origin.lat_deg, origin.lon_deg, origin.h_m);
            SceneFrame::at(place, Earth::Flat)
        });
        let pulses = source.pulses();
        let mut job = Self { path, source, columns, rows: 0..pulses, frame };
        let Rows::U64(index) = job.rows("pulse/index", 0..pulses)? else {
            return Err(job.foreign("/pulse/index holds no numbers".to_owned()));
        };
        if let Some(pair) = index.windows(2).find(|pair| pair[1] <= pair[0]) {
            let [before, after] = [pair[0], pair[1]];
            return Err(job.foreign(format!("pulse {after} comes after pulse {before}; pulses ascend")));
        }
        let asked = settings.pulses.clone().unwrap_or(0..u64::MAX);
        job.rows = index.partition_point(|i| *i < asked.start)..index.partition_point(|i| *i < asked.end);
        if job.rows.is_empty() {
            let first = index.first().copied().unwrap_or(0);
            let end = index.last().map_or(first, |last| last.saturating_add(1));
            return Err(RecordingError::NoPulses { path: path.to_owned(), first, end, asked });
        }
        Ok(job)
    }

    fn foreign(&self, detail: String) -> RecordingError {
        RecordingError::Foreign { path: self.path.to_owned(), detail }
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.path == name && self.source.has(column))
    }

    fn rows(&self, name: &str, rows: Range<usize>) -> Result<Rows, RecordingError> {
        let missing = || RecordingError::Missing { path: self.path.to_owned(), column: name.to_owned() };
        self.source.rows(self.path, self.column(name).ok_or_else(missing)?, rows)
    }

    /// Channels and their files; the collection, where there are several. Nothing of them may be in the way.
    fn plan(&self, settings: &Settings) -> Result<(Vec<Channel>, Option<PathBuf>), RecordingError> {
        let all = &self.source.header().channels;
        let mut places = Vec::new();
        for name in &settings.channels {
            let Some(place) = all.iter().position(|row| row.name == *name) else {
                let names = all.iter().map(|row| row.name.as_str()).collect::<Vec<_>>().join(", ");
                return Err(self.foreign(format!("has no channel {name}; allowed: {names}")));
            };
            if !places.contains(&place) {
                places.push(place);
            }
        }
        if settings.channels.is_empty() {
            places = (0..all.len()).collect();
        }
        let ending = settings.out.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        let base = match ending {
            "sigmf" | "sigmf-meta" | "sigmf-data" | "sigmf-collection" => settings.out.with_extension(""),
            _ => settings.out.clone(),
        };
        let Some(stem) = base.file_name() else {
            return Err(FileFault::NoFolder { path: settings.out.clone() }.into());
        };
        let stem = stem.to_string_lossy().into_owned();
        let named = |name: String| base.with_file_name(name);
        let channels: Vec<Channel> = places
            .iter()
            .map(|&place| {
                let name = all[place].name.clone();
                let legible = name.replace(|c: char| !(c.is_alphanumeric() || "-_".contains(c)), "_");
                let stem = if places.len() == 1 { stem.clone() } else { format!("{stem}-{legible}") };
                let [data, meta] = ["data", "meta"].map(|end| named(format!("{stem}.sigmf-{end}")));
                Channel { place, name, data, meta }
            })
            .collect();
        let collection = (places.len() > 1).then(|| named(format!("{stem}.sigmf-collection")));
        let files = || channels.iter().flat_map(|channel| [&channel.data, &channel.meta]).chain(&collection);
        for (place, path) in files().enumerate() {
            if files().take(place).any(|before| before == path) {
                return Err(self.foreign(format!("two channels would be {}", path.display())));
            }
            files::preflight(path, settings.force, &recognise)?;
        }
        Ok((channels, collection))
    }

    /// Writes all files under other names.
    fn write(
        &self,
        channels: &[Channel],
        collection: Option<&Path>,
        parts: &mut Vec<Part>,
    ) -> Result<(), RecordingError> {
        for channel in channels {
            parts.push(Part::begin(&channel.data)?);
        }
        self.write_samples(channels, parts)?;
        let mut hashes = Vec::new();
        for part in parts.iter_mut() {
            hashes.push(part.end()?);
        }
        for (channel, hash) in channels.iter().zip(hashes) {
            parts.push(Part::begin(&channel.meta)?);
            let Some(part) = parts.last_mut() else { continue };
            self.write_meta(channel, &hash, collection, part)?;
        }
        let Some(collection) = collection else { return Ok(()) };
        let mut streams = Vec::new();
        for (channel, part) in channels.iter().zip(parts.iter_mut().skip(channels.len())) {
            let name = channel.meta.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            streams.push(json!({ "name": name, "hash": part.end()? }));
        }
        let mut part = Part::begin(collection)?;
        let header = self.source.header();
        let described = opened(
            "collection",
            header,
            json!({
                "core:version": VERSION,
                "core:description": "channels of one receive window, sample by sample at the same time",
                "core:extensions": [extension()],
                "core:streams": streams,
            }),
        );
        let done = part.bytes(format!("{described}}}\n").as_bytes()).and_then(|()| part.end());
        parts.push(part);
        done.map(|_| ())
    }

    /// Samples of all channels: each block of pulses is read once.
    fn write_samples(&self, channels: &[Channel], parts: &mut [Part]) -> Result<(), RecordingError> {
        let header = self.source.header();
        let (samples, all) = (header.layout.samples, header.layout.channels);
        let missing = || RecordingError::Missing { path: self.path.to_owned(), column: "iq".to_owned() };
        let column = self.column("iq").ok_or_else(missing)?;
        self.source.holds(self.path, column, &self.rows)?;
        let block = (BLOCK_BYTES / column.row_bytes().max(1)).max(1);
        let mut bytes = Vec::new();
        for first in self.rows.clone().step_by(block) {
            let rows = self.source.rows(self.path, column, first..(first + block).min(self.rows.end))?;
            for (channel, part) in channels.iter().zip(&mut *parts) {
                bytes.clear();
                let skipped = channel.place * samples;
                match &rows {
                    Rows::Cf32(values) => {
                        for row in values.chunks_exact(all * samples) {
                            let window = row.iter().skip(skipped).take(samples);
                            bytes.extend(window.flat_map(|z| [z.re, z.im]).flat_map(f32::to_le_bytes));
                        }
                    }
                    Rows::Ci16(codes) => {
                        for row in codes.chunks_exact(all * samples) {
                            let window = row.iter().skip(skipped).take(samples);
                            bytes.extend(window.flat_map(|z| [z.re, z.im]).flat_map(i16::to_le_bytes));
                        }
                    }
                    _ => return Err(self.foreign("/iq holds no samples".to_owned())),
                }
                part.bytes(&bytes)?;
            }
        }
        Ok(())
    }

    /// Metadata of a channel: what holds for all, the capture, the pulses.
    fn write_meta(
        &self,
        channel: &Channel,
        hash: &str,
        collection: Option<&Path>,
        part: &mut Part,
    ) -> Result<(), RecordingError> {
        let header = self.source.header();
        let row = &header.channels[channel.place];
        let mut global = json!({
            "core:version": VERSION,
            "core:datatype": datatype(header),
            "core:sample_rate": header.sample_rate_hz,
            "core:num_channels": 1,
            "core:sha512": hash,
            "core:recorder": header.software,
            "core:description": format!("{} of a bistatic radar, channel {}", header.received(), row.name),
            "core:extensions": [extension()],
            "nereus:channel": row,
            "nereus:window_samples": header.layout.samples,
            "nereus:bandwidth_hz": header.bandwidth_hz,
            "nereus:pulse_s": header.pulse_s,
            "nereus:prf_hz": header.prf_hz,
            // A sample in sqrt(W) is (count + 1/2) of these; null where it is one.
            "nereus:adc_step": header.adc.map(|adc| adc.step),
            "nereus:adc_bits": header.adc.map(|adc| adc.bits),
            "nereus:instrument": header.instrument,
        });
        if let Some(collection) = collection {
            let name = collection.file_stem().unwrap_or_default().to_string_lossy();
            global["core:collection"] = json!(name);
        }
        part.bytes(opened("global", header, global).as_bytes())?;
        let mut first = true;
        let (mut zero_ns, mut before_s) = (None, None);
        for start in self.rows.clone().step_by(BLOCK_PULSES) {
            let block = Block::read(self, channel, start..(start + BLOCK_PULSES).min(self.rows.end))?;
            for pulse in 0..block.index.len() {
                let since_ns =
                    block.time_ns[pulse].saturating_sub(*zero_ns.get_or_insert(block.time_ns[pulse]));
                let emission_s = (since_ns as f64 + block.time_frac_ns[pulse]) * 1e-9;
                let (number, window_s) = (block.index[pulse], block.window_start_s[pulse]);
                check_instants(number, before_s.replace(emission_s), emission_s, window_s)
                    .map_err(|detail| self.foreign(detail))?;
                if first {
                    part.bytes(b",\n\"captures\":[")?;
                    part.bytes(block.capture(self, pulse).to_string().as_bytes())?;
                    part.bytes(b"],\n\"annotations\":[\n")?;
                }
                part.bytes(if first { b"" } else { b",\n" })?;
                let place = start - self.rows.start + pulse;
                part.bytes(block.annotation(self, pulse, place).to_string().as_bytes())?;
                first = false;
            }
        }
        part.bytes(b"\n]}\n")?;
        part.flush()
    }

    /// Latitude, longitude (degrees) and height above the ellipsoid (m) of a point, as GeoJSON has it.
    fn geolocation(&self, point_m: Option<[f64; 3]>) -> Option<Value> {
        let [x, y, z] = point_m?;
        let place = self.frame.as_ref()?.to_geodetic(Point::new(x, y, z))?;
        let coordinates = [place.lon_rad.to_degrees(), place.lat_rad.to_degrees(), place.h_m];
        let finite = coordinates.iter().all(|value| value.is_finite());
        finite.then(|| json!({ "type": "Point", "coordinates": coordinates }))
    }
}

/// The extension in which our keys stand.
fn extension() -> Value {
    json!({ "name": "nereus", "version": "1.0.0", "optional": true })
}

/// An object that begins as all of ours do, open for what follows.
fn opened(object: &str, header: &Header, fields: Value) -> String {
    let mut text = format!("{}{}", opening(object), json!(header.software));
    for (key, value) in fields.as_object().into_iter().flatten() {
        text.push_str(&format!(",\n{}:{value}", json!(key)));
    }
    text.push('}');
    text
}

/// What is known of some pulses.
struct Block {
    index: Vec<u64>,
    time_ns: Vec<i64>,
    time_frac_ns: Vec<f64>,
    window_start_s: Vec<f64>,
    flags: Vec<u32>,
    tx_pol: Vec<u8>,
    /// Reported phase centres of the transmitter and the receiver, where they are known.
    centres_m: [Vec<[f64; 3]>; 2],
}

impl Block {
    fn read(job: &Job, channel: &Channel, rows: Range<usize>) -> Result<Self, RecordingError> {
        let header = job.source.header();
        let row = &header.channels[channel.place];
        let get = |name: &str| job.rows(name, rows.clone());
        let reals = |name: &str| match get(name)? {
            Rows::F64(values) => Ok(values),
            _ => Ok::<_, RecordingError>(Vec::new()),
        };
        let centres = |antenna: &String| {
            let name = format!("nav/{antenna}/reported_phase_centre_m");
            match job.column(&name) {
                Some(_) => Ok::<_, RecordingError>(reals(&name)?.as_chunks::<3>().0.to_vec()),
                None => Ok(Vec::new()),
            }
        };
        let block = Self {
            index: match get("pulse/index")? {
                Rows::U64(values) => values,
                _ => Vec::new(),
            },
            time_ns: match get("pulse/time_ns")? {
                Rows::I64(values) => values,
                _ => Vec::new(),
            },
            time_frac_ns: reals("pulse/time_frac_ns")?,
            window_start_s: match (header.receiver_of(channel.place), job.column(RECEIVER_WINDOWS)) {
                (Some(receiver), Some(column)) => {
                    let all = reals(RECEIVER_WINDOWS)?;
                    all.iter().skip(receiver).step_by(column.width()).copied().collect()
                }
                _ => reals("pulse/window_start_s")?,
            },
            flags: match get("pulse/flags")? {
                Rows::U32(values) => values,
                _ => Vec::new(),
            },
            tx_pol: match get("pulse/tx_pol")? {
                Rows::U8(values) => values,
                _ => Vec::new(),
            },
            centres_m: [centres(&row.transmitter)?, centres(&row.receiver)?],
        };
        let pulses = block.index.len();
        let lengths = [block.time_ns.len(), block.time_frac_ns.len(), block.window_start_s.len()];
        if lengths.into_iter().chain([block.flags.len(), block.tx_pol.len()]).any(|length| length != pulses) {
            return Err(job.foreign("columns of /pulse have different numbers of rows".to_owned()));
        }
        Ok(block)
    }

    /// UTC of an instant after the emission of a pulse.
    fn utc(&self, pulse: usize, after_s: f64) -> String {
        let parts_ns = (self.time_frac_ns[pulse] + after_s * 1e9).floor();
        utc(self.time_ns[pulse].saturating_add(parts_ns as i64))
    }

    fn capture(&self, job: &Job, pulse: usize) -> Value {
        let mut capture = json!({
            "core:sample_start": 0,
            "core:frequency": job.source.header().carrier_hz,
            "core:datetime": self.utc(pulse, self.window_start_s[pulse]),
        });
        if let Some(place) = job.geolocation(self.centres_m[1].get(pulse).copied()) {
            capture["core:geolocation"] = place;
        }
        capture
    }

    fn annotation(&self, job: &Job, pulse: usize, place: usize) -> Value {
        let header = job.source.header();
        let (samples, index) = (header.layout.samples, self.index[pulse]);
        let (band, window_s) = (header.band_of(index), self.window_start_s[pulse]);
        let emission = self.utc(pulse, 0.0);
        let marks = marks(self.flags[pulse]);
        let mut annotation = json!({
            "core:sample_start": place * samples,
            "core:sample_count": samples,
            "core:freq_lower_edge": header.carrier_hz + band.from_hz,
            "core:freq_upper_edge": header.carrier_hz + band.to_hz,
            "core:label": format!("pulse {index}"),
            "core:comment": format!("emitted {emission}, window opens {} us later{marks}", window_s * 1e6),
            "nereus:pulse": index,
            "nereus:emission": emission,
            "nereus:emission_ns": self.time_ns[pulse],
            "nereus:emission_frac_ns": self.time_frac_ns[pulse],
            "nereus:window_start_s": window_s,
            "nereus:flags": self.flags[pulse],
            "nereus:tx_pol": self.tx_pol[pulse],
        });
        for (end, centres) in ["transmitter", "receiver"].into_iter().zip(&self.centres_m) {
            let Some(centre_m) = centres.get(pulse) else { continue };
            annotation[format!("nereus:{end}_enu_m")] = json!(centre_m);
            if let Some(place) = job.geolocation(Some(*centre_m)) {
                annotation[format!("nereus:{end}_geolocation")] = place;
            }
        }
        annotation
    }
}

/// Flags of a pulse in words.
fn marks(of: u32) -> String {
    [
        (flags::LATE, "late"),
        (flags::AFTER_GAP, "after a gap"),
        (flags::ADC_SATURATED, "ADC saturated"),
        (flags::OUTSIDE_WINDOW, "echo outside the window"),
        (flags::NAV_EXTRAPOLATED, "motion extrapolated"),
        (flags::NAV_STALE, "navigation stale"),
        (flags::REPORT_DROPOUT, "report dropped out"),
        (flags::ERROR_CLASS, "coarser than asked"),
    ]
    .into_iter()
    .filter(|(flag, _)| of & flag != 0)
    .fold(String::new(), |text, (_, mark)| text + "; " + mark)
}

/// UTC of nanoseconds since 1970, by ISO 8601.
fn utc(ns: i64) -> String {
    const DAY_NS: i64 = 86_400_000_000_000;
    // Civil date of a day: years begin in March, and 400 of them have 146097 days.
    let days = ns.div_euclid(DAY_NS) + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let within = ns.rem_euclid(DAY_NS);
    let (seconds, rest) = (within / 1_000_000_000, within % 1_000_000_000);
    let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{rest:09}Z")
}

impl Part {
    fn begin(path: &Path) -> Result<Self, RecordingError> {
        let (draft, file) = Draft::file(path)?;
        Ok(Self { draft, file: BufWriter::with_capacity(1 << 16, file), hash: Sha512::new() })
    }

    fn bytes(&mut self, bytes: &[u8]) -> Result<(), RecordingError> {
        self.hash.update(bytes);
        Ok(self.file.write_all(bytes).map_err(FileFault::io(self.draft.target(), WRITING))?)
    }

    fn flush(&mut self) -> Result<(), RecordingError> {
        let done = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        Ok(done.map_err(FileFault::io(self.draft.target(), WRITING))?)
    }

    /// All of it is on the disk; the hash of all bytes.
    fn end(&mut self) -> Result<String, RecordingError> {
        self.flush()?;
        Ok(self.hash.finalize_reset().iter().map(|byte| format!("{byte:02x}")).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::TimeTag;

    #[test]
    fn instants_are_those_of_the_calendar() {
        assert_eq!(utc(0), "1970-01-01T00:00:00.000000000Z");
        assert_eq!(utc(-1), "1969-12-31T23:59:59.999999999Z");
        for text in [
            "2000-02-29T23:59:59.25Z",
            "2018-05-30T20:15:00Z",
            "2100-03-01T00:00:00Z",
            "1700-12-31T01:02:03Z",
        ] {
            let (ns, _) = TimeTag::from_iso8601(text).unwrap().to_unix_ns();
            let found = TimeTag::from_iso8601(&utc(ns)).unwrap();
            assert_eq!(found, TimeTag::from_iso8601(text).unwrap(), "{text}: {}", utc(ns));
        }
    }
}
