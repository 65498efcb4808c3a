//! A reference receiver of the wire.
//!
//! It is written against ANSI/VITA 49.2-2017 and `docs/wire.md`, and shares no packing code with
//! [`crate::sinks::vita49`]: what both agree on is on the wire. [`Listener`] owns the socket, [`Receiver`] knows only datagrams.
//!
//! A pulse is whole when every sample of every channel has come, and the state of every platform. Pulses are handed on
//! in the order of their emission; one that is not whole when eight later ones are open is given up and counted. All that
//! is read is bounded, a datagram that is no packet is counted, and what came first of two contradicting descriptions holds.
//!
//! Lateness is `arrival - emission` above its least value: it needs no common clock, only two that run alike.
//!
//! Limits: one run at a time; contexts with field attributes (CIF 7) are not read; packet counts of four bits do not see sixteen
//! lost packets in a row, time stamps and pulse numbers do.
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
mod order;
pub mod packet;
pub mod report;
mod roster;

use std::collections::HashMap;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use crate::pulse::Pulse;
use crate::sinks::sink::Header;
use crate::time::TimeTag;

use assembly::{Assembly, Taken};
use context::{Context, Extension, State};
use order::{Order, Stream};
use packet::{Kind, Malformed, Packet};
use report::{Arrivals, Missing, Platform, Report};
use roster::Roster;

pub use listener::{Listener, ReceiveError};

/// Streams whose counts are followed.
const STREAMS: usize = 4096;

/// What the wire does not carry.
pub const NOT_CARRIED: &[&str] = &[
    "nav/*/true",
    "nav/*/{phase_centre_m,reported_phase_centre_m,boresight_quat}",
    "truth",
    "replica",
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
}

impl Receiver {
    /// One that knows nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The header of a recording, once the run is known.
    pub fn header(&self) -> Option<&Header> {
        self.roster.known().map(|known| &known.header)
    }

    /// Whole pulses so far.
    pub fn pulses(&self) -> u64 {
        self.assembly.as_ref().map_or(0, |assembly| assembly.pulses.complete)
    }

    /// Takes a datagram; whole pulses go to `outlet`.
    pub fn take(&mut self, datagram: &[u8], arrival: Instant, outlet: &mut impl Outlet) {
        self.report.datagrams += 1;
        self.report.bytes += datagram.len() as u64;
        if let Err(fault) = self.read(datagram, arrival, outlet) {
            self.report.malformed += 1;
            self.report.first_fault.get_or_insert_with(|| fault.to_string());
        }
    }

    fn read(&mut self, datagram: &[u8], arrival: Instant, outlet: &mut impl Outlet) -> Result<(), Malformed> {
        let packet = Packet::parse(datagram)?;
        let Some(stream) = packet.stream else {
            self.report.unknown += 1;
            return Ok(());
        };
        match packet.kind {
            Kind::Signal => {
                if self.in_order(stream, &packet) {
                    self.signal(stream, &packet, arrival, outlet);
                }
            }
            Kind::Context => {
                let Some(context) = Context::parse(packet.payload)? else {
                    self.report.unknown += 1;
                    return Ok(());
                };
                if self.in_order(stream, &packet) {
                    self.roster.hear(stream, context);
                    self.look_ready();
                }
            }
            Kind::ExtensionContext => {
                let body = packet.class.map(|class| Extension::parse(class, packet.payload)).transpose()?;
                match body.flatten() {
                    None => self.report.unknown += 1,
                    Some(Extension::State(state)) => {
                        if self.in_order(stream, &packet) {
                            self.state(stream, &packet, &state, arrival, outlet);
                        }
                    }
                    Some(description) => {
                        // Looked at even when it comes again: another run may begin with the same count and time.
                        self.in_order(stream, &packet);
                        self.roster.learn(stream, description);
                        self.look_ready();
                    }
                }
            }
            Kind::ExtensionData | Kind::Command => self.report.unknown += 1,
        }
        Ok(())
    }

