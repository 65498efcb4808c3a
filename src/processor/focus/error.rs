//! Why a recording cannot be focused.

use crate::inputs::one_line;
use crate::processor::range_compress::CompressError;
use crate::recording::RecordingError;
use crate::recording::ground::GroundError;

/// Why a recording cannot be focused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FocusError {
    /// A path that the recording lacks.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// No image of such a size.
    #[error(transparent)]
    Ground(#[from] GroundError),
    /// The recording has no pulse to compress with.
    #[error(transparent)]
    Compress(#[from] CompressError),
    /// An error of interpolation that cannot be kept.
    #[error("interpolation error of {found_db} dB; allowed: a number from -100 to below 0")]
    Interpolation {
        /// As asked.
        found_db: f64,
    },
    /// What came over the wire from a sender that does not describe its radar.
    #[error(
        "holds no replica: it was received over the wire from a sender that describes neither waveform nor antennas (an earlier version, or a replica of more than 2^20 samples); allowed: what was received from one that does (docs/wire.md, classes 5 to 7), or the sender's own recording"
    )]
    NoReplica,
    /// Blocks of samples in place of pulses.
    #[error(
        "holds blocks received without a gap (radar.window.gate = \"continuous\"), and an image takes a window for every pulse; allowed: a recording with gate = \"windowed\", or windows cut from the blocks by a processor of your own (docs/continuous.md)"
    )]
    Continuous,
    /// Tones in place of pulses.
    #[error(
        "holds dechirped echoes (radar.dechirp), which are compressed by a transform, not by a replica; allowed: a recording without radar.dechirp, or a processor of your own (docs/fmcw.md)"
    )]
    Dechirped,
    /// What came over the wire, by true navigation.
    #[error(
        "holds no true phase centres: it was received over the wire, which carries what platforms report; allowed: --nav reported"
    )]
    NoTruth,
    /// Nothing but calibration channels.
    #[error("holds no channel of echoes")]
    NoEchoes,
    /// Neither a centre nor anything from which it would follow.
    #[error(
        "has neither attribute instrument nor a scenario that this version can read, from which the middle of the image would follow; allowed: a centre (--centre-m X,Y)"
    )]
    NoCentre,
    /// A Doppler band about the aim of an antenna that has none.
    #[error(
        "channel {} has no aim about which a Doppler band of {hz} Hz could lie: its antennas are isotropic, or the recording does not hold where they look; allowed: all pulses (--doppler-hz all)",
        one_line(channel)
    )]
    NoAim {
        /// As asked.
        hz: f64,
        /// The channel.
        channel: String,
    },
    /// No pulse carries what a channel receives.
    #[error("channel {}: none of the pulses left in its polarisation", one_line(channel))]
    NotIlluminated {
        /// The channel.
        channel: String,
    },
}
