//! What became of the datagrams of a network sink.

use serde::Serialize;

/// What became of the datagrams of a network sink.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct WireReport {
    /// Where they were sent.
    pub address: String,
    /// Where they came from.
    pub local: String,
    /// Room for datagrams on their way out, bytes.
    pub send_buffer_bytes: usize,
    /// Datagrams that the system took.
    pub datagrams: u64,
    /// Datagrams of `datagrams` that were answered by a refusal: nobody listens there.
    pub refused: u64,
    /// Datagrams lost because the send buffer stayed full.
    pub blocked: u64,
    /// Datagrams lost because the system had no buffer for them.
    pub no_buffer: u64,
    /// Datagrams lost for other reasons.
    pub failed: u64,
}

impl WireReport {
    /// Datagrams that cannot have arrived.
    pub fn lost(&self) -> u64 {
        self.refused + self.blocked + self.no_buffer + self.failed
    }
}
