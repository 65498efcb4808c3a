//! What is allowed of a hull.

/// Lengths that are hulls, m: the smallest models to beyond the largest ships.
pub const LENGTH_RANGE_M: [f64; 2] = [0.05, 1000.0];

/// Most stations.
pub const MOST_STATIONS: usize = 2001;

/// Most waterlines.
pub const MOST_WATERLINES: usize = 1001;

/// Longest file that is read, bytes.
pub const MOST_BYTES: u64 = 16 << 20;
