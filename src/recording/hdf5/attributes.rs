//! Attributes of HDF5 files, written and read: text is checked before it is believed.

use std::str::FromStr;

use ::hdf5::types::VarLenUnicode;
use ::hdf5::{H5Type, Location};

use super::fault::Fault;

/// A text as the library takes it.
pub(crate) fn text(value: &str) -> Result<VarLenUnicode, Fault> {
    VarLenUnicode::from_str(value).map_err(|e| Fault::Text(e.to_string()))
}

pub(crate) fn texts<'a>(values: impl IntoIterator<Item = &'a String>) -> Result<Vec<VarLenUnicode>, Fault> {
    values.into_iter().map(|v| text(v)).collect()
}

/// Writes an attribute.
pub(crate) fn attribute<T: H5Type>(place: &Location, name: &str, value: &T) -> Result<(), Fault> {
    Ok(place.new_attr::<T>().create(name)?.write_scalar(value)?)
}

/// Writes an attribute of several texts.
pub(crate) fn list(place: &Location, name: &str, values: &[VarLenUnicode]) -> Result<(), Fault> {
    Ok(place.new_attr_builder().with_data(values).create(name).map(|_| ())?)
}

pub(super) fn value<T: H5Type>(place: &Location, name: &str) -> Result<T, Fault> {
    Ok(place.attr(name)?.read_scalar()?)
}

/// The text in some bytes of a file. The library's own strings take whatever stands there for UTF-8,
/// unchecked.
pub(super) fn checked(bytes: &[u8], name: &str) -> Result<String, Fault> {
    let text = std::str::from_utf8(bytes);
    Ok(text.map_err(|error| Fault::Text(format!("{name} is not UTF-8 text: {error}")))?.to_owned())
}

pub(super) fn string(place: &Location, name: &str) -> Result<String, Fault> {
    checked(value::<VarLenUnicode>(place, name)?.as_bytes(), name)
}

pub(super) fn optional<T: H5Type>(place: &Location, name: &str) -> Result<Option<T>, Fault> {
    if place.attr_names()?.iter().any(|n| n == name) { value(place, name).map(Some) } else { Ok(None) }
}

pub(super) fn strings(place: &Location, name: &str) -> Result<Vec<String>, Fault> {
    if !place.attr_names()?.iter().any(|n| n == name) {
        return Ok(Vec::new());
    }
    let values = place.attr(name)?;
    if values.size() > MOST_NAMES {
        return Err(Fault::Text(format!(
            "{name} has {} names; at most {MOST_NAMES} are read",
            values.size()
        )));
    }
    values.read_raw::<VarLenUnicode>()?.iter().map(|value| checked(value.as_bytes(), name)).collect()
}

/// Most names in a list.
const MOST_NAMES: usize = 1 << 16;
