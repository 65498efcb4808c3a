//! The built program: exit codes, what goes to which stream, texts.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod bench;
mod continuous;
mod doctor;
#[path = "../support/cases.rs"]
mod cases;
#[cfg(unix)]
mod control;
mod examples;
#[cfg(unix)]
mod export_sigmf;
mod cases_named;
mod export;
#[cfg(unix)]
mod files;
mod fit;
mod focus;
mod foreign_files;
mod help;
#[cfg(unix)]
mod inputs;
mod import;
mod inspection;
#[cfg(all(unix, feature = "serial"))]
mod live_navigation;
#[cfg(unix)]
#[path = "../support/listing.rs"]
mod listing;
#[cfg(feature = "hdf5")]
mod oracle;
mod pages;
#[cfg(all(unix, feature = "hdf5"))]
mod pages_run;
mod plausible;
mod mocomp;
#[cfg(all(unix, feature = "monitor"))]
mod monitor;
#[cfg(all(unix, feature = "monitor"))]
mod monitor_client;
#[cfg(all(unix, feature = "monitor"))]
mod monitor_ppi;
mod nav;
mod navigation_cases;
mod polarisation_check;
mod ppi;
mod program;
mod python_tools;
mod receive;
mod received_image;
mod recorded_tracks;
#[cfg(target_os = "linux")]
mod release;
mod running;
mod sea;
mod shells;
mod sea_check;
#[cfg(unix)]
mod setup_script;
mod sigma0_page;
mod snapshot;
mod speckle;
mod ship_meshes;
mod ship_tables;
mod targets;
mod table_golden;
mod table_keys;
mod tables;
mod video;
mod wake;
mod wake_check;
