//! Bragg waves that travel, over a block: what turns the amplitudes of a tile from pulse to pulse.
//!
//! Amplitudes at the scattering epochs have the phases of facets at rest, and are as slow as those of waves that
//! are frozen; phasors turn faster than epochs lie, and are found at every pulse
//! ([`crate::scattering::bragg::block`]). Specular points turn by a phasor of their own: where they add to what
//! a sample of the block returns, a tile is handed over twice, its Bragg waves and its specular points.

use super::TileWork;
use super::tile::Pair;
use crate::geometry::lanes::LANES;
use crate::paths::PathGenerator;
use crate::paths::sea::SeaPlan;
use crate::scattering::bragg::Mechanism;
use crate::scattering::bragg::block::Times;
use crate::scattering::bragg::group::{GROUP, Looks};
use crate::scattering::lanes::Batch;
use crate::scene::Patch;

/// Share of the power below which specular points turn with the Bragg waves: -90 dB.
const LEAST_SPECULAR: f64 = 1e-9;

/// What a tile is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All that scatters, phases at rest.
    Still,
    /// All that scatters, turned as Bragg waves.
    All,
    /// Bragg waves.
    Bragg,
    /// Specular points.
    Specular,
}

impl Part {
    /// That of the tiles of a block, and that of a second pass.
    pub fn of_block(travelling: bool, specular: bool) -> (Self, Option<Self>) {
        match (travelling, specular) {
            (false, _) => (Self::Still, None),
            (true, false) => (Self::All, None),
            (true, true) => (Self::Bragg, Some(Self::Specular)),
        }
    }

    /// Takes the phasors of the other part away.
    pub fn choose(self, batch: &mut Batch) {
        let gone = match self {
            Self::Still | Self::All => 0..0,
            Self::Bragg => 0..1,
            Self::Specular => 1..batch.phasor.len(),
        };
        batch.phasor[gone].as_flattened_mut().iter_mut().for_each(|row| row.fill(0.0));
    }

    fn mechanism(self) -> Option<Mechanism> {
        match self {
            Self::Still => None,
            Self::All | Self::Bragg => Some(Mechanism::Bragg),
            Self::Specular => Some(Mechanism::Specular),
        }
    }
}

/// What a sample shows of specular points.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Specular {
    own_w: f64,
    all_w: f64,
}

impl Specular {
    /// Whether they add to the block.
    pub fn counts(self) -> bool {
        self.own_w > LEAST_SPECULAR * self.all_w
    }
}

impl PathGenerator {
    /// Adds what the tile at hand returns at the middle of the block, and its specular points alone.
    pub(super) fn add_specular(&self, sea: &SeaPlan, patch: &Patch, work: &mut TileWork, sum: &mut Specular) {
        if work.tile.count == 0 {
            return;
        }
        let power_w = |pair: &Pair, count: usize| -> f64 {
            let (epoch, factor) = (&pair.epochs()[pair.epoch_count / 2], &pair.factor[pair.factor.len() / 2]);
            epoch.power[..count].iter().zip(factor).map(|(w, factor)| f64::from(w * factor * factor)).sum()
        };
        sum.all_w += work.tile.pairs.iter().map(|pair| power_w(pair, work.tile.count)).sum::<f64>();
        Part::Specular.choose(&mut work.batch);
        let part = std::mem::replace(&mut work.part, Part::Specular);
        for pair in 0..self.plans.len() {
            let middle = work.tile.pairs[pair].epoch_count / 2;
            self.epoch(sea, pair, middle, patch.facet_m * patch.facet_m, work);
            sum.own_w += power_w(&work.tile.pairs[pair], work.tile.count);
        }
        work.part = part;
    }

    /// Factors of every pulse times what turns the part of the tile.
    pub(super) fn turn(&self, sea: &SeaPlan, pair: usize, work: &mut TileWork) {
        let TileWork { variant, part, land, timings, nodes, keys, turns, tile, .. } = work;
        let timing = timings.of(tile.tier);
        let Pair { nodes: paths, node_count, factor, turned, .. } = &mut tile.pairs[pair];
        let (Some(lines), Some(mechanism)) = (sea.scattering.travelling(), part.mechanism()) else {
            turned.clear();
            return;
        };
        turned.resize(factor.len(), [[0.0; LANES]; 2]);
        turns.resize(factor.len(), [[0.0; GROUP]; 2]);
        let (first, last) = (&paths[0].paths, &paths[*node_count - 1].paths);
        let times = Times { first_s: nodes[timing.nodes[0]].elapsed_s, interval_s: tile.interval_s };
        let mut looks: [Looks; 2] = [[[0.0; GROUP]; 3]; 2];
        for from in (0..tile.count).step_by(GROUP) {
            let count = GROUP.min(tile.count - from);
            for (looks, paths) in looks.iter_mut().zip([first, last]) {
                for (axis, look) in looks.iter_mut().enumerate() {
                    let (scattered, incident) =
                        (&paths.scattered[axis][from..], &paths.incident[axis][from..]);
                    for ((look, scattered), incident) in look.iter_mut().zip(scattered).zip(incident) {
                        *look = f64::from(*scattered) - f64::from(*incident);
                    }
                }
            }
            let facets = (&keys[from..from + count], &looks);
            lines.phasors_of_block(*variant, mechanism, facets, times, turns);
            for ((turned, turns), factor) in turned.iter_mut().zip(&*turns).zip(&*factor) {
                for (turned, turns) in turned.iter_mut().zip(turns) {
                    for ((to, turn), factor) in turned[from..].iter_mut().zip(turns).zip(&factor[from..]) {
                        *to = turn * factor;
                    }
                }
            }
        }
        // Land rests.
        for i in (0..if land.count > 0 { tile.count } else { 0 }).filter(|i| land.land[*i] > 0.0) {
            for (turned, factor) in turned.iter_mut().zip(&*factor) {
                (turned[0][i], turned[1][i]) = (factor[i], 0.0);
            }
        }
    }
}
