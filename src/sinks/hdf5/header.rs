//! The header of a recording in HDF5: root attributes, replica, channel and truth tables.

// `repr(C)` below: the library reads these rows by the offsets of their fields.

use super::attributes::{attribute, checked, list, optional, string, strings, text, texts, value};

use ::hdf5::types::VarLenUnicode;
use ::hdf5::{Dataset, File, H5Type};
use num_complex::{Complex, Complex32};

use crate::pulse::{Layout, SampleFormat};
use crate::sinks::columns::Column;
use crate::sinks::descriptions::{self, Description};
use crate::sinks::shard::NotAShard;
use crate::sinks::sink::{AdcRow, ChannelRow, FORMAT_VERSION, Header, Origin, PairRow};
use crate::time::TimeTag;

use super::{changes, sizes};
use crate::sinks::hdf5::fault::Fault;

#[derive(Clone, H5Type)]
#[repr(C)]
struct ChannelRecord {
    name: VarLenUnicode,
    transmitter: VarLenUnicode,
    receiver: VarLenUnicode,
    polarisations: VarLenUnicode,
}

#[derive(Clone, H5Type)]
#[repr(C)]
struct PairRecord {
    transmitter: VarLenUnicode,
    receiver: VarLenUnicode,
}

/// Writes everything of the header that is not per pulse; `/iq` gets the converter's step. `after` is the
/// last pulse of the segment before this file.
pub(super) fn write(file: &File, iq: &Dataset, header: &Header, after: Option<u64>) -> Result<(), Fault> {
    if let Some(after) = after {
        attribute(file, "after_pulse", &after)?;
    }
    attribute(file, "format", &text("nereus")?)?;
    attribute(file, "version", &FORMAT_VERSION)?;
    attribute(file, "software", &text(&header.software)?)?;
    attribute(file, "carrier_hz", &header.carrier_hz)?;
    attribute(file, "sample_rate_hz", &header.sample_rate_hz)?;
    attribute(file, "bandwidth_hz", &header.bandwidth_hz)?;
    attribute(file, "pulse_s", &header.pulse_s)?;
    attribute(file, "prf_hz", &header.prf_hz)?;
    list(file, "channels", &texts(header.channels.iter().map(|c| &c.name))?)?;
    list(file, "transmit_basis", &texts(header.channels.iter().map(|c| &c.transmit_basis))?)?;
    list(file, "receive_basis", &texts(header.channels.iter().map(|c| &c.receive_basis))?)?;
    if let Some(origin) = header.origin {
        attribute(file, "origin_lat_deg", &origin.lat_deg)?;
        attribute(file, "origin_lon_deg", &origin.lon_deg)?;
        attribute(file, "origin_h_m", &origin.h_m)?;
    }
    attribute(file, "seed", &header.seed)?;
    attribute(file, "config", &text(&header.config)?)?;
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    attribute(file, "start_time_ns", &start_ns)?;
    attribute(file, "start_time_frac_ns", &start_frac_ns)?;
    attribute(file, "start_time_s", &header.start.seconds())?;
    attribute(file, "start_time_fraction_s", &header.start.fraction_s())?;
    attribute(file, "first_pulse", &header.first_pulse)?;
    attribute(file, "pulses", &header.pulses)?;
    if let Some(shard) = header.shard {
        attribute(file, "shard", &text(&shard.to_string())?)?;
    }
    if !header.truth {
        // Absent in recordings that have it.
        attribute(file, "truth", &0u8)?;
    }
    for (name, values) in [
        ("platforms", &header.platforms),
        ("transmitters", &header.transmitters),
        ("receivers", &header.receivers),
    ] {
        if !values.is_empty() {
            list(file, name, &texts(values)?)?;
        }
    }
    if let Some(adc) = header.adc {
        attribute(iq, "adc_step", &adc.step)?;
        attribute(iq, "adc_bits", &adc.bits)?;
    }
    file.new_dataset_builder().with_data(header.replica.as_slice()).create("replica")?;
    let channels = header
        .channels
        .iter()
        .map(|c| {
            Ok(ChannelRecord {
                name: text(&c.name)?,
                transmitter: text(&c.transmitter)?,
                receiver: text(&c.receiver)?,
                polarisations: text(&c.polarisations)?,
            })
        })
        .collect::<Result<Vec<_>, Fault>>()?;
    file.new_dataset_builder().with_data(channels.as_slice()).create("channel")?;
    let truth = match file.group("truth") {
        Ok(group) => group,
        Err(_) => file.create_group("truth")?,
    };
    if !header.targets.is_empty() {
        truth.new_dataset_builder().with_data(texts(&header.targets)?.as_slice()).create("targets")?;
    }
    if !header.ships.is_empty() {
        truth.new_dataset_builder().with_data(texts(&header.ships)?.as_slice()).create("ships")?;
    }
    if !header.clocks.is_empty() {
        truth.new_dataset_builder().with_data(texts(&header.clocks)?.as_slice()).create("clocks")?;
    }
    if !header.pairs.is_empty() {
        let pairs = header
            .pairs
            .iter()
            .map(|p| Ok(PairRecord { transmitter: text(&p.transmitter)?, receiver: text(&p.receiver)? }))
            .collect::<Result<Vec<_>, Fault>>()?;
        truth.new_dataset_builder().with_data(pairs.as_slice()).create("pairs")?;
    }
    Ok(())
}

