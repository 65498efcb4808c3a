//! The publisher.

use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{
    LogLevel, ServiceName, SignalHandlingMode, ipc_threadsafe, set_log_level_from_env_or,
};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::layout::{self, PulseHeader, STATE_WORDS};
use super::{BORROWED, Settings, memory};
use crate::pulse::Pulse;
use crate::recording::header::Header;
use crate::sinks::description;
use crate::sinks::sink::{Closed, Sink, SinkError, SinkReport, SubscriberCounts};

/// iceoryx2 between processes, from any thread.
pub(crate) type Ipc = ipc_threadsafe::Service;

/// What iceoryx2 adds to a pulse at most, bytes.
const EXTRA_BYTES: u64 = 256;

/// Publishes pulses in shared memory.
#[derive(Debug)]
pub struct ShmSink {
    // Ports before services before the node: each rests on the next.
    pulses: Publisher<Ipc, [u64], PulseHeader>,
    run: Publisher<Ipc, [u8], ()>,
    service: PortFactory<Ipc, [u64], PulseHeader>,
    _run_service: PortFactory<Ipc, [u8], ()>,
    _node: Node<Ipc>,
    settings: Settings,
    header: Header,
    common: PulseHeader,
    words: usize,
    written: u64,
    delivered: u64,
    /// Pulses for which there was no memory.
    lost: u64,
    most: usize,
}

/// What iceoryx2 reports.
pub(crate) fn failed(service: &str, action: &'static str) -> impl Fn(&dyn std::fmt::Debug) -> SinkError {
    let service = service.to_owned();
    move |error| SinkError::Shm { service: service.clone(), action, error: format!("{error:?}") }
}

/// A node of this process; what others have left behind is removed.
pub(crate) fn node(service: &str) -> Result<Node<Ipc>, SinkError> {
    set_log_level_from_env_or(LogLevel::Fatal);
    NodeBuilder::new()
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create()
        .map_err(|error| failed(service, "reaching shared memory")(&error))
}

/// The name of one of the services.
pub(crate) fn name(service: &str, part: &str) -> Result<ServiceName, SinkError> {
    ServiceName::new(&format!("{service}/{part}"))
        .map_err(|error| failed(service, "naming the service")(&error))
}

/// Whether somebody publishes under this name.
pub(super) fn preflight(settings: &Settings) -> Result<(), SinkError> {
    let service = settings.service.as_str();
    let node = node(service)?;
    let pulses = node
        .service_builder(&name(service, "pulses")?)
        .publish_subscribe::<[u64]>()
        .user_header::<PulseHeader>()
        .open();
    match pulses {
        Ok(pulses) if pulses.dynamic_config().number_of_publishers() > 0 => {
            Err(SinkError::ServiceInUse { service: service.to_owned() })
        }
        // What else is wrong with it is reported when it is made.
        _ => Ok(()),
    }
}

impl ShmSink {
    /// Makes the services, takes the memory, and publishes what the run is.
    ///
    /// # Errors
    /// A service that somebody else publishes, and memory that is not there.
    pub fn open(settings: &Settings, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        let service = settings.service.as_str();
        let common = PulseHeader::of_run(header, description::source());
        let words = common.words().unwrap_or_default();
        let slots = settings.buffer_pulses + BORROWED * settings.subscribers + settings.subscribers + 4;
        let text = description::of_run(header, common.source).to_string();
        memory::check(service, needed_bytes(words, slots, text.len(), settings.subscribers))?;

        let node = node(service)?;
        let held = |error: &dyn std::fmt::Debug| failed(service, "making the service")(error);
        let pulses_service = node
            .service_builder(&name(service, "pulses")?)
            .publish_subscribe::<[u64]>()
            .user_header::<PulseHeader>()
            .enable_safe_overflow(true)
            .history_size(settings.buffer_pulses)
            .subscriber_max_buffer_size(settings.buffer_pulses)
            .subscriber_max_borrowed_samples(BORROWED)
            .max_subscribers(settings.subscribers)
            .max_publishers(1)
            .open_or_create()
            .map_err(|error| held(&error))?;
        let run_service = node
            .service_builder(&name(service, "run")?)
            .publish_subscribe::<[u8]>()
            .enable_safe_overflow(true)
            .history_size(1)
            .subscriber_max_buffer_size(1)
            .max_subscribers(settings.subscribers)
            .max_publishers(1)
            .open_or_create()
            .map_err(|error| held(&error))?;
        let taken = |error: PublisherCreateError| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => {
                SinkError::ServiceInUse { service: service.to_owned() }
            }
            error => failed(service, "taking shared memory")(&error),
        };
        let pulses = pulses_service
            .publisher_builder()
            .max_loaned_samples(slots)
            .initial_max_slice_len(words.max(1))
            .override_sample_preallocation(move |_| slots)
            .create()
            .map_err(taken)?;
        touch(&pulses, words, slots);
        let run =
            run_service.publisher_builder().initial_max_slice_len(text.len()).create().map_err(taken)?;
        let sample = run
            .loan_slice_uninit(text.len())
            .map_err(|error| failed(service, "taking shared memory")(&error))?
            .write_from_slice(text.as_bytes());
        sample.send().map_err(|error| failed(service, "describing the run")(&error))?;
        Ok(Self {
            pulses,
            run,
            service: pulses_service,
            _run_service: run_service,
            _node: node,
            settings: settings.clone(),
            header: header.clone(),
            common,
            words,
            written: 0,
            delivered: 0,
            lost: 0,
            most: 0,
        })
    }

    /// Publishes a header and words; whether there was memory for it.
    fn publish(&mut self, header: PulseHeader, words: usize, word: impl FnMut(usize) -> u64) -> bool {
        // Whoever has come since gets the description before the pulse.
        let _ = self.run.update_connections();
        let Ok(mut sample) = self.pulses.loan_slice_uninit(words) else { return false };
        *sample.user_header_mut() = header;
        // A connection that breaks is that of a subscriber that is gone: the others have theirs.
        self.delivered += sample.write_from_fn(word).send().unwrap_or_default() as u64;
        true
    }
}

