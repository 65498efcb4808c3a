//! Breaking waves over a stretch of pulses: exact paths at its nodes, and in between only what changes fast.
//!
//! A breaker runs straight on, so that delay and matrix are as smooth as the flight of the antennas: both are
//! cubics through the nodes. Gains, the breaker's envelope and its visibility are found at every pulse and
//! multiply the amplitude; gains at three, where directions turn by less than `LOBE_SHARE` of a lobe: a
//! parabola leaves some 1e-6 of the peak. A stretch is left to be made shorter, or exactly, where
//!
//! - a direction turns by more than `TURN_RAD`, or by a tenth of what it is off the vertical, where H and V
//!   turn with it: matrices are cubics within 1e-4 then;
//! - the rate at either end is not that of the cubic, by what leaves more than `PHASE_RAD` of phase: with
//!   nodes a third of a stretch `T` apart a fourth derivative leaves at most `T/18` times the error of the
//!   rate.
//!
//! It goes by what antennas and breakers do in these pulses alone. Antennas of measured pattern have complex
//! gains: their pulses are made exactly.

use std::ops::Range;

use glam::DVec3;
use num_complex::Complex64;

use super::{Moves, between};
use crate::frames::Earth;
use crate::geometry::light_time::{LightTime, Path, bistatic};
use crate::paths::block::{NODES, Sight, SlowTime, TileWork};
use crate::paths::breaking::{BreakingPlan, Riding};
use crate::paths::emission::Emission;
use crate::paths::list::ScattererPaths;
use crate::paths::sea::SeaPlan;
use crate::paths::{PairPlan, PathGenerator, Workspace};
use crate::radar::antenna::Antenna;
use crate::radar::fault::RadarError;
use crate::radar::polarisation::Axes;
use crate::radar::window::Window;
use crate::scene::Patch;
use crate::sea::wake::WakeError;
use crate::units::SPEED_OF_LIGHT_MPS;

/// What a direction may turn in a stretch, rad.
const TURN_RAD: f64 = 0.03;
/// What directions may turn for gains to be a parabola, of a wavelength over the aperture.
const LOBE_SHARE: f64 = 0.025;
/// Pulses of which gains are worth a parabola.
const MANY_PULSES: usize = 12;
/// What the axes of a receiver may turn while echoes of the patch arrive, rad.
const STEADY_RAD: f64 = 3e-7;
/// What a cubic may leave of the carrier's phase, rad.
pub(in crate::paths) const PHASE_RAD: f64 = 1e-4;

/// Room for what the pulses of a stretch have in common.
#[derive(Clone, Default)]
pub(in crate::paths) struct Buffers {
    pub(in crate::paths) emissions: Vec<Emission>,
    /// After pulse 0.
    pub(in crate::paths) elapsed_s: Vec<f64>,
    pub(in crate::paths) slow: SlowTime,
    /// Of a wave at every pulse.
    envelope: Vec<f64>,
    few: Few,
    /// Transmitter and receiver, `[pulse][pair]`.
    sights: Vec<[Sight; 2]>,
    /// As many: how receivers turn.
    turns: Vec<Option<Turn>>,
    /// Of every node; none where everything is received.
    pub(in crate::paths) windows: Vec<Vec<Window>>,
}

/// Gains at three pulses of a stretch in place of all.
#[derive(Clone, Default)]
struct Few {
    /// Weights of the three at every pulse; empty where a stretch is short.
    weights: Vec<[f64; 3]>,
    /// Of each pair towards a breaker; `None` where three are not enough.
    gains: Vec<Option<[f64; 3]>>,
}

/// How an antenna turns that receives echoes from one end of a patch otherwise than those from the other.
#[derive(Clone, Copy)]
struct Turn {
    /// Change of its axes in a second.
    change_per_s: Axes,
    /// When its axes are those known, after the emission, s.
    delay_s: f64,
}

/// Pulses of a block that are made together.
pub struct Stretch<'a> {
    /// First pulse of the block.
    pub block: u64,
    /// Pulses within it.
    pub pulses: Range<usize>,
    /// Where exact paths are found, counted from the first pulse of the stretch.
    pub nodes: &'a [usize],
    /// The patch of the block.
    pub patch: &'a Patch,
}

