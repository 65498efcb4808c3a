//! What has been learned of the run: once all is known, the header of a recording.

use std::collections::HashMap;

use crate::pulse::{Layout, SampleFormat};
use crate::recording::header::{AdcRow, ChannelRow, Header, Origin};
use crate::recording::instrument::Instrument;
use crate::time::TimeTag;

use super::context::{ChannelDescription, Context, Extension, Format, RunDescription};
use super::radar::{ANTENNAS, Radar, TURNS};

/// Most channels and platforms that are taken.
const CHANNELS: usize = 1024;
const PLATFORMS: usize = 1024;
/// Most samples of a pulse over all channels.
const SAMPLES: usize = 1 << 24;
/// Stream identifiers: those of channels and platforms count from here.
const CHANNEL_STREAMS: u32 = 0x1000_0000;
const PLATFORM_STREAMS: u32 = 0x2000_0000;
const NAME_STREAMS: u32 = 0x3000_0000;
const RUN_STREAM: u32 = 0x4000_0000;
const SIGNAL_STREAM: u32 = 0x5000_0000;
const REPLICA_STREAM: u32 = 0x6000_0000;
const ANTENNA_STREAMS: u32 = 0x7000_0000;
const EMITTER_STREAMS: u32 = 0x8000_0000;
const PULSE_STREAMS: u32 = 0x9000_0000;

/// Whether a stream is one that may have standard contexts.
pub(super) fn has_contexts(stream: u32) -> bool {
    let within = |first: u32, most: usize| stream.checked_sub(first).is_some_and(|n| (n as usize) < most);
    within(CHANNEL_STREAMS, CHANNELS) || within(PLATFORM_STREAMS, PLATFORMS)
}

/// Whether an extension context comes in the stream that it belongs to.
pub(super) fn belongs(stream: u32, extension: &Extension) -> bool {
    let (first, [number, of], most) = match extension {
        Extension::State(state) => (PLATFORM_STREAMS, state.platform, PLATFORMS),
        Extension::Channel(channel) => (CHANNEL_STREAMS, channel.number, CHANNELS),
        Extension::Platform(number, _) => (NAME_STREAMS, *number, PLATFORMS),
        Extension::Run(_) => (RUN_STREAM, [0, 1], 1),
        Extension::Signal(_) => (SIGNAL_STREAM, [0, 1], 1),
        Extension::Replica(_) => (REPLICA_STREAM, [0, 1], 1),
        Extension::Antenna(antenna) => (ANTENNA_STREAMS, antenna.number, ANTENNAS as usize),
        Extension::Emitter(emitter) => (EMITTER_STREAMS, emitter.antenna.number, ANTENNAS as usize),
        Extension::Pulse(pulse) => (PULSE_STREAMS, pulse.number, TURNS as usize),
    };
    number < of && (of as usize) <= most && stream == first + number
}

/// The run as far as it is known.
#[derive(Debug, Default)]
pub(super) struct Roster {
    run: Option<RunDescription>,
    /// By number: the stream, and its description.
    channels: Vec<Option<(u32, ChannelDescription)>>,
    platforms: Vec<Option<String>>,
    radar: Radar,
    /// By stream.
    contexts: HashMap<u32, Context>,
    /// The header, once it is complete.
    known: Option<Known>,
    /// Descriptions that contradict each other or what can be held.
    pub(super) contradictions: u64,
}

/// A run of which everything is known.
#[derive(Debug)]
pub(super) struct Known {
    /// As recordings have it; without truth.
    pub(super) header: Header,
    /// Stream of every channel.
    pub(super) streams: Vec<u32>,
}

/// Entry `number` of `of` in a list that is bounded.
fn entry<T>(list: &mut Vec<Option<T>>, [number, of]: [u32; 2], most: usize) -> Option<&mut Option<T>> {
    let (number, of) = (number as usize, of as usize);
    if number >= of || of > most || (!list.is_empty() && list.len() != of) {
        return None;
    }
    list.resize_with(of, || None);
    list.get_mut(number)
}

impl Roster {
    /// Whether a description is of another run than the one that is known.
    pub(super) fn is_another(&self, run: &RunDescription) -> bool {
        self.run.as_ref().is_some_and(|known| !same_run(known, run))
    }

