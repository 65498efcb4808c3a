//! The far sea over a stretch of pulses: tiles of cells, exact at both ends of it.
//!
//! Cells run straight on, so that delays are cubics between nodes and amplitudes straight lines. Gains,
//! envelopes, horizons and main lobes ([`super::gains`]) are found at every pulse and multiply the amplitude.
//! Cells are gathered from their lots, as many as are side by side at a time, and handed over as a tile.
//!
//! A tile is exact at both ends of a half where
//!
//! - a direction turns by more than `STRAIGHT_RAD`, or H and V with it: amplitudes are straight lines within
//!   1e-4 else;
//! - a cubic may leave more than `PHASE_RAD` of the phase: `9 r d^4/384`, `r` the way and `d` the turn;
//!
//! and all tiles of a stretch are where antennas turn far, or where the cubic misses one of them halfway.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

use super::cells::{AsSeen, Cells, Maker, Matrix};
use super::gains::{Outlook, Passes, Towards};
use super::squares::{Search, Split, Square, is_on};
use super::{FASTEST_MPS, FarPlan, Work};
use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::geometry::lanes::{End, LANES, Paths, Row, WideRow};
use crate::paths::block::{OnRays, OntoPorts, Scale, Tile, View};
use crate::paths::emission::Emission;
use crate::paths::facets::Reception;
use crate::paths::sea::SeaFailure;
use crate::paths::spikes::stretch::PHASE_RAD;
use crate::paths::{PairPlan, PathGenerator, Workspace};
use crate::pulse::costs::Stage;
use crate::radar::fault::RadarError;
use crate::scattering::lanes::Batch;
use crate::units::SPEED_OF_LIGHT_MPS;

/// What antennas turn to either side of the middle of a stretch, over the width of their beams.
const TURN_WIDTHS: f64 = 0.55;
/// The same, rad: amplitudes are straight lines within 1e-4.
const TURN_RAD: f64 = 0.014;

/// What directions to a cell turn from end to end, rad, for the same reason.
const STRAIGHT_RAD: f64 = 0.03;

/// Cells side by side that a stretch may see.
#[derive(Clone)]
struct Lit {
    count: usize,
    /// When their life is half over, m.
    places: [WideRow; 3],
    pairs: Vec<LitPair>,
}

/// The same by a pair of antennas: velocities, m/s, and matrices.
#[derive(Clone)]
struct LitPair {
    velocities: [Row; 3],
    matrix: [[[Row; 2]; 2]; 2],
}

/// Buffers of one thread.
#[derive(Clone)]
pub(super) struct Buffers {
    lit: Lit,
    view: Box<View>,
    batch: Box<Batch>,
    tile: Tile,
}

impl Buffers {
    pub fn new(of: &PathGenerator) -> Self {
        let row = [0.0; LANES];
        let pair = LitPair { velocities: [row; 3], matrix: [[[row; 2]; 2]; 2] };
        let pairs = vec![pair; of.plans.len()];
        Self {
            lit: Lit { count: 0, places: [[0.0; LANES]; 3], pairs },
            view: View::boxed(),
            batch: Batch::boxed(0),
            tile: Tile::new(of.radar.emissions.mean_pri_s(), &of.groups_of_pairs()),
        }
    }
}

/// What the cells of a stretch are made from.
struct Making<'a> {
    of: &'a PathGenerator,
    plan: &'a FarPlan,
    /// First pulse, counted from that of the block.
    start: usize,
    /// Of every pulse, and their times after pulse 0.
    emissions: &'a [Emission],
    elapsed_s: &'a [f64],
    /// What antennas, windows and cells move and what antennas turn about the middle, m and rad.
    about: [f64; 2],
    reception: &'a Reception<'a>,
    /// `[pulse][pair]`.
    outlooks: &'a [[Outlook; 2]],
}

