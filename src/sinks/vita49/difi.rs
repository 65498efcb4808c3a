//! The same samples as DIFI packets (IEEE-ISTO 4900-2021, version 1.1 of the standard): for receivers that
//! take nothing else.
//!
//! A channel is a DIFI stream: signal data, the standard context and the version context once per second, all
//! under one stream identifier. Nothing else is sent: neither states nor descriptions, which have no place in
//! that standard. A second sink of the ordinary profile sends them to another address.
//!
//! DIFI streams hold whole numbers: an ADC is needed. Its packets of signal data are of one size, so a window
//! is cut into equal ones.
//!
//! ```
//! use nereus::sinks::vita49::difi::equal_pieces;
//! // 400 samples, at most 360 a packet: two of 200. A window that cannot be cut evenly is refused.
//! assert_eq!(equal_pieces(400, 360), Some(200));
//! assert_eq!(equal_pieces(401, 360), None);
//! ```

use super::datagram::{Datagram, Difi, Type};
use super::packets::{CHANNEL_STREAM, ci16};
use super::stamp::{Span, Stamp};
use super::{Counts, DESCRIBE_S, MTU_BYTES, Settings, receivers};
use crate::pulse::{Pulse, Samples};
use crate::recording::header::{AdcRow, Header};
use crate::sinks::link::{self, Link};
use crate::sinks::sink::{Closed, Sink, SinkError, SinkReport};
use crate::time::TimeTag;

/// Bytes before the samples: header, stream, class, time stamp.
const PROLOGUE: usize = 28;
/// Greatest and least packet of signal data, bytes, and bytes of a sample.
const LARGEST: u64 = 9000;
const SMALLEST: usize = 128;
const SAMPLE: usize = 4;

/// Year after 2000 and day of the year of this sender's packets, and the revision of the standard.
const VERSION: [u32; 3] = [26, 327, 1];

/// Sends pulses as DIFI packets.
#[derive(Debug)]
pub struct DifiSink {
    link: Link,
    header: Header,
    adc: AdcRow,
    datagram: Datagram,
    /// Samples of a packet.
    piece: usize,
    /// Time of the first sample of each packet after the window's start.
    offsets: Vec<Span>,
    /// Emission from which contexts are due; none before the first pulse.
    due: Option<TimeTag>,
    signal: Counts,
    context: Counts,
    version: Counts,
    /// Receiver of each channel.
    receivers: Vec<usize>,
    pulses: u64,
    bytes: u64,
}

/// Samples of equal packets, at most `most` each; none where they would be shorter than DIFI allows.
pub fn equal_pieces(samples: usize, most: usize) -> Option<usize> {
    let least = (SMALLEST - PROLOGUE) / SAMPLE;
    (least..=most.min(samples)).rev().find(|piece| samples.is_multiple_of(*piece))
}

impl DifiSink {
    /// Binds a socket and allocates everything; nothing is sent yet.
    ///
    /// # Errors
    /// Samples that are no whole numbers, windows that cannot be cut evenly, an address that cannot be
    /// reached.
    pub fn open(settings: &Settings, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        let Some(adc) = header.adc else {
            let found = "samples are floating point".to_owned();
            return Err(SinkError::Difi { found, allowed: "codes of an ADC: add [radar.adc]".to_owned() });
        };
        let to = link::resolve(&settings.address)?;
        if !(MTU_BYTES[0]..=LARGEST).contains(&(settings.mtu_bytes as u64)) {
            let allowed = format!("{} to {LARGEST} bytes", MTU_BYTES[0]);
            return Err(SinkError::Difi { found: format!("mtu_bytes = {}", settings.mtu_bytes), allowed });
        }
        let room = link::payload_bytes(settings.mtu_bytes, &to);
        let samples = header.layout.samples;
        let most = room.saturating_sub(PROLOGUE) / SAMPLE;
        let piece = equal_pieces(samples, most).ok_or_else(|| {
            let near = (1..).flat_map(|off| [samples.checked_sub(off), samples.checked_add(off)]).flatten();
            let near = near.take(2 * samples).find(|near| equal_pieces(*near, most).is_some());
            let found =
                format!("samples = {samples} cannot be sent in equal packets of 25 to {most} samples");
            let allowed = near.map_or("more samples".to_owned(), |near| format!("such as samples = {near}"));
            SinkError::Difi { found, allowed }
        })?;
        if !(1.0..=1e12).contains(&header.sample_rate_hz) {
            let found = format!("sample_rate_hz = {}", header.sample_rate_hz);
            return Err(SinkError::Difi { found, allowed: "1 to 1e12 Hz".to_owned() });
        }
        let first = |start: usize| u32::try_from(start).unwrap_or(u32::MAX);
        let offsets = (0..samples).step_by(piece);
        let channels = header.layout.channels;
        Ok(Self {
            link: Link::open(to, settings.bind.as_deref(), None)?,
            header: header.clone(),
            adc,
            datagram: Datagram::with_room(room),
            piece,
            offsets: offsets.map(|start| Span::of_samples(first(start), header.sample_rate_hz)).collect(),
            due: None,
            signal: Counts::new(channels),
            context: Counts::new(channels),
            version: Counts::new(channels),
            receivers: receivers(header),
            pulses: 0,
            bytes: 0,
        })
    }

