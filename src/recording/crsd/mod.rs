//! CRSD 1.0 (NGA.STND.0080): recordings as files that SAR processors read.
//!
//! A CRSDsar file with a channel for each channel of echoes. [`Description`] has what CRSD needs to know of a
//! run, [`Writer`] takes its pulses, [`export()`] those of a recording. What the file holds, and what the
//! standard cannot express, is in `docs/formats.md`.
//!
//! | module | |
//! | --- | --- |
//! | `description` | sequences, channels, antennas |
//! | `states` | where antennas are and look, as reported |
//! | `records` | parameters per pulse and per vector, times on the grid of samples |
//! | `pattern`, `covariance`, `reference` | support arrays, errors, reference geometry and polarisation |
//! | `writer`, `document`, `xml` | the file |
//! | `export`, `nearby` | from a recording, from a run |
//!
//! Positions are those **reported**: the truth stays in the recording.

mod covariance;
mod description;
mod document;
mod export;
mod fault;
mod nearby;
mod pattern;
mod records;
mod reference;
mod states;
mod writer;
mod xml;

pub use description::{Described, Description};
pub use export::{Exported, export};
pub use fault::{CrsdError, ExportError};
pub use nearby::Nearby;
pub use writer::{PulseSamples, Writer};
