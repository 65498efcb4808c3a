//! Plain folders, as [`crate::sinks::plain`] makes them.

use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use bytemuck::Pod;
use num_complex::{Complex, Complex32};
use serde_json::Value;

use super::RecordingError;
use crate::inputs;
use crate::pulse::{Layout, SampleFormat};
use crate::sinks::columns::{Column, Element, Rows, columns};
use crate::sinks::sink::{AdcRow, ChannelRow, FORMAT_VERSION, Header, Origin, PairRow, SinkError};
use crate::time::TimeTag;

/// Longest `meta.json` and `replica.bin`.
const MOST_BYTES: u64 = 256 << 20;

/// A file of a recording and its length.
fn regular(path: &Path) -> Result<(File, u64), SinkError> {
    let fault = || SinkError::io(path, "reading the recording");
    let file = inputs::open(path).map_err(fault())?;
    let data = file.metadata().map_err(fault())?;
    if !data.is_file() {
        return Err(fault()(ErrorKind::IsADirectory.into()));
    }
    Ok((file, data.len()))
}

/// A folder that is read.
pub(super) struct Plain {
    folder: PathBuf,
    pub header: Header,
    pub pulses: usize,
    /// Columns that `meta.json` lists.
    listed: Vec<String>,
}

impl Plain {
    pub fn open(folder: &Path) -> Result<Self, RecordingError> {
        let read = |name: &str| {
            let path = folder.join(name);
            let (file, length) = regular(&path)?;
            if length > MOST_BYTES {
                let detail = format!("{name} has {length} bytes; allowed: at most {MOST_BYTES}");
                return Err(RecordingError::Foreign { path: folder.to_owned(), detail });
            }
            let mut bytes = Vec::new();
            let read = file.take(length).read_to_end(&mut bytes);
            read.map_err(SinkError::io(&path, "reading the recording"))?;
            Ok(bytes)
        };
        let (header, listed) = described(folder, &read("meta.json")?, &read("replica.bin")?)?;
        let index = folder.join("pulse/index.bin");
        let (_, length) = regular(&index)?;
        Ok(Self { folder: folder.to_owned(), header, pulses: (length / 8) as usize, listed })
    }

    pub fn has(&self, column: &Column) -> bool {
        self.listed.contains(&column.path)
    }

    /// Whole rows of a column, and bytes beyond them.
    pub fn length(&self, column: &Column) -> Result<(u64, u64), RecordingError> {
        let path = self.folder.join(format!("{}.bin", column.path));
        let held = fs::metadata(&path).map_err(SinkError::io(&path, "reading the recording"))?.len();
        let row = column.row_bytes().max(1) as u64;
        Ok((held / row, held % row))
    }

