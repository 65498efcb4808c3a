//! What multiplies the amplitudes at every pulse: gains, shadows, facets that turn away.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use super::tile::{Epoch, Node};
use crate::cpu::Task;
use crate::geometry::lanes::{LANES, Row, lanes_for};

/// Cosine of a local angle below which a facet may turn away within a block.
const NEAR_GRAZING: f32 = 0.1;
/// Cosine (but for the length of the normal) at all nodes below which a facet does not turn towards an
/// antenna between them.
const TURNED_AWAY: f32 = -0.02;

/// Marks the facets of a pair that may return something.
pub(super) struct Illuminated<'a> {
    pub count: usize,
    pub nodes: &'a [Node],
    pub slopes: &'a [[Row; 2]],
    pub gains: &'a [Row],
    /// `[update][antenna]`.
    pub seen: &'a [Row],
    pub ends: usize,
    /// Transmitter and receiver.
    pub of: [usize; 2],
    pub illuminated: &'a mut Row,
}

impl Task for Illuminated<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, nodes, slopes, gains, seen, ends, of, illuminated } = self;
        let n = lanes_for(count);
        let mut gain = [0.0f32; LANES];
        for row in gains {
            for i in 0..n {
                gain[i] = gain[i].max(row[i].abs());
            }
        }
        for end in 0..2 {
            // Largest cosine, but for the length of the normal.
            let mut cosine = [-1.0f32; LANES];
            for (node, slope) in nodes.iter().zip(slopes) {
                let (k, sign) =
                    if end == 0 { (&node.paths.incident, -1.0f32) } else { (&node.paths.scattered, 1.0) };
                for i in 0..n {
                    let along = sign * (k[2][i] - k[0][i] * slope[0][i] - k[1][i] * slope[1][i]);
                    cosine[i] = if along > cosine[i] { along } else { cosine[i] };
                }
            }
            for i in 0..n {
                gain[i] = if cosine[i] > TURNED_AWAY { gain[i] } else { 0.0 };
            }
            if ends > 0 {
                let mut most = [0.0f32; LANES];
                for rows in seen.chunks_exact(ends) {
                    let row = &rows[of[end] % ends];
                    for i in 0..n {
                        most[i] = if row[i] > most[i] { row[i] } else { most[i] };
                    }
                }
                for i in 0..n {
                    gain[i] *= most[i];
                }
            }
        }
        for i in 0..n {
            illuminated[i] = if gain[i] > illuminated[i] { gain[i] } else { illuminated[i] };
        }
    }
}

/// Factors times a visibility between two updates.
pub(super) struct Shadowed<'a> {
    pub count: usize,
    pub from: &'a Row,
    pub to: &'a Row,
    pub share: f32,
    pub out: &'a mut Row,
}

impl Task for Shadowed<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { count, from, to, share, out } = self;
        for i in 0..lanes_for(count) {
            out[i] *= from[i] + share * (to[i] - from[i]);
        }
    }
}

/// Whether some facet may turn away from an antenna.
pub(super) struct Turns<'a> {
    pub count: usize,
    pub epochs: &'a [Epoch],
}

impl Task for Turns<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let n = lanes_for(self.count);
        let mut least = [1.0f32; LANES];
        for row in self.epochs.iter().flat_map(|epoch| &epoch.cosine) {
            for i in 0..n {
                least[i] = if row[i] < least[i] { row[i] } else { least[i] };
            }
        }
        least[..self.count.min(LANES)].iter().any(|cosine| *cosine < NEAR_GRAZING)
    }
}

/// `out = sum of weights times rows`.
pub(super) struct Weigh<'a> {
    pub count: usize,
    pub rows: &'a [Row],
    pub weights: &'a [f32],
    pub out: &'a mut Row,
}

impl Task for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = lanes_for(self.count);
        self.out[..n].fill(0.0);
        for (row, weight) in self.rows.iter().zip(self.weights) {
            for i in 0..n {
                self.out[i] += weight * row[i];
            }
        }
    }
}

/// Scales of amplitudes times the roots of areas, `sum of weights times rows`.
pub(super) struct Stretched<'a> {
    pub count: usize,
    pub rows: &'a [Row],
    pub weights: &'a [f32],
    pub out: &'a mut Row,
}

impl Task for Stretched<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = lanes_for(self.count);
        let mut area = [0.0f32; LANES];
        for (row, weight) in self.rows.iter().zip(self.weights) {
            for i in 0..n {
                area[i] += weight * row[i];
            }
        }
        for i in 0..n {
            self.out[i] *= area[i].max(0.0).sqrt();
        }
    }
}
