//! ZeroMQ: a PUB socket that others subscribe to.
//!
//! Two forms. **Samples**: a port for each channel, a message for each pulse that holds nothing but the
//! channel's samples as complex64, little-endian, in sqrt(W): what the ZMQ SUB source of GNU Radio reads.
//! **Multipart**: one port; the frames of a message are a topic, a JSON header and the samples of each
//! channel as they are made (complex64, or ADC codes as pairs of int16).
//!
//! | topic | second frame | further frames | when |
//! | --- | --- | --- | --- |
//! | `run` | what holds for all pulses | | at the first pulse, then once a second of emission time |
//! | `pulse` | number, time, flags, reported states | samples, a frame for each channel | every pulse |
//! | `end` | how many were published | | when the run has ended |
//!
//! All keys are in `docs/formats.md`.
//!
//! **Loss.** A subscriber has a queue of `buffer_pulses`. What does not find room in it is lost to that
//! subscriber, and to nobody else; the header's `sequence` counts what was published, from 0, so that a
//! subscriber sees it. The sink itself counts what it could not deliver.
//!
//! ```
//! use nereus::pulse::{Layout, Pulse};
//! use nereus::recording::header::{ChannelRow, Header};
//! use nereus::sinks::{sink::Sink, zmq::{Messages, Settings, ZmqSink}};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let layout = Layout { channels: 1, samples: 384, ..Layout::default() };
//! let channel = ChannelRow { name: "HH".into(), ..ChannelRow::default() };
//! let header = Header { carrier_hz: 10e9, sample_rate_hz: 100e6, prf_hz: 222.0, channels: vec![channel], layout,
//!     ..Header::default() };
//! let settings = Settings { bind: "127.0.0.1:0".into(), ports: 1, messages: Messages::Multipart, buffer_pulses: 64 };
//! let mut sink = Box::new(ZmqSink::open(&settings, &header)?);
//! sink.write(&Pulse::new(&layout))?;
//! // Nobody has subscribed.
//! let report = sink.finish()?;
//! assert_eq!((report.pulses, report.subscribers.map(|all| (all.seen, all.lost))), (1, Some((0, 0))));
//! # Ok(())
//! # }
//! ```

mod publisher;
mod wire;

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use num_complex::Complex32;

use super::description;
use super::link::resolve;
use super::sink::{Closed, Sink, SinkError, SinkReport, SubscriberCounts};
use crate::pulse::{Pulse, Samples};
use crate::recording::header::Header;
use crate::time::TimeTag;
use publisher::{Message, Publisher};

/// Emission time between two descriptions of the run, s.
const DESCRIBE_S: f64 = 1.0;
/// How long subscribers may take for the last messages.
const LAST_MESSAGES: Duration = Duration::from_secs(1);

/// What messages hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Messages {
    /// The samples of a channel, a port for each.
    Samples,
    /// Topic, header and all channels.
    Multipart,
}

/// Where, and in which form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Local address and first port.
    pub bind: String,
    /// Ports from there on: one per channel, or one for all.
    pub ports: u16,
    /// What messages hold.
    pub messages: Messages,
    /// Pulses that may wait for a subscriber.
    pub buffer_pulses: usize,
}

impl Settings {
    /// Every address that is listened at.
    fn addresses(&self) -> Result<Vec<SocketAddr>, SinkError> {
        let first = resolve(&self.bind)?;
        (0..self.ports)
            .map(|place| {
                // Port 0 is any that is free, for each.
                let port = if first.port() == 0 { Some(0) } else { first.port().checked_add(place) };
                let port = port.ok_or(SinkError::Ports { bind: self.bind.clone(), ports: self.ports })?;
                Ok(SocketAddr::new(first.ip(), port))
            })
            .collect()
    }
}

fn refused(address: SocketAddr) -> impl FnOnce(std::io::Error) -> SinkError {
    move |source| SinkError::Bind { address: address.to_string(), source }
}

/// Whether every port is free, and the addresses that are taken then.
pub(super) fn preflight(settings: &Settings) -> Result<Vec<SocketAddr>, SinkError> {
    let addresses = settings.addresses()?;
    for address in &addresses {
        TcpListener::bind(address).map_err(refused(*address))?;
    }
    Ok(addresses)
}

/// Publishes pulses.
#[derive(Debug)]
pub struct ZmqSink {
    header: Header,
    messages: Messages,
    source: u64,
    /// Description of the run.
    run: String,
    sockets: Vec<Publisher>,
    /// Messages that were published: those that nobody holds any more are used again.
    spare: VecDeque<Arc<Message>>,
    /// Most messages that can be on their way.
    most: usize,
    /// The text of a header; samples as complex64.
    text: Vec<u8>,
    samples: Vec<Complex32>,
    /// Emission from which the run is described again.
    due: Option<TimeTag>,
    pulses: u64,
    bytes: u64,
}

