//! Which emissions the windows of pulses receive, over a block and over a run.
//!
//! A block of pulses needs the **emissions** that any of its windows receives: mostly its own, and where
//! echoes overlap the next window, or come several intervals late, some of before it. Delays are bounded at a
//! few pulses of the block, widened by how fast they may change in between; what each window receives follows
//! from its own start, as for a pulse by itself.

use std::ops::Range;

use super::{Emission, MANOEUVRE_MPS, PathGenerator, Reception, Workspace};
use crate::motion::pointing::PhaseCentre;
use crate::paths::block::{NODES, nodes_within};
use crate::paths::hearing::Hearing;
use crate::radar::fault::RadarError;
use crate::radar::window::Window;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Most emissions that the window of a pulse made in a block receives.
pub const MOST_RECEIVED: u64 = 16;
/// Most pulses in the air at once that are searched where intervals differ.
const MOST_IN_AIR: u64 = 256;

/// What pulses receive: how many intervals before or after its own an emission may be, hulls over a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct InAir {
    /// Numbers of emissions less that of the pulse.
    lags: Range<i64>,
    /// Most of a pulse.
    most: u64,
}

/// The emissions that each pulse of a block receives.
#[derive(Clone, Debug, Default)]
pub struct Received {
    of_pulses: Vec<Range<u64>>,
    emissions: Range<u64>,
    alone: bool,
}

impl InAir {
    /// Where emissions are not those of the pulses.
    pub(super) fn of_others() -> Self {
        Self { lags: 0..2, most: 1 }
    }
}

impl Received {
    /// All emissions that are needed: those of the pulses where each receives nothing but its own.
    pub fn emissions(&self) -> Range<u64> {
        self.emissions.clone()
    }

    /// Emissions of each pulse.
    pub fn of_pulses(&self) -> &[Range<u64>] {
        &self.of_pulses
    }

    /// Those of some emissions that are received, from the first to the last; `None` where none is.
    pub fn within(&self, emissions: &Range<u64>) -> Option<Range<u64>> {
        let own = |of: &Range<u64>| of.start.max(emissions.start)..of.end.min(emissions.end);
        let held = self.of_pulses.iter().map(own).filter(|of| !of.is_empty());
        held.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end))
    }

    /// Whether each pulse receives nothing but its own emission, if at all.
    pub fn is_alone(&self) -> bool {
        self.alone
    }

    /// Most emissions that a pulse receives.
    fn most(&self) -> u64 {
        self.of_pulses.iter().map(|of| of.end - of.start).max().unwrap_or(0)
    }
}

impl PathGenerator {
    /// What the windows of a few dozen pulses spread over the run receive.
    pub(super) fn find_in_air(&self) -> Result<InAir, RadarError> {
        let (mut emission, mut found) = (Emission::default(), None::<InAir>);
        for index in if self.pulses > 0 { Some(self.checked_pulses()) } else { None }.into_iter().flatten() {
            self.evaluate(index, &mut emission)?;
            let window = self.hull_at(index)?;
            let of = self.emissions_in_window(index, &emission, &window)?;
            // The ends of a run lack what is before and after it.
            if !of.is_empty() {
                let [start, end] = [of.start, of.end].map(|n| n as i64 - index as i64);
                let own = found.get_or_insert(InAir { lags: start..end, most: 0 });
                own.lags = own.lags.start.min(start)..own.lags.end.max(end);
                own.most = own.most.max(of.end - of.start);
            }
        }
        Ok(found.unwrap_or(InAir { lags: 0..1, most: 1 }))
    }

    /// Whether every pulse receives nothing but its own emission, at a few dozen instants of the run.
    pub fn receives_itself_alone(&self) -> bool {
        self.in_air.lags == (0..1)
    }

    /// Most emissions that a window receives, at a few dozen instants of the run.
    pub fn emissions_received(&self) -> u64 {
        self.in_air.most
    }

    /// Emissions that a block needs beyond as many as it has pulses; `None` where windows receive more than
    /// [`MOST_RECEIVED`].
    pub fn overlap_pulses(&self) -> Option<u64> {
        if self.is_apart() {
            return Some(0);
        }
        let InAir { lags, most } = &self.in_air;
        // One more where what is in the air changes from pulse to pulse.
        let changes = lags.end - lags.start > *most as i64;
        (*most <= MOST_RECEIVED).then(|| most.saturating_sub(1) + u64::from(changes))
    }

