//! Why there is no monitor.

use std::io;

/// Why there is no monitor.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MonitorFault {
    /// Not an address.
    #[error("monitor address '{}': {source}; allowed: HOST:PORT such as 127.0.0.1:8080, port 0 for any that is free", given.escape_debug())]
    Address {
        /// As given.
        given: String,
        /// The system's error.
        source: io::Error,
    },
    /// Somebody listens there.
    #[error(
        "monitor address '{given}' is in use: another program listens there; allowed: a free port, 0 for any"
    )]
    InUse {
        /// As given.
        given: String,
    },
    /// The system refuses to listen there.
    #[error(
        "monitor address '{given}': {source}; allowed: an address of this machine and a port that you may open (1024 or above, 0 for any)"
    )]
    Listen {
        /// As given.
        given: String,
        /// The system's error.
        source: io::Error,
    },
    /// No token.
    #[error("the system gives no random numbers for the monitor's address: {0}")]
    Random(getrandom::Error),
    /// No thread.
    #[error("the monitor's thread cannot be started: {0}")]
    Thread(io::Error),
}
