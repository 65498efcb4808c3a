//! A reference receiver of the wire.
//!
//! It is written against ANSI/VITA 49.2-2017 and `docs/wire.md`, and shares no packing code with
//! [`crate::sinks::vita49`]: what both agree on is on the wire. [`Listener`] owns the socket, [`Receiver`]
//! knows only datagrams.
//!
//! A pulse is whole when every sample of every channel has come, and the state of every platform. Pulses are
//! handed on in the order of their emission; one that is not whole when eight later ones are open is given up
//! and counted. All that is read is bounded, a datagram that is no packet is counted, and what came first of
//! two contradicting descriptions holds.
//!
//! Lateness is `arrival - emission` above its least value: it needs no common clock, only two that run alike.
//!
//! Nothing hangs on one datagram, for anybody may have sent it. Times and numbers of pulses must be of the
//! run as it was described and agree with each other. A leap of more than a second is followed when a
//! majority of the states agree, 32 of 16 pulses at least, and so is a stream that goes back. Until the first
//! pulse is whole, descriptions that contradict what was learned make the receiver learn again. A sender that
//! begins again is counted in `restarts`; [`Receiver::following`] begins again with it.
//!
//! Limits: one run at a time; contexts with field attributes (CIF 7) are not read; packet counts of four bits
//! do not see sixteen lost packets in a row, time stamps and pulse numbers do.
//!
//! ```
//! use nereus::receive::Receiver;
//! let mut receiver = Receiver::new();
//! receiver.take(b"no packet", std::time::Instant::now(), &mut |pulse| Some(pulse));
//! let report = receiver.finish(&mut |pulse| Some(pulse));
//! assert_eq!((report.datagrams, report.malformed, report.pulses), (1, 1, 0));
//! ```

mod assembly;
pub mod context;
pub mod listener;
mod open;
mod order;
pub mod packet;
pub mod parts;
mod radar;
mod recording;
pub mod report;
#[cfg(feature = "shm")]
pub mod shm;
mod roster;
mod track;

use std::collections::hash_map::Entry;
use std::collections::{HashMap, VecDeque};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::time::TimeTag;

use assembly::{Assembly, Taken};
use context::{Context, Extension, RunDescription, State};
use order::{Order, Stream};
use packet::{Kind, Malformed, Packet};
use report::{Arrivals, Platform, Report};
use roster::Roster;

pub use listener::{Listener, ReceiveError};

/// Further runs that are followed: whoever can begin runs does not fill a disk with their files.
pub(crate) const RUNS: usize = 999;

/// What the wire does not carry.
pub const NOT_CARRIED: &[&str] =
    &["nav/*/true", "nav/*/{phase_centre_m,boresight_quat}", "truth", "config", "pairs"];
/// The same from a sender that describes no radar.
const NOT_DESCRIBED: &[&str] = &[
    "nav/*/true",
    "nav/*/{phase_centre_m,reported_phase_centre_m,boresight_quat}",
    "truth",
    "replica",
    "instrument",
    "config",
    "pairs",
    "transmitters",
    "receivers",
];

/// Takes whole pulses; what it gives back is used again.
pub trait Outlet: FnMut(Box<Pulse>) -> Option<Box<Pulse>> {}
impl<F: FnMut(Box<Pulse>) -> Option<Box<Pulse>>> Outlet for F {}

/// Puts a run together from datagrams.
#[derive(Debug, Default)]
pub struct Receiver {
    roster: Roster,
    assembly: Option<Assembly>,
    streams: HashMap<(u32, Kind), Stream>,
    report: Report,
    arrivals: Arrivals,
    /// Emission and arrival of the first whole pulse.
    first: Option<(TimeTag, Instant)>,
    /// Whether another run of the sender is followed.
    follows: bool,
    /// Another run that was described, and how often since this one was.
    other: Option<(Box<RunDescription>, u32)>,
    /// Runs before this one.
    runs_before: usize,
    /// Times that the present assembly was seen to go back.
    rewound: u64,
    /// Times that a run was known.
    known: u64,
    withheld: Withheld,
}

/// Datagrams that lie ahead of the stream, in case that it turns out to be there: after a gap the first
/// pulses are evidence, and are not lost for it.
#[derive(Debug, Default)]
struct Withheld {
    datagrams: VecDeque<(Vec<u8>, Instant)>,
    bytes: usize,
    /// Whether the stream is there.
    believed: bool,
}

