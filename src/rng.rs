//! Counter-based random streams keyed by (seed, purpose, index, part).
//!
//! A stream is a ChaCha8 generator whose 256-bit key *is* the address, so the numbers of pulse 1000,
//! channel 2 are the same whatever was drawn before, by whichever thread.
//!
//! ```
//! use nereus::rng::{stream, Room};
//! use rand::Rng;
//! let mut a = stream(7, Room::ReceiverNoise, 1000, 2);
//! let mut b = stream(7, Room::ReceiverNoise, 1000, 2);
//! assert_eq!(a.next_u64(), b.next_u64());
//! ```

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// What numbers are drawn for: one stream each, so that none depends on another. The values are part of the
/// format of a run: never reuse one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Room {
    /// Thermal noise of a receiver: index = pulse, part = channel.
    ReceiverNoise = 1,
    /// Jitter of the sampling clock: index = pulse.
    SamplingJitter = 2,
    /// Instability of the transmitter: index = pulse.
    Transmitter = 3,
    /// Complex amplitude of a sea wave: index = wave-number index along x, part = along y (as two's
    /// complement).
    SeaWave = 16,
    /// Random phases of a sea facet: index and part = its global grid numbers (two's complement).
    FacetPhase = 20,
    /// Loss of memory of a sea facet: as above.
    FacetDecorrelation = 21,
    /// Travelling Bragg waves of a sea facet: as above.
    FacetBragg = 22,
    /// Breaking waves: index = numbers of a cell of the sea (32 bits each), part = slot of time (two's
    /// complement).
    Breaker = 23,
    /// Random phases of a facet of land: as above.
    LandPhase = 25,
    /// Drops of rain: index = numbers of a box of space (21 bits each), part = slot of time * 256 + level of
    /// the box.
    RainDrop = 40,
    /// Waves of the far sea: one stream; of a cell that has waves of its own: index = its number of
    /// [`Room::FarCell`], part = 1.
    FarWave = 43,
    /// Cells of the far sea: index = numbers of a lot of the sea (32 bits each), part = slot of time times
    /// 256, plus level of the lot.
    FarCell = 44,
    /// Samples of a continuous signal: the place in the stream is that of the sample.
    Waveform = 42,
    /// Bytes of a recording that are corrupted on purpose.
    CorruptedBytes = 48,
    /// Errors of a platform's report: index = platform * 256 + axis, part = epoch of the report (two's
    /// complement).
    ReportErrors = 32,
    /// Gusts: index = platform * 256 + axis, part = step (two's complement).
    Turbulence = 33,
    /// Radar cross section of a target: index = scan or pulse, part = target.
    TargetFluctuation = 35,
    /// Readings of an antenna's encoder: index = pulse, part = antenna.
    Encoder = 36,
    /// Noise of a clock: index = clock, part = step of its series.
    Clock = 34,
    /// Pulses at which the error of an echo is measured.
    SampledPulses = 64,
    /// Samples of a law of clutter: index = sample, part = law.
    Bootstrap = 65,
}

/// The stream at an address.
pub fn stream(seed: u64, purpose: Room, index: u64, part: u64) -> ChaCha8Rng {
    let mut key = [0u8; 32];
    for (bytes, word) in key.chunks_exact_mut(8).zip([seed, purpose as u64, index, part]) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    ChaCha8Rng::from_seed(key)
}

#[cfg(test)]
#[path = "../tests/support/cases.rs"]
pub(crate) mod cases;
