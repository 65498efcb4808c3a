//! Opens where pulses go, and describes the run there.

use std::iter;
use std::sync::Arc;

use super::stages::PulseFactory;
use super::targets::Observed;
use super::video::{full_dbw, video};
use super::{navigation, targets};
use crate::config::Run;
use crate::motion::changes::Changes;
use crate::nav::TrackSource;
use crate::pipeline::fault::PulseError;
use crate::recording::crsd::{Described, Description};
use crate::recording::header::{AdcRow, ChannelRow, Header, Origin, PairRow};
use crate::recording::instrument::{EmitterRow, Instrument, WaveformRow};
use crate::scene::Scene;
use crate::scene::calibration::Signal;
use crate::scene::radar::{AntennaMount, PolarisationBasis};
use crate::sinks::crsd::{CrsdSink, Plan};
use crate::sinks::sink::{Closed, Sink, SinkError, SinkReport, Unplaced};
use crate::sinks::{self, Kind};
use crate::transport::Policy;
use crate::transport::schedule::Schedule;
use crate::transport::stage::{Outcome, RunError};

/// What can be known of outputs to be made before anything is: all their faults.
pub(crate) fn preflight(sinks: &[sinks::Settings]) -> Vec<SinkError> {
    sinks.iter().filter_map(unnamed).chain(sinks::preflight(sinks)).collect()
}

/// A recording gets its name when it is begun, in place of what is replaced: `.` and `..` are no names that
/// can be given.
fn unnamed(settings: &sinks::Settings) -> Option<SinkError> {
    let (Kind::Hdf5 { path, .. } | Kind::Plain { path, .. } | Kind::Crsd { path, .. }) = &settings.kind
    else {
        return None;
    };
    let words = "the path ends in no name; allowed: the name of a file or folder that is to be made";
    let source = std::io::Error::new(std::io::ErrorKind::IsADirectory, words);
    path.file_name().is_none().then(|| SinkError::io(path, "making the recording")(source))
}

/// The error that pulses of each class keep, dB: as asked, or as predicted where that is more. Empty where
/// all pulses are of one class.
fn error_classes_db(factory: &PulseFactory, coarser: &[PulseFactory]) -> Vec<f64> {
    let of = |factory: &PulseFactory| Some(factory.plan()?.promised_db());
    let classes = || iter::once(factory).chain(coarser).filter_map(of);
    if coarser.is_empty() { Vec::new() } else { classes().collect() }
}

/// What the run is.
pub(super) fn header(
    run: &Run,
    scene: &Scene,
    (factory, coarser): (&PulseFactory, &[PulseFactory]),
    schedule: &Schedule,
    changes: Option<&Arc<Changes>>,
) -> Header {
    let radar = &scene.radar;
    let transmitter = |i: usize| radar.transmitters[i].name.clone();
    let receiver = |i: usize| radar.receivers[i].name.clone();
    let basis = |mount: &AntennaMount| PolarisationBasis::of(&mount.pattern).name().to_owned();
    Header {
        software: format!("nereus {}", env!("CARGO_PKG_VERSION")),
        carrier_hz: radar.carrier_hz,
        sample_rate_hz: radar.sample_rate_hz,
        bandwidth_hz: factory.waveform.bandwidth_hz(),
        pulse_s: factory.waveform.duration_s(),
        prf_hz: radar.emissions.mean_prf_hz(),
        channels: radar
            .channels
            .iter()
            .map(|channel| ChannelRow {
                name: channel.name.clone(),
                transmitter: transmitter(channel.transmitter),
                receiver: receiver(channel.receiver),
                polarisations: [channel.rx.letter(), channel.tx.letter()].iter().collect(),
                transmit_basis: basis(&radar.transmitters[channel.transmitter].antenna),
                receive_basis: basis(&radar.receivers[channel.receiver].antenna),
            })
            .chain(run.calibration.iter().map(|known| ChannelRow {
                name: known.name.clone(),
                transmitter: match known.signal {
                    Signal::Loopback { transmitter: place, .. } => transmitter(place),
                    Signal::Tone { .. } => String::new(),
                },
                receiver: receiver(known.receiver),
                polarisations: known.signal.kind().to_owned(),
                // The signal does not pass an antenna.
                ..ChannelRow::default()
            }))
            .collect(),
        pairs: radar
            .pairs()
            .into_iter()
            .map(|pair| PairRow {
                transmitter: transmitter(pair.transmitter),
                receiver: receiver(pair.receiver),
            })
            .collect(),
        origin: scene.frame.origin().map(|origin| Origin {
            lat_deg: origin.lat_rad.to_degrees(),
            lon_deg: origin.lon_rad.to_degrees(),
            h_m: origin.h_m,
        }),
        seed: scene.seed,
        config: run.text.clone(),
        replica: factory.replica(),
        instrument: Some(Instrument {
            emitters: (radar.emitters.iter().zip(factory.emitted()))
                .map(|(emitter, signal)| EmitterRow::of(emitter, scene, signal))
                .collect(),
            error_classes_db: error_classes_db(factory, coarser),
            waveform: WaveformRow::of(&radar.waveform).as_made(factory.waveform.as_ref()),
            ..Instrument::of(scene)
        }),
        platforms: scene.platforms.clone(),
        transmitters: radar.transmitters.iter().map(|t| t.name.clone()).collect(),
        receivers: radar.receivers.iter().map(|r| r.name.clone()).collect(),
        targets: scene.targets.iter().map(|t| t.name.clone()).collect(),
        ships: scene.ships.iter().map(|s| s.name.clone()).collect(),
        clocks: run.clocks.clocks.iter().map(|c| c.name.clone()).collect(),
        layout: *factory.layout(),
        adc: radar.adc.map(|adc| AdcRow { bits: adc.bits, step: adc.step() }),
        start: scene.start,
        first_pulse: schedule.first,
        pulses: schedule.count,
        shard: run.shard,
        truth: true,
        changes: changes.map(|changes| Arc::clone(changes.log())),
    }
}

