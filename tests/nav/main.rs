//! Navigation: files to fixes, fixes to tracks.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod captures;
mod converter;
mod csv_tracks;
mod decoding;
mod flights;
mod formats;
mod nmea_logs;
mod sentences;
mod sources;
mod tracks;
