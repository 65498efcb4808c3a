//! Messages on a port, in step with the pulses: what a platform reports, or what a radar and AIS report of
//! targets.
//!
//! A message is sent at every tick of a rate of its own, counted from the emission of pulse 0: it holds the
//! state at the first pulse at or after the tick, and bears the emission time of that pulse. With
//! `latency_s` it leaves with the first pulse emitted that much later, as from a receiver that thinks for a
//! while. With a rate above the PRF there is one message per pulse.
//!
//! The sink does not wait for its port ([`Port`]). An [`Encoder`] of the modules above turns states into
//! messages.

use std::collections::VecDeque;
use std::time::Duration;

use super::port::{self, Device, Port, PortFault};
use super::sink::{Closed, Sink, SinkError, SinkReport};
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::time::TimeTag;

/// How long the last bytes may take.
const LAST_BYTES: Duration = Duration::from_millis(500);
/// Share of a tick by which a pulse may be early and still be at the tick: rounding of times.
const ROUNDING: f64 = 1e-9;

/// Which messages are sent.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Messages {
    /// NMEA 0183 sentences of these names, in this order.
    Nmea(Vec<&'static str>),
    /// NovAtel INSPVAX, ASCII.
    InspvaxAscii,
    /// NovAtel INSPVAX, binary.
    InspvaxBinary,
}

/// What is asked of a navigation output.
#[derive(Clone, Debug, PartialEq)]
pub struct NavSettings {
    /// The port.
    pub device: Device,
    /// Place of the platform in the navigation record.
    pub platform: usize,
    /// Messages.
    pub messages: Messages,
    /// Messages a second.
    pub rate_hz: f64,
    /// Delay of a message in emission time, s.
    pub latency_s: f64,
    /// Replace a file of messages that exists.
    pub force: bool,
}

/// A sentence about targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetSentence {
    /// Tracked target message: distance, bearing, course, speed, closest approach.
    Ttm,
    /// Target latitude and longitude.
    Tll,
    /// Radar system data: the range scale.
    Rsd,
    /// AIS: what ships report of themselves.
    Vdm,
}

impl TargetSentence {
    /// Its name, and all of them.
    pub const NAMES: [(&'static str, Self); 4] =
        [("TTM", Self::Ttm), ("TLL", Self::Tll), ("RSD", Self::Rsd), ("VDM", Self::Vdm)];

    /// The sentence of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, sentence)| *sentence)
    }
}

/// What is asked of an output of targets.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetSettings {
    /// The port.
    pub device: Device,
    /// Place of own ship in the navigation record.
    pub platform: usize,
    /// Sentences, in this order.
    pub sentences: Vec<TargetSentence>,
    /// Whether own ship's position and heading are the true ones; else as reported.
    pub from_truth: bool,
    /// Messages about each target a second.
    pub rate_hz: f64,
    /// Delay of a message in emission time, s.
    pub latency_s: f64,
    /// Replace a file of messages that exists.
    pub force: bool,
}

/// Turns pulses into messages.
pub trait Encoder: Send {
    /// Appends the messages of a pulse; how many could not be made.
    fn encode(&mut self, pulse: &Pulse, out: &mut Vec<u8>) -> u64;
}

/// Where messages go, and when.
struct Ticks<'a> {
    name: &'static str,
    device: &'a Device,
    rate_hz: f64,
    latency_s: f64,
    force: bool,
    /// Whether every line is a message of its own; else all of a tick are one.
    by_line: bool,
}

/// Sends messages.
pub struct NavSink {
    name: &'static str,
    device: Device,
    rate_hz: f64,
    latency_s: f64,
    by_line: bool,
    port: Port,
    encoder: Box<dyn Encoder>,
    start: TimeTag,
    interval_s: f64,
    /// The last tick that has passed.
    tick: Option<i64>,
    pulses: u64,
    /// Messages that are not yet due: when they are, and their length.
    due: VecDeque<(TimeTag, usize)>,
    waiting: VecDeque<u8>,
    message: Vec<u8>,
}

impl NavSink {
    /// Opens the port.
    ///
    /// # Errors
    /// A port that cannot be opened, and a file that may not be replaced.
    pub fn open(
        settings: &NavSettings,
        encoder: Box<dyn Encoder>,
        header: &Header,
    ) -> Result<Self, SinkError> {
        let NavSettings { device, rate_hz, latency_s, force, .. } = settings;
        let (rate_hz, latency_s, force) = (*rate_hz, *latency_s, *force);
        Self::of(Ticks { name: "nav", device, rate_hz, latency_s, force, by_line: false }, encoder, header)
    }