impl PathGenerator {
    /// Hands over the far sea of some pulses of a block as tiles; returns how many cells there are. `None`,
    /// and nothing is handed over, where antennas move or turn further than a stretch allows.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover.
    pub fn far_sea_of_stretch(
        &self,
        (block, pulses): (u64, Range<usize>),
        workspace: &mut Workspace,
        mut each: impl FnMut(&Tile),
    ) -> Result<Option<usize>, RadarError> {
        let (Some(plan), Some(sea), true) = (&self.far, &self.sea, self.gains_are_real()) else {
            return Ok(None);
        };
        let (first, count) = (block + pulses.start as u64, pulses.len());
        let Workspace { other, stretch, places, windows, far, costs, .. } = workspace;
        let emissions = &mut stretch.emissions;
        emissions.resize_with(count.max(emissions.len()), Emission::default);
        for (index, emission) in (first..).zip(&mut emissions[..count]) {
            self.evaluate(index, emission)?;
        }
        let emissions = &emissions[..count];
        stretch.elapsed_s.clear();
        stretch.elapsed_s.extend((first..).take(count).map(|index| self.radar.emissions.elapsed_s(index)));
        let elapsed_s = &stretch.elapsed_s[..];
        let Some(mut about) = self.about(plan, emissions, elapsed_s) else { return Ok(None) };
        let middle = first + count as u64 / 2;
        self.windows_at(middle, windows)?;
        stretch.windows.resize_with(stretch.windows.len().max(1), Vec::new);
        self.windows_at(first, &mut stretch.windows[0])?;
        let opens_s = windows.iter().zip(&stretch.windows[0]).map(|(a, b)| (a.open_s - b.open_s).abs());
        about[0] += SPEED_OF_LIGHT_MPS * opens_s.fold(0.0, f64::max);
        about[0] += FASTEST_MPS * 0.5 * (elapsed_s[count - 1] - elapsed_s[0]);
        let reception = &self.reception_of_all(middle, &emissions[count / 2], windows);
        let patch = sea.patch_at(&reception.surroundings, elapsed_s[0]);
        let patch = &patch.map_err(|failure| self.sea_error(first, SeaFailure::from(failure)))?;
        let Work { room, stretch: buffers, outlooks } = far.get_or_insert_with(|| Work::new(sea, self));
        outlooks.clear();
        for (emission, plan) in emissions.iter().flat_map(|it| self.plans.iter().map(move |plan| (it, plan)))
        {
            outlooks.push(Outlook::of_pair(self, plan, emission, &emissions[count / 2]));
        }
        let start = pulses.start;
        let made = Making { of: self, plan, start, emissions, elapsed_s, about, reception, outlooks };
        self.slow_time(block, pulses.end, &mut buffers.tile.slow);
        let mut each = |tile: &Tile| {
            costs.lap(Stage::ScattererPaths);
            each(tile);
            costs.lap(Stage::Spread);
        };
        let mut lit = 0;
        let [begin, end] = [elapsed_s[0], elapsed_s[count - 1]].map(FarPlan::slots_at);
        for slot in begin[0]..=end[1] {
            let coarser = self.begin_far_slot(plan, (first, slot), other, places)?;
            let split = Split { plan, of: self, places, coarser, slot };
            let search = Search { split, reception, patch, about };
            let maker = Maker { split, sea, middle_s: FarPlan::middle_s(slot) };
            let mut hand_over = |buffers: &mut Buffers| {
                lit += buffers.lit.count;
                made.hand_over(slot, pulses.clone(), buffers, &mut each);
                buffers.lit.count = 0;
            };
            let mut gather = |cells: &Cells| {
                for from in (0..cells.places.len()).step_by(LANES) {
                    let until = (from + LANES).min(cells.places.len());
                    let kept = made.kept(slot, cells, from..until);
                    for (i, place) in (from..until).zip(&cells.places[from..until]) {
                        let [x, y, _] = place.to_array();
                        if kept[i - from] == 0.0 || is_on(patch, [x, y]) {
                            continue;
                        }
                        buffers.lit.push(*place, cells.pairs.iter(), i);
                        if buffers.lit.count == LANES {
                            hand_over(buffers);
                        }
                    }
                }
            };
            search.lots(Square::ALL, &mut |lot| {
                plan.lots.with((slot, lot), || maker.lot(lot, room), &mut gather);
                true
            });
            hand_over(buffers);
        }
        Ok(Some(lit))
    }

