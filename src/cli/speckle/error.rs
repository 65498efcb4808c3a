//! Why there are no statistics of an image of the sea.

use std::path::PathBuf;

use crate::cli::escape;
use crate::geometry::phase_path::PhasePathError;
use crate::processor::range_compress::CompressError;

/// Why there are no statistics.
#[derive(Debug, thiserror::Error)]
pub enum SpeckleError {
    /// A value out of range.
    #[error("--{key} {found}: allowed: {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// What was given.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No cell across the look.
    #[error(
        "{}: channel {channel} has no cross-range from the pulses that left in its polarisation; allowed: at least two, from different places that see the patch at different angles",
        escape::path(path)
    )]
    NoAperture {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
    },
    /// Pixels that hold sea in a part of the pulses only.
    #[error("{}: scene.patch = \"follow\": its edges are sea in a part of the pulses only, which is no texture of the sea; allowed: \"fixed\"", path.display())]
    Follows {
        /// The scenario.
        path: PathBuf,
    },
    /// An image too small for statistics.
    #[error(
        "{}: channel {channel} has {} x {} resolution cells of {:.3} m x {:.3} m (across the look and along it) on the patch; \
         allowed: at least {least} cells along both: a larger scene.patch_size_m, a longer aperture, more bandwidth, or more --pixels",
        escape::path(path), pixels[0], pixels[1], cell_m[0], cell_m[1]
    )]
    FewPixels {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// Cells across the look and along it.
        pixels: [usize; 2],
        /// Their size, m.
        cell_m: [f64; 2],
        /// The least that is allowed.
        least: usize,
    },
    /// A channel that hears nothing.
    #[error("{}: channel {channel}: {source}; allowed: a window that covers the patch, antennas that light it", path.display())]
    Silent {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: crate::clutter::SampleFault,
    },
    /// No pulse to compress with.
    #[error("{}: {source}", path.display())]
    Compress {
        /// The scenario.
        path: PathBuf,
        /// What is wrong.
        source: CompressError,
    },
    /// Positions or times that are none.
    #[error("{}: {source}", path.display())]
    Path {
        /// The scenario.
        path: PathBuf,
        /// What is wrong.
        source: PhasePathError,
    },
    /// Pulses that do not fit in memory.
    #[error(
        "{}: {pulses} pulses are {needed_mib} MiB of samples, {available_mib} MiB are free; allowed: a shorter scene.duration_s or fewer channels",
        escape::path(path)
    )]
    Memory {
        /// The scenario.
        path: PathBuf,
        /// Pulses of the run.
        pulses: u64,
        /// What they take.
        needed_mib: u64,
        /// What may be taken.
        available_mib: u64,
    },
}
