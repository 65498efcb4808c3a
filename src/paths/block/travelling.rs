//! Bragg waves that travel, over a block: what turns the amplitudes of a tile from pulse to pulse.
//!
//! Amplitudes at the scattering epochs have the phases of facets at rest, and are as slow as those of waves
//! that are frozen; phasors turn faster than epochs lie, and are found at every pulse
//! ([`crate::scattering::bragg::block`]). Specular points turn by a phasor of their own: a tile that has any
//! ([`Batch::reflects`]) is handed over twice, its Bragg waves and its specular points. Each tile knows by
//! itself: of a wide patch only the few below an antenna may have them, and return most of the echo.

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

/// What a tile is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All that scatters, phases at rest.
    Still,
    /// Bragg waves.
    Bragg,
    /// Specular points.
    Specular,
}

impl Part {
    /// What a tile is of at first.
    pub fn first(travelling: bool) -> Self {
        if travelling { Self::Bragg } else { Self::Still }
    }

    /// What else there is of a tile, which had specular points or not.
    pub fn then(self, reflects: bool) -> Option<Self> {
        (self == Self::Bragg && reflects).then_some(Self::Specular)
    }

    /// Takes the phasors of the other part away.
    pub fn choose(self, batch: &mut Batch) {
        let gone = match self {
            Self::Still => 0..0,
            Self::Bragg => 0..1,
            Self::Specular => 1..batch.phasor.len(),
        };
        batch.phasor[gone].as_flattened_mut().iter_mut().for_each(|row| row.fill(0.0));
    }

    fn mechanism(self) -> Option<Mechanism> {
        match self {
            Self::Still => None,
            Self::Bragg => Some(Mechanism::Bragg),
            Self::Specular => Some(Mechanism::Specular),
        }
    }
}

impl PathGenerator {
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
