//! Bragg waves that travel, and facets that forget their phases, over a block: what turns the amplitudes of a
//! tile from pulse to pulse.
//!
//! Amplitudes at the scattering epochs have the phases of facets at rest, and are as slow as those of waves
//! that are frozen; phasors turn faster than epochs lie, and are found at every pulse
//! ([`crate::scattering::bragg::block`]). Specular points turn by a phasor of their own: a tile that has any
//! that count ([`Batch::reflects`]) is handed over twice, its Bragg waves and its specular points. Each tile
//! knows by itself: of a wide patch only the few below an antenna may have them, and return most of the echo.

use super::TileWork;
use super::forgetting::SumWaves;
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
use crate::scattering::water::WaterScattering;

/// What a tile is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// All that scatters, phases at rest.
    Still,
    /// Bragg waves; a mode of their tilts where facets are of Gaussian amplitude.
    Bragg(usize),
    /// Specular points.
    Specular,
    /// A mechanism whose phases are forgotten.
    Forgetting(usize),
}

impl Part {
    /// Takes the phasors of the other parts away.
    pub fn choose(self, water: &WaterScattering, batch: &mut Batch) {
        let gone = match self {
            Self::Still => 0..0,
            Self::Bragg(_) => 0..1,
            Self::Specular => 1..batch.phasor.len(),
            Self::Forgetting(_) => 0..batch.phasor.len(),
        };
        batch.phasor[gone].as_flattened_mut().iter_mut().for_each(|row| row.fill(0.0));
        let mode = match self {
            Self::Bragg(mode) => Some(mode),
            Self::Forgetting(process) => process.checked_sub(1),
            Self::Still | Self::Specular => None,
        };
        if let Some(share) = mode.and_then(|mode| water.tilt_shares(mode)) {
            for (tilt, [re, im]) in batch.phasor.iter_mut().skip(1).enumerate() {
                re.fill(share(tilt) as f32);
                im.fill(0.0);
            }
        } else if let Self::Forgetting(process) = self {
            batch.phasor[process][0].fill(1.0);
        }
    }

    /// What turns it, where waves travel.
    pub fn mechanism(self) -> Option<Mechanism> {
        match self {
            Self::Still | Self::Forgetting(_) => None,
            Self::Bragg(_) => Some(Mechanism::Bragg),
            Self::Specular => Some(Mechanism::Specular),
        }
    }
}

impl SeaPlan {
    /// What a tile is of at first.
    pub(super) fn first_part(&self) -> Part {
        let several = self.lanes.phases() != Phases::Single && self.scattering.mechanisms() > 1;
        match (self.scattering.decorrelates(), self.scattering.travelling().is_some()) {
            (true, _) => Part::Forgetting(usize::from(several)),
            (false, true) => Part::Bragg(0),
            (false, false) => Part::Still,
        }
    }

    /// What else there is of a tile, which has specular points that count or not.
    pub(super) fn part_after(&self, part: Part, reflects: impl FnOnce() -> bool) -> Option<Part> {
        match part {
            Part::Bragg(mode) if mode + 1 < self.scattering.travelling_modes() => Some(Part::Bragg(mode + 1)),
            Part::Bragg(_) => reflects().then_some(Part::Specular),
            Part::Still | Part::Specular | Part::Forgetting(0) => None,
            Part::Forgetting(own) if own + 1 < self.scattering.processes() => Some(Part::Forgetting(own + 1)),
            Part::Forgetting(_) => reflects().then_some(Part::Forgetting(0)),
        }
    }

    /// Whether land, which rests, is in the part.
    pub(super) fn has_land(&self, part: Part) -> bool {
        part == Part::Still || part == self.first_part()
    }
}

impl PathGenerator {
    /// How often a tile without specular points is handed over.
    pub fn parts_of_tiles(&self) -> usize {
        self.sea.as_ref().map_or(1, |sea| {
            std::iter::successors(Some(sea.first_part()), |part| sea.part_after(*part, || false)).count()
        })
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
        let uneven = tile.supports.chosen().map_or(tile.slow.uneven(), |own| own.at());
        let times = Times { first_s: nodes[timing.nodes[0]].elapsed_s, interval_s: tile.interval_s, uneven };
        for from in (0..tile.count).step_by(GROUP) {
            let keys = &keys[from..tile.count.min(from + GROUP)];
            if let Some((lines, mechanism)) = lines {
                let mode = if let Part::Bragg(mode) = *part { mode } else { 0 };
                let of = (mechanism, mode);
                variant.run(TurnGroup { lines, of, from, keys, ends, times, turns, turned });
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
    /// What, and which mode of it.
    of: (Mechanism, usize),
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
        let Self { lines, of: (mechanism, mode), from, keys, ends, times, turns, turned } = self;
        let mut looks: [Looks; 2] = [[[0.0; GROUP]; 3]; 2];
        for (looks, paths) in looks.iter_mut().zip(ends) {
            for ((look, scattered), incident) in looks.iter_mut().zip(&paths.scattered).zip(&paths.incident) {
                let (scattered, incident) = (of_group(scattered, from), of_group(incident, from));
                for i in 0..GROUP {
                    look[i] = scattered[i] - incident[i];
                }
            }
        }
        BlockPhasors { lines, mechanism, mode, keys, looks: &looks, times, out: &mut *turns }.run();
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