    /// How far antennas move, m, and turn, rad, about the middle of some emissions; `None` where they turn
    /// too far, or where the cubic between the ends misses one in the middle.
    fn about(&self, plan: &FarPlan, emissions: &[Emission], elapsed_s: &[f64]) -> Option<[f64; 2]> {
        let at = emissions.len() / 2;
        let middle = &emissions[at];
        let ends = [&emissions[0], &emissions[emissions.len() - 1]];
        let lasts_s = elapsed_s[elapsed_s.len() - 1] - elapsed_s[0];
        let share = if lasts_s > 0.0 { (elapsed_s[at] - elapsed_s[0]) / lasts_s } else { 0.0 };
        let mut about = [0.0f64; 2];
        for (n, centre) in middle.centres.iter().enumerate() {
            let axes_of = |emission: &Emission, axis| emission.axes(n).col(axis);
            let turned = |from: &Emission, to: &Emission| {
                (0..3).map(|axis| axes_of(from, axis).distance(axes_of(to, axis))).fold(0.0, f64::max)
            };
            for end in ends {
                let rad = turned(end, middle);
                if rad > (TURN_WIDTHS * plan.lobes[n].width_rad()).min(TURN_RAD) {
                    return None;
                }
                about[1] = about[1].max(1.1 * rad);
                about[0] = about[0].max(1.1 * end.centres[n].position.raw().distance(centre.position.raw()));
            }
            let [a, b] = ends.map(|end| end.centres[n].position.raw());
            let [u, v] = ends.map(|end| end.centres[n].velocity.raw() * lasts_s);
            let (s, rest) = (share, 1.0 - share);
            let cubic = a + (b - a) * (s * s * (3.0 - 2.0 * s)) + (u * rest - v * s) * (s * rest);
            let off_rad = TAU / self.radar.wavelength_m() * cubic.distance(centre.position.raw());
            if off_rad.is_nan() || off_rad > PHASE_RAD {
                return None;
            }
        }
        Some(about)
    }
}

impl Lit {
    fn push<'a>(&mut self, place: Point<Enu>, pairs: impl Iterator<Item = &'a AsSeen>, i: usize) {
        let n = self.count;
        for (row, c) in self.places.iter_mut().zip(place.to_array()) {
            row[n] = c;
        }
        for (own, seen) in self.pairs.iter_mut().zip(pairs) {
            for (row, c) in own.velocities.iter_mut().zip(seen.velocities_mps[i]) {
                row[n] = c;
            }
            let matrix: &Matrix = &seen.matrices[i];
            let rows = own.matrix.as_flattened_mut().as_flattened_mut().iter_mut();
            for (row, part) in rows.zip(matrix.as_flattened().as_flattened()) {
                row[n] = *part;
            }
        }
        self.count += 1;
    }

    /// Places from somewhere, m.
    fn from(&self, from: DVec3) -> [Row; 3] {
        let mut out = [[0.0; LANES]; 3];
        for (axis, row) in out.iter_mut().enumerate() {
            for i in 0..self.count {
                row[i] = (self.places[axis][i] - from[axis]) as f32;
            }
        }
        out
    }
}

