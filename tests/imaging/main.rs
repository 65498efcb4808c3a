//! Images of recordings: points in every geometry, the fast way against the reference.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
mod agreement;
mod beams;
mod channels;
mod degradation;
mod extremes;
mod geometries;
mod navigation;
mod points;
mod statistics;
