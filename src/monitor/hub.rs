//! What is shown, held once for all browsers, in bounded memory.
//!
//! One thread writes (the watcher or a replay), the server's thread reads; neither is a thread of the stream.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::Serialize;

use super::about::{Scenery, about};
use super::doppler::Map;
use super::footprint::Footprint;
use super::history::History;
use super::ppi::{Ppi, Radial};
use super::ranges::{Ranges, Row};
use crate::pipeline::control::Control;
use crate::pulse::PlatformRecord;
use crate::pulse::log::{Entry, Log};
use crate::recording::header::Header;
use crate::transport::health::Counters;

/// Memory of the range lines of all channels, bytes.
const ROWS_BYTES: usize = 16 << 20;
/// Most range lines of a channel.
const MOST_ROWS: usize = 400;
/// Most radials: those of a turn.
const MOST_RADIALS: usize = 2048;

/// What is shown of a run.
pub struct Hub {
    /// First message of every browser, JSON.
    pub about: String,
    /// Names of the platforms.
    pub platforms: Vec<String>,
    /// Error of each class of pulses, dB; empty where there is one.
    pub classes_db: Vec<f64>,
    /// Mean PRF, Hz.
    pub prf_hz: f64,
    /// Asks for changes, where that is allowed.
    pub control: Option<Control>,
    /// What is changed.
    log: Option<Arc<Log>>,
    state: Mutex<State>,
    begun: Instant,
    ended: AtomicBool,
    /// Channels whose range-Doppler maps somebody looks at.
    doppler: Vec<AtomicBool>,
    /// Whether somebody looks at the plan position panel.
    ppi: AtomicBool,
    /// Length of the cells of its radials, there and back, s.
    pub ppi_cell_s: f64,
    /// Browsers connected.
    pub browsers: AtomicUsize,
    /// Rows that browsers did not take in time.
    pub left_out: AtomicU64,
    /// Connections refused because too many were open.
    pub turned_away: AtomicU64,
}

/// What changes while the run goes on.
pub struct State {
    /// Range lines of each channel, the oldest first.
    pub rows: Vec<VecDeque<Row>>,
    most_rows: usize,
    /// Delay from a column to the next, s.
    pub column_s: f64,
    /// Radials of the plan position panel, the oldest first.
    pub radials: VecDeque<Radial>,
    /// The latest range-Doppler map.
    pub map: Option<Map>,
    /// The latest pulse.
    pub now: Option<Now>,
    /// The whole run.
    pub history: History,
    /// How the stream counts.
    pub counters: Counters,
    /// Pulses that the monitor did not take.
    pub not_shown: u64,
    /// Emission time made in a second of generation, lately.
    pub real_time_factor: Option<f64>,
    /// Losses and when they began.
    pub losses: Vec<Loss>,
    /// What it means that a pulse is missing.
    missing: &'static str,
}

/// Something that is lost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Loss {
    /// What, in words.
    pub what: String,
    /// How many pulses.
    pub pulses: u64,
    /// Pulse released when the first loss was seen.
    pub since_pulse: u64,
    /// Seconds after the begin of the run when it was seen.
    pub since_s: f64,
    /// Seconds after the begin when the last one was seen.
    pub last_s: f64,
}

/// The latest pulse.
#[derive(Clone, Debug, Default)]
pub struct Now {
    /// Its number.
    pub pulse: u64,
    /// Its emission after that of pulse 0, s.
    pub time_s: f64,
    /// Its emission, UTC nanoseconds since 1970.
    pub unix_ns: i64,
    /// Start of its window, s.
    pub window_start_s: f64,
    /// Its flags.
    pub flags: u32,
    /// True states.
    pub truth: Vec<PlatformRecord>,
    /// Reported states.
    pub reported: Vec<PlatformRecord>,
    /// Phase centres, East, North, up, m.
    pub antennas_m: Vec<[f64; 3]>,
    /// Main lobes on the sea.
    pub footprints: Vec<Footprint>,
    /// Delays of targets, `[pair][target]`, s.
    pub delays_s: Vec<f64>,
    /// Their Doppler frequencies, Hz.
    pub dopplers_hz: Vec<f64>,
    /// Ships: position, East, North, m.
    pub ships_m: Vec<[f64; 3]>,
    /// Their headings, clockwise from North, degrees.
    pub headings_deg: Vec<f64>,
    /// Middle of the patch of sea.
    pub patch_m: Option<[f64; 2]>,
}

