//! From a recorded file to fixes: one entry for every format.
//!
//! ```
//! use nereus::nav::{AttitudeSource, FileFormat, FileSource, MotionBounds, Smoothing, VerticalDatum, load};
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
//!     first_day: None,
//!     bounds: MotionBounds::SPACECRAFT,
//! };
//! let recording = load(&source)?;
//! assert_eq!(recording.fixes.len(), 2);
//! println!("{}", recording.report);
//! # std::fs::remove_file(path)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::recording::Recording;
use super::{FileFormat, FileSource, NavError, unpacked};

/// Reads the file of a source, which may be gzipped, and if it is text UTF-16.
///
/// All faults of the file are reported at once, each with its line, value and what is allowed. Fixes come
/// back with times strictly increasing and no gap longer than `max_gap_s`; positions on Earth have
/// heights above the WGS-84 ellipsoid, whatever the datum of the file.
///
/// # Errors
/// A file that cannot be read, and all faults of its contents.
pub fn load(source: &FileSource) -> Result<Recording, NavError> {
    parse(&unpacked::read(&source.path)?, source)
}

/// Reads fixes from the bytes of a file (its path is used in messages only).
///
/// # Errors
/// All faults of the file.
pub fn parse(bytes: &[u8], source: &FileSource) -> Result<Recording, NavError> {
    if let FileFormat::Sbet { gps_week } = source.format {
        return super::sbet::parse(bytes, gps_week, source);
    }
    let text = unpacked::utf8(bytes);
    match source.format {
        FileFormat::Csv => super::csv::parse(&text, source),
        FileFormat::Gpx => super::xml::gpx(&text, source),
        FileFormat::Kml => super::xml::kml(&text, source),
        FileFormat::Nmea | FileFormat::Inspvax | FileFormat::Sbet { .. } => super::nmea::parse(&text, source),
    }
}