/// Writes the words for every dataset: what it is, its unit, axes and frame.
pub(super) fn describe<'a>(
    file: &File,
    columns: impl Iterator<Item = (&'a Column, &'a Dataset)>,
    header: &Header,
) -> Result<(), Fault> {
    let write = |dataset: &Dataset, of: &Description| {
        [("description", of.description), ("unit", of.unit), ("axes", of.axes), ("frame", of.frame)]
            .into_iter()
            .try_for_each(|(name, words)| attribute(dataset, name, &text(words)?))
    };
    for (column, dataset) in columns {
        descriptions::of_column(column).map_or(Ok(()), |of| write(dataset, of))?;
    }
    descriptions::of_header(header).try_for_each(|of| write(&file.dataset(of.path)?, of))
}

/// Reads what [`write`] wrote; nothing is read of which the file cannot hold as much as it says.
pub(super) fn read(file: &File, file_bytes: u64) -> Result<Header, Fault> {
    let held = |dataset: Dataset| sizes::check(&dataset, None, file_bytes).map(|()| dataset);
    let format = string(file, "format")?;
    let version: u32 = value(file, "version")?;
    if format != "nereus" || version != FORMAT_VERSION {
        return Err(Fault::Text(format!(
            "format '{format}' version {version}; 'nereus' version {FORMAT_VERSION} is read"
        )));
    }
    let iq = file.dataset("iq")?;
    let &[_, channels, samples] = iq.shape().as_slice() else {
        return Err(Fault::Text(format!("/iq has {} axes; 3 are read", iq.ndim())));
    };
    let format = if iq.dtype()?.is::<Complex32>() {
        SampleFormat::Cf32
    } else if iq.dtype()?.is::<Complex<i16>>() {
        SampleFormat::Ci16
    } else {
        return Err(Fault::Text("/iq is neither complex64 nor a pair {r, i} of int16".to_owned()));
    };
    let table = held(file.dataset("channel")?)?.read_raw::<ChannelRecord>()?;
    let truth = file.group("truth")?;
    let pairs: Vec<PairRow> = if truth.link_exists("pairs") {
        let rows = held(truth.dataset("pairs")?)?.read_raw::<PairRecord>()?;
        rows.iter()
            .map(|r| {
                Ok(PairRow {
                    transmitter: checked(r.transmitter.as_bytes(), "/truth/pairs")?,
                    receiver: checked(r.receiver.as_bytes(), "/truth/pairs")?,
                })
            })
            .collect::<Result<_, Fault>>()?
    } else {
        Vec::new()
    };
    let names = |of: &str| -> Result<Vec<String>, Fault> {
        if !truth.link_exists(of) {
            return Ok(Vec::new());
        }
        let names = held(truth.dataset(of)?)?.read_raw::<VarLenUnicode>()?;
        names.iter().map(|name| checked(name.as_bytes(), of)).collect()
    };
    let (targets, ships, clocks) = (names("targets")?, names("ships")?, names("clocks")?);
    let origin = match optional(file, "origin_lat_deg")? {
        None => None,
        Some(lat_deg) => {
            Some(Origin { lat_deg, lon_deg: value(file, "origin_lon_deg")?, h_m: value(file, "origin_h_m")? })
        }
    };
    let adc = match optional(&iq, "adc_step")? {
        None => None,
        Some(step) => Some(AdcRow { step, bits: value(&iq, "adc_bits")? }),
    };
    // Absent in older recordings.
    let (transmit_basis, receive_basis) = (strings(file, "transmit_basis")?, strings(file, "receive_basis")?);
    let (platforms, transmitters, receivers) =
        (strings(file, "platforms")?, strings(file, "transmitters")?, strings(file, "receivers")?);
    // A run in one piece has none.
    let shard =
        match strings(file, "shard")?.first() {
            None => None,
            Some(words) => Some(words.parse().map_err(|error: NotAShard| {
                Fault::Text(format!("shard '{}': {error}", words.escape_debug()))
            })?),
        };
    Ok(Header {
        software: string(file, "software")?,
        carrier_hz: value(file, "carrier_hz")?,
        sample_rate_hz: value(file, "sample_rate_hz")?,
        bandwidth_hz: value(file, "bandwidth_hz")?,
        pulse_s: value(file, "pulse_s")?,
        prf_hz: value(file, "prf_hz")?,
        layout: Layout {
            channels,
            samples,
            format,
            platforms: platforms.len(),
            antennas: transmitters.len() + receivers.len(),
            targets: targets.len(),
            pairs: pairs.len(),
            ships: ships.len(),
            clocks: clocks.len(),
        },
        channels: table
            .iter()
            .enumerate()
            .map(|(channel, r)| {
                Ok(ChannelRow {
                    name: checked(r.name.as_bytes(), "/channel")?,
                    transmitter: checked(r.transmitter.as_bytes(), "/channel")?,
                    receiver: checked(r.receiver.as_bytes(), "/channel")?,
                    polarisations: checked(r.polarisations.as_bytes(), "/channel")?,
                    transmit_basis: transmit_basis.get(channel).cloned().unwrap_or_default(),
                    receive_basis: receive_basis.get(channel).cloned().unwrap_or_default(),
                })
            })
            .collect::<Result<_, Fault>>()?,
        pairs,
        origin,
        seed: value(file, "seed")?,
        config: string(file, "config")?,
        replica: held(file.dataset("replica")?)?.read_raw()?,
        platforms,
        transmitters,
        receivers,
        targets,
        ships,
        clocks,
        adc,
        start: TimeTag::new(value(file, "start_time_s")?, value(file, "start_time_fraction_s")?),
        first_pulse: value(file, "first_pulse")?,
        pulses: value(file, "pulses")?,
        shard,
        truth: optional::<u8>(file, "truth")?.is_none_or(|truth| truth != 0),
        changes: changes::read(file, file_bytes)?,
    })
}