impl ZmqSink {
    /// Listens; nothing is sent yet.
    ///
    /// # Errors
    /// An address or a port that cannot be had.
    pub fn open(settings: &Settings, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        let sockets: Vec<Publisher> = settings
            .addresses()?
            .into_iter()
            .map(|address| Publisher::bind(address, settings.buffer_pulses).map_err(refused(address)))
            .collect::<Result<_, _>>()?;
        // What waits for the slowest of them, and the pulse that is being made.
        let most = (settings.buffer_pulses + 2) * sockets.len();
        let source = description::source();
        Ok(Self {
            header: header.clone(),
            messages: settings.messages,
            source,
            run: description::of_run(header, source).to_string(),
            sockets,
            spare: VecDeque::with_capacity(most),
            most,
            text: Vec::new(),
            samples: Vec::new(),
            due: None,
            pulses: 0,
            bytes: 0,
        })
    }

    /// Where each socket listens.
    pub fn addresses(&self) -> Vec<SocketAddr> {
        self.sockets.iter().map(Publisher::address).collect()
    }

    /// A message, in memory that nobody reads any more where there is some.
    fn message(&mut self, fill: impl FnOnce(&mut Self, &mut Message)) -> Arc<Message> {
        let reusable = self.spare.front_mut().is_some_and(|oldest| Arc::get_mut(oldest).is_some());
        let oldest = if reusable { self.spare.pop_front() } else { None };
        let mut message = oldest.unwrap_or_default();
        if let Some(message) = Arc::get_mut(&mut message) {
            message.clear();
            fill(self, message);
            self.bytes += message.len() as u64;
        }
        if self.spare.len() < self.most {
            self.spare.push_back(Arc::clone(&message));
        }
        message
    }

    /// Publishes topic and text on the first socket.
    fn send_text(&mut self, topic: &str, text: &str) {
        let message = self.message(|_, message| {
            message.frame(topic.as_bytes(), true);
            message.frame(text.as_bytes(), false);
        });
        if let Some(socket) = self.sockets.first() {
            socket.publish(&message);
        }
    }

    fn send_multipart(&mut self, pulse: &Pulse) {
        if self.due.is_none_or(|due| pulse.time >= due) {
            self.due = Some(pulse.time.plus(DESCRIBE_S));
            let text = std::mem::take(&mut self.run);
            self.send_text("run", &text);
            self.run = text;
        }
        let message = self.message(|sink, message| {
            sink.text.clear();
            description::write_pulse(&mut sink.text, &sink.header, sink.source, pulse, sink.pulses);
            message.frame(b"pulse", true);
            message.frame(&sink.text, true);
            let bytes = pulse.samples.as_bytes();
            let channels = sink.header.layout.channels;
            for (place, channel) in bytes.chunks(bytes.len() / channels).enumerate() {
                message.frame(channel, place + 1 < channels);
            }
        });
        if let Some(socket) = self.sockets.first() {
            socket.publish(&message);
        }
    }

    fn send_samples(&mut self, pulse: &Pulse) {
        let samples = self.header.layout.samples;
        for channel in 0..self.sockets.len() {
            let range = channel * samples..(channel + 1) * samples;
            let message = self.message(|sink, message| match &pulse.samples {
                Samples::Cf32(all) => {
                    message.frame(bytemuck::cast_slice(all.get(range).unwrap_or_default()), false);
                }
                Samples::Ci16(codes) => {
                    let step = sink.header.adc.map_or(1.0, |adc| adc.step as f32);
                    let volts = |code: i16| (f32::from(code) + 0.5) * step;
                    let codes = codes.get(range).unwrap_or_default();
                    sink.samples.clear();
                    sink.samples.extend(codes.iter().map(|[i, q]| Complex32::new(volts(*i), volts(*q))));
                    message.frame(bytemuck::cast_slice(&sink.samples), false);
                }
            });
            if let Some(socket) = self.sockets.get(channel) {
                socket.publish(&message);
            }
        }
    }
}

impl Sink for ZmqSink {
    fn name(&self) -> &'static str {
        "zmq"
    }

    fn describe(&self) -> String {
        let addresses: Vec<String> =
            self.addresses().iter().map(|address| format!("tcp://{address}")).collect();
        format!("ZeroMQ at {}", addresses.join(", "))
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.header.check_pulse(pulse)?;
        match self.messages {
            Messages::Samples => self.send_samples(pulse),
            Messages::Multipart => self.send_multipart(pulse),
        }
        self.pulses += 1;
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        if self.messages == Messages::Multipart {
            let text = serde_json::json!({ "source": self.source, "sequence": self.pulses });
            self.send_text("end", &text.to_string());
        }
        let mut all = SubscriberCounts { at: self.describe(), ..SubscriberCounts::default() };
        for socket in &mut self.sockets {
            let counts = socket.close(LAST_MESSAGES);
            all.seen += counts.seen;
            all.messages += counts.sent;
            all.lost += counts.lost;
        }
        Ok(Closed::of(SinkReport {
            name: "zmq".to_owned(),
            pulses: self.pulses,
            bytes: self.bytes,
            subscribers: Some(all),
            ..SinkReport::default()
        }))
    }
}
