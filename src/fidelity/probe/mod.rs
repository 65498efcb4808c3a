//! What the fast echo will leave out, found on a sample of what a run returns.
//!
//! Echoes of facets add with random phases, so errors add as powers, and the error of a pulse relative to the
//! echo is that of a sample of its facets, weighted by what they return. At a few **places** of the run some
//! [`TILES`] tiles, runs of neighbours from all over the patch, are illuminated at the instants of a block,
//! with all between interpolated as the echo does it, once as mainlobe tiles and once as sidelobe tiles; and
//! at **probes**, pulses between two nodes, as if these were nodes themselves. Sums are kept by the gain of a
//! run, so that they show what is left wherever sidelobe tiles begin
//! ([`sidelobe`](crate::fidelity::sidelobe)). With `a` the amplitude of a channel without gains, `G` the
//! gains and shadows, `tau` the delay, and a hat for what is interpolated,
//!
//! ```text
//! path = sum |a G|^2 (2 pi f0 (tau^ - tau))^2 ,   tilt = sum |a^ - a|^2 G^2 ,   gain = sum |a|^2 (G^ - G)^2   over  sum |a G|^2
//! ```
//!
//! at the worst probe and place; path and tilt at one and the same. What the worst pulse has more
//! than the sum, and what the sample may have missed, is in [`worst`](super::worst).
//!
//! Closed forms of flight, waves and gains are in `docs/physics.md` section 15.7; a sample also knows what
//! these do not: facets that turn away, nulls of scattering, waves of ships, shadows, heights
//! rounded to f32 (those of the nodes and those at a probe, so that once is counted twice).
//!
//! Gains are interpolated worst in the first and last interval of a block, where the cubics of path and tilt
//! are at their best: each probe takes the gain of its own interval.
//!
//! The mean power of facets is that of [`PROFILE`] pulses spread over the run, and the places are its
//! strongest one and both ends: what is in proportion to a pulse (images of the grid, say) weighs as its
//! power over the mean ([`ErrorSampler::peak`]).
//!
//! Targets and direct paths are few: they are followed themselves, in [`points`].
//!
//! Limits: [`TILES`] x 256 facets; a beam that illuminates fewer than some hundred of them is sampled poorly
//! (10 % of 100). What moves the platforms between the places is not seen.

mod exact;
mod interpolation_error;
mod known;
mod line;
mod omitted;
pub mod points;
mod profile;
mod pulses;
mod received;
mod sweep;

use std::ops::Range;

use self::known::Known;
use super::budget::BETWEEN_DB;
use super::turning::Cosines;
use super::worst::{Cells, Sum, deviations_of};
use crate::cpu::Variant;
use crate::fidelity::echo_settings::block_pulses;
use crate::fidelity::sidelobe::Candidates;
use crate::geometry::lanes::Row;
use crate::paths::block::probe::{Keep, SampledTile};
use crate::paths::block::{Fine, Instants, TileWork};
use crate::paths::{PathGenerator, Workspace};
use crate::radar::fault::RadarError;
use crate::radar::waveform::Waveform;
use crate::scene::{Patch, Radar};

use exact::ExactPulse;
use points::{Law, Points};

pub use interpolation_error::{InterpolationError, Probed};
pub use omitted::Omission;
use omitted::Omitted;
use pulses::point_step;
pub use pulses::{LONGEST, is_coarse, scattered_over, spread_over, unit_of};
pub use sweep::{Sweeps, Swept};

/// Tiles of 256 facets of a sample.
pub const TILES: usize = 64;
/// Pulses of the run whose power is taken.
pub const PROFILE: u64 = 48;
/// Groups of equal power by Doppler.
const GROUPS: usize = 6;
/// Patches up to so many facets are evaluated in more places.
const SMALL_FACETS: usize = 1 << 15;
/// Most power of the breaking waves and the rain of a pulse over the most that a few dozen pulses show: they
/// add with random phases, and come and go.
const MOST_OF_EXACT: f64 = 2.0;
/// Pulses in a period of the bandwidth of a tile from which on it may have supports.
const LEAST_PULSES_OF_BAND: f64 = 3.0;
/// Runs of no more pulses need none.
const FEW_PULSES: u64 = 32;
/// Powers by channel, W: the sum over a sample.
pub type Powers = Vec<f64>;

