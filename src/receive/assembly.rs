//! From packets to pulses.
//!
//! A signal packet belongs to the pulse on whose sample grid its time stamp lies: with `t0` the time of the pulse's
//! first sample and `fs` the sample rate, `n = (t - t0) fs` is a whole number from 0 up to the samples of a pulse. Stamps
//! are rounded to picoseconds, so `t` and `t0` are off by half a picosecond each.

use std::collections::VecDeque;

use num_complex::Complex32;

use crate::pulse::{PlatformRecord, Pulse, SampleFormat, Samples, flags};
use crate::sinks::sink::Header;
use crate::time::TimeTag;

use super::context::State;
use super::packet::{Frame, SECOND_PS};

/// Pulses that may be open at a time: a packet that comes later than so many pulses after its own is too late.
const OPEN_PULSES: usize = 8;
/// Memory of open pulses, samples.
const OPEN_SAMPLES: usize = 1 << 25;
/// Closed pulses that are remembered, to know doubles when they come.
const CLOSED_PULSES: usize = 64;
/// Signal packets that may wait for a pulse that nothing has told of yet.
const WAITING: usize = 64;
/// How far a stamp may lie outside the run as it was described: the farthest window, and runs that slip a little.
const BESIDE_S: f64 = 1e6;
const SLIP: f64 = 0.01;
/// A stamp so far after all others is first taken for a wrong one, s.
const LEAP_PS: i128 = 3600 * SECOND_PS;
/// So many datagrams in a row are no accident: a leap is followed, and so is a stream that goes back.
const AGREEING: u32 = 64;
/// How far a stamp may lie from the grid: half a picosecond for it and for the first sample's, and one more for the
/// arithmetic of a window in f64.
const GRID_PS: f64 = 2.0;

/// A pulse that is being put together.
#[derive(Debug)]
struct Open {
    /// Time of the first sample.
    first_ps: i128,
    /// Whether its number is known: a state has come.
    known: bool,
    states: Vec<bool>,
    /// A bit for every sample, channels one after the other.
    got: Vec<u64>,
    /// Words of `got` that are not all 0 lie within: a long window is not wiped for every datagram.
    touched: std::ops::Range<usize>,
    missing: usize,
    pulse: Box<Pulse>,
}

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
    /// No pulse can have it.
    Stray,
    /// Its time is not one of this run, or far from all others.
    Implausible,
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

/// Samples that came before anything told of their pulse.
#[derive(Debug)]
struct Early {
    channel: usize,
    time_ps: i128,
    payload: Vec<u8>,
}

/// Puts pulses together and hands them on in the order of their emission.
#[derive(Debug)]
pub(super) struct Assembly {
    header: Header,
    open: VecDeque<Open>,
    most: usize,
    free: Vec<Open>,
    early: VecDeque<Early>,
    closed: VecDeque<(i128, bool)>,
    /// Time of the first sample of the last pulse that was closed.
    last_ps: Option<i128>,
    /// Emission of the last pulse that was closed and known.
    last_emission: Option<TimeTag>,
    gap: bool,
    /// Times that the run can have, as it was described.
    span_ps: (i128, i128),
    /// Latest first sample of a pulse that was opened.
    latest_ps: Option<i128>,
    /// Datagrams in a row that lie far ahead, and that are too late; the time of the last one of these.
    ahead: u32,
    late: u32,
    late_ps: i128,
    /// Times that the stream went back.
    pub(super) rewound: u64,
    pub(super) pulses: Pulses,
}

