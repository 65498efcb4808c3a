//! Targets and direct paths of a run.
//!
//! They are few, so they are followed themselves: at up to [`MOST_PROFILE`] pulses spread over the run for their power, and in
//! **stretches** of [`LONGEST`] successive pulses for what is left of them, all of the run where it is short, else those about the loudest
//! pulses, and some spread over it.
//!
//! Unlike facets they do not add with random phases from pulse to pulse: two in one resolution cell may add up in phase for a whole run.
//! So with `m_i` the modulus of what each adds, in amplitude or in error, a pulse has at most
//!
//! `W = sum over i of m_i * sum over j of m_j` , `|tau_j - tau_i|` within a cell,
//!
//! and where there is more than one point [`SIDE_LOBES`] times as much, for the range side lobes of neighbours.
//!
//! Limits: points that are loud for less than the pulses from one of the profile to the next may be missed.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::{LONGEST, Powers, Sounder, through};
use crate::radar::fault::RadarError;
use crate::radar::illumination::tiles::nodes_within;
use crate::scattering::contact::Contacts;

/// Points and pulses of a profile, at most, and pulses of it at least.
const MOST_PROFILE: u64 = 1 << 16;
const LEAST_PROFILE: u64 = 64;
/// Points and pulses of all stretches, at most; stretches at least, and at most.
const MOST_FOLLOWED: u64 = 1 << 17;
const STRETCHES: std::ops::RangeInclusive<u64> = 3..=64;
/// Dopplers of which a [`Law`] is told.
const KNOTS: usize = 6;

/// What the next cell adds, were its first side lobe in phase: -13.26 dB of a linear sweep.
const SIDE_LOBES: f64 = 1.22;

/// What the points of a run return.
#[derive(Clone, Debug, Default)]
pub struct Points {
    /// Mean power over the run, W.
    pub power: Powers,
    /// Most of a pulse, were all of a cell in phase, W.
    pub highest: Powers,
    /// The loudest pulse.
    pub loudest: u64,
    /// Largest rate of a delay.
    pub fastest: f64,
    /// First pulses of the stretches.
    stretches: Vec<u64>,
    /// Doppler at all pulses of the stretches.
    offsets: Vec<Offset>,
    /// What cubics leave that were asked for: steps of gain, and powers.
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

/// Room for the terms of a pulse: `(delay in cells, modulus)`.
type Terms = Vec<(f64, f64)>;

/// The most that terms add up to, all of a cell in phase.
fn in_phase(terms: &mut Terms) -> f64 {
    terms.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let (mut from, mut to, mut near, mut sum) = (0, 0, 0.0, 0.0);
    for (cell, modulus) in terms.iter() {
        while terms.get(to).is_some_and(|(other, _)| *other < cell + 1.0) {
            near += terms[to].1;
            to += 1;
        }
        while terms[from].0 <= cell - 1.0 {
            near -= terms[from].1;
            from += 1;
        }
        sum += modulus * f64::max(near, *modulus);
    }
    if terms.len() > 1 { SIDE_LOBES * sum } else { sum }
}

/// Numbers of `count` pulses in the middle of as many equal parts of a run.
fn spread_over(pulses: u64, count: u64) -> impl Iterator<Item = u64> {
    (0..count)
        .map(move |n| (u128::from(pulses) * u128::from(2 * n + 1) / u128::from(2 * count.max(1))) as u64)
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
        let points = self.illumination.point_count() as u64;
        if points == 0 || self.pulses == 0 {
            return Ok(());
        }
        let count = (MOST_PROFILE / points).max(LEAST_PROFILE).min(self.pulses);
        let mut loud = Vec::with_capacity(count as usize);
        let mut contacts = self.no_points();
        let mut terms = Terms::new();
        for index in spread_over(self.pulses, count) {
            self.points_at(index, &mut contacts)?;
            let mut all = 0.0;
            for (channel, pair) in self.illumination.channel_pairs().iter().enumerate() {
                let power: f64 = contacts.amplitude[channel].iter().map(Complex64::norm_sqr).sum();
                self.points.power[channel] += power / count as f64;
                all += power;
                let most = self
                    .most_in_phase(&contacts, *pair, &mut terms, |n| contacts.amplitude[channel][n].norm());
                self.points.highest[channel] = self.points.highest[channel].max(most);
            }
            loud.push((all, index));
            let rates = contacts.delay_rate.iter().flatten();
            self.points.fastest = rates.fold(self.points.fastest, |most, rate| most.max(rate.abs()));
        }
        loud.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.points.loudest = loud.first().map_or(0, |(_, index)| *index);
        self.points.stretches = stretches(self.pulses, points, &loud);
        Ok(())
    }

