//! Bytes that are lost, flipped or cut out, to try readers on them.

use rand::RngExt;

use crate::rng::{Room, stream};

/// The longest stretch that is cut, bytes.
const LONGEST_CUT: usize = 200;

/// Chances of each byte, 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Chances {
    /// To be lost.
    pub drop: f64,
    /// To have one of its bits flipped.
    pub flip: f64,
    /// To have a stretch of 1 to 200 bytes cut out behind it.
    pub cut: f64,
}

/// What became of the bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Corrupted {
    /// Bytes lost.
    pub dropped: u64,
    /// Bytes with a bit flipped.
    pub flipped: u64,
    /// Stretches cut out.
    pub cuts: u64,
    /// Bytes of them.
    pub cut_bytes: u64,
}

/// The bytes that are left; the same seed corrupts the same bytes.
pub fn corrupt(bytes: &[u8], chances: Chances, seed: u64) -> (Vec<u8>, Corrupted) {
    let mut random = stream(seed, Room::CorruptedBytes, 0, 0);
    let mut kept = Vec::with_capacity(bytes.len());
    let mut counts = Corrupted::default();
    let mut skip = 0;
    for &byte in bytes {
        if skip > 0 {
            skip -= 1;
            counts.cut_bytes += 1;
            continue;
        }
        // Every byte takes as many draws, whatever becomes of it.
        let draws: [f64; 3] = random.random();
        let (bit, length) = (random.random_range(0..8), random.random_range(1..=LONGEST_CUT));
        if draws[2] < chances.cut {
            counts.cuts += 1;
            skip = length;
        }
        if draws[0] < chances.drop {
            counts.dropped += 1;
            continue;
        }
        let flip = draws[1] < chances.flip;
        counts.flipped += u64::from(flip);
        kept.push(if flip { byte ^ (1 << bit) } else { byte });
    }
    (kept, counts)
}
