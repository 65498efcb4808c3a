//! Looks at pulses as they are released, and keeps what is shown of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::MonitorFault;
use super::about::Scenery;
use super::budget::Budget;
use super::doppler::{self, Burst};
use super::footprint::Footprint;
use super::history;
use super::hub::{Hub, Now};
use super::ppi::Ppi;
use super::ranges::{Ranges, Row};
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;
use crate::transport::health::Counters;
use crate::transport::view::{Onlooker, Seen};

/// Most pulses between two looks at the counters: a stream that is faster than this thread never lets it
/// rest.
const BATCH: usize = 256;
/// Pause between two looks at the queue.
const PAUSE: Duration = Duration::from_millis(20);
/// Shortest time between two range lines of a channel.
const ROW_EVERY: Duration = Duration::from_millis(50);
/// Shortest time between two range-Doppler maps.
const MAP_EVERY: Duration = Duration::from_millis(500);
/// How long maps and radials go on being made after a browser has asked for them.
const WANTED: Duration = Duration::from_secs(3);
/// Shortest time between two looks at the counters.
const COUNT_EVERY: Duration = Duration::from_millis(200);
/// Time over which the speed of generation is taken, s.
const SPEED_S: f64 = 2.0;
/// Priority of the monitor's threads from 0 to 99, where 50 is that of an ordinary thread: nice 19.
const PRIORITY: u8 = 0;

/// Turns pulses into what is shown.
pub struct Watcher {
    hub: Arc<Hub>,
    scenery: Scenery,
    ranges: Option<Ranges>,
    line_budget: Budget,
    map_budget: Budget,
    ppi: Option<Ppi>,
    ppi_budget: Budget,
    /// When somebody last looked at the plan position panel.
    ppi_wanted: Option<Instant>,
    start: TimeTag,
    /// Code of the polarisation that a channel is radiated in; `None`: in every pulse.
    radiated: Vec<Option<u8>>,
    /// When the last range line of each channel was made.
    lines: Vec<Option<Instant>>,
    burst: Burst,
    burst_pulses: usize,
    maps: u64,
    mapped: Option<Instant>,
    /// When somebody last looked at the map of each channel.
    wanted: Vec<Option<Instant>>,
    /// Pulses made and seconds of work, some time ago.
    speed: Option<(u64, f64)>,
}

/// Lowers the priority of a thread of the monitor to the least there is.
pub fn step_back() {
    if let Ok(level) = PRIORITY.try_into() {
        let _ = thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Crossplatform(
            level,
        ));
    }
}

/// Watches a stream in a thread of its own until it ends or is `over`.
///
/// # Errors
/// The system refuses the thread.
pub fn start(
    mut onlooker: Onlooker,
    mut watcher: Watcher,
    over: Arc<AtomicBool>,
) -> Result<JoinHandle<()>, MonitorFault> {
    let watch = move || {
        step_back();
        let mut counted: Option<Instant> = None;
        loop {
            // Looked at before the queue: what came before the end is shown.
            let last = over.load(Ordering::Acquire);
            let mut seen = Seen::Pulse;
            let mut shown = 0;
            while seen == Seen::Pulse && shown < BATCH {
                shown += 1;
                seen = onlooker.poll(|pulse, waiting| watcher.show(pulse, waiting == 0 || shown == BATCH));
            }
            let ended = seen == Seen::Ended || (last && seen == Seen::Nothing);
            if (ended || counted.is_none_or(|at| at.elapsed() >= COUNT_EVERY))
                && let Some(health) = onlooker.health()
            {
                counted = Some(Instant::now());
                watcher.count(health.counters(), onlooker.not_shown());
            }
            if ended {
                return;
            }
            if seen == Seen::Nothing {
                thread::sleep(PAUSE);
            }
        }
    };
    thread::Builder::new().name("monitor".to_owned()).spawn(watch).map_err(MonitorFault::Thread)
}

