//! The header of a plain recording: `meta.json` and `replica.bin`, written and read.

use std::path::Path;

use bytemuck::Pod;
use num_complex::Complex32;
use serde_json::{Map, Value, json};

use super::META;
use crate::pulse::{Layout, SampleFormat};
use crate::recording::columns::{Column, Element, columns};
use crate::recording::descriptions;
use crate::recording::fault::RecordingError;
use crate::recording::header::{AdcRow, ChannelRow, FORMAT_VERSION, Header, Origin, PairRow};
use crate::time::TimeTag;

/// `meta.json`.
pub(super) fn meta(header: &Header, list: &[Column]) -> Value {
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    let files: Map<String, Value> = list
        .iter()
        .map(|column| {
            let mut shape = column.shape.clone();
            let mut entry = json!(descriptions::of_column(column));
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
    let others: Map<String, Value> =
        descriptions::of_header(header).map(|of| (of.path.to_owned(), json!(of))).collect();
    json!({
        "format": "nereus",
        "version": FORMAT_VERSION,
        "software": header.software,
        "carrier_hz": header.carrier_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "bandwidth_hz": header.bandwidth_hz,
        "pulse_s": header.pulse_s,
        "prf_hz": header.prf_hz,
        "channels": header.channels.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "channel": header.channels,
        "pairs": header.pairs,
        "origin_lat_deg": header.origin.map(|o| o.lat_deg),
        "origin_lon_deg": header.origin.map(|o| o.lon_deg),
        "origin_h_m": header.origin.map(|o| o.h_m),
        "seed": header.seed,
        "config": header.config,
        "platforms": header.platforms,
        "transmitters": header.transmitters,
        "receivers": header.receivers,
        "targets": header.targets,
        "ships": header.ships,
        "clocks": header.clocks,
        "adc_bits": header.adc.map(|a| a.bits),
        "adc_step": header.adc.map(|a| a.step),
        "start_time_ns": start_ns,
        "start_time_frac_ns": start_frac_ns,
        "first_pulse": header.first_pulse,
        "truth": header.truth,
        "pulses": header.pulses,
        "replica_dtype": Element::Cf32.numpy(),
        "columns": files,
        "descriptions": others,
    })
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
    described(Path::new(META), meta, replica).map(|(header, _)| header)
}

/// Bytes of a file as numbers.
pub(super) fn values<T: Pod>(bytes: &[u8]) -> Vec<T> {
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
        truth: meta["truth"].as_bool().unwrap_or(true),
        changes: None,
    })
}
