//! What the stream counts while it runs.
//!
//! Counters are atomic, lateness goes into a histogram of atomic counters of fixed size, and what the system
//! granted is written once. So who counts never allocates and never waits, whoever reads meanwhile and
//! however long that takes: nothing here can be held. Lateness is `release - deadline` in whole nanoseconds;
//! quantiles are reported in microseconds, to 0.1 %.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use serde::Serialize;

use super::durations::Durations;
use super::rights::{self, Right};
use crate::pulse::{Pulse, flags};

/// Counters of a running stream, shared by all of its threads.
#[derive(Debug)]
pub struct Health {
    released: AtomicU64,
    late: AtomicU64,
    held_up: AtomicU64,
    dropped: AtomicU64,
    slipped_ns: AtomicU64,
    stood_still_ns: AtomicU64,
    /// Sum over releases of the moves before them.
    moved_us: AtomicU64,
    made: AtomicU64,
    busy_ns: AtomicU64,
    ring_slots: usize,
    ring_filled: AtomicU64,
    ring_low_water: AtomicU64,
    generation_ended: AtomicBool,
    /// In the order of [`rights::ALL`].
    rights: [OnceLock<Right>; rights::ALL.len()],
    extrapolated: AtomicU64,
    stale: AtomicU64,
    lateness: Durations,
    navigation: Durations,
    lateness_buckets: [AtomicU64; LATENESS_BOUNDS_NS.len() + 1],
    /// Releases by error class.
    classes: [AtomicU64; CLASSES],
    sinks: Vec<Arc<SinkHealth>>,
}

/// Error classes of pulses ([`flags::error_class`]).
pub const CLASSES: usize = flags::MOST_CLASS as usize + 1;

/// Counters of one sink.
#[derive(Debug)]
pub struct SinkHealth {
    name: String,
    slots: usize,
    lossless: bool,
    failed: AtomicBool,
    level: AtomicU64,
    written: AtomicU64,
    dropped: AtomicU64,
    high_water: AtomicU64,
}

/// Lateness, microseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lateness {
    /// Median.
    pub p50: f64,
    /// 99 %.
    pub p99: f64,
    /// 99.9 %.
    pub p999: f64,
    /// Worst.
    pub max: f64,
    /// Mean.
    pub mean: f64,
}

/// From the arrival of navigation to the release of the pulses that rest on it, milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct NavigationLatency {
    /// Shortest.
    pub min: f64,
    /// Median.
    pub p50: f64,
    /// 99 %.
    pub p99: f64,
    /// Worst.
    pub max: f64,
}

/// One sink's counters at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SinkSnapshot {
    /// The sink's name.
    pub name: String,
    /// Pulses that the sink took; of a recording that failed, those that can be read.
    pub written: u64,
    /// Pulses that were released and that this sink missed: its queue was full, or it failed and the run went
    /// on without it.
    pub dropped: u64,
    /// The most pulses that ever waited in its queue.
    pub queue_high_water: u64,
    /// Whether it failed and the run went on without it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub failed: bool,
    /// Whether it is to get every pulse.
    #[serde(skip)]
    pub lossless: bool,
}