/// A block of the run.
#[derive(Clone, Debug)]
struct Place {
    first: u64,
    patch: Option<Patch>,
}

/// One tile and pair at a probe.
struct Truth {
    count: usize,
    /// Lanes of each run of neighbours, and bin of its gain.
    runs: Vec<(Range<usize>, usize)>,
    /// For each run, what of its peak the two-way gain of field has at most.
    gains: Vec<f32>,
    delay_s: Vec<f64>,
    rate: Vec<f64>,
    amplitude: Vec<[Row; 2]>,
    factor: Row,
    /// How much windows receive of each (`Hearing::share`).
    share: Vec<f64>,
    /// Cosines of the local angles, transmitter and receiver.
    cosine: [Row; 2],
}

impl Truth {
    /// Power of a facet in all channels of the pair.
    fn power(&self, i: usize) -> f64 {
        self.amplitude.iter().map(|a| square(a, i)).sum::<f64>() * f64::from(self.factor[i]).powi(2)
    }

    /// The same as the window receives it; 0 of what is no number.
    fn received(&self, i: usize) -> f64 {
        if self.share[i] > 0.0 { self.power(i) * self.share[i] } else { 0.0 }
    }

    /// Bandwidth of what its facets return, without that of their waves, Hz.
    fn bandwidth_hz(&self, radar: &Radar) -> f64 {
        let rates = self.rate[..self.count].iter().filter(|rate| rate.is_finite());
        let [least, most] =
            rates.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], rate| [a.min(*rate), b.max(*rate)]);
        radar.carrier_hz * (most - least).max(0.0) + radar.sample_rate_hz * most.abs().max(least.abs())
    }

    /// Power of a facet in the channel that receives most of it.
    fn strongest(&self, i: usize) -> f64 {
        self.amplitude.iter().map(|a| square(a, i)).fold(0.0, f64::max) * f64::from(self.factor[i]).powi(2)
    }
}

/// Samples the error on a run.
pub struct ErrorSampler<'a> {
    generator: &'a PathGenerator,
    radar: &'a Radar,
    pulse_s: f64,
    /// Resolution cells of a second of delay.
    cells_per_s: f64,
    pulses: u64,
    /// Pulses of a unit.
    unit: u64,
    /// Pulses from one at which points are looked at to the next.
    point_step: u64,
    memory: Workspace,
    tiles: Option<Box<TileWork>>,
    places: Vec<Place>,
    /// Channels of each pair.
    channels: Vec<Vec<usize>>,
    interval_s: f64,
    /// Whether some facets turn away from an antenna.
    turning: bool,
    /// `(pair, Doppler Hz, power W)` of facets, all places.
    dopplers: Vec<(usize, f64, f64)>,
    /// Breaking waves and rain of the pulses of the profile.
    exact_pulses: Vec<ExactPulse>,
    /// `[pair]`: power of the points at all places, and its sum with their Doppler.
    dopplers_of_points: Vec<(f64, f64)>,
    /// Largest rate of a delay of facets.
    fastest: f64,
    /// Mean power over the run, of facets and points, and what the facets of the strongest pulse may have.
    power: Powers,
    highest: Powers,
    /// The same of single pulses where an antenna scans, the strongest first.
    scanned: Vec<(u64, Powers)>,
    points: Points,
    omitted: Omitted,
    candidates: Candidates,
    /// Facets of each bin of gain, sum over the run.
    gains: Vec<f64>,
    /// Of the tiles of the sample at all places: how far their facets differ in Doppler, and how fast they
    /// move over the delay grid, Hz.
    bandwidths_hz: Vec<f64>,
    known: Known,
}

