//! Why a recording has no plan position picture.

use crate::inputs::one_line;
use crate::processor::range_compress::CompressError;
use crate::recording::RecordingError;

/// Why a recording has no plan position picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PpiError {
    /// What cannot be read, or is not in the recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recording has no pulse to compress with.
    #[error(transparent)]
    Compress(#[from] CompressError),
    /// What came over the wire from a sender that does not describe its radar.
    #[error(
        "holds no replica: it was received from a sender that describes neither waveform nor antennas; allowed: what was received from one that does (docs/wire.md, classes 5 to 7), or the sender's own recording"
    )]
    NoReplica,
    /// A recording that does not say how its antennas are mounted.
    #[error(
        "has no attribute instrument, so that nothing is known of its antennas; allowed: recordings of this version"
    )]
    NoInstrument,
    /// Blocks of samples in place of pulses.
    #[error(
        "holds blocks received without a gap (radar.window.gate = \"continuous\"); allowed: a recording with a window for every pulse (gate = \"windowed\")"
    )]
    Continuous,
    /// Tones in place of pulses.
    #[error("holds dechirped echoes (radar.dechirp); allowed: a recording without radar.dechirp")]
    Dechirped,
    /// Nothing but calibration channels.
    #[error("holds no channel of echoes")]
    NoEchoes,
    /// No such channel of echoes.
    #[error("channel {} is no channel of echoes of the recording; allowed: {allowed}", one_line(name))]
    Channel {
        /// As asked.
        name: String,
        /// Those that there are.
        allowed: String,
    },
    /// Range would not be half the way.
    #[error(
        "channel {}: transmitter on {}, receiver on {}; allowed: channels whose transmitter and receiver are on one platform",
        one_line(channel),
        one_line(transmits),
        one_line(receives)
    )]
    Bistatic {
        /// The channel.
        channel: String,
        /// Platform of the transmitter.
        transmits: String,
        /// Platform of the receiver.
        receives: String,
    },
    /// An antenna that stands still, or looks at a point.
    #[error(
        "channel {}: receiver {} does not scan; allowed: channels whose receiver has pointing.kind = \"scan\" or \"sector\"",
        one_line(channel),
        one_line(receiver)
    )]
    StandsStill {
        /// The channel.
        channel: String,
        /// Its receiver.
        receiver: String,
    },
    /// No pulse carries what a channel receives.
    #[error("channel {}: none of the pulses left in its polarisation", one_line(channel))]
    NotIlluminated {
        /// The channel.
        channel: String,
    },
    /// No such turn or sweep.
    #[error("scan {asked} is not in the recording; allowed: 0 to {last}")]
    Scan {
        /// As asked.
        asked: usize,
        /// The last one.
        last: usize,
    },
    /// A range before the first sample.
    #[error("a range of {asked_m} m; allowed: above {near_m:.1} m, where the receive window begins")]
    Range {
        /// As asked, m.
        asked_m: f64,
        /// Range of the first sample, m.
        near_m: f64,
    },
    /// A beam that is none.
    #[error("a beam of {asked_deg} degrees; allowed: above 0, up to 180")]
    Beam {
        /// As asked, degrees.
        asked_deg: f64,
    },
}
