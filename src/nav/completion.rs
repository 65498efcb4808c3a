//! Epochs become fixes: a date, a place in the order of time, a height and a heading for each, whether they
//! come from a file or as a receiver sends them.
//!
//! * **Date.** An epoch without a day takes that of its neighbours: the
//!   [`Assembler`](super::epoch::Assembler) dates it by the epoch before; those before the first date are
//!   dated backwards, where the time of day falls by more than half a day, midnight has passed.
//! * **Order.** An epoch that is not later than the one before is left: up to 5 s earlier it is out of order
//!   (two talkers with different delays), more is a step of the clock.
//! * **Height, heading.** What is missing is interpolated between the neighbours that have it,
//!   `a + (b - a) s` with `s` the share of the time between them (headings the short way round), or held
//!   where only one side has it. Without any height at all the fix is at mean sea level; without any heading
//!   it has none.
//!
//! A fix that needs a later neighbour waits for it until an epoch comes that is more than `wait_s` later;
//! then it is completed as at the end of a file, and so are those after it, at once, until a neighbour has
//! come. An epoch without a date waits as long, then it is left. What becomes of epochs depends on them
//! alone, never on the clock of the machine, so that a file and a stream of the same messages give
//! bit-identical results: a file waits without end, a stream `wait_s`, and they differ only where height or
//! heading is missing for longer.
//!
//! A stream does not believe a single date from the future: an epoch more than `wait_s` after the one before
//! counts when the next one follows it; if the next one follows the one before instead, it was a step of the
//! clock. Nor does it stay behind one that was believed: the third of three epochs that follow one another
//! from more than 5 s earlier is taken, and its time may then be earlier than that of fixes that were
//! reported.
//!
//! Limits: not more than 16,384 epochs of a stream wait.
//!
//! ```
//! use nereus::nav::VerticalDatum;
//! use nereus::nav::completion::{Completer, Reported};
//! use nereus::nav::epoch::Epoch;
//!
//! let mut completer = Completer::for_stream(VerticalDatum::Ellipsoid, 0.0, 5.0, true);
//! let mut heights_m = Vec::new();
//! for (second, altitude_m) in [(0, Some(10.0)), (1, None), (2, Some(14.0))] {
//!     let mut epoch = Epoch::default();
//!     (epoch.day, epoch.time_of_day_ns) = (Some(17_000), second * 1_000_000_000);
//!     (epoch.position_deg, epoch.altitude_m) = (Some([53.0, 4.5]), altitude_m);
//!     epoch.yaw_pitch_roll_rad = Some([0.0; 3]);
//!     completer.push(epoch, &mut |reported| {
//!         if let Reported::Fix(fix) = reported {
//!             let nereus::nav::Place::Geodetic(place) = fix.place else { return };
//!             heights_m.push(place.h_m);
//!         }
//!     });
//! }
//! assert_eq!(heights_m, [10.0, 12.0, 14.0]);
//! ```

use std::collections::VecDeque;

use super::epoch::{DAY_NS, Epoch};
use super::{Fix, VerticalDatum};
use crate::time::TimeTag;

/// The step back that two talkers with different delays may cause, s.
pub const DISORDER_S: f64 = 5.0;
/// Epochs of a stream that wait at most.
const MOST_WAITING: usize = 1 << 14;

/// What became of an epoch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reported {
    /// It follows another one; its fix is reported when it is complete.
    Follows {
        /// Line of its first message.
        line: u64,
        /// Its time.
        time: TimeTag,
        /// Time of the epoch before.
        before: TimeTag,
    },
    /// It is more than 5 s earlier than the one before, and left.
    StepsBack {
        /// Line of its first message.
        line: u64,
        /// Its time.
        time: TimeTag,
        /// Time of the epoch before.
        before: TimeTag,
    },
    /// A fix is complete.
    Fix(Fix),
}

/// What was left, and what was filled in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompletionCounts {
    /// Epochs not later than one before by up to 5 s.
    pub out_of_order: u64,
    /// Epochs earlier by more, and epochs of a stream far ahead of those after them.
    pub clock_steps: u64,
    /// Epochs of a stream without a date.
    pub undated: u64,
    /// Fixes without a height of their own.
    pub heights_filled: u64,
    /// Fixes that got the heading of their neighbours.
    pub headings_filled: u64,
}

