//! A subscriber of pulses in shared memory ([`crate::sinks::shm`]).
//!
//! ```no_run
//! use std::time::Duration;
//! use nereus::receive::shm::{Next, Subscriber};
//! # fn main() -> Result<(), nereus::receive::shm::ShmError> {
//! let mut subscriber = Subscriber::open("nereus", Duration::from_secs(60))?;
//! while let Next::Pulse(pulse) = subscriber.next(Duration::from_secs(5))? {
//!     // Where the emulator has put them: nothing is copied.
//!     let echo = pulse.channel(0);
//!     println!("pulse {}: {} samples, {} missed so far", pulse.header().index, echo.len(), subscriber.missed());
//! }
//! # Ok(())
//! # }
//! ```

use std::thread;
use std::time::{Duration, Instant};

use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber as Port;
use iceoryx2::sample::Sample;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use num_complex::Complex32;
use serde_json::Value;
use thiserror::Error;

use crate::pulse::{PlatformRecord, SampleFormat};
use crate::recording::header::{FORMAT_VERSION, LAST_VERSION};
use crate::sinks::shm::layout::{PulseHeader, STATE_WORDS, state_of};
use crate::sinks::shm::publisher::{Ipc, name, node};

/// How long to sleep while there is no pulse.
const NAP: Duration = Duration::from_micros(200);

/// Why pulses cannot be had.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ShmError {
    /// Nobody publishes.
    #[error(
        "shared memory service '{service}': nobody publishes there; start a run with a sink of kind \"shm\""
    )]
    Nobody {
        /// Name of the service.
        service: String,
    },
    /// The service refuses.
    #[error(
        "shared memory service '{service}': {error}; allowed: as many subscribers as the sink has (key subscribers)"
    )]
    Refused {
        /// Name of the service.
        service: String,
        /// What iceoryx2 reported.
        error: String,
    },
    /// Something else than pulses that this version knows.
    #[error(
        "shared memory service '{service}': no pulses of version {FORMAT_VERSION} to {LAST_VERSION}; use the same version of nereus on both sides"
    )]
    Foreign {
        /// Name of the service.
        service: String,
    },
}

/// What there is.
#[derive(Debug)]
pub enum Next {
    /// A pulse.
    Pulse(SharedPulse),
    /// No pulse came in the time allowed.
    Quiet,
    /// The run has ended.
    Ended,
    /// The run has gone without ending: it was killed.
    Gone,
}

/// A pulse where it lies. It takes one of the places that a subscriber may hold until it is dropped.
#[derive(Debug)]
pub struct SharedPulse {
    sample: Sample<Ipc, [u64], PulseHeader>,
    format: SampleFormat,
}

impl SharedPulse {
    /// Number, time, sizes.
    pub fn header(&self) -> &PulseHeader {
        self.sample.user_header()
    }

    /// What a platform reports, by its place in the description of the run.
    pub fn reported(&self, platform: usize) -> Option<PlatformRecord> {
        let at = platform.checked_mul(STATE_WORDS)?;
        let states = self.sample.payload().get(..self.header().platforms as usize * STATE_WORDS)?;
        states.get(at..at + STATE_WORDS)?.try_into().ok().map(state_of)
    }

    /// Start of the window of a receiver after the emission, s, by its place in the description of the run.
    pub fn window_start_of(&self, receiver: usize) -> f64 {
        let (header, words) = (self.header(), self.sample.payload());
        let own = words
            .len()
            .checked_sub(usize::from(header.windows))
            .filter(|_| receiver < usize::from(header.windows));
        let own = own.and_then(|at| words.get(at + receiver));
        own.map_or(header.window_start_s, |word| f64::from_bits(*word))
    }

    /// How samples are held.
    pub fn format(&self) -> SampleFormat {
        self.format
    }

    /// Samples of a channel, sqrt(W); none where they are codes.
    pub fn channel(&self, channel: usize) -> &[Complex32] {
        if self.format == SampleFormat::Cf32 { self.samples(channel) } else { &[] }
    }

    /// ADC codes of a channel, in-phase and quadrature; none where samples are not codes.
    pub fn codes(&self, channel: usize) -> &[[i16; 2]] {
        if self.format == SampleFormat::Ci16 { self.samples(channel) } else { &[] }
    }

    fn samples<T: bytemuck::Pod>(&self, channel: usize) -> &[T] {
        let header = self.header();
        let samples = header.samples as usize;
        let states = header.platforms as usize * STATE_WORDS;
        let bytes: &[u8] = bytemuck::cast_slice(self.sample.payload().get(states..).unwrap_or_default());
        let whole = bytes.len() / size_of::<T>() * size_of::<T>();
        let all: &[T] = bytemuck::cast_slice(bytes.get(..whole).unwrap_or_default());
        let range = channel.checked_mul(samples).and_then(|at| all.get(at..at.checked_add(samples)?));
        range.filter(|_| channel < header.channels as usize).unwrap_or_default()
    }
}

