//! HDF5 recordings, readable while they grow.
//!
//! Structure (format bounds 1.10, so any HDF5 from 1.10 on reads it): root attributes `format`, `version`,
//! `carrier_hz`, `sample_rate_hz`, `bandwidth_hz`, `pulse_s`, `prf_hz`, `channels`, `origin_lat_deg`,
//! `origin_lon_deg`, `origin_h_m` (absent for a plain local frame), `seed`, `config`, `software`,
//! `start_time_ns` (emission of pulse 0), `first_pulse`, `pulses`; `/iq`, `/replica`, `/channel`,
//! `/truth/targets`, `/truth/pairs`, `/truth/ships`, `/truth/clocks`, where reports may be changed
//! `/truth/changes` (`pulse`, `time_ns`, `platform`, `text`, `source`: every change up to the last pulse),
//! and the per-pulse datasets of [`super::descriptions`].
//!
//! Codes of a converter are a compound `{r, i}` of i16, so `/iq` keeps its three axes: in numpy
//! `x["r"] + 1j * x["i"]`; the attributes `adc_step` and `adc_bits` of `/iq` have the value of a code.
//!
//! **Reading while it grows** (SWMR): `h5py.File(path, "r", swmr=True)`; to look again, `refresh()`
//! `/pulse/index`, take its length n, then `refresh()` the other datasets: their first n rows are complete.
//! **After a kill** the file still has the open-for-write flag and a plain `"r"` is refused by the library:
//! open it with `swmr=True` too (or clear the mark once with `h5clear -s`). Everything older than half
//! a second is in it, and all but the last 16 MiB. A finished file opens either way.

use std::path::Path;

use super::fault::{READING, RecordingError};
use fault::Fault;

pub(crate) mod attributes;
mod changes;
pub(crate) mod fault;
pub(crate) mod file;
pub(crate) mod header;
pub(crate) mod reader;
mod sizes;
mod superblock;
pub(crate) mod writer;

/// Reads a recording to the end, everything that another reading would come across; its pulses.
///
/// # Errors
/// A file that is damaged or no recording.
pub fn read_through(path: &Path) -> Result<u64, RecordingError> {
    let recorded = reader::Reader::open(path).map_err(Fault::at(path, READING))?;
    recorded.read_through().map_err(Fault::at(path, READING))?;
    Ok(recorded.pulses as u64)
}