impl Watcher {
    /// For the pulses of a run.
    pub fn new(hub: &Arc<Hub>, header: &Header, scenery: &Scenery) -> Self {
        let radiated = |letters: &str| {
            letters.chars().nth(1).and_then(Polarisation::from_letter).map(Polarisation::code)
        };
        let ppi = Ppi::new(header);
        // Lines and maps share what radials leave.
        let part = if ppi.is_some() { 0.25 } else { 0.5 };
        Self {
            hub: Arc::clone(hub),
            scenery: scenery.clone(),
            ranges: Ranges::new(header),
            line_budget: Budget::of_this_machine(part),
            map_budget: Budget::of_this_machine(part),
            ppi,
            ppi_budget: Budget::of_this_machine(0.5),
            ppi_wanted: None,
            start: header.start,
            radiated: header.channels.iter().map(|channel| radiated(&channel.polarisations)).collect(),
            lines: vec![None; header.channels.len()],
            burst: Burst::default(),
            burst_pulses: doppler::pulses(header.layout.samples),
            maps: 0,
            mapped: None,
            wanted: vec![None; header.channels.len()],
            speed: None,
        }
    }

    /// Whether a channel was radiated in a pulse.
    fn is_illuminated(&self, pulse: &Pulse, channel: usize) -> bool {
        pulse.tx_pol == 0
            || self.radiated.get(channel).copied().flatten().is_none_or(|code| code == pulse.tx_pol)
    }

    /// Shows a pulse; the plan and the figures are those of the latest one.
    pub fn show(&mut self, pulse: &Pulse, is_latest: bool) {
        let time_s = pulse.time.since(self.start);
        self.range_lines(pulse, time_s);
        self.range_doppler(pulse, time_s);
        self.radials(pulse, time_s);
        if self.hub.state().history.wants(time_s) {
            let point = history::Instant::of(pulse, time_s);
            self.hub.state().history.push(point);
        }
        if !is_latest {
            return;
        }
        let outline = |(place, antenna)| {
            self.scenery.outline(place).map_or_else(Footprint::default, |outline| outline.on_the_sea(antenna))
        };
        let now = Now {
            pulse: pulse.index,
            time_s,
            unix_ns: pulse.time.to_unix_ns().0,
            window_start_s: pulse.window_start_s,
            flags: pulse.flags,
            truth: pulse.nav_true.clone(),
            reported: pulse.nav_reported.clone(),
            antennas_m: pulse.antennas.iter().map(|antenna| antenna.phase_centre_m).collect(),
            footprints: pulse.antennas.iter().enumerate().map(outline).collect(),
            delays_s: pulse.target_delay_s.clone(),
            dopplers_hz: pulse.target_doppler_hz.clone(),
            ships_m: pulse.ship_position_m.clone(),
            headings_deg: pulse.ship_heading_deg.clone(),
            patch_m: self.scenery.patch_centre_m(time_s, &pulse.nav_true, &pulse.nav_reported),
        };
        self.hub.state().now = Some(now);
    }

    fn range_lines(&mut self, pulse: &Pulse, time_s: f64) {
        // The oldest first: where there is time for one line alone, channels take turns.
        let due = |of: &Self, channel: usize| {
            of.lines[channel].is_none_or(|at| at.elapsed() >= ROW_EVERY) && of.is_illuminated(pulse, channel)
        };
        while let Some(channel) = (0..self.lines.len())
            .filter(|channel| due(self, *channel))
            .min_by_key(|channel| self.lines[*channel])
        {
            let (Some(ranges), budget) = (&mut self.ranges, &mut self.line_budget) else { return };
            let Some(levels) = budget.spend(|| ranges.levels(pulse, channel)) else { return };
            self.lines[channel] = Some(Instant::now());
            let (pulse, start_s) = (pulse.index, ranges.opens_s(pulse, channel) - 0.5 * ranges.cell_s());
            self.hub.state().push_row(channel, Row { number: 0, pulse, time_s, start_s, levels });
        }
    }

    fn range_doppler(&mut self, pulse: &Pulse, time_s: f64) {
        for channel in 0..self.wanted.len() {
            if self.hub.is_doppler_wanted(channel) {
                self.wanted[channel] = Some(Instant::now());
            } else if self.wanted[channel].is_some_and(|at| at.elapsed() > WANTED) {
                self.wanted[channel] = None;
            }
        }
        if !self.wanted.get(self.burst.channel()).is_some_and(Option::is_some) && !self.next_map() {
            return;
        }
        if !self.is_illuminated(pulse, self.burst.channel()) {
            return;
        }
        let Some(ranges) = &mut self.ranges else { return };
        self.burst.take(pulse, time_s, self.burst_pulses, ranges);
        if !self.burst.is_full(self.burst_pulses) || self.mapped.is_some_and(|at| at.elapsed() < MAP_EVERY) {
            return;
        }
        let (burst, prf_hz) = (&mut self.burst, self.hub.prf_hz);
        let Some(mut map) = self.map_budget.spend(|| burst.map(ranges, prf_hz)) else { return };
        self.maps += 1;
        map.number = self.maps;
        self.mapped = Some(Instant::now());
        self.hub.state().map = Some(map);
        self.next_map();
    }

