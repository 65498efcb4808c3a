//! The header of a recording in HDF5: root attributes, replica, channel and truth tables.

// `repr(C)` below: the library reads these rows by the offsets of their fields.

use ::hdf5::types::VarLenUnicode;
use ::hdf5::{Dataset, File, Group, H5Type};
use num_complex::{Complex, Complex32};

use super::attributes::{attribute, checked, list, optional, string, strings, text, texts, value};
use super::fault::Fault;
use super::{changes, sizes};
use crate::pulse::SampleFormat;
use crate::recording::columns::Column;
use crate::recording::descriptions::{Description, of_header};
use crate::recording::header::{
    AdcRow, ChannelRow, FORMAT_VERSION, Field, Header, LAST_VERSION, Origin, PairRow,
};
use crate::recording::instrument::Instrument;
use crate::recording::shard::{NotAShard, Shard};
use crate::time::TimeTag;

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

/// Which part of a recording in segments a file is.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Segment {
    /// From 0; 0 without segments.
    pub number: u64,
    /// Last pulse of the segment before it.
    pub after: Option<u64>,
}

/// Writes everything of the header that is not per pulse; `/iq` gets the converter's step.
pub(super) fn write(file: &File, iq: &Dataset, header: &Header, segment: Segment) -> Result<(), Fault> {
    if let Some(after) = segment.after {
        attribute(file, "after_pulse", &after)?;
    }
    if segment.number > 0 {
        attribute(file, "segment", &segment.number)?;
    }
    attribute(file, "format", &text("nereus")?)?;
    attribute(file, "version", &header.version())?;
    let mut header = header.clone();
    for (name, field) in header.fields() {
        match field {
            Field::Text(value) => attribute(file, name, &text(value)?),
            Field::Real(value) => attribute(file, name, value),
            Field::Whole(value) => attribute(file, name, value),
            Field::Names(values) if values.is_empty() => Ok(()),
            Field::Names(values) => list(file, name, &texts(values.iter())?),
        }?;
    }
    list(file, "channels", &texts(header.channels.iter().map(|c| &c.name))?)?;
    list(file, "transmit_basis", &texts(header.channels.iter().map(|c| &c.transmit_basis))?)?;
    list(file, "receive_basis", &texts(header.channels.iter().map(|c| &c.receive_basis))?)?;
    if let Some(origin) = header.origin {
        attribute(file, "origin_lat_deg", &origin.lat_deg)?;
        attribute(file, "origin_lon_deg", &origin.lon_deg)?;
        attribute(file, "origin_h_m", &origin.h_m)?;
    }
    if let Some(instrument) = &header.instrument {
        attribute(file, "instrument", &text(&instrument.to_json())?)?;
    }
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    attribute(file, "start_time_ns", &start_ns)?;
    attribute(file, "start_time_frac_ns", &start_frac_ns)?;
    attribute(file, "start_time_s", &header.start.seconds())?;
    attribute(file, "start_time_fraction_s", &header.start.fraction_s())?;
    if let Some(shard) = header.shard {
        attribute(file, "shard", &text(&shard.to_string())?)?;
    }
    if !header.truth {
        // Absent in recordings that have it.
        attribute(file, "truth", &0u8)?;
    }
    if let Some(adc) = header.adc {
        attribute(iq, "adc_step", &adc.step)?;
        attribute(iq, "adc_bits", &adc.bits)?;
    }
    write_tables(file, &mut header)
}

/// Writes the datasets of the header.
fn write_tables(file: &File, header: &mut Header) -> Result<(), Fault> {
    fn put<T: H5Type>(group: &Group, name: &str, rows: &[T]) -> Result<(), Fault> {
        Ok(group.new_dataset_builder().with_data(rows).create(name).map(drop)?)
    }
    put(file, "replica", &header.replica)?;
    let channel = |row: &ChannelRow| {
        Ok(ChannelRecord {
            name: text(&row.name)?,
            transmitter: text(&row.transmitter)?,
            receiver: text(&row.receiver)?,
            polarisations: text(&row.polarisations)?,
        })
    };
    put(file, "channel", &header.channels.iter().map(channel).collect::<Result<Vec<_>, Fault>>()?)?;
    let truth = match file.group("truth") {
        Ok(group) => group,
        Err(_) => file.create_group("truth")?,
    };
    for (name, names) in header.truth_names() {
        if !names.is_empty() {
            put(&truth, name, &texts(names.iter())?)?;
        }
    }
    if !header.pairs.is_empty() {
        let pair = |row: &PairRow| {
            Ok(PairRecord { transmitter: text(&row.transmitter)?, receiver: text(&row.receiver)? })
        };
        put(&truth, "pairs", &header.pairs.iter().map(pair).collect::<Result<Vec<_>, Fault>>()?)?;
    }
    Ok(())
}

/// Describes every dataset: what it is, its unit, axes and frame.
pub(super) fn describe<'a>(
    file: &File,
    columns: impl Iterator<Item = (&'a Column, &'a Dataset)>,
    header: &Header,
) -> Result<(), Fault> {
    let write = |dataset: &Dataset, of: &Description| {
        [("description", of.description), ("unit", of.unit), ("axes", of.axes), ("frame", of.frame)]
            .into_iter()
            .try_for_each(|(name, value)| attribute(dataset, name, &text(value)?))
    };
    for (column, dataset) in columns {
        write(dataset, column.description)?;
    }
    of_header(header).try_for_each(|of| write(&file.dataset(of.path)?, of))
}