impl<'a> ErrorSampler<'a> {
    /// For a run of so many pulses in units of some, with the thresholds of sidelobe tiles and of
    /// those left out, and whether surfaces are found in f64; illuminates the sample once at every place.
    ///
    /// # Errors
    /// A track that ends before the run.
    pub fn new(
        generator: &'a PathGenerator,
        radar: &'a Radar,
        waveform: &dyn Waveform,
        (pulses, unit): (u64, u64),
        (sidelobe_db, cutoff_db, fine_surface): (Option<f64>, Option<f64>, bool),
    ) -> Result<Self, RadarError> {
        let candidates = Candidates::new(sidelobe_db);
        let bandwidth_hz = waveform.bandwidth_hz();
        let pairs = generator.pairs().len();
        let mut channels = vec![Vec::new(); pairs];
        for (channel, pair) in generator.channel_pairs().iter().enumerate() {
            channels[*pair].push(channel);
        }
        let all = radar.channels.len();
        let mut own = Self {
            generator,
            radar,
            pulse_s: waveform.duration_s(),
            cells_per_s: if bandwidth_hz > 0.0 { bandwidth_hz } else { radar.sample_rate_hz },
            pulses,
            unit,
            point_step: point_step(radar, unit),
            memory: generator.workspace(),
            tiles: generator.tile_work(
                Variant::fastest(),
                None,
                Fine { surface: fine_surface, shadows: true },
            ),
            places: Vec::new(),
            channels,
            interval_s: radar.emissions.mean_pri_s(),
            turning: false,
            dopplers: Vec::new(),
            exact_pulses: Vec::new(),
            dopplers_of_points: vec![(0.0, 0.0); pairs],
            fastest: 0.0,
            power: vec![0.0; all],
            highest: vec![0.0; all],
            scanned: Vec::new(),
            points: Points::default(),
            omitted: Omitted::new(all, cutoff_db),
            gains: vec![0.0; candidates.bins()],
            candidates,
            bandwidths_hz: Vec::new(),
            known: Known::default(),
        };
        own.find_points()?;
        let strongest = own.profile()?;
        // The last block of a run may be cut short.
        let longest = own.longest();
        let last = pulses.saturating_sub(longest / 2);
        let mut firsts: Vec<u64> = Vec::new();
        let between = (1..4).map(|n| last / 4 * n).filter(|_| own.is_small());
        for first in [strongest.min(last), 0, last].into_iter().chain(between) {
            if firsts.iter().all(|other| other.abs_diff(first) >= longest / 8) {
                firsts.push(first);
            }
        }
        for first in firsts {
            own.places.push(Place { first, patch: own.generator.patch_of(first)? });
            own.open(own.places.len() - 1)?;
        }
        Ok(own)
    }

    /// Whether facets turn away from an antenna at a pulse.
    fn find_turning(&mut self, truths: &[Truth]) {
        let mut cosines = vec![[Cosines::default(); 2]; self.channels.len()];
        for (n, truth) in truths.iter().enumerate() {
            for (of, cosine) in cosines[n % self.channels.len()].iter_mut().zip(&truth.cosine) {
                (0..truth.count).filter(|i| truth.share[*i] > 0.0).for_each(|i| of.add(cosine[i].into()));
            }
        }
        self.turning |= cosines.as_flattened().iter().any(Cosines::reach_zero);
    }

    /// Powers of a sample at a pulse, and those that the worst of pulses like it may have.
    fn powers(&mut self, index: u64, truths: &[Truth]) -> Result<[Powers; 2], RadarError> {
        let mut sums = vec![Sum::default(); self.power.len()];
        let (cells, weight, deviations) = (self.cells_at(index)?, self.sampled(), self.deviations());
        for (n, truth) in truths.iter().enumerate() {
            for (channel, a) in self.channels[n % self.channels.len()].iter().zip(&truth.amplitude) {
                for (lanes, _) in &truth.runs {
                    for i in lanes.clone().filter(|i| truth.share[*i] > 0.0) {
                        let w = square(a, i) * f64::from(truth.factor[i]).powi(2) * truth.share[i];
                        sums[*channel].add(w, cells.of(truth.delay_s[i]));
                    }
                    sums[*channel].close();
                }
            }
        }
        let worst = sums.iter().map(|sum| sum.worst_of_like(weight, deviations)).collect();
        Ok([sums.iter().map(Sum::mean).collect(), worst])
    }

    /// Whether blocks are interpolated at all; if not, every pulse is made by itself.
    pub fn interpolates(&self) -> bool {
        self.generator.overlap_pulses().is_some()
    }

    /// Whether some facets turn away from an antenna while they are received.
    pub fn turning(&self) -> bool {
        self.turning
    }

