//! Scatterer paths side by side, spread without being listed.
//!
//! A [`Batch`] has the scatterer paths of one pair as rows of [`LANES`]: delay and rate at the nodes of a
//! block, amplitudes at its scattering epochs, and a factor for every pulse. Between two nodes phase and
//! place are Hermite cubics of `s = (t - t_0)/(t_1 - t_0)`,
//!
//! `f = f_0 + s d_0 + s^2 (3 D - 2 d_0 - d_1) + s^3 (d_0 + d_1 - 2 D)`, `D = f_1 - f_0`,
//! `d = f' (t_1 - t_0)`,
//!
//! in f64, held as in [`block`](super::block); amplitudes are one polynomial through four scattering epochs.
//! What Doppler off the mean adds to phase and place is linear between nodes. It is the same echo as that of
//! [`Synth::fill`], but for these polynomials.
//!
//! **Error** of a delay between nodes `T` apart: `max |tau''''| T^4 / 384`; of amplitudes, as there.

use std::ops::Range;

use super::Synth;
use super::block::{FAR_CELLS, Frame, MAX_NODES, Through};
use super::grid::{Grids, Lined};
use super::spread::{Courses, Job};
use crate::cpu::Task;
use crate::geometry::lanes::{LANES, Row, WideRow, lanes_for};

/// Scatterer paths at a node.
#[derive(Clone, Copy)]
pub struct BatchNode<'a> {
    /// Delay, s.
    pub delay_s: &'a WideRow,
    /// Its derivative by the time of emission.
    pub delay_rate: &'a WideRow,
}

/// Amplitudes at some pulse of a block.
#[derive(Clone, Copy)]
pub struct BatchEpoch<'a> {
    /// Pulse within the block.
    pub pulse: usize,
    /// Per channel of the pair: sqrt(W), real and imaginary.
    pub amplitude: &'a [[Row; 2]],
}

/// Scatterer paths of one pair side by side.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    /// The pair.
    pub pair: usize,
    /// How many lanes are in use.
    pub count: usize,
    /// One to four, at the pulses given beside.
    pub nodes: [Option<BatchNode<'a>>; MAX_NODES],
    /// Pulses of the nodes within the block, rising.
    pub places: [usize; MAX_NODES],
    /// Between two nodes amplitudes go through the scattering epochs from the given one on, up to four:
    /// `[interval]`.
    pub from_epoch: [usize; MAX_NODES],
    /// At least one, rising.
    pub epochs: &'a [BatchEpoch<'a>],
    /// Per pulse of the block.
    pub factor: &'a [Row],
    /// Time from pulse to pulse, s.
    pub interval_s: f64,
}

/// Room to work; one per thread.
#[derive(Debug, Default)]
pub struct LaneWork {
    courses: Courses<f32>,
    /// `[layer][epoch]`: amplitudes scatterer path by scatterer path.
    epochs: Vec<Vec<Lined<f32>>>,
    /// `[layer][power]`.
    amplitude: Vec<[Lined<f32>; MAX_NODES]>,
    factors: Vec<f32>,
    shifts: Vec<(i32, f32)>,
    /// Powers of the amplitudes at hand, 2 or 4, and the pair's mean Doppler.
    powers: usize,
    mean_hz: f64,
}