/// Most bytes that are withheld; the oldest go first.
const WITHHELD_BYTES: usize = 32 << 20;

impl Withheld {
    fn push(&mut self, datagram: &[u8], arrival: Instant) {
        self.bytes += datagram.len();
        self.datagrams.push_back((datagram.to_vec(), arrival));
        while self.bytes > WITHHELD_BYTES
            && let Some((oldest, _)) = self.datagrams.pop_front()
        {
            self.bytes -= oldest.len();
        }
    }
}

/// Descriptions of another run that must come in a row before it is believed: one datagram may be anybody's.
const AGREEING: u32 = 2;

impl Receiver {
    /// One that knows nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// One that follows the sender into its next run.
    pub fn following() -> Self {
        Self { follows: true, ..Self::default() }
    }

    /// Runs that came to an end because the sender began another.
    pub fn runs_before(&self) -> usize {
        self.runs_before
    }

    /// Times that the sender was seen to restart.
    pub fn restarts(&self) -> u64 {
        self.report.restarts
    }

    /// The header of a recording, once the run is known.
    pub fn header(&self) -> Option<&Header> {
        self.roster.known().map(|known| &known.header)
    }

    /// Times that a run, or the same one again, was known: another header then holds.
    pub(super) fn times_known(&self) -> u64 {
        self.known
    }

    /// Whole pulses so far.
    pub fn pulses(&self) -> u64 {
        self.report.pulses.saturating_add(self.whole_pulses())
    }

    /// Whole pulses of the present run.
    fn whole_pulses(&self) -> u64 {
        self.assembly.as_ref().map_or(0, |assembly| assembly.pulses.complete)
    }

    /// Datagrams that are none of the run, as far as can be seen.
    pub(super) fn refused(&self) -> u64 {
        let Report { malformed, unknown, implausible, misnumbered, stray, .. } = self.report;
        let in_vain = self.assembly.as_ref().map_or(0, |assembly| assembly.pulses.strays);
        [malformed, unknown, implausible, misnumbered, stray, in_vain]
            .into_iter()
            .fold(0, u64::saturating_add)
    }

    /// Whether another run may be followed.
    fn may_follow(&self) -> bool {
        self.follows && self.runs_before < RUNS
    }

    /// Takes a datagram; whole pulses go to `outlet`.
    pub fn take(&mut self, datagram: &[u8], arrival: Instant, outlet: &mut dyn Outlet) {
        self.report.datagrams += 1;
        self.report.bytes += datagram.len() as u64;
        self.read_counted(datagram, arrival, outlet);
        if self.withheld.believed {
            let Withheld { datagrams, .. } = std::mem::take(&mut self.withheld);
            for (datagram, arrival) in datagrams {
                // Counted when it was withheld; it is counted as what it is now.
                self.report.implausible -= 1;
                self.read_counted(&datagram, arrival, outlet);
            }
        }
        let rewound = self.assembly.as_ref().map_or(0, |assembly| assembly.rewound);
        if rewound > self.rewound {
            self.rewound = rewound;
            self.report.restarts += 1;
            if self.may_follow() {
                self.begin_again(outlet);
                self.use_ready();
            } else {
                // Counts and times of the streams are those from before.
                self.forget_streams();
            }
        }
    }

    fn read_counted(&mut self, datagram: &[u8], arrival: Instant, outlet: &mut dyn Outlet) {
        if let Err(fault) = self.read(datagram, arrival, outlet) {
            self.report.malformed += 1;
            self.report.first_fault.get_or_insert_with(|| fault.to_string());
        }
    }

    /// Ends the run that is received. What is known of it stays known, for the same run may begin again.
    fn begin_again(&mut self, outlet: &mut dyn Outlet) {
        self.close_run(outlet);
        self.runs_before += 1;
    }

    fn close_run(&mut self, outlet: &mut dyn Outlet) {
        self.close_pulses(outlet);
        self.assembly = None;
        self.withheld = Withheld::default();
        self.forget_streams();
        self.other = None;
        self.rewound = 0;
    }