/// What CRSD sinks need to know of a run; none without such a sink.
fn crsd_plan(run: &Run, scene: &Scene, header: &Header) -> Result<Option<Plan>, SinkError> {
    if !run.sinks.iter().any(|sink| matches!(sink.kind, Kind::Crsd { .. })) {
        return Ok(None);
    }
    if run.nav.iter().any(|nav| matches!(nav.truth, TrackSource::Live(_))) {
        return Err(SinkError::CrsdLive);
    }
    let described = Described { header, scene, nav: &run.nav, clocks: &run.clocks };
    let description = Description::new(described, &[])?;
    let planned = description.planned(&scene.radar.tx_polarisation, header.first_pulse, header.pulses);
    description.check_planned(&planned)?;
    Ok(Some(Plan { description, planned }))
}

/// What sinks need to know of a run beside its header.
pub(super) struct Plans {
    crsd: Option<Plan>,
    noise_figure_db: Option<f64>,
    observed: Option<Observed>,
}

impl Plans {
    /// Those of a run.
    ///
    /// # Errors
    /// Of a sink that cannot take what the run makes.
    pub(super) fn of(run: &Run, scene: &Scene, header: &Header) -> Result<Self, SinkError> {
        // A sink that makes nothing of these pulses is found before anything is opened.
        for sink in &run.sinks {
            if let Kind::Asterix(settings) = &sink.kind {
                video(settings, header)?;
            }
        }
        let is_asked = run.sinks.iter().any(|sink| matches!(sink.kind, Kind::Targets(_)));
        Ok(Self {
            crsd: crsd_plan(run, scene, header)?,
            noise_figure_db: scene.radar.noise_figure_db,
            // Not the scene that is made ready: that has scatterers of ships among its targets.
            observed: is_asked.then(|| Observed::of(&run.scene)),
        })
    }
}

