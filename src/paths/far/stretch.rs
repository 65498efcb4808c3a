//! The far sea over a stretch of pulses: exact paths at its nodes, and in between only what changes fast.
//!
//! Cells run straight on, so that delays and matrices are cubics through the nodes, as those of breaking
//! waves are ([`crate::paths::spikes::stretch`], by whose limits a stretch is made shorter). Gains,
//! envelopes, horizons and main lobes are found at every pulse and multiply the amplitude.

use glam::DVec3;
use num_complex::Complex64;

use super::FarPlan;
use super::scatterer::{Scatterer, Seen};
use super::squares::{Search, Square};
use crate::frames::Enu;
use crate::frames::Point;
use crate::geometry::horizon;
use crate::geometry::light_time::{LightTime, Path, bistatic};
use crate::paths::block::{NODES, Sight, SlowTime};
use crate::paths::emission::Emission;
use crate::paths::list::ScattererPaths;
use crate::paths::sea::{SeaFailure, SeaPlan};
use crate::paths::spikes::stretch::{PHASE_RAD, Slopes, turns};
use crate::paths::{PathGenerator, Workspace};
use crate::radar::fault::RadarError;
use crate::radar::polarisation::Axes;
use crate::units::SPEED_OF_LIGHT_MPS;

/// What antennas turn to either side of the middle of a stretch, over the width of their beams.
const TURN_WIDTHS: f64 = 1.0;

/// What the cells of a stretch are made from.
struct Making<'a> {
    of: &'a PathGenerator,
    plan: &'a FarPlan,
    sea: &'a SeaPlan,
    /// Of every pulse, and their times after pulse 0.
    emissions: &'a [Emission],
    elapsed_s: &'a [f64],
    /// Pulses of the nodes.
    nodes: &'a [usize],
    slow: &'a SlowTime,
    slopes: Slopes,
}

/// A cell as every pair of a stretch sees it.
struct Cell<'a> {
    scatterer: &'a Scatterer,
    middle_s: f64,
    slot: i64,
    places: &'a [Point<Enu>],
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
        let Workspace { other, stretch, amplitude, places, windows, .. } = workspace;
        let emissions = &mut stretch.emissions;
        emissions.resize_with(count.max(emissions.len()), Emission::default);
        for (index, emission) in (first..).zip(&mut emissions[..count]) {
            self.evaluate(index, emission)?;
        }
        let emissions = &emissions[..count];
        let Some(about) = self.about(plan, emissions) else { return Ok(false) };
        self.slow_time(first, count, &mut stretch.slow);
        stretch.elapsed_s.clear();
        stretch.elapsed_s.extend((first..).take(count).map(|index| self.radar.emissions.elapsed_s(index)));
        let elapsed_s = &stretch.elapsed_s[..];
        let middle = first + count as u64 / 2;
        self.windows_at(middle, windows)?;
        let opens_s = windows.first().map_or(0.0, |window| window.open_s);
        self.windows_at(first, windows)?;
        let moves_m =
            0.5 * SPEED_OF_LIGHT_MPS * (windows.first().map_or(0.0, |window| window.open_s) - opens_s).abs();
        self.windows_at(middle, windows)?;
        let reception = self.reception_of_all(middle, &emissions[count / 2], windows);
        let patch = sea.patch_at(&reception.surroundings, elapsed_s[0]);
        let patch = &patch.map_err(|failure| self.sea_error(first, SeaFailure::from(failure)))?;
        let made = Making {
            of: self,
            plan,
            sea,
            emissions,
            elapsed_s,
            nodes: at,
            slow: &stretch.slow,
            slopes: Slopes::through(at, &stretch.slow),
        };
        let [begin, end] = [elapsed_s[0], elapsed_s[count - 1]].map(FarPlan::slots_at);
        let mut smooth = true;
        for slot in begin[0]..=end[1] {
            let coarser = self.begin_far_slot(plan, (first, slot), other, places)?;
            let about = [about[0] + 2.0 * moves_m, about[1]];
            let (of, reception) = (self, &reception);
            let search = Search { plan, of, reception, places, coarser, slot, patch, about };
            let middle_s = FarPlan::middle_s(slot);
            search.visit(Square::ALL, &mut |found| {
                let scatterer = Scatterer::new(plan, found, self.frame.earth(), middle_s);
                let cell = Cell { scatterer: &scatterer, middle_s, slot, places };
                smooth = made.append(&cell, nodes, amplitude, factors);
                smooth
            });
            if !smooth {
                break;
            }
        }
        // `[path][pulse][pair]` so far.
        let (paths, pairs) = (nodes[0].len(), self.plans.len());
        transpose(factors, [paths, count], pairs);
        Ok(smooth)
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

/// Turns `[path][pulse]` groups of so many into `[pulse][path]`.
fn transpose(values: &mut [f64], [paths, pulses]: [usize; 2], size: usize) {
    let before = values.to_owned();
    for path in 0..paths {
        for pulse in 0..pulses {
            let (from, to) = ((path * pulses + pulse) * size, (pulse * paths + path) * size);
            values[to..to + size].copy_from_slice(&before[from..from + size]);
        }
    }
}

