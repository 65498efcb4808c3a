//! The far sea over a stretch of pulses: exact paths at its nodes, and in between only what changes fast.
//!
//! Cells run straight on, so that delays and amplitudes are cubics through the nodes, as those of breaking
//! waves are ([`crate::paths::spikes::stretch`], by whose limits a stretch is made shorter). Gains,
//! envelopes, horizons and main lobes ([`super::gains`]) are found at every pulse and multiply the amplitude.
//! Cells are gathered from their lots, as many as are side by side at a time.

// Lanes are counted: so they become vectors.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use glam::DVec3;
use num_complex::{Complex32, Complex64};

use super::cells::{AsSeen, Cells, Maker, Matrix};
use super::gains::{Outlook, Passes, Towards};
use super::squares::{Search, Split, Square, is_on};
use super::{FASTEST_MPS, FarPlan, Work};
use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::geometry::lanes::{End, LANES, Paths, Row, WideRow, lanes_for};
use crate::paths::block::{InRain, NODES, OnRays, OntoPorts, Scale, SlowTime, View, port_products};
use crate::paths::emission::Emission;
use crate::paths::facets::Reception;
use crate::paths::list::ScattererPaths;
use crate::paths::sea::SeaFailure;
use crate::paths::spikes::stretch::{PHASE_RAD, Slopes, turns};
use crate::paths::{PairPlan, PathGenerator, Workspace};
use crate::radar::fault::RadarError;
use crate::scattering::lanes::Batch;
use crate::units::SPEED_OF_LIGHT_MPS;

/// What antennas turn to either side of the middle of a stretch, over the width of their beams.
const TURN_WIDTHS: f64 = 0.55;

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
    paths: Vec<Box<Paths>>,
    view: Box<View>,
    batch: Box<Batch>,
    /// What multiplies amplitudes, `[pulse][cell][pair]` of every batch, and cells of each.
    factors: Vec<f64>,
    counts: Vec<usize>,
}

impl Buffers {
    pub fn new(pairs: usize) -> Self {
        let row = [0.0; LANES];
        let pair = LitPair { velocities: [row; 3], matrix: [[[row; 2]; 2]; 2] };
        Self {
            lit: Lit { count: 0, places: [[0.0; LANES]; 3], pairs: vec![pair; pairs] },
            paths: (0..NODES).map(|_| Paths::boxed()).collect(),
            view: View::boxed(),
            batch: Batch::boxed(0),
            factors: Vec::new(),
            counts: Vec::new(),
        }
    }
}

/// What the cells of a stretch are made from.
struct Making<'a> {
    of: &'a PathGenerator,
    plan: &'a FarPlan,
    /// Of every pulse, and their times after pulse 0.
    emissions: &'a [Emission],
    elapsed_s: &'a [f64],
    /// Pulses of the nodes.
    nodes: &'a [usize],
    slow: &'a SlowTime,
    slopes: Slopes,
    /// What antennas, windows and cells move and what antennas turn about the middle, m and rad.
    about: [f64; 2],
    reception: &'a Reception<'a>,
    /// `[pulse][pair]`.
    outlooks: &'a [[Outlook; 2]],
}

impl PathGenerator {
    /// Fills `nodes` with the far sea of some pulses at some of them, counted from the first, and `factors`,
    /// `[pulse][path][pair]`, with what multiplies the amplitudes; returns whether they are smooth enough and
    /// the beams turn no further than a stretch allows.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover.
    pub fn far_sea_of_stretch(
        &self,
        (first, count): (u64, usize),
        at: &[usize],
        workspace: &mut Workspace,
        nodes: &mut [ScattererPaths],
        factors: &mut Vec<f64>,
    ) -> Result<bool, RadarError> {
        nodes.iter_mut().for_each(ScattererPaths::clear);
        factors.clear();
        let (Some(plan), Some(sea), true) = (&self.far, &self.sea, self.gains_are_real()) else {
            return Ok(false);
        };
        let Workspace { other, stretch, places, windows, far, .. } = workspace;
        let emissions = &mut stretch.emissions;
        emissions.resize_with(count.max(emissions.len()), Emission::default);
        for (index, emission) in (first..).zip(&mut emissions[..count]) {
            self.evaluate(index, emission)?;
        }
        let emissions = &emissions[..count];
        let Some(mut about) = self.about(plan, emissions) else { return Ok(false) };
        self.slow_time(first, count, &mut stretch.slow);
        stretch.elapsed_s.clear();
        stretch.elapsed_s.extend((first..).take(count).map(|index| self.radar.emissions.elapsed_s(index)));
        let elapsed_s = &stretch.elapsed_s[..];
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
        let slow = &stretch.slow;
        let slopes = Slopes::through(at, slow);
        let Work { room, stretch: buffers, outlooks } =
            far.get_or_insert_with(|| Work::new(sea, self.plans.len()));
        outlooks.clear();
        for (emission, plan) in emissions.iter().flat_map(|it| self.plans.iter().map(move |plan| (it, plan)))
        {
            outlooks.push(Outlook::of_pair(self, plan, emission, &emissions[count / 2]));
        }
        let made = Making {
            of: self,
            plan,
            emissions,
            elapsed_s,
            nodes: at,
            slow,
            slopes,
            about,
            reception,
            outlooks,
        };
        buffers.factors.clear();
        buffers.counts.clear();
        let [begin, end] = [elapsed_s[0], elapsed_s[count - 1]].map(FarPlan::slots_at);
        for slot in begin[0]..=end[1] {
            let coarser = self.begin_far_slot(plan, (first, slot), other, places)?;
            let split = Split { plan, of: self, places, coarser, slot };
            let search = Search { split, reception, patch, about };
            let maker = Maker { split, sea, middle_s: FarPlan::middle_s(slot) };
            let mut gather = |cells: &Cells| {
                let (mut from, mut smooth) = (0, true);
                while smooth && from < cells.places.len() {
                    let until = (from + LANES).min(cells.places.len());
                    let kept = made.kept(slot, cells, from..until);
                    for (i, place) in (from..until).zip(&cells.places[from..until]) {
                        let [x, y, _] = place.to_array();
                        if kept[i - from] == 0.0 || is_on(patch, [x, y]) {
                            continue;
                        }
                        buffers.lit.push(*place, cells.pairs.iter(), i);
                        if buffers.lit.count == LANES {
                            smooth &= made.append(slot, buffers, nodes);
                        }
                    }
                    from = until;
                }
                smooth
            };
            let mut smooth = search.lots(Square::ALL, &mut |lot| {
                plan.lots.with((slot, lot), || maker.lot(lot, room), &mut gather)
            });
            smooth = smooth && made.append(slot, buffers, nodes);
            buffers.lit.count = 0;
            if !smooth {
                return Ok(false);
            }
        }
        buffers.by_pulse(count, self.plans.len(), factors);
        Ok(true)
    }

