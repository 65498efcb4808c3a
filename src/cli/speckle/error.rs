//! Why there are no statistics of an image of the sea.

use std::path::PathBuf;

use crate::cli::escape;
use crate::clutter::image::ImageError;

/// Why there are no statistics.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// Pixels that hold sea in a part of the pulses only.
    #[error("{}: scene.patch = \"follow\": its edges are sea in a part of the pulses only, which is no texture of the sea; allowed: \"fixed\"", path.display())]
    Follows {
        /// The scenario.
        path: PathBuf,
    },
    /// No image.
    #[error("{}: channel {channel}: {source}", escape::path(path))]
    Image {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: ImageError,
    },
    /// A channel without echoes of the patch.
    #[error("{}: channel {channel}: {source}; allowed: a window that covers the patch, antennas that illuminate it", path.display())]
    NoPower {
        /// The scenario.
        path: PathBuf,
        /// The channel.
        channel: String,
        /// What is wrong.
        source: crate::clutter::SampleFault,
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
