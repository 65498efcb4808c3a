//! Panels of ships by lists of their numbers, many at a time: for blocks of pulses, and for what these are
//! predicted to leave.
//!
//! Gains of antennas that are real numbers can be left out of the amplitudes, so that what is left changes as
//! slowly as panels turn: they multiply it at every pulse then, with the share that is not hidden
//! ([`crate::paths::block`]), and are never interpolated.

use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use super::Ships;
use super::lanes::{Batch, Instant, WIDTH};
use super::pose::Pose;
use crate::cpu::Variant;
use crate::frames::{Earth, Vector};
use crate::geometry::lanes::End;
use crate::motion::pointing::PhaseCentre;
use crate::paths::emission::{Emission, TrackFailure};
use crate::paths::facets::Reception;
use crate::paths::list::ScattererPaths;
use crate::paths::{PairPlan, PathGenerator};
use crate::radar::fault::{RadarError, TrackUse, mounts};
use crate::radar::polarisation::{Axes, port_shares};

/// Panels of which the mean Doppler of a block is taken, at most, or nearly so.
const MOST_OF_MEAN: usize = 512;

/// What antennas see of ships about some pulses.
#[derive(Clone, Default)]
pub(in crate::paths) struct Sight {
    first: i64,
    /// `[pulse]`: time sample before it, from the first on, and how far it is from there to the next.
    pulses: Vec<(usize, f64)>,
    /// `[knot][pair][element]`, words of bits.
    words: Vec<u64>,
    /// Words of a pair.
    length: usize,
    pairs: usize,
}

impl Sight {
    /// Bits of a pair at a time sample.
    fn bits(&self, knot: usize, pair: usize) -> &[u64] {
        let from = (knot * self.pairs + pair) * self.length;
        self.words.get(from..from + self.length).unwrap_or_default()
    }

    /// Share of the field of an element that is not hidden at a pulse, over a pair.
    pub fn share(&self, pulse: usize, pair: usize, element: u32) -> f64 {
        let (knot, share) = self.pulses[pulse];
        let [before, after] = [knot, knot + 1].map(|knot| self.sees(knot, pair, element));
        before + share * (after - before)
    }

    /// Knot before a pulse, and how far it is from there to the next.
    pub fn about(&self, pulse: usize) -> (usize, f64) {
        self.pulses[pulse]
    }

    /// 1 where both antennas of a pair see an element at a time sample.
    pub fn sees(&self, knot: usize, pair: usize, element: u32) -> f64 {
        let word = self.bits(knot, pair).get(element as usize / 64).copied().unwrap_or_default();
        f64::from((word >> (element % 64)) as u8 & 1)
    }