/// Derivatives of a polynomial through nodes, at the first and at the last: weights of the values there.
struct Slopes([[f64; NODES]; 2]);

impl Slopes {
    /// Of nodes at some pulses, `slow` being when these are.
    fn through(nodes: &[usize], slow: &SlowTime) -> Self {
        let at = |n: usize| slow.at(nodes[n]);
        let of = |own: usize| {
            let mut weights = [0.0; NODES];
            for j in (0..nodes.len()).filter(|j| *j != own) {
                let others = (0..nodes.len()).filter(|m| *m != own && *m != j);
                let product: f64 = others.map(|m| (at(own) - at(m)) / (at(j) - at(m))).product();
                weights[j] = product / (at(j) - at(own));
                // Differences count from the node's own value.
                weights[own] -= weights[j];
            }
            weights
        };
        Self([of(0), of(nodes.len() - 1)])
    }

    /// How far the rates of a path at both ends are off, per pulse of an interval.
    ///
    /// Paths are their delays and rates.
    fn off_s(&self, paths: impl ExactSizeIterator<Item = (f64, f64)> + Clone, interval_s: f64) -> f64 {
        let ends = [paths.clone().next(), paths.clone().last()].map(Option::unwrap_or_default);
        let off = self.0.iter().zip(ends).map(|(weights, (end_s, rate))| {
            let of = |(weight, (delay_s, _)): (&f64, (f64, f64))| weight * (delay_s - end_s);
            (weights.iter().zip(paths.clone()).map(of).sum::<f64>() - rate * interval_s).abs()
        });
        off.fold(0.0, f64::max)
    }
}

/// Whether a direction turns by more than matrices stay smooth over.
fn turns(from: DVec3, to: DVec3) -> bool {
    let level = (from.x * from.x + from.y * from.y).min(to.x * to.x + to.y * to.y);
    from.distance_squared(to) > (TURN_RAD * TURN_RAD).min(0.01 * level)
}

impl PathGenerator {
    /// Whether breaking waves are found by stretches.
    pub fn gains_are_real(&self) -> bool {
        self.antennas.iter().all(Antenna::is_real)
    }

    /// Fills `nodes` with the breaking waves of a stretch at its nodes, and `factors`, `[pulse][path][pair]`,
    /// with what multiplies their amplitudes; returns whether they are smooth enough.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover; a sea that cannot be found at it.
    pub fn breakers_of_stretch(
        &self,
        stretch: &Stretch,
        tiles: &TileWork,
        workspace: &mut Workspace,
        nodes: &mut [ScattererPaths],
        factors: &mut Vec<f64>,
    ) -> Result<bool, RadarError> {
        nodes.iter_mut().for_each(ScattererPaths::clear);
        factors.clear();
        let Some((sea, breaking)) = self.sea.as_ref().and_then(|sea| Some((sea, sea.breaking.as_ref()?)))
        else {
            return Ok(true);
        };
        if !self.gains_are_real() {
            return Ok(false);
        }
        let Workspace {
            stretch: Buffers { emissions, elapsed_s, slow, envelope, few, sights, turns, windows },
            amplitude,
            ..
        } = workspace;
        let first = stretch.block + stretch.pulses.start as u64;
        let count = stretch.pulses.len();
        emissions.resize_with(count.max(emissions.len()), Emission::default);
        for (index, emission) in (first..).zip(&mut emissions[..count]) {
            self.evaluate(index, emission)?;
        }
        self.slow_time(first, count, slow);
        elapsed_s.clear();
        elapsed_s.extend((first..).take(count).map(|index| self.radar.emissions.elapsed_s(index)));
        windows.resize_with(stretch.nodes.len().max(windows.len()), Vec::new);
        for (windows, place) in windows.iter_mut().zip(stretch.nodes) {
            self.windows_or_all(first + *place as u64, windows)?;
        }
        self.sights(stretch.patch, &emissions[..count], (sights, turns));
        let made = Making {
            of: self,
            sea,
            stretch,
            tiles,
            emissions: &emissions[..count],
            sights,
            turns,
            windows: &windows[..stretch.nodes.len()],
            elapsed_s,
            interval_s: self.radar.emissions.mean_pri_s(),
            slow,
            slopes: Slopes::through(stretch.nodes, slow),
        };
        envelope.resize(count, 0.0);
        made.all(breaking, nodes, (amplitude, envelope, few), factors)
            .map_err(|failure| self.sea_error(first, WakeError::from(failure).into()))
    }

