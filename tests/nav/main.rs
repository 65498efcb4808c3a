//! Navigation: files to fixes, fixes to tracks.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod converter;
mod csv_tracks;
mod flights;
mod nmea_logs;
mod report_errors;
mod sources;
mod tracks;
mod turbulence;