/// All counters at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Snapshot {
    /// Pulses released.
    pub pulses: u64,
    /// Pulses released more than one PRI after their deadline.
    pub late: u64,
    /// Those of them that were computed in time: the operating system delayed the thread that releases
    /// pulses.
    pub held_up: u64,
    /// Pulses never released: not made in time (policy `drop`).
    pub dropped: u64,
    /// By how much the schedule was moved (policy `slip`), seconds.
    pub slipped_s: f64,
    /// For how long in all the machine, or this program, stood still, seconds.
    pub stood_still_s: f64,
    /// Pulses that were released and missed by a sink, summed over the sinks.
    pub missed: u64,
    /// Mean over the released pulses of the moves before them, seconds.
    #[serde(skip)]
    pub mean_moved_s: f64,
    /// Lateness of the released pulses; all zero at pace `fast`.
    pub lateness_us: Lateness,
    /// Pulses for which the navigation of a platform was extrapolated.
    pub extrapolated: u64,
    /// Those of them for which it was stale.
    pub stale: u64,
    /// From the arrival of the last fix up to the emission of a pulse to its release; none without live
    /// navigation.
    pub navigation_to_release_ms: Option<NavigationLatency>,
    /// Fewest pulses found ready at a release while generation was running; none before a release.
    pub ring_low_water: Option<u64>,
    /// Whether the pacer ran at real-time priority.
    pub pacer_ahead: bool,
    /// What was asked of the system, and what it granted.
    pub rights: Vec<Right>,
    /// Pulses made.
    pub made: u64,
    /// Time that generation was at work (not waiting for a free slot), seconds.
    pub generation_busy_s: f64,
    /// Pulses released by error class, up to the coarsest that any has.
    #[serde(skip_serializing_if = "of_one_class")]
    pub by_class: Vec<u64>,
    /// The sinks.
    pub sinks: Vec<SinkSnapshot>,
}

fn of_one_class(by_class: &[u64]) -> bool {
    by_class.len() <= 1
}

/// Upper bounds of the buckets of lateness, nanoseconds: 1, 2, 5 of every decade from 1 us to 10 s. One more
/// bucket is for what lies above.
pub const LATENESS_BOUNDS_NS: [u64; 22] = {
    let mut bounds = [0; 22];
    let mut place = 0;
    while place < bounds.len() {
        bounds[place] = 1000 * 10_u64.pow((place / 3) as u32) * [1, 2, 5][place % 3];
        place += 1;
    }
    bounds
};

/// What an onlooker reads while the stream runs. Values are of about one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Counters {
    /// Pulses released.
    pub released: u64,
    /// Pulses released more than one PRI after their deadline.
    pub late: u64,
    /// Those of them that were computed in time.
    pub held_up: u64,
    /// Pulses never released.
    pub dropped: u64,
    /// By how much the schedule was moved, seconds.
    pub slipped_s: f64,
    /// Pulses made.
    pub made: u64,
    /// Time that generation was at work, seconds.
    pub generation_busy_s: f64,
    /// Pulses for which the navigation of a platform was extrapolated.
    pub extrapolated: u64,
    /// Those of them for which it was stale.
    pub stale: u64,
    /// Pulses released by error class.
    pub by_class: [u64; CLASSES],
    /// Releases by lateness, see [`LATENESS_BOUNDS_NS`]; none at pace `fast`.
    pub lateness: [u64; LATENESS_BOUNDS_NS.len() + 1],
    /// Sum of lateness, seconds.
    pub lateness_sum_s: f64,
    /// Slots of the ring between generation and release.
    pub ring_slots: usize,
    /// Pulses that were ready at the last release.
    pub ring_filled: u64,
    /// The sinks.
    pub sinks: Vec<SinkCounters>,
}

/// One sink's part of [`Counters`].
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SinkCounters {
    /// The sink's name.
    pub name: String,
    /// Pulses that the sink took.
    pub written: u64,
    /// Pulses that it missed.
    pub dropped: u64,
    /// Pulses that waited for it at the last release.
    pub queue: u64,
    /// Pulses that may wait for it.
    pub queue_slots: usize,
}

impl Health {
    pub(crate) fn new(sinks: Vec<Arc<SinkHealth>>, ring_slots: usize) -> Self {
        Self {
            released: AtomicU64::new(0),
            late: AtomicU64::new(0),
            held_up: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            slipped_ns: AtomicU64::new(0),
            stood_still_ns: AtomicU64::new(0),
            moved_us: AtomicU64::new(0),
            made: AtomicU64::new(0),
            busy_ns: AtomicU64::new(0),
            ring_slots,
            ring_filled: AtomicU64::new(0),
            ring_low_water: AtomicU64::new(u64::MAX),
            generation_ended: AtomicBool::new(false),
            rights: [const { OnceLock::new() }; rights::ALL.len()],
            extrapolated: AtomicU64::new(0),
            stale: AtomicU64::new(0),
            lateness: Durations::new(),
            navigation: Durations::new(),
            lateness_buckets: [const { AtomicU64::new(0) }; LATENESS_BOUNDS_NS.len() + 1],
            classes: [const { AtomicU64::new(0) }; CLASSES],
            sinks,
        }
    }