/// Epochs in a row after which a stream that has stepped back is believed.
const STAYS: u32 = 3;

/// Completes epochs.
#[derive(Clone, Debug)]
pub struct Completer {
    datum: VerticalDatum,
    undulation_m: f64,
    wait_s: f64,
    most: usize,
    counts: CompletionCounts,
    located: bool,
    dated: bool,
    undated: VecDeque<Epoch>,
    /// Time of the epoch taken last.
    last: Option<TimeTag>,
    /// An epoch far ahead of it.
    ahead: Option<(TimeTag, Epoch)>,
    /// The last of epochs far behind it that follow one another, and how many.
    back: Option<(TimeTag, u32)>,
    waiting: VecDeque<(TimeTag, Epoch)>,
    /// Number of the first epoch that waits.
    first: u64,
    height: Filling<f64>,
    attitude: Filling<[f64; 3]>,
}

impl Completer {
    /// For a file: what is missing waits to its end. Heights are measured from `datum` where the messages do
    /// not say; `undulation_m` is that of mean sea level above the ellipsoid.
    pub fn for_file(datum: VerticalDatum, undulation_m: f64) -> Self {
        Self::new(datum, undulation_m, f64::INFINITY, usize::MAX, true)
    }

    /// For a stream: what is missing waits `wait_s`. Headings are filled in only where `headings` states that
    /// they are of use: otherwise no fix waits for one.
    pub fn for_stream(datum: VerticalDatum, undulation_m: f64, wait_s: f64, headings: bool) -> Self {
        Self::new(datum, undulation_m, wait_s, MOST_WAITING, headings)
    }

    fn new(datum: VerticalDatum, undulation_m: f64, wait_s: f64, most: usize, headings: bool) -> Self {
        Self {
            datum,
            undulation_m,
            wait_s,
            most,
            counts: CompletionCounts::default(),
            located: false,
            dated: false,
            undated: VecDeque::new(),
            last: None,
            ahead: None,
            back: None,
            waiting: VecDeque::new(),
            first: 0,
            height: Filling::new(true),
            attitude: Filling::new(headings),
        }
    }

    /// Takes the next epoch and calls with what becomes of it and of those before.
    pub fn push(&mut self, epoch: Epoch, see: &mut dyn FnMut(Reported)) {
        self.located |= epoch.position_deg.is_some();
        if self.dated {
            return self.order(epoch, see);
        }
        if epoch.day.is_none() {
            return self.wait_for_date(epoch);
        }
        self.dated = true;
        date_backwards(self.undated.iter_mut().rev(), &epoch);
        for earlier in std::mem::take(&mut self.undated) {
            self.order(earlier, see);
        }
        self.order(epoch, see);
    }

    /// Takes the end of the stream: what waits is completed with what there is.
    pub fn finish(&mut self, see: &mut dyn FnMut(Reported)) {
        if let Some((time, epoch)) = self.ahead.take() {
            self.take(time, epoch, see);
        }
        let next = self.first + self.waiting.len() as u64;
        self.give_up_heights(next);
        self.give_up_attitudes(next);
        self.release(see);
    }

    /// What was left and filled in so far.
    pub fn counts(&self) -> CompletionCounts {
        self.counts
    }

    /// Whether any epoch had a position.
    pub fn is_located(&self) -> bool {
        self.located
    }

    /// Whether any epoch had a date.
    pub fn is_dated(&self) -> bool {
        self.dated
    }

    fn wait_for_date(&mut self, epoch: Epoch) {
        let newest_ns = epoch.time_of_day_ns;
        self.undated.push_back(epoch);
        while let Some(oldest) = self.undated.front() {
            // Past midnight, and back where talkers differ.
            let age_ns = (newest_ns - oldest.time_of_day_ns + DAY_NS / 2).rem_euclid(DAY_NS) - DAY_NS / 2;
            let age_s = age_ns as f64 * 1e-9;
            if age_s <= self.wait_s && self.undated.len() <= self.most {
                break;
            }
            self.counts.undated += u64::from(oldest.position_deg.is_some());
            self.undated.pop_front();
        }
    }

