//! What a block of pulses holds of its scatterer paths.
//!
//! Over the `M` pulses of a block, with `m` the time from the middle pulse `M/2` in mean intervals, a
//! scatterer path has
//!
//! | quantity | form | held as |
//! | --- | --- | --- |
//! | carrier phase `-f0 tau`, turns | cubic in `m` | u32 fractions of a turn for `1, m, m^2`, float for `m^3` (`scalar`) |
//! | place on the grid, cells | cubic in `m` | whole cells (i32) and float for `1, m, m^2, m^3` |
//! | amplitude of each channel, sqrt(W) | linear or cubic in `m` | floats |
//!
//! all of them through its values at the **nodes**: one to four pulses of the block at which it was evaluated
//! in full. The part of its Doppler that is not the mean's is put into phase and place at the nodes
//! ([`doppler`](super::doppler)), so it follows the rate as it changes. Everything is computed in f64 and
//! rounded last.
//!
//! **Errors.** With 4 nodes over a block of half length `Th` the range remainder is at most
//! `max |R''''| Th^4 / 24`; with 3 nodes `0.064 max|R'''| Th^3` (ends and middle); see `docs/physics.md`
//! section 15.7 for sizes. The place in f32 is rounded to `2^-24` of the cells that it moves within half a
//! block ([`Fill::drift_cells`]).

use std::ops::Range;

use num_complex::Complex64;

pub use super::frame::{Frame, Receives};
use super::grid::{FAR_CELLS, Lined};
use super::scalar::Scalar;
use super::spread::{DelayPolynomials, Emitted, TICKS};
use super::{Synth, SynthError};
use crate::echo::reference::of_window;
use crate::paths::list::ScattererPaths;

/// Most pulses of a block.
pub const MAX_PULSES: usize = 1024;
/// Pulses of a block for which there is room beforehand.
const FEW_PULSES: usize = 64;
/// Most nodes of a block.
pub const MAX_NODES: usize = 4;
/// Cells that a scatterer path may move within half a block.
pub const MAX_DRIFT_CELLS: f64 = 1e6;

/// Scatterer paths of the block at one of its pulses.
#[derive(Clone, Copy, Debug)]
pub struct Node<'a> {
    /// Pulse within the block.
    pub pulse: usize,
    /// Its scatterer paths: the same ones, in the same order, at every node.
    pub paths: &'a ScattererPaths,
}

/// What filling a block has found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fill {
    /// Scatterer paths that are spread, counted once for each pair.
    pub spread: usize,
    /// Scatterer paths and pairs left out though their amplitude is not zero: with a delay at one node and
    /// none at another, a rate of 1 or more (faster than light), or a place that moves beyond
    /// [`MAX_DRIFT_CELLS`].
    pub unplaced: usize,
    /// Largest Doppler off its pair's mean at a node, Hz.
    pub residual_hz: f64,
    /// Largest change of place from the middle of the block to a node, cells; the window's own steps are
    /// whole cells and cost nothing.
    pub drift_cells: f64,
}

/// Scatterer paths of a block of pulses. Made by [`Synth::block`], filled by [`Synth::fill`].
#[derive(Debug)]
pub struct BlockPaths<T: Scalar> {
    pub(super) frame: Frame,
    /// `[pair]`.
    pub(super) polynomials: Vec<DelayPolynomials<T>>,
    /// `[layer][power]`, each `[path][lane]`.
    pub(super) amplitude: Vec<Vec<Lined<T>>>,
    /// Powers of the amplitudes that are in use: 2 or 4.
    pub(super) powers: usize,
    /// `[pair]`: what multiplies the amplitudes, `[pulse][path]`; empty where nothing does.
    pub(super) factors: Vec<Vec<T>>,
    /// `[window]`: what pulses receive, that of a group together.
    pub(super) emitted: Vec<Vec<Emitted<T>>>,
    /// `[window]`: start of a window that places count from, s.
    references_s: Vec<f64>,
    /// Groups of its emissions; empty where every one fills all channels.
    pub(super) groups: Vec<u8>,
    pub(super) fill: Fill,
}

