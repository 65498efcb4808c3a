//! Descriptions of sources, and where the data lies.

use std::path::PathBuf;

use nereus::nav::{AttitudeSource, FileFormat, FileSource, MotionBounds, Smoothing, VerticalDatum};

pub fn repository(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(path)
}

pub fn csv(path: &str) -> FileSource {
    FileSource {
        path: path.into(),
        format: FileFormat::Csv,
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        max_gap_s: 10.0,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Level,
        first_day: None,
        bounds: MotionBounds::SPACECRAFT,
    }
}

pub fn nmea(path: &str) -> FileSource {
    FileSource {
        format: FileFormat::Nmea,
        datum: VerticalDatum::MeanSeaLevel,
        undulation_m: 41.0,
        ..csv(path)
    }
}

pub fn adsb(path: &str, max_acceleration_mps2: f64) -> FileSource {
    FileSource {
        path: repository(path),
        datum: VerticalDatum::Barometric { offset_m: 0.0 },
        undulation_m: 42.0,
        smoothing: Smoothing::Rts { horizontal_sigma_m: 50.0, vertical_sigma_m: 4.0, max_acceleration_mps2 },
        attitude: AttitudeSource::CoordinatedTurn,
        ..csv(path)
    }
}

/// An NMEA sentence with its checksum and line end.
pub fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0u8, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}
