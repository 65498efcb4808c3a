//! Policy `relax`: at which error the next pulses are made.
//!
//! A run has error classes: class 0 is the error that is asked, the others are coarser and take less time.
//! Before every segment the slack is known, what is left until its first pulse is due. With `w` the time that
//! a worker takes for a pulse of class `c`, predicted by the cost model and scaled by the slowest of the
//! last segments and of those under way, and `n` the pulses of a segment,
//!
//! * **coarser** by one class: 2.5 times what a segment of this class or a coarser one takes, `w(c) n(c)` at
//!   most, is more than the slack, and that shrinks; or pulses were given up. The coarsest at once: 1.5 times
//!   that is more;
//! * **finer**, by one class: workers have waited for free slots or for navigation, so much that the next
//!   finer class would keep them busy for [`MOST_BUSY`] of the time at most. That is looked at once a second
//!   of generation, and less and less often where the finer class did not last.
//!
//! A pulse of a class is the same to the bit, whatever made it coarser: segments are cut by pulse numbers.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::fidelity::budget::Plan;

use super::stages::PulseFactory;

/// Segments that fit the slack at least, of this class and of all coarser ones: else the next coarser class
/// is taken, or the coarsest.
const ENOUGH: f64 = 2.5;
const LEAST: f64 = 1.5;
/// Share of the slack that is left when a class that was taken has not stopped it from shrinking.
const SHRUNK: f64 = 0.8;
/// How busy a finer class may keep the workers.
const MOST_BUSY: f64 = 0.85;
/// Time of generation after which a finer class is tried, s, and the longest.
const SETTLE_S: f64 = 1.0;
const LONGEST_SETTLE_S: f64 = 60.0;
/// A finer class that lasted no longer than so many times that was tried too early.
const LASTED: f64 = 10.0;
/// Segments of a worker that show how slow it is: the slowest of them counts, for pulses leave in order.
const RECENT: usize = 3;
/// A class that takes more of the time of the one before is none.
const LEAST_GAIN: f64 = 0.95;

/// Seconds of one worker for a pulse by the cost model.
fn model_s(factory: &PulseFactory) -> f64 {
    factory.plan().map_or(0.0, Plan::seconds)
}

/// Those of ever coarser factories that take less time than the one before, and, where reception is
/// continuous, whose noise goes on from one to the other.
pub(super) fn worth_having(asked: &PulseFactory, coarser: Vec<PulseFactory>) -> Vec<PulseFactory> {
    let mut least_s = model_s(asked);
    let cheaper = |factory: &PulseFactory| {
        let seconds = model_s(factory);
        let goes_on = !factory.is_continuous() || factory.fft_len() == asked.fft_len();
        let is_cheaper = goes_on && seconds < LEAST_GAIN * least_s;
        least_s = if is_cheaper { seconds } else { least_s };
        is_cheaper
    };
    coarser.into_iter().filter(cheaper).collect()
}

/// Which class the next segment has.
pub(super) struct Relaxation {
    /// Seconds of one worker for a pulse of each class, by the cost model.
    model_s: Vec<f64>,
    workers: f64,
    state: Mutex<State>,
}

struct State {
    class: usize,
    /// Where the segment ends for which a class was found last.
    end: Option<u64>,
    /// Of every worker: since when it makes a segment, and what the model says of it, s.
    under_way: Vec<Option<(Instant, f64)>>,
    /// What pulses of the last segments took over what the model says.
    recent: VecDeque<f64>,
    /// Slack when the last segment was begun, after the wait for navigation, s.
    begun_with_s: f64,
    /// Slack when a coarser class was taken, s.
    changed_at_s: f64,
    /// Time of workers since the class last changed, s.
    busy_s: f64,
    waited_s: f64,
    settle_s: f64,
    refined: Option<Instant>,
}

/// A segment that was made.
pub(super) struct Made {
    pub worker: usize,
    pub class: usize,
    pub pulses: u64,
    /// For slots and for navigation.
    pub waited: Duration,
    pub busy: Duration,
    /// Slack when it was begun, s.
    pub begun_with_s: f64,
}

impl Relaxation {
    /// Of what makes each class, with so many workers.
    pub(super) fn new(classes: &[&PulseFactory], workers: usize) -> Self {
        Self::of(classes.iter().map(|factory| model_s(factory)).collect(), workers)
    }

