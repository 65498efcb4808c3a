//! Targets, direct paths and panels of ships of a run.
//!
//! They are few, so they are followed themselves: at up to 65536 pulses spread over the run for their power,
//! and in **stretches** of [`LONGEST`] units of successive pulses for what is left of them, a pulse of each
//! unit ([`unit_of`](super::unit_of)) of errors that are not coarse, all of the run where it is short, else
//! those about the strongest pulses, and some spread over it. Of more than 1024 the strongest are followed,
//! for all.
//!
//! Unlike facets they keep their phases, so the power of the run is that of amplitudes with their phases, and
//! what is left is taken at its worst: `line.rs`. Targets that fluctuate count in the power of the run as
//! they are drawn; in the error they count with the most that they return at any pulse. Targets that crests
//! hide count likewise: in the power as hidden as they are, in the error as not hidden at all. What land and
//! ships hide is known beforehand, and counts in both as it is.
//!
//! The heave of a target is a Gaussian process: the largest of the `N` stretches of the run exceeds the
//! largest of the `n` that are followed by a factor of about `sqrt(ln N / ln n)`. The error of such targets
//! is multiplied by it. That of targets and ships that turn is multiplied by 1.5 at least, because what
//! cubics leave in a turn depends on where they begin.
//!
//! Panels of ships have nodes of their own, and gains that are found at every pulse. Their error is that of
//! the cubics through the amplitude without gains, times the gains and the fraction that is not hidden. It
//! may be in phase with the error of targets.
//!
//! Limits: points that are strong for less than the interval between pulses of the profile may be missed.

use std::f64::consts::TAU;
use std::ops::Range;
use std::rc::Rc;

use num_complex::Complex64;

use super::line::Line;
use super::{ErrorSampler, LONGEST, Powers, spread_over, through};
use crate::paths::block::{SlowTime, nodes_within};
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;

/// Points and pulses of a profile, at most, and pulses of it at least.
const MOST_PROFILE: u64 = 1 << 16;
const LEAST_PROFILE: u64 = 64;
/// Points and pulses of all stretches, at most; stretches at least, and at most.
const MOST_FOLLOWED: u64 = 1 << 20;
const STRETCHES: std::ops::RangeInclusive<u64> = 1..=64;
/// Points that are followed.
const MOST_POINTS: usize = 1024;
/// Dopplers at which a [`Law`] is found, over the largest.
const KNOTS: [f64; 6] = [1e-9, 1e-4, 1e-3, 1e-2, 1e-1, 1.0];

/// What the points of a run return.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Mean power over the run, W.
    pub power: Powers,
    /// Most of a pulse, W.
    pub highest: Powers,
    /// The strongest pulse.
    pub loudest: u64,
    /// Largest rate of a delay.
    pub fastest: f64,
    /// Most power of a pulse over that of random phases, 1 at least.
    pub(super) coherence: f64,
    /// Points that are followed, panels of ships last, and from which on they are that.
    followed: Vec<usize>,
    panels_from: usize,
    /// Power of all over that of those followed: of targets, and of panels.
    all_of_followed: [f64; 2],
    /// The most that fluctuations make of each target's power at any pulse; empty where there are none.
    most_of_run: Vec<f64>,
    /// First pulses of the stretches.
    pub(super) stretches: Vec<u64>,
    /// What is left of each point in the whole run over what is left in the stretches; empty where it is the
    /// same.
    unseen: Vec<f64>,
    /// What cubics leave of targets: steps of gain, and powers by channel.
    swept: Vec<(u64, Powers)>,
    /// The same of panels, by the steps of their nodes; empty where there are none.
    swept_panels: Vec<(u64, Powers)>,
    /// The step that was chosen.
    panel_pulses: Option<u64>,
}

impl Points {
    /// What cubics between gains every so many pulses leave, by channel, where they were followed with these,
    /// and what those of panels leave.
    pub fn swept(&self, gain_pulses: u64) -> Option<Powers> {
        let (_, own) = self.swept.iter().find(|(step, _)| *step == gain_pulses)?;
        let of_panels = self.swept_panels.iter().find(|(step, _)| Some(*step) == self.panel_pulses);
        let Some((_, of_panels)) = of_panels else { return Some(own.clone()) };
        let in_phase = |(a, b): (&f64, &f64)| (a.sqrt() + b.sqrt()).powi(2);
        Some(own.iter().zip(of_panels).map(in_phase).collect())
    }
}