fn open(settings: &sinks::Settings, header: &Header, plans: &Plans) -> Result<Box<dyn Sink>, SinkError> {
    Ok(match &settings.kind {
        #[cfg(feature = "hdf5")]
        Kind::Hdf5 { path, segment_s, force } => {
            Box::new(sinks::hdf5::Hdf5Sink::create(path, *segment_s, *force, header)?)
        }
        #[cfg(not(feature = "hdf5"))]
        Kind::Hdf5 { path, .. } => return Err(SinkError::NoHdf5 { path: path.clone() }),
        Kind::Plain { path, force } => Box::new(sinks::plain::PlainSink::create(path, *force, header)?),
        Kind::Crsd { path, force } => match &plans.crsd {
            Some(plan) => Box::new(CrsdSink::create(path, *force, plan)?),
            None => return Err(SinkError::CrsdLive),
        },
        Kind::Vita49(settings) => sinks::vita49::open(settings, header)?,
        #[cfg(feature = "shm")]
        Kind::Shm(settings) => Box::new(sinks::shm::ShmSink::open(settings, header)?),
        #[cfg(not(feature = "shm"))]
        Kind::Shm(settings) => return Err(SinkError::NoShm { service: settings.service.clone() }),
        Kind::Zmq(settings) => Box::new(sinks::zmq::ZmqSink::open(settings, header)?),
        Kind::Asterix(settings) => {
            let full_dbw = full_dbw(settings, plans.noise_figure_db, header.pulse_s);
            Box::new(sinks::asterix::AsterixSink::open(settings, video(settings, header)?, full_dbw)?)
        }
        Kind::Nav(settings) => {
            let encoder = navigation::encoder(settings, header).ok_or(SinkError::NoOrigin)?;
            Box::new(sinks::nav::NavSink::open(settings, encoder, header)?)
        }
        Kind::Targets(settings) => {
            let encoder = plans.observed.as_ref().and_then(|all| targets::encoder(settings, all, header));
            Box::new(sinks::nav::NavSink::of_targets(settings, encoder.ok_or(SinkError::NoOrigin)?, header)?)
        }
        Kind::Null => Box::new(sinks::null::NullSink::new()),
    })
}

/// Opens every sink, or none: when one fails, the others remove what they have made, and nothing else.
pub(super) fn open_all(
    sinks: &[sinks::Settings],
    header: &Header,
    plans: &Plans,
) -> Result<Vec<Box<dyn Sink>>, SinkError> {
    let mut opened: Vec<Box<dyn Sink>> = Vec::with_capacity(sinks.len());
    for settings in sinks {
        match open(settings, header, plans) {
            Ok(sink) => opened.push(sink),
            Err(error) => {
                opened.iter_mut().for_each(|sink| sink.abandon());
                return Err(error);
            }
        }
    }
    Ok(opened)
}

/// Puts recordings in the place of older ones, if the run went well; otherwise they stay beside them. `asked`
/// is the number of pulses, if they are all that the scenario has.
///
/// A run that went on without a sink has failed, but its other recordings are complete; so has one in which a
/// sink missed pulses, unless its policy allows that.
pub(super) fn placed(
    outcome: Outcome<Option<Closed>, PulseError, SinkError>,
    asked: Option<u64>,
    policy: Policy,
) -> Outcome<Option<SinkReport>, PulseError, SinkError> {
    let Outcome { summary, reports, mut failed, mut result } = outcome;
    let passed = summary.health.pulses + summary.health.dropped;
    let (has_failed, whole) =
        (result.is_err(), !summary.stopped && asked.is_some_and(|asked| passed >= asked));
    let reports = reports
        .into_iter()
        .map(|(name, closed)| {
            let Some(closed) = closed else { return (name, None) };
            if has_failed {
                return (name, Some(closed.keep()));
            }
            match closed.place(whole) {
                Ok(report) => (name, Some(report)),
                Err(unplaced) => {
                    let Unplaced { report, error } = *unplaced;
                    if result.is_ok() {
                        result = Err(RunError::Sink { name: name.clone(), error });
                    }
                    (name, Some(report))
                }
            }
        })
        .collect();
    if result.is_ok() && !failed.is_empty() {
        let (name, error) = failed.remove(0);
        result = Err(RunError::Without { name, error });
    }
    let pulses = summary.health.pulses;
    let short = summary.health.sinks.iter().find(|sink| sink.lossless && !sink.failed && sink.dropped > 0);
    if let (true, false, Some(sink)) = (result.is_ok(), policy.drops(), short) {
        result = Err(RunError::Missed { name: sink.name.clone(), missed: sink.dropped, pulses });
    }
    Outcome { summary, reports, failed, result }
}

/// Whether two places are of the same kind.
pub(super) fn same_kind(a: &Kind, b: &Kind) -> bool {
    std::mem::discriminant(a) == std::mem::discriminant(b)
}