    /// Counts a release, its lateness and by how much the schedule had been moved before it.
    pub(crate) fn release(&self, lateness: Option<Duration>, late: bool, moved: Duration) {
        self.released.fetch_add(1, Ordering::Relaxed);
        self.late.fetch_add(u64::from(late), Ordering::Relaxed);
        self.moved_us.fetch_add(u64::try_from(moved.as_micros()).unwrap_or(u64::MAX), Ordering::Relaxed);
        if let Some(lateness) = lateness {
            let ns = self.lateness.record(lateness);
            let bucket = LATENESS_BOUNDS_NS.partition_point(|bound| *bound < ns);
            self.lateness_buckets[bucket].fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Counts a late release of a pulse that was made in time.
    pub(crate) fn hold_up(&self) {
        self.held_up.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts the error class of a pulse, and what navigation it rests on.
    pub(crate) fn passed(&self, pulse: &Pulse) {
        self.classes[flags::error_class(pulse.flags)].fetch_add(1, Ordering::Relaxed);
        let set = |bit| u64::from(pulse.flags & bit != 0);
        self.extrapolated.fetch_add(set(flags::NAV_EXTRAPOLATED), Ordering::Relaxed);
        self.stale.fetch_add(set(flags::NAV_STALE), Ordering::Relaxed);
        if let Some(arrived) = pulse.nav_arrived {
            self.navigation.record(arrived.elapsed());
        }
    }

    pub(crate) fn drop_pulses(&self, n: u64) {
        self.dropped.fetch_add(n, Ordering::Relaxed);
    }

    pub(crate) fn slip(&self, by: Duration) {
        self.slipped_ns.fetch_add(u64::try_from(by.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    pub(crate) fn stood_still(&self, for_so_long: Duration) {
        let ns = u64::try_from(for_so_long.as_nanos()).unwrap_or(u64::MAX);
        self.stood_still_ns.fetch_add(ns, Ordering::Relaxed);
    }

    pub(crate) fn made(&self, n: u64, busy: Duration) {
        self.made.fetch_add(n, Ordering::Relaxed);
        self.busy_ns.fetch_add(u64::try_from(busy.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    pub(crate) fn right(&self, right: Right) {
        // Each is asked for once, by one thread.
        if let Some(place) = rights::ALL.iter().position(|asked| *asked == right.asked) {
            let _ = self.rights[place].set(right);
        }
    }

    pub(crate) fn generation_ended(&self) {
        self.generation_ended.store(true, Ordering::Relaxed);
    }

    pub(crate) fn ring_level(&self, filled: usize) {
        self.ring_filled.store(filled as u64, Ordering::Relaxed);
        if !self.generation_ended.load(Ordering::Relaxed) {
            self.ring_low_water.fetch_min(filled as u64, Ordering::Relaxed);
        }
    }

    /// Pulses released so far.
    pub fn released_pulses(&self) -> u64 {
        self.released.load(Ordering::Relaxed)
    }

    /// Pulses that were late so far.
    pub fn late_pulses(&self) -> u64 {
        self.late.load(Ordering::Relaxed)
    }

    /// Pulses dropped before release so far.
    pub fn dropped_pulses(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    pub(crate) fn made_pulses(&self) -> u64 {
        self.made.load(Ordering::Relaxed)
    }

    /// What can be read at any time without being in anybody's way.
    pub fn counters(&self) -> Counters {
        let read = |of: &AtomicU64| of.load(Ordering::Relaxed);
        Counters {
            released: read(&self.released),
            late: read(&self.late),
            held_up: read(&self.held_up),
            dropped: read(&self.dropped),
            slipped_s: read(&self.slipped_ns) as f64 * 1e-9,
            made: read(&self.made),
            generation_busy_s: read(&self.busy_ns) as f64 * 1e-9,
            extrapolated: read(&self.extrapolated),
            stale: read(&self.stale),
            by_class: self.classes.each_ref().map(read),
            lateness: std::array::from_fn(|bucket| read(&self.lateness_buckets[bucket])),
            lateness_sum_s: self.lateness.sum_s(),
            ring_slots: self.ring_slots,
            ring_filled: read(&self.ring_filled),
            sinks: self.sinks.iter().map(|sink| sink.counters()).collect(),
        }
    }

    /// All counters now. Copies the counts of the histogram (about 0.3 MB): for a status line, not for every
    /// pulse.
    pub fn snapshot(&self) -> Snapshot {
        let lateness_us = self.lateness.measured().map_or_else(Lateness::default, |measured| {
            let us = |share: f64| measured.quantile_ns(share) * 1e-3;
            Lateness {
                p50: us(0.5),
                p99: us(0.99),
                p999: us(0.999),
                max: measured.most_ns * 1e-3,
                mean: measured.mean_ns * 1e-3,
            }
        });
        let navigation_to_release_ms = self.navigation.measured().map(|measured| NavigationLatency {
            min: measured.least_ns * 1e-6,
            p50: measured.quantile_ns(0.5) * 1e-6,
            p99: measured.quantile_ns(0.99) * 1e-6,
            max: measured.most_ns * 1e-6,
        });
        let has_some = |of: &AtomicU64| of.load(Ordering::Relaxed) > 0;
        let coarsest = self.classes.iter().rposition(has_some).map_or(0, |place| place + 1);
        let granted: Vec<Right> = self.rights.iter().filter_map(OnceLock::get).cloned().collect();
        let low = self.ring_low_water.load(Ordering::Relaxed);
        let released = self.released_pulses();
        let sinks: Vec<SinkSnapshot> = self.sinks.iter().map(|sink| sink.snapshot(released)).collect();
        Snapshot {
            pulses: released,
            late: self.late_pulses(),
            held_up: self.held_up.load(Ordering::Relaxed),
            dropped: self.dropped_pulses(),
            slipped_s: self.slipped_ns.load(Ordering::Relaxed) as f64 * 1e-9,
            stood_still_s: self.stood_still_ns.load(Ordering::Relaxed) as f64 * 1e-9,
            missed: sinks.iter().map(|sink| sink.dropped).sum(),
            mean_moved_s: self.moved_us.load(Ordering::Relaxed) as f64 * 1e-6 / released.max(1) as f64,
            lateness_us,
            extrapolated: self.extrapolated.load(Ordering::Relaxed),
            stale: self.stale.load(Ordering::Relaxed),
            navigation_to_release_ms,
            ring_low_water: (low != u64::MAX).then_some(low),
            pacer_ahead: granted.iter().any(|right| right.asked == rights::PRIORITY && right.granted),
            rights: granted,
            made: self.made_pulses(),
            generation_busy_s: self.busy_ns.load(Ordering::Relaxed) as f64 * 1e-9,
            by_class: self.classes[..coarsest].iter().map(|of| of.load(Ordering::Relaxed)).collect(),
            sinks,
        }
    }
}

impl SinkHealth {
    pub(crate) fn new(name: &str, slots: usize, lossless: bool) -> Self {
        Self {
            name: name.to_owned(),
            slots,
            lossless,
            failed: AtomicBool::new(false),
            level: AtomicU64::new(0),
            written: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
            high_water: AtomicU64::new(0),
        }
    }

    pub(crate) fn wrote(&self) {
        self.written.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn wrote_in_all(&self, pulses: u64) {
        self.written.store(pulses, Ordering::Relaxed);
    }

    /// The run goes on without it.
    pub(crate) fn failed(&self) {
        self.failed.store(true, Ordering::Relaxed);
    }

    pub(crate) fn missed(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn queue_level(&self, filled: usize) {
        self.level.store(filled as u64, Ordering::Relaxed);
        self.high_water.fetch_max(filled as u64, Ordering::Relaxed);
    }

    fn counters(&self) -> SinkCounters {
        SinkCounters {
            name: self.name.clone(),
            written: self.written.load(Ordering::Relaxed),
            dropped: self.dropped.load(Ordering::Relaxed),
            queue: self.level.load(Ordering::Relaxed),
            queue_slots: self.slots,
        }
    }

    fn snapshot(&self, released: u64) -> SinkSnapshot {
        let (written, failed) = (self.written.load(Ordering::Relaxed), self.failed.load(Ordering::Relaxed));
        // What waited for it when it failed was neither written nor found its queue full.
        let dropped = match failed {
            true => released.saturating_sub(written),
            false => self.dropped.load(Ordering::Relaxed),
        };
        let queue_high_water = self.high_water.load(Ordering::Relaxed);
        SinkSnapshot {
            name: self.name.clone(),
            written,
            dropped,
            queue_high_water,
            failed,
            lossless: self.lossless,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_recorded() {
        let health = Health::new(Vec::new(), 0);
        for us in 1..=1000_u64 {
            health.release(Some(Duration::from_micros(us)), us > 990, Duration::ZERO);
        }
        let shot = health.snapshot();
        // Three significant digits of the histogram: 0.1 %.
        for (got, want) in [
            (shot.lateness_us.p50, 500.0),
            (shot.lateness_us.p99, 990.0),
            (shot.lateness_us.p999, 999.0),
            (shot.lateness_us.max, 1000.0),
        ] {
            assert!((got / want - 1.0).abs() <= 1e-3, "{got} {want}");
        }
        assert_eq!((shot.pulses, shot.late, shot.ring_low_water), (1000, 10, None));
        let counters = health.counters();
        // 1, 2, 5, ... us: a value on a bound belongs to the bucket that ends there.
        assert_eq!(counters.lateness[..11], [1, 1, 3, 5, 10, 30, 50, 100, 300, 500, 0]);
        assert!((counters.lateness_sum_s - 0.5005).abs() < 1e-9);
        health.release(Some(Duration::MAX), true, Duration::ZERO);
        assert_eq!(health.counters().lateness[LATENESS_BOUNDS_NS.len()], 1);
        assert!(health.snapshot().lateness_us.max >= 3.5e9);
    }

    /// Behind a lock one release in a hundred waited some 20 ms for readers that had lost their core. A
    /// release takes 0.1 us, too short to lose its own in more than a few of them.
    #[test]
    #[cfg_attr(miri, ignore = "measures time")]
    fn who_reads_does_not_hold_up_who_counts() {
        let health = Health::new(Vec::new(), 0);
        let done = AtomicBool::new(false);
        let mut spent: Vec<Duration> = std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let mut pulses = 0;
                    while !done.load(Ordering::Relaxed) {
                        let shot = health.snapshot();
                        assert!(shot.pulses >= pulses);
                        pulses = shot.pulses;
                    }
                });
            }
            let release = |_| {
                std::thread::sleep(Duration::from_micros(200));
                let begun = std::time::Instant::now();
                health.release(Some(Duration::from_micros(1)), false, Duration::ZERO);
                begun.elapsed()
            };
            let spent = (0..500).map(release).collect();
            done.store(true, Ordering::Relaxed);
            spent
        });
        spent.sort();
        println!(
            "a release beside four readers: p50 {:?}, p98 {:?}, p99 {:?}",
            spent[250], spent[490], spent[495]
        );
        assert!(spent[490] < Duration::from_micros(50), "{:?}", spent[490]);
    }
}