/// Bytes of shared memory that a run takes at most: its pulses, and copies of its description, which holds
/// the replica and is as long as many pulses where that is long.
fn needed_bytes(words: usize, slots: usize, text: usize, subscribers: usize) -> u64 {
    // iceoryx2 has room for one that waits and two that are held for each subscriber, and a few more.
    let copies = 3 * subscribers as u64 + 4;
    (words as u64 * 8 + EXTRA_BYTES) * slots as u64 + (text as u64 + EXTRA_BYTES) * copies + (1 << 20)
}

/// Writes to all of the memory, so that none of it has to be found while pulses are published.
fn touch(pulses: &Publisher<Ipc, [u64], PulseHeader>, words: usize, slots: usize) {
    let mut all = Vec::with_capacity(slots);
    for _ in 0..slots {
        let Ok(sample) = pulses.loan_slice_uninit(words) else { break };
        all.push(sample.write_from_fn(|_| 0));
    }
}

impl Sink for ShmSink {
    fn name(&self) -> &'static str {
        "shm"
    }

    fn describe(&self) -> String {
        format!("shared memory, iceoryx2 service {}", self.settings.service)
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        self.header.check_pulse(pulse)?;
        let header = self.common.of_pulse(pulse, self.written);
        let bytes = pulse.samples.as_bytes();
        let states = pulse.nav_reported.len() * STATE_WORDS;
        let windows = self.words - usize::from(header.windows);
        let record = |place: usize| {
            let state = layout::words_of(&pulse.nav_reported[place / STATE_WORDS]);
            state[place % STATE_WORDS]
        };
        let published = self.publish(header, self.words, |place| {
            if place < states {
                return record(place);
            }
            if let Some(receiver) = place.checked_sub(windows) {
                return pulse.window_start_of(receiver).to_bits();
            }
            let at = (place - states) * 8;
            match bytes.get(at..at + 8) {
                Some(word) => bytemuck::pod_read_unaligned(word),
                // The last word of codes may be half full.
                None => {
                    let mut word = [0; 8];
                    let rest = bytes.get(at..).unwrap_or_default();
                    word[..rest.len()].copy_from_slice(rest);
                    u64::from_ne_bytes(word)
                }
            }
        });
        self.lost += u64::from(!published);
        self.written += 1;
        self.most = self.most.max(self.service.dynamic_config().number_of_subscribers());
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        // Whoever comes while there are no pulses gets what there is now.
        let _ = self.run.update_connections();
        let _ = self.pulses.update_connections();
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        let end = PulseHeader { sequence: self.written, end: 1, ..self.common };
        self.publish(end, 0, |_| 0);
        let all = SubscriberCounts {
            at: self.describe(),
            seen: self.most as u64,
            messages: self.delivered,
            lost: self.lost,
        };
        Ok(Closed::of(SinkReport {
            name: "shm".to_owned(),
            pulses: self.written,
            bytes: self.written * (self.words * 8) as u64,
            subscribers: Some(all),
            ..SinkReport::default()
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_replica_counts_among_the_memory() {
        let pulses = needed_bytes(1000, 10, 0, 4);
        assert!((80_000..80_000 + (2 << 20)).contains(&pulses), "{pulses}");
        assert!(needed_bytes(1000, 10, 5 << 20, 4) - pulses >= 16 * (5 << 20));
    }
}