    /// Finds what the pulses of a block receive, whose windows start so late after their emissions, window by
    /// window; `false` where it is more than blocks can have, or more than the run showed.
    ///
    /// # Errors
    /// A track that does not cover the block.
    pub fn received(
        &self,
        first: u64,
        windows_s: &[Vec<f64>],
        workspace: &mut Workspace,
        out: &mut Received,
    ) -> Result<bool, RadarError> {
        let pulses = windows_s.first().map_or(0, Vec::len);
        let hull = |pulse: usize| {
            let starts_s = windows_s.iter().filter_map(|of| of.get(pulse));
            Window::hull(starts_s.map(|start_s| self.window(*start_s)))
        };
        let (at, count) = nodes_within(pulses);
        let (mut spans, mut fastest_mps) = ([None; NODES], 0f64);
        out.of_pulses.clear();
        out.emissions = first..first + pulses as u64;
        out.alone = self.receives_itself_alone();
        for (span, place) in spans.iter_mut().zip(&at[..count]) {
            let index = first + *place as u64;
            let emitted = self.emission_at(index);
            self.evaluate(emitted, &mut workspace.own)?;
            let window = hull(*place);
            *span = self.delay_span_s(emitted, &workspace.own)?;
            let own_mps = self.closing_mps(&workspace.own.centres);
            let of = span.map(|span| self.emissions_within(index, span, own_mps, &window));
            out.alone &= of.is_none_or(|of| of.is_empty() || of == (index..index + 1));
            fastest_mps = fastest_mps.max(own_mps);
        }
        if self.receives_itself_alone() {
            return Ok(out.alone);
        }
        for pulse in 0..pulses {
            let (index, window) = (first + pulse as u64, hull(pulse));
            let after = at[..count].partition_point(|place| *place < pulse).min(count - 1);
            let before = if at[after] == pulse { after } else { after.saturating_sub(1) };
            let gap_s = |node: usize| {
                let emitted = self.emission_at(first + at[node] as u64);
                self.offset_s(index, emitted).abs() * fastest_mps / SPEED_OF_LIGHT_MPS
            };
            let within = match (spans[before], spans[after]) {
                (Some((a, b)), Some((c, d))) => {
                    let drift_s = gap_s(before).min(gap_s(after));
                    Some((a.min(c) - drift_s, b.max(d) + drift_s))
                }
                (one, other) => one.or(other),
            };
            let of = within.map(|span| self.emissions_within(index, span, fastest_mps, &window));
            out.of_pulses.push(of.unwrap_or(index..index));
        }
        let is_own = |(own, of): (u64, &Range<u64>)| of.is_empty() || *of == (own..own + 1);
        out.alone = !self.is_apart() && (first..).zip(&out.of_pulses).all(is_own);
        if !out.alone {
            let held = out.of_pulses.iter().filter(|of| !of.is_empty());
            let hull = held.cloned().reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
            out.emissions = hull.unwrap_or(first..first);
        }
        Ok(self.is_apart() || out.most() <= MOST_RECEIVED)
    }

    /// What windows receive of an emission: those of the pulses that any pulse of the run receives so late,
    /// all open as late as its own.
    pub(crate) fn hearing(&self, emission: u64) -> Result<Hearing, RadarError> {
        let mut hearing = Hearing::default();
        self.hearing_in(emission, &mut hearing)?;
        Ok(hearing)
    }

    /// The same in place of what is there.
    pub(super) fn hearing_in(&self, emission: u64, out: &mut Hearing) -> Result<(), RadarError> {
        let Hearing { windows, of_pairs, offsets_s } = out;
        of_pairs.clear();
        of_pairs.extend(self.plans.iter().map(|plan| plan.window));
        if self.is_apart() {
            // Sooner or later a window receives any part of it.
            windows.clear();
            windows.resize(self.windows(), Window::UNBOUNDED);
            offsets_s.clear();
            return Ok(());
        }
        self.windows_at(emission, windows)?;
        let InAir { lags, most } = &self.in_air;
        offsets_s.clear();
        if !self.receives_itself_alone() && *most <= MOST_RECEIVED {
            let pulses = lags.clone().filter_map(|lag| emission.checked_add_signed(-lag));
            let pulses = pulses.filter(|pulse| *pulse < self.pulses);
            offsets_s.extend(pulses.map(|pulse| self.radar.emissions.interval_s(pulse, emission)));
        }
        Ok(())
    }

    /// The windows of a pulse where it is the only one to receive its emission, else none: all is received.
    pub(super) fn windows_or_all(&self, index: u64, out: &mut Vec<Window>) -> Result<(), RadarError> {
        out.clear();
        if self.receives_itself_alone() {
            self.windows_at(index, out)?;
        }
        Ok(())
    }

    /// How fast the delays of an emission may change with time, m/s.
    pub(super) fn closing_mps(&self, centres: &[PhaseCentre]) -> f64 {
        let fastest = |centres: &[PhaseCentre]| centres.iter().map(|c| c.velocity.norm()).fold(0.0, f64::max);
        let (tx, rx) = centres.split_at(self.radar.transmitters.len());
        fastest(tx) + fastest(rx) + 2.0 * self.fastest_target_mps + MANOEUVRE_MPS
    }