impl<T: Scalar> BlockPaths<T> {
    pub(super) fn new(pairs: usize, layers: usize) -> Self {
        Self {
            frame: Frame::with_room(FEW_PULSES, pairs, layers),
            polynomials: (0..pairs).map(|_| DelayPolynomials::default()).collect(),
            amplitude: (0..layers).map(|_| Vec::new()).collect(),
            powers: 2,
            factors: vec![Vec::new(); pairs],
            emitted: vec![Vec::with_capacity(FEW_PULSES)],
            references_s: Vec::with_capacity(1),
            groups: Vec::new(),
            fill: Fill::default(),
        }
    }

    /// Pulses of the block.
    pub fn pulses(&self) -> usize {
        self.frame.pulses()
    }

    /// Scatterer paths, those of zero amplitude included.
    pub fn len(&self) -> usize {
        self.polynomials.first().map_or(0, |c| c.base.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Multiplies the amplitudes at a pulse, from the first on, by `[path][pair]`. Filling forgets it.
    pub fn push_factors(&mut self, of_pulse: &[f64]) {
        let pairs = self.factors.len();
        for (pair, factors) in self.factors.iter_mut().enumerate() {
            factors.extend(of_pulse.iter().skip(pair).step_by(pairs).map(|factor| T::round_from(*factor)));
        }
    }

    /// Multiplies the amplitudes of a pair by `[pulse][path]`. Filling forgets it.
    pub fn set_factors(&mut self, pair: usize, factors: &[T]) {
        self.factors[pair].clear();
        self.factors[pair].extend_from_slice(factors);
    }

    /// Windows and mean Doppler.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What the last filling has found.
    pub fn found(&self) -> Fill {
        self.fill
    }
}

/// A polynomial in `m` through values at the nodes.
pub(super) struct Through {
    nodes: usize,
    /// `[power][node]`.
    pub(super) basis: [[f64; MAX_NODES]; MAX_NODES],
}

impl Through {
    pub(super) fn new(places: &[f64]) -> Self {
        let mut basis = [[0.0; MAX_NODES]; MAX_NODES];
        for (n, own) in places.iter().enumerate() {
            // prod (x - x_j)/(x_n - x_j), expanded.
            let mut c = [0.0; MAX_NODES];
            c[0] = 1.0;
            for (_, other) in places.iter().enumerate().filter(|(j, _)| *j != n) {
                let scale = 1.0 / (own - other);
                for k in (0..MAX_NODES).rev() {
                    c[k] = scale * (if k > 0 { c[k - 1] } else { 0.0 } - other * c[k]);
                }
            }
            for (power, value) in c.iter().enumerate() {
                basis[power][n] = *value;
            }
        }
        Self { nodes: places.len(), basis }
    }

    /// Coefficients of `1, m, m^2, m^3`. Differences from the first value, so that large ones lose nothing.
    fn coefficients(&self, values: &[f64; MAX_NODES]) -> [f64; MAX_NODES] {
        let mut c = [0.0; MAX_NODES];
        for (c, basis) in c.iter_mut().zip(&self.basis) {
            *c = basis.iter().zip(values).take(self.nodes).map(|(b, v)| b * (v - values[0])).sum();
        }
        c[0] += values[0];
        c
    }
}

impl<T: Scalar> Synth<T> {
    /// An empty block.
    pub fn block(&self) -> BlockPaths<T> {
        self.block_with_room(0, 0)
    }

    /// An empty block, with room for so many scatterer paths and so many numbers that multiply those of a
    /// pair.
    pub fn block_with_room(&self, paths: usize, factors: usize) -> BlockPaths<T> {
        let mut block = BlockPaths::new(self.pairs, self.layers.len());
        block.polynomials.iter_mut().for_each(|of_pair| of_pair.reserve(paths));
        block.factors.iter_mut().for_each(|of_pair| of_pair.reserve(factors));
        for (layer, held) in self.layers.iter().zip(&mut block.amplitude) {
            held.resize_with(MAX_NODES, Lined::default);
            held.iter_mut().for_each(|amplitude| amplitude.reset(paths * layer.lanes));
        }
        block
    }

    /// Fills a block of as many pulses as there are windows (`windows_s[m]`: first sample of pulse `m` after
    /// its emission, s) from its scatterer paths at one to four nodes.
    ///
    /// # Errors
    /// Too many pulses or nodes, windows that are not finite, nodes outside of the block or with other
    /// scatterer paths than the first.
    pub fn fill(
        &self,
        nodes: &[Node<'_>],
        windows_s: &[f64],
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        self.fill_in(nodes, &[windows_s], block)
    }

    /// The same with several windows a pulse ([`Synth::in_windows`]), `[window][pulse]`.
    ///
    /// # Errors
    /// As [`Self::fill`].
    pub fn fill_in<W: AsRef<[f64]>>(
        &self,
        nodes: &[Node<'_>],
        windows_s: &[W],
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        self.fill_without_replicas(nodes, windows_s, block)?;
        self.fill_replicas(&mut block.frame);
        Ok(())
    }

    /// The same without what takes grids to spectra, for who has that by [`Self::replicas_of`].
    ///
    /// # Errors
    /// As [`Self::fill`].
    pub fn fill_without_replicas<W: AsRef<[f64]>>(
        &self,
        nodes: &[Node<'_>],
        windows_s: &[W],
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        let pulses = windows_s.first().map_or(0, |of| of.as_ref().len());
        self.check(nodes, pulses, windows_s.iter().flat_map(AsRef::as_ref))?;
        let means: [f64; 0] = [];
        self.frame(windows_s, &means, &mut block.frame);
        for pair in 0..self.pairs {
            block.frame.mean_hz[pair] = self.mean_hz(nodes, pair);
        }
        block.frame.level();
        let frame = std::mem::take(&mut block.frame);
        self.fill_paths(nodes, &frame, 0..pulses, block);
        block.frame = frame;
        Ok(())
    }

    /// The same for some of the emissions at hand of a longer block, of which `frame` has windows and mean
    /// Doppler; nodes count from the first of these emissions.
    ///
    /// # Errors
    /// As [`Self::fill`]; emissions that the frame does not have.
    pub fn fill_part(
        &self,
        nodes: &[Node<'_>],
        frame: &Frame,
        emissions: Range<usize>,
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        let known = !frame.receives.is_empty() || emissions.end <= frame.pulses();
        let count = if known { emissions.len() } else { 0 };
        self.check(nodes, count, frame.windows_s.iter().flatten())?;
        self.fill_paths(nodes, frame, emissions, block);
        Ok(())
    }

    /// The same for the own emission of a pulse of a longer block, which fills channels of a group (all
    /// without one), whether it is at hand or not.
    ///
    /// # Errors
    /// As [`Self::fill`]; a pulse that the frame does not have.
    pub fn fill_own(
        &self,
        paths: &ScattererPaths,
        frame: &Frame,
        (pulse, group): (usize, Option<u8>),
        block: &mut BlockPaths<T>,
    ) -> Result<(), SynthError> {
        let nodes = [Node { pulse: 0, paths }];
        let known = usize::from(pulse < frame.pulses());
        self.check(&nodes, known, frame.windows_s.iter().filter_map(|of| of.get(pulse)))?;
        let mut alone = std::mem::take(&mut block.frame);
        alone.level();
        alone.windows_s.resize_with(frame.windows_s.len(), Vec::new);
        for (own, of) in alone.windows_s.iter_mut().zip(&frame.windows_s) {
            own.clear();
            own.extend(of.get(pulse));
        }
        alone.mean_hz.clone_from(&frame.mean_hz);
        alone.groups.extend(group);
        self.fill_paths(&nodes, &alone, 0..1, block);
        block.frame = alone;
        block.emitted.iter_mut().flatten().for_each(|own| own.grid = pulse);
        Ok(())
    }

    /// Windows (`[window][pulse]`, s) and mean Doppler of a block (of each pair, Hz; 0 where it is not
    /// given), and what follows from them.
    pub fn frame<W: AsRef<[f64]>>(&self, windows_s: &[W], mean_hz: &[f64], frame: &mut Frame) {
        frame.set_windows(windows_s);
        frame.mean_hz.clear();
        frame.mean_hz.extend_from_slice(mean_hz);
        frame.mean_hz.resize(self.pairs, 0.0);
        frame.replicas.resize_with(self.layers.len(), Vec::new);
        if !mean_hz.is_empty() {
            self.fill_replicas(frame);
        }
    }

    fn fill_paths(
        &self,
        nodes: &[Node<'_>],
        frame: &Frame,
        emissions: Range<usize>,
        block: &mut BlockPaths<T>,
    ) {
        let (slow, start, count) = (&frame.slow, emissions.start, emissions.len());
        let uneven = !slow.uneven().is_empty();
        let middle = slow.at(start + count / 2);
        let time = |row: usize| [slow.at(start + row) - middle; 2];
        block.groups.clear();
        block.groups.extend_from_slice(frame.groups.get(emissions.clone()).unwrap_or_default());
        let mut references_s = std::mem::take(&mut block.references_s);
        references_s.clear();
        block.emitted.resize_with(frame.windows_s.len(), Vec::new);
        for (windows_s, emitted) in frame.windows_s.iter().zip(&mut block.emitted) {
            let of = (frame, windows_s.as_slice());
            references_s.push(self.fill_emitted(of, emissions.clone(), time, emitted));
        }
        let (mut places, mut carrier) = ([0.0; MAX_NODES], [0.0; MAX_NODES]);
        for ((place, turns), node) in places.iter_mut().zip(&mut carrier).zip(nodes) {
            *place = slow.at(start + node.pulse) - middle;
            *turns = frame.turns_at(slow.at(start + node.pulse));
        }
        let through = Through::new(&places[..nodes.len()]);
        block.fill = Fill::default();
        block.factors.iter_mut().for_each(Vec::clear);
        // How far the polynomials reach, intervals.
        let reach = [0, count - 1].map(|row| time(row)[0].abs());
        let reach = reach.into_iter().fold(0.5 * FEW_PULSES as f64, f64::max);
        for pair in 0..self.pairs {
            let mean_hz = frame.mean_hz[pair];
            let reference_s = of_window(&references_s, &self.windows, pair).copied().unwrap_or(0.0);
            self.fill_pair(nodes, (&through, &carrier), (reference_s, reach, uneven), (pair, mean_hz), block);
        }
        block.references_s = references_s;
    }

    fn check<'a>(
        &self,
        nodes: &[Node<'_>],
        pulses: usize,
        mut windows_s: impl Iterator<Item = &'a f64>,
    ) -> Result<(), SynthError> {
        if !(1..=MAX_PULSES).contains(&pulses) {
            return Err(SynthError::Pulses { pulses });
        }
        if let Some(start_s) = windows_s.find(|s| !s.is_finite()) {
            return Err(SynthError::Window { start_s: *start_s });
        }
        if !(1..=MAX_NODES).contains(&nodes.len()) {
            return Err(SynthError::Nodes { nodes: nodes.len() });
        }
        for (i, node) in nodes.iter().enumerate() {
            if node.pulse >= pulses || nodes[..i].iter().any(|other| other.pulse == node.pulse) {
                return Err(SynthError::NodePulse { pulse: node.pulse, pulses });
            }
            let (paths, first) = (node.paths, nodes[0].paths);
            let polynomials =
                paths.delay_s.iter().take(self.pairs).chain(paths.delay_rate.iter().take(self.pairs));
            let same = paths.len() == first.len()
                && paths.delay_s.len() >= self.pairs
                && paths.delay_rate.len() >= self.pairs
                && paths.amplitude.len() >= self.channels
                && polynomials.map(Vec::len).all(|len| len == first.len())
                && paths.amplitude.iter().take(self.channels).all(|a| a.len() == first.len());
            if !same {
                return Err(SynthError::ScattererPaths { pulse: node.pulse });
            }
        }
        Ok(())
    }

    /// Mean of `f0 r` over scatterer paths and nodes, weighted by power.
    fn mean_hz(&self, nodes: &[Node<'_>], pair: usize) -> f64 {
        let (mut sum, mut weight) = (0.0, 0.0);
        for node in nodes {
            for layer in self.layers.iter().filter(|l| l.pair == pair && !l.moment) {
                for channel in &layer.channels {
                    let amplitudes = &node.paths.amplitude[*channel];
                    let delays_s = &node.paths.delay_s[pair];
                    let rates = &node.paths.delay_rate[pair];
                    for (a, (delay_s, rate)) in amplitudes.iter().zip(delays_s.iter().zip(rates)) {
                        let power = a.norm_sqr();
                        if power > 0.0 && power.is_finite() && has_delay(*delay_s, *rate) {
                            sum += power * rate;
                            weight += power;
                        }
                    }
                }
            }
        }
        if weight > 0.0 { self.carrier_hz * sum / weight } else { 0.0 }
    }

    fn fill_pair(
        &self,
        nodes: &[Node<'_>],
        (through, carrier): (&Through, &[f64; MAX_NODES]),
        (reference_s, reach, uneven): (f64, f64, bool),
        (pair, mean_hz): (usize, f64),
        block: &mut BlockPaths<T>,
    ) {
        let paths = nodes[0].paths.len();
        let correction = self.correction();
        let polynomials = &mut block.polynomials[pair];
        polynomials.phase.iter_mut().for_each(|p| p.resize(paths, T::Turns::default()));
        polynomials.phase_cubic.resize(paths, T::default());
        let room = if uneven { paths } else { 0 };
        polynomials.uneven.iter_mut().for_each(|p| p.resize(room, T::default()));
        polynomials.base.resize(paths, 0);
        polynomials.place.iter_mut().for_each(|p| p.resize(paths, T::default()));
        let powers = if nodes.len() <= 2 { 2 } else { 4 };
        block.powers = powers;
        for (layer, held) in self.layers.iter().zip(&mut block.amplitude) {
            if layer.pair == pair {
                // What is not needed keeps its room for the next block.
                held.resize_with(MAX_NODES, Lined::default);
                held.iter_mut().enumerate().for_each(|(power, a)| {
                    a.reset(if power < powers { paths * layer.lanes } else { 0 });
                });
            }
        }
        for n in 0..paths {
            let (mut turns, mut cells, mut residual) = ([0.0; 4], [0.0; 4], [0.0; 4]);
            let (mut placed, mut anywhere, mut drift) = (true, false, 0.0f64);
            for (i, node) in nodes.iter().enumerate() {
                let delay_s = node.paths.delay_s[pair][n];
                let rate = node.paths.delay_rate[pair][n];
                residual[i] = self.carrier_hz * rate - mean_hz;
                let (extra_turns, extra_s) = correction.of(mean_hz, residual[i]);
                turns[i] = extra_turns - self.carrier_hz * delay_s + carrier[i];
                let after_s = node.paths.emission_offset_s[n] + (delay_s - reference_s) + extra_s;
                cells[i] = (after_s + self.lead_s) * self.cells_per_s + 0.5;
                let seen = has_delay(delay_s, rate) && cells[i].is_finite();
                placed &= seen;
                anywhere |= delay_s.is_finite();
            }
            let mut place = through.coefficients(&cells);
            let held = place[0].clamp(-FAR_CELLS, FAR_CELLS).round();
            for cells in &cells[..nodes.len()] {
                drift = drift.max((cells - held).abs());
            }
            // The polynomial at either end of the block.
            placed &= place[1..].iter().rev().fold(0.0, |s, c| (s + c.abs()) * reach) < MAX_DRIFT_CELLS;
            // Farther than any window: not received, and nothing is lost.
            let far = placed && (place[0] - held).abs() > 0.5;
            placed &= !far;
            let contributes =
                self.fill_amplitude(nodes, through, pair, n, placed, &residual, block_amplitude(block));
            if !placed || !contributes {
                block.fill.unplaced += usize::from(contributes && anywhere && !far);
                let polynomials = &mut block.polynomials[pair];
                polynomials.phase.iter_mut().for_each(|p| p[n] = T::Turns::default());
                polynomials.phase_cubic[n] = T::default();
                polynomials.base[n] = -1;
                polynomials.place.iter_mut().for_each(|p| p[n] = T::default());
                continue;
            }
            block.fill.spread += 1;
            let largest = residual.iter().take(nodes.len()).fold(0.0f64, |a, r| a.max(r.abs()));
            block.fill.residual_hz = block.fill.residual_hz.max(largest);
            block.fill.drift_cells = block.fill.drift_cells.max(drift);
            let mut phase = through.coefficients(&turns);
            place[0] -= held;
            let polynomials = &mut block.polynomials[pair];
            if uneven {
                for (to, value) in polynomials.uneven.iter_mut().zip(&phase[1..]) {
                    to[n] = T::round_from(*value);
                }
                phase[1] /= TICKS;
            }
            for (to, value) in polynomials.phase.iter_mut().zip(phase) {
                to[n] = T::turns(value);
            }
            polynomials.phase_cubic[n] = T::round_from(phase[3]);
            polynomials.base[n] = held as i32;
            for (to, value) in polynomials.place.iter_mut().zip(place) {
                to[n] = T::round_from(value);
            }
        }
    }

    /// Amplitudes of scatterer path `n` in the layers of a pair; returns whether any is not zero.
    fn fill_amplitude(
        &self,
        nodes: &[Node<'_>],
        through: &Through,
        pair: usize,
        n: usize,
        placed: bool,
        residual_hz: &[f64; MAX_NODES],
        amplitude: &mut [Vec<Lined<T>>],
    ) -> bool {
        let mut contributes = false;
        for (layer, held) in self.layers.iter().zip(amplitude) {
            if layer.pair != pair {
                continue;
            }
            for (at, channel) in layer.channels.iter().enumerate() {
                let (mut re, mut im) = ([0.0; MAX_NODES], [0.0; MAX_NODES]);
                for (i, node) in nodes.iter().enumerate() {
                    let mut a = node.paths.amplitude[*channel][n];
                    if layer.moment {
                        a *= residual_hz[i] * self.waveform.duration_s();
                    }
                    (re[i], im[i]) = (a.re, a.im);
                    contributes |= a != Complex64::ZERO;
                }
                if !placed {
                    continue;
                }
                let (re, im) = (through.coefficients(&re), through.coefficients(&im));
                let powers = if nodes.len() <= 2 { 2 } else { MAX_NODES };
                for (power, held) in held.iter_mut().take(powers).enumerate() {
                    let lanes = &mut held.as_mut_slice()[n * layer.lanes..][..layer.lanes];
                    lanes[2 * at] = T::round_from(re[power]);
                    lanes[2 * at + 1] = T::round_from(im[power]);
                }
            }
        }
        contributes
    }
}

/// Whether a scatterer path has a delay, and a rate below the speed of light.
fn has_delay(delay_s: f64, rate: f64) -> bool {
    delay_s.is_finite() && rate.abs() < 1.0
}

/// The amplitudes alone, while the rest is borrowed elsewhere.
fn block_amplitude<T: Scalar>(block: &mut BlockPaths<T>) -> &mut [Vec<Lined<T>>] {
    &mut block.amplitude
}
