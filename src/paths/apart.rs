//! Pulses that are no emissions: what receivers take of an emitter with a schedule of its own.
//!
//! A generator mostly has one train: pulse `n` is received after emission `n`. Here there are two: emissions
//! `k` at `t_k`, and pulses `n` at `t_n` with windows of their own, found by the radar's first pair as ever.
//! A window receives whatever emissions reach it. A carrier `df` above that of the receiver turns emission
//! `k` by `df t_k` (both oscillators are in phase at pulse 0); what it turns within an emission is part of
//! the waveform ([`Offset`](crate::radar::waveform::Offset)).

use std::f64::consts::TAU;
use std::ops::Range;

use num_complex::Complex64;

use super::{InAir, PathGenerator, Workspace, pair_plans};
use crate::motion::PlatformTracks;
use crate::paths::list::ScattererPaths;
use crate::paths::sea::Drawn;
use crate::pulse::Pulse;
use crate::pulse::costs::Stage;
use crate::radar::fault::RadarError;
use crate::radar::window::{GUARD_SAMPLES, RINGING_OF_PULSES, Window};
use crate::scene::radar::{Channel, TxPolarisation};
use crate::scene::{Emitter, Radar, Scene};
use crate::time::{PulseTimes, TimeTag};
use crate::units::SPEED_OF_LIGHT_MPS;

/// Pulses, apart from emissions.
#[derive(Clone, Debug)]
pub(super) struct Apart {
    times: PulseTimes,
    pulses: u64,
    /// Carrier of the emitter above that of the receivers, Hz.
    offset_hz: f64,
    /// Whether what is emitted is the radar's own, so that its pulses have records.
    own: bool,
}

impl Apart {
    fn time(&self, pulse: u64) -> TimeTag {
        self.times.emission(TimeTag::default(), pulse)
    }
}

/// Instants at which windows are looked at over a run.
const CHECKED_WINDOWS: u64 = 64;
/// Pulses whose schedule is compared with that of an emitter: the first of a run, and as many over all of
/// it. Emissions that pass by too slowly to reach a window within the first do so at one of the others, in
/// runs of no more than [`MOST_SCHEDULES`] pulses, where window and pulse last a hundredth of an interval.
const SCHEDULES: u64 = 1 << 14;
const MOST_SCHEDULES: u64 = 1 << 21;

/// Least share of an emission, in time, that counts as received where a window takes any of it.
const LEAST_SHARE: f64 = 0.1;

/// What pulses receive of emissions apart from them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shares {
    /// Share of the pulses that receive anything.
    pub reached: f64,
    /// Mean power over that of a pulse that receives all of an emission.
    pub received: f64,
}

/// A radar as it receives an emitter: one more transmitter, the emitter's carrier, waveform and schedule,
/// and a channel for every port of a receiver that takes it. Without rain clutter.
pub(crate) fn received_by(emitter: &Emitter, radar: &Radar) -> Radar {
    let mut heard = radar.clone();
    heard.emitters.clear();
    heard.sent = None;
    heard.transmitters.push(emitter.transmitter.clone());
    heard.carrier_hz = emitter.carrier_hz;
    heard.waveform = emitter.waveform.clone();
    heard.emissions = emitter.emissions.clone();
    heard.tx_polarisation = TxPolarisation::Simultaneous;
    heard.direct_path = emitter.direct_path;
    heard.rain_clutter = None;
    heard.channels.clear();
    for channel in radar.channels.iter().filter(|own| emitter.receivers.contains(&own.receiver)) {
        let port = (channel.receiver, channel.rx);
        if heard.channels.iter().all(|own| (own.receiver, own.rx) != port) {
            let transmitter = radar.transmitters.len();
            heard.channels.push(Channel { transmitter, tx: emitter.polarisation, ..channel.clone() });
        }
    }
    heard
}

/// The scene of an emitter as the radar of another receives it: its emissions are the pulses, from so long
/// before the radar's first up to so long after its last. Without a far sea.
pub(crate) fn scene_of(scene: &Scene, emitter: &Emitter, [before_s, after_s]: [f64; 2]) -> Scene {
    let emissions = emitter.emissions.clone().not_before(-before_s);
    let pulses = emitted_until(scene, &emissions, after_s);
    let radar = Radar { emissions, ..received_by(emitter, &scene.radar) };
    let mut own = Scene { radar, pulses, ..scene.clone() };
    if let Some(sea) = &mut own.sea {
        sea.far = None;
    }
    if !emitter.echo {
        own.sea = None;
        own.ships.clear();
        own.targets.clear();
    }
    own
}