    /// Both antennas of every pair at every pulse, the receiver when echoes of the middle of a patch arrive,
    /// and how it turns where the microseconds by which others differ matter.
    fn sights(
        &self,
        patch: &Patch,
        emissions: &[Emission],
        (sights, turns): (&mut Vec<[Sight; 2]>, &mut Vec<Option<Turn>>),
    ) {
        let [x, y] = [0, 1].map(|i| patch.facet_m * (patch.first[i] as f64 + 0.5 * patch.facets[i] as f64));
        let middle = DVec3::new(x, y, -self.frame.earth().drop_m(x, y));
        let across_m = patch.facet_m * (patch.facets[0] as f64).hypot(patch.facets[1] as f64);
        sights.clear();
        turns.clear();
        for emission in emissions {
            for plan in &self.plans {
                let ends = plan.ends(self.radar.transmitters.len());
                let [tx, rx] = ends.map(|end| &emission.centres[end]);
                let way_m = middle.distance(tx.position.raw()) + middle.distance(rx.position.raw());
                let delay_s = way_m / SPEED_OF_LIGHT_MPS;
                let arrives = rx.position.raw() + rx.velocity.raw() * delay_s;
                let axes = emission.axes_after(ends[1], delay_s, self.axes_span_s);
                let (_, change_per_s) = self.axes_of(emission, ends[1]);
                let fastest =
                    change_per_s.to_cols_array().into_iter().fold(0.0, |most: f64, c| most.max(c.abs()));
                let turn = Turn { change_per_s, delay_s };
                turns.push((fastest * across_m / SPEED_OF_LIGHT_MPS > STEADY_RAD).then_some(turn));
                sights.push([
                    Sight::of(&self.antennas[ends[0]], tx.position.raw(), emission.axes(ends[0])),
                    Sight::of(&self.antennas[ends[1]], arrives, axes),
                ]);
            }
        }
    }
}

/// What the breakers of a stretch are made from.
struct Making<'a> {
    of: &'a PathGenerator,
    sea: &'a SeaPlan,
    stretch: &'a Stretch<'a>,
    tiles: &'a TileWork,
    /// Of every pulse.
    emissions: &'a [Emission],
    /// `[pulse][pair]`.
    sights: &'a [[Sight; 2]],
    /// As many.
    turns: &'a [Option<Turn>],
    /// Of every node.
    windows: &'a [Vec<Window>],
    /// Of every pulse, after pulse 0.
    elapsed_s: &'a [f64],
    interval_s: f64,
    slow: &'a SlowTime,
    slopes: Slopes,
}

