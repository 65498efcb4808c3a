//! Bragg waves that travel, over a block: what turns the amplitudes of a tile from pulse to pulse.
//!
//! Amplitudes at the scattering epochs have the phases of facets at rest, and are as slow as those of waves
//! that are frozen; phasors turn faster than epochs lie, and are found at every pulse
//! ([`crate::scattering::bragg::block`]). Specular points turn by a phasor of their own: where they add to
//! what a sample of the block returns, a tile is handed over twice, its Bragg waves and its specular points.

use super::TileWork;
use super::tile::{Pair, TURNED_LANES, TurnedRow};
use crate::cpu::Task;
use crate::geometry::lanes::{Paths, Row};
use crate::paths::PathGenerator;
use crate::paths::sea::SeaPlan;
use crate::scattering::bragg::block::{BlockPhasors, Phasors, Times};
use crate::scattering::bragg::group::{GROUP, Looks};
use crate::scattering::bragg::{BraggLines, Mechanism};
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

    /// What turns the part of the tile at every pulse.
    pub(super) fn turn(&self, sea: &SeaPlan, pair: usize, work: &mut TileWork) {
        let TileWork { variant, part, land, timings, nodes, keys, turns, tile, .. } = work;
        let timing = timings.of(tile.tier);
        let Pair { nodes: paths, node_count, factor, turned, .. } = &mut tile.pairs[pair];
        let (Some(lines), Some(mechanism)) = (sea.scattering.travelling(), part.mechanism()) else {
            turned.clear();
            return;
        };
        turned.resize(factor.len(), [[0.0; TURNED_LANES]; 2]);
        turns.resize(factor.len(), [[0.0; GROUP]; 2]);
        let ends = [&*paths[0].paths, &*paths[*node_count - 1].paths];
        let times = Times { first_s: nodes[timing.nodes[0]].elapsed_s, interval_s: tile.interval_s };
        for from in (0..tile.count).step_by(GROUP) {
            let keys = &keys[from..tile.count.min(from + GROUP)];
            variant.run(TurnGroup { lines, mechanism, from, keys, ends, times, turns, turned });
        }
        // Land rests.
        for i in (0..if land.count > 0 { tile.count } else { 0 }).filter(|i| land.land[*i] > 0.0) {
            for [re, im] in turned.iter_mut() {
                (re[i], im[i]) = (1.0, 0.0);
            }
        }
    }
}

/// Turns a group of facets of a tile.
struct TurnGroup<'a> {
    lines: &'a BraggLines,
    mechanism: Mechanism,
    /// Its first facet.
    from: usize,
    keys: &'a [[i64; 2]],
    /// Paths at the first pulse and at the last.
    ends: [&'a Paths; 2],
    times: Times,
    turns: &'a mut [Phasors],
    /// Of every pulse.
    turned: &'a mut [[TurnedRow; 2]],
}

impl Task for TurnGroup<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { lines, mechanism, from, keys, ends, times, turns, turned } = self;
        let mut looks: [Looks; 2] = [[[0.0; GROUP]; 3]; 2];
        for (looks, paths) in looks.iter_mut().zip(ends) {
            for ((look, scattered), incident) in looks.iter_mut().zip(&paths.scattered).zip(&paths.incident) {
                let (scattered, incident) = (of_group(scattered, from), of_group(incident, from));
                for i in 0..GROUP {
                    look[i] = scattered[i] - incident[i];
                }
            }
        }
        BlockPhasors { lines, mechanism, keys, looks: &looks, times, out: &mut *turns }.run();
        for (turned, turns) in turned.iter_mut().zip(&*turns) {
            for (turned, turns) in turned.iter_mut().zip(turns) {
                if let Some(turned) = turned[from..].first_chunk_mut() {
                    *turned = *turns;
                }
            }
        }
    }
}

/// The lanes of a group, as many as are left.
#[inline(always)]
fn of_group(row: &Row, from: usize) -> &[f32; GROUP] {
    row[from..].first_chunk().unwrap_or(&[0.0; GROUP])
}
