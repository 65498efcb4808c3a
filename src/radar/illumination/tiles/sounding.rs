//! A sample of the facets of a block, at instants of one's own choice: for whoever wants to know what interpolation leaves.
//!
//! Tiles spread over the patch are lit as [`Illumination::visit_tiles`] lights all of them, but for two things: shadows are those of one
//! pulse throughout, or none (both sides of any comparison share them), and the product of gains is told apart from the factor.

use super::{Instants, Pair, TileWork, sampled};
use crate::geometry::lanes::{LANES, Row};
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

impl Illumination {
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
        let all = patch.len().div_ceil(LANES);
        for (place, tile) in sampled(all, tiles).enumerate() {
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
