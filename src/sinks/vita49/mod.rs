//! The wire: VITA 49.2 over UDP.
//!
//! A pulse is sent as, in this order,
//!
//! 1. for each platform the standard ECEF ephemeris of its *reported* state (context packet, where the scene
//!    lies somewhere on Earth) and the same state in f64 with what else is known of the pulse (extension
//!    context);
//! 2. for each channel its samples, split over as many signal packets as the MTU asks for.
//!
//! Before the first pulse, and once every second of emission time, a description of the run, the platforms,
//! the waveform and its replica, the antennas and the channels is sent, and the standard context of every
//! channel. A long replica is sent at once before the first pulse, and spread over the second later. All
//! bytes are in `docs/wire.md`.
//!
//! **Time.** The stamp of a signal packet is that of its first sample,
//!
//! ```text
//! t = emission + window_start + n / fs
//! ```
//!
//! in UTC seconds and picoseconds, n counted from the start of the window (samples), fs the sample rate (Hz).
//! It is rounded once, to the nearest picosecond. Other packets bear the emission time.
//!
//! **Loss** shows in the packet counts (modulo 16, one for each stream and packet type), in the time stamps,
//! in the sample frame of the trailer (first, middle, last packet of a pulse), and in the index of the pulse.
//!
//! Sending waits 20 ms at most for room in the socket's buffer. What the system refuses is counted
//! ([`WireReport`]) and the stream goes on: a receiver that is absent or late costs its own datagrams only.
//!
//! Source: ANSI/VITA 49.2-2017, VITA Radio Transport. Limits: seconds turn over in 2106; the ephemeris holds
//! 2^-5 m, 2^-16 m/s and 2^-22 degrees, which is why the state is sent in f64 too.
//!
//! ```
//! use nereus::pulse::{Layout, Pulse, SampleFormat};
//! use nereus::recording::header::{ChannelRow, Header};
//! use nereus::sinks::{sink::Sink, vita49::{Settings, Vita49Sink}};
//! use nereus::time::TimeTag;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let layout = Layout { channels: 1, samples: 384, format: SampleFormat::Cf32, platforms: 1,
//!     antennas: 0, targets: 0, pairs: 0, windows: 0, ships: 0, clocks: 0 };
//! let channel = ChannelRow { name: "HH".into(), transmitter: "tx".into(), receiver: "rx".into(), polarisations: "HH".into(),
//!     transmit_basis: "ludwig-3".into(), receive_basis: "ludwig-3".into() };
//! let header = Header { software: "example".into(), carrier_hz: 10e9, sample_rate_hz: 100e6, bandwidth_hz: 60e6,
//!     pulse_s: 1e-6, prf_hz: 222.0, channels: vec![channel], pairs: vec![], origin: None, seed: 1, config: String::new(),
//!     replica: vec![], instrument: None, platforms: vec!["aircraft".into()], transmitters: vec![], receivers: vec![], targets: vec![],
//!     ships: vec![], clocks: vec![], layout, adc: None, start: TimeTag::default(), first_pulse: 0, pulses: 1, shard: None,
//!     truth: false, changes: None };
//! let receiver = std::net::UdpSocket::bind("127.0.0.1:0")?;
//! let settings = Settings { address: receiver.local_addr()?.to_string(), ..Settings::default() };
//! let mut sink = Box::new(Vita49Sink::open(&settings, &header)?);
//! sink.write(&Pulse::new(&layout))?;
//! let sent = sink.finish()?.wire.unwrap_or_default();
//! // Run, platform, channel (its description and its context); the platform's state; 384 samples of 8 bytes in three parts.
//! assert_eq!(sent.datagrams, 4 + 1 + 3);
//! # Ok(())
//! # }
//! ```

mod datagram;
pub mod difi;
mod report;
mod packets;
mod radar;
mod stamp;

use crate::pulse::{Pulse, SampleFormat, Samples, flags};
use crate::time::TimeTag;