    /// Contexts of every stream.
    fn describe(&mut self, at: Stamp, first: bool) {
        let Self { link, header, adc, datagram, context, version, bytes, .. } = self;
        let mut send = |packet: &[u8]| {
            *bytes += packet.len() as u64;
            link.send(packet);
        };
        for channel in 0..header.layout.channels {
            let stream = CHANNEL_STREAM + channel as u32;
            send(version_context(datagram, (stream, version.next(channel)), at, first));
            send(standard_context(datagram, header, adc, (stream, context.next(channel)), at, first));
        }
    }

    /// Every channel, packet by packet.
    fn send_samples(&mut self, pulse: &Pulse) {
        let Samples::Ci16(all) = &pulse.samples else { return };
        for (channel, window) in all.chunks_exact(self.header.layout.samples).enumerate() {
            let stream = CHANNEL_STREAM + channel as u32;
            let after = Span::of_seconds(pulse.window_start_of(self.receivers[channel]));
            for (samples, &offset) in window.chunks_exact(self.piece).zip(&self.offsets) {
                let at = Stamp::new(pulse.time, after, offset);
                let count = self.signal.next(channel);
                let packet = self.datagram.begin(Type::Difi(Difi::Data), stream, count, at);
                ci16(packet, samples);
                let packet = packet.end();
                self.bytes += packet.len() as u64;
                self.link.send(packet);
            }
        }
    }
}

/// The standard flow signal context: 27 words.
fn standard_context<'a>(
    datagram: &'a mut Datagram,
    header: &Header,
    adc: &AdcRow,
    (stream, count): (u32, u8),
    at: Stamp,
    changed: bool,
) -> &'a [u8] {
    const FIELDS: u32 = 0x7bb9_8000;
    const REFERENCE_POINT: u32 = 100;
    // dBm of a complex sinusoid of 2^15 codes, 7 bits below the point.
    let level = (20.0 * (32_768.0 * adc.step).log10() + 30.0) * 128.0;
    datagram
        .begin(Type::Difi(Difi::Context), stream, count, at)
        .u32(FIELDS | u32::from(changed) << 31)
        .u32(REFERENCE_POINT)
        .hertz(header.bandwidth_hz)
        .hertz(0.0)
        .hertz(header.carrier_hz)
        .hertz(0.0)
        .u32(u32::from(level.round_ties_even() as i16 as u16))
        // Gains of both stages: they are in the level.
        .u32(0)
        .hertz(header.sample_rate_hz)
        // Adjustment of the stamps, and when they were calibrated.
        .u64(0)
        .u32(at.seconds)
        // Calibrated time, valid data, reference lock: enabled, and so.
        .u32(0b111 << 29 | 0b111 << 17)
        // Link-efficient, complex Cartesian, signed fixed point, fields and items of 16 bits.
        .u32(1 << 31 | 1 << 29 | 15 << 6 | 15)
        .u32(0)
        .end()
}

/// The version flow signal context: 11 words.
fn version_context(datagram: &mut Datagram, (stream, count): (u32, u8), at: Stamp, changed: bool) -> &[u8] {
    let [year, day, revision] = VERSION;
    datagram
        .begin(Type::Difi(Difi::Version), stream, count, at)
        .u32(1 << 1 | u32::from(changed) << 31)
        .u32(0x0c)
        // V49.2.
        .u32(4)
        .u32(year << 25 | day << 16 | revision << 10)
        .end()
}

impl Sink for DifiSink {
    fn name(&self) -> &'static str {
        "vita49"
    }

    fn describe(&self) -> String {
        format!("DIFI over UDP to {}", self.link.address())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.header.check_pulse(pulse)?;
        let first = self.due.is_none();
        if self.due.is_none_or(|due| pulse.time >= due) {
            let emission = Stamp::new(pulse.time, Span::default(), Span::default());
            Self::describe(self, emission, first);
            self.due = Some(pulse.time.plus(DESCRIBE_S));
        }
        self.send_samples(pulse);
        self.pulses += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let wire = Some(self.link.finish());
        let name = "vita49".to_owned();
        Ok(Closed::of(SinkReport {
            name,
            pulses: self.pulses,
            bytes: self.bytes,
            wire,
            ..SinkReport::default()
        }))
    }
}