    /// How far antennas move, m, and turn, rad, about the middle of some emissions; `None` where they turn
    /// too far.
    fn about(&self, plan: &FarPlan, emissions: &[Emission]) -> Option<[f64; 2]> {
        let middle = &emissions[emissions.len() / 2];
        let ends = [&emissions[0], &emissions[emissions.len() - 1]];
        let mut about = [0.0f64; 2];
        for (n, centre) in middle.centres.iter().enumerate() {
            for end in ends {
                let turned = (0..3).map(|axis| end.axes(n).col(axis).distance(middle.axes(n).col(axis)));
                let rad = turned.fold(0.0, f64::max);
                if rad > TURN_WIDTHS * plan.lobes[n].width_rad() {
                    return None;
                }
                about[1] = about[1].max(1.1 * rad);
                about[0] = about[0].max(1.1 * end.centres[n].position.raw().distance(centre.position.raw()));
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

impl Buffers {
    /// Factors of all batches, `[pulse][path][pair]`.
    fn by_pulse(&self, pulses: usize, pairs: usize, factors: &mut Vec<f64>) {
        for pulse in 0..pulses {
            let mut begin = 0;
            for count in self.counts.iter().map(|cells| cells * pairs) {
                let from = begin + pulse * count;
                factors.extend_from_slice(&self.factors[from..from + count]);
                begin += pulses * count;
            }
        }
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

    /// Appends the cells that were gathered at the nodes, and their factors; returns whether they are smooth.
    fn append(&self, slot: i64, buffers: &mut Buffers, nodes: &mut [ScattererPaths]) -> bool {
        let count = buffers.lit.count;
        if count == 0 {
            return true;
        }
        let (pairs, pulses, from) = (self.of.plans.len(), self.emissions.len(), buffers.factors.len());
        buffers.counts.push(count);
        buffers.factors.resize(from + pulses * count * pairs, 0.0);
        let mut smooth = true;
        for (pair, plan) in self.of.plans.iter().enumerate() {
            smooth &= self.at_nodes((pair, plan), slot, buffers, nodes);
            self.at_pulses((pair, plan), slot, buffers, from);
        }
        for node in nodes {
            node.emission_offset_s.resize(node.delay_s[0].len(), 0.0);
        }
        buffers.lit.count = 0;
        smooth
    }

    /// Paths and amplitudes of a pair at the nodes.
    fn at_nodes(
        &self,
        (pair, plan): (usize, &PairPlan),
        slot: i64,
        buffers: &mut Buffers,
        nodes: &mut [ScattererPaths],
    ) -> bool {
        let (of, variant) = (self.of, Variant::fastest());
        let Buffers { lit, paths, view, batch, .. } = buffers;
        let (count, [tx, rx]) = (lit.count, self.ends(plan));
        let own = &lit.pairs[pair];
        batch.count = count;
        batch.slope.iter_mut().for_each(|row| row.fill(0.0));
        for ((paths, &place), node) in paths.iter_mut().zip(self.nodes).zip(nodes) {
            let emission = &self.emissions[place];
            let for_s = self.elapsed_s[place] - FarPlan::middle_s(slot);
            let ends = [tx, rx].map(|end| End::from(&emission.centres[end]));
            variant.run(Solve { paths, lit, velocities: &own.velocities, for_s, ends: &ends });
            node.delay_s[pair].extend_from_slice(&paths.delay_s[..count]);
            node.delay_rate[pair].extend_from_slice(&paths.delay_rate[..count]);
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
            let isolations_db = [
                of.radar.transmitters[plan.pair.transmitter].antenna.cross_pol_isolation_db,
                of.radar.receivers[plan.pair.receiver].antenna.cross_pol_isolation_db,
            ];
            for &(channel, tx_port, rx_port) in &plan.channels {
                let products = port_products([tx_port, rx_port], isolations_db);
                let mut in_rain = scale;
                if let Some(rain) = plan.link.lanes_in_rain() {
                    let ports = [tx_port, rx_port];
                    variant.run(InRain { rain, ports, view, scale: &scale, count, out: &mut in_rain });
                }
                let mut sums = [[0.0; LANES]; 2];
                variant.run(Between { products, batch, scale: &in_rain, out: &mut sums });
                let amplitudes = sums[0].iter().zip(&sums[1]).take(count);
                node.amplitude[channel]
                    .extend(amplitudes.map(|(re, im)| Complex64::new((*re).into(), (*im).into())));
            }
        }
        self.is_smooth(&paths[..self.nodes.len()], count)
    }

    /// Whether delays and matrices are cubics through the nodes.
    fn is_smooth(&self, paths: &[Box<Paths>], count: usize) -> bool {
        let last = self.nodes[self.nodes.len() - 1];
        let lasts = self.slow.at(last) - self.slow.at(self.nodes[0]);
        let (mean_pri_s, carrier_hz) = (self.of.radar.emissions.mean_pri_s(), self.of.radar.carrier_hz);
        let most_s = PHASE_RAD / (std::f64::consts::TAU * carrier_hz * lasts / 18.0);
        let [begin, end] = [&paths[0], &paths[paths.len() - 1]];
        (0..count).all(|i| {
            let values = |of: &Paths| (of.delay_s[i], of.delay_rate[i]);
            let vector = |rows: &[Row; 3]| DVec3::from_array([0, 1, 2].map(|c| f64::from(rows[c][i])));
            self.slopes.off_s(paths.iter().map(|paths| values(paths)), mean_pri_s) <= most_s
                && !turns(vector(&begin.incident), vector(&end.incident))
                && !turns(vector(&begin.scattered), vector(&end.scattered))
        })
    }

    /// Gains, envelope, horizons and main lobes of a pair at every pulse.
    fn at_pulses(&self, (pair, plan): (usize, &PairPlan), slot: i64, buffers: &mut Buffers, from: usize) {
        let (of, pairs) = (self.of, self.of.plans.len());
        let Buffers { lit, paths, factors, .. } = buffers;
        let (count, ends) = (lit.count, self.ends(plan));
        let mut delay_s = [0.0; LANES];
        for i in 0..count {
            delay_s[i] = paths[0].delay_s[i] as f32;
        }
        let centres = ends.map(|end| self.middle().centres[end].position.raw());
        let places = centres.map(|centre| lit.from(centre));
        let last = self.emissions.len() - 1;
        let passes = ends.map(|end| {
            let at = [0, last].map(|pulse| self.emissions[pulse].centres[end].position);
            Passes::new(of, at, &lit.places, count)
        });
        for pulse in 0..self.emissions.len() {
            let envelope = FarPlan::envelope(slot, self.elapsed_s[pulse]);
            if envelope == 0.0 {
                continue;
            }
            let for_s = (self.elapsed_s[pulse] - FarPlan::middle_s(slot)) as f32;
            let mut row = [envelope as f32; LANES];
            for (n, end) in ends.into_iter().enumerate() {
                let outlook = &self.outlooks[pulse * pairs + pair][n];
                let moves = Some((&lit.pairs[pair].velocities, for_s));
                let delay_s = (n == 1).then_some(&delay_s);
                let cells = Towards { count, places: &places[n], moves, delay_s };
                outlook.weigh(of, &self.plan.lobes[end], cells, &mut row);
                if let Some(passes) = &passes[n] {
                    passes.weigh(pulse as f32 / last.max(1) as f32, &mut row);
                }
            }
            let begin = from + pulse * count * pairs + pair;
            for (factor, own) in factors[begin..].iter_mut().step_by(pairs).zip(&row[..count]) {
                *factor = f64::from(*own);
            }
        }
    }
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

/// Amplitudes between two ports.
struct Between<'a> {
    products: [[Complex32; 2]; 2],
    batch: &'a Batch,
    scale: &'a Row,
    out: &'a mut [Row; 2],
}

impl Task for Between<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { products, batch, scale, out: [re, im] } = self;
        let n = lanes_for(batch.count);
        for row in 0..2 {
            for column in 0..2 {
                let [a, b] = &batch.matrix[row][column];
                let weight = products[row][column];
                for i in 0..n {
                    re[i] += weight.re * a[i] - weight.im * b[i];
                    im[i] += weight.re * b[i] + weight.im * a[i];
                }
            }
        }
        for i in 0..n {
            (re[i], im[i]) = (re[i] * scale[i], im[i] * scale[i]);
        }
    }
}