use super::link::{self, Link, resolve};
use super::sink::{Closed, Sink, SinkError, SinkReport};
use crate::recording::header::Header;
use datagram::{Datagram, PROLOGUE, TRAILER, Type};
use packets::{CHANNEL_STREAM, Globe, Part};
use stamp::{Span, Stamp};

pub use report::WireReport;

/// Emission time between two descriptions, s.
const DESCRIBE_S: f64 = 1.0;

/// Smallest and greatest MTU, bytes: what every IPv4 host takes, and the greatest packet of IP.
pub const MTU_BYTES: [u64; 2] = [576, 65_535];

/// Where to, and in which pieces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Receiver, host and port.
    pub address: String,
    /// Local address and port; any of the machine's when there is none.
    pub bind: Option<String>,
    /// Greatest IP packet, bytes.
    pub mtu_bytes: usize,
    /// Which packets.
    pub profile: Profile,
}

/// Which packets are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Profile {
    /// All of `docs/wire.md`: samples, states, descriptions.
    #[default]
    Nereus,
    /// Those of DIFI (IEEE-ISTO 4900) alone: samples and contexts of each channel.
    Difi,
}

/// A sink of a profile.
///
/// # Errors
/// Those of [`Vita49Sink::open`] and [`difi::DifiSink::open`].
pub fn open(settings: &Settings, header: &Header) -> Result<Box<dyn Sink>, SinkError> {
    Ok(match settings.profile {
        Profile::Nereus => Box::new(Vita49Sink::open(settings, header)?),
        Profile::Difi => Box::new(difi::DifiSink::open(settings, header)?),
    })
}

impl Default for Settings {
    /// The standard's port on this machine, Ethernet's MTU.
    fn default() -> Self {
        Self { address: "127.0.0.1:4991".to_owned(), bind: None, mtu_bytes: 1500, profile: Profile::Nereus }
    }
}

/// Packet counts, modulo 16, of the streams of one kind.
#[derive(Debug)]
struct Counts(Vec<u8>);

impl Counts {
    fn new(streams: usize) -> Self {
        Self(vec![0; streams])
    }

    /// The count of the next packet of a stream.
    fn next(&mut self, stream: usize) -> u8 {
        let Some(count) = self.0.get_mut(stream) else { return 0 };
        let now = *count;
        *count = (now + 1) % 16;
        now
    }
}

/// Sends pulses as VITA 49.2 datagrams.
#[derive(Debug)]
pub struct Vita49Sink {
    link: Link,
    header: Header,
    globe: Option<Globe>,
    datagram: Datagram,
    /// Samples of a full signal packet.
    piece: usize,
    /// Time of the first sample of each piece after the window's start.
    offsets: Vec<Span>,
    /// Emission from which a description is due; none before the first pulse.
    due: Option<TimeTag>,
    signal: Counts,
    context: Counts,
    description: Counts,
    ephemeris: Counts,
    state: Counts,
    names: Counts,
    run: Counts,
    /// Of waveform and filter, and of the replica.
    radar: Counts,
    antennas: Counts,
    emitters: Counts,
    /// Of pulses in turn.
    in_turn: Counts,
    /// Bytes that a datagram has at most.
    room: usize,
    replica: Replica,
    /// Receiver of each channel.
    receivers: Vec<usize>,
    pulses: u64,
    bytes: u64,
}

/// The replica on its way, piece by piece.
#[derive(Debug, Default)]
struct Replica {
    samples: usize,
    /// Samples in a piece.
    piece: usize,
    /// First sample that this round has not sent.
    next: usize,
    /// Samples that a pulse after the first sends.
    per_pulse: usize,
}

impl Replica {
    fn new(header: &Header, room: usize) -> Self {
        let samples = if header.instrument.is_some() { radar::replica_samples(header) } else { 0 };
        let piece = radar::replica_piece(room).max(1);
        // All within a description's second.
        let pieces = (samples.div_ceil(piece) as f64 / (header.prf_hz * DESCRIBE_S).max(1.0)).ceil();
        Self { samples, piece, next: 0, per_pulse: pieces as usize * piece }
    }
}