/// How many emissions of a train there are up to so long after the last pulse of a scene, that at the very
/// last instant among them.
fn emitted_until(scene: &Scene, train: &PulseTimes, after_s: f64) -> u64 {
    let last_s = scene.radar.emissions.interval_s(0, scene.pulses.saturating_sub(1));
    if scene.pulses > 0 { train.count_within((last_s + after_s).next_up()) } else { 0 }
}

/// The scene of a radar that receives continuously, as it radiates: its emissions are the pulses, to the end
/// of the last block or where it begins. `None` for one with windows.
pub(crate) fn sent_by(scene: &Scene, to_the_end: bool) -> Option<Scene> {
    let mut radar = scene.radar.clone();
    radar.emissions = radar.sent.take()?;
    let block_s = radar.window.samples as f64 / radar.sample_rate_hz;
    let pulses = emitted_until(scene, &radar.emissions, if to_the_end { block_s } else { 0.0 });
    Some(Scene { radar, pulses, ..scene.clone() })
}

impl PathGenerator {
    /// What a radar that receives continuously takes of its own emissions, whose scene is `own`
    /// ([`sent_by`]).
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(crate) fn continuous(
        scene: &Scene,
        own: &Scene,
        pulse_length_s: f64,
        tracks: Vec<PlatformTracks>,
        drawn: Drawn<'_>,
    ) -> Result<Self, RadarError> {
        let built = Self::on(own, pulse_length_s, tracks, drawn)?;
        Ok(built.in_pulses_of(scene, 0.0, true))
    }

    /// The same with the pulses of another scene.
    fn in_pulses_of(self, scene: &Scene, offset_hz: f64, own: bool) -> Self {
        let (times, pulses) = (scene.radar.emissions.clone(), scene.pulses);
        let apart = Some(Apart { times, pulses, offset_hz, own });
        Self { in_air: InAir::of_others(), apart, ..self }
    }

    /// What the receivers of a scene's radar take of an emitter, whose scene is `own` ([`scene_of`]).
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(crate) fn of_emitter(
        (scene, emitter): (&Scene, &Emitter),
        own: &Scene,
        pulse_length_s: f64,
        tracks: Vec<PlatformTracks>,
        drawn: Drawn<'_>,
    ) -> Result<Self, RadarError> {
        let mut built = Self::on(own, pulse_length_s, tracks, drawn)?;
        built.leads = scene.radar.window_leads();
        built.plans = pair_plans(&built.radar, &built.pairs, built.leads.len(), &built.channel_pairs);
        Ok(built.in_pulses_of(scene, emitter.carrier_hz - scene.radar.carrier_hz, false))
    }

    /// Whether pulses are not those emitted.
    pub(crate) fn is_apart(&self) -> bool {
        self.apart.is_some()
    }

    /// Whether they are those of an emitter beside the radar.
    pub(crate) fn is_of_emitter(&self) -> bool {
        self.apart.as_ref().is_some_and(|apart| !apart.own)
    }

    /// Mean interval of its emissions, s.
    pub(crate) fn mean_pri_s(&self) -> f64 {
        self.radar.emissions.mean_pri_s()
    }

    /// How many pulses receive.
    pub(crate) fn receiving_pulses(&self) -> u64 {
        self.apart.as_ref().map_or(self.pulses, |apart| apart.pulses)
    }

    /// When pulses are.
    pub(super) fn pulse_times(&self) -> &PulseTimes {
        self.apart.as_ref().map_or(&self.radar.emissions, |apart| &apart.times)
    }

    /// Mean interval of its pulses, s.
    pub(crate) fn mean_pulse_interval_s(&self) -> f64 {
        self.pulse_times().mean_pri_s()
    }

    /// When a pulse is, from whose emission its windows count.
    pub(super) fn pulse_time(&self, index: u64) -> TimeTag {
        self.pulse_times().emission(self.start, index)
    }

    /// Fills the record of a pulse that is not one of those emitted, if they are the radar's own: truth is
    /// that of what leaves at the pulse.
    pub(super) fn fill_record_apart(
        &self,
        index: u64,
        workspace: &mut Workspace,
        record: &mut Pulse,
    ) -> Result<(), RadarError> {
        let Some(Apart { times, own: true, .. }) = &self.apart else { return Ok(()) };
        let own = &mut workspace.own;
        own.evaluate(&self.circumstances(), index, self.pulse_time(index), times.interval_s(0, index))
            .map_err(|failure| self.track_error(index, failure))?;
        self.fill_record(index, own, record)?;
        workspace.costs.lap(Stage::Record);
        Ok(())
    }

