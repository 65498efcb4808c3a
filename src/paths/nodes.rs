//! Pulses of a block: whether they can be made together, their records, and their targets as scatterer paths
//! that can be interpolated.

use std::ops::Range;

use num_complex::Complex64;

use super::facets::Reception;
use super::{PathGenerator, Workspace};
use crate::paths::list::ScattererPaths;
use crate::pulse::costs::Stage;
use crate::pulse::{Pulse, flags};
use crate::radar::fault::RadarError;
use crate::scattering::target::most_of_run;
use crate::scene::target::Swerling;
use crate::scene::{Patch, Target};

/// Draws of all targets of which the largest is looked for, not bounded.
const MOST_DRAWS: u64 = 1 << 18;

/// What cubics leave of a point that turns, over what they leave where they begin elsewhere.
const TURNING: f64 = 1.5;

/// Longest block for which a dwell is to have a divisor of at least half its length.
const LONGEST_OF_DWELL: u64 = 64;

/// Whether a dwell has divisors near every length of a block.
fn divides_well(dwell: u64) -> bool {
    let near = |length: u64| (length.div_ceil(2)..=length).any(|n| dwell.is_multiple_of(n));
    (4..=LONGEST_OF_DWELL.min(dwell)).all(near)
}

impl PathGenerator {
    /// Power of points in the channels of a pair, each by its own share, and the sum of powers and delay
    /// rates.
    pub fn rates(&self, paths: &ScattererPaths, pair: usize, share: impl Fn(f64) -> f64) -> (f64, f64) {
        let (mut power, mut sum) = (0.0, 0.0);
        for (channel, _) in self.channel_pairs().iter().enumerate().filter(|(_, own)| **own == pair) {
            let courses = paths.delay_s[pair].iter().zip(&paths.delay_rate[pair]);
            for (a, (delay_s, rate)) in paths.amplitude[channel].iter().zip(courses) {
                let own = share(*delay_s) * a.norm_sqr();
                if own.is_finite() && rate.abs() < 1.0 {
                    (power, sum) = (power + own, sum + own * rate);
                }
            }
        }
        (power, sum)
    }

    /// Start of a window of a pulse after its emission, s; with clock errors, the true one.
    ///
    /// # Errors
    /// A receive window that follows a platform whose track does not cover the pulse.
    pub fn window_start_of(&self, window: usize, index: u64) -> Result<f64, RadarError> {
        self.window_start_s(window, index, self.pulse_time(index))
    }

    /// The same of the window of a pair; where pulses are not those emitted, that of an emission.
    ///
    /// # Errors
    /// Those of [`Self::window_start_of`].
    pub fn pair_start_of(&self, pair: usize, index: u64) -> Result<f64, RadarError> {
        let window = self.plans.get(pair).map_or(0, |plan| plan.window);
        if self.is_apart() {
            // That of an emission, whichever pulse receives it.
            return self.nominal_start_s(window, index, self.radar.emissions.emission(self.start, index));
        }
        self.window_start_of(window, index)
    }

    /// Pulses that blocks are to divide, from pulse 0 on: those for which a patch that follows stays where it
    /// is, or else a beam that jumps. `None` where both stay for good, and where blocks that divide a dwell
    /// would be far shorter than others: these are cut where it ends.
    pub fn hold_pulses(&self) -> Option<u64> {
        self.hold_pulses.or_else(|| self.dwells.first().copied().filter(|dwell| divides_well(*dwell)))
    }

    /// Whether a patch that follows is held for some pulses.
    pub fn holds_patch(&self) -> bool {
        self.hold_pulses.is_some()
    }

    /// Pulses about one of them in which no beam jumps.
    pub fn stays(&self, index: u64) -> Range<u64> {
        let of = |dwell: &u64| index / dwell * dwell..(index / dwell + 1).saturating_mul(*dwell);
        self.dwells.iter().map(of).fold(0..u64::MAX, |a, b| a.start.max(b.start)..a.end.min(b.end))
    }