impl Making<'_> {
    /// Appends a cell at the nodes and its factors, `[pulse][pair]`; returns whether it is smooth.
    fn append(
        &self,
        cell: &Cell,
        nodes: &mut [ScattererPaths],
        amplitude: &mut [Complex64],
        factors: &mut Vec<f64>,
    ) -> bool {
        let Self { of, emissions, slow, .. } = *self;
        let (pairs, count, from) = (of.plans.len(), emissions.len(), factors.len());
        factors.resize(from + count * pairs, 0.0);
        let (mut any, mut smooth) = (false, true);
        let last = self.nodes[self.nodes.len() - 1];
        for (pair, plan) in of.plans.iter().enumerate() {
            let ends = [plan.pair.transmitter, of.radar.transmitters.len() + plan.pair.receiver];
            let seen = cell.scatterer.seen(self.plan, self.sea, ends.map(|end| cell.places[end]));
            let mut paths = [Path::default(); NODES];
            for (path, &place) in paths.iter_mut().zip(self.nodes) {
                let [tx, rx] = ends.map(|end| &emissions[place].centres[end]);
                let position = cell.scatterer.place + seen.velocity * (self.elapsed_s[place] - cell.middle_s);
                *path = bistatic(LightTime::Exact, tx, position, seen.velocity, rx);
            }
            let paths = &paths[..self.nodes.len()];
            let lasts = slow.at(last) - slow.at(self.nodes[0]);
            let off_s = self.slopes.off_s(paths, of.radar.emissions.mean_pri_s());
            let off_rad = std::f64::consts::TAU * of.radar.carrier_hz * lasts / 18.0 * off_s;
            smooth &= off_rad <= PHASE_RAD && !turns(&paths[0], &paths[paths.len() - 1]);
            for pulse in 0..count {
                let factor = self.factor(cell, &seen, ends, (pulse, paths[0].delay_s));
                factors[from + pulse * pairs + pair] = factor;
                any |= factor != 0.0;
            }
            for ((node, path), &place) in nodes.iter_mut().zip(paths).zip(self.nodes) {
                node.delay_s[pair].push(path.delay_s);
                node.delay_rate[pair].push(path.delay_rate);
                amplitude.fill(Complex64::ZERO);
                let scale = Complex64::from(plan.link.scattered_over(path));
                let emission = &emissions[place];
                of.polarised(plan, (path, None), Some(&seen.matrix), scale, None, emission, amplitude);
                for (channel, ..) in &plan.channels {
                    node.amplitude[*channel].push(amplitude[*channel]);
                }
            }
        }
        if any {
            nodes.iter_mut().for_each(|node| node.emission_offset_s.push(0.0));
        } else {
            let before = nodes[0].len();
            nodes.iter_mut().for_each(|node| node.resize(before));
            factors.truncate(from);
        }
        smooth || !any
    }

    /// Gains, envelope, horizons and main lobes of a cell at a pulse.
    fn factor(&self, cell: &Cell, seen: &Seen, ends: [usize; 2], (pulse, delay_s): (usize, f64)) -> f64 {
        let Self { of, plan, emissions, elapsed_s, .. } = *self;
        let envelope = FarPlan::envelope(cell.slot, elapsed_s[pulse]);
        if envelope == 0.0 {
            return 0.0;
        }
        let emission = &emissions[pulse];
        let [x, y, _] = cell.scatterer.place.to_array();
        let level = DVec3::new(x, y, -of.frame.earth().drop_m(x, y));
        let place = (cell.scatterer.place + seen.velocity * (elapsed_s[pulse] - cell.middle_s)).raw();
        let earth = of.frame.hiding_earth();
        let ways = ends.map(|end| level - emission.centres[end].position.raw());
        let lobe_s = (ways[0].length() + ways[1].length()) / SPEED_OF_LIGHT_MPS;
        let mut factor = envelope;
        for (n, end) in ends.into_iter().enumerate() {
            let centre = &emission.centres[end];
            let axes = |delay_s: f64| -> Axes {
                if n == 0 { emission.axes(end) } else { emission.axes_after(end, delay_s, of.axes_span_s) }
            };
            let in_lobe = plan.lobes[end].holds(axes(lobe_s).transpose() * ways[n], 0.0);
            if !in_lobe {
                return 0.0;
            }
            let after_s = if n == 0 { 0.0 } else { delay_s };
            let position = centre.position.raw() + centre.velocity.raw() * after_s;
            let sight = Sight::of(&of.antennas[end], position, axes(delay_s));
            factor *= sight.gain(&of.antennas[end], (place - position).normalize_or_zero());
            factor *= horizon::weight(
                horizon::clearance_m(earth, centre.position, cell.scatterer.place),
                horizon::POINT_EDGE_M,
            );
        }
        factor
    }
}