/// Reads the pulses of a run on this machine.
#[derive(Debug)]
pub struct Subscriber {
    // Ports before services before the node.
    pulses: Port<Ipc, [u64], PulseHeader>,
    runs: Port<Ipc, [u8], ()>,
    service: PortFactory<Ipc, [u64], PulseHeader>,
    _run_service: PortFactory<Ipc, [u8], ()>,
    node: Node<Ipc>,
    name: String,
    run: Option<Value>,
    /// Number of the run and of the pulse that comes next.
    expected: Option<(u64, u64)>,
    received: u64,
    missed: u64,
}

impl Subscriber {
    /// Subscribes, as soon as somebody publishes.
    ///
    /// # Errors
    /// Nobody who publishes within `timeout`, and no place for another subscriber.
    pub fn open(service: &str, timeout: Duration) -> Result<Self, ShmError> {
        let refused = |error: &dyn std::fmt::Debug| ShmError::Refused {
            service: service.to_owned(),
            error: format!("{error:?}"),
        };
        let until = Instant::now() + timeout;
        let node = node(service).map_err(|error| refused(&error))?;
        let names = [name(service, "pulses"), name(service, "run")];
        let [Ok(of_pulses), Ok(of_run)] = names else { return Err(refused(&"no name of a service")) };
        loop {
            let pulses = node
                .service_builder(&of_pulses)
                .publish_subscribe::<[u64]>()
                .user_header::<PulseHeader>()
                .open();
            let run = node.service_builder(&of_run).publish_subscribe::<[u8]>().open();
            if let (Ok(service_of_pulses), Ok(run_service)) = (pulses, run)
                && service_of_pulses.dynamic_config().number_of_publishers() > 0
            {
                let history = service_of_pulses.static_config().history_size();
                let pulses = service_of_pulses
                    .subscriber_builder()
                    .history_request(history)
                    .create()
                    .map_err(|error| refused(&error))?;
                let runs = run_service
                    .subscriber_builder()
                    .history_request(1)
                    .create()
                    .map_err(|error| refused(&error))?;
                return Ok(Self {
                    pulses,
                    runs,
                    service: service_of_pulses,
                    _run_service: run_service,
                    node,
                    name: service.to_owned(),
                    run: None,
                    expected: None,
                    received: 0,
                    missed: 0,
                });
            }
            if Instant::now() >= until {
                return Err(ShmError::Nobody { service: service.to_owned() });
            }
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// The next pulse, waiting at most so long.
    ///
    /// # Errors
    /// A connection that breaks, and content of another version.
    pub fn next(&mut self, timeout: Duration) -> Result<Next, ShmError> {
        let until = Instant::now() + timeout;
        loop {
            let received = self.pulses.receive().map_err(|error| ShmError::Refused {
                service: self.name.clone(),
                error: format!("{error:?}"),
            })?;
            if let Some(sample) = received {
                return self.take(sample);
            }
            if Instant::now() >= until {
                // A run that was killed counts until its remains are removed.
                self.node.try_cleanup_dead_nodes();
                let gone = self.service.dynamic_config().number_of_publishers() == 0;
                return Ok(if gone && !self.has_more() { Next::Gone } else { Next::Quiet });
            }
            thread::sleep(NAP);
        }
    }

    fn has_more(&self) -> bool {
        self.pulses.has_samples().unwrap_or(false)
    }

    fn take(&mut self, sample: Sample<Ipc, [u64], PulseHeader>) -> Result<Next, ShmError> {
        let header = *sample.user_header();
        let foreign = || ShmError::Foreign { service: self.name.clone() };
        let format = header.format().filter(|_| (FORMAT_VERSION..=LAST_VERSION).contains(&header.version));
        let format = format.ok_or_else(foreign)?;
        if header.words() != Some(sample.payload().len()) {
            return Err(foreign());
        }
        // Before the first pulse nothing counts as missed, and what another run has published neither.
        let expected = self.expected.filter(|(source, _)| *source == header.source);
        let gap = expected.map_or(0, |(_, next)| header.sequence.saturating_sub(next));
        self.missed += gap;
        if header.end != 0 {
            self.expected = None;
            return Ok(Next::Ended);
        }
        self.expected = Some((header.source, header.sequence + 1));
        self.received += 1;
        Ok(Next::Pulse(SharedPulse { sample, format }))
    }

    /// What holds for the whole run: channels, rates, platforms (`docs/formats.md`). It is there before the
    /// first pulse.
    pub fn run(&mut self) -> Option<&Value> {
        while let Ok(Some(sample)) = self.runs.receive() {
            self.run = serde_json::from_slice(sample.payload()).ok().or(self.run.take());
        }
        self.run.as_ref()
    }

    /// Pulses received.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Pulses that were published after the first one received and did not come: this subscriber was too
    /// slow.
    pub fn missed(&self) -> u64 {
        self.missed
    }
}
