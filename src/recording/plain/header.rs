//! The header of a plain recording: `meta.json` and `replica.bin`, written and read.

use std::path::Path;

use bytemuck::Pod;
use num_complex::Complex32;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::META;
use crate::pulse::SampleFormat;
use crate::recording::columns::{Column, Element, columns};
use crate::recording::descriptions::of_header;
use crate::recording::fault::RecordingError;
use crate::recording::header::{AdcRow, FORMAT_VERSION, Field, Header, LAST_VERSION, Origin};
use crate::recording::instrument::Instrument;
use crate::time::TimeTag;

/// `meta.json`.
pub(super) fn meta(header: &Header, list: &[Column]) -> Value {
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    let files: Map<String, Value> = list
        .iter()
        .map(|column| {
            let mut shape = column.shape.clone();
            let mut entry = json!(column.description);
            if column.element == Element::Ci16 {
                shape.push(2);
                entry["axes"] =
                    format!("{}, in-phase and quadrature", entry["axes"].as_str().unwrap_or("")).into();
            }
            entry["dtype"] = column.element.numpy().into();
            entry["shape"] = shape.into();
            (column.path.clone(), entry)
        })
        .collect();
    let others: Map<String, Value> = of_header(header).map(|of| (of.path.to_owned(), json!(of))).collect();
    let mut meta = json!({
        "format": "nereus",
        "version": header.version(),
        "channels": header.channels.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "channel": header.channels,
        "pairs": header.pairs,
        "origin_lat_deg": header.origin.map(|o| o.lat_deg),
        "origin_lon_deg": header.origin.map(|o| o.lon_deg),
        "origin_h_m": header.origin.map(|o| o.h_m),
        "adc_bits": header.adc.map(|a| a.bits),
        "adc_step": header.adc.map(|a| a.step),
        "start_time_ns": start_ns,
        "start_time_frac_ns": start_frac_ns,
        "shard": header.shard.map(|shard| shard.to_string()),
        "truth": header.truth,
        // Text, as in HDF5: whoever reads both finds the same.
        "instrument": header.instrument.as_ref().map(Instrument::to_json),
        "replica_dtype": Element::Cf32.numpy(),
        "columns": files,
        "descriptions": others,
    });
    let mut header = header.clone();
    for (name, field) in header.fields() {
        meta[name] = match field {
            Field::Text(value) => json!(value),
            Field::Real(value) => json!(value),
            Field::Whole(value) => json!(value),
            Field::Names(value) => json!(value),
        };
    }
    for (name, names) in header.truth_names() {
        meta[name] = json!(names);
    }
    meta
}

/// The header that `meta.json` and `replica.bin` describe, and the columns that are listed there.
pub(super) fn described(
    folder: &Path,
    meta: &[u8],
    replica: &[u8],
) -> Result<(Header, Vec<String>), RecordingError> {
    let foreign = |detail: String| RecordingError::Foreign { path: folder.to_owned(), detail };
    let meta: Value = serde_json::from_slice(meta).map_err(|error| foreign(format!("meta.json: {error}")))?;
    let mut header = header(&meta).ok_or_else(|| {
        foreign(format!(
            "meta.json is not that of a nereus recording, version {FORMAT_VERSION} to {LAST_VERSION}"
        ))
    })?;
    header.replica = values::<Complex32>(replica);
    header.check()?;
    let listed = meta["columns"].as_object().map(|of| of.keys().cloned().collect()).unwrap_or_default();
    for column in columns(&header) {
        let listed = &meta["columns"][&column.path];
        let older = listed.is_null() && column.may_be_missing();
        if !older && listed["dtype"] != column.element.numpy() {
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
    described(Path::new(META), meta, replica).map(|(header, _)| header)
}

/// Bytes of a file as numbers.
pub(super) fn values<T: Pod>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// The header without its replica.
fn header(meta: &Value) -> Option<Header> {
    let version = read(&meta["version"])?;
    if meta["format"] != "nereus" || !(FORMAT_VERSION..=LAST_VERSION).contains(&version) {
        return None;
    }
    let real = |key: &str| meta[key].as_f64();
    let start_ns = meta["start_time_ns"].as_i64()?;
    let fraction_s = (start_ns.rem_euclid(1_000_000_000) as f64 + real("start_time_frac_ns")?) * 1e-9;
    let mut header = Header {
        channels: read(&meta["channel"])?,
        pairs: read(&meta["pairs"])?,
        origin: real("origin_lat_deg").and_then(|lat_deg| {
            Some(Origin { lat_deg, lon_deg: real("origin_lon_deg")?, h_m: real("origin_h_m")? })
        }),
        adc: real("adc_step").and_then(|step| Some(AdcRow { step, bits: read(&meta["adc_bits"])? })),
        start: TimeTag::new(start_ns.div_euclid(1_000_000_000), fraction_s),
        shard: match &meta["shard"] {
            Value::Null => None,
            shard => Some(shard.as_str()?.parse().ok()?),
        },
        truth: meta["truth"].as_bool().unwrap_or(true),
        instrument: match &meta["instrument"] {
            Value::Null => None,
            instrument => Some(Instrument::from_json(instrument.as_str()?).ok()?),
        },
        ..Header::default()
    };
    for (name, field) in header.fields() {
        match field {
            Field::Text(value) => *value = read(&meta[name])?,
            Field::Real(value) => *value = read(&meta[name])?,
            Field::Whole(value) => *value = read(&meta[name])?,
            Field::Names(value) => *value = read(&meta[name])?,
        }
    }
    for (name, names) in header.truth_names() {
        *names = read(&meta[name])?;
    }
    let iq = &meta["columns"]["iq"];
    let format = [SampleFormat::Cf32, SampleFormat::Ci16]
        .into_iter()
        .find(|format| iq["dtype"] == Element::from(*format).numpy())?;
    header.count(version, read(&iq["shape"][1])?, format);
    Some(header)
}

/// A value, if it is of the type that is wanted.
fn read<'a, T: Deserialize<'a>>(value: &'a Value) -> Option<T> {
    T::deserialize(value).ok()
}
