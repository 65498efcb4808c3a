//! From packets to pulses.
//!
//! A signal packet belongs to the pulse on whose sample grid its time stamp lies: with `t0` the time of the
//! pulse's first sample and `fs` the sample rate, `n = (t - t0) fs` is a whole number from 0 up to the
//! samples of a pulse. Stamps are rounded to picoseconds, so `t` and `t0` are off by half a picosecond each.

use std::collections::VecDeque;

use crate::frames::{Body, Vector};
use crate::pulse::{Pulse, SampleFormat, flags};
use crate::recording::header::Header;
use crate::time::TimeTag;

use super::context::State;
use super::open::Open;
use super::packet::{Frame, Kind, Packet, SECOND_PS};
use super::track::{Numbers, Track, Verdict};

/// Pulses that may be open at a time: a packet that comes later than so many pulses after its own is too
/// late.
const OPEN_PULSES: usize = 8;
/// Memory of open pulses, samples.
const OPEN_SAMPLES: usize = 1 << 25;
/// Closed pulses that are remembered, to know doubles when they come.
const CLOSED_PULSES: usize = 64;
/// Signal packets that may wait for a pulse that nothing has announced yet.
const WAITING: usize = 64;
/// How far a stamp may lie outside the run as it was described: the farthest window, and runs that slip a
/// little.
const BESIDE_S: f64 = 1e6;
const SLIP: f64 = 0.01;
/// Mean intervals between pulses that are no neighbours: twice as many as may be open.
const APART: f64 = 16.0;
/// How far a stamp may lie from the grid: half a picosecond for it and for the first sample's, and one more
/// for the arithmetic of a window in f64.
const GRID_PS: f64 = 2.0;

/// What became of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// It is part of a pulse.
    Yes,
    /// What it brings has been there.
    Double,
    /// Its pulse has been given up.
    Late,
    /// It waits for its pulse.
    Waits,
    /// The same waits already.
    WaitsAlready,
    /// No pulse can have it.
    Stray,
    /// Its time is not one of this run, or far from all others.
    Implausible,
    /// It lies so far ahead that it may be anybody's; if the stream turns out to be there, it is wanted
    /// again.
    Ahead,
    /// It has shown that the stream is where those that lay ahead were: it is wanted again, after them.
    Moved,
    /// Its number is not one of this run, not that of its time, or not that of its pulse.
    Misnumbered,
}

impl Taken {
    /// Whether the packet is of the run, as far as can be seen: one that waits, or that no pulse can have,
    /// may be anybody's.
    pub(super) fn is_of_run(self) -> bool {
        matches!(self, Self::Yes | Self::Double | Self::Late)
    }
}

/// Counters of pulses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Pulses {
    pub(super) complete: u64,
    pub(super) incomplete: u64,
    pub(super) first: Option<u64>,
    pub(super) last: Option<u64>,
    pub(super) missing_by_index: u64,
    pub(super) missing_by_time: u64,
    pub(super) backwards: u64,
    /// Signal packets that waited in vain.
    pub(super) strays: u64,
}

/// Samples that came before anything announced their pulse.
#[derive(Debug)]
struct Early {
    channel: usize,
    /// Packet count.
    count: u8,
    time_ps: i128,
    payload: Vec<u8>,
}

/// A packet that had waited and has found its pulse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) channel: usize,
    pub(super) count: u8,
    pub(super) time_ps: i128,
}

/// A pulse that was handed on or given up.
#[derive(Debug)]
struct Closed {
    first_ps: i128,
    /// Of every channel, where they differ.
    firsts_ps: Vec<i128>,
    complete: bool,
}

/// The receiver of each channel, where these have windows of their own; else empty.
fn receivers_apart(header: &Header) -> Vec<usize> {
    let channels = if header.layout.windows > 0 { header.layout.channels } else { 0 };
    (0..channels).map(|channel| header.receiver_of(channel).unwrap_or(0)).collect()
}

