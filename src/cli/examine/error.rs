//! Why a recording is not read.

use std::io;

/// Why a recording is not read.
#[derive(Debug, thiserror::Error)]
pub enum ExamineError {
    /// It is wrong, as the process that read it reports.
    #[error("{message}")]
    Refused {
        /// Its report.
        message: String,
    },
    /// The process did not come to an end by itself.
    #[error(
        "{path}: not read: {how} when it was examined in a process of its own; the file is damaged or was forged; \
         allowed: recordings of nereus as they were written"
    )]
    Fatal {
        /// The recording.
        path: String,
        /// How it ended.
        how: String,
    },
    /// There is no such process.
    #[error("{path}: cannot be examined in a process of its own: {source}")]
    Process {
        /// The recording.
        path: String,
        /// The system's error.
        source: io::Error,
    },
}
