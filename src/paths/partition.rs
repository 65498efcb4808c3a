//! Where blocks of pulses end because a report changes, or a beam jumps.
//!
//! Antennas and gates that go by reports jump when a report is changed ([`crate::motion::changes`]), and no
//! interpolation knows of a jump. So blocks end at the first pulse whose emission comes a servo's lag after
//! the change; and, because axes of receive antennas are found over the time of flight, also at the first
//! that sees it in that time. Where windows receive several emissions these are cut there, too.

use std::ops::Range;

use super::{PathGenerator, beside};
use crate::motion::changes::Change;
use crate::radar::fault::mounts;
use crate::radar::window::Window;
use crate::scene::Radar;
use crate::scene::radar::{AimFrom, Gate};
use crate::time::TimeTag;

/// Times nearer than this are taken for the same, s: pulses are a nanosecond apart at least.
const TIE_S: f64 = 0.5e-9;

/// Platforms by whose reports something is aimed, and how late.
pub(super) fn report_steered(radar: &Radar) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    let mut note = |platform: Option<usize>, lag_s: f64| {
        if let Some(platform) = platform.filter(|platform| !found.contains(&(*platform, lag_s))) {
            found.push((platform, lag_s));
        }
    };
    for (_, mount) in mounts(radar) {
        if let Some(by) = mount.pointing.steering().filter(|by| by.from == AimFrom::Reported) {
            note(Some(mount.platform), by.lag_s);
            note(by.aim.and_then(beside), by.lag_s);
        }
    }
    for pair in radar.window_leads() {
        if let Gate::Follow { aim, aim_from: AimFrom::Reported, .. } = radar.gate(pair.receiver) {
            note(Some(radar.transmitters[pair.transmitter].antenna.platform), 0.0);
            note(Some(radar.receivers[pair.receiver].antenna.platform), 0.0);
            note(beside(aim), 0.0);
        }
    }
    found
}

/// After how many pulses beams jump, each once.
pub(super) fn dwells(radar: &Radar) -> Vec<u64> {
    let mut found: Vec<u64> =
        mounts(radar).filter_map(|(_, mount)| mount.pointing.dwell_pulses()).map(|n| n.max(1)).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Rounding of windows and emissions, s.
const GUARD_S: f64 = 1e-3;

impl PathGenerator {
    /// The last instant at which tracks are asked for pulses before `index`: what their windows receive of
    /// later emissions, the longest light time, and two pulses more.
    pub fn latest_state_needed(&self, index: u64) -> TimeTag {
        let window_s = self.radar.window.samples as f64 / self.radar.sample_rate_hz;
        let opens_s = |gate: &Gate| match gate {
            Gate::Fixed { start_s } => start_s.max(0.0),
            Gate::Follow { .. } => self.axes_span_s,
        };
        let gates = self.leads.iter().map(|lead| self.radar.gate(lead.receiver));
        let opens_s = gates.map(opens_s).fold(0.0, f64::max);
        let after_s = 2.0 * (self.axes_span_s + self.pulse_length_s) + opens_s + window_s + GUARD_S;
        self.pulse_time(index.saturating_add(2)).plus(after_s)
    }

    /// The part of a block of pulses, about one of them, in which no report jumps that something is aimed by,
    /// no beam does, and a patch that follows stays.
    pub fn unbroken(&self, block: Range<u64>, index: u64) -> Range<u64> {
        let mut part = block.clone();
        let mut cut = |pulse: u64| {
            if pulse <= index {
                part.start = part.start.max(pulse);
            } else {
                part.end = part.end.min(pulse);
            }
        };
        // In step with the patch: it holds for so many pulses from pulse 0 on.
        let in_step = self.radar.emissions.is_uniform() && self.radar.emissions.elapsed_s(0) == 0.0;
        if let (Some(hold), true) = (self.hold_pulses, in_step) {
            // Blocks divide it; emissions of before a block do not.
            [index / hold, index / hold + 1].map(|n| n.saturating_mul(hold)).into_iter().for_each(&mut cut);
        } else if let (Some(sea), false) = (&self.sea, in_step) {
            // Else a patch that follows need not move between two blocks.
            let placed_s = |pulse: u64| sea.placed_s(self.radar.emissions.elapsed_s(pulse));
            let moves = |pulse: &u64| placed_s(*pulse) != placed_s(pulse - 1);
            (block.start + 1..block.end).filter(|_| sea.moves()).filter(moves).for_each(&mut cut);
        }
        let stays = self.stays(index);
        [stays.start, stays.end].into_iter().for_each(&mut cut);
        for &(platform, lag_s) in &self.report_steered {
            let Some(changes) = self.tracks.get(platform).and_then(|of| of.reported.changes()) else {
                continue;
            };
            changes.read(|given| {
                for one in given {
                    // What a servo sees at once it sees at that very pulse, and while others are in the air.
                    if lag_s == 0.0 {
                        let at_s = self.pulse_times().elapsed_s(one.pulse);
                        let sees_s = at_s - self.axes_span_s;
                        let first =
                            if self.is_apart() { self.first_from(&block, at_s - TIE_S) } else { one.pulse };
                        cut(self.first_from(&block, sees_s - TIE_S).min(first));
                        cut(first);
                    }
                    let ends_s = match one.change {
                        Change::Dropout { seconds } => Some(one.t_s + seconds),
                        _ => None,
                    };
                    let begins_s = (lag_s > 0.0).then_some(one.t_s);
                    for jump_s in begins_s.into_iter().chain(ends_s) {
                        // Taken for a pulse a rounding before or after.
                        for tie_s in [-TIE_S, TIE_S] {
                            cut(self.first_from(&block, jump_s + lag_s + tie_s));
                        }
                        cut(self.first_from(&block, jump_s + lag_s - self.axes_span_s - TIE_S));
                    }
                }
            });
        }
        part
    }

    /// The first pulse of a block that is emitted so long after pulse 0; its end if there is none.
    fn first_from(&self, block: &Range<u64>, at_s: f64) -> u64 {
        let (mut low, mut high) = (block.start, block.end);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.radar.emissions.elapsed_s(middle) < at_s {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// How long after its emission a pulse still asks what platforms report, s: the latest echo that its
    /// window receives was sent that much later at most, and antennas are asked where they point a time of
    /// flight after that.
    pub fn asks_ahead_s(&self, index: u64) -> f64 {
        let window =
            self.hull_at(index).unwrap_or_else(|_| Window::new(&self.radar, 0.0, self.pulse_length_s));
        (window.close_s + window.guard_s).max(0.0) + self.axes_span_s
    }

    /// The first pulse whose reports nothing asks for that has to do with pulses up to `made`.
    pub fn first_untouched(&self, made: u64) -> u64 {
        let ahead_s = self.asks_ahead_s(made);
        let next = made.saturating_add(1);
        let (mut low, mut high) = (next, self.receiving_pulses().max(next));
        while low < high {
            let middle = low + (high - low) / 2;
            if self.pulse_times().interval_s(made, middle) <= ahead_s {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}