    fn of(model_s: Vec<f64>, workers: usize) -> Self {
        let state = State {
            class: 0,
            end: None,
            under_way: vec![None; workers],
            recent: VecDeque::with_capacity(RECENT * workers.max(1) + 1),
            begun_with_s: f64::INFINITY,
            changed_at_s: f64::INFINITY,
            busy_s: 0.0,
            waited_s: 0.0,
            settle_s: SETTLE_S,
            refined: None,
        };
        Self { model_s, workers: workers.max(1) as f64, state: Mutex::new(state) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The class of pulses that are due in so long, s, where the segment of each class that holds the first
    /// is this.
    pub(super) fn class(&self, first: u64, slack_s: f64, segment: impl Fn(usize) -> Range<u64>) -> usize {
        if self.model_s.len() < 2 {
            return 0;
        }
        // A segment is made whole, whatever part of it is needed.
        let pulses = |class: usize| segment(class).end - segment(class).start;
        let to_end = |class: usize| segment(class).end - first;
        let mut state = self.state();
        let Some(slowness) = state.slowness() else { return state.class };
        let slack_s = slack_s.min(state.begun_with_s);
        let last = self.model_s.len() - 1;
        let takes_s = |class: usize| slowness * self.model_s[class] * pulses(class) as f64;
        let fits = |times: f64, from: usize| (from..=last).all(|class| times * takes_s(class) <= slack_s);
        let is_gap = state.end.is_some_and(|end| first > end);
        let shrinks = slack_s < SHRUNK * state.changed_at_s;
        let needed = if state.class == last || fits(ENOUGH, state.class) && !is_gap {
            state.class
        } else if !fits(LEAST, state.class) {
            last
        } else {
            state.class + usize::from(is_gap || shrinks)
        };
        if needed > state.class {
            let early = |at: Instant| at.elapsed().as_secs_f64() < LASTED * state.settle_s;
            let settle_s = if state.refined.is_some_and(early) { 2.0 * state.settle_s } else { SETTLE_S };
            state.settle_s = settle_s.min(LONGEST_SETTLE_S);
            state.change(needed, slack_s);
        } else if needed > 0 && self.may_refine(&state) && fits(ENOUGH, needed - 1) {
            state.refined = Some(Instant::now());
            state.change(needed - 1, f64::INFINITY);
        }
        state.end = Some(first + to_end(state.class));
        state.class
    }

    fn may_refine(&self, state: &State) -> bool {
        let all_s = state.busy_s + state.waited_s;
        let finer = state.busy_s / all_s * self.model_s[state.class - 1] / self.model_s[state.class];
        all_s >= self.workers * state.settle_s && finer <= MOST_BUSY
    }

    /// Takes note of a segment that a worker begins.
    pub(super) fn begin(&self, worker: usize, class: usize, pulses: u64) {
        self.state().under_way[worker] = Some((Instant::now(), self.model_s[class] * pulses as f64));
    }

    /// Takes note of a segment that was made.
    pub(super) fn made(&self, made: &Made) {
        if self.model_s.len() < 2 {
            return;
        }
        let mut state = self.state();
        state.under_way[made.worker] = None;
        let of_pulse_s = made.busy.as_secs_f64() / made.pulses.max(1) as f64;
        let newest = of_pulse_s / self.model_s[made.class].max(f64::MIN_POSITIVE);
        state.recent.push_back(newest);
        if state.recent.len() > RECENT * state.under_way.len() {
            state.recent.pop_front();
        }
        state.begun_with_s = made.begun_with_s;
        if made.class != state.class {
            return;
        }
        state.busy_s += made.busy.as_secs_f64();
        state.waited_s += made.waited.as_secs_f64();
        // What was long ago says little of now.
        if state.busy_s + state.waited_s > 2.0 * self.workers * state.settle_s {
            state.busy_s /= 2.0;
            state.waited_s /= 2.0;
        }
    }
}

impl State {
    /// What pulses take over what the model says, of late or under way, at worst; `None` before the first.
    fn slowness(&self) -> Option<f64> {
        let so_far = |(since, model_s): &(Instant, f64)| {
            since.elapsed().as_secs_f64() / model_s.max(f64::MIN_POSITIVE)
        };
        let under_way = self.under_way.iter().flatten().map(so_far);
        (!self.recent.is_empty()).then(|| self.recent.iter().copied().chain(under_way).fold(0.0, f64::max))
    }

    fn change(&mut self, class: usize, slack_s: f64) {
        (self.class, self.busy_s, self.waited_s) = (class, 0.0, 0.0);
        self.changed_at_s = slack_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Plays a run of 1000 pulses/s in segments of 50 pulses with one worker that takes so long for a pulse
    /// of class 0, `load` times longer at each instant; the others take a half and a quarter. Slots for 200
    /// pulses. Returns the pulses by class and those that were made too late.
    fn play(pulse_s: f64, seconds: f64, load: impl Fn(f64) -> f64) -> (Vec<[u64; 3]>, u64) {
        const PULSES: u64 = 50;
        let relaxation = Relaxation::of(vec![4.0, 2.0, 1.0], 1);
        let (mut now_s, mut next, mut late) = (0.0f64, 0u64, 0u64);
        let mut by_second = vec![[0; 3]; seconds as usize + 1];
        let due = |pulse: u64| 0.2 + pulse as f64 * 1e-3;
        while due(next) < seconds {
            // A slot is free when the pulse 200 before has left.
            let free_s = due((next + PULSES).saturating_sub(200)) * f64::from(u8::from(next + PULSES > 200));
            let waited_s = (free_s - now_s).max(0.0);
            now_s += waited_s;
            let class = relaxation.class(next, due(next) - now_s, |_| next..next + PULSES);
            let slack_s = due(next) - now_s;
            let busy_s = PULSES as f64 * pulse_s * load(now_s) / [1.0, 2.0, 4.0][class];
            now_s += busy_s;
            let [waited, busy] = [waited_s, busy_s].map(Duration::from_secs_f64);
            relaxation.made(&Made { worker: 0, class, pulses: PULSES, waited, busy, begun_with_s: slack_s });
            late += u64::from(now_s > due(next));
            by_second[due(next) as usize][class] += PULSES;
            next += PULSES;
        }
        (by_second, late)
    }

    #[test]
    fn a_load_is_met_by_a_coarser_class_and_left_again() {
        // Twice as slow from 5 to 10 s: class 0 would take 1.4 of the time, class 1 takes 0.7.
        let (by_second, late) = play(0.7e-3, 20.0, |t| if (5.0..10.0).contains(&t) { 2.0 } else { 1.0 });
        assert_eq!(late, 0, "{by_second:?}");
        assert!(by_second[..5].iter().all(|of| of[1] + of[2] == 0), "{by_second:?}");
        assert!(by_second[7..10].iter().all(|of| of[0] == 0 && of[1] > 0), "{by_second:?}");
        assert!(by_second[14..].iter().all(|of| of[1] + of[2] == 0), "{by_second:?}");
    }

    #[test]
    fn classes_do_not_alternate_where_a_finer_one_does_not_last() {
        // Class 0 would take 1.2 of the time for good; class 1 leaves the workers 0.4.
        let (by_second, late) = play(1.2e-3, 60.0, |_| 1.0);
        let finest: u64 = by_second[5..].iter().map(|of| of[0]).sum();
        assert_eq!((late, finest), (0, 0), "{by_second:?}");
        // Slower by four: the coarsest, and nothing is lost that it can keep.
        let (by_second, late) = play(3.6e-3, 10.0, |_| 1.0);
        assert!(by_second[3..].iter().all(|of| of[0] + of[1] == 0), "{by_second:?}");
        assert!(late <= 2, "{late}");
    }

    #[test]
    fn pulses_that_were_given_up_ask_for_a_coarser_class() {
        let relaxation = Relaxation::of(vec![4.0, 2.0, 1.0], 1);
        let (waited, busy) = (Duration::ZERO, Duration::from_millis(10));
        let made = Made { worker: 0, class: 0, pulses: 50, waited, busy, begun_with_s: 10.0 };
        relaxation.made(&made);
        // Nobody took the first one: it is asked for again.
        let classes = [0, 0, 50, 120, 170].map(|first| relaxation.class(first, 10.0, |_| first..first + 50));
        assert_eq!(classes, [0, 0, 0, 1, 1]);
        // A segment that has taken a hundred times as long as others promises no better.
        relaxation.begin(0, 1, 50);
        std::thread::sleep(Duration::from_millis(500));
        assert_eq!(relaxation.class(220, 0.5, |_| 220..270), 2);
    }

    #[test]
    fn a_run_without_classes_has_none() {
        let relaxation = Relaxation::of(vec![1.0], 2);
        assert_eq!(relaxation.class(0, -1.0, |_| 0..64), 0);
    }
}
