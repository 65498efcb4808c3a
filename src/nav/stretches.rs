//! Steps of a receiver's clock within a recording.
//!
//! Before a receiver knows the time it reports 1980, a date 1024 weeks ago, or a UTC that is off by the leap
//! seconds it has not yet learnt. A recording is cut where the time steps back by more than 5 s, where it
//! steps ahead by more than a day. The longest stretch is kept, with those before and after it that are in
//! order and not below a twentieth of it; the rest is left and counted.
//!
//! Where the time steps back by up to 5 s and goes on from there at the pace that it had, the shorter side is
//! moved by whole seconds to the time of the longer one: the platform has not stood still or jumped.
//!
//! Single fixes that come late by up to 5 s are no step: [`completion`](super::completion) leaves them.

use super::completion::DISORDER_S;
use super::epoch::Epoch;
use crate::time::TimeTag;

/// The longest gap that any source interpolates, s.
const DAY_S: f64 = 86_400.0;
/// Interval after a late epoch, in the longest of those before it, up to which it goes on from there.
const PACE: f64 = 1.5;
/// A stretch below this share of the longest is not kept.
const LEAST_SHARE: usize = 20;
/// A receiver without the time is further than that from it, s.
const FAR_S: f64 = 300.0 * DAY_S;
/// Epochs in which one that is late is looked for.
const LOOKED_BACK: usize = 1000;
/// Steps that are worded.
const MOST_STEPS: usize = 4;
/// 1024 weeks, s: after so long the GPS week of an older receiver begins again.
pub const ROLLOVER_S: f64 = 1024.0 * 604_800.0;

/// What was left.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Left {
    /// Fixes.
    pub fixes: u64,
    /// Steps of the clock, in words.
    pub steps: Vec<String>,
}

struct Stretch {
    first: usize,
    end: usize,
    from: TimeTag,
    to: TimeTag,
    /// Small step of the clock before it, s.
    late_s: Option<i64>,
}

/// Leaves what lies beyond steps of the clock; all epochs have a date and a place.
pub(super) fn keep(epochs: &mut Vec<Epoch>) -> Left {
    let mut left = Left::default();
    left.steps.extend(moved(epochs));
    let all = stretches(epochs);
    let Some(longest) = (0..all.len()).max_by_key(|i| all[*i].end - all[*i].first) else { return left };
    if all.len() == 1 {
        return left;
    }
    let least = (all[longest].end - all[longest].first).div_ceil(LEAST_SHARE);
    let is_long = |stretch: &Stretch| stretch.end - stretch.first >= least;
    let is_near = |gap_s: f64| gap_s > 0.0 && gap_s < FAR_S;
    let mut kept = vec![false; all.len()];
    kept[longest] = true;
    let (mut from, mut to) = (all[longest].from, all[longest].to);
    for (index, stretch) in all.iter().enumerate().skip(longest + 1) {
        if is_long(stretch) && is_near(stretch.from.since(to)) {
            (kept[index], to) = (true, stretch.to);
        }
    }
    for (index, stretch) in all.iter().enumerate().take(longest).rev() {
        if is_long(stretch) && is_near(from.since(stretch.to)) {
            (kept[index], from) = (true, stretch.from);
        }
    }
    for (index, stretch) in all.iter().enumerate().filter(|(index, _)| !kept[*index]) {
        let fixes = stretch.end - stretch.first;
        left.fixes += fixes as u64;
        if left.steps.len() < MOST_STEPS {
            left.steps.push(step(&all, index, longest, fixes));
        }
    }
    let mut ranges = all.iter().zip(&kept).peekable();
    let mut index = 0;
    epochs.retain(|_| {
        while ranges.next_if(|(stretch, _)| stretch.end <= index).is_some() {}
        index += 1;
        ranges.peek().is_some_and(|(_, kept)| **kept)
    });
    left
}

/// Moves what lies on the shorter side of small steps; the first of them in words.
fn moved(epochs: &mut [Epoch]) -> Option<String> {
    let all = stretches(epochs);
    let mut first = None;
    for pair in all.windows(2) {
        let Some(step_s) = pair[1].late_s else { continue };
        let is_before = pair[0].end - pair[0].first < pair[1].end - pair[1].first;
        let (stretch, by_s, place) =
            if is_before { (&pair[0], step_s, "before") } else { (&pair[1], -step_s, "behind") };
        for epoch in &mut epochs[stretch.first..stretch.end] {
            epoch.leap_s += by_s;
        }
        let fixes = stretch.end - stretch.first;
        first.get_or_insert_with(|| {
            format!(
                "{fixes} {place} a step of the clock by {step_s:+} s at {} moved by {by_s:+} s (leap seconds learnt late)",
                pair[1].from
            )
        });
    }
    first
}

/// A stretch that was left, in words.
fn step(all: &[Stretch], index: usize, longest: usize, fixes: usize) -> String {
    let (stretch, beside) = (&all[index], if index < longest { &all[index + 1] } else { &all[index - 1] });
    let step_s = if index < longest { beside.from.since(stretch.to) } else { stretch.from.since(beside.to) };
    let place = if index < longest { "before" } else { "behind" };
    let rollovers = (step_s / ROLLOVER_S).round();
    let why = if rollovers != 0.0 && (step_s - rollovers * ROLLOVER_S).abs() < 2.0 * DAY_S {
        " (1024 weeks: a GPS week that had rolled over)"
    } else {
        ""
    };
    format!("{fixes} {place} a step of the clock by {step_s:+.3} s{why} left, from {}", stretch.from)
}