    /// The patch at a pulse; `None` for a scene without sea.
    ///
    /// # Errors
    /// A patch that follows a platform whose track does not cover the pulse.
    pub fn patch_of(&self, index: u64) -> Result<Option<Patch>, RadarError> {
        let Some(sea) = &self.sea else { return Ok(None) };
        let patch = sea.patch_at(&self.surroundings(), self.radar.emissions.elapsed_s(index));
        Ok(Some(patch.map_err(|failure| self.track_error(index, failure))?))
    }

    /// Index, time, window start, navigation, phase centres and target truth of a pulse, without its
    /// scatterer paths; see [`Self::pulse`]. Nothing of an emitter.
    ///
    /// # Errors
    /// A pulse outside of the run, or that its tracks do not cover.
    pub fn record(
        &self,
        index: u64,
        workspace: &mut Workspace,
        record: &mut Pulse,
    ) -> Result<(), RadarError> {
        if index >= self.receiving_pulses() {
            return Err(RadarError::NoSuchPulse { index, pulses: self.receiving_pulses() });
        }
        if self.is_apart() {
            return self.fill_record_apart(index, workspace, record);
        }
        let Workspace { own, amplitude, ships, costs, windows, .. } = workspace;
        self.evaluate(index, own)?;
        self.fill_record(index, own, record)?;
        self.recorded_windows(record, windows);
        let reception = self.reception(index, index, own, windows);
        for (point, of_pairs) in own.paths.chunks_exact(self.pairs.len().max(1)).enumerate() {
            if self.weigh(&reception, point, of_pairs, amplitude) {
                record.flags |= flags::OUTSIDE_WINDOW;
            }
        }
        if record.flags & flags::OUTSIDE_WINDOW == 0 && self.ships_reach_outside(index, &reception, ships)? {
            record.flags |= flags::OUTSIDE_WINDOW;
        }
        costs.lap(Stage::Record);
        Ok(())
    }

    /// Targets, their images in the sea, direct paths and panels of ships of a pulse, always the same ones in
    /// the same order, whether they are received or not, with their steady amplitudes: without
    /// [`Self::variations`].
    ///
    /// # Errors
    /// A pulse outside of the run, or that its tracks do not cover.
    pub fn points(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        self.steady_targets(index, workspace, paths)?;
        if !self.ships.is_empty() {
            let Workspace { own, ships, .. } = workspace;
            let reception = self.reception_of_all(index, own, &[]);
            self.append_every_panel(&reception, ships.mesh(), paths);
        }
        Ok(())
    }

    /// The same without panels of ships.
    ///
    /// # Errors
    /// Those of [`Self::points`].
    pub fn steady_targets(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        if index >= self.pulses {
            return Err(RadarError::NoSuchPulse { index, pulses: self.pulses });
        }
        let Workspace { own, amplitude, .. } = workspace;
        paths.clear();
        self.evaluate(index, own)?;
        own.variation.clear();
        let reception = self.reception_of_all(index, own, &[]);
        self.append_every(&reception, amplitude, paths);
        Ok(())
    }

    /// The points of which the mean Doppler of a block is taken: targets as in [`Self::points`], and some of
    /// the panels of ships for all of them, as they are at the pulse.
    ///
    /// # Errors
    /// Those of [`Self::points`].
    pub fn points_of_mean(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        self.steady_targets(index, workspace, paths)?;
        if !self.ships.is_empty() {
            let Workspace { own, ships, .. } = workspace;
            let reception = self.reception_of_all(index, own, &[]);
            self.append_some_panels(index, &reception, ships.mesh(), paths)?;
        }
        Ok(())
    }

    /// Whether the amplitude of any point varies otherwise than with its path.
    pub fn varies(&self) -> bool {
        self.targets_vary() || !self.ships.is_empty()
    }

    /// Whether that of any target does.
    pub fn targets_vary(&self) -> bool {
        self.circumstances().varies()
    }

    /// Whether directions to targets are found at every pulse, for cross sections that depend on them.
    pub fn follows_aspects(&self) -> bool {
        !self.aspects.is_empty()
    }

