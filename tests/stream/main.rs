//! The stream with made-up pulses: order, pacing, policies, isolation, ends, allocations.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
mod released;
mod stream_allocations;
mod stream_ends;
mod stream_fixture;
mod stream_pacing;
mod stream_shared;
mod stream_view;