/// Puts pulses together and hands them on in the order of their emission.
#[derive(Debug)]
pub(super) struct Assembly {
    header: Header,
    /// Platform and lever arm of every antenna.
    arms: Vec<(usize, Vector<Body>)>,
    /// Antennas that scan, whose encoders are read in every state.
    scanning: Vec<usize>,
    open: VecDeque<Open>,
    most: usize,
    free: Vec<Open>,
    early: VecDeque<Early>,
    found: Vec<Found>,
    closed: VecDeque<Closed>,
    /// Receiver of each channel, where these have windows of their own; else empty.
    receivers: Vec<usize>,
    /// How far the first samples of channels lie from that of the pulse, at most.
    spread_ps: i128,
    /// Time of the first sample of the last pulse that was closed.
    last_ps: Option<i128>,
    /// Emission of the last pulse that was closed and known.
    last_emission: Option<TimeTag>,
    gap: bool,
    /// Numbers of pulses of which only states came, since the last one with samples.
    unsound: Vec<u64>,
    /// Times that the run can have, as it was described.
    span_ps: (i128, i128),
    /// First sample of the last whole pulse, or of the first that was opened.
    base_ps: Option<i128>,
    /// A pulse so far after another is none of its neighbours.
    apart_ps: i128,
    track: Track,
    numbers: Numbers,
    /// Times that the stream went back to where it had been.
    pub(super) rewound: u64,
    pub(super) pulses: Pulses,
}

/// Times that pulses of a run can have.
fn span_ps(header: &Header) -> (i128, i128) {
    let start_ps = i128::from(header.start.seconds()) * SECOND_PS;
    // Conversions of what is too large, or no number, end at the limits.
    let after =
        |pulse: u64| (pulse as f64 / header.prf_hz * (1.0 + SLIP) + BESIDE_S).min(1e15) * SECOND_PS as f64;
    // A run without a stated length may have any.
    let pulses = if header.pulses == 0 { u64::MAX } else { header.pulses };
    let end = header.first_pulse.saturating_add(pulses);
    (start_ps - (BESIDE_S * SECOND_PS as f64) as i128, start_ps + after(end) as i128)
}

/// An emission as a stamp has it.
fn emission_ps(emission: TimeTag) -> i128 {
    i128::from(emission.seconds()) * SECOND_PS + (emission.fraction_s() * SECOND_PS as f64).round() as i128
}

/// Where a time lies on a grid: the sample, if it is near one.
fn sample_at(time_ps: i128, first_ps: i128, rate_hz: f64) -> Option<usize> {
    let after_ps = time_ps.checked_sub(first_ps)?;
    if !(-2..i128::from(i64::MAX)).contains(&after_ps) {
        return None;
    }
    let after_ps = after_ps as f64;
    let sample = (after_ps * rate_hz / SECOND_PS as f64).round();
    let off_ps = after_ps - sample / rate_hz * SECOND_PS as f64;
    // An f64 of the span itself is good to 2^-53 of it, twice.
    (sample >= 0.0 && off_ps.abs() <= GRID_PS + after_ps.abs() * 2.0 * f64::EPSILON)
        .then_some(sample as usize)
}

impl Assembly {
    pub(super) fn new(header: &Header) -> Self {
        let total = (header.layout.channels * header.layout.samples).max(1);
        let antennas = header.instrument.iter().flat_map(|instrument| &instrument.antennas);
        let arms = antennas.filter_map(|antenna| {
            let carrier = header.platforms.iter().position(|name| *name == antenna.platform)?;
            Some((carrier, antenna.lever_arm()))
        });
        Self {
            header: header.clone(),
            arms: arms.collect(),
            scanning: header.scanning().collect(),
            open: VecDeque::new(),
            most: (OPEN_SAMPLES / total).clamp(2, OPEN_PULSES),
            free: Vec::new(),
            early: VecDeque::new(),
            found: Vec::new(),
            closed: VecDeque::with_capacity(CLOSED_PULSES),
            receivers: receivers_apart(header),
            spread_ps: 0,
            last_ps: None,
            last_emission: None,
            gap: false,
            unsound: Vec::new(),
            span_ps: span_ps(header),
            base_ps: None,
            apart_ps: (APART / header.prf_hz * SECOND_PS as f64) as i128,
            track: Track::new(header),
            numbers: Numbers::new(header),
            rewound: 0,
            pulses: Pulses::default(),
        }
    }

    /// Whether a time can be one of this run: one stamp from another century must not make all others late.
    pub(super) fn is_plausible(&self, time_ps: i128) -> bool {
        (self.span_ps.0..=self.span_ps.1).contains(&time_ps)
    }

    /// Whether a packet lies near the last whole pulse, or where the stream began, by the time of its samples
    /// or its emission, or in a pulse whose states are: what is noted of it changes what is expected of the
    /// packets after it.
    pub(super) fn is_near(&self, kind: Kind, time_ps: i128) -> bool {
        let base_ps = if kind == Kind::Signal { self.base_ps } else { self.track.base_ps() };
        let is_of = |open: &Open| {
            let mut firsts_ps = open.firsts_ps.iter().chain([&open.first_ps]);
            let lies = |at: usize| at < self.header.layout.samples;
            let rate_hz = self.header.sample_rate_hz;
            open.known && firsts_ps.any(|first_ps| sample_at(time_ps, *first_ps, rate_hz).is_some_and(lies))
        };
        base_ps.is_none_or(|base| time_ps.saturating_sub(base).saturating_abs() <= self.track.leap_ps())
            || (kind == Kind::Signal && self.open.iter().any(is_of))
    }