    /// Follows them through the stretches, once the facets' Doppler is known.
    pub(super) fn follow_points(&mut self) -> Result<(), RadarError> {
        // Of all facets, the mean of the places: power, and its sum with Doppler.
        let share = self.sampled() * self.places.len().max(1) as f64;
        let mut of_facets = vec![(0.0, 0.0); self.channels.len()];
        for (pair, hz, w) in &self.dopplers {
            let (power, weighted) = &mut of_facets[*pair];
            (*power, *weighted) = (*power + w / share, *weighted + w * hz / share);
        }
        let mut terms = Terms::new();
        for n in 0..self.points.stretches.len() {
            let contacts = self.stretch(n)?;
            self.take_offsets(&contacts, &of_facets, &mut terms);
        }
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

    /// Points of all pulses of a stretch.
    fn stretch(&mut self, n: usize) -> Result<Vec<Contacts>, RadarError> {
        let first = self.points.stretches[n];
        let mut found = Vec::new();
        for index in first..(first + LONGEST).min(self.pulses) {
            let mut contacts = self.no_points();
            self.points_at(index, &mut contacts)?;
            found.push(contacts);
        }
        Ok(found)
    }

    /// Points of a pulse; amplitudes are those of the part that the window hears, and courses of others are zero.
    pub(super) fn points_at(&mut self, index: u64, contacts: &mut Contacts) -> Result<(), RadarError> {
        self.illumination.points(index, &mut self.light, contacts)?;
        let opens_s = self.illumination.window_start_of(index)?;
        let closes_s = opens_s + self.radar.window.samples as f64 / self.radar.sample_rate_hz;
        for (channel, pair) in self.illumination.channel_pairs().iter().enumerate() {
            for (a, delay_s) in contacts.amplitude[channel].iter_mut().zip(&contacts.delay_s[*pair]) {
                let heard_s = (delay_s + self.pulse_s).min(closes_s) - delay_s.max(opens_s);
                let share = heard_s / self.pulse_s;
                let sounds = a.norm_sqr().is_finite() && share > 0.0;
                *a = if sounds { *a * share.min(1.0).sqrt() } else { Complex64::ZERO };
            }
        }
        for (delays_s, rates) in contacts.delay_s.iter_mut().zip(&mut contacts.delay_rate) {
            for (delay_s, rate) in delays_s.iter_mut().zip(rates) {
                if !(delay_s.is_finite() && rate.abs() < 1.0) {
                    (*delay_s, *rate) = (0.0, 0.0);
                }
            }
        }
        Ok(())
    }

    /// The most that something of the points of a pulse adds up to.
    fn most_in_phase(
        &self,
        contacts: &Contacts,
        pair: usize,
        terms: &mut Terms,
        modulus: impl Fn(usize) -> f64,
    ) -> f64 {
        terms.clear();
        let delays_s = contacts.delay_s[pair].iter().enumerate();
        terms.extend(delays_s.map(|(n, delay_s)| (delay_s * self.cells_per_s, modulus(n))));
        terms.retain(|(_, modulus)| *modulus > 0.0);
        in_phase(terms)
    }

    /// Doppler of the points of a stretch.
    fn take_offsets(&mut self, contacts: &[Contacts], of_facets: &[(f64, f64)], terms: &mut Terms) {
        let scale = self.radar.carrier_hz;
        let channel_pairs = self.illumination.channel_pairs();
        // As blocks weigh it: all channels of a pair.
        let mean_hz = |contacts: &Contacts, pair: usize| {
            let (mut power, mut sum) = of_facets[pair];
            for (channel, _) in channel_pairs.iter().enumerate().filter(|(_, own)| **own == pair) {
                for (a, rate) in contacts.amplitude[channel].iter().zip(&contacts.delay_rate[pair]) {
                    sum += a.norm_sqr() * rate * scale;
                    power += a.norm_sqr();
                }
            }
            (power > 0.0).then(|| sum / power)
        };
        for (pair, channels) in self.channels.iter().enumerate() {
            let means: Vec<Option<f64>> = contacts.iter().map(|contacts| mean_hz(contacts, pair)).collect();
            for (n, (contacts, mean)) in contacts.iter().zip(&means).enumerate() {
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
                        let power = self.most_in_phase(contacts, pair, terms, |n| amplitude[n].norm());
                        let (rms_hz, fourth_hz) = ((second / all).sqrt(), (fourth / all).powf(0.25));
                        self.points.highest[channel] = self.points.highest[channel].max(power);
                        self.points.offsets.push(Offset { channel, power, rms_hz, fourth_hz, drift_hz });
                    }
                }
            }
        }
    }

    /// What cubics through the instants of gain leave of points, `[step][channel]`: three steps of gain at a time.
    pub(super) fn gains_of_points(&mut self, steps: &[u64]) -> Result<Vec<Powers>, RadarError> {
        let known = |points: &Points, step: u64| points.swept.iter().any(|(own, _)| *own == step);
        let new: Vec<u64> = steps.iter().copied().filter(|step| !known(&self.points, *step)).collect();
        if !new.is_empty() {
            let mut worst = vec![vec![0.0f64; self.radar.channels.len()]; new.len()];
            let mut terms = Terms::new();
            for n in 0..self.points.stretches.len() {
                let exact = self.stretch(n)?;
                for (worst, &step) in worst.iter_mut().zip(&new) {
                    let length = (3 * step as usize).max(1);
                    for from in (0..exact.len()).step_by(length) {
                        let part = &exact[from..(from + length).min(exact.len())];
                        self.add_part(part, worst, &mut terms);
                    }
                }
            }
            self.points.swept.extend(new.into_iter().zip(worst));
        }
        let of = |step: &u64| self.points.swept.iter().find(|(own, _)| own == step);
        Ok(steps.iter().filter_map(of).map(|(_, powers)| powers.clone()).collect())
    }

    /// The worst pulse of some that have a cubic in common.
    fn add_part(&self, exact: &[Contacts], worst: &mut Powers, terms: &mut Terms) {
        let turns_per_s = TAU * self.radar.carrier_hz;
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
                worst[channel] = worst[channel].max(self.most_in_phase(own, *pair, terms, off));
            }
        }
    }
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
    fn terms_of_a_cell_add_in_phase() {
        // Alone, three of a cell, and a chain of which only neighbours are within a cell.
        assert_eq!(in_phase(&mut vec![(7.0, 3.0)]), 9.0);
        let of_all = |mut terms: Terms| in_phase(&mut terms) / SIDE_LOBES;
        for (terms, wanted) in [
            (vec![(7.2, 1.0), (7.0, 2.0), (7.9, 3.0)], 36.0),
            (vec![(0.0, 1.0), (0.75, 1.0), (1.5, 1.0)], 2.0 + 3.0 + 2.0),
            (vec![(0.0, 1.0), (1.0, 1.0), (5.0, 2.0)], 6.0),
        ] {
            assert!((of_all(terms.clone()) - wanted).abs() < 1e-12, "{terms:?}");
        }
        assert_eq!(in_phase(&mut Terms::new()), 0.0);
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
        assert_eq!(stretches(800_000, 1_000_000, &loud), [0, 640_000]);
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