    /// From a pulse to an emission, s.
    pub fn offset_s(&self, index: u64, emitted: u64) -> f64 {
        match &self.apart {
            None => self.radar.emissions.interval_s(index, emitted),
            Some(apart) => {
                self.radar.emissions.emission(TimeTag::default(), emitted).since(apart.time(index))
            }
        }
    }

    /// The emission at a pulse, or the first after it.
    pub(crate) fn emission_at(&self, index: u64) -> u64 {
        match &self.apart {
            None => index,
            Some(_) => self.first_emission(index, 0.0).min(self.pulses.saturating_sub(1)),
        }
    }

    /// By how much the carrier turns an emission, turns.
    fn carrier_turns_of(&self, emitted: u64) -> f64 {
        let Some(apart) = &self.apart else { return 0.0 };
        let at = self.radar.emissions.emission(TimeTag::default(), emitted);
        // Whole turns of whole seconds vanish before they cost digits.
        (apart.offset_hz.fract() * at.seconds() as f64).fract() + (apart.offset_hz * at.fraction_s()).fract()
    }

    /// By how much the carrier turns so many emissions from the first on, turns: where intervals are equal
    /// the first, and from each to the next; else every one.
    pub(crate) fn carrier_turns(&self, first: u64, count: usize, each: &mut Vec<f64>) -> [f64; 2] {
        each.clear();
        let (Some(apart), emissions) = (&self.apart, &self.radar.emissions) else { return [0.0; 2] };
        if emissions.is_uniform() {
            return [self.carrier_turns_of(first), (apart.offset_hz * emissions.mean_pri_s()).fract()];
        }
        each.extend((first..).take(count).map(|emitted| self.carrier_turns_of(emitted)));
        [0.0; 2]
    }

    /// Fills `paths` with all that windows receive of the emitter, which start so long after their pulse, s.
    ///
    /// # Errors
    /// Those of [`Self::pulse`].
    pub(super) fn append_received(
        &self,
        index: u64,
        starts_s: &[f64],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let mut windows = std::mem::take(&mut workspace.windows);
        windows.clear();
        windows.extend(starts_s.iter().map(|open_s| self.window(*open_s)));
        let made = self.append_in_windows(index, &windows, workspace, paths);
        workspace.windows = windows;
        made
    }

    fn append_in_windows(
        &self,
        index: u64,
        windows: &[Window],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let emissions = self.emissions_at(index, windows, workspace)?;
        for emitted in emissions {
            self.append_emission((index, emitted), windows, workspace, paths)?;
        }
        Ok(())
    }

    fn append_emission(
        &self,
        (index, emitted): (u64, u64),
        windows: &[Window],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        let before = paths.len();
        self.append_others(index, emitted..emitted + 1, windows, workspace, paths)?;
        let turns = self.carrier_turns_of(emitted);
        if turns != 0.0 {
            paths.turn(before, Complex64::cis(TAU * turns));
        }
        Ok(())
    }

    /// Emissions that the windows of a pulse may receive, which start so long after it, s. Fills the record
    /// of a pulse that has one.
    ///
    /// # Errors
    /// Those of [`Self::pulse`].
    pub(crate) fn emissions_of_pulse(
        &self,
        index: u64,
        workspace: &mut Workspace,
        record: &mut Pulse,
    ) -> Result<Range<u64>, RadarError> {
        if index >= self.receiving_pulses() {
            return Err(RadarError::NoSuchPulse { index, pulses: self.receiving_pulses() });
        }
        self.fill_record_apart(index, workspace, record)?;
        let windows = self.windows_from(record.window_starts_s());
        self.emissions_at(index, &windows, workspace)
    }

    /// Fills `paths` with what the windows of a pulse receive of one emission, as [`Self::pulse`] does with
    /// that of all.
    ///
    /// # Errors
    /// Those of [`Self::pulse`].
    pub(crate) fn paths_of_emission(
        &self,
        (index, emitted): (u64, u64),
        starts_s: &[f64],
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        paths.clear();
        let windows = self.windows_from(starts_s);
        self.append_emission((index, emitted), &windows, workspace, paths)?;
        workspace.costs.lap(Stage::ScattererPaths);
        Ok(())
    }