impl Hub {
    /// Of a run that has not begun.
    pub fn new(header: &Header, scenery: &Scenery, control: Option<Control>) -> Self {
        let ranges = Ranges::new(header);
        let columns = ranges.as_ref().map(Ranges::columns);
        let ppi = Ppi::new(header);
        let row_bytes = 2 * columns.unwrap_or(1) * header.layout.channels.max(1);
        Self {
            about: about(header, scenery, columns, ppi.as_ref(), control.is_some()).to_string(),
            platforms: header.platforms.clone(),
            classes_db: header.error_classes_db().to_vec(),
            prf_hz: header.prf_hz,
            control,
            log: header.changes.clone(),
            state: Mutex::new(State {
                rows: vec![VecDeque::new(); header.layout.channels],
                most_rows: (ROWS_BYTES / row_bytes).clamp(16, MOST_ROWS),
                column_s: ranges.as_ref().map_or(0.0, Ranges::column_s),
                radials: VecDeque::new(),
                map: None,
                now: None,
                history: History::new(header.platforms.len()),
                counters: Counters::default(),
                not_shown: 0,
                real_time_factor: None,
                losses: Vec::new(),
                missing: if scenery.replayed {
                    "the recording does not have them"
                } else {
                    "not made in time and not released"
                },
            }),
            begun: Instant::now(),
            ended: AtomicBool::new(false),
            doppler: header.channels.iter().map(|_| AtomicBool::new(false)).collect(),
            ppi: AtomicBool::new(false),
            ppi_cell_s: ppi.as_ref().map_or(0.0, Ppi::cell_s),
            browsers: AtomicUsize::new(0),
            left_out: AtomicU64::new(0),
            turned_away: AtomicU64::new(0),
        }
    }

    /// What is shown now.
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The changes up to the latest pulse and those that are still to come.
    pub fn changes(&self) -> Vec<Entry> {
        self.log.as_ref().map_or_else(Vec::new, |log| log.between(None, u64::MAX))
    }

    /// Somebody looks at the range-Doppler map of a channel.
    pub fn watch_doppler(&self, channel: usize) {
        if let Some(wanted) = self.doppler.get(channel) {
            wanted.store(true, Ordering::Relaxed);
        }
    }

    /// Whether somebody has looked at the map of a channel since the last call.
    pub fn is_doppler_wanted(&self, channel: usize) -> bool {
        self.doppler.get(channel).is_some_and(|wanted| wanted.swap(false, Ordering::Relaxed))
    }

    /// Somebody looks at the plan position panel.
    pub fn watch_ppi(&self) {
        self.ppi.store(true, Ordering::Relaxed);
    }

    /// Whether somebody has looked at it since the last call.
    pub fn is_ppi_wanted(&self) -> bool {
        self.ppi.swap(false, Ordering::Relaxed)
    }

    /// Nothing more will come.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Whether nothing more will come.
    pub fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    /// Seconds since it began.
    pub fn elapsed_s(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }
}

impl State {
    /// Appends a range line; the oldest one goes.
    pub fn push_row(&mut self, channel: usize, mut row: Row) {
        let Some(rows) = self.rows.get_mut(channel) else { return };
        row.number = rows.back().map_or(1, |last| last.number + 1);
        while rows.len() >= self.most_rows {
            rows.pop_front();
        }
        rows.push_back(row);
    }