impl Making<'_> {
    fn earth(&self) -> Earth {
        self.of.frame.earth()
    }

    fn ends(&self, plan: &PairPlan) -> [usize; 2] {
        plan.ends(self.of.radar.transmitters.len())
    }

    /// All breakers; `false` once one of them is not smooth.
    fn all(
        &self,
        breaking: &BreakingPlan,
        nodes: &mut [ScattererPaths],
        (amplitude, envelope, few): (&mut [Complex64], &mut [f64], &mut Few),
        factors: &mut Vec<f64>,
    ) -> Result<bool, crate::sea::surface::SurfaceError> {
        let (pulses, pairs) = (self.stretch.pulses.len(), self.of.plans.len());
        let lasts_s = [self.elapsed_s[0], self.elapsed_s[pulses - 1]];
        let mut alive = 0;
        breaking.each(self.stretch.patch, lasts_s, |_| alive += 1)?;
        factors.resize(pulses * alive * pairs, 0.0);
        let (mut smooth, mut number) = (true, 0);
        // Scatterers of a wave come one after another and have one envelope.
        let mut last = [f64::NAN; 2];
        few.weights.clear();
        if pulses >= MANY_PULSES {
            self.weigh_few(&mut few.weights);
        }
        breaking.each(self.stretch.patch, lasts_s, |riding| {
            smooth = smooth && self.at_nodes(riding, nodes, amplitude);
            if smooth {
                let own = [riding.breaker.born_s, riding.breaker.life_s];
                if own != last {
                    last = own;
                    for (envelope, &elapsed_s) in envelope.iter_mut().zip(self.elapsed_s) {
                        *envelope = riding.breaker.envelope(elapsed_s);
                    }
                }
                few.gains.clear();
                if !few.weights.is_empty() {
                    few.gains.extend((0..pairs).map(|pair| self.few_gains(riding, pair)));
                }
                for (pulse, &envelope) in envelope.iter().enumerate().filter(|(_, envelope)| **envelope > 0.0)
                {
                    let from = (pulse * alive + number) * pairs;
                    let factors = &mut factors[from..from + pairs];
                    self.at_pulse(riding, (pulse, envelope), few, factors);
                }
            }
            number += 1;
        })?;
        Ok(smooth)
    }

    /// Appends the paths of a breaker at the nodes; returns whether they are smooth.
    fn at_nodes(&self, riding: &Riding, nodes: &mut [ScattererPaths], amplitude: &mut [Complex64]) -> bool {
        let Self { of, sea, stretch, emissions, windows, slow, .. } = *self;
        let (permittivity, places) = (sea.scattering.permittivity(), stretch.nodes);
        let mut smooth = true;
        for (pair, plan) in of.plans.iter().enumerate() {
            let [tx, rx] = self.ends(plan);
            let mut paths = [Path::default(); NODES];
            let mut within = false;
            for ((path, &place), windows) in paths.iter_mut().zip(places).zip(windows) {
                let moves = Moves::of(riding, self.earth(), self.elapsed_s[place]);
                let centres = &emissions[place].centres;
                let (tx, rx) = (&centres[tx], &centres[rx]);
                *path = bistatic(LightTime::Exact, tx, moves.position, moves.velocity, rx);
                within |= windows.get(plan.window).is_none_or(|window| window.touches(path.delay_s));
            }
            let paths = &paths[..places.len()];
            let lasts = slow.at(places[places.len() - 1]) - slow.at(places[0]);
            let [first, last] = [&paths[0], &paths[paths.len() - 1]];
            let off_rad = std::f64::consts::TAU * of.radar.carrier_hz * lasts / 18.0
                * self
                    .slopes
                    .off_s(paths.iter().map(|path| (path.delay_s, path.delay_rate)), self.interval_s);
            smooth &= !within
                || (off_rad <= PHASE_RAD
                    && !(turns(first.incident, last.incident) || turns(first.scattered, last.scattered)));
            for ((node, path), &place) in nodes.iter_mut().zip(paths).zip(places) {
                node.delay_s[pair].push(path.delay_s);
                node.delay_rate[pair].push(path.delay_rate);
                amplitude.fill(Complex64::ZERO);
                if within {
                    let moves = Moves::of(riding, self.earth(), self.elapsed_s[place]);
                    let matrix = Some(moves.matrix(self.earth(), permittivity, &riding.breaker, path));
                    let scale = Complex64::from(plan.link.scattered_over(path));
                    let emission = &emissions[place];
                    of.polarised(plan, (path, None), matrix.as_ref(), scale, None, emission, amplitude);
                }
                for (channel, ..) in &plan.channels {
                    node.amplitude[*channel].push(amplitude[*channel]);
                }
            }
        }
        nodes.iter_mut().for_each(|node| node.emission_offset_s.push(0.0));
        smooth
    }

    /// Weights of the first, the middle and the last pulse in a parabola, at every pulse.
    fn weigh_few(&self, out: &mut Vec<[f64; 3]>) {
        let last = self.elapsed_s.len() - 1;
        let at = [0, last / 2, last].map(|pulse| self.slow.at(pulse));
        out.extend((0..=last).map(|pulse| {
            let t = self.slow.at(pulse);
            [[0, 1, 2], [1, 0, 2], [2, 0, 1]]
                .map(|[own, a, b]| (t - at[a]) * (t - at[b]) / ((at[own] - at[a]) * (at[own] - at[b])))
        }));
    }

    /// Gains of a pair towards a breaker at the first, the middle and the last pulse, where these are enough.
    fn few_gains(&self, riding: &Riding, pair: usize) -> Option<[f64; 3]> {
        let (pairs, last) = (self.of.plans.len(), self.elapsed_s.len() - 1);
        let ends = self.ends(&self.of.plans[pair]);
        let (mut gains, mut first) = ([1.0; 3], [DVec3::ZERO; 2]);
        for (n, pulse) in [0, last / 2, last].into_iter().enumerate() {
            let at = pulse * pairs + pair;
            if self.turns[at].is_some() {
                return None;
            }
            let place = Moves::of(riding, self.earth(), self.elapsed_s[pulse]).position.raw();
            for ((sight, end), first) in self.sights[at].iter().zip(ends).zip(&mut first) {
                let towards = (place - sight.position).normalize_or_zero();
                let (own, side) = sight.lobes_towards(towards)?;
                if n == 0 {
                    *first = own;
                }
                // From any to any.
                if 2.0 * side * own.distance(*first) > LOBE_SHARE || (own.x > 0.0) != (first.x > 0.0) {
                    return None;
                }
                gains[n] *= sight.gain(&self.of.antennas[end], towards);
            }
        }
        Some(gains)
    }

    /// Gains, envelope and visibility of the breaker that was appended last, by pair.
    fn at_pulse(&self, riding: &Riding, (pulse, envelope): (usize, f64), few: &Few, factors: &mut [f64]) {
        let Self { of, stretch, tiles, emissions, .. } = *self;
        let patch = stretch.patch;
        let mut known = None;
        for ((pair, plan), factor) in of.plans.iter().enumerate().zip(factors) {
            let ends = self.ends(plan);
            let mut moves =
                || *known.get_or_insert_with(|| Moves::of(riding, self.earth(), self.elapsed_s[pulse]));
            let three = few.weights.get(pulse).zip(few.gains.get(pair).and_then(Option::as_ref));
            let gains = match three {
                Some((weights, gains)) => weights.iter().zip(gains).map(|(weight, gain)| weight * gain).sum(),
                None => self.gains(&moves(), pulse, pair, ends),
            };
            if gains == 0.0 {
                continue;
            }
            let mut seen = |end: usize| {
                let pulse = stretch.pulses.start + pulse;
                let seen = tiles.seen_from(end, pulse);
                if seen.is_whole() {
                    return 1.0;
                }
                between(patch, moves().at_m, |facet| seen.of(facet))
            };
            let of_tx = seen(ends[0]);
            // Antennas at one place see the same.
            let [tx, rx] = ends.map(|end| emissions[pulse].centres[end].position);
            let of_rx = if tx == rx { of_tx } else { seen(ends[1]) };
            *factor = envelope * gains * of_tx * of_rx;
        }
    }

    /// Gains of a pair towards a breaker at a pulse.
    fn gains(&self, moves: &Moves, pulse: usize, pair: usize, ends: [usize; 2]) -> f64 {
        // Light time moves breakers by centimetres at most.
        let at = pulse * self.of.plans.len() + pair;
        let ([tx, rx], place) = (&self.sights[at], moves.position.raw());
        let turned = self.turns[at].map(|turn| {
            let way_m = place.distance(tx.position) + place.distance(rx.position);
            rx.later(turn.change_per_s, way_m / SPEED_OF_LIGHT_MPS - turn.delay_s)
        });
        let rx = turned.as_ref().unwrap_or(rx);
        let gain = |sight: &Sight, end: usize| {
            sight.gain(&self.of.antennas[end], (place - sight.position).normalize_or_zero())
        };
        gain(tx, ends[0]) * gain(rx, ends[1])
    }
}
