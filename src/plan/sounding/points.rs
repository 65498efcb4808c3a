//! Targets and direct paths of a run.
//!
//! They are few, so they are followed themselves: at up to 65536 pulses spread over the run for their power, and in
//! **stretches** of [`LONGEST`] successive pulses for what is left of them, all of the run where it is short, else those about the loudest
//! pulses, and some spread over it. Of more than 4096 the loudest are followed, for all.
//!
//! Unlike facets they keep their phases, so the power of the run is that of amplitudes with their phases, and what is left is taken at its worst:
//! `line.rs`.
//!
//! Limits: points that are loud for less than the pulses from one of the profile to the next may be missed.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::line::Line;
use super::{LONGEST, Powers, Sounder, spread_over, through};
use crate::radar::fault::RadarError;
use crate::radar::illumination::tiles::nodes_within;
use crate::scattering::contact::Contacts;

/// Points and pulses of a profile, at most, and pulses of it at least.
const MOST_PROFILE: u64 = 1 << 16;
const LEAST_PROFILE: u64 = 64;
/// Points and pulses of all stretches, at most; stretches at least, and at most.
const MOST_FOLLOWED: u64 = 1 << 20;
const STRETCHES: std::ops::RangeInclusive<u64> = 1..=64;
/// Points that are followed.
const MOST_POINTS: usize = 4096;
/// Dopplers of which a [`Law`] is told.
const KNOTS: usize = 6;

/// What the points of a run return.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Mean power over the run, W.
    pub power: Powers,
    /// Most of a pulse, W.
    pub highest: Powers,
    /// The loudest pulse.
    pub loudest: u64,
    /// Largest rate of a delay.
    pub fastest: f64,
    /// Points that are followed, and the power of all over theirs.
    followed: Vec<usize>,
    all_of_followed: f64,
    /// First pulses of the stretches.
    stretches: Vec<u64>,
    /// Doppler at all pulses of the stretches.
    offsets: Vec<Offset>,
    /// What cubics leave: steps of gain, and powers by channel.
    swept: Vec<(u64, Powers)>,
}

/// Doppler of a channel's points at a pulse off their mean, Hz.
#[derive(Clone, Copy, Debug)]
struct Offset {
    channel: usize,
    /// Most power of the pulse, W.
    power: f64,
    /// Root of the mean square, and of the mean fourth power, by power.
    rms_hz: f64,
    fourth_hz: f64,
    /// Change of the mean from pulse to pulse.
    drift_hz: f64,
}

impl Points {
    /// The most that Doppler within a pulse leaves in the worst pulse of blocks of so many pulses, `[channel]`.
    pub fn doppler(&self, law: &Law, block_pulses: u64) -> Powers {
        let mut worst = vec![0.0f64; self.power.len()];
        for of in &self.offsets {
            let hz = of.off_hz(block_pulses, law.fourth);
            if hz > 0.0 {
                worst[of.channel] = worst[of.channel].max(of.power * law.at(hz));
            }
        }
        worst
    }
}

/// What a Doppler off the mean leaves of a pulse, relative to its power.
#[derive(Clone, Debug)]
pub struct Law {
    /// Grows as the fourth power, or else as the square.
    fourth: bool,
    /// Logarithms of Hz and of what is left: powers from one to the next.
    knots: Vec<(f64, f64)>,
}

impl Law {
    /// For the points of a run, with `left` what a Doppler in Hz leaves, which grows as its square or as its fourth power.
    pub fn new(points: &Points, fourth: bool, left: impl Fn(f64) -> f64) -> Self {
        let all = points.offsets.iter().flat_map(|of| [1, LONGEST].map(|block| of.off_hz(block, fourth)));
        let heard = all.filter(|hz| *hz > 0.0);
        let (least_hz, most_hz) =
            heard.fold((f64::INFINITY, 0.0f64), |(least, most), hz| (least.min(hz), most.max(hz)));
        if most_hz == 0.0 {
            return Self { fourth, knots: Vec::new() };
        }
        // What is a millionth of the largest leaves nothing.
        let least_hz = least_hz.max(1e-6 * most_hz);
        let knot = |n: usize| least_hz * (most_hz / least_hz).powf(n as f64 / (KNOTS - 1) as f64);
        let of = |hz: f64| (hz.ln(), left(hz).max(f64::MIN_POSITIVE).ln());
        Self { fourth, knots: (0..KNOTS).map(|n| of(knot(n))).collect() }
    }

    fn at(&self, hz: f64) -> f64 {
        if self.knots.is_empty() {
            return 0.0;
        }
        let at = hz.ln();
        let n = self.knots.partition_point(|knot| knot.0 < at).clamp(1, self.knots.len() - 1);
        let [(a, left_a), (b, left_b)] = [self.knots[n - 1], self.knots[n]];
        let share = if b > a { (at - a) / (b - a) } else { 1.0 };
        (left_a + share * (left_b - left_a)).exp()
    }
}