    /// A dated epoch finds its place among the others.
    fn order(&mut self, epoch: Epoch, see: &mut dyn FnMut(Reported)) {
        let (Some(time), Some(_)) = (epoch.time(), epoch.position_deg) else { return };
        let Some(last) = self.last else { return self.take(time, epoch, see) };
        let mut step_s = time.since(last);
        if let Some((ahead, _)) = self.ahead {
            let after_s = time.since(ahead);
            if after_s > 0.0 {
                // Confirmed by another one.
                if let Some((ahead, epoch)) = self.ahead.take() {
                    self.take(ahead, epoch, see);
                }
                step_s = after_s;
            } else if after_s >= -DISORDER_S && !(step_s > 0.0 && step_s <= self.wait_s) {
                self.counts.out_of_order += 1;
                return;
            } else if step_s > 0.0 {
                // This one follows what is sure: the other was a step of the clock.
                self.ahead = None;
                self.counts.clock_steps += 1;
            }
        }
        if step_s > self.wait_s {
            self.ahead = Some((time, epoch));
        } else if step_s > 0.0 {
            self.take(time, epoch, see);
        } else if step_s >= -DISORDER_S {
            self.counts.out_of_order += 1;
        } else {
            self.counts.clock_steps += 1;
            see(Reported::StepsBack { line: epoch.line, time, before: last });
            if self.wait_s.is_finite() && self.stays_back(time) {
                // What came before was the step: a stream is received from here on.
                self.finish(see);
                self.last = None;
                self.take(time, epoch, see);
            }
        }
    }

    /// Whether an epoch that steps back is the last of [`STAYS`] that follow one another.
    fn stays_back(&mut self, time: TimeTag) -> bool {
        let before = self.back.filter(|(before, _)| (0.0..=self.wait_s).contains(&time.since(*before)));
        let count = before.map_or(1, |(_, count)| count + 1);
        self.back = Some((time, count));
        count >= STAYS
    }

    /// The next epoch in the order of time.
    fn take(&mut self, time: TimeTag, mut epoch: Epoch, see: &mut dyn FnMut(Reported)) {
        if let Some(before) = self.last {
            see(Reported::Follows { line: epoch.line, time, before });
        }
        self.last = Some(time);
        self.back = None;
        // From here on heights are above the ellipsoid.
        epoch.altitude_m = epoch.height_m(self.datum, self.undulation_m).filter(|height| height.abs() < 1e8);
        epoch.separation_m = Some(0.0);
        let number = self.first + self.waiting.len() as u64;
        let (height_m, attitude) = (epoch.altitude_m, epoch.yaw_pitch_roll_rad);
        self.waiting.push_back((time, epoch));
        if let Some(height_m) = height_m {
            let between = |a: f64, b: f64, s: f64| a + (b - a) * s;
            let filled = self.height.arrive(time, height_m, number, self.first, &self.waiting, between);
            self.set_heights(filled);
        } else if self.height.is_given_up() {
            self.give_up_heights(number + 1);
        }
        if let Some(attitude) = attitude {
            let filled = self.attitude.arrive(time, attitude, number, self.first, &self.waiting, turned);
            self.set_attitudes(filled);
        } else if self.attitude.is_given_up() {
            self.give_up_attitudes(number + 1);
        }
        self.release(see);
        // The oldest that is still incomplete has waited long enough.
        while let Some((oldest, _)) = self.waiting.front() {
            if time.since(*oldest) <= self.wait_s && self.waiting.len() <= self.most {
                break;
            }
            if self.height.from == self.first {
                self.give_up_heights(number + 1);
            }
            if self.attitude.from == self.first {
                self.give_up_attitudes(number + 1);
            }
            self.release(see);
        }
    }

    fn set_heights(&mut self, filled: Vec<(usize, f64)>) {
        self.counts.heights_filled += filled.len() as u64;
        for (place, height_m) in filled {
            self.waiting[place].1.altitude_m = Some(height_m);
        }
    }