/// A quantity at both ends of an interval.
#[derive(Clone, Copy)]
struct Ends<'a> {
    delay_s: [&'a WideRow; 2],
    delay_rate: [&'a WideRow; 2],
}

impl Synth<f32> {
    /// Makes room for any batch of a block of so many pulses with so many scattering epochs: later ones may
    /// have more of everything than the first.
    pub fn make_room(&self, epochs: usize, pulses: usize, work: &mut LaneWork) {
        fn reserve<T>(column: &mut Vec<T>, room: usize) {
            column.reserve(room.saturating_sub(column.len()));
        }
        let LaneWork { courses, epochs: turned, amplitude, factors, shifts, .. } = work;
        turned.resize_with(self.layers.len(), Vec::new);
        amplitude.resize_with(self.layers.len(), Default::default);
        for ((layer, turned), powers) in self.layers.iter().zip(turned).zip(amplitude) {
            turned.resize_with(epochs.max(turned.len()), Lined::default);
            turned.iter_mut().chain(powers).for_each(|column| column.fit(LANES * layer.lanes));
        }
        courses.phase.iter_mut().for_each(|column| reserve(column, LANES));
        courses.place.iter_mut().for_each(|column| reserve(column, LANES));
        reserve(&mut courses.phase_cubic, LANES);
        reserve(&mut courses.base, LANES);
        reserve(factors, LANES * pulses);
        reserve(shifts, pulses);
    }

    /// Spreads a batch on the grids of its block.
    pub fn spread_lanes(
        &self,
        batch: &Batch<'_>,
        frame: &Frame,
        work: &mut LaneWork,
        grids: &mut Grids<f32>,
    ) {
        let count = batch.count.min(LANES);
        let nodes = batch.nodes.iter().flatten().count();
        if nodes == 0 || count == 0 {
            return;
        }
        let pulses = frame.pulses();
        let middle = (pulses / 2) as i32;
        work.mean_hz = frame.mean_hz[batch.pair];
        self.turn_epochs(batch, work);
        let mut at = None;
        for interval in 0..nodes.saturating_sub(1).max(1) {
            let last = interval + 2 >= nodes;
            let from = batch.places[interval];
            let to = if nodes == 1 { pulses } else { batch.places[interval + 1] + usize::from(last) };
            let (from, to) = (if interval == 0 { 0 } else { from }, if last { pulses } else { to });
            if from < to {
                let first = batch.from_epoch[interval].min(batch.epochs.len().saturating_sub(1));
                if at != Some(first) {
                    let epochs = first..batch.epochs.len().min(first + MAX_NODES);
                    self.lane_amplitudes(batch, epochs, middle, work);
                    at = Some(first);
                }
                self.lane_interval(batch, interval, nodes, from..to, frame, work, grids);
            }
        }
    }

    /// Amplitudes of all scattering epochs, scatterer path by scatterer path.
    fn turn_epochs(&self, batch: &Batch<'_>, work: &mut LaneWork) {
        work.epochs.resize_with(self.layers.len(), Vec::new);
        for (layer, turned) in self.layers.iter().zip(&mut work.epochs) {
            if layer.pair != batch.pair {
                continue;
            }
            turned.resize_with(batch.epochs.len().max(turned.len()), Lined::default);
            // Channels of a pair stand in the order of its layers, four to a layer.
            let first = self
                .layers
                .iter()
                .filter(|other| other.pair == layer.pair && other.moment == layer.moment)
                .take_while(|other| other.channels != layer.channels)
                .map(|other| other.channels.len())
                .sum::<usize>();
            for (epoch, out) in batch.epochs.iter().zip(turned) {
                out.fit(batch.count * layer.lanes);
                let amplitude = epoch.amplitude.get(first..).unwrap_or_default();
                let amplitude = &amplitude[..amplitude.len().min(layer.channels.len())];
                let scale = layer.moment.then(|| self.moments(batch, epoch.pulse, work.mean_hz));
                let scale = scale.as_ref();
                let out = out.as_mut_slice();
                match layer.lanes {
                    2 => self.variant.run(Turned::<2> { amplitude, scale, out }),
                    4 => self.variant.run(Turned::<4> { amplitude, scale, out }),
                    _ => self.variant.run(Turned::<8> { amplitude, scale, out }),
                }
            }
        }
    }

    /// Doppler off the mean over the length of a pulse, from the node before or at a scattering epoch.
    fn moments(&self, batch: &Batch<'_>, pulse: usize, mean_hz: f64) -> Row {
        let node = batch.places.iter().zip(&batch.nodes).take_while(|(place, _)| **place <= pulse);
        let Some(node) = node.filter_map(|(_, node)| node.as_ref()).last() else { return [1.0; LANES] };
        node.delay_rate.map(|rate| ((self.carrier_hz * rate - mean_hz) * self.waveform.duration_s()) as f32)
    }

    /// Polynomials of the amplitudes through some scattering epochs.
    fn lane_amplitudes(&self, batch: &Batch<'_>, epochs: Range<usize>, middle: i32, work: &mut LaneWork) {
        let mut places = [0.0; MAX_NODES];
        for (place, epoch) in places.iter_mut().zip(&batch.epochs[epochs.clone()]) {
            *place = epoch.pulse as f64 - f64::from(middle);
        }
        let through = Through::new(&places[..epochs.len()]);
        work.powers = if epochs.len() <= 2 { 2 } else { MAX_NODES };
        let basis = through.basis.map(|row| row.map(|b| b as f32));
        work.amplitude.resize_with(self.layers.len(), Default::default);
        for ((layer, turned), held) in self.layers.iter().zip(&work.epochs).zip(&mut work.amplitude) {
            if layer.pair != batch.pair {
                continue;
            }
            let mut seen = turned[epochs.clone()].iter().map(Lined::as_slice);
            let seen: [&[f32]; MAX_NODES] = std::array::from_fn(|_| seen.next().unwrap_or_default());
            for (power, weights) in held.iter_mut().zip(&basis).take(work.powers) {
                power.fit(batch.count * layer.lanes);
                self.variant.run(Weighted { epochs: &seen, weights, out: power.as_mut_slice() });
            }
        }
    }

    fn lane_interval(
        &self,
        batch: &Batch<'_>,
        interval: usize,
        nodes: usize,
        pulses: Range<usize>,
        frame: &Frame,
        work: &mut LaneWork,
        grids: &mut Grids<f32>,
    ) {
        let LaneWork { courses, amplitude, factors, shifts, powers: in_use, .. } = work;
        let reference_s = self.fill_shifts(&frame.windows_s[pulses.clone()], shifts);
        let [Some(first), other] = [batch.nodes[interval], batch.nodes[(interval + 1).min(nodes - 1)]] else {
            return;
        };
        let second = other.unwrap_or(first);
        let count = batch.count;
        courses.phase.iter_mut().for_each(|p| p.resize(count, 0));
        courses.phase_cubic.resize(count, 0.0);
        courses.base.resize(count, 0);
        courses.place.iter_mut().for_each(|p| p.resize(count, 0.0));
        let middle = pulses.start + pulses.len() / 2;
        let length = if nodes == 1 { 0 } else { batch.places[interval + 1] - batch.places[interval] };
        let mean_hz = frame.mean_hz[batch.pair];
        let correction = self.correction();
        let [shifted, moved] = correction.delays();
        let task = Polynomials {
            ends: Ends {
                delay_s: [first.delay_s, second.delay_s],
                delay_rate: [first.delay_rate, second.delay_rate],
            },
            carrier_hz: self.carrier_hz,
            mean_hz,
            middle_s: correction.middle_s,
            shifted,
            moved,
            before_s: self.lead_s - reference_s,
            cells_per_s: self.cells_per_s,
            interval_s: batch.interval_s,
            length: length as f64,
            middle: middle as f64 - batch.places[interval] as f64,
            count,
            courses: &mut *courses,
        };
        self.variant.run(task);
        factors.clear();
        for row in &batch.factor[pulses.clone()] {
            factors.extend_from_slice(&row[..count]);
        }
        let share = grids.share(pulses.start, pulses.len());
        let mut offset = 0;
        for (index, layer) in self.layers.iter().enumerate() {
            if layer.pair == batch.pair {
                let powers = amplitude[index].each_ref().map(|power| power.as_slice());
                let job = Job {
                    courses,
                    amplitude: &powers[..*in_use],
                    shifts,
                    first: pulses.start as i32 - middle as i32,
                    amplitude_first: pulses.start as i32 - (frame.pulses() / 2) as i32,
                    factors,
                    coefficients: &self.coefficients,
                    last_cell: self.last_cell,
                    outside: self.shape.outside() as i32,
                    stride: share.pulse_len,
                    offset,
                };
                (self.bodies[index])(&job, share.cells);
            }
            offset += self.shape.layer_len(index);
        }
    }
}

/// Amplitudes of a scattering epoch from channel by channel to scatterer path by scatterer path, `C` lanes
/// each; lanes without a channel are silent.
struct Turned<'a, const C: usize> {
    amplitude: &'a [[Row; 2]],
    scale: Option<&'a Row>,
    out: &'a mut [f32],
}

