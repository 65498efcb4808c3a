//! A sample of the facets of a block, at instants of one's own choice: to find what
//! interpolation leaves.
//!
//! Tiles spread over the patch are illuminated as [`PathGenerator::visit_tiles`] does all of them, but for
//! two things: shadows are those of one pulse throughout, or none (both sides of any comparison share them),
//! and the product of gains is reported apart from the factor.

use super::instants::Tiers;
use super::runs::{Cut, Run};
use super::shadows::Heights;
use super::{Instants, Pair, TileWork};
use crate::geometry::lanes::Row;
use crate::paths::PathGenerator;
use crate::radar::fault::RadarError;
use crate::scene::Patch;

/// What a sample shows of one pair.
pub struct SampledTile<'a> {
    /// Place of the tile in the sample.
    pub tile: usize,
    /// The pair.
    pub pair: usize,
    /// Facets.
    pub count: usize,
    /// They are these.
    pub runs: &'a [Run],
    /// For every run, what of its peak the two-way gain of field of any pair has at most, at the gain
    /// instants.
    pub shares: &'a [f32],
    /// For every run, whether tiles with it are wake tiles.
    pub crossed: &'a [bool],
    /// Nodes, scattering epochs, factors.
    pub of: &'a Pair,
    /// Product of the gains, at every gain instant.
    pub gains: &'a [Row],
}

/// Which shadows a probe has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shadows {
    /// Those at its first pulse.
    #[default]
    Find,
    /// Those found last.
    Keep,
    /// None.
    Without,
}

/// What a probe takes over from the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// Shadows.
    pub shadows: Shadows,
    /// The surface at the nodes, which must be as many.
    pub surface: bool,
}

impl TileWork {
    /// What of its peak the two-way gain of any pair has at most for each run of the tile at hand.
    fn shares_of_runs(&self, peaks: &[f64], shares: &mut Vec<f32>) {
        let instants = self.timing().gain_places.len();
        shares.clear();
        let mut at = 0;
        for run in &self.runs {
            let lanes = at..at + run.count;
            let of = |(rows, peak): (&Vec<Row>, &f64)| {
                let gains = rows[..instants].iter().flat_map(|row| &row[lanes.clone()]);
                gains.fold(0.0f32, |most, gain| most.max(gain.abs())) / *peak as f32
            };
            shares.push(self.gain_rows.iter().zip(peaks).map(of).fold(0.0, f32::max));
            at += run.count;
        }
    }
}

impl PathGenerator {
    /// Rms slope that is expected of the waves, along and across together; 0 without a sea.
    pub fn rms_slope(&self) -> f64 {
        self.sea.as_ref().map_or(0.0, |sea| sea.surface.expected().slope_variance.iter().sum::<f64>().sqrt())
    }

    /// Share of the facets that a sample of about so many tiles has; 1 without a sea.
    pub fn sampled(&self, tiles: usize) -> f64 {
        self.sea.as_ref().map_or(1.0, |sea| Cut::of(sea.patch.facets).sampled(tiles))
    }

    /// Evaluates a sample of about so many tiles at some instants.
    ///
    /// # Errors
    /// Tracks that do not cover the instants; a sea or shadows that cannot be found at them.
    pub fn sample_tiles(
        &self,
        tiers: &Tiers,
        patch: &Patch,
        tiles: usize,
        keep: Keep,
        work: &mut TileWork,
        mut each: impl FnMut(&SampledTile<'_>),
    ) -> Result<(), RadarError> {
        let Some(sea) = &self.sea else { return Ok(()) };
        let instants = &tiers.mainlobe;
        let first = instants.first;
        work.time(self, tiers)?;
        if !keep.surface {
            sea.prepare(patch, work).map_err(|failure| self.sea_error(first, failure))?;
        }
        if keep.shadows == Shadows::Without {
            work.shadow_updates.clear();
        }
        if keep.shadows == Shadows::Find {
            let at_once = Instants { pulses: 1, ..*instants };
            work.weigh_shadows(self, sea, &at_once, patch, Heights::Near)
                .map_err(|failure| self.sea_error(first, failure))?;
        }
        let held = work.shares.first().copied().unwrap_or_default();
        work.shares.clear();
        work.shares.resize(instants.pulses, held);
        let (mut shares, mut crossed) = (Vec::new(), Vec::new());
        let peaks: Vec<f64> = (0..self.plans.len()).map(|pair| self.peak_gain(pair)).collect();
        for (place, runs) in Cut::of(patch.facets).sample(tiles).enumerate() {
            work.take(runs);
            // Lanes stay facets, so that probes can be compared.
            work.whole = true;
            self.evaluate_tile(sea, patch, work);
            work.whole = false;
            work.shares_of_runs(&peaks, &mut shares);
            crossed.clear();
            let mut at = 0;
            for run in &work.runs {
                let lanes = at..at + run.count;
                at = lanes.end;
                crossed.push(sea.scattering.has_short_waves() && self.are_crossed(sea, work, lanes));
            }
            for pair in 0..self.plans.len() {
                let TileWork { gain_rows, runs, tile, .. } = &*work;
                let of = &tile.pairs[pair];
                let gains = &gain_rows[pair][..work.timing().gain_places.len()];
                let (shares, crossed, count) = (&shares, &crossed, tile.count);
                each(&SampledTile { tile: place, pair, count, runs, shares, crossed, of, gains });
            }
        }
        Ok(())
    }
}