/// Times that pulses of a run can have.
fn span_ps(header: &Header) -> (i128, i128) {
    let start_ps = i128::from(header.start.seconds()) * SECOND_PS;
    // Conversions of what is too large, or no number, end at the limits.
    let after =
        |pulse: u64| (pulse as f64 / header.prf_hz * (1.0 + SLIP) + BESIDE_S).min(1e15) * SECOND_PS as f64;
    let end = header.first_pulse.saturating_add(header.pulses);
    (start_ps - (BESIDE_S * SECOND_PS as f64) as i128, start_ps + after(end) as i128)
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

impl Open {
    fn new(header: &Header) -> Self {
        let layout = &header.layout;
        let total = layout.channels * layout.samples;
        Self {
            first_ps: 0,
            known: false,
            states: vec![false; layout.platforms],
            got: vec![0; total.div_ceil(64)],
            touched: 0..0,
            missing: total,
            pulse: Box::new(Pulse::new(layout)),
        }
    }

    fn begin(&mut self, first_ps: i128, total: usize) {
        self.first_ps = first_ps;
        self.known = false;
        self.states.fill(false);
        if let Some(words) = self.got.get_mut(std::mem::take(&mut self.touched)) {
            words.fill(0);
        }
        self.missing = total;
    }

    fn has(&self, at: usize) -> bool {
        self.got.get(at / 64).is_some_and(|word| word >> (at % 64) & 1 == 1)
    }

    fn is_complete(&self) -> bool {
        self.missing == 0 && self.known && self.states.iter().all(|&came| came)
    }

    /// Copies the samples of a packet to `at..`; counts those that are new.
    fn fill(&mut self, at: usize, count: usize, payload: &[u8]) {
        let words = at / 64..(at + count).div_ceil(64);
        self.touched = match self.touched.is_empty() {
            true => words,
            false => self.touched.start.min(words.start)..self.touched.end.max(words.end),
        };
        for k in at..at + count {
            if let Some(word) = self.got.get_mut(k / 64) {
                let bit = 1 << (k % 64);
                self.missing -= usize::from(*word & bit == 0);
                *word |= bit;
            }
        }
        match &mut self.pulse.samples {
            Samples::Cf32(all) => {
                for (sample, bytes) in all.iter_mut().skip(at).zip(payload.chunks_exact(8)) {
                    let part = |from: usize| {
                        bytes
                            .get(from..from + 4)
                            .and_then(|b| b.try_into().ok())
                            .map_or(0.0, f32::from_be_bytes)
                    };
                    *sample = Complex32::new(part(0), part(4));
                }
            }
            Samples::Ci16(all) => {
                for (sample, bytes) in all.iter_mut().skip(at).zip(payload.chunks_exact(4)) {
                    let part = |from: usize| {
                        bytes
                            .get(from..from + 2)
                            .and_then(|b| b.try_into().ok())
                            .map_or(0, i16::from_be_bytes)
                    };
                    *sample = [part(0), part(2)];
                }
            }
        }
    }

    fn state(&mut self, state: &State) {
        let pulse = &mut *self.pulse;
        pulse.index = state.index;
        pulse.time = TimeTag::new(state.emission.0, state.emission.1);
        pulse.window_start_s = state.window_start_s;
        pulse.flags = state.flags;
        pulse.tx_pol = state.tx_pol;
        self.known = true;
        let platform = state.platform[0] as usize;
        if let (Some(record), Some(came)) =
            (pulse.nav_reported.get_mut(platform), self.states.get_mut(platform))
        {
            *came = true;
            *record = PlatformRecord {
                position_m: state.position_m,
                velocity_mps: state.velocity_mps,
                attitude_quat: state.attitude_quat,
                age_s: state.age_s,
                flags: state.platform_flags,
            };
        }
    }
}

impl Assembly {
    pub(super) fn new(header: &Header) -> Self {
        let total = (header.layout.channels * header.layout.samples).max(1);
        Self {
            header: header.clone(),
            open: VecDeque::new(),
            most: (OPEN_SAMPLES / total).clamp(2, OPEN_PULSES),
            free: Vec::new(),
            early: VecDeque::new(),
            closed: VecDeque::with_capacity(CLOSED_PULSES),
            last_ps: None,
            last_emission: None,
            gap: false,
            span_ps: span_ps(header),
            latest_ps: None,
            ahead: 0,
            late: 0,
            late_ps: 0,
            rewound: 0,
            pulses: Pulses::default(),
        }
    }

    /// Whether a time can be one of this run: one stamp from another century must not make all others late.
    pub(super) fn is_plausible(&self, time_ps: i128) -> bool {
        (self.span_ps.0..=self.span_ps.1).contains(&time_ps)
    }

    /// Whether a pulse may be opened at a time: not at a single stamp far ahead of all others.
    fn may_begin(&mut self, first_ps: i128) -> bool {
        if self.latest_ps.is_some_and(|latest| first_ps - latest > LEAP_PS) {
            self.ahead += 1;
            return self.ahead >= AGREEING;
        }
        true
    }

    /// What is in its time ends every suspicion.
    fn in_time(&mut self) {
        (self.ahead, self.late) = (0, 0);
    }

    /// Counts what is too late. Datagrams that only are late do not come in a row and in their order: when so many do, the
    /// stream has gone back, or was led astray by wrong stamps, and is followed to where it is.
    fn follow_back(
        &mut self,
        time_ps: i128,
        taken: Taken,
        done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> bool {
        if taken != Taken::Late {
            return false;
        }
        self.late = if time_ps >= self.late_ps { self.late + 1 } else { 1 };
        self.late_ps = time_ps;
        if self.late < AGREEING {
            return false;
        }
        while !self.open.is_empty() {
            self.close(done);
        }
        self.closed.clear();
        self.early.clear();
        (self.last_ps, self.latest_ps, self.last_emission) = (None, None, None);
        self.rewound += 1;
        self.in_time();
        true
    }

    /// Bytes of a sample.
    fn width(&self) -> usize {
        match self.header.layout.format {
            SampleFormat::Cf32 => 8,
            SampleFormat::Ci16 => 4,
        }
    }

    /// A state: the pulse that it tells of is opened, or named.
    pub(super) fn state(
        &mut self,
        time_ps: i128,
        state: &State,
        done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> Taken {
        let first_ps = time_ps + (state.window_start_s * SECOND_PS as f64).round() as i128;
        if state.platform[0] as usize >= self.header.layout.platforms {
            return Taken::Stray;
        }
        if !self.is_plausible(time_ps) {
            return Taken::Implausible;
        }
        let near = |open: &Open| (open.first_ps - first_ps).unsigned_abs() <= GRID_PS as u128;
        let place = match self.open.iter().position(near) {
            Some(place) => place,
            None => {
                if let Some(taken) = self.closed(first_ps, 1)
                    && !self.follow_back(first_ps, taken, done)
                {
                    return taken;
                }
                if !self.may_begin(first_ps) {
                    return Taken::Implausible;
                }
                self.begin(first_ps, done)
            }
        };
        let Some(open) = self.open.get_mut(place) else { return Taken::Stray };
        if open.states.get(state.platform[0] as usize) == Some(&true) {
            return Taken::Double;
        }
        open.state(state);
        self.in_time();
        self.hand_on(done);
        Taken::Yes
    }

    /// Samples of a channel.
    pub(super) fn samples(
        &mut self,
        channel: usize,
        time_ps: i128,
        frame: Option<Frame>,
        payload: &[u8],
        done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>,
    ) -> Taken {
        let samples = self.header.layout.samples;
        let width = self.width();
        let count = payload.len() / width;
        if count == 0 || count > samples || !payload.len().is_multiple_of(width) {
            return Taken::Stray;
        }
        if !self.is_plausible(time_ps) {
            return Taken::Implausible;
        }
        let begins = matches!(frame, Some(Frame::First | Frame::Only));
        if let Some(taken) = self.place(channel, time_ps, begins, count, payload) {
            self.in_time();
            self.hand_on(done);
            return taken;
        }
        if let Some(taken) = self.closed(time_ps, samples)
            && !self.follow_back(time_ps, taken, done)
        {
            return taken;
        }
        if begins {
            if !self.may_begin(time_ps) {
                return Taken::Implausible;
            }
            // The first word of a pulse whose states are missing or still to come.
            let place = self.begin(time_ps, done);
            if let Some(open) = self.open.get_mut(place) {
                open.fill(channel * samples, count, payload);
            }
            self.hand_on(done);
            return Taken::Yes;
        }
        if self.early.len() >= WAITING {
            self.early.pop_front();
            self.pulses.strays += 1;
        }
        self.early.push_back(Early { channel, time_ps, payload: payload.to_vec() });
        Taken::Waits
    }

    /// Puts samples into the open pulse on whose grid they lie.
    fn place(
        &mut self,
        channel: usize,
        time_ps: i128,
        begins: bool,
        count: usize,
        payload: &[u8],
    ) -> Option<Taken> {
        let (samples, rate_hz) = (self.header.layout.samples, self.header.sample_rate_hz);
        let mut double = None;
        for open in &mut self.open {
            let fits = |at: &usize| at + count <= samples && (!begins || *at == 0);
            let Some(at) = sample_at(time_ps, open.first_ps, rate_hz).filter(fits) else { continue };
            let at = channel * samples + at;
            if open.has(at) {
                double = Some(Taken::Double);
                continue;
            }
            open.fill(at, count, payload);
            return Some(Taken::Yes);
        }
        double
    }

    /// What a packet is whose time lies in a pulse that was closed, or before all that are open.
    fn closed(&self, time_ps: i128, samples: usize) -> Option<Taken> {
        let rate_hz = self.header.sample_rate_hz;
        let lies_in = |&&(first_ps, _): &&(i128, bool)| {
            sample_at(time_ps, first_ps, rate_hz).is_some_and(|at| at < samples)
        };
        if let Some((_, complete)) = self.closed.iter().rev().find(lies_in) {
            return Some(if *complete { Taken::Double } else { Taken::Late });
        }
        let last_ps = self.last_ps?;
        (time_ps < last_ps).then_some(Taken::Late)
    }

    /// Opens a pulse at its place among the others, and gives up the oldest where there are too many.
    fn begin(&mut self, first_ps: i128, done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>) -> usize {
        while self.open.len() >= self.most {
            self.close(done);
        }
        self.latest_ps = Some(self.latest_ps.map_or(first_ps, |latest| latest.max(first_ps)));
        let mut open = self.free.pop().unwrap_or_else(|| Open::new(&self.header));
        open.begin(first_ps, self.header.layout.channels * self.header.layout.samples);
        let place = self.open.partition_point(|other| other.first_ps < first_ps);
        let (samples, width) = (self.header.layout.samples, self.width());
        // What has waited for this pulse.
        self.early.retain(|early| {
            let count = early.payload.len() / width;
            let at = sample_at(early.time_ps, first_ps, self.header.sample_rate_hz);
            let Some(at) = at.filter(|at| at + count <= samples) else { return true };
            open.fill(early.channel * samples + at, count, &early.payload);
            false
        });
        self.open.insert(place, open);
        place
    }

    /// Hands on what is complete at the front.
    fn hand_on(&mut self, done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        while self.open.front().is_some_and(Open::is_complete) {
            self.close(done);
        }
    }

    /// Closes the oldest pulse, complete or not.
    fn close(&mut self, done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        let Some(mut open) = self.open.pop_front() else { return };
        let complete = open.is_complete();
        if self.closed.len() >= CLOSED_PULSES {
            self.closed.pop_front();
        }
        self.closed.push_back((open.first_ps, complete));
        self.last_ps = Some(open.first_ps);
        let pulses = &mut self.pulses;
        if open.known {
            let (index, time) = (open.pulse.index, open.pulse.time);
            match pulses.last {
                Some(last) if index <= last => pulses.backwards += 1,
                Some(last) => {
                    let missing = index - last - 1;
                    pulses.missing_by_index = pulses.missing_by_index.saturating_add(missing);
                    self.gap |= missing > 0;
                }
                None => pulses.first = Some(index),
            }
            if let Some(last) = self.last_emission {
                let intervals = (time.since(last) * self.header.prf_hz).round();
                let missing = (intervals - 1.0).max(0.0) as u64;
                pulses.missing_by_time = pulses.missing_by_time.saturating_add(missing);
            }
            pulses.last = Some(index);
            self.last_emission = Some(time);
        }
        if complete {
            pulses.complete += 1;
            if std::mem::take(&mut self.gap) {
                open.pulse.flags |= flags::AFTER_GAP;
            }
            let Open { first_ps, known, states, got, touched, missing, pulse } = open;
            let pulse = done(pulse).unwrap_or_else(|| Box::new(Pulse::new(&self.header.layout)));
            open = Open { first_ps, known, states, got, touched, missing, pulse };
        } else {
            pulses.incomplete += 1;
            self.gap = true;
        }
        self.free.push(open);
    }

    /// The end: closes all.
    pub(super) fn finish(&mut self, done: &mut impl FnMut(Box<Pulse>) -> Option<Box<Pulse>>) {
        while !self.open.is_empty() {
            self.close(done);
        }
        self.pulses.strays += self.early.len() as u64;
        self.early.clear();
    }
}
