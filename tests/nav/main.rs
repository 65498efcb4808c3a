//! Navigation: files to fixes, fixes to tracks.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
mod captures;
mod converter;
mod csv_tracks;
mod decoding;
mod flights;
mod foreign;
mod formats;
mod growing;
mod hostile;
mod live;
mod nmea_logs;
mod sentences;
mod report_errors;
mod sources;
mod tracks;
mod turbulence;