    /// The most that each target returns at any pulse of the run over its mean, as far as it fluctuates;
    /// empty where none does.
    pub fn most_of_run(&self) -> Vec<f64> {
        let fluctuating = self.targets.iter().filter(|target| target.swerling != Swerling::Steady).count();
        if fluctuating == 0 {
            return Vec::new();
        }
        let length_s = self.radar.emissions.interval_s(0, self.pulses.saturating_sub(1));
        let draws = MOST_DRAWS / fluctuating as u64;
        let of = |(number, target): (u64, &Target)| {
            most_of_run(target.swerling, self.seed, number, self.pulses, length_s, draws)
        };
        (0..).zip(&self.targets).map(of).collect()
    }

    /// What may be left of a point in a run over what was found where some of it was looked at, of points
    /// that waves move: `unseen`; of those that turn at least [`TURNING`].
    pub fn left_unseen(&self, point: usize, unseen: f64) -> f64 {
        let of = |waves: bool, turns: bool| {
            let least = if turns { TURNING } else { 1.0 };
            if waves || turns { unseen.max(least) } else { 1.0 }
        };
        let first_panel = self.target_count();
        if point >= first_panel {
            let [waves, turns] = self.ships.is_moved(point - first_panel);
            return of(waves, turns);
        }
        let image = point.checked_sub(self.targets.len()).and_then(|n| self.images.get(n));
        let target = image.map_or(point, |image| image.target);
        let turns = self.targets.get(target).is_some_and(|target| target.trajectory.is_some());
        of(self.heaves.get(target).is_some_and(Option::is_some), turns)
    }

    /// What multiplies the steady amplitudes of [`Self::points`] at a pulse, `[point][pair]`; with
    /// [`Self::most_of_run`] in place of the draws of the pulse, and with nothing hidden by crests, where it
    /// is given.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover.
    pub fn variations(
        &self,
        index: u64,
        most_of_run: Option<&[f64]>,
        workspace: &mut Workspace,
        out: &mut Vec<f64>,
    ) -> Result<(), RadarError> {
        self.target_variations(index, most_of_run, workspace, out)?;
        if self.ships.is_empty() {
            return Ok(());
        }
        let Workspace { own, ships, .. } = workspace;
        self.evaluate(index, own)?;
        let reception = self.reception_of_all(index, own, &[]);
        let targets = out.len();
        self.ship_weights(index, reception.elapsed_s, out)?;
        self.apply_gains(&reception, ships.mesh(), &mut out[targets..]);
        Ok(())
    }

    /// The same of points that are no panels.
    ///
    /// # Errors
    /// Those of [`Self::variations`].
    pub fn target_variations(
        &self,
        index: u64,
        most_of_run: Option<&[f64]>,
        workspace: &mut Workspace,
        out: &mut Vec<f64>,
    ) -> Result<(), RadarError> {
        let own = &mut workspace.own;
        if !self.aspects.is_empty() {
            self.evaluate(index, own)?;
        }
        let elapsed_s = self.radar.emissions.elapsed_s(index);
        own.vary(&self.circumstances(), index, elapsed_s, most_of_run)
            .map_err(|failure| self.track_error(index, failure))?;
        out.clone_from(&own.variation);
        out.resize(self.target_count() * self.pairs.len(), 1.0);
        Ok(())
    }

    /// How many of them there are.
    pub fn point_count(&self) -> usize {
        self.target_count() + self.ships.len()
    }

    /// How many of them are no panels of ships: they come first.
    pub fn target_count(&self) -> usize {
        self.targets.len() + self.images.len() + usize::from(self.radar.direct_path)
    }

    /// Appends targets and direct paths whether they are received or not.
    fn append_every(&self, reception: &Reception, amplitude: &mut [Complex64], paths: &mut ScattererPaths) {
        for (point, of_pairs) in reception.emission.paths.chunks_exact(self.pairs.len().max(1)).enumerate() {
            self.weigh(reception, point, of_pairs, amplitude);
            paths.push(reception.offset_s, of_pairs.iter().map(|p| (p.delay_s, p.delay_rate)), amplitude);
        }
    }
}