impl<const C: usize> Task for Turned<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        const SILENT: Row = [0.0; LANES];
        let Self { amplitude, scale, out } = self;
        let mut given = amplitude.as_flattened().iter();
        let rows: [&Row; C] = std::array::from_fn(|_| given.next().unwrap_or(&SILENT));
        let lines = out.as_chunks_mut::<C>().0.iter_mut().take(LANES).enumerate();
        match scale {
            None => {
                for (i, line) in lines {
                    for k in 0..C {
                        line[k] = rows[k][i];
                    }
                }
            }
            Some(scale) => {
                for (i, line) in lines {
                    for k in 0..C {
                        line[k] = rows[k][i] * scale[i];
                    }
                }
            }
        }
    }
}

/// A sum of scattering epochs, each with its weight.
struct Weighted<'a> {
    epochs: &'a [&'a [f32]; MAX_NODES],
    weights: &'a [f32; MAX_NODES],
    out: &'a mut [f32],
}

impl Task for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { epochs: [a, b, c, d], weights: w, out } = self;
        let n = out.len();
        match (b.len() == n, c.len() == n, d.len() == n) {
            (true, true, true) => {
                for ((((out, a), b), c), d) in out.iter_mut().zip(*a).zip(*b).zip(*c).zip(*d) {
                    *out = w[0] * a + w[1] * b + w[2] * c + w[3] * d;
                }
            }
            (true, true, _) => {
                for (((out, a), b), c) in out.iter_mut().zip(*a).zip(*b).zip(*c) {
                    *out = w[0] * a + w[1] * b + w[2] * c;
                }
            }
            (true, ..) => {
                for ((out, a), b) in out.iter_mut().zip(*a).zip(*b) {
                    *out = w[0] * a + w[1] * b;
                }
            }
            _ => {
                for (out, a) in out.iter_mut().zip(*a) {
                    *out = w[0] * a;
                }
            }
        }
    }
}