/// A stretch of successive pulses.
pub(super) struct Stretch {
    first: u64,
    /// When its pulses are, mean intervals.
    at: Vec<f64>,
    /// Points that are followed, pulse by pulse.
    pub(super) exact: Vec<ScattererPaths>,
    /// `[pulse][pair]`.
    pub(super) lines: Vec<Vec<Line>>,
    /// `[pulse][pair]`: of all points.
    rates: Vec<Vec<Rates>>,
    /// `[pulse]`: the most that multiplies these amplitudes.
    pub(super) most: Vec<Variation>,
}

/// What multiplies the steady (not fluctuating) amplitudes of points.
pub(super) struct Variation {
    /// `[point][pair]`; empty where nothing varies.
    of_points: Vec<f64>,
    pairs: usize,
}

impl Variation {
    pub(super) fn of(&self, point: usize, pair: usize) -> f64 {
        self.of_points.get(point * self.pairs + pair).copied().unwrap_or(1.0)
    }
}

/// Powers, and sums of powers and delay rates, of points that are received and of all.
type Rates = [(f64, f64); 2];

/// Pulses of a block of so many at which its points are weighed for their mean Doppler: first, middle and
/// last.
pub fn of_points(pulses: usize) -> [usize; 3] {
    [0, pulses / 2, pulses.saturating_sub(1)]
}

/// Mean delay rate of a block: of facets, power and mean rate, and of points, sums over the three pulses of
/// [`of_points`]: of those that are received, or, where there is nothing else, of all.
pub fn mean_rate((of_facets, rate): (f64, f64), received: (f64, f64), all: (f64, f64)) -> f64 {
    let points = if of_facets + received.0 > 0.0 { received } else { all };
    let power = of_facets + points.0 / 3.0;
    if power > 0.0 { (of_facets * rate + points.1 / 3.0) / power } else { 0.0 }
}

/// What a Doppler off the mean leaves of a pulse, relative to its power.
#[derive(Clone, Debug)]
pub struct Law {
    /// Logarithms of Hz and of what is left: powers from one to the next.
    knots: [(f64, f64); KNOTS.len()],
}

impl Law {
    /// Up to a Doppler, of `left`, the error power of one in Hz. What is left of either sign counts, and
    /// never falls: a waveform that is cut off at the ends of its band may lose a bin by the smallest
    /// Doppler.
    pub fn new(most_hz: f64, left: impl Fn(f64) -> f64) -> Self {
        let mut most = f64::MIN_POSITIVE;
        let knots = KNOTS.map(|share| {
            let hz = share * most_hz.max(1e-3);
            most = most.max(left(hz)).max(left(-hz));
            (hz.ln(), most.ln())
        });
        Self { knots }
    }

    /// The root of the error power.
    pub(super) fn root(&self, hz: f64) -> f64 {
        let at = hz.ln();
        if hz == 0.0 || at <= self.knots[0].0 {
            return (0.5 * self.knots[0].1).exp();
        }
        let n = self.knots.partition_point(|knot| knot.0 < at).clamp(1, self.knots.len() - 1);
        let [(a, left_a), (b, left_b)] = [self.knots[n - 1], self.knots[n]];
        (0.5 * (left_a + (at - a) / (b - a) * (left_b - left_a))).exp()
    }
}

