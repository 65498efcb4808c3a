//! From a recorded file to fixes: one entry for every format.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, Smoothing, VerticalDatum, load};
//!
//! let path = std::env::temp_dir().join(format!("nereus-replay-{}.csv", std::process::id()));
//! std::fs::write(&path, "unix_s,x_m,y_m,z_m\n0,0,0,100\n1.5,150,0,100\n")?;
//! let source = FileSource {
//!     path: path.clone(),
//!     format: FileFormat::Csv,
//!     datum: VerticalDatum::Ellipsoid,
//!     undulation_m: 0.0,
//!     max_gap_s: 5.0,
//!     smoothing: Smoothing::Off,
//!     attitude: AttitudeSource::Level,
//! };
//! let recording = load(&source)?;
//! assert_eq!(recording.fixes.len(), 2);
//! println!("{}", recording.report);
//! # std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::recording::Recording;
use std::path::Path;

use super::{FileFormat, FileSource, NavError};
use crate::inputs;

/// The most bytes that are read of a file.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Reads the file of a source.
///
/// All faults of the file are reported at once, each with its line, value and what is allowed. Fixes come
/// back with times strictly increasing and no gap longer than `max_gap_s`; positions on Earth have
/// heights above the WGS-84 ellipsoid, whatever the datum of the file.
///
/// # Errors
/// A file that cannot be read, and all faults of its contents.
pub fn load(source: &FileSource) -> Result<Recording, NavError> {
    parse(&read_bytes(&source.path)?, source)
}

/// The bytes of a file.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, NavError> {
    let read_error = |error| NavError::Read { path: path.to_owned(), source: error };
    let bytes = inputs::read(path, MAX_FILE_BYTES).map_err(read_error)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(NavError::TooLarge { path: path.to_owned(), allowed_bytes: MAX_FILE_BYTES });
    }
    Ok(bytes)
}

/// Reads fixes from the bytes of a file (its path is used in messages only).
///
/// # Errors
/// All faults of the file.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    match source.format {
        FileFormat::Csv => super::csv::parse(bytes, source),
        FileFormat::Nmea => super::nmea::parse(bytes, source),
        FileFormat::Inspvax => super::inspvax::parse(bytes, source),
        FileFormat::Sbet { gps_week } => super::sbet::parse(bytes, gps_week, source),
    }
}