    fn forget_streams(&mut self) {
        let by_count = &mut self.report.missing.packets_by_count;
        *by_count = self.streams.values().fold(*by_count, |sum, stream| sum.saturating_add(stream.missing()));
        self.streams.clear();
    }

    /// Forgets what was learned.
    fn forget_roster(&mut self) {
        self.report.contradictions = self.report.contradictions.saturating_add(self.roster.contradictions);
        self.roster = Roster::default();
    }

    /// Looks whether a description is of another run, which may be followed.
    fn another(&mut self, description: &Extension, outlet: &mut dyn Outlet) {
        let Extension::Run(run) = description else { return };
        if !self.roster.is_another(run) {
            self.other = None;
            return;
        }
        let times = match &self.other {
            Some((other, times)) if roster::same_run(other, run) => times.saturating_add(1),
            _ => 1,
        };
        self.other = Some((run.clone(), times));
        if times != AGREEING || self.whole_pulses() == 0 {
            return;
        }
        self.report.restarts += 1;
        if !self.may_follow() {
            return;
        }
        self.begin_again(outlet);
        self.forget_roster();
    }

    /// Learns a description. What came first holds once a pulse of it has been whole; until then, what came
    /// last does.
    fn learn(&mut self, stream: u32, description: Extension, outlet: &mut dyn Outlet) {
        if self.roster.learn(stream, description.clone()) || self.whole_pulses() > 0 {
            return;
        }
        self.close_run(outlet);
        self.roster.learn_again(stream, description);
    }

    fn read(&mut self, datagram: &[u8], arrival: Instant, outlet: &mut dyn Outlet) -> Result<(), Malformed> {
        let packet = Packet::parse(datagram)?;
        let Some(stream) = packet.stream else {
            self.report.unknown += 1;
            return Ok(());
        };
        match packet.kind {
            Kind::Signal => {
                if self.is_plausible(&packet) && self.is_new(stream, &packet) {
                    let taken = self.signal(stream, &packet, arrival, outlet);
                    self.note_taken(stream, &packet, taken);
                    self.withhold(taken, datagram, arrival);
                }
            }
            Kind::Context => {
                let context = Context::parse(packet.payload)?.filter(|_| roster::has_contexts(stream));
                let Some(context) = context else {
                    self.report.unknown += 1;
                    return Ok(());
                };
                if !self.is_in_span(&packet) {
                    return Ok(());
                }
                if self.is_new(stream, &packet) {
                    self.note(stream, packet.kind, packet.count, packet.time_ps, true);
                }
                // Learned even when it comes again: a forged one may have had the same count and time.
                let fresh = self.whole_pulses() == 0;
                if fresh && !self.roster.agrees(stream, &context) {
                    self.close_run(outlet);
                }
                self.roster.learn_context(stream, context, fresh);
                self.use_ready();
            }
            Kind::ExtensionContext => {
                let body = packet.class.map(|class| Extension::parse(class, packet.payload)).transpose()?;
                match body.flatten().filter(|extension| roster::belongs(stream, extension)) {
                    None => self.report.unknown += 1,
                    Some(Extension::State(state)) => {
                        if self.is_plausible(&packet) && self.is_new(stream, &packet) {
                            let taken = self.state(stream, &packet, &state, arrival, outlet);
                            self.note_taken(stream, &packet, taken);
                            self.withhold(taken, datagram, arrival);
                        }
                    }
                    Some(description) => {
                        // Looked at even when it comes again: another run may begin with the same count and
                        // time.
                        self.another(&description, outlet);
                        // Many pieces of a replica have one time: their counts show no order.
                        let counts = !matches!(description, Extension::Replica(_));
                        if counts && self.is_new(stream, &packet) {
                            self.note(stream, packet.kind, packet.count, packet.time_ps, true);
                        }
                        self.learn(stream, description, outlet);
                        self.use_ready();
                    }
                }
            }
            Kind::ExtensionData | Kind::Command => self.report.unknown += 1,
        }
        Ok(())
    }

    /// Keeps a datagram that lies ahead, or that has shown that the stream is there.
    fn withhold(&mut self, taken: Option<Taken>, datagram: &[u8], arrival: Instant) {
        match taken {
            Some(Taken::Ahead) => self.withheld.push(datagram, arrival),
            Some(Taken::Moved) => {
                self.withheld.push(datagram, arrival);
                self.withheld.believed = true;
            }
            _ => {}
        }
    }