    pub fn rows(&self, path: &Path, column: &Column, rows: Range<usize>) -> Result<Rows, RecordingError> {
        let bytes = self.bytes(column, &rows)?;
        let wanted = column.row_bytes().saturating_mul(rows.len());
        if bytes.len() < wanted {
            let detail = format!("{}.bin ends before pulse {}", column.path, rows.end);
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        Ok(match column.element {
            Element::U8 => Rows::U8(bytes),
            Element::U32 => Rows::U32(values(&bytes)),
            Element::U64 => Rows::U64(values(&bytes)),
            Element::I64 => Rows::I64(values(&bytes)),
            Element::F64 => Rows::F64(values(&bytes)),
            Element::Cf32 => Rows::Cf32(values(&bytes)),
            Element::Ci16 => Rows::Ci16(values::<Complex<i16>>(&bytes)),
        })
    }

    /// Whether a column is long enough for these rows.
    pub fn holds(&self, path: &Path, column: &Column, rows: &Range<usize>) -> Result<(), RecordingError> {
        let (_, length) = regular(&self.folder.join(format!("{}.bin", column.path)))?;
        let needed = (column.row_bytes() as u64).checked_mul(rows.end as u64);
        if needed.is_none_or(|needed| needed > length) {
            let detail = format!("{}.bin ends before pulse {}", column.path, rows.end);
            return Err(RecordingError::Foreign { path: path.to_owned(), detail });
        }
        Ok(())
    }

    fn bytes(&self, column: &Column, rows: &Range<usize>) -> Result<Vec<u8>, SinkError> {
        let path = self.folder.join(format!("{}.bin", column.path));
        let fault = |action| SinkError::io(&path, action);
        let (mut file, _) = regular(&path)?;
        // What cannot be counted lies behind the end of every file.
        let bytes_of =
            |rows: usize| (column.row_bytes() as u64).saturating_mul(rows as u64).min(i64::MAX as u64);
        file.seek(SeekFrom::Start(bytes_of(rows.start))).map_err(fault("reading the recording"))?;
        let mut bytes = Vec::new();
        let wanted = bytes_of(rows.len());
        file.take(wanted).read_to_end(&mut bytes).map_err(fault("reading the recording"))?;
        Ok(bytes)
    }
}

/// The header that `meta.json` and `replica.bin` describe, and the columns that are listed there.
fn described(folder: &Path, meta: &[u8], replica: &[u8]) -> Result<(Header, Vec<String>), RecordingError> {
    let foreign = |detail: String| RecordingError::Foreign { path: folder.to_owned(), detail };
    let meta: Value = serde_json::from_slice(meta).map_err(|error| foreign(format!("meta.json: {error}")))?;
    let mut header = header(&meta).ok_or_else(|| {
        foreign(format!("meta.json is not that of a nereus recording, version {FORMAT_VERSION}"))
    })?;
    header.replica = values::<Complex32>(replica);
    header.check()?;
    let listed = meta["columns"].as_object().map(|of| of.keys().cloned().collect()).unwrap_or_default();
    for column in columns(&header) {
        let told = &meta["columns"][&column.path];
        let older = told.is_null() && column.may_be_missing();
        if !older && told["dtype"] != column.element.numpy() {
            let detail = format!("{} is not {} in meta.json", column.path, column.element.numpy());
            return Err(foreign(detail));
        }
    }
    Ok((header, listed))
}

/// The header of a plain recording, from the bytes of its `meta.json` and `replica.bin`.
///
/// # Errors
/// Bytes that describe no recording.
pub fn plain_header(meta: &[u8], replica: &[u8]) -> Result<Header, RecordingError> {
    described(Path::new("meta.json"), meta, replica).map(|(header, _)| header)
}

/// Bytes of a file as numbers.
fn values<T: Pod>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// The header without its replica.
fn header(meta: &Value) -> Option<Header> {
    if meta["format"] != "nereus" || meta["version"] != FORMAT_VERSION {
        return None;
    }
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let texts = |key: &str| meta[key].as_array()?.iter().map(text).collect::<Option<Vec<_>>>();
    let real = |key: &str| meta[key].as_f64();
    let channels: Vec<ChannelRow> = meta["channel"]
        .as_array()?
        .iter()
        .map(|row| {
            Some(ChannelRow {
                name: text(&row["name"])?,
                transmitter: text(&row["transmitter"])?,
                receiver: text(&row["receiver"])?,
                polarisations: text(&row["polarisations"])?,
                // Absent in older recordings.
                transmit_basis: text(&row["transmit_basis"]).unwrap_or_default(),
                receive_basis: text(&row["receive_basis"]).unwrap_or_default(),
            })
        })
        .collect::<Option<_>>()?;
    let pairs: Vec<PairRow> = meta["pairs"]
        .as_array()?
        .iter()
        .map(|row| {
            Some(PairRow { transmitter: text(&row["transmitter"])?, receiver: text(&row["receiver"])? })
        })
        .collect::<Option<_>>()?;
    let iq = &meta["columns"]["iq"];
    let format = match iq["dtype"].as_str()? {
        name if name == Element::Cf32.numpy() => SampleFormat::Cf32,
        name if name == Element::Ci16.numpy() => SampleFormat::Ci16,
        _ => return None,
    };
    let (platforms, transmitters, receivers) =
        (texts("platforms")?, texts("transmitters")?, texts("receivers")?);
    let (targets, ships, clocks) = (texts("targets")?, texts("ships")?, texts("clocks")?);
    let origin = real("origin_lat_deg").and_then(|lat_deg| {
        Some(Origin { lat_deg, lon_deg: real("origin_lon_deg")?, h_m: real("origin_h_m")? })
    });
    let adc = real("adc_step")
        .and_then(|step| Some(AdcRow { step, bits: u32::try_from(meta["adc_bits"].as_u64()?).ok()? }));
    let start_ns = meta["start_time_ns"].as_i64()?;
    let fraction_s = (start_ns.rem_euclid(1_000_000_000) as f64 + real("start_time_frac_ns")?) * 1e-9;
    Some(Header {
        software: text(&meta["software"])?,
        carrier_hz: real("carrier_hz")?,
        sample_rate_hz: real("sample_rate_hz")?,
        bandwidth_hz: real("bandwidth_hz")?,
        pulse_s: real("pulse_s")?,
        prf_hz: real("prf_hz")?,
        layout: Layout {
            channels: channels.len(),
            samples: usize::try_from(iq["shape"][1].as_u64()?).ok()?,
            format,
            platforms: platforms.len(),
            antennas: transmitters.len() + receivers.len(),
            targets: targets.len(),
            pairs: pairs.len(),
            ships: ships.len(),
            clocks: clocks.len(),
        },
        channels,
        pairs,
        origin,
        seed: meta["seed"].as_u64()?,
        config: text(&meta["config"])?,
        replica: Vec::new(),
        platforms,
        transmitters,
        receivers,
        targets,
        ships,
        clocks,
        adc,
        start: TimeTag::new(start_ns.div_euclid(1_000_000_000), fraction_s),
        first_pulse: meta["first_pulse"].as_u64()?,
        pulses: meta["pulses"].as_u64()?,
        shard: meta["shard"].as_str().and_then(|shard| shard.parse().ok()),
        truth: meta["truth"].as_bool().unwrap_or(true),
        changes: None,
    })
}