    /// What tiles may lack at their supports alone, where an error over the echo's power is asked; none where
    /// pulses lie so far apart that hardly any tile would have supports.
    pub fn between(&self, power: f64) -> Option<f64> {
        let mut bandwidths_hz = self.bandwidths_hz.clone();
        bandwidths_hz.sort_unstable_by(f64::total_cmp);
        let median_hz = bandwidths_hz.get(bandwidths_hz.len() / 2)?;
        let far = self.radar.emissions.mean_prf_hz() > LEAST_PULSES_OF_BAND * median_hz;
        let of_strongest = || power * 10f64.powf(-BETWEEN_DB / 10.0) / self.peak([1.0, 0.0]).max(1.0);
        // A facet that turns away does so at once.
        (far && self.pulses > FEW_PULSES && !self.turning).then(of_strongest)
    }

    /// Pulses of a unit.
    pub fn unit(&self) -> u64 {
        self.unit
    }

    /// Longest block, pulses.
    pub fn longest(&self) -> u64 {
        LONGEST * self.unit
    }

    /// How many places there are.
    pub fn places(&self) -> usize {
        self.places.len()
    }

    /// Pulses of the run and their power by channel, in the unit of [`Self::power`], the strongest first;
    /// empty where no antenna scans.
    pub fn scanned(&self) -> &[(u64, Powers)] {
        &self.scanned
    }

    /// Mean power over the run.
    pub fn power(&self) -> &Powers {
        &self.power
    }

    /// What is in proportion to the power of a pulse, in the strongest that there may be, over the mean of
    /// all: of the worst channel, with weights of facets and of points.
    pub fn peak(&self, [of_facets, of_points]: [f64; 2]) -> f64 {
        let both = self.highest.iter().zip(&self.points.highest);
        let highest = both.map(|(facets, points)| of_facets * facets + of_points * self.sampled() * points);
        self.worst_ratio(&highest.collect())
    }

    fn worst_ratio(&self, powers: &Powers) -> f64 {
        let received = powers.iter().zip(&self.power).filter(|(_, mean)| **mean > 0.0);
        received.map(|(own, mean)| own / mean).fold(0.0, f64::max)
    }

    /// Largest rate of a delay.
    pub fn fastest(&self) -> f64 {
        self.fastest.max(self.points.fastest)
    }

    /// Mean Doppler of each pair, and groups of facets of equal power with the rms of what is off it, Hz.
    pub fn dopplers(&self) -> Vec<(f64, Vec<f64>)> {
        let mut of_pairs = Vec::new();
        for pair in 0..self.channels.len() {
            let mut own: Vec<(f64, f64)> =
                self.dopplers.iter().filter(|(p, ..)| *p == pair).map(|(_, hz, w)| (*hz, *w)).collect();
            let all: f64 = own.iter().map(|(_, w)| w).sum();
            let (of_points, weighted) = self.dopplers_of_points[pair];
            if all + of_points <= 0.0 {
                continue;
            }
            let mean = (own.iter().map(|(hz, w)| hz * w).sum::<f64>() + weighted) / (all + of_points);
            own.sort_by(|a, b| (a.0 - mean).abs().total_cmp(&(b.0 - mean).abs()));
            let (mut groups, mut sums, mut passed) = (Vec::new(), (0.0, 0.0), 0.0);
            for (hz, w) in own {
                sums = (sums.0 + w * (hz - mean).powi(2), sums.1 + w);
                passed += w;
                if passed >= all * (groups.len() + 1) as f64 / GROUPS as f64 * (1.0 - 1e-9) {
                    groups.push((sums.0 / sums.1).sqrt());
                    sums = (0.0, 0.0);
                }
            }
            of_pairs.push((mean, groups));
        }
        of_pairs
    }

    fn open(&mut self, place: usize) -> Result<(), RadarError> {
        let first = self.places[place].first;
        let patch = self.places[place].patch;
        let truths = self.illuminate(first, patch.as_ref(), Keep::default())?;
        let (scale, pairs) = (self.radar.carrier_hz, self.channels.len());
        for (n, truth) in truths.iter().enumerate() {
            let pair = n % pairs;
            for i in 0..truth.count {
                let sum = truth.received(i);
                if sum > 0.0 {
                    self.dopplers.push((pair, scale * truth.rate[i], sum));
                    self.fastest = self.fastest.max(truth.rate[i].abs());
                }
            }
        }
        self.bandwidths_hz.extend(truths.iter().map(|truth| truth.bandwidth_hz(self.radar)));
        self.add_exact_at(first, patch.as_ref())?;
        self.add_points_at(first)
    }

    /// Whether the patch is so small that single facets count, and more instants cost little.
    fn is_small(&self) -> bool {
        self.generator.facets() <= SMALL_FACETS
    }