impl ErrorSampler<'_> {
    /// What the targets and direct paths are to the run.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Finds what the points of the run return.
    pub(super) fn find_points(&mut self) -> Result<(), RadarError> {
        let channels = self.radar.channels.len();
        self.points = Points {
            power: vec![0.0; channels],
            highest: vec![0.0; channels],
            coherence: 1.0,
            most_of_run: self.generator.most_of_run(),
            ..Points::default()
        };
        let points = self.generator.point_count();
        if points == 0 || self.pulses == 0 {
            return Ok(());
        }
        let count = (MOST_PROFILE / points as u64).max(LEAST_PROFILE).min(self.pulses);
        let mut loud = Vec::with_capacity(count as usize);
        // Most power of each point, and its mean.
        let mut of_each = vec![(0.0f64, 0.0); points];
        let mut paths = self.no_points();
        let deviations = self.deviations();
        for index in spread_over(self.pulses, count, 1) {
            let found = self.points_at(index, &mut paths)?;
            let (drawn, highest) = (self.variation(index, false)?, self.variation(index, true)?);
            let mut all = 0.0;
            for (pair, channels) in self.channels.iter().enumerate() {
                let (delays_s, opens_s) = (&paths.delay_s[pair], found[pair].0);
                let line = Line::new(delays_s, self.cells_per_s);
                for &channel in channels {
                    let amplitude = &paths.amplitude[channel];
                    let power = self.received_power(index, (pair, opens_s), (&line, &paths, &drawn), channel);
                    self.points.power[channel] += power / count as f64;
                    all += power;
                    let own = |n: usize| (amplitude[n] * drawn.of(n, pair)).norm_sqr();
                    let each: f64 = (0..points).map(own).sum();
                    self.points.coherence = self.points.coherence.max(power / each.max(f64::MIN_POSITIVE));
                    let most = line.most([deviations, self.points.coherence], |n| {
                        amplitude[n].norm() * highest.of(n, pair)
                    });
                    self.points.highest[channel] = self.points.highest[channel].max(most);
                    for (n, (most, mean)) in of_each.iter_mut().enumerate() {
                        (*most, *mean) = (most.max(own(n)), *mean + own(n));
                    }
                }
            }
            loud.push((all, index));
            let rates = paths.delay_rate.iter().flatten();
            self.points.fastest = rates.fold(self.points.fastest, |most, rate| most.max(rate.abs()));
        }
        loud.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.points.loudest = loud.first().map_or(0, |(_, index)| *index);
        self.points.stretches = stretches(self.pulses, (points as u64, self.longest()), &loud);
        let (targets, panels) = of_each.split_at(self.generator.target_count());
        let [(targets, of_targets), (panels, of_panels)] =
            [targets, panels].map(|of_each| loudest(of_each, MOST_POINTS));
        let first_panel = self.generator.target_count();
        self.points.panels_from = targets.len();
        self.points.followed = targets.into_iter().chain(panels.iter().map(|n| first_panel + n)).collect();
        self.points.all_of_followed = [of_targets, of_panels];
        let unseen = unseen(self.points.stretches.len() as u64, self.pulses, self.longest());
        let of: Vec<f64> = (0..points).map(|n| self.generator.left_unseen(n, unseen)).collect();
        if of.iter().any(|unseen| *unseen > 1.0) {
            self.points.unseen = of;
        }
        Ok(())
    }

    /// Follows the points through the stretches with gains every so many pulses, and panels of ships with
    /// nodes every so many.
    ///
    /// # Errors
    /// A track that ends before the run.
    pub fn follow_points(&mut self, gain_pulses: &[u64], panel_pulses: &[u64]) -> Result<(), RadarError> {
        let nothing = |step: &u64| (*step, vec![0.0; self.power.len()]);
        let mut swept: Vec<_> = gain_pulses.iter().map(nothing).collect();
        let meshes = self.generator.ship_paths() > 0;
        let mut swept_panels: Vec<_> = panel_pulses.iter().filter(|_| meshes).map(nothing).collect();
        let (targets, panels) =
            (0..self.points.panels_from, self.points.panels_from..self.points.followed.len());
        for n in 0..self.points.stretches.len() {
            let stretch = self.stretch(n)?;
            let most = self.most_of(&stretch);
            for (highest, most) in self.points.highest.iter_mut().zip(most) {
                *highest = highest.max(most);
            }
            for (steps, points, more) in
                [(&mut swept, targets.clone(), 0), (&mut swept_panels, panels.clone(), 1)]
            {
                for (step, worst) in steps {
                    // Steps are whole ones of points, or a pulse, which leaves nothing.
                    let length =
                        usize::try_from(3 * (*step / self.point_step) + more).unwrap_or(usize::MAX).max(1);
                    for from in (0..stretch.exact.len()).step_by(length) {
                        let pulses = from..(from + length).min(stretch.exact.len());
                        self.add_part(&stretch, pulses, points.clone(), worst);
                    }
                }
            }
        }
        (self.points.swept, self.points.swept_panels) = (swept, swept_panels);
        Ok(())
    }

    /// The most pulses from node to node of the panels of ships that leave no more than a share of the echo,
    /// of those that were followed, or the fewest; `None` without ships that echo by their mesh.
    pub fn choose_panel_pulses(&mut self, share: f64) -> Option<u64> {
        let left = |powers: &Powers| self.sampled() * self.worst_ratio(powers);
        let swept = &self.points.swept_panels;
        let keeps = swept.iter().filter(|(_, powers)| left(powers) <= share).map(|(step, _)| *step).max();
        self.points.panel_pulses = keeps.or_else(|| swept.iter().map(|(step, _)| *step).min());
        self.points.panel_pulses
    }

    /// The most that Doppler within a pulse leaves of points in the worst pulse of blocks of so many pulses
    /// each, over the mean power of all.
    ///
    /// # Errors
    /// A track that ends before the run.
    pub fn doppler_of_points(&mut self, law: &Law, blocks: &[u64]) -> Result<Vec<(u64, f64)>, RadarError> {
        // Of all facets, the mean of the places: power, and its sum with delay rates.
        let share = self.sampled() * self.places.len().max(1) as f64;
        let mut of_facets = vec![(0.0, 0.0); self.channels.len()];
        for (pair, hz, w) in &self.dopplers {
            let (power, sum) = &mut of_facets[*pair];
            (*power, *sum) = (*power + w / share, *sum + w * hz / self.radar.carrier_hz / share);
        }
        of_facets.iter_mut().for_each(|(power, sum)| *sum /= power.max(f64::MIN_POSITIVE));
        let mut worst: Vec<(u64, Powers)> =
            blocks.iter().map(|block| (*block, vec![0.0; self.power.len()])).collect();
        for n in 0..self.points.stretches.len() {
            let stretch = self.stretch(n)?;
            for (block, worst) in &mut worst {
                self.add_doppler(&stretch, *block, law, &of_facets, worst);
            }
        }
        self.raise_to_peaks(&mut worst)?;
        Ok(worst.iter().map(|(block, of)| (*block, self.sampled() * self.worst_ratio(of))).collect())
    }

    /// Doppler of the points of a stretch off the mean of their blocks.
    fn add_doppler(
        &self,
        stretch: &Stretch,
        block: u64,
        law: &Law,
        of_facets: &[(f64, f64)],
        worst: &mut Powers,
    ) {
        let (carrier_hz, bounds) = (self.radar.carrier_hz, [self.deviations(), self.points.coherence]);
        let block = block.max(1);
        let mut from = 0;
        while from < stretch.exact.len() {
            // Blocks of the run; of those that begin before the stretch or end after it, their part.
            let begun = (stretch.first + from as u64 * self.point_step) % block;
            let within = (block - begun).div_ceil(self.point_step);
            let pulses = from..(from + within as usize).min(stretch.exact.len());
            for (pair, channels) in self.channels.iter().enumerate() {
                let sum = |which: usize| {
                    let of = of_points(pulses.len()).map(|n| stretch.rates[from + n][pair][which]);
                    of.iter().fold((0.0, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
                };
                let mean = mean_rate(of_facets[pair], sum(0), sum(1));
                for pulse in pulses.clone() {
                    let own = &stretch.exact[pulse];
                    for &channel in channels {
                        let left = |n: usize| {
                            let off_hz = carrier_hz * self.off_mean(&own.delay_rate[pair], n, mean);
                            let most = own.amplitude[channel][n].norm() * stretch.most[pulse].of(n, pair);
                            most * law.root(off_hz.abs())
                        };
                        worst[channel] = worst[channel].max(stretch.lines[pulse][pair].most(bounds, left));
                    }
                }
            }
            from = pulses.end;
        }
    }

    /// Adds the points of a pulse to what the mean Doppler is taken of.
    pub(super) fn add_points_at(&mut self, index: u64) -> Result<(), RadarError> {
        let (weight, carrier_hz) = (self.sampled(), self.radar.carrier_hz);
        let mut paths = self.no_points();
        let found = self.points_at(index, &mut paths)?;
        for ((power, weighted), (_, [received, _])) in self.dopplers_of_points.iter_mut().zip(found) {
            (*power, *weighted) =
                (*power + weight * received.0, *weighted + weight * received.1 * carrier_hz);
        }
        Ok(())
    }

    /// Room for the points of a pulse.
    pub(super) fn no_points(&self) -> ScattererPaths {
        ScattererPaths::new(self.channels.len(), self.radar.channels.len(), self.generator.point_count())
    }

    /// Points that are followed, at all pulses of a stretch.
    pub(super) fn stretch(&mut self, n: usize) -> Result<Rc<Stretch>, RadarError> {
        if let Some(known) = self.known.stretches.get(&n) {
            return Ok(known);
        }
        let found = self.follow(n)?;
        let of_point = 1 + 4 * self.channels.len() + 2 * self.radar.channels.len();
        let numbers = found.exact.len() * self.points.followed.len() * of_point;
        Ok(self.known.stretches.keep(n, found, numbers))
    }

    fn follow(&mut self, n: usize) -> Result<Stretch, RadarError> {
        let first = self.points.stretches[n];
        let mut all = self.no_points();
        let [of_targets, of_panels] = self.points.all_of_followed.map(f64::sqrt);
        let first_panel = self.generator.target_count();
        let scale = |n: usize| if n < first_panel { of_targets } else { of_panels };
        let (exact, lines, rates, most) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut slow = SlowTime::default();
        self.generator.slow_time(first, self.longest() as usize, &mut slow);
        let at = (0..self.longest()).step_by(self.point_step as usize).map(|n| slow.at(n as usize)).collect();
        let mut stretch = Stretch { first, at, exact, lines, rates, most };
        let pulses = first..first.saturating_add(self.longest()).min(self.pulses);
        for index in pulses.step_by(self.point_step as usize) {
            let found = self.points_at(index, &mut all)?;
            let of =
                |column: &Vec<f64>| -> Vec<f64> { self.points.followed.iter().map(|n| column[*n]).collect() };
            let amplitude = |column: &Vec<Complex64>| {
                self.points.followed.iter().map(|n| scale(*n) * column[*n]).collect()
            };
            let delay_s: Vec<Vec<f64>> = all.delay_s.iter().map(of).collect();
            stretch.lines.push(delay_s.iter().map(|own| Line::new(own, self.cells_per_s)).collect());
            stretch.exact.push(ScattererPaths {
                emission_offset_s: of(&all.emission_offset_s),
                delay_s,
                delay_rate: all.delay_rate.iter().map(of).collect(),
                amplitude: all.amplitude.iter().map(amplitude).collect(),
            });
            stretch.rates.push(found.into_iter().map(|(_, rates)| rates).collect());
            let Variation { of_points, pairs } = self.variation(index, true)?;
            let of_point = |n: &usize| of_points.get(n * pairs..(n + 1) * pairs).unwrap_or_default();
            let of_points = self.points.followed.iter().flat_map(of_point).copied().collect();
            stretch.most.push(Variation { of_points, pairs });
        }
        Ok(stretch)
    }

    /// What multiplies the amplitudes of a pulse, or the most that fluctuations make of them.
    pub(super) fn variation(&mut self, index: u64, most: bool) -> Result<Variation, RadarError> {
        let (pairs, mut of_points) = (self.channels.len(), Vec::new());
        if self.generator.varies() {
            let most_of_run = most.then_some(&self.points.most_of_run[..]);
            self.generator.variations(index, most_of_run, &mut self.memory, &mut of_points)?;
        }
        if most && !self.points.unseen.is_empty() {
            of_points.resize(self.points.unseen.len() * pairs, 1.0);
            for (own, unseen) in of_points.chunks_exact_mut(pairs.max(1)).zip(&self.points.unseen) {
                own.iter_mut().for_each(|most| *most *= unseen);
            }
        }
        Ok(Variation { of_points, pairs })
    }

    /// Points of a pulse, and by pair its window's start and their rates. Points that the window does not
    /// receive at all, and those without a delay polynomial, are silent.
    pub(super) fn points_at(
        &mut self,
        index: u64,
        paths: &mut ScattererPaths,
    ) -> Result<Vec<(f64, Rates)>, RadarError> {
        self.generator.points(index, &mut self.memory, paths)?;
        let starts_s = (0..self.channels.len()).map(|pair| self.generator.pair_start_of(pair, index));
        let starts_s = starts_s.collect::<Result<Vec<f64>, _>>()?;
        let share = |pair: usize, delay_s| self.generator.received_share(index, starts_s[pair], delay_s);
        let mut of_mean = None;
        if self.generator.ship_paths() > 0 {
            let mut some = self.no_points();
            self.generator.points_of_mean(index, &mut self.memory, &mut some)?;
            of_mean = Some(some);
        }
        let of_mean = of_mean.as_ref().unwrap_or(paths);
        let received = |pair| self.generator.rates(of_mean, pair, |delay_s| share(pair, delay_s));
        let rates = |pair| [received(pair), self.generator.rates(of_mean, pair, |_| 1.0)];
        let found = (0..self.channels.len()).map(|pair| (starts_s[pair], rates(pair))).collect();
        for (channel, pair) in self.generator.channel_pairs().iter().enumerate() {
            let courses = paths.delay_s[*pair].iter().zip(&paths.delay_rate[*pair]);
            for (a, (delay_s, rate)) in paths.amplitude[channel].iter_mut().zip(courses) {
                if !(share(*pair, *delay_s) > 0.0 && rate.abs() < 1.0 && a.norm_sqr().is_finite()) {
                    *a = Complex64::ZERO;
                }
            }
        }
        for (delays_s, rates) in paths.delay_s.iter_mut().zip(&mut paths.delay_rate) {
            for (delay_s, rate) in delays_s.iter_mut().zip(rates) {
                if !(delay_s.is_finite() && rate.abs() < 1.0) {
                    (*delay_s, *rate) = (0.0, 0.0);
                }
            }
        }
        Ok(found)
    }

    /// The worst pulse of some that have a cubic in common, for some of the points that are followed.
    fn add_part(&self, of: &Stretch, pulses: Range<usize>, points: Range<usize>, worst: &mut Powers) {
        if points.is_empty() {
            return;
        }
        let from = pulses.start;
        let (exact, lines, varied) = (&of.exact[pulses.clone()], &of.lines[pulses.clone()], &of.most[pulses]);
        let turns_per_s = TAU * self.radar.carrier_hz;
        let bounds = [self.deviations(), self.points.coherence];
        let (nodes, count) = nodes_within(exact.len());
        let nodes = &nodes[..count];
        let slow = |pulse: usize| of.at[from + pulse];
        for (pulse, own) in exact.iter().enumerate().filter(|(pulse, _)| !nodes.contains(pulse)) {
            let weights = through(nodes, pulse, slow);
            for (channel, pair) in self.generator.channel_pairs().iter().enumerate() {
                let off = |n: usize| {
                    if !points.contains(&n) {
                        return 0.0;
                    }
                    let (delay_s, a) = (own.delay_s[*pair][n], own.amplitude[channel][n]);
                    let (mut late_s, mut found) = (0.0, Complex64::ZERO);
                    for (m, weight) in nodes.iter().zip(weights) {
                        late_s += weight * (exact[*m].delay_s[*pair][n] - delay_s);
                        found += exact[*m].amplitude[channel][n] * weight;
                    }
                    (found * Complex64::cis(-turns_per_s * late_s) - a).norm() * varied[pulse].of(n, *pair)
                };
                worst[channel] = worst[channel].max(lines[pulse][*pair].most(bounds, off));
            }
        }
    }
}

/// Points of the largest power, and the mean power of all over theirs; `(most, mean)` of each.
fn loudest(of_each: &[(f64, f64)], most: usize) -> (Vec<usize>, f64) {
    let mut order: Vec<usize> = (0..of_each.len()).collect();
    order.sort_by(|a, b| of_each[*b].0.total_cmp(&of_each[*a].0));
    order.truncate(most);
    order.sort_unstable();
    let all: f64 = of_each.iter().map(|(_, mean)| mean).sum();
    let own: f64 = order.iter().map(|n| of_each[*n].1).sum();
    (order, if own > 0.0 { all / own } else { 1.0 })
}

/// The largest of a Gaussian process in a run over the largest in so many of its stretches.
fn unseen(stretches: u64, pulses: u64, longest: u64) -> f64 {
    let all = pulses.div_ceil(longest);
    if all <= stretches { 1.0 } else { ((all as f64).ln() / (stretches.max(2) as f64).ln()).sqrt().max(1.0) }
}

/// First pulses of the stretches of a run; `strong` are pulses from the strongest on.
fn stretches(pulses: u64, (points, longest): (u64, u64), loud: &[(f64, u64)]) -> Vec<u64> {
    let most = (MOST_FOLLOWED / (points * LONGEST)).clamp(*STRETCHES.start(), *STRETCHES.end());
    let all = pulses.div_ceil(longest);
    if all <= most {
        return (0..all).map(|n| n * longest).collect();
    }
    let mut chosen = std::collections::BTreeSet::new();
    for (_, index) in loud {
        if chosen.len() as u64 >= most.div_ceil(2) {
            break;
        }
        chosen.insert(index / longest);
    }
    let rest = most - chosen.len() as u64;
    chosen.extend((0..rest).map(|n| (all - 1) * n / (rest - 1).max(1)));
    chosen.into_iter().map(|n| n * longest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loudest_stand_for_all() {
        let of_each = [(1.0, 1.0), (9.0, 2.0), (4.0, 2.0), (0.0, 0.0)];
        assert_eq!(loudest(&of_each, 2), (vec![1, 2], 5.0 / 4.0));
        assert_eq!(loudest(&of_each, 10), (vec![0, 1, 2, 3], 1.0));
        assert_eq!(loudest(&[(0.0, 0.0)], 1), (vec![0], 1.0));
    }

    #[test]
    fn short_runs_are_followed_throughout_and_long_ones_where_they_are_loud() {
        assert_eq!(stretches(1, (1, LONGEST), &[]), [0]);
        assert_eq!(stretches(130, (1, LONGEST), &[]), [0, 64, 128]);
        assert_eq!(stretches(1300, (1, 10 * LONGEST), &[]), [0, 640, 1280]);
        let loud = [(9.0, 640_000), (8.0, 640_001), (7.0, 3), (6.0, 500_000)];
        let found = stretches(800_000, (1, LONGEST), &loud);
        assert!(found.len() <= 64 && found.is_sorted(), "{found:?}");
        for index in [0, 640_000, 499_968, 799_936] {
            assert!(found.contains(&index), "{index}: {found:?}");
        }
        assert_eq!(stretches(800_000, (1_000_000, LONGEST), &loud), [640_000]);
        assert!(stretches(u64::MAX, (1, LONGEST), &[]).iter().all(|first| *first < u64::MAX));
    }

    #[test]
    fn what_no_stretch_shows_is_allowed_for() {
        let unseen = |stretches: u64, pulses: u64| super::unseen(stretches, pulses, LONGEST);
        assert_eq!((unseen(1, 64), unseen(3, 130), unseen(0, 0)), (1.0, 1.0, 1.0));
        // The largest of 2^20 of a Gaussian process, and of 64: sqrt(20/6).
        assert!((unseen(64, LONGEST << 20) - (20f64 / 6.0).sqrt()).abs() < 1e-12);
        assert_eq!((unseen(1, 65), unseen(2, u64::MAX).is_finite()), (1.0, true));
    }

    #[test]
    fn laws_are_powers_from_knot_to_knot() {
        let close =
            |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-9, "{found} {wanted}");
        let square = Law::new(1e4, |hz| 1e-12 * hz * hz);
        [10.0, 3e3, 1e4, 2e4].into_iter().for_each(|hz| close(square.root(hz), 1e-6 * hz));
        // A bin that is lost to one side by the smallest Doppler.
        let edge = Law::new(1e4, |hz| if hz < 0.0 { 1e-4 } else { 1e-12 * hz * hz });
        [0.0, 1e-7, 1e3].into_iter().for_each(|hz| close(edge.root(hz), 1e-2));
        assert!(Law::new(0.0, |_| 0.0).root(0.0) < 1e-100);
    }

    #[test]
    fn blocks_have_the_mean_of_what_is_received() {
        assert_eq!(of_points(64), [0, 32, 63]);
        assert_eq!((of_points(1), of_points(0)), ([0; 3], [0; 3]));
        // Facets of 2 W, and points of 6 W over three pulses; nothing but what is not received; nothing.
        assert_eq!(mean_rate((2.0, 1e-6), (6.0, -6e-6), (60.0, 1.0)), 0.0);
        assert_eq!(mean_rate((0.0, 0.0), (0.0, 0.0), (3.0, 6e-6)), 2e-6);
        assert_eq!(mean_rate((0.0, 0.0), (0.0, 0.0), (0.0, 0.0)), 0.0);
    }
}
