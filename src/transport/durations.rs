//! Durations that one thread measures and any thread reads, neither waiting for the other.
//!
//! Each is counted in a bucket of a histogram by one atomic addition. Whoever reads copies the counts, about
//! 0.3 MB, while they go on growing: his figures are of about one instant. Quantiles are those of buckets
//! that are less than 0.1 % wide, the upper end of each; sum, least and most are exact. Values are whole
//! nanoseconds, those above 73 minutes count as that long in quantiles.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use histogram::{AtomicHistogram, Histogram};

/// Buckets of a power of two: 2^10, each less than 0.1 % of its value.
const GROUPING_POWER: u8 = 10;
/// Largest value in quantiles: 2^42 ns less one.
const MAX_POWER: u8 = 42;

/// Durations that were measured.
#[derive(Debug)]
pub(super) struct Durations {
    counts: Option<AtomicHistogram>,
    number: AtomicU64,
    sum_ns: AtomicU64,
    least_ns: AtomicU64,
    most_ns: AtomicU64,
}

/// What was measured up to an instant; there is at least one duration.
pub(super) struct Measured {
    counts: Histogram,
    /// Shortest, ns.
    pub(super) least_ns: f64,
    /// Longest, ns.
    pub(super) most_ns: f64,
    /// Mean, ns.
    pub(super) mean_ns: f64,
}

impl Durations {
    pub(super) fn new() -> Self {
        Self {
            counts: AtomicHistogram::new(GROUPING_POWER, MAX_POWER).ok(),
            number: AtomicU64::new(0),
            sum_ns: AtomicU64::new(0),
            least_ns: AtomicU64::new(u64::MAX),
            most_ns: AtomicU64::new(0),
        }
    }

    /// Counts a duration; never waits. Returns it in nanoseconds.
    pub(super) fn record(&self, duration: Duration) -> u64 {
        let ns = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        if let Some(counts) = &self.counts {
            // Within range, so this cannot fail.
            let _ = counts.increment(ns.min((1 << MAX_POWER) - 1));
        }
        self.sum_ns.fetch_add(ns, Ordering::Relaxed);
        self.least_ns.fetch_min(ns, Ordering::Relaxed);
        self.most_ns.fetch_max(ns, Ordering::Relaxed);
        self.number.fetch_add(1, Ordering::Relaxed);
        ns
    }

    /// Sum of all, s.
    pub(super) fn sum_s(&self) -> f64 {
        self.sum_ns.load(Ordering::Relaxed) as f64 * 1e-9
    }

    /// What was measured so far, if anything was.
    pub(super) fn measured(&self) -> Option<Measured> {
        let number = self.number.load(Ordering::Relaxed);
        let counts = self.counts.as_ref().filter(|_| number > 0)?.load();
        Some(Measured {
            counts,
            least_ns: self.least_ns.load(Ordering::Relaxed) as f64,
            most_ns: self.most_ns.load(Ordering::Relaxed) as f64,
            mean_ns: self.sum_s() * 1e9 / number as f64,
        })
    }
}

impl Measured {
    /// The duration that a share of them, 0 to 1, does not exceed, ns.
    pub(super) fn quantile_ns(&self, share: f64) -> f64 {
        let bucket = self.counts.quantile_bucket(share).ok().flatten();
        bucket.map_or(self.most_ns, |bucket| (bucket.end() as f64).min(self.most_ns))
    }
}
