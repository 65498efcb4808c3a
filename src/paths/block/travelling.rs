//! Bragg waves that travel, and facets that forget their phases, over a block: what turns the amplitudes of a
//! tile from pulse to pulse.
//!
//! Amplitudes at the scattering epochs have the phases of facets at rest, and are as slow as those of waves
//! that are frozen; phasors turn faster than epochs lie, and are found at every pulse
//! ([`crate::scattering::bragg::block`]). Specular points turn by a phasor of their own: where they add to
//! what a sample of the block returns, a tile is handed over twice, its Bragg waves and its specular points.

use super::TileWork;
use super::forgetting::{Forgetting, SumWaves};
use super::tile::{Pair, TURNED_LANES, TurnedRow};
use crate::cpu::Task;
use crate::geometry::lanes::{Paths, Row};
use crate::paths::PathGenerator;
use crate::paths::sea::SeaPlan;
use crate::scattering::bragg::block::{BlockPhasors, Phasors, Times};
use crate::scattering::bragg::group::{GROUP, Looks};
use crate::scattering::bragg::{BraggLines, Mechanism};
use crate::scattering::facets::Phases;
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
    /// A mechanism whose phases are forgotten.
    Forgetting(usize),
}

impl Part {
    /// Takes the phasors of the other parts away.
    pub fn choose(self, batch: &mut Batch) {
        let gone = match self {
            Self::Still | Self::All => 0..0,
            Self::Bragg => 0..1,
            Self::Specular => 1..batch.phasor.len(),
            Self::Forgetting(_) => 0..batch.phasor.len(),
        };
        batch.phasor[gone].as_flattened_mut().iter_mut().for_each(|row| row.fill(0.0));
        if let Self::Forgetting(mechanism) = self {
            batch.phasor[mechanism][0].fill(1.0);
        }
    }

    fn mechanism(self) -> Option<Mechanism> {
        match self {
            Self::Still | Self::Forgetting(_) => None,
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

impl SeaPlan {
    /// Whether phasors turn facets at every pulse.
    pub(super) fn turns(&self) -> bool {
        self.scattering.travelling().is_some() || self.scattering.decorrelates()
    }

    /// What of a tile is handed over one after the other.
    pub(super) fn parts(&self, specular: bool) -> impl Iterator<Item = Part> + use<> {
        let single = self.lanes.phases() == Phases::Single;
        let forgets = self.scattering.decorrelates();
        let mechanisms = if forgets { self.scattering.mechanisms() } else { 0 };
        let forgetting = Forgetting::mechanisms(mechanisms, single, specular).filter(move |_| forgets);
        let [first, more] = match (forgets, self.scattering.travelling().is_some(), specular) {
            (true, ..) => [None; 2],
            (_, false, _) => [Some(Part::Still), None],
            (_, true, false) => [Some(Part::All), None],
            (_, true, true) => [Some(Part::Bragg), Some(Part::Specular)],
        };
        first.into_iter().chain(more).chain(forgetting.map(Part::Forgetting))
    }
}

impl PathGenerator {
    /// How often a tile is handed over, specular points apart.
    pub fn parts_of_tiles(&self) -> usize {
        self.sea.as_ref().map_or(1, |sea| sea.parts(false).count())
    }

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
        let is_more = std::mem::replace(&mut work.is_more, true);
        for pair in 0..self.plans.len() {
            let middle = work.tile.pairs[pair].epoch_count / 2;
            self.epoch(sea, pair, middle, patch.facet_m * patch.facet_m, work);
            sum.own_w += power_w(&work.tile.pairs[pair], work.tile.count);
        }
        (work.part, work.is_more) = (part, is_more);
    }

    /// What turns the part of the tile at every pulse.
    pub(super) fn turn(&self, sea: &SeaPlan, pair: usize, work: &mut TileWork) {
        let TileWork { variant, part, land, timings, nodes, keys, turns, forgetting, tile, .. } = work;
        let timing = timings.of(tile.tier);
        let Pair { nodes: paths, node_count, factor, turned, .. } = &mut tile.pairs[pair];
        let lines = sea.scattering.travelling().zip(part.mechanism());
        if lines.is_none() && !matches!(part, Part::Forgetting(_)) {
            turned.clear();
            return;
        }
        turned.resize(factor.len(), [[0.0; TURNED_LANES]; 2]);
        turns.resize(factor.len(), [[0.0; GROUP]; 2]);
        let ends = [&*paths[0].paths, &*paths[*node_count - 1].paths];
        let uneven = tile.slow.uneven();
        let times = Times { first_s: nodes[timing.nodes[0]].elapsed_s, interval_s: tile.interval_s, uneven };
        for from in (0..tile.count).step_by(GROUP) {
            let keys = &keys[from..tile.count.min(from + GROUP)];
            if let Some((lines, mechanism)) = lines {
                variant.run(TurnGroup { lines, mechanism, from, keys, ends, times, turns, turned });
            } else if let Part::Forgetting(mechanism) = *part {
                let waves = forgetting.waves(&sea.scattering, mechanism, keys, sea.patch.facets);
                variant.run(SumWaves { waves: &waves, times, out: &mut *turns });
                put(from, turns, turned);
            }
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
    times: Times<'a>,
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
        put(from, turns, turned);
    }
}

/// Phasors of a group to where they stand.
#[inline(always)]
fn put(from: usize, turns: &[Phasors], turned: &mut [[TurnedRow; 2]]) {
    for (turned, turns) in turned.iter_mut().zip(turns) {
        for (turned, turns) in turned.iter_mut().zip(turns) {
            if let Some(turned) = turned[from..].first_chunk_mut() {
                *turned = *turns;
            }
        }
    }
}

/// The lanes of a group, as many as are left.
#[inline(always)]
fn of_group(row: &Row, from: usize) -> &[f32; GROUP] {
    row[from..].first_chunk().unwrap_or(&[0.0; GROUP])
}