    fn set_attitudes(&mut self, filled: Vec<(usize, [f64; 3])>) {
        self.counts.headings_filled += filled.len() as u64;
        for (place, attitude) in filled {
            self.waiting[place].1.yaw_pitch_roll_rad = Some(attitude);
        }
    }

    /// All before `next` get the height that there is.
    fn give_up_heights(&mut self, next: u64) {
        let held_m = self.height.before.map_or(self.undulation_m, |(_, held_m)| held_m);
        let places = self.height.give_up(next, self.first);
        self.set_heights(places.map(|place| (place, held_m)).collect());
    }

    /// All before `next` get the attitude that there is, if there is one.
    fn give_up_attitudes(&mut self, next: u64) {
        let held = self.attitude.before;
        let places = self.attitude.give_up(next, self.first);
        if let Some((_, held)) = held {
            self.set_attitudes(places.map(|place| (place, held)).collect());
        }
    }

    /// Passes on the fixes that are complete.
    fn release(&mut self, see: &mut dyn FnMut(Reported)) {
        let complete = self.height.from.min(self.attitude.from);
        while self.first < complete
            && let Some((_, epoch)) = self.waiting.pop_front()
        {
            self.first += 1;
            if let Some(fix) = epoch.fix(self.datum, self.undulation_m) {
                see(Reported::Fix(fix));
            }
        }
    }
}

/// Dates epochs, the latest first, by the first one with a date, which follows them.
pub(super) fn date_backwards<'a>(earlier: impl Iterator<Item = &'a mut Epoch>, dated: &Epoch) {
    let Some(mut day) = dated.day else { return };
    let mut later_ns = dated.time_of_day_ns;
    for earlier in earlier {
        day -= i64::from(earlier.time_of_day_ns - later_ns > DAY_NS / 2);
        earlier.day = Some(day);
        later_ns = earlier.time_of_day_ns;
    }
}

/// A quantity that some epochs do not have.
#[derive(Clone, Copy, Debug)]
struct Filling<T> {
    /// The last epoch that has it.
    before: Option<(TimeTag, T)>,
    /// Number of the first epoch for which it is not decided; past all of them where nobody asks for it.
    from: u64,
    /// Whether epochs without it wait no longer.
    given_up: bool,
    wanted: bool,
}

impl<T: Copy> Filling<T> {
    fn new(wanted: bool) -> Self {
        Self { before: None, from: if wanted { 0 } else { u64::MAX }, given_up: false, wanted }
    }

    fn is_given_up(&self) -> bool {
        self.given_up && self.wanted
    }

    /// An epoch that has it has come: what those before it get, by their place among those that wait.
    fn arrive(
        &mut self,
        time: TimeTag,
        value: T,
        number: u64,
        first: u64,
        waiting: &VecDeque<(TimeTag, Epoch)>,
        between: impl Fn(T, T, f64) -> T,
    ) -> Vec<(usize, T)> {
        if !self.wanted {
            return Vec::new();
        }
        let filled = (self.from..number)
            .filter_map(|missing| {
                let place = usize::try_from(missing - first).ok()?;
                let (at, _) = waiting.get(place)?;
                Some((
                    place,
                    match self.before {
                        Some((t0, before)) => between(before, value, at.since(t0) / time.since(t0)),
                        None => value,
                    },
                ))
            })
            .collect();
        (self.before, self.from, self.given_up) = (Some((time, value)), number + 1, false);
        filled
    }

    /// Nobody waits any longer: the places that miss it.
    fn give_up(&mut self, next: u64, first: u64) -> std::ops::Range<usize> {
        if !self.wanted {
            return 0..0;
        }
        let place = |number: u64| usize::try_from(number.saturating_sub(first)).unwrap_or(usize::MAX);
        let places = place(self.from)..place(next);
        (self.from, self.given_up) = (self.from.max(next), true);
        places
    }
}

/// Yaw, pitch and roll between two, the short way round.
fn turned(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    let short_way = |a: f64, b: f64| {
        let turn = (b - a).rem_euclid(std::f64::consts::TAU);
        if turn > std::f64::consts::PI { turn - std::f64::consts::TAU } else { turn }
    };
    std::array::from_fn(|i| a[i] + short_way(a[i], b[i]) * s)
}
