//! Where in time and number the stream is. One datagram is not believed; a majority is.
//!
//! States are counted, by their emission: the stamps of samples step back at every channel. Those that lie
//! elsewhere, far ahead or before what has been closed, propose that the stream is there. A proposal gains a
//! vote with every state that goes on from it, and loses one with every state that does not, above all with
//! every one that is in its place. It is followed when it has [`VOTES`] of [`PULSES`] pulses. So a few forged
//! or late datagrams never lead away, many do not lead away for long, and a sender that begins again is found
//! again after a bounded number of datagrams, whoever else sends. What has led ahead is taken again from the
//! beginning, so that a gap costs no pulse that came whole.

use crate::recording::header::Header;
use crate::time::TimeTag;

use super::packet::SECOND_PS;

/// Votes and pulses of a proposal that is followed.
const VOTES: u32 = 32;
const PULSES: u32 = 16;
/// Emissions farther after that of the last whole pulse propose another place: one second, or so many mean
/// intervals.
const LEAP_S: f64 = 1.0;
const LEAP_INTERVALS: f64 = 64.0;
/// How far a number may lie from that of its emission at the mean PRF: sequences of intervals go ahead and
/// fall behind.
const SLACK: f64 = 64.0;
/// More than the longest sequence of intervals.
const MOST_SLACK: f64 = 131_072.0;

/// What a proposal comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is not believed, or not yet.
    Waits,
    /// The stream is there.
    Moved,
    /// The stream is there, where it has been before: the sender has begun again.
    Rewound,
}

/// Where the stream might be.
#[derive(Clone, Copy, Debug)]
struct Proposal {
    at_ps: i128,
    votes: u32,
    pulses: u32,
    /// Votes of the pulse at hand.
    of_pulse: u32,
}

impl Proposal {
    fn at(at_ps: i128) -> Self {
        Self { at_ps, votes: 1, pulses: 1, of_pulse: 1 }
    }
}

/// The place of the stream.
#[derive(Debug)]
pub(super) struct Track {
    leap_ps: i128,
    /// States of a pulse.
    per_pulse: u32,
    /// Emission of the last whole pulse, or of the pulse with which the stream began here.
    base_ps: Option<i128>,
    /// Emission of the last whole pulse.
    whole_ps: Option<i128>,
    proposal: Option<Proposal>,
}

impl Track {
    pub(super) fn new(header: &Header) -> Self {
        let leap_s = LEAP_S.max(LEAP_INTERVALS / header.prf_hz);
        Self {
            leap_ps: (leap_s.min(1e15) * SECOND_PS as f64) as i128,
            per_pulse: u32::try_from(header.layout.platforms).unwrap_or(u32::MAX),
            base_ps: None,
            whole_ps: None,
            proposal: None,
        }
    }

    /// Whether an emission lies far ahead.
    pub(super) fn is_ahead(&self, time_ps: i128) -> bool {
        self.base_ps.is_some_and(|base| time_ps.saturating_sub(base) > self.leap_ps)
    }

    /// How far an emission may lie from that of the last whole pulse and be of the same place.
    pub(super) fn leap_ps(&self) -> i128 {
        self.leap_ps
    }

    /// Emission of the last whole pulse, or of the pulse with which the stream began here.
    pub(super) fn base_ps(&self) -> Option<i128> {
        self.base_ps
    }

    /// A state is in its place.
    pub(super) fn here(&mut self, emission_ps: i128) {
        self.base_ps.get_or_insert(emission_ps);
        self.vote_down();
    }

    /// A pulse is whole.
    pub(super) fn whole(&mut self, emission_ps: i128) {
        (self.base_ps, self.whole_ps) = (Some(emission_ps), Some(emission_ps));
    }

    fn vote_down(&mut self) {
        if let Some(proposal) = &mut self.proposal {
            proposal.votes -= 1;
            if proposal.votes == 0 {
                self.proposal = None;
            }
        }
    }

    /// A state lies elsewhere.
    pub(super) fn elsewhere(&mut self, emission_ps: i128) -> Verdict {
        let Some(proposal) = &mut self.proposal else {
            self.proposal = Some(Proposal::at(emission_ps));
            return Verdict::Waits;
        };
        let after_ps = emission_ps.saturating_sub(proposal.at_ps);
        if after_ps.saturating_abs() > self.leap_ps {
            self.vote_down();
            return Verdict::Waits;
        }
        // Those of one pulse may differ by their rounding.
        if after_ps < -2 {
            proposal.at_ps = emission_ps;
            proposal.pulses = proposal.pulses.saturating_sub(1);
            self.vote_down();
            return Verdict::Waits;
        }
        if after_ps > 2 {
            proposal.at_ps = emission_ps;
            proposal.pulses = proposal.pulses.saturating_add(1);
            proposal.of_pulse = 0;
        }
        if proposal.of_pulse < self.per_pulse {
            proposal.of_pulse += 1;
            proposal.votes = proposal.votes.saturating_add(1);
        }
        if proposal.votes < VOTES || proposal.pulses < PULSES {
            return Verdict::Waits;
        }
        let been = self.whole_ps.is_some_and(|whole| emission_ps <= whole);
        (self.base_ps, self.whole_ps, self.proposal) = (Some(emission_ps), None, None);
        if been { Verdict::Rewound } else { Verdict::Moved }
    }
}