    /// Judges the packet count; whether the packet is new.
    fn in_order(&mut self, stream: u32, packet: &Packet<'_>) -> bool {
        let key = (stream, packet.kind);
        let Some(known) = self.streams.get_mut(&key) else {
            if self.streams.len() < STREAMS {
                self.streams.insert(key, Stream::begin(packet.count, packet.time_ps));
            }
            return true;
        };
        match known.judge(packet.count, packet.time_ps) {
            Order::Next => true,
            Order::Overtaken => {
                self.report.overtaken += 1;
                true
            }
            Order::Double => {
                self.report.duplicates += 1;
                false
            }
        }
    }

    fn look_ready(&mut self) {
        if let (None, Some(known)) = (&self.assembly, self.roster.known()) {
            self.assembly = Some(Assembly::new(&known.header));
            self.report.platforms = known
                .header
                .platforms
                .iter()
                .map(|name| Platform { name: name.clone(), ..Platform::default() })
                .collect();
        }
    }

    fn signal(&mut self, stream: u32, packet: &Packet<'_>, arrival: Instant, outlet: &mut impl Outlet) {
        let Self { assembly: Some(assembly), roster, report, arrivals, first, .. } = self else {
            self.report.undescribed += 1;
            return;
        };
        let channel = roster.known().and_then(|known| known.streams.iter().position(|of| *of == stream));
        let (Some(channel), Some(time_ps)) = (channel, packet.time_ps) else {
            report.unknown += 1;
            return;
        };
        let mut done = timed(arrivals, first, arrival, outlet);
        let taken = assembly.samples(channel, time_ps, packet.frame(), packet.payload, &mut done);
        count(report, taken);
    }

    fn state(
        &mut self,
        stream: u32,
        packet: &Packet<'_>,
        state: &State,
        arrival: Instant,
        outlet: &mut impl Outlet,
    ) {
        let Self { assembly: Some(assembly), roster, report, arrivals, first, .. } = self else {
            self.report.undescribed += 1;
            return;
        };
        let Some(time_ps) = packet.time_ps else {
            report.unknown += 1;
            return;
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
    }

    /// The end: gives up what is open, and reports.
    pub fn finish(mut self, outlet: &mut impl Outlet) -> Report {
        self.report.missing.packets_by_count = self.streams.values().map(Stream::missing).sum();
        if let Some(assembly) = &mut self.assembly {
            assembly.finish(outlet);
            let pulses = assembly.pulses;
            self.report.pulses = pulses.complete;
            self.report.incomplete = pulses.incomplete;
            self.report.first_pulse = pulses.first;
            self.report.last_pulse = pulses.last;
            self.report.backwards = pulses.backwards;
            self.report.stray += pulses.strays;
            self.report.missing = Missing {
                pulses_by_index: pulses.missing_by_index,
                pulses_by_time: pulses.missing_by_time,
                ..self.report.missing
            };
        }
        if let Some(known) = self.roster.known() {
            self.report.contexts =
                known.streams.iter().filter_map(|stream| self.roster.context(*stream).copied()).collect();
        }
        self.report.contradictions = self.roster.contradictions;
        self.report.emission_span_s = self.arrivals.emission_span_s;
        self.report.arrival_span_s = self.arrivals.arrival_span_s;
        self.report.lateness = self.arrivals.lateness();
        self.report.not_carried = NOT_CARRIED;
        self.report
    }
}

/// An outlet that notes when pulses came.
fn timed<'a>(
    arrivals: &'a mut Arrivals,
    first: &'a mut Option<(TimeTag, Instant)>,
    arrival: Instant,
    outlet: &'a mut impl Outlet,
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
        Taken::Double => report.duplicates += 1,
        Taken::Late => report.too_late += 1,
        Taken::Stray => report.stray += 1,
    }
}
