//! A sample of the facets of a block, at instants of one's own choice: for whoever wants to know what interpolation leaves.
//!
//! Tiles spread over the patch are lit as [`Illumination::visit_tiles`] lights all of them, but for two things: shadows are those of one
//! pulse throughout, or none (both sides of any comparison share them), and the product of gains is told apart from the factor.

use super::{GAIN_POINTS, Instants, LOOKS, LOOKS_PER_NODE, NODES, Pair, TileWork, lagrange};
use crate::geometry::lanes::Row;
use crate::radar::fault::RadarError;
use crate::radar::illumination::Illumination;
use crate::scene::Patch;

/// What a sample shows of one pair.
pub struct Heard<'a> {
    /// Place of the tile in the sample.
    pub tile: usize,
    /// The pair.
    pub pair: usize,
    /// Facets.
    pub count: usize,
    /// Nodes, looks, factors.
    pub of: &'a Pair,
    /// Product of the gains, at every gain instant.
    pub gains: &'a [Row],
}

/// Which shadows a sounding has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shadows {
    /// Those at its first pulse.
    #[default]
    Find,
    /// Those found last.
    Keep,
    /// None.
    Without,
}

/// What a sounding takes over from the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Shadows.
    pub shadows: Shadows,
    /// The surface at the nodes, which must be as many.
    pub surface: bool,
}

impl Instants {
    /// Those of a block: up to [`NODES`] nodes from its first to its last pulse, `looks` from one node to the next where there
    /// are as many pulses.
    pub fn of_block(first: u64, pulses: usize, looks: usize, gain_pulses: usize) -> Self {
        let last = pulses.saturating_sub(1);
        let (nodes, node_count) = nodes_within(pulses);
        let gain_pulses = gain_step(pulses, gain_pulses);
        let mut instants = Self { first, pulses, nodes, node_count, gain_pulses, ..Self::default() };
        for n in 0..node_count {
            let (node, next) = (nodes[n], if n + 1 < node_count { nodes[n + 1] } else { last });
            let steps = looks.clamp(1, LOOKS_PER_NODE).min((next - node).max(1));
            for step in 0..if n + 1 < node_count { steps } else { 1 } {
                instants.looks[instants.look_count.min(LOOKS - 1)] = node + (next - node) * step / steps;
                instants.look_count += 1;
            }
        }
        instants
    }
}

/// Pulses of the nodes within a block of so many pulses, rising, and how many there are.
pub fn nodes_within(pulses: usize) -> ([usize; NODES], usize) {
    let last = pulses.saturating_sub(1);
    if last >= NODES - 1 {
        (std::array::from_fn(|n| n * last / (NODES - 1)), NODES)
    } else {
        (std::array::from_fn(|n| n.min(last)), last + 1)
    }
}

/// Pulses from gain to gain that a block of so many pulses takes: not more than leave it all the instants of a polynomial.
pub fn gain_step(pulses: usize, gain_pulses: usize) -> usize {
    gain_pulses.min(pulses.saturating_sub(1) / (GAIN_POINTS - 1)).max(1)
}

/// Pulses of the gain instants of a block.
pub fn gain_instants(pulses: usize, gain_pulses: usize) -> Vec<usize> {
    let last = pulses.saturating_sub(1);
    let mut places: Vec<usize> = (0..last).step_by(gain_pulses.max(1)).collect();
    places.push(last);
    places
}

/// Weights of the gain instants at a pulse: the first of them, and as many weights as count.
pub fn gain_weights(places: &[usize], pulse: usize) -> (usize, [f32; GAIN_POINTS]) {
    lagrange(places, pulse)
}

impl Illumination {
    /// Rms height that is expected of the waves, m; 0 without a sea.
    pub fn rms_height_m(&self) -> f64 {
        self.sea.as_ref().map_or(0.0, |sea| sea.surface.expected().variance_m2.sqrt())
    }

    /// Rms slope that is expected of the waves, along and across together; 0 without a sea.
    pub fn rms_slope(&self) -> f64 {
        self.sea.as_ref().map_or(0.0, |sea| sea.surface.expected().slope_variance.iter().sum::<f64>().sqrt())
    }

    /// Lights a sample of about so many tiles at some instants.
    pub fn sound(
        &self,
        instants: &Instants,
        patch: &Patch,
        tiles: usize,
        keep: Keep,
        work: &mut TileWork,
        mut each: impl FnMut(&Heard<'_>),
    ) -> Result<(), RadarError> {
        let Some(sea) = &self.sea else { return Ok(()) };
        let first = instants.first;
        work.time(self, instants)?;
        if !keep.surface {
            sea.prepare(self, first, patch, work).map_err(|failure| self.sea_error(first, failure))?;
        }
        if keep.shadows == Shadows::Without {
            work.shades.clear();
        }
        if keep.shadows == Shadows::Find {
            let at_once = Instants { pulses: 1, ..*instants };
            work.shade(self, sea, &at_once, patch).map_err(|failure| self.sea_error(first, failure))?;
        }
        let held = work.shares.first().copied().unwrap_or_default();
        work.shares.clear();
        work.shares.resize(instants.pulses, held);
        let all = patch.len().div_ceil(crate::geometry::lanes::LANES);
        // An odd step: rows of a patch are often a power of two of tiles.
        let step = match (all / tiles.max(1)).max(1) {
            1 => 1,
            step => step | 1,
        };
        for (place, tile) in (0..all).step_by(step).enumerate() {
            // Lanes stay facets, so that soundings can be compared.
            work.whole = true;
            self.light_tile(sea, patch, tile, work);
            work.whole = false;
            for pair in 0..self.plans.len() {
                let TileWork { gain_rows, tile, .. } = &*work;
                let of = &tile.pairs[pair];
                each(&Heard { tile: place, pair, count: tile.count, of, gains: &gain_rows[pair] });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_of_blocks() {
        let block = Instants::of_block(7, 37, 2, 4);
        assert_eq!((block.first, block.node_count, block.nodes), (7, 4, [0, 12, 24, 36]));
        assert_eq!(&block.looks[..block.look_count], [0, 6, 12, 18, 24, 30, 36]);
        // Blocks cut short move their nodes together, down to a single one.
        let short = Instants::of_block(0, 3, 3, 4);
        assert_eq!((short.node_count, &short.looks[..short.look_count]), (3, &[0, 1, 2][..]));
        let single = Instants::of_block(0, 1, 3, 4);
        assert_eq!((single.node_count, single.look_count), (1, 1));
        assert_eq!(gain_instants(10, 4), [0, 4, 8, 9]);
        // Six instants of gain at least, where there are as many pulses.
        assert_eq!([37, 21, 7, 3, 1].map(|pulses| gain_step(pulses, 4)), [4, 4, 1, 1, 1]);
        assert_eq!((block.gain_pulses, short.gain_pulses), (4, 1));
        assert_eq!(gain_instants(1, 4), [0]);
    }

    #[test]
    fn weights_of_gains_are_those_of_polynomials() {
        let places = gain_instants(37, 4);
        for pulse in 0..37 {
            let (first, weights) = gain_weights(&places, pulse);
            // A polynomial of the fifth degree is met: to rounding of values up to 1, weights below 3.
            let of = |m: usize| (m as f32 / 36.0).powi(5);
            let found: f32 = weights.iter().zip(&places[first..]).map(|(w, m)| w * of(*m)).sum();
            assert!((found - of(pulse)).abs() < 2e-6, "{pulse}: {found}");
        }
    }
}