    fn windows_from(&self, starts_s: &[f64]) -> Vec<Window> {
        starts_s.iter().map(|open_s| self.window(*open_s)).collect()
    }

    /// A window that opens so long after its pulse, s.
    pub(super) fn window(&self, open_s: f64) -> Window {
        let window = Window::new(&self.radar, open_s, self.pulse_length_s);
        if !self.is_apart() || self.radar.waveform.turns() == 1 {
            return window;
        }
        // Pulses in turn are joined with all that the filter rings of them.
        let guard_samples = GUARD_SAMPLES + RINGING_OF_PULSES;
        Window { guard_s: guard_samples as f64 / self.radar.sample_rate_hz, ..window }
    }

    /// The number of an emission in its train, also of one that left before the first pulse.
    pub(crate) fn number_of(&self, emitted: u64) -> u64 {
        self.radar.emissions.number(emitted)
    }

    /// Bounds on all delays of the run, s, as far as a few dozen emissions show: widened by what may change
    /// between two of them. `None` where nothing returns an emission.
    ///
    /// # Errors
    /// Tracks that do not cover the run.
    pub(crate) fn delay_span_of_run_s(&self) -> Result<Option<(f64, f64)>, RadarError> {
        if self.pulses == 0 {
            return Ok(None);
        }
        let (mut own, mut span, mut before) = (self.workspace().own, None, None);
        let mut most_s: f64 = 0.0;
        for emitted in self.checked_pulses() {
            self.evaluate(emitted, &mut own)?;
            let gap_s = before.map_or(0.0, |n| self.radar.emissions.interval_s(n, emitted));
            most_s = most_s.max(0.5 * gap_s * self.closing_mps(&own.centres) / SPEED_OF_LIGHT_MPS);
            before = Some(emitted);
            span = match (span, self.delay_span_s(emitted, &own)?) {
                (Some((a, b)), Some((c, d))) => Some((f64::min(a, c), f64::max(b, d))),
                (one, other) => one.or(other),
            };
        }
        Ok(span.map(|(least_s, longest_s)| (least_s - most_s, longest_s + most_s)))
    }

    /// Whether any window of the run may receive the direct path: by bounds on its delay and on when windows
    /// open, as far as a few dozen instants show, of every pulse; of long runs, of the first
    /// [`SCHEDULES`] pulses and as many spread over all.
    ///
    /// # Errors
    /// Tracks that do not cover the run.
    pub(crate) fn may_receive_direct_path(&self) -> Result<bool, RadarError> {
        let pulses = self.receiving_pulses();
        if self.pulses == 0 || pulses == 0 || pulses > MOST_SCHEDULES {
            return Ok(self.radar.direct_path);
        }
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let hold = |(a, b): (f64, f64), s: f64| (a.min(s), b.max(s));
        let (mut own, mut delays_s, mut opens_s) = (self.workspace().own, none, none);
        let mut closing_mps: f64 = 0.0;
        for emitted in self.checked_pulses() {
            self.evaluate(emitted, &mut own)?;
            closing_mps = closing_mps.max(self.closing_mps(&own.centres));
            let direct = own.paths.len().saturating_sub(self.pairs.len());
            delays_s = own.paths[direct..].iter().fold(delays_s, |all, path| hold(all, path.delay_s));
        }
        for step in 0..=CHECKED_WINDOWS {
            let index = (u128::from(pulses - 1) * u128::from(step) / u128::from(CHECKED_WINDOWS)) as u64;
            for window in 0..self.windows() {
                opens_s = hold(opens_s, self.window_start_of(window, index)?);
            }
        }
        // Between two of these instants both change by no more than so much.
        let longest_s = pulses as f64 * self.mean_pulse_interval_s();
        let wider_s = longest_s / CHECKED_WINDOWS as f64 * closing_mps / SPEED_OF_LIGHT_MPS;
        let span_s = (delays_s.0 - wider_s, delays_s.1 + wider_s);
        let [first, last] = [opens_s.0 - wider_s, opens_s.1 + wider_s].map(|open_s| self.window(open_s));
        let hull = Window::hull([first, last]);
        let receives = |index: u64| !self.emissions_within(index, span_s, 0.0, &hull).is_empty();
        let spread =
            (0..SCHEDULES).map(|n| (u128::from(pulses) * u128::from(n) / u128::from(SCHEDULES)) as u64);
        Ok((0..pulses.min(SCHEDULES)).any(receives) || (pulses > SCHEDULES && { spread }.any(receives)))
    }