/// Which numbers pulses can have.
#[derive(Debug)]
pub(super) struct Numbers {
    start: TimeTag,
    prf_hz: f64,
    first: u64,
    /// Pulses of the run; 0 where that is not known.
    count: u64,
    slack: f64,
    /// Numbers in a row that are of the run, but not of their time.
    refused: u32,
}

impl Numbers {
    pub(super) fn new(header: &Header) -> Self {
        let Header { start, prf_hz, first_pulse: first, pulses: count, .. } = *header;
        Self { start, prf_hz, first, count, slack: SLACK, refused: 0 }
    }

    /// Whether a pulse of that emission can have that number: one of the run as it was described, and near
    /// that of the emission by the mean PRF. How near follows from the stream: intervals that differ are
    /// taken for granted when many agree.
    pub(super) fn allow(&mut self, index: u64, emission: TimeTag) -> bool {
        let of_run = index.checked_sub(self.first).is_some_and(|after| self.count == 0 || after < self.count);
        if !of_run {
            return false;
        }
        let off = (emission.since(self.start) * self.prf_hz - index as f64).abs();
        // The PRF is a mean, rounded to an f64.
        let rounding = index as f64 * 1e-12;
        if off <= self.slack + rounding {
            self.refused = 0;
            return true;
        }
        self.refused = self.refused.saturating_add(1);
        if self.refused >= VOTES && off <= MOST_SLACK + rounding {
            (self.slack, self.refused) = ((self.slack * 8.0).min(MOST_SLACK), 0);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track() -> Track {
        let leap_ps = SECOND_PS;
        Track { leap_ps, per_pulse: 4, base_ps: Some(0), whole_ps: Some(0), proposal: None }
    }

    /// Four states a millisecond, until the stream is there.
    fn until_followed(
        track: &mut Track,
        from_ps: i128,
        between: &mut dyn FnMut(&mut Track, u32),
    ) -> Option<u32> {
        (0..1000).find(|k| {
            between(track, *k);
            track.elsewhere(from_ps + i128::from(k / 4) * SECOND_PS / 1000) != Verdict::Waits
        })
    }

    #[test]
    fn a_majority_is_followed() {
        let far = 3000 * SECOND_PS;
        assert_eq!(until_followed(&mut track(), far, &mut |_, _| {}), Some(60));
        // One in four is elsewhere again, or in its place: some more are needed.
        let mut astray = |track: &mut Track, k: u32| {
            if k.is_multiple_of(4) {
                assert_eq!(track.elsewhere(9000 * SECOND_PS + i128::from(k)), Verdict::Waits);
            }
        };
        assert!(until_followed(&mut track(), far, &mut astray).is_some_and(|k| k < 100));
        let mut in_place = |track: &mut Track, k: u32| {
            if k.is_multiple_of(4) {
                track.here(0);
            }
        };
        assert!(until_followed(&mut track(), far, &mut in_place).is_some_and(|k| k < 100));
        // As many in their place as elsewhere: the stream stays.
        assert_eq!(until_followed(&mut track(), far, &mut |track, _| track.here(0)), None);
    }

    #[test]
    fn many_datagrams_of_few_pulses_are_no_stream() {
        let mut track = track();
        for k in 0..1000 {
            assert_eq!(track.elsewhere(3000 * SECOND_PS + k % 2 * SECOND_PS / 2000), Verdict::Waits);
        }
    }

    #[test]
    fn a_place_that_was_is_distinguished_from_a_new_one() {
        let mut track = track();
        track.whole(5000 * SECOND_PS);
        let mut last = Verdict::Waits;
        for k in 0..32 {
            last = track.elsewhere(SECOND_PS * k / 1000);
        }
        assert_eq!(last, Verdict::Rewound);
        for k in 0..32 {
            last = track.elsewhere(SECOND_PS * (3000 + k / 2));
        }
        assert_eq!(last, Verdict::Moved);
    }

    #[test]
    fn numbers_are_those_of_their_time() {
        let start = TimeTag::new(1_000_000, 0.25);
        let mut numbers = Numbers { start, prf_hz: 333.3, first: 10, count: 1000, slack: SLACK, refused: 0 };
        let at = |index: u64| start.plus(index as f64 / 333.3);
        assert!(numbers.allow(10, at(10)) && numbers.allow(1009, at(1009)));
        assert!(
            !numbers.allow(9, at(9)) && !numbers.allow(1010, at(1010)) && !numbers.allow(u64::MAX, at(1))
        );
        assert!(!numbers.allow(500, at(100)));
        // Of a sequence whose pulses come in bursts.
        numbers.count = 0;
        let accepted = (0..1000u64).filter(|k| numbers.allow(1000 + k % 4, at(800))).count();
        assert!(accepted > 900, "{accepted}");
        assert!((0..1000u64).all(|_| !numbers.allow(u64::MAX - 5, at(800))));
    }
}
