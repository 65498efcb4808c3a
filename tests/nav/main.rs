//! Navigation: files to fixes, fixes to tracks.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod probe;
