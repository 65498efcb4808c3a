//! Recordings: what is in them, while they grow, after a kill, on a full disk, merged. The wire: what is
//! sent, and received.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
mod asterix;
mod emitters;
#[cfg(all(unix, feature = "serial"))]
mod gpsd;
#[path = "../support/listing.rs"]
mod listing;
mod in_turn;
mod navigation;
mod recording_fixture;
mod recording_outputs;
mod recording_plain;
mod recording_replaced;
mod recording_rule;
mod recording_sigmf;
mod recording_verify;
mod scanning;
#[cfg(all(feature = "shm", target_os = "linux"))]
mod shm;
mod windows;
mod wire;
mod wire_difi;
mod wire_fixture;
mod wire_forged;
mod wire_hostile;
mod wire_radar;
mod wire_receive;
mod wire_recordings;
mod wire_tshark;
mod zmq;

#[cfg(feature = "hdf5")]
mod recording_breakdowns;
mod recording_changes;
mod recording_descriptions;
#[cfg(feature = "hdf5")]
mod recording_hdf5;
#[cfg(feature = "hdf5")]
mod recording_hostile;
#[cfg(feature = "hdf5")]
mod recording_merge;