/// Whether the sink could be opened as far as names go; nothing is sent.
pub(super) fn preflight(settings: &Settings) -> Result<(), SinkError> {
    settings.bind.iter().chain([&settings.address]).try_for_each(|address| resolve(address).map(|_| ()))
}

/// The receiver of each channel.
pub(super) fn receivers(header: &Header) -> Vec<usize> {
    (0..header.layout.channels).map(|channel| header.receiver_of(channel).unwrap_or(0)).collect()
}

impl Vita49Sink {
    /// Binds a socket and allocates everything; nothing is sent yet.
    ///
    /// # Errors
    /// An address that cannot be reached, and sizes that do not fit datagrams.
    pub fn open(settings: &Settings, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        let to = resolve(&settings.address)?;
        let room = link::payload_bytes(settings.mtu_bytes, &to);
        let layout = &header.layout;
        let sample = match layout.format {
            SampleFormat::Cf32 => 8,
            SampleFormat::Ci16 => 4,
        };
        let piece = room.saturating_sub(PROLOGUE + TRAILER) / sample;
        let lowest = MTU_BYTES[0] as usize;
        if settings.mtu_bytes < lowest || settings.mtu_bytes > MTU_BYTES[1] as usize || piece == 0 {
            return Err(SinkError::Mtu { mtu_bytes: settings.mtu_bytes });
        }
        packets::check(header, room)?;
        let first = |start: usize| u32::try_from(start).unwrap_or(u32::MAX);
        let offsets = (0..layout.samples)
            .step_by(piece)
            .map(|start| Span::of_samples(first(start), header.sample_rate_hz))
            .collect();
        Ok(Self {
            link: Link::open(to, settings.bind.as_deref(), None)?,
            header: header.clone(),
            globe: Globe::new(header.origin),
            datagram: Datagram::with_room(room),
            piece,
            offsets,
            due: None,
            signal: Counts::new(layout.channels),
            context: Counts::new(layout.channels),
            description: Counts::new(layout.channels),
            ephemeris: Counts::new(layout.platforms),
            state: Counts::new(layout.platforms),
            names: Counts::new(layout.platforms),
            run: Counts::new(1),
            radar: Counts::new(2),
            antennas: Counts::new(layout.antennas),
            emitters: Counts::new(header.emitters().len()),
            in_turn: Counts::new(header.in_turn().len()),
            room,
            replica: Replica::new(header, room),
            receivers: receivers(header),
            pulses: 0,
            bytes: 0,
        })
    }

    /// What does not change from pulse to pulse, for receivers that come in now.
    fn describe_run(&mut self, at: Stamp, first: bool) {
        let Self { link, header, datagram, bytes, .. } = self;
        let mut send = |packet: &[u8]| {
            *bytes += packet.len() as u64;
            link.send(packet);
        };
        send(packets::run_description(datagram, header, self.run.next(0), at));
        for platform in 0..header.platforms.len() {
            let count = self.names.next(platform);
            send(packets::platform_description(datagram, header, platform, count, at));
        }
        if let Some(instrument) = &header.instrument {
            send(radar::signal(datagram, header, instrument, self.radar.next(0), at));
            let pulses = &instrument.waveform.pulses;
            for (place, row) in pulses.iter().enumerate() {
                let count = self.in_turn.next(place);
                send(radar::pulse(datagram, (place, pulses.len()), row, count, at));
            }
            for antenna in instrument.antennas.iter().enumerate() {
                let count = self.antennas.next(antenna.0);
                send(radar::antenna(datagram, header, antenna, count, at));
            }
            for emitter in instrument.emitters.iter().enumerate() {
                let count = self.emitters.next(emitter.0);
                send(radar::emitter(datagram, header, emitter, self.room, count, at));
            }
        }
        for channel in 0..header.layout.channels {
            let count = self.description.next(channel);
            send(packets::channel_description(datagram, header, channel, count, at));
            let count = self.context.next(channel);
            send(packets::channel_context(datagram, header, channel, count, at, first));
        }
    }

