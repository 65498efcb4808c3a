//! What became of the cells of a video.

use serde::Serialize;

/// What became of the cells of a video.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct VideoReport {
    /// Radials sent.
    pub radials: u64,
    /// Radials of which no pulse came.
    pub missed: u64,
    /// Cells sent.
    pub cells: u64,
    /// Cells whose level is above that of the greatest code.
    pub clipped: u64,
}