    /// Appends a radial; the oldest one goes.
    pub fn push_radial(&mut self, mut radial: Radial) {
        radial.number = self.radials.back().map_or(1, |last| last.number + 1);
        while self.radials.len() >= MOST_RADIALS {
            self.radials.pop_front();
        }
        self.radials.push_back(radial);
    }

    /// Takes new counters, and notes what has been lost since the last ones.
    pub fn count(&mut self, counters: Counters, not_shown: u64, elapsed_s: f64) {
        let dropped = [(self.missing.to_owned(), counters.dropped)];
        let missed =
            counters.sinks.iter().map(|sink| (format!("sink '{}' was too slow", sink.name), sink.dropped));
        for (what, pulses) in dropped.into_iter().chain(missed).filter(|(_, pulses)| *pulses > 0) {
            match self.losses.iter_mut().find(|loss| loss.what == what) {
                Some(loss) if loss.pulses == pulses => {}
                Some(loss) => (loss.pulses, loss.last_s) = (pulses, elapsed_s),
                None => {
                    let since_pulse = self.now.as_ref().map_or(0, |now| now.pulse);
                    self.losses.push(Loss {
                        what,
                        pulses,
                        since_pulse,
                        since_s: elapsed_s,
                        last_s: elapsed_s,
                    });
                }
            }
        }
        self.counters = counters;
        self.not_shown = not_shown;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pulse::Layout;
    use crate::transport::health::SinkCounters;

    fn hub(channels: usize) -> Hub {
        let header =
            Header { layout: Layout { channels, samples: 4, ..Layout::default() }, ..Header::default() };
        Hub::new(&header, &Scenery::default(), None)
    }

    /// However long the run, the rows held stay as many.
    #[test]
    fn memory_is_bounded() {
        let hub = hub(3);
        let mut state = hub.state();
        for pulse in 0..10_000 {
            for channel in 0..4 {
                state.push_row(channel, Row { pulse, ..Row::default() });
            }
        }
        let held: Vec<usize> = state.rows.iter().map(VecDeque::len).collect();
        assert_eq!(held, [MOST_ROWS; 3]);
        let (first, last) = (state.rows[0].front().unwrap(), state.rows[0].back().unwrap());
        assert_eq!((last.number, last.number - first.number), (10_000, MOST_ROWS as u64 - 1));
        // Many channels have fewer rows each: the limit is one of bytes.
        let wide = Header {
            sample_rate_hz: 1e6,
            bandwidth_hz: 1e6,
            replica: vec![num_complex::Complex32::ONE],
            layout: Layout { channels: 256, samples: 4096, ..Layout::default() },
            ..Header::default()
        };
        let hub = Hub::new(&wide, &Scenery::default(), None);
        let most = hub.state().most_rows;
        assert!(most * 256 * 2 * 1024 <= ROWS_BYTES && most >= 16, "{most}");
    }

    #[test]
    fn losses_are_known_since_when() {
        let hub = hub(1);
        let mut state = hub.state();
        let of = |dropped, missed| Counters {
            dropped,
            sinks: vec![SinkCounters { name: "hdf5".into(), dropped: missed, ..SinkCounters::default() }],
            ..Counters::default()
        };
        state.count(of(0, 0), 0, 1.0);
        assert!(state.losses.is_empty());
        state.now = Some(Now { pulse: 40, ..Now::default() });
        state.count(of(0, 3), 0, 2.0);
        state.now = Some(Now { pulse: 50, ..Now::default() });
        state.count(of(2, 3), 0, 3.0);
        state.count(of(2, 9), 0, 4.0);
        let [sink, dropped] = &state.losses[..] else { panic!("{:?}", state.losses) };
        assert_eq!((sink.pulses, sink.since_pulse, sink.since_s, sink.last_s), (9, 40, 2.0, 4.0));
        assert_eq!((dropped.pulses, dropped.since_pulse, dropped.last_s), (2, 50, 3.0));
        assert!(sink.what.contains("hdf5"));
    }
}