/// Reads what [`write`] wrote; nothing is read of which the file cannot hold as much as it announces.
pub(super) fn read(file: &File, file_bytes: u64) -> Result<Header, Fault> {
    let format = string(file, "format")?;
    let version: u32 = value(file, "version")?;
    if format != "nereus" || !(FORMAT_VERSION..=LAST_VERSION).contains(&version) {
        return Err(Fault::Text(format!(
            "format '{format}' version {version}; 'nereus' versions {FORMAT_VERSION} to {LAST_VERSION} are read"
        )));
    }
    let iq = file.dataset("iq")?;
    let (channels, samples, format) = sizes_of(&iq)?;
    let mut header = Header {
        origin: origin(file)?,
        adc: match optional(&iq, "adc_step")? {
            None => None,
            Some(step) => Some(AdcRow { step, bits: value(&iq, "adc_bits")? }),
        },
        start: TimeTag::new(value(file, "start_time_s")?, value(file, "start_time_fraction_s")?),
        truth: optional::<u8>(file, "truth")?.is_none_or(|truth| truth != 0),
        changes: changes::read(file, file_bytes)?,
        shard: shard(file)?,
        instrument: instrument(file)?,
        ..Header::default()
    };
    for (name, field) in header.fields() {
        match field {
            Field::Text(text) => *text = string(file, name)?,
            Field::Real(real) => *real = value(file, name)?,
            Field::Whole(whole) => *whole = value(file, name)?,
            Field::Names(names) => *names = strings(file, name)?,
        }
    }
    read_tables(file, file_bytes, &mut header)?;
    header.count(version, samples, format);
    // As many as the samples have, not as the table has: they are compared.
    header.layout.channels = channels;
    Ok(header)
}

/// Channels, samples of each, and their format.
fn sizes_of(iq: &Dataset) -> Result<(usize, usize, SampleFormat), Fault> {
    let &[_, channels, samples] = iq.shape().as_slice() else {
        return Err(Fault::Text(format!("/iq has {} axes; 3 are read", iq.ndim())));
    };
    if iq.dtype()?.is::<Complex32>() {
        Ok((channels, samples, SampleFormat::Cf32))
    } else if iq.dtype()?.is::<Complex<i16>>() {
        Ok((channels, samples, SampleFormat::Ci16))
    } else {
        Err(Fault::Text("/iq is neither complex64 nor a pair {r, i} of int16".to_owned()))
    }
}

/// The shard of the run; a run in one piece has none.
fn shard(file: &File) -> Result<Option<Shard>, Fault> {
    let words = strings(file, "shard")?;
    let parsed = words.first().map(|words| words.parse().map_err(|error| (words, error)));
    parsed.transpose().map_err(|(words, error): (_, NotAShard)| {
        Fault::Text(format!("shard '{}': {error}", words.escape_debug()))
    })
}

/// Absent in recordings of earlier versions.
fn instrument(file: &File) -> Result<Option<Instrument>, Fault> {
    let words = strings(file, "instrument")?;
    let read = |words: &String| Instrument::from_json(words).map_err(|fault| Fault::Text(fault.to_string()));
    words.first().map(read).transpose()
}

fn origin(file: &File) -> Result<Option<Origin>, Fault> {
    let Some(lat_deg) = optional(file, "origin_lat_deg")? else { return Ok(None) };
    Ok(Some(Origin { lat_deg, lon_deg: value(file, "origin_lon_deg")?, h_m: value(file, "origin_h_m")? }))
}

/// Reads the datasets of the header.
fn read_tables(file: &File, file_bytes: u64, header: &mut Header) -> Result<(), Fault> {
    let rows = |dataset: Dataset| sizes::check(&dataset, None, file_bytes).map(|()| dataset);
    header.replica = rows(file.dataset("replica")?)?.read_raw()?;
    // Absent in older recordings.
    let (transmit_basis, receive_basis) = (strings(file, "transmit_basis")?, strings(file, "receive_basis")?);
    let basis = |of: &[String], channel: usize| of.get(channel).cloned().unwrap_or_default();
    for (channel, row) in rows(file.dataset("channel")?)?.read_raw::<ChannelRecord>()?.iter().enumerate() {
        header.channels.push(ChannelRow {
            name: checked(row.name.as_bytes(), "/channel")?,
            transmitter: checked(row.transmitter.as_bytes(), "/channel")?,
            receiver: checked(row.receiver.as_bytes(), "/channel")?,
            polarisations: checked(row.polarisations.as_bytes(), "/channel")?,
            transmit_basis: basis(&transmit_basis, channel),
            receive_basis: basis(&receive_basis, channel),
        });
    }
    let truth = file.group("truth")?;
    let in_truth = |name: &str| match truth.link_exists(name) {
        true => rows(truth.dataset(name)?).map(Some),
        false => Ok(None),
    };
    for (name, names) in header.truth_names() {
        for text in in_truth(name)?.map_or(Ok(Vec::new()), |names| names.read_raw::<VarLenUnicode>())? {
            names.push(checked(text.as_bytes(), name)?);
        }
    }
    for row in in_truth("pairs")?.map_or(Ok(Vec::new()), |pairs| pairs.read_raw::<PairRecord>())? {
        header.pairs.push(PairRow {
            transmitter: checked(row.transmitter.as_bytes(), "/truth/pairs")?,
            receiver: checked(row.receiver.as_bytes(), "/truth/pairs")?,
        });
    }
    Ok(())
}