    /// What is due of the replica: all of it before the first pulse.
    fn send_replica(&mut self, at: Stamp, first: bool) {
        let Self { link, header, datagram, bytes, replica, .. } = self;
        let end = if first { replica.samples } else { replica.next.saturating_add(replica.per_pulse) };
        while replica.next < end.min(replica.samples) {
            let count = self.radar.next(1);
            let packet = radar::replica(datagram, header, (replica.next, replica.piece), count, at);
            *bytes += packet.len() as u64;
            link.send(packet);
            replica.next += replica.piece;
        }
    }

    /// Reported position of every platform.
    fn send_states(&mut self, pulse: &Pulse, at: Stamp) {
        let Self { link, globe, datagram, bytes, .. } = self;
        let mut send = |packet: &[u8]| {
            *bytes += packet.len() as u64;
            link.send(packet);
        };
        for (platform, record) in pulse.nav_reported.iter().enumerate() {
            let earth = globe.as_ref().and_then(|globe| globe.state(record));
            if let Some(earth) = &earth {
                let count = self.ephemeris.next(platform);
                send(packets::ephemeris(datagram, platform, earth, count, at));
            }
            let count = self.state.next(platform);
            send(packets::state(datagram, pulse, platform, earth.as_ref(), count, at));
        }
    }

    /// Every channel, piece by piece.
    fn send_samples(&mut self, pulse: &Pulse) {
        let saturated = pulse.flags & flags::ADC_SATURATED != 0;
        let samples = self.header.layout.samples;
        for channel in 0..self.header.layout.channels {
            let stream = CHANNEL_STREAM + channel as u32;
            let after = Span::of_seconds(pulse.window_start_of(self.receivers[channel]));
            for (piece, &offset) in self.offsets.iter().enumerate() {
                let at = Stamp::new(pulse.time, after, offset);
                let start = piece * self.piece;
                let end = (start + self.piece).min(samples);
                let range = channel * samples + start..channel * samples + end;
                let packet = self.datagram.begin(Type::Signal, stream, self.signal.next(channel), at);
                match &pulse.samples {
                    Samples::Cf32(all) => packets::cf32(packet, all.get(range).unwrap_or(&[])),
                    Samples::Ci16(all) => packets::ci16(packet, all.get(range).unwrap_or(&[])),
                }
                let part = Part::of(piece, self.offsets.len());
                let packet = packet.u32(packets::trailer(part, saturated)).end();
                self.bytes += packet.len() as u64;
                self.link.send(packet);
            }
        }
    }
}

impl Sink for Vita49Sink {
    fn name(&self) -> &'static str {
        "vita49"
    }

    fn describe(&self) -> String {
        format!("VITA 49.2 over UDP to {}", self.link.address())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.header.check_pulse(pulse)?;
        let emission = Stamp::new(pulse.time, Span::default(), Span::default());
        let first = self.due.is_none();
        if self.due.is_none_or(|due| pulse.time >= due) {
            self.describe_run(emission, first);
            self.due = Some(pulse.time.plus(DESCRIBE_S));
            // What drops of pulses have left of the last round comes first.
            if self.replica.next >= self.replica.samples {
                self.replica.next = 0;
            }
        }
        self.send_replica(emission, first);
        self.send_states(pulse, emission);
        self.send_samples(pulse);
        self.pulses += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let wire = Some(self.link.finish());
        Ok(Closed::of(SinkReport {
            name: "vita49".to_owned(),
            pulses: self.pulses,
            bytes: self.bytes,
            wire,
            ..SinkReport::default()
        }))
    }
}