    /// Packets may not be overtaken by more than this: their pulse would have been given up.
    pub(super) fn apart_ps(&self) -> i128 {
        self.apart_ps
    }

    /// Packets that waited, and found their pulses since this was last asked.
    pub(super) fn found(&mut self) -> Vec<Found> {
        std::mem::take(&mut self.found)
    }

    /// Whether the stream is followed to where an emission is out of its place.
    fn follow(
        &mut self,
        emission_ps: i128,
        done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> Verdict {
        let verdict = self.track.elsewhere(emission_ps);
        if verdict == Verdict::Waits {
            return verdict;
        }
        while !self.open.is_empty() {
            self.close(done);
        }
        self.closed.clear();
        self.strand();
        (self.last_ps, self.last_emission, self.base_ps) = (None, None, None);
        self.rewound += u64::from(verdict == Verdict::Rewound);
        verdict
    }

    /// Gives up packets that wait for their pulse.
    fn strand(&mut self) {
        self.pulses.strays += self.early.len() as u64;
        self.early.clear();
    }

    /// Bytes of a sample.
    fn width(&self) -> usize {
        match self.header.layout.format {
            SampleFormat::Cf32 => 8,
            SampleFormat::Ci16 => 4,
        }
    }

    /// A state: its pulse is opened, or named.
    pub(super) fn state(
        &mut self,
        time_ps: i128,
        state: &State,
        done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> Taken {
        let first_ps = time_ps + (state.window_start_s * SECOND_PS as f64).round() as i128;
        let [platform, of] = state.platform;
        if platform >= of
            || of as usize != self.header.layout.platforms
            || !state.adds(self.header.layout.windows, self.scanning.len())
        {
            return Taken::Stray;
        }
        // The stamp is that of the emission.
        let emission = state.time();
        if !self.is_plausible(time_ps) || (emission_ps(emission) - time_ps).abs() > GRID_PS as i128 {
            return Taken::Implausible;
        }
        if !self.numbers.allow(state.index, emission) {
            return Taken::Misnumbered;
        }
        let near = |open: &Open| (open.first_ps - first_ps).unsigned_abs() <= GRID_PS as u128;
        let place = match self.open.iter().position(near) {
            Some(place) => place,
            None => {
                let ahead = || self.track.is_ahead(time_ps).then_some(Taken::Ahead);
                if let Some(taken) = self.closed(first_ps, 1, None).or_else(ahead) {
                    match self.follow(time_ps, done) {
                        Verdict::Waits => return taken,
                        Verdict::Moved => return Taken::Moved,
                        Verdict::Rewound => {}
                    }
                }
                self.begin(first_ps, done)
            }
        };
        let Some(open) = self.open.get_mut(place) else { return Taken::Stray };
        if open.states.get(state.platform[0] as usize) == Some(&true) {
            return Taken::Double;
        }
        if !open.agrees(state) {
            return Taken::Misnumbered;
        }
        open.state(state, &self.arms, &self.scanning);
        self.track.here(time_ps);
        if !self.receivers.is_empty() {
            self.place_windows(place, time_ps);
        }
        self.hand_on(done);
        Taken::Yes
    }

    /// Samples of a channel.
    pub(super) fn samples(
        &mut self,
        channel: usize,
        packet: &Packet<'_>,
        time_ps: i128,
        done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> Taken {
        let Packet { payload, .. } = *packet;
        let samples = self.header.layout.samples;
        let width = self.width();
        let count = payload.len() / width;
        if count == 0 || count > samples || !payload.len().is_multiple_of(width) {
            return Taken::Stray;
        }
        if !self.is_plausible(time_ps) {
            return Taken::Implausible;
        }
        let begins = matches!(packet.frame(), Some(Frame::First | Frame::Only));
        if let Some(taken) = self.place(channel, time_ps, begins, count, payload) {
            self.hand_on(done);
            return taken;
        }
        if let Some(taken) = self.closed(time_ps, samples, Some(channel)) {
            return taken;
        }
        if self.base_ps.is_some_and(|base| time_ps - base > self.track.leap_ps()) {
            return Taken::Ahead;
        }
        if begins && self.receivers.is_empty() {
            // The first word of a pulse whose states are missing or still to come.
            let place = self.begin(time_ps, done);
            if let Some(open) = self.open.get_mut(place) {
                open.fill(channel * samples, count, payload);
            }
            self.hand_on(done);
            return Taken::Yes;
        }
        if self.early.iter().any(|early| (early.channel, early.time_ps) == (channel, time_ps)) {
            return Taken::WaitsAlready;
        }
        if self.early.len() >= WAITING {
            self.early.pop_front();
            self.pulses.strays += 1;
        }
        self.early.push_back(Early { channel, count: packet.count, time_ps, payload: payload.to_vec() });
        Taken::Waits
    }

    /// Puts samples into an open pulse on whose grid they lie: first those whose first samples of the channel
    /// came, for a single state can open a pulse a sample before the true one, whose other packets lie on the
    /// grid of both.
    fn place(
        &mut self,
        channel: usize,
        time_ps: i128,
        begins: bool,
        count: usize,
        payload: &[u8],
    ) -> Option<Taken> {
        let (samples, rate_hz) = (self.header.layout.samples, self.header.sample_rate_hz);
        let fits = |at: &usize| at + count <= samples && (!begins || *at == 0);
        let mut double = None;
        for begun in [true, false] {
            for open in self.open.iter_mut().filter(|open| open.has(channel * samples) == begun) {
                let first_ps = match self.receivers.is_empty() {
                    true => Some(&open.first_ps),
                    false => open.firsts_ps.get(channel),
                };
                let at = first_ps.and_then(|first_ps| sample_at(time_ps, *first_ps, rate_hz));
                let Some(at) = at.filter(fits) else { continue };
                let at = channel * samples + at;
                if open.has(at) {
                    double = Some(Taken::Double);
                    continue;
                }
                open.fill(at, count, payload);
                return Some(Taken::Yes);
            }
        }
        double
    }

    /// What a packet is whose time (of samples of a channel, or of the first of a pulse) lies in a pulse that
    /// was closed, or before all that are open.
    fn closed(&self, time_ps: i128, samples: usize, channel: Option<usize>) -> Option<Taken> {
        let rate_hz = self.header.sample_rate_hz;
        let lies_in = |closed: &&Closed| {
            let own = channel.and_then(|channel| closed.firsts_ps.get(channel));
            let first_ps = own.copied().unwrap_or(closed.first_ps);
            sample_at(time_ps, first_ps, rate_hz).is_some_and(|at| at < samples)
        };
        if let Some(Closed { complete, .. }) = self.closed.iter().rev().find(lies_in) {
            return Some(if *complete { Taken::Double } else { Taken::Late });
        }
        let spread_ps = channel.map_or(0, |_| self.spread_ps);
        (time_ps < self.last_ps? - spread_ps).then_some(Taken::Late)
    }

    /// Finds where the samples of every channel of a pulse begin, once its state has come (stamped
    /// `time_ps`), and takes in those that have waited for it.
    fn place_windows(&mut self, place: usize, time_ps: i128) {
        let Some(open) = self.open.get_mut(place) else { return };
        if !open.firsts_ps.is_empty() {
            return;
        }
        let start_ps = |receiver: &usize| {
            let start_s = open.pulse.receiver_window_start_s.get(*receiver).copied().unwrap_or(0.0);
            time_ps + (start_s * SECOND_PS as f64).round() as i128
        };
        open.firsts_ps = self.receivers.iter().map(start_ps).collect();
        let apart_ps = open.firsts_ps.iter().map(|first_ps| (first_ps - open.first_ps).abs());
        self.spread_ps = apart_ps.fold(self.spread_ps, i128::max);
        let width = self.width();
        let Some(open) = self.open.get_mut(place) else { return };
        Self::take_early(&self.header, width, open, &mut self.early, &mut self.found);
    }

    /// Takes in what has waited for a pulse.
    fn take_early(
        header: &Header,
        width: usize,
        open: &mut Open,
        early: &mut VecDeque<Early>,
        found: &mut Vec<Found>,
    ) {
        let samples = header.layout.samples;
        early.retain(|early| {
            let count = early.payload.len() / width;
            let first_ps = open.firsts_ps.get(early.channel).copied().unwrap_or(open.first_ps);
            let at = sample_at(early.time_ps, first_ps, header.sample_rate_hz);
            let Some(at) = at.filter(|at| at + count <= samples) else { return true };
            open.fill(early.channel * samples + at, count, &early.payload);
            let Early { channel, count, time_ps, .. } = *early;
            found.push(Found { channel, count, time_ps });
            false
        });
    }

    /// Opens a pulse at its place among the others, and gives up the oldest where there are too many.
    fn begin(&mut self, first_ps: i128, done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>) -> usize {
        while self.open.len() >= self.most {
            // First one of which only states came, or only samples: who opens many shall not close those that
            // become whole. Then a pulse that lies apart, or all others if this one comes before them: it
            // would be late.
            let last = self.open.len() - 1;
            let weak = self.open.iter().rposition(|open| !open.is_sound());
            let apart = |open: &Open| open.first_ps - first_ps > self.apart_ps;
            let is_first = self.open.front().is_some_and(|front| first_ps < front.first_ps);
            if let Some(place) = weak {
                self.give_up(place);
            } else if is_first || self.open.back().is_some_and(apart) {
                self.give_up(last);
            } else {
                self.close(done);
            }
        }
        self.base_ps.get_or_insert(first_ps);
        let mut open = self.free.pop().unwrap_or_else(|| Open::new(&self.header));
        open.begin(first_ps, self.header.layout.channels * self.header.layout.samples);
        let place = self.open.partition_point(|other| other.first_ps < first_ps);
        if self.receivers.is_empty() {
            let width = self.width();
            Self::take_early(&self.header, width, &mut open, &mut self.early, &mut self.found);
        }
        self.open.insert(place, open);
        place
    }

    /// Hands on what is complete at the front.
    fn hand_on(&mut self, done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        while self.open.front().is_some_and(Open::is_complete) {
            self.close(done);
        }
    }

    /// Gives up a pulse as if nothing had come of it.
    fn give_up(&mut self, place: usize) {
        if let Some(open) = self.open.remove(place) {
            self.pulses.incomplete += 1;
            self.note_unsound(&open);
            self.free.push(open);
        }
    }

    /// Remembers the number of a pulse of which only states came: it is not missing, but no evidence of
    /// others.
    fn note_unsound(&mut self, open: &Open) {
        if open.known && self.unsound.len() < CLOSED_PULSES {
            self.unsound.push(open.pulse.index);
        }
    }

    /// Counts what is missing before a pulse, by its number and its emission.
    fn count(&mut self, index: u64, emission: TimeTag) {
        let pulses = &mut self.pulses;
        let mut between = std::mem::take(&mut self.unsound);
        match pulses.last {
            Some(last) if index <= last => pulses.backwards += 1,
            Some(last) => {
                between.retain(|other| last < *other && *other < index);
                between.sort_unstable();
                between.dedup();
                let missing = index - last - 1 - between.len() as u64;
                pulses.missing_by_index = pulses.missing_by_index.saturating_add(missing);
                self.gap |= index - last > 1;
            }
            None => pulses.first = Some(index),
        }
        if let Some(last) = self.last_emission {
            let intervals = (emission.since(last) * self.header.prf_hz).round();
            let missing = (intervals - 1.0 - between.len() as f64).max(0.0) as u64;
            pulses.missing_by_time = pulses.missing_by_time.saturating_add(missing);
        }
        pulses.last = Some(index);
        self.last_emission = Some(emission);
    }

    /// Closes the oldest pulse, complete or not.
    fn close(&mut self, done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        let Some(mut open) = self.open.pop_front() else { return };
        let complete = open.is_complete();
        if self.closed.len() >= CLOSED_PULSES {
            self.closed.pop_front();
        }
        let firsts_ps = std::mem::take(&mut open.firsts_ps);
        self.closed.push_back(Closed { first_ps: open.first_ps, firsts_ps, complete });
        if open.is_sound() {
            self.last_ps = self.last_ps.max(Some(open.first_ps));
        }
        if open.is_sound() {
            self.count(open.pulse.index, open.pulse.time);
        } else {
            self.note_unsound(&open);
        }
        let pulses = &mut self.pulses;
        if complete {
            self.track.whole(emission_ps(open.pulse.time));
            self.base_ps = Some(open.first_ps);
            pulses.complete += 1;
            if std::mem::take(&mut self.gap) {
                open.pulse.flags |= flags::AFTER_GAP;
            }
            let pulse = done(open.pulse).unwrap_or_else(|| Box::new(Pulse::new(&self.header.layout)));
            open.pulse = pulse;
        } else {
            pulses.incomplete += 1;
            self.gap = true;
        }
        self.free.push(open);
    }

    /// The end: closes all.
    pub(super) fn finish(&mut self, done: &mut dyn FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        while !self.open.is_empty() {
            self.close(done);
        }
        self.strand();
    }
}