impl Offset {
    /// Off the mean of a block of some pulses, which is that of its middle.
    fn off_hz(&self, block_pulses: u64, fourth: bool) -> f64 {
        let own = if fourth { self.fourth_hz } else { self.rms_hz };
        own + self.drift_hz * 0.5 * block_pulses.saturating_sub(1) as f64
    }
}

impl Sounder<'_> {
    /// What the targets and direct paths are to the run.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// Finds what the points of the run return.
    pub(super) fn find_points(&mut self) -> Result<(), RadarError> {
        let channels = self.radar.channels.len();
        self.points =
            Points { power: vec![0.0; channels], highest: vec![0.0; channels], ..Points::default() };
        let points = self.illumination.point_count();
        if points == 0 || self.pulses == 0 {
            return Ok(());
        }
        let count = (MOST_PROFILE / points as u64).max(LEAST_PROFILE).min(self.pulses);
        let mut loud = Vec::with_capacity(count as usize);
        // Most power of each point, and its mean.
        let mut of_each = vec![(0.0f64, 0.0); points];
        let mut contacts = self.no_points();
        let deviations = self.deviations();
        for index in spread_over(self.pulses, count) {
            let opens_s = self.points_at(index, &mut contacts)?;
            let mut all = 0.0;
            for (pair, channels) in self.channels.iter().enumerate() {
                let delays_s = &contacts.delay_s[pair];
                let line = Line::new(delays_s, self.cells_per_s);
                for &channel in channels {
                    let amplitude = &contacts.amplitude[channel];
                    let power = line.power(|n| {
                        let heard = self.illumination.heard_share(opens_s, delays_s[n]).sqrt();
                        amplitude[n] * heard * Complex64::cis(-TAU * self.radar.carrier_hz * delays_s[n])
                    });
                    self.points.power[channel] += power / count as f64;
                    all += power;
                    let most = line.most(deviations, |n| amplitude[n].norm());
                    self.points.highest[channel] = self.points.highest[channel].max(most);
                    for ((most, mean), a) in of_each.iter_mut().zip(amplitude) {
                        (*most, *mean) = (most.max(a.norm_sqr()), *mean + a.norm_sqr());
                    }
                }
            }
            loud.push((all, index));
            let rates = contacts.delay_rate.iter().flatten();
            self.points.fastest = rates.fold(self.points.fastest, |most, rate| most.max(rate.abs()));
        }
        loud.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.points.loudest = loud.first().map_or(0, |(_, index)| *index);
        self.points.stretches = stretches(self.pulses, points as u64, &loud);
        (self.points.followed, self.points.all_of_followed) = loudest(&of_each, MOST_POINTS);
        Ok(())
    }

    /// Follows the points through the stretches, once the facets' Doppler is known: with gains every so many pulses.
    pub fn follow_points(&mut self, gain_pulses: &[u64]) -> Result<(), RadarError> {
        // Of all facets, the mean of the places: power, and its sum with Doppler.
        let share = self.sampled() * self.places.len().max(1) as f64;
        let mut of_facets = vec![(0.0, 0.0); self.channels.len()];
        for (pair, hz, w) in &self.dopplers {
            let (power, weighted) = &mut of_facets[*pair];
            (*power, *weighted) = (*power + w / share, *weighted + w * hz / share);
        }
        self.points.offsets.clear();
        self.points.swept = gain_pulses.iter().map(|step| (*step, vec![0.0; self.power.len()])).collect();
        let mut swept = std::mem::take(&mut self.points.swept);
        for n in 0..self.points.stretches.len() {
            let exact = self.stretch(n)?;
            let lines: Vec<Vec<Line>> = exact
                .iter()
                .map(|own| own.delay_s.iter().map(|delays_s| Line::new(delays_s, self.cells_per_s)).collect())
                .collect();
            self.take_offsets(&exact, &lines, &of_facets);
            for (step, worst) in &mut swept {
                let length = usize::try_from(3 * *step).unwrap_or(usize::MAX).max(1);
                for (exact, lines) in exact.chunks(length).zip(lines.chunks(length)) {
                    self.add_part(exact, lines, worst);
                }
            }
        }
        self.points.swept = swept;
        Ok(())
    }

    /// Adds the points of a pulse to what the mean Doppler is taken of.
    pub(super) fn add_points_at(&mut self, index: u64) -> Result<(), RadarError> {
        let weight = self.sampled();
        let mut contacts = self.no_points();
        self.points_at(index, &mut contacts)?;
        for (channel, pair) in self.illumination.channel_pairs().iter().enumerate() {
            let (power, weighted) = &mut self.dopplers_of_points[*pair];
            for (a, rate) in contacts.amplitude[channel].iter().zip(&contacts.delay_rate[*pair]) {
                let w = weight * a.norm_sqr();
                (*power, *weighted) = (*power + w, *weighted + w * rate * self.radar.carrier_hz);
            }
        }
        Ok(())
    }

    /// Room for the points of a pulse.
    fn no_points(&self) -> Contacts {
        Contacts::new(self.channels.len(), self.radar.channels.len(), self.illumination.point_count())
    }

    /// Points that are followed, at all pulses of a stretch.
    fn stretch(&mut self, n: usize) -> Result<Vec<Contacts>, RadarError> {
        let first = self.points.stretches[n];
        let (mut all, mut found) = (self.no_points(), Vec::new());
        let scale = self.points.all_of_followed.sqrt();
        for index in first..first.saturating_add(LONGEST).min(self.pulses) {
            self.points_at(index, &mut all)?;
            let of = |column: &Vec<f64>| self.points.followed.iter().map(|n| column[*n]).collect();
            let amplitude =
                |column: &Vec<Complex64>| self.points.followed.iter().map(|n| scale * column[*n]).collect();
            found.push(Contacts {
                emission_offset_s: of(&all.emission_offset_s),
                delay_s: all.delay_s.iter().map(of).collect(),
                delay_rate: all.delay_rate.iter().map(of).collect(),
                amplitude: all.amplitude.iter().map(amplitude).collect(),
            });
        }
        Ok(found)
    }

    /// Points of a pulse, and its window's start; silent are those that the window does not hear at all, and those without a course.
    fn points_at(&mut self, index: u64, contacts: &mut Contacts) -> Result<f64, RadarError> {
        self.illumination.points(index, &mut self.light, contacts)?;
        let opens_s = self.illumination.window_start_of(index)?;
        for (channel, pair) in self.illumination.channel_pairs().iter().enumerate() {
            let courses = contacts.delay_s[*pair].iter().zip(&contacts.delay_rate[*pair]);
            for (a, (delay_s, rate)) in contacts.amplitude[channel].iter_mut().zip(courses) {
                let heard = self.illumination.heard_share(opens_s, *delay_s) > 0.0;
                if !(heard && rate.abs() < 1.0 && a.norm_sqr().is_finite()) {
                    *a = Complex64::ZERO;
                }
            }
        }
        for (delays_s, rates) in contacts.delay_s.iter_mut().zip(&mut contacts.delay_rate) {
            for (delay_s, rate) in delays_s.iter_mut().zip(rates) {
                if !(delay_s.is_finite() && rate.abs() < 1.0) {
                    (*delay_s, *rate) = (0.0, 0.0);
                }
            }
        }
        Ok(opens_s)
    }

    /// Doppler of the points of a stretch.
    fn take_offsets(&mut self, exact: &[Contacts], lines: &[Vec<Line>], of_facets: &[(f64, f64)]) {
        let (scale, deviations) = (self.radar.carrier_hz, self.deviations());
        // As blocks weigh it: all channels of a pair.
        let mean_hz = |contacts: &Contacts, pair: usize| {
            let (mut power, mut sum) = of_facets[pair];
            for channel in &self.channels[pair] {
                for (a, rate) in contacts.amplitude[*channel].iter().zip(&contacts.delay_rate[pair]) {
                    sum += a.norm_sqr() * rate * scale;
                    power += a.norm_sqr();
                }
            }
            (power > 0.0).then(|| sum / power)
        };
        for (pair, channels) in self.channels.iter().enumerate() {
            let means: Vec<Option<f64>> = exact.iter().map(|contacts| mean_hz(contacts, pair)).collect();
            for (n, ((contacts, mean), lines)) in exact.iter().zip(&means).zip(lines).enumerate() {
                let Some(mean) = mean else { continue };
                let beside = [n.checked_sub(1), Some(n + 1)].into_iter().flatten();
                let drift_hz = beside
                    .filter_map(|n| means.get(n).copied().flatten())
                    .map(|other| (other - mean).abs())
                    .fold(0.0, f64::max);
                for &channel in channels {
                    let amplitude = &contacts.amplitude[channel];
                    let (mut all, mut second, mut fourth) = (0.0, 0.0, 0.0);
                    for (a, rate) in amplitude.iter().zip(&contacts.delay_rate[pair]) {
                        let (w, off) = (a.norm_sqr(), scale * rate - mean);
                        (all, second, fourth) = (all + w, second + w * off.powi(2), fourth + w * off.powi(4));
                    }
                    if all > 0.0 {
                        let power = lines[pair].most(deviations, |n| amplitude[n].norm());
                        let (rms_hz, fourth_hz) = ((second / all).sqrt(), (fourth / all).powf(0.25));
                        self.points.highest[channel] = self.points.highest[channel].max(power);
                        self.points.offsets.push(Offset { channel, power, rms_hz, fourth_hz, drift_hz });
                    }
                }
            }
        }
    }

    /// The worst pulse of some that have a cubic in common: three steps of gain.
    fn add_part(&self, exact: &[Contacts], lines: &[Vec<Line>], worst: &mut Powers) {
        let (turns_per_s, deviations) = (TAU * self.radar.carrier_hz, self.deviations());
        let (nodes, count) = nodes_within(exact.len());
        let nodes = &nodes[..count];
        for (pulse, own) in exact.iter().enumerate().filter(|(pulse, _)| !nodes.contains(pulse)) {
            let weights = through(nodes, pulse);
            for (channel, pair) in self.illumination.channel_pairs().iter().enumerate() {
                let off = |n: usize| {
                    let (delay_s, a) = (own.delay_s[*pair][n], own.amplitude[channel][n]);
                    let (mut late_s, mut found) = (0.0, Complex64::ZERO);
                    for (m, weight) in nodes.iter().zip(weights) {
                        late_s += weight * (exact[*m].delay_s[*pair][n] - delay_s);
                        found += exact[*m].amplitude[channel][n] * weight;
                    }
                    (found * Complex64::cis(-turns_per_s * late_s) - a).norm()
                };
                worst[channel] = worst[channel].max(lines[pulse][*pair].most(deviations, off));
            }
        }
    }
}