/// Phase and place between two nodes.
struct Polynomials<'a> {
    ends: Ends<'a>,
    carrier_hz: f64,
    mean_hz: f64,
    middle_s: f64,
    /// Delay per Hz of Doppler off the mean, s: that which replaces Doppler, and all of it.
    shifted: f64,
    moved: f64,
    /// From the window's start to cell 0, s.
    before_s: f64,
    cells_per_s: f64,
    interval_s: f64,
    /// Pulses between the nodes; 0 for a single one.
    length: f64,
    /// Pulses from the first node to that from which `m` counts.
    middle: f64,
    count: usize,
    courses: &'a mut Courses<f32>,
}

/// Brings an f64 below `2^51` to the nearest integer, and its low bits are that integer.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// The fraction of a phase as `2^-32` turns.
#[inline(always)]
fn turns(value: f64) -> u32 {
    let fraction = value - ((value + TO_INTEGER) - TO_INTEGER);
    (fraction * 4_294_967_296.0 + TO_INTEGER).to_bits() as u32
}

impl Task for Polynomials<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { ends, carrier_hz, mean_hz, middle_s, shifted, moved, .. } = self;
        let Self { interval_s, length, middle, count, courses, .. } = self;
        let [d0, d1] = ends.delay_s;
        let [r0, r1] = ends.delay_rate;
        let span_s = length * interval_s;
        // From powers of s to powers of m: s = (m + middle) / length.
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        let (mut phase, mut cubic) = ([[0u32; LANES]; 3], [0.0f32; LANES]);
        let (mut base, mut place) = ([0i32; LANES], [[0.0f32; LANES]; 4]);
        for i in 0..lanes_for(count) {
            let (mut delays, mut extra) = ([0.0; 2], [0.0; 2]);
            for (end, rate) in [r0[i], r1[i]].into_iter().enumerate() {
                let nu = carrier_hz * rate - mean_hz;
                delays[end] = nu * moved;
                extra[end] = -nu * middle_s - (nu * shifted) * (0.5 * nu + mean_hz);
            }
            let difference = d1[i] - d0[i];
            let (v0, v1) = if length > 0.0 {
                (r0[i] * span_s, r1[i] * span_s)
            } else {
                // One node: the rate is all there is, per pulse.
                (r0[i] * interval_s, r0[i] * interval_s)
            };
            let (a2, a3) = if length > 0.0 {
                (3.0 * difference - 2.0 * v0 - v1, v0 + v1 - 2.0 * difference)
            } else {
                (0.0, 0.0)
            };
            let scale = if length > 0.0 { inverse } else { 1.0 };
            // Delay in powers of m, less its value at the first node.
            let (c1, c2, c3) = (v0 * scale, a2 * scale * scale, a3 * scale * scale * scale);
            let b0 = middle * (c1 + middle * (c2 + middle * c3));
            let b1 = c1 + middle * (2.0 * c2 + 3.0 * middle * c3);
            let b2 = c2 + 3.0 * middle * c3;
            let more_turns = (extra[1] - extra[0]) * inverse;
            let more_s = (delays[1] - delays[0]) * inverse;
            let constant = extra[0] + middle * more_turns - carrier_hz * b0;
            phase[0][i] = turns(constant - carrier_hz * d0[i]);
            phase[1][i] = turns(more_turns - carrier_hz * b1);
            phase[2][i] = turns(-carrier_hz * b2);
            cubic[i] = (-carrier_hz * c3) as f32;
            let at_s = d0[i] + b0 + delays[0] + middle * more_s + self.before_s;
            let cells = at_s * self.cells_per_s + 0.5;
            let near = cells.abs() < FAR_CELLS;
            let cells = if near { cells } else { 0.0 };
            let shifted = cells + TO_INTEGER;
            let held = shifted - TO_INTEGER;
            base[i] = if near { shifted.to_bits() as i32 } else { -1_000_000_000 };
            place[0][i] = (cells - held) as f32;
            place[1][i] = ((b1 + more_s) * self.cells_per_s) as f32;
            place[2][i] = (b2 * self.cells_per_s) as f32;
            place[3][i] = (c3 * self.cells_per_s) as f32;
        }
        for (to, from) in courses.phase.iter_mut().zip(&phase) {
            to.copy_from_slice(&from[..count]);
        }
        courses.phase_cubic.copy_from_slice(&cubic[..count]);
        courses.base.copy_from_slice(&base[..count]);
        for (to, from) in courses.place.iter_mut().zip(&place) {
            to.copy_from_slice(&from[..count]);
        }
    }
}