    /// The emissions that the window of a pulse may receive of delays between bounds, s, that change no
    /// faster than so many m/s.
    pub(super) fn emissions_within(
        &self,
        index: u64,
        (least_s, most_s): (f64, f64),
        closing_mps: f64,
        window: &Window,
    ) -> Range<u64> {
        let earliest_s = window.open_s - window.guard_s - self.pulse_length_s - most_s;
        let latest_s = window.close_s + window.guard_s - least_s;
        // Twice, because the interval itself widens by what is added.
        let change_s = 2.0 * closing_mps / SPEED_OF_LIGHT_MPS * earliest_s.abs().max(latest_s.abs());
        let first = self.first_emission(index, earliest_s - change_s);
        let after = self.first_emission(index, latest_s + change_s);
        first..after
    }

    /// The emissions that may be received in the window of pulse `index`.
    pub(super) fn emissions_in_window(
        &self,
        index: u64,
        own: &Emission,
        window: &Window,
    ) -> Result<Range<u64>, RadarError> {
        let span = self.delay_span_s(index, own)?;
        let within = |span| self.emissions_within(index, span, self.closing_mps(&own.centres), window);
        Ok(span.map_or(index..index, within))
    }

    /// Bounds on all delays of an emission, s; `None` where nothing returns it.
    pub(super) fn delay_span_s(
        &self,
        index: u64,
        emission: &Emission,
    ) -> Result<Option<(f64, f64)>, RadarError> {
        self.delay_span_beside_s(index, emission, emission.delay_span_s(), 0..self.pairs.len())
    }

    /// Bounds on the delays of sea and ships over some pairs, and on others that are known, s.
    pub(super) fn delay_span_beside_s(
        &self,
        index: u64,
        emission: &Emission,
        known_s: Option<(f64, f64)>,
        pairs: Range<usize>,
    ) -> Result<Option<(f64, f64)>, RadarError> {
        let elapsed_s = self.radar.emissions.elapsed_s(index);
        let targets = self.with_ships(known_s, emission, elapsed_s, &self.ends[pairs.clone()]);
        let Some(sea) = &self.sea else { return Ok(targets) };
        let reception = self.reception(index, index, emission, &[]);
        let reception = Reception { plans: &self.plans[pairs], ..reception };
        let patch = sea
            .patch_at(&reception.surroundings, reception.elapsed_s)
            .map_err(|failure| self.track_error(index, failure))?;
        let facets = sea.delay_span_s(&patch, &reception);
        Ok(match (targets, facets) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (one, other) => one.or(other),
        })
    }

    /// The first emission of the run at least `offset_s` after pulse `index` (the number of emissions if
    /// there is none).
    pub(super) fn first_emission(&self, index: u64, offset_s: f64) -> u64 {
        // No emission is farther away, counted in pulses, than the shortest interval allows.
        let steps = (offset_s.abs() / self.radar.emissions.shortest_pri_s()).ceil() as u64;
        let reach = steps.saturating_add(2);
        let [mut low, mut high] = match (self.is_apart(), offset_s < 0.0) {
            (true, _) => [0, self.pulses],
            (false, true) => [index.saturating_sub(reach), index.min(self.pulses)],
            (false, false) => [index, index.saturating_add(reach).min(self.pulses)],
        };
        while low < high {
            let middle = low + (high - low) / 2;
            if self.offset_s(index, middle) < offset_s {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Share of the echo of a pulse with such a delay that windows receive, of those that open `opens_s`
    /// after their emission: 0 to 1.
    pub fn received_share(&self, index: u64, opens_s: f64, delay_s: f64) -> f64 {
        if self.is_apart() {
            return 1.0;
        }
        let window_length_s = self.radar.window.samples as f64 / self.radar.sample_rate_hz;
        let begins_s = delay_s - opens_s;
        let received_s = |later_s: f64| {
            let begins_s = begins_s - later_s;
            let own_s = self.pulse_length_s.min(window_length_s - begins_s) - (-begins_s).max(0.0);
            own_s.max(0.0)
        };
        // Where pulses are in the air a later window receives it, or an earlier one, or two a part each.
        let emissions = &self.radar.emissions;
        let interval_s = emissions.interval_s(0, 1);
        let sum_s: f64 = if emissions.is_uniform() && interval_s > 0.0 {
            let [first, last] = [begins_s - window_length_s, begins_s + self.pulse_length_s]
                .map(|end_s| (end_s / interval_s).floor());
            let last = last.min(first + MOST_IN_AIR as f64);
            (first as i64..=last as i64).map(|n| received_s(n as f64 * interval_s)).sum()
        } else {
            let later = (1..=MOST_IN_AIR).map(|n| emissions.interval_s(index, index.saturating_add(n)));
            let later = later.take_while(|later_s| *later_s <= begins_s + self.pulse_length_s);
            let before = (1..=MOST_IN_AIR.min(index)).map(|n| -emissions.interval_s(index - n, index));
            let before = before.take_while(|later_s| begins_s - *later_s <= window_length_s);
            later.chain(before).map(received_s).fold(received_s(0.0), |sum, own| sum + own)
        };
        (sum_s / self.pulse_length_s).min(1.0)
    }
}