impl Points {
    /// What cubics between gains every so many pulses leave, by channel, where they were followed with these.
    pub fn swept(&self, gain_pulses: u64) -> Option<&Powers> {
        self.swept.iter().find(|(step, _)| *step == gain_pulses).map(|(_, powers)| powers)
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

/// First pulses of the stretches of a run; `loud` are pulses from the loudest on.
fn stretches(pulses: u64, points: u64, loud: &[(f64, u64)]) -> Vec<u64> {
    let most = (MOST_FOLLOWED / (points * LONGEST)).clamp(*STRETCHES.start(), *STRETCHES.end());
    let all = pulses.div_ceil(LONGEST);
    if all <= most {
        return (0..all).map(|n| n * LONGEST).collect();
    }
    let mut chosen = std::collections::BTreeSet::new();
    for (_, index) in loud {
        if chosen.len() as u64 >= most.div_ceil(2) {
            break;
        }
        chosen.insert(index / LONGEST);
    }
    let rest = most - chosen.len() as u64;
    chosen.extend((0..rest).map(|n| (all - 1) * n / (rest - 1).max(1)));
    chosen.into_iter().map(|n| n * LONGEST).collect()
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
        assert_eq!(stretches(1, 1, &[]), [0]);
        assert_eq!(stretches(130, 1, &[]), [0, 64, 128]);
        let loud = [(9.0, 640_000), (8.0, 640_001), (7.0, 3), (6.0, 500_000)];
        let found = stretches(800_000, 1, &loud);
        assert!(found.len() <= 64 && found.is_sorted(), "{found:?}");
        for index in [0, 640_000, 499_968, 799_936] {
            assert!(found.contains(&index), "{index}: {found:?}");
        }
        assert_eq!(stretches(800_000, 1_000_000, &loud), [640_000]);
        assert!(stretches(u64::MAX, 1, &[]).iter().all(|first| *first < u64::MAX));
    }

    #[test]
    fn doppler_follows_the_law_it_is_given() {
        let offset = |channel, power, rms_hz| Offset {
            channel,
            power,
            rms_hz,
            fourth_hz: 2.0 * rms_hz,
            drift_hz: 1.0,
        };
        let points = Points {
            power: vec![0.0; 3],
            offsets: vec![offset(0, 2.0, 10.0), offset(0, 1.0, 300.0), offset(1, 1.0, 0.0)],
            ..Points::default()
        };
        let close = |found: &Powers, wanted: [f64; 3]| {
            let near = |(a, b): (&f64, f64)| (a - b).abs() <= 1e-9 * b;
            assert!(found.iter().zip(wanted).all(near), "{found:?} {wanted:?}");
        };
        let square = Law::new(&points, false, |hz| 1e-12 * hz * hz);
        close(&points.doppler(&square, 1), [9e-8, 0.0, 0.0]);
        close(&points.doppler(&square, 3), [1e-12 * 301f64.powi(2), 1e-12, 0.0]);
        let fourth = Law::new(&points, true, |hz| 1e-20 * hz.powi(4));
        close(&points.doppler(&fourth, 1), [1e-20 * 600f64.powi(4), 0.0, 0.0]);
        let none = Points::default();
        assert_eq!(none.doppler(&Law::new(&none, true, |_| 1.0), 64), Powers::new());
    }
}