    /// The same for messages about targets.
    ///
    /// # Errors
    /// A port that cannot be opened, and a file that may not be replaced.
    pub fn of_targets(
        settings: &TargetSettings,
        encoder: Box<dyn Encoder>,
        header: &Header,
    ) -> Result<Self, SinkError> {
        let TargetSettings { device, rate_hz, latency_s, force, .. } = settings;
        let (rate_hz, latency_s, force) = (*rate_hz, *latency_s, *force);
        Self::of(Ticks { name: "targets", device, rate_hz, latency_s, force, by_line: true }, encoder, header)
    }

    fn of(ticks: Ticks<'_>, encoder: Box<dyn Encoder>, header: &Header) -> Result<Self, SinkError> {
        let Ticks { name, device, rate_hz, latency_s, force, by_line } = ticks;
        let port = Port::open(device.clone(), force).map_err(|fault| match fault {
            PortFault::System(source) => SinkError::Port { device: device.to_string(), source },
            PortFault::File(fault) => fault.into(),
        })?;
        Ok(Self {
            name,
            device: device.clone(),
            rate_hz,
            latency_s,
            by_line,
            port,
            encoder,
            start: header.start,
            interval_s: header.prf_hz.recip(),
            tick: None,
            pulses: 0,
            due: VecDeque::new(),
            waiting: VecDeque::new(),
            message: Vec::new(),
        })
    }

    /// A file that cannot be written ends the sink.
    fn fault(&mut self) -> Result<(), SinkError> {
        let path = self.device.file().unwrap_or("".as_ref());
        self.port.fault().map_or(Ok(()), |source| Err(SinkError::io(path, "writing")(source)))
    }

    fn tick_at(&self, time_s: f64) -> i64 {
        (time_s * self.rate_hz + ROUNDING).floor() as i64
    }

    /// Sends what is due at a time, or all of it.
    fn release(&mut self, now: Option<TimeTag>) {
        while let Some((due, length)) = self.due.front().copied() {
            if now.is_some_and(|now| now.since(due) < 0.0) {
                return;
            }
            self.due.pop_front();
            self.message.clear();
            self.message.extend(self.waiting.drain(..length));
            self.port.send(&self.message);
        }
    }
}

impl Sink for NavSink {
    fn name(&self) -> &'static str {
        self.name
    }

    fn describe(&self) -> String {
        format!("{} to {}", if self.by_line { "targets" } else { "navigation" }, self.device)
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.pulses += 1;
        let since_s = pulse.time.since(self.start);
        let tick = self.tick_at(since_s);
        // Part of a run begins where the whole would be.
        let before = self.tick.unwrap_or_else(|| self.tick_at(since_s - self.interval_s));
        self.tick = Some(tick);
        if tick > before {
            self.message.clear();
            let lost = self.encoder.encode(pulse, &mut self.message);
            (0..lost).for_each(|_| self.port.count_lost());
            let due = pulse.time.plus(self.latency_s);
            self.waiting.extend(&self.message);
            match self.by_line {
                true => {
                    let lines = self.message.split_inclusive(|byte| *byte == b'\n');
                    self.due.extend(lines.map(|line| (due, line.len())));
                }
                false if self.message.is_empty() => {}
                false => self.due.push_back((due, self.message.len())),
            }
        }
        self.release(Some(pulse.time));
        self.fault()
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.port.flush();
        self.fault()
    }

    fn abandon(&mut self) {
        self.port.abandon();
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        self.release(None);
        let files = self.device.file().map(|path| path.to_owned()).into_iter().collect();
        let (port, draft) = self.port.close(LAST_BYTES);
        self.fault()?;
        let force = draft.as_ref().is_some_and(|(_, force)| *force);
        let report = SinkReport {
            name: self.name.to_owned(),
            pulses: self.pulses,
            bytes: port.bytes,
            files,
            port: Some(port),
            ..SinkReport::default()
        };
        let drafts = draft.map(|(draft, _)| draft).into_iter().collect();
        Ok(Closed { report, drafts, force, recognise: Some(port::recognise), ..Closed::default() })
    }
}