    /// Share of the facets that is in the sample; 1 without a sea.
    fn sampled(&self) -> f64 {
        self.generator.sampled(TILES)
    }

    /// Share of the facets in sidelobe tiles by the threshold of a candidate, mean over the run.
    pub fn sidelobe_share(&self, candidate: usize) -> f64 {
        let sidelobe =
            self.gains.iter().enumerate().filter(|(bin, _)| self.candidates.is_sidelobe(*bin, candidate));
        sidelobe.map(|(_, facets)| facets).sum::<f64>() / self.gains.iter().sum::<f64>().max(1.0)
    }

    /// Scattering epochs of a sidelobe tile: one in the middle of a block where facets turn away.
    pub fn sidelobe_epochs(&self) -> usize {
        if self.turning { 3 } else { 2 }
    }

    /// Gains below which tiles may be sidelobe tiles.
    pub fn candidates(&self) -> &Candidates {
        &self.candidates
    }

    /// The sample at a pulse, `[tile x pair]`.
    fn illuminate(&mut self, at: u64, patch: Option<&Patch>, keep: Keep) -> Result<Vec<Truth>, RadarError> {
        let mut truths = Vec::new();
        let (Some(patch), Some(tiles)) = (patch, &mut self.tiles) else { return Ok(truths) };
        let hearing = self.generator.hearing(at)?;
        let instants = Instants::of_block(at, 1, 1, 1).into();
        let candidates = &self.candidates;
        self.generator.sample_tiles(&instants, patch, TILES, keep, tiles, |sampled| {
            let (node, epoch) = (&sampled.of.nodes()[0].paths, &sampled.of.epochs()[0]);
            truths.push(Truth {
                count: sampled.count,
                runs: runs_of(sampled, candidates),
                gains: sampled.shares.to_vec(),
                delay_s: node.delay_s.to_vec(),
                rate: node.delay_rate.to_vec(),
                amplitude: epoch.rows(),
                factor: sampled.of.factor[0],
                share: node.delay_s.iter().map(|delay_s| hearing.share(sampled.pair, *delay_s)).collect(),
                cosine: epoch.cosine,
            });
        })?;
        Ok(truths)
    }

    /// First pulse of the block of the run that holds a place, with nodes so many pulses apart: where beams
    /// jump, one that ends before they do.
    pub fn block_of(&self, place: usize, node_pulses: u64) -> u64 {
        let (length, at) = (block_pulses(node_pulses), self.places[place].first);
        let stays = self.generator.stays(at);
        let latest = stays.end.saturating_sub(length).max(stays.start);
        (at / length * length).clamp(stays.start, latest)
    }

    /// Deviations up at which the worst pulse and channel of the run lies.
    fn deviations(&self) -> f64 {
        deviations_of(self.pulses.saturating_mul(self.power.len() as u64))
    }

    /// Resolution cells from the first delay on that windows receive of a pulse.
    fn cells_at(&self, index: u64) -> Result<Cells, RadarError> {
        let from_s = self.generator.hearing(index)?.opens_s() - self.pulse_s;
        Ok(Cells { from_s, per_s: self.cells_per_s })
    }
}

/// Lanes of the runs of a tile, and the bins of their gains.
fn runs_of(sampled: &SampledTile<'_>, candidates: &Candidates) -> Vec<(Range<usize>, usize)> {
    let mut at = 0;
    let lanes = sampled.runs.iter().map(|run| {
        at += run.count;
        at - run.count..at
    });
    lanes.zip(sampled.shares.iter().map(|share| candidates.bin(*share))).collect()
}

fn square([re, im]: &[Row; 2], i: usize) -> f64 {
    f64::from(re[i] * re[i] + im[i] * im[i])
}

/// Weights of the polynomial through values at some pulses, at a pulse, `at` being when these are.
fn through(places: &[usize], pulse: usize, at: impl Fn(usize) -> f64) -> [f64; 4] {
    let mut weights = [0.0; 4];
    for (n, (weight, own)) in weights.iter_mut().zip(places).enumerate() {
        let others = places.iter().enumerate().filter(|(m, _)| *m != n);
        *weight = others
            .fold(1.0, |product, (_, other)| product * (at(pulse) - at(*other)) / (at(*own) - at(*other)));
    }
    weights
}