    /// Whether a packet can be of this run, by its time; one that cannot is counted and leaves no trace.
    fn is_plausible(&mut self, packet: &Packet<'_>) -> bool {
        // Pulses of two runs do not belong in one; the next description of this run ends it.
        if self.other.as_ref().is_some_and(|(_, times)| *times >= AGREEING) {
            self.report.undescribed += 1;
            return false;
        }
        self.is_in_span(packet)
    }

    /// Whether the time of a packet is one of this run as it was described; one that is not is counted.
    fn is_in_span(&mut self, packet: &Packet<'_>) -> bool {
        let plausible = match (&self.assembly, packet.time_ps) {
            (Some(assembly), Some(time_ps)) => assembly.is_plausible(time_ps),
            _ => true,
        };
        self.report.implausible += u64::from(!plausible);
        plausible
    }

    /// Whether a packet is new by its count and time; one that is not is counted.
    fn is_new(&mut self, stream: u32, packet: &Packet<'_>) -> bool {
        let known = self.streams.get(&(stream, packet.kind));
        let double = known.is_some_and(|known| known.is_double(packet.count, packet.time_ps));
        self.report.duplicates += u64::from(double);
        !double
    }

    /// Notes what was taken, and what had waited for it. What is refused, strays or waits is no evidence of
    /// what is missing.
    fn note_taken(&mut self, stream: u32, packet: &Packet<'_>, taken: Option<Taken>) {
        if let Some(taken) = taken.filter(|taken| taken.is_of_run()) {
            self.note(stream, packet.kind, packet.count, packet.time_ps, taken == Taken::Yes);
        }
        for found in self.assembly.as_mut().map(Assembly::found).unwrap_or_default() {
            let stream = self.roster.known().and_then(|known| known.streams.get(found.channel).copied());
            if let Some(stream) = stream {
                self.note(stream, Kind::Signal, found.count, Some(found.time_ps), true);
            }
        }
    }

    /// Notes the count of a packet in a stream of the run, if its time is near. One that is in its `place` is
    /// believed more than one that lies far ahead of it: that was forged, and would make all others
    /// overtaken.
    fn note(&mut self, stream: u32, kind: Kind, count: u8, time_ps: Option<i128>, place: bool) {
        let assembly = self.assembly.as_ref();
        if assembly.zip(time_ps).is_some_and(|(assembly, time_ps)| !assembly.is_near(kind, time_ps)) {
            return;
        }
        match self.streams.entry((stream, kind)) {
            Entry::Vacant(place) => drop(place.insert(Stream::begin(count, time_ps))),
            Entry::Occupied(mut known) => {
                let known = known.get_mut();
                if place && assembly.is_some_and(|assembly| known.is_ahead(time_ps, assembly.apart_ps())) {
                    known.begin_again(count, time_ps);
                } else if known.judge(count, time_ps) == Order::Overtaken {
                    self.report.overtaken += 1;
                }
            }
        }
    }

    fn use_ready(&mut self) {
        if let (None, Some(known)) = (&self.assembly, self.roster.known()) {
            self.assembly = Some(Assembly::new(&known.header));
            self.known += 1;
            self.report.platforms = known
                .header
                .platforms
                .iter()
                .map(|name| Platform { name: name.clone(), ..Platform::default() })
                .collect();
        }
    }

    /// Takes samples; what became of them, if their stream is known.
    fn signal(
        &mut self,
        stream: u32,
        packet: &Packet<'_>,
        arrival: Instant,
        outlet: &mut dyn Outlet,
    ) -> Option<Taken> {
        let Self { assembly: Some(assembly), roster, report, arrivals, first, .. } = self else {
            self.report.undescribed += 1;
            return None;
        };
        let channel = roster.known().and_then(|known| known.streams.iter().position(|of| *of == stream));
        let (Some(channel), Some(time_ps)) = (channel, packet.time_ps) else {
            report.unknown += 1;
            return None;
        };
        let mut done = timed(arrivals, first, arrival, outlet);
        let taken = assembly.samples(channel, packet, time_ps, &mut done);
        count(report, taken);
        Some(taken)
    }