    /// Emissions that windows of a pulse may receive.
    fn emissions_at(
        &self,
        index: u64,
        windows: &[Window],
        workspace: &mut Workspace,
    ) -> Result<Range<u64>, RadarError> {
        if self.pulses == 0 {
            return Ok(0..0);
        }
        let hull = Window::hull(windows.iter().copied());
        let about = self.emission_at(index);
        self.evaluate(about, &mut workspace.own)?;
        let span = self.delay_span_s(about, &workspace.own)?;
        let closing_mps = self.closing_mps(&workspace.own.centres);
        // That emission may be far from the pulse.
        let drift_s = self.offset_s(index, about).abs() * closing_mps / SPEED_OF_LIGHT_MPS;
        let within = |(nearest_s, farthest_s): (f64, f64)| {
            self.emissions_within(index, (nearest_s - drift_s, farthest_s + drift_s), closing_mps, &hull)
        };
        Ok(span.map_or(0..0, within))
    }

    /// What some pulses receive, of an emitter that of the pair that fewest reach of those that any does;
    /// windows as those of `radar`.
    ///
    /// # Errors
    /// Tracks that do not cover the run.
    pub(crate) fn shares_received(&self, radar: &Self, at: &[u64]) -> Result<Shares, RadarError> {
        let (mut work, mut windows, count) = (self.workspace(), Vec::new(), self.pairs.len());
        let each = if self.is_of_emitter() { 1 } else { count.max(1) };
        let parts: Vec<Range<usize>> = (0..count).step_by(each).map(|pair| pair..pair + each).collect();
        let mut sums = vec![Shares { reached: 0.0, received: 0.0 }; parts.len()];
        for &index in at {
            windows.clear();
            for window in 0..radar.windows() {
                let start_s = radar.window_start_of(window, index)?;
                windows.push(self.window(start_s));
            }
            let emissions = self.emissions_at(index, &windows, &mut work)?;
            for (pairs, sum) in parts.iter().zip(&mut sums) {
                let own = self.plans[pairs.clone()].iter().filter_map(|plan| windows.get(plan.window));
                let window = Window::hull(own.copied());
                let mut most: f64 = 0.0;
                for emitted in emissions.clone() {
                    most = most.max(self.received_of(index, emitted, &window, pairs, &mut work)?);
                    if most == 1.0 {
                        break;
                    }
                }
                sum.reached += f64::from(u8::from(most > 0.0));
                sum.received += most;
            }
        }
        let heard = sums.into_iter().filter(|sum| sum.reached > 0.0);
        let least = heard.min_by(|a, b| a.received.total_cmp(&b.received));
        let share = |of: f64| of / at.len().max(1) as f64;
        Ok(least.map_or(Shares { reached: 0.0, received: 0.0 }, |sum| Shares {
            reached: share(sum.reached),
            received: share(sum.received),
        }))
    }

    /// How much of an emission a window of a pulse receives by some pairs, as a power: of a target or the
    /// direct path, or all where any of sea and ships is received; of what the filter rings alone its share.
    fn received_of(
        &self,
        index: u64,
        emitted: u64,
        window: &Window,
        pairs: &Range<usize>,
        work: &mut Workspace,
    ) -> Result<f64, RadarError> {
        self.evaluate(emitted, &mut work.own)?;
        let offset_s = self.offset_s(index, emitted);
        let points = work.own.paths.chunks(self.pairs.len()).flat_map(|of| &of[pairs.clone()]);
        // Where less is received, errors at the edges of a window are a larger part of it, too: squared.
        let share = |begin_s: f64| {
            let ends_s = (begin_s + window.pulse_s).min(window.close_s);
            let inside = (ends_s - begin_s.max(window.open_s)) / window.pulse_s;
            inside.clamp(LEAST_SHARE, 1.0).powi(2) * window.share(begin_s)
        };
        let most = points.map(|path| share(offset_s + path.delay_s)).fold(0.0, f64::max);
        if most == 1.0 {
            return Ok(most);
        }
        let span = self.delay_span_beside_s(emitted, &work.own, None, pairs.clone())?;
        let of_span = |(nearest_s, farthest_s): (f64, f64)| {
            let lasts_s = window.pulse_s + farthest_s - nearest_s;
            Window { pulse_s: lasts_s, ..*window }.share(offset_s + nearest_s)
        };
        Ok(most.max(span.map_or(0.0, of_span)))
    }
}