    /// The run, once everything is known of it.
    pub(super) fn known(&self) -> Option<&Known> {
        self.known.as_ref()
    }

    /// Takes a description. What differs from an earlier one is counted and left.
    /// Whether it agrees.
    pub(super) fn learn(&mut self, stream: u32, extension: Extension) -> bool {
        let agrees = match extension {
            Extension::State(_) => true,
            Extension::Run(run) => {
                let fits = self.run.as_ref().is_none_or(|known| same_run(known, &run));
                if fits {
                    self.run = Some(*run);
                }
                fits
            }
            Extension::Platform(number, name) => match entry(&mut self.platforms, number, PLATFORMS) {
                Some(entry) => *entry.get_or_insert_with(|| name.clone()) == name,
                None => false,
            },
            Extension::Channel(channel) => match entry(&mut self.channels, channel.number, CHANNELS) {
                Some(Some((known, of))) => {
                    // The step is NaN without a converter.
                    let adc = |channel: &ChannelDescription| (channel.adc.0.to_bits(), channel.adc.1);
                    let same = of.names == channel.names && of.bases == channel.bases;
                    *known == stream && same && of.samples == channel.samples && adc(of) == adc(&channel)
                }
                Some(entry) => {
                    *entry = Some((stream, channel));
                    true
                }
                None => false,
            },
            Extension::Signal(signal) => self.radar.learn_signal(*signal),
            Extension::Replica(piece) => {
                self.radar.learn_piece(piece, self.run.as_ref().and_then(|run| run.radar))
            }
            Extension::Antenna(antenna) => self.radar.learn_antenna(*antenna),
            Extension::Emitter(emitter) => self.radar.learn_emitter(*emitter),
            Extension::Pulse(pulse) => self.radar.learn_pulse(*pulse),
        };
        self.contradictions += u64::from(!agrees);
        self.complete();
        agrees
    }

    /// Takes a description that contradicts what was learned, in the place of that.
    pub(super) fn learn_again(&mut self, stream: u32, extension: Extension) {
        match &extension {
            Extension::State(_) => {}
            Extension::Run(_) => {
                self.run = None;
                self.radar.forget_replica();
            }
            Extension::Signal(_) => self.radar.forget_signal(),
            Extension::Replica(piece) => self.radar.forget_piece(piece),
            Extension::Antenna(antenna) => self.radar.forget_antenna(antenna.number),
            Extension::Emitter(emitter) => self.radar.forget_emitter(emitter.antenna.number),
            Extension::Pulse(pulse) => self.radar.forget_pulse(pulse.number),
            Extension::Platform(..) => self.platforms.clear(),
            Extension::Channel(_) => self.channels.clear(),
        }
        self.known = None;
        self.learn(stream, extension);
    }

    /// Whether a standard context is of the run that is known.
    pub(super) fn agrees(&self, stream: u32, context: &Context) -> bool {
        let Some(Known { header, streams }) = &self.known else { return true };
        !streams.contains(&stream) || is_of(context, header.layout.format, header.sample_rate_hz)
    }

    /// Takes the standard context of a stream. One that contradicts what is known is counted, and left unless
    /// all is to be learned again.
    pub(super) fn learn_context(&mut self, stream: u32, context: Context, fresh: bool) {
        if !self.agrees(stream, &context) {
            self.contradictions += 1;
            if !fresh {
                return;
            }
            self.known = None;
        }
        self.contexts.insert(stream, context);
        self.complete();
    }

    /// The standard context of a stream.
    pub(super) fn context(&self, stream: u32) -> Option<&Context> {
        self.contexts.get(&stream)
    }

    fn complete(&mut self) {
        if self.known.is_none() {
            self.known = self.assemble();
        }
    }