    /// Takes a state; what became of it, if the run is known.
    fn state(
        &mut self,
        stream: u32,
        packet: &Packet<'_>,
        state: &State,
        arrival: Instant,
        outlet: &mut dyn Outlet,
    ) -> Option<Taken> {
        let Self { assembly: Some(assembly), roster, report, arrivals, first, .. } = self else {
            self.report.undescribed += 1;
            return None;
        };
        let Some(time_ps) = packet.time_ps else {
            report.unknown += 1;
            return None;
        };
        let mut done = timed(arrivals, first, arrival, outlet);
        let taken = assembly.state(time_ps, state, &mut done);
        count(report, taken);
        if let (Taken::Yes, Some(platform)) = (taken, report.platforms.get_mut(state.platform[0] as usize)) {
            platform.pulse = state.index;
            platform.position_m = state.position_m;
            platform.velocity_mps = state.velocity_mps;
            platform.attitude_quat = state.attitude_quat;
            platform.ecef_position_m = state.ecef_position_m;
            platform.ecef_velocity_mps = state.ecef_velocity_mps;
            platform.ecef_attitude_quat = state.ecef_attitude_quat;
            platform.age_s = state.age_s;
            platform.flags = state.platform_flags;
            platform.ephemeris = roster.context(stream).and_then(|context| context.ephemeris);
        }
        Some(taken)
    }

    /// Gives up what is open, and adds the counts of this run to those before.
    fn close_pulses(&mut self, outlet: &mut dyn Outlet) {
        let Some(assembly) = &mut self.assembly else { return };
        assembly.finish(outlet);
        let pulses = assembly.pulses;
        let report = &mut self.report;
        report.first_pulse = report.first_pulse.or(pulses.first);
        report.last_pulse = pulses.last.or(report.last_pulse);
        for (sum, count) in [
            (&mut report.pulses, pulses.complete),
            (&mut report.incomplete, pulses.incomplete),
            (&mut report.backwards, pulses.backwards),
            (&mut report.stray, pulses.strays),
            (&mut report.missing.pulses_by_index, pulses.missing_by_index),
            (&mut report.missing.pulses_by_time, pulses.missing_by_time),
        ] {
            *sum = sum.saturating_add(count);
        }
    }

    /// The end: gives up what is open, and reports.
    pub fn finish(mut self, outlet: &mut dyn Outlet) -> Report {
        self.forget_streams();
        self.close_pulses(outlet);
        self.report.not_carried = NOT_CARRIED;
        if let Some(known) = self.roster.known() {
            if known.header.instrument.is_none() {
                self.report.not_carried = NOT_DESCRIBED;
            }
            self.report.contexts =
                known.streams.iter().filter_map(|stream| self.roster.context(*stream).copied()).collect();
        }
        self.forget_roster();
        self.report.emission_span_s = self.arrivals.emission_span_s;
        self.report.arrival_span_s = self.arrivals.arrival_span_s;
        self.report.lateness = self.arrivals.lateness();
        self.report
    }
}

/// An outlet that notes when pulses came.
fn timed<'a>(
    arrivals: &'a mut Arrivals,
    first: &'a mut Option<(TimeTag, Instant)>,
    arrival: Instant,
    outlet: &'a mut dyn Outlet,
) -> impl Outlet + 'a {
    move |pulse: Box<Pulse>| {
        let (emission, begun) = *first.get_or_insert_with(|| {
            let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
            let since = arrival.elapsed();
            let clock = TimeTag::new(now.as_secs() as i64, f64::from(now.subsec_nanos()) * 1e-9);
            arrivals.first_offset_s = clock.since(pulse.time) - since.as_secs_f64();
            (pulse.time, arrival)
        });
        arrivals.note(pulse.time.since(emission), arrival.saturating_duration_since(begun).as_secs_f64());
        outlet(pulse)
    }
}

fn count(report: &mut Report, taken: Taken) {
    match taken {
        Taken::Yes | Taken::Waits => {}
        Taken::Double | Taken::WaitsAlready => report.duplicates += 1,
        Taken::Late => report.too_late += 1,
        Taken::Stray => report.stray += 1,
        Taken::Implausible | Taken::Ahead | Taken::Moved => report.implausible += 1,
        Taken::Misnumbered => report.misnumbered += 1,
    }
}