    /// Numbers of the elements that any pair sees at any time sample, ascending.
    pub fn seen(&self, out: &mut Vec<u32>) {
        out.clear();
        for word in 0..self.length {
            let mut bits = self.words.iter().skip(word).step_by(self.length).fold(0, |all, own| all | own);
            while bits != 0 {
                out.push(64 * word as u32 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
    }
}

/// Buffers for panels by lists; one per thread.
#[derive(Clone)]
pub(in crate::paths) struct MeshWork {
    pub variant: Variant,
    batch: Box<Batch>,
    pub sight: Sight,
    elements: Vec<u32>,
}

impl MeshWork {
    pub fn new(variant: Variant) -> Self {
        Self { variant, batch: Batch::boxed(), sight: Sight::default(), elements: Vec::new() }
    }
}

/// Which gains are in an amplitude.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::paths) enum With {
    /// All.
    Gains,
    /// Those that are no real numbers.
    ComplexGains,
}

impl PathGenerator {
    /// What antennas see of ships about some pulses.
    ///
    /// # Errors
    /// Tracks that do not cover them.
    pub(in crate::paths) fn see_ships(
        &self,
        pulses: impl Iterator<Item = u64>,
        sight: &mut Sight,
    ) -> Result<(), RadarError> {
        let Sight { first, pulses: about, words, length, pairs } = sight;
        about.clear();
        words.clear();
        (*length, *pairs) = (self.ships.len().div_ceil(64), self.pairs.len());
        let (mut after, mut last, mut spans) = (0, 0, 0.0);
        for index in pulses {
            let (knot, share) = Ships::knot_before(self.radar.emissions.elapsed_s(index));
            if about.is_empty() {
                (*first, after) = (knot, knot);
            }
            about.push(((knot - *first) as usize, share));
            (after, last) = (after.max(knot + 2), index);
            spans = (knot - *first) as f64 + share - about[0].1;
        }
        // As many as any block of this length may have, wherever it begins between time samples.
        words.reserve((spans.max(0.0).ceil() as usize + 3) * *pairs * *length);
        let (place, ends) = ((&self.frame, self.hills.as_deref()), &self.ends);
        let centre = |antenna: usize, time_s: f64| self.antenna_at(antenna, time_s);
        for knot in *first..after {
            self.ships
                .seen_at(place, knot, ends, centre, words)
                .map_err(|failure| self.track_error(last, failure))?;
        }
        Ok(())
    }

    /// Where an antenna is at a time after pulse 0.
    pub(in crate::paths) fn antenna_at(
        &self,
        antenna: usize,
        time_s: f64,
    ) -> Result<PhaseCentre, TrackFailure> {
        let Some((_, mount)) = mounts(&self.radar).nth(antenna) else {
            return Ok(PhaseCentre::at_rest(crate::frames::Point::from_raw(DVec3::ZERO)));
        };
        let (platform, which) = (mount.platform, TrackUse::Truth);
        let state = self.tracks[platform].truth.state(self.start.plus(time_s));
        let state = state.map_err(|source| TrackFailure { platform, which, source })?;
        Ok(PhaseCentre::of(&state, mount.lever_arm))
    }

    /// A pair at an emission.
    fn pair_at(&self, plan: &PairPlan, emission: &Emission) -> Instant {
        let [tx, rx] = plan.ends(self.radar.transmitters.len());
        let bases = [tx, rx].map(|antenna| emission.basis(antenna));
        let span_s = self.axes_span_s;
        let change_per_s = if span_s > 0.0 {
            (emission.basis_after(rx, span_s, span_s).axes - bases[1].axes) * (1.0 / span_s)
        } else {
            Axes::ZERO
        };
        Instant {
            transmitter: End::from(&emission.centres[tx]),
            receiver: End::from(&emission.centres[rx]),
            bases,
            change_per_s,
            wave_number_rad_m: TAU / self.radar.wavelength_m(),
        }
    }

    /// Appends what panels return by themselves, whether they are hidden or received or not, those that
    /// return nothing too; `each` has every pair and batch, and how many elements were before it.
    pub(in crate::paths) fn append_panels(
        &self,
        reception: &Reception,
        elements: &[u32],
        with: With,
        work: &mut MeshWork,
        paths: &mut ScattererPaths,
        mut each: impl FnMut(usize, &Batch, usize),
    ) {
        let Reception { emission, elapsed_s, offset_s, .. } = *reception;
        let (variant, mut before) = (work.variant, 0);
        self.ships.batches(&self.frame, elapsed_s, elements, &mut work.batch, |batch, pose, _| {
            paths.emission_offset_s.extend((0..batch.count).map(|_| offset_s));
            for (pair, plan) in self.plans.iter().enumerate() {
                let of = self.pair_at(plan, emission);
                batch.solve(variant, pose, &of);
                batch.scatter(variant, pose, &of);
                paths.delay_s[pair].extend_from_slice(&batch.delay_s[..batch.count]);
                paths.delay_rate[pair].extend_from_slice(&batch.delay_rate[..batch.count]);
                self.append_amplitudes(plan, reception, (batch, pose), with, paths);
                each(pair, batch, before);
            }
            before += batch.count;
        });
    }

    /// Amplitudes of a batch in the channels of a pair.
    fn append_amplitudes(
        &self,
        plan: &PairPlan,
        reception: &Reception,
        (batch, pose): (&Batch, &Pose),
        with: With,
        paths: &mut ScattererPaths,
    ) {
        let Reception { emission, tx_pol, .. } = *reception;
        let mut scales = [Complex64::ZERO; WIDTH];
        for (i, scale) in scales[..batch.count].iter_mut().enumerate() {
            let strength = Complex64::new(batch.strength[0][i], batch.strength[1][i]);
            let [out_m, back_m] = [0, 1].map(|leg| batch.leg_m[leg][i]);
            *scale = strength * plan.link.scattered(out_m, back_m);
            if self.frame.hiding_earth() != Earth::Flat && *scale != Complex64::ZERO {
                *scale *= self.passes_horizon_of_ship(plan, emission, batch.meets(pose, i));
            }
            *scale *= self.gain_of(plan, emission, (batch, i), |real| with == With::Gains || !real);
        }
        let tx_errors = self.radar.transmitters[plan.pair.transmitter].antenna.ports;
        let rx_errors = self.radar.receivers[plan.pair.receiver].antenna.ports;
        for &(channel, tx_port, rx_port) in &plan.channels {
            let column = &mut paths.amplitude[channel];
            if tx_pol.is_some_and(|port| port != tx_port) {
                column.extend((0..batch.count).map(|_| Complex64::ZERO));
                continue;
            }
            let (sent, received) = (port_shares(tx_port, tx_errors), port_shares(rx_port, rx_errors));
            let coupled = [0, 1].map(|to| [0, 1].map(|from| received[to] * sent[from]));
            column.extend(scales[..batch.count].iter().enumerate().map(|(i, scale)| {
                let of = |to: usize, from: usize| coupled[to][from] * batch.coupled[to][from][i];
                let rises = batch.directions(i).map(|direction| direction.z);
                let legs_m = [0, 1].map(|leg| batch.leg_m[leg][i]);
                let rain = plan.link.in_rain([tx_port, rx_port], legs_m, rises);
                scale * (of(0, 0) + of(0, 1) + of(1, 0) + of(1, 1)) * rain
            }));
        }
    }

    /// Product of the gains of both antennas of a pair towards a path, of those that count.
    fn gain_of(
        &self,
        plan: &PairPlan,
        emission: &Emission,
        (batch, i): (&Batch, usize),
        counts: impl Fn(bool) -> bool,
    ) -> Complex64 {
        let [tx, rx] = plan.ends(self.radar.transmitters.len());
        let [incident, scattered] = batch.directions(i);
        let mut product = Complex64::ONE;
        for (antenna, after_s, towards) in [(tx, 0.0, incident), (rx, batch.delay_s[i], -scattered)] {
            let of = &self.antennas[antenna];
            if counts(of.is_real()) {
                let axes = emission.axes_after(antenna, after_s, self.axes_span_s);
                product *= of.field_gain(Vector::from_raw(axes.transpose() * towards));
            }
        }
        product
    }

    /// Appends every panel of an emission, without the gains that are real.
    pub(in crate::paths) fn append_every_panel(
        &self,
        reception: &Reception,
        work: &mut MeshWork,
        paths: &mut ScattererPaths,
    ) {
        let elements = self.elements_by(1, work);
        self.append_panels(reception, &elements, With::ComplexGains, work, paths, |_, _, _| {});
        work.elements = elements;
    }

    /// Appends so many of the panels, evenly chosen, that their mean Doppler is that of all: as seen at a
    /// pulse, with all gains, and so much stronger as they are fewer.
    pub(in crate::paths) fn append_some_panels(
        &self,
        index: u64,
        reception: &Reception,
        work: &mut MeshWork,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let step = self.ships.len().div_ceil(MOST_OF_MEAN).max(1);
        let elements = self.elements_by(step, work);
        let first = paths.len();
        self.append_panels(reception, &elements, With::Gains, work, paths, |_, _, _| {});
        let found = self.see_ships(std::iter::once(index), &mut work.sight);
        for (pair, plan) in self.plans.iter().enumerate().filter(|_| found.is_ok()) {
            for (n, element) in elements.iter().enumerate() {
                let share = work.sight.share(0, pair, *element) * (step as f64).sqrt();
                plan.channels.iter().for_each(|(channel, ..)| paths.amplitude[*channel][first + n] *= share);
            }
        }
        work.elements = elements;
        found
    }

    /// Multiplies the shares of all panels that are not hidden, `[element][pair]`, by the gains that are
    /// real.
    pub(in crate::paths) fn apply_gains(
        &self,
        reception: &Reception,
        work: &mut MeshWork,
        shares: &mut [f64],
    ) {
        let Reception { emission, elapsed_s, .. } = *reception;
        let elements = self.elements_by(1, work);
        let (variant, pairs) = (work.variant, self.plans.len());
        self.ships.batches(&self.frame, elapsed_s, &elements, &mut work.batch, |batch, pose, numbers| {
            for (pair, plan) in self.plans.iter().enumerate() {
                batch.solve(variant, pose, &self.pair_at(plan, emission));
                for (i, number) in numbers.iter().enumerate() {
                    let share = &mut shares[*number as usize * pairs + pair];
                    if *share != 0.0 {
                        *share *= self.gain_of(plan, emission, (batch, i), |real| real).re;
                    }
                }
            }
        });
        work.elements = elements;
    }

    /// Every so many-th panel.
    fn elements_by(&self, step: usize, work: &mut MeshWork) -> Vec<u32> {
        let mut elements = std::mem::take(&mut work.elements);
        elements.clear();
        elements.extend((0..self.ships.len() as u32).step_by(step));
        elements
    }
}