    fn assemble(&self) -> Option<Known> {
        let run = self.run.as_ref()?;
        let channels: Vec<&(u32, ChannelDescription)> =
            self.channels.iter().map(Option::as_ref).collect::<Option<_>>()?;
        let names: Vec<&String> = self.platforms.iter().map(Option::as_ref).collect::<Option<_>>()?;
        let (_, first) = channels.first()?;
        let samples = first.samples as usize;
        let total = samples.checked_mul(channels.len())?;
        let format = match self.context(channels.first()?.0)?.format? {
            Format::Cf32 => SampleFormat::Cf32,
            Format::Ci16 => SampleFormat::Ci16,
        };
        let alike = channels.iter().all(|(stream, channel)| {
            channel.samples == first.samples
                && self.context(*stream).is_some_and(|context| is_of(context, format, run.sample_rate_hz))
        });
        if names.is_empty() || total == 0 || total > SAMPLES || !alike {
            return None;
        }
        let (instrument, replica) = self.radar.described(run.radar, run.emitters, &names)?.unzip();
        let antennas = |transmit: bool| -> Vec<String> {
            let all = instrument.iter().flat_map(|instrument: &Instrument| &instrument.antennas);
            all.filter(|antenna| antenna.transmits == transmit).map(|antenna| antenna.name.clone()).collect()
        };
        let (transmitters, receivers) = (antennas(true), antennas(false));
        let layout = Layout {
            channels: channels.len(),
            samples,
            format,
            platforms: names.len(),
            antennas: transmitters.len() + receivers.len(),
            targets: 0,
            pairs: 0,
            // By whose windows samples are placed must be known by name.
            windows: if run.windows as usize == receivers.len() { receivers.len() } else { 0 },
            ships: 0,
            clocks: 0,
        };
        let (step, bits) = first.adc;
        let [lat_deg, lon_deg, h_m] = run.origin;
        let (seconds, fraction_s) = run.start;
        let header = Header {
            software: run.software.clone(),
            carrier_hz: run.carrier_hz,
            sample_rate_hz: run.sample_rate_hz,
            bandwidth_hz: run.bandwidth_hz,
            pulse_s: run.pulse_s,
            prf_hz: run.prf_hz,
            channels: channels
                .iter()
                .map(|(_, channel)| {
                    let [name, transmitter, receiver, polarisations] = channel.names.clone();
                    let [transmit_basis, receive_basis] = channel.bases.clone();
                    ChannelRow { name, transmitter, receiver, polarisations, transmit_basis, receive_basis }
                })
                .collect(),
            pairs: Vec::new(),
            origin: lat_deg.is_finite().then_some(Origin { lat_deg, lon_deg, h_m }),
            seed: run.seed,
            config: "# received over the wire, which does not carry the scenario\n".to_owned(),
            replica: replica.unwrap_or_default(),
            instrument,
            platforms: names.into_iter().cloned().collect(),
            transmitters,
            receivers,
            targets: Vec::new(),
            ships: Vec::new(),
            clocks: Vec::new(),
            layout,
            adc: (format == SampleFormat::Ci16).then_some(AdcRow { bits, step }),
            start: TimeTag::new(seconds, fraction_s),
            first_pulse: run.first_pulse,
            pulses: run.pulses,
            shard: None,
            truth: false,
            changes: None,
        };
        header.check().ok()?;
        Some(Known { header, streams: channels.iter().map(|(stream, _)| *stream).collect() })
    }
}

/// Whether a standard context describes the samples of a run.
fn is_of(context: &Context, format: SampleFormat, sample_rate_hz: f64) -> bool {
    let same_format = match context.format {
        Some(Format::Cf32) => format == SampleFormat::Cf32,
        Some(Format::Ci16) => format == SampleFormat::Ci16,
        None => false,
    };
    let rate_hz = context.sample_rate_hz.unwrap_or(f64::NAN);
    // The field has 20 bits below the point.
    same_format && (rate_hz - sample_rate_hz).abs() <= 2f64.powi(-20) + sample_rate_hz * f64::EPSILON
}

/// Whether two descriptions are of one run.
pub(super) fn same_run(a: &RunDescription, b: &RunDescription) -> bool {
    let bits = |run: &RunDescription| {
        let [lat, lon, h] = run.origin;
        let signal = [run.carrier_hz, run.sample_rate_hz, run.bandwidth_hz, run.pulse_s, run.prf_hz];
        ([lat, lon, h].map(f64::to_bits), signal.map(f64::to_bits), run.start.1.to_bits())
    };
    bits(a) == bits(b)
        && (a.start.0, a.seed, a.first_pulse, a.pulses) == (b.start.0, b.seed, b.first_pulse, b.pulses)
        && (a.radar, a.windows, a.emitters) == (b.radar, b.windows, b.emitters)
}