    fn radials(&mut self, pulse: &Pulse, time_s: f64) {
        let Some(ppi) = &mut self.ppi else { return };
        if self.hub.is_ppi_wanted() {
            self.ppi_wanted = Some(Instant::now());
        } else if self.ppi_wanted.is_some_and(|at| at.elapsed() > WANTED) {
            self.ppi_wanted = None;
            ppi.forget();
        }
        if self.ppi_wanted.is_none() {
            return;
        }
        if let Some(radial) = ppi.take(pulse, time_s, &mut self.ppi_budget) {
            self.hub.state().push_radial(radial);
        }
    }

    /// Goes on to the next channel that somebody looks at; `false` if there is none. Several browsers at
    /// several channels get their maps by turns.
    fn next_map(&mut self) -> bool {
        let (channels, last) = (self.wanted.len(), self.burst.channel());
        let next =
            (1..=channels).map(|step| (last + step) % channels).find(|next| self.wanted[*next].is_some());
        if let Some(channel) = next {
            self.burst.restart(channel);
        }
        next.is_some()
    }

    /// Shows how the stream counts.
    pub fn count(&mut self, counters: Counters, not_shown: u64) {
        let (made, busy_s) = (counters.made, counters.generation_busy_s);
        let (before, busy_before_s) = self.speed.unwrap_or((0, 0.0));
        let spent_s = busy_s - busy_before_s;
        let factor =
            (spent_s > 0.0 && made > before).then(|| (made - before) as f64 / self.hub.prf_hz / spent_s);
        if self.speed.is_none() || spent_s >= SPEED_S {
            self.speed = Some((made, busy_s));
        }
        let elapsed_s = self.hub.elapsed_s();
        let mut state = self.hub.state();
        state.real_time_factor = factor.or(state.real_time_factor);
        state.count(counters, not_shown, elapsed_s);
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex32;

    use super::*;
    use crate::pulse::Layout;
    use crate::recording::header::ChannelRow;

    /// A watcher of two channels, and a pulse for it.
    fn watcher() -> (Arc<Hub>, Watcher, Pulse) {
        let header = Header {
            sample_rate_hz: 1e6,
            bandwidth_hz: 1e6,
            prf_hz: 1000.0,
            replica: vec![Complex32::ONE],
            layout: Layout { channels: 2, samples: 8, ..Layout::default() },
            channels: vec![ChannelRow::default(); 2],
            ..Header::default()
        };
        let hub = Arc::new(Hub::new(&header, &Scenery::default(), None));
        let watcher = Watcher::new(&hub, &header, &Scenery::default());
        (hub, watcher, Pulse::new(&header.layout))
    }

    /// Two browsers that look at two channels both get maps: neither puts the other's burst back to its
    /// begin.
    #[test]
    fn maps_of_several_channels_come_by_turns() {
        let (hub, mut watcher, mut pulse) = watcher();
        let begun = Instant::now();
        let mut seen = [false; 2];
        while seen != [true; 2] {
            hub.watch_doppler((pulse.index / 20 % 2) as usize);
            watcher.show(&pulse, true);
            if let Some(map) = &hub.state().map {
                seen[map.channel] = true;
            }
            pulse.index += 1;
            assert!(begun.elapsed() < Duration::from_secs(20), "{seen:?}");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// Where there is time for a line now and then, the first channel does not take all of it.
    #[test]
    fn channels_take_turns_where_time_is_scarce() {
        let (hub, mut watcher, mut pulse) = watcher();
        for lines in 0..4 {
            watcher.line_budget = Budget::of(0.0, 1e-9);
            watcher.show(&pulse, false);
            pulse.index += 1;
            let held: Vec<usize> = hub.state().rows.iter().map(std::collections::VecDeque::len).collect();
            assert_eq!(held, [[1, 0], [1, 1], [2, 1], [2, 2]][lines]);
            assert!(hub.state().now.is_none(), "the plan is that of the latest pulse");
            thread::sleep(ROW_EVERY);
        }
    }
}