fn stretches(epochs: &[Epoch]) -> Vec<Stretch> {
    let mut all: Vec<Stretch> = Vec::new();
    // Time of the epoch before; epochs that go on from one that is late: the first, how many, their interval.
    let mut before = TimeTag::default();
    let mut late: Option<(usize, usize, f64)> = None;
    for (index, epoch) in epochs.iter().enumerate() {
        let Some(time) = epoch.time() else { continue };
        let new = |first| Stretch { first, end: index + 1, from: time, to: time, late_s: None };
        let Some(open) = all.last_mut() else {
            all.push(new(0));
            before = time;
            continue;
        };
        let step_s = time.since(open.to);
        let interval_s = time.since(before);
        if !(-DISORDER_S..=DAY_S).contains(&step_s) {
            late = None;
            all.push(new(index));
        } else if step_s > 0.0 {
            open.end = index + 1;
            match late.take() {
                Some((first, count, pace_s)) if count > 1 && interval_s <= PACE * pace_s => {
                    let from = epochs[first].time().unwrap_or(time);
                    let to = epochs[..first].last().and_then(Epoch::time).unwrap_or(open.to);
                    (open.end, open.to) = (first, to);
                    let late_s = from.since(to) - pace_s;
                    let whole_s =
                        Some(late_s.round()).filter(|whole_s| (whole_s - late_s).abs() < 0.1 * pace_s);
                    all.push(Stretch { from, late_s: whole_s.map(|s| s as i64), ..new(first) });
                }
                _ => open.to = time,
            }
        } else {
            open.end = index + 1;
            late = match late {
                Some((first, count, pace_s)) if interval_s > 0.0 => {
                    Some((first, count + 1, pace_s.max(interval_s)))
                }
                _ if is_sent_twice(&epochs[..index], epoch) => None,
                _ => Some((index, 1, 0.0)),
            };
        }
        before = time;
    }
    all
}

/// Whether an epoch has come before, with the same time and place.
fn is_sent_twice(before: &[Epoch], epoch: &Epoch) -> bool {
    let same = |other: &Epoch| other.time() == epoch.time() && other.position_deg == epoch.position_deg;
    before.iter().rev().take(LOOKED_BACK).any(same)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn epochs(seconds: impl IntoIterator<Item = f64>) -> Vec<Epoch> {
        let of = |(index, seconds): (usize, f64)| {
            let mut epoch = Epoch::default();
            epoch.day = Some(17_000 + (seconds / DAY_S).floor() as i64);
            epoch.time_of_day_ns = (seconds.rem_euclid(DAY_S) * 1e9) as i64;
            epoch.position_deg = Some([50.0, 1e-4 * index as f64]);
            epoch
        };
        seconds.into_iter().enumerate().map(of).collect()
    }

    fn span(from: f64, fixes: usize) -> Vec<f64> {
        (0..fixes).map(|k| from + k as f64).collect()
    }

    #[test]
    fn the_longest_stretch_is_kept() {
        let (cold, late, rolled) = (-9e8, 1e4 - 2.0, -ROLLOVER_S + 1e4);
        for (parts, kept, left) in [
            (vec![span(0.0, 50)], 50, 0),
            (vec![span(cold, 4), span(0.0, 50)], 50, 4),
            (vec![span(1e4 + 9.0, 10), span(late, 40)], 40, 10),
            (vec![span(rolled, 10), span(1e4 + 10.0, 40)], 40, 10),
            // Learnt late: 2 s back, and on at the same pace. Moved.
            (vec![span(0.0, 10), span(8.0, 30)], 40, 0),
            // Two sessions of one log, a week apart, are both meant.
            (vec![span(0.0, 50), span(7.0 * DAY_S, 20)], 70, 0),
            // One fix that is late is none of a step.
            (vec![span(0.0, 10), vec![6.5], span(10.0, 30)], 41, 0),
        ] {
            let mut all = epochs(parts.concat());
            let found = keep(&mut all);
            assert_eq!((all.len(), found.fixes), (kept, left), "{:?}", found.steps);
        }
        let mut moved = epochs([span(0.0, 10), span(8.0, 30)].concat());
        assert!(keep(&mut moved).steps[0].starts_with("10 before a step of the clock by -2 s"));
        let steps: Vec<f64> =
            moved.windows(2).map(|pair| pair[1].time().unwrap().since(pair[0].time().unwrap())).collect();
        assert!(steps.iter().all(|step_s| *step_s == 1.0), "{steps:?}");
        let mut twice = epochs(span(0.0, 10));
        twice.extend_from_within(6..10);
        twice.extend(epochs(span(0.0, 30)).split_off(10));
        assert_eq!(keep(&mut twice).fixes, 0);
        assert_eq!(twice.len(), 34);
    }
}