impl Making<'_> {
    fn ends(&self, plan: &PairPlan) -> [usize; 2] {
        plan.ends(self.of.radar.transmitters.len())
    }

    fn middle(&self) -> &Emission {
        &self.emissions[self.emissions.len() / 2]
    }

    /// Which cells any pair may see in the stretch, by where they are in its middle: 0 of others.
    fn kept(&self, slot: i64, cells: &Cells, range: Range<usize>) -> Row {
        let (count, places) = (range.len(), &cells.places[range.clone()]);
        let for_s = self.elapsed_s[self.emissions.len() / 2] - FarPlan::middle_s(slot);
        let of_middle = self.emissions.len() / 2 * self.of.plans.len();
        let mut any = [0.0; LANES];
        for (pair, (plan, seen)) in self.of.plans.iter().zip(&cells.pairs).enumerate() {
            let velocities_mps = &seen.velocities_mps[range.clone()];
            let mut own = [1.0; LANES];
            let mut ways_m = [0.0; LANES];
            let window = self.reception.window(plan);
            for (n, end) in self.ends(plan).into_iter().enumerate() {
                let centre = self.middle().centres[end].position.raw();
                let mut rows = [[0.0; LANES]; 3];
                for (i, (place, velocity_mps)) in places.iter().zip(velocities_mps).enumerate() {
                    let way = place.raw() - centre;
                    for c in 0..3 {
                        rows[c][i] = (way[c] + f64::from(velocity_mps[c]) * for_s) as f32;
                    }
                }
                let outlook = &self.outlooks[of_middle + pair][n];
                let mut length_m = [0.0; LANES];
                let slack_rad = |length_m: &Row| {
                    let nearest_m = length_m[..count].iter().fold(f32::INFINITY, |a, b| a.min(*b));
                    let beside = self.about[0] / f64::from(nearest_m).max(f64::MIN_POSITIVE);
                    let moved = if beside < 1.0 { beside.asin() } else { std::f64::consts::PI };
                    moved + self.about[1] + outlook.turned_rad(window.close_s)
                };
                outlook.keep(&self.plan.lobes[end], (count, &rows), slack_rad, &mut length_m, &mut own);
                for i in 0..count {
                    ways_m[i] += length_m[i];
                }
            }
            let slack_s = 2.0 * self.about[0] / SPEED_OF_LIGHT_MPS;
            let most = window.close_s + window.guard_s + slack_s - self.reception.offset_s;
            let least = window.open_s - window.guard_s - window.pulse_s - slack_s - self.reception.offset_s;
            for i in 0..count {
                let delay_s = f64::from(ways_m[i]) / SPEED_OF_LIGHT_MPS;
                if own[i] != 0.0 && (least..=most).contains(&delay_s) {
                    any[i] = 1.0;
                }
            }
        }
        any
    }

    /// Hands over the cells that were gathered for some pulses of the block.
    fn hand_over(
        &self,
        slot: i64,
        pulses: Range<usize>,
        buffers: &mut Buffers,
        each: &mut impl FnMut(&Tile),
    ) {
        if buffers.lit.count == 0 {
            return;
        }
        buffers.tile.count = buffers.lit.count;
        buffers.tile.take(pulses.clone());
        let mut smooth = true;
        for (pair, plan) in self.of.plans.iter().enumerate() {
            self.at_nodes((pair, plan), slot, buffers);
            smooth &= self.is_smooth(&buffers.tile, pair);
        }
        // Two pulses are both exact.
        if !smooth && pulses.len() > 2 {
            let middle = pulses.start + pulses.len() / 2;
            for half in [pulses.start..middle, middle..pulses.end] {
                self.hand_over(slot, half, buffers, each);
            }
            return;
        }
        for (pair, plan) in self.of.plans.iter().enumerate() {
            self.at_pulses((pair, plan), slot, pulses.clone(), buffers);
        }
        each(&buffers.tile);
    }

    /// Paths and amplitudes of a pair at both ends.
    fn at_nodes(&self, (pair, plan): (usize, &PairPlan), slot: i64, buffers: &mut Buffers) {
        let (of, variant) = (self.of, Variant::fastest());
        let Buffers { lit, view, batch, tile } = buffers;
        let (count, [tx, rx]) = (lit.count, self.ends(plan));
        let own = &lit.pairs[pair];
        batch.count = count;
        batch.slope.iter_mut().for_each(|row| row.fill(0.0));
        let nodes = tile.instants.nodes;
        for (node, &pulse) in nodes.iter().enumerate().take(tile.instants.node_count) {
            let Some((paths, epoch)) = tile.pairs[pair].at_node(node) else { continue };
            let place = pulse - self.start;
            let emission = &self.emissions[place];
            let for_s = self.elapsed_s[place] - FarPlan::middle_s(slot);
            let ends = [tx, rx].map(|end| End::from(&emission.centres[end]));
            variant.run(Solve { paths, lit, velocities: &own.velocities, for_s, ends: &ends });
            (batch.incident, batch.scattered) = (paths.incident, paths.scattered);
            (view.incident, view.scattered, view.leg_m) = (paths.incident, paths.scattered, paths.leg_m);
            for i in 0..LANES {
                view.delay_s[i] = paths.delay_s[i] as f32;
            }
            batch.matrix = own.matrix;
            variant.run(OnRays(batch));
            let bases = [tx, rx].map(|end| of.basis_of(emission, end));
            variant.run(OntoPorts { bases: &bases, view, batch });
            let mut scale = [0.0; LANES];
            variant.run(Scale { link: plan.link.in_air(), footprint_m2: 1.0, view, batch, out: &mut scale });
            of.combine(variant, plan, (batch, view), &scale, epoch);
        }
    }

    /// Whether delays of a pair are cubics and amplitudes straight lines from end to end.
    fn is_smooth(&self, tile: &Tile, pair: usize) -> bool {
        let [begin, end] = tile.pairs[pair].nodes() else { return true };
        let most_m = PHASE_RAD * self.of.radar.wavelength_m() / TAU;
        (0..tile.count).all(|i| {
            let vector = |rows: &[Row; 3]| DVec3::from_array([0, 1, 2].map(|c| f64::from(rows[c][i])));
            let ways = |of: &Paths| [vector(&of.incident), vector(&of.scattered)];
            let (from, to) = (ways(&begin.paths), ways(&end.paths));
            let mut off_m = 0.0;
            for way in 0..2 {
                let leg_m = f64::from(begin.paths.leg_m[way][i]);
                off_m += 9.0 / 384.0 * leg_m * from[way].distance_squared(to[way]).powi(2);
            }
            off_m <= most_m && (0..2).all(|way| is_straight(from[way], to[way]))
        })
    }

    /// Gains, envelope, horizons and main lobes of a pair at every pulse.
    fn at_pulses(
        &self,
        (pair, plan): (usize, &PairPlan),
        slot: i64,
        pulses: Range<usize>,
        buffers: &mut Buffers,
    ) {
        let (of, pairs) = (self.of, self.of.plans.len());
        let Buffers { lit, tile, .. } = buffers;
        let (count, ends) = (lit.count, self.ends(plan));
        let own = &mut tile.pairs[pair];
        let mut delay_s = [0.0; LANES];
        if let [node, ..] = own.nodes() {
            for i in 0..count {
                delay_s[i] = node.paths.delay_s[i] as f32;
            }
        }
        let centres = ends.map(|end| self.middle().centres[end].position.raw());
        let places = centres.map(|centre| lit.from(centre));
        let last = self.emissions.len() - 1;
        let passes = ends.map(|end| {
            let at = [0, last].map(|pulse| self.emissions[pulse].centres[end].position);
            Passes::new(of, at, &lit.places, count)
        });
        for (row, place) in own.factor[pulses.clone()].iter_mut().zip(pulses.start - self.start..) {
            let envelope = FarPlan::envelope(slot, self.elapsed_s[place]);
            row.fill(envelope as f32);
            if envelope == 0.0 {
                continue;
            }
            let for_s = (self.elapsed_s[place] - FarPlan::middle_s(slot)) as f32;
            for (n, end) in ends.into_iter().enumerate() {
                let outlook = &self.outlooks[place * pairs + pair][n];
                let moves = Some((&lit.pairs[pair].velocities, for_s));
                let delay_s = (n == 1).then_some(&delay_s);
                let cells = Towards { count, places: &places[n], moves, delay_s };
                outlook.weigh(of, &self.plan.lobes[end], cells, row);
                if let Some(passes) = &passes[n] {
                    passes.weigh(place as f32 / last.max(1) as f32, row);
                }
            }
        }
    }
}

/// Whether a direction turns so little that matrices are straight lines: by 0.03 rad, and H and V with it by
/// as much about the vertical.
fn is_straight(from: DVec3, to: DVec3) -> bool {
    let level = (from.x * from.x + from.y * from.y).min(to.x * to.x + to.y * to.y);
    from.distance_squared(to) <= STRAIGHT_RAD * STRAIGHT_RAD * level.min(1.0)
}

/// Paths over cells at a node.
struct Solve<'a> {
    paths: &'a mut Paths,
    lit: &'a Lit,
    velocities: &'a [Row; 3],
    /// Since their life was half over.
    for_s: f64,
    ends: &'a [End; 2],
}

impl Task for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { paths, lit, velocities, for_s, ends } = self;
        for axis in 0..3 {
            let (places, moves) = (&lit.places[axis], &velocities[axis]);
            for i in 0..LANES {
                paths.position_m[axis][i] = places[i] + f64::from(moves[i]) * for_s;
                paths.velocity_mps[axis][i] = moves[i];
            }
        }
        paths.solve(lit.count, &ends[0], &ends[1]);
    }
}
