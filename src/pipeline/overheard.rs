//! What receivers take of emitters beside the transmitters of their radar: another radar, a jammer.
//!
//! Each emitter has paths, a plan and an engine of its own, by its own schedule, carrier and waveform. What
//! it returns is added, spectrum by spectrum, to the channels of the receivers that take it:
//!
//! ```text
//! S[k] = S_radar[k] + sum over emitters of S_emitter[k]
//! ```
//!
//! Where its pulses are longer or shorter than the radar's its transforms are, too: [`Refit`] brings them to
//! one length. Echoes of different emitters add as powers on average, and so do their errors. But an emitter
//! may be received by few pulses, and a pulse is judged by the mean of all: its error is planned finer by
//! the share of pulses that receive it.

use std::sync::{Arc, OnceLock};

use num_complex::Complex64;

use super::engine::{EchoEngine, EchoWorker};
use super::engines;
use super::fault::{BuildError, BuildErrors, PulseError};
use super::kit::{Desk, Listen};
use super::refit::Refit;
use crate::echo::{Asked, Fidelity};
use crate::fidelity::budget::{EXACT_DB, Plan};
use crate::fidelity::choose::{Chooser, most_pulses};
use crate::fidelity::probe::spread_over;
use crate::motion::PlatformTracks;
use crate::paths::{Drawn, PathGenerator, Shares, scene_of, sent_by};
use crate::pulse::Pulse;
use crate::pulse::costs::{Costs, Stage};
use crate::radar::clock::RunningClocks;
use crate::radar::fault::RadarError;
use crate::radar::waveform::{self, Waveform, offset};
use crate::scene::radar::{Channel, Gate, Waveform as Described};
use crate::scene::{Emitter, Radar, Scene};
use crate::time::PulseTimes;

/// Pulses of which it is found whether they receive an emitter.
const PULSES: u64 = 512;
/// Most pulses of an emitter that a window receives.
const MOST_RECEIVED: f64 = 10_000.0;
/// Longest way of an emission that is received, s: 30,000 km. What left earlier is not.
const LONGEST_S: f64 = 0.1;
/// How much finer than the rest an emitter is planned, dB: there is no dry run of it.
const FINER_DB: f64 = 6.0;
/// Errors from here down are kept pulse by pulse, in f64: no dry run shows what blocks would leave, dB.
const ONE_BY_ONE_DB: f64 = -90.0;
/// Less than that received of an emission on average is taken for so much.
const LEAST_RECEIVED: f64 = 0.01 / PULSES as f64;
/// The finest error that a plan may be asked for, dB.
const FINEST_DB: f64 = -120.0;

/// An emitter whose paths are known, before anything is planned.
#[derive(Clone)]
pub(crate) struct Emitting {
    name: String,
    scene: Scene,
    generator: PathGenerator,
    waveform: Arc<dyn Waveform>,
    offset_hz: f64,
    channels: Vec<Vec<usize>>,
}

/// The emitters of a scene.
///
/// # Errors
/// Faults of their antennas, waveforms and tracks.
pub(crate) fn emitting(
    scene: &Scene,
    tracks: &[PlatformTracks],
    drawn: Drawn<'_>,
) -> Result<Vec<Emitting>, BuildErrors> {
    let radar = &scene.radar;
    // What may reach a window, until the last closes; where tracks begin later or end earlier, from the first
    // pulse or until the last.
    let closes_s = |gate: &Gate| match gate {
        Gate::Fixed { start_s } => start_s.max(0.0) + window_s(radar),
        Gate::Follow { .. } => 0.0,
    };
    let after_s = (0..radar.receivers.len()).map(|end| closes_s(radar.gate(end))).fold(0.0, f64::max);
    let of = |emitter: &Emitter| {
        let made = |before_s, after_s| one((scene, emitter), tracks, drawn, [before_s, after_s]);
        let early = emitter.emissions.start_s() < 0.0;
        made(f64::INFINITY, after_s)
            .or_else(|fault| if early { made(0.0, after_s) } else { Err(fault) })
            .or_else(|_| made(0.0, 0.0))
    };
    radar.emitters.iter().map(of).collect()
}

/// An emitter that radiates from so long before the first pulse until so long after the last.
fn one(
    (scene, emitter): (&Scene, &Emitter),
    tracks: &[PlatformTracks],
    drawn: Drawn<'_>,
    [before_s, after_s]: [f64; 2],
) -> Result<Emitting, BuildErrors> {
    let radar = &scene.radar;
    let waveform = waveform::from_description(&emitter.waveform)?;
    let of_train = (emitter.transmitter.name.as_str(), &emitter.emissions);
    check(of_train, (waveform.duration_s(), waveform.is_stream()), window_s(radar))?;
    let span_s = [before_s.min(LONGEST_S + waveform.duration_s()), after_s];
    let mut own = scene_of(scene, emitter, span_s);
    if own.pulses == 0 && scene.pulses > 0 {
        let (name, start_s) = (emitter.transmitter.name.clone(), emitter.emissions.start_s());
        return Err(BuildError::EmitterLate { name, start_s }.into());
    }
    let offset_hz = emitter.carrier_hz - radar.carrier_hz;
    let waveform = offset(waveform, offset_hz);
    let pulse_s = waveform.duration_s();
    let made = |emitter: &Emitter, own: &Scene| {
        PathGenerator::of_emitter((scene, emitter), own, pulse_s, tracks.to_vec(), drawn)
    };
    let mut generator = made(emitter, &own)?;
    // A direct path that no window receives must not be what Doppler and errors are judged by.
    let is_live = tracks.iter().any(|tracks| tracks.truth.as_live().is_some());
    if emitter.direct_path && emitter.echo && !is_live && !generator.may_receive_direct_path()? {
        let unheard = Emitter { direct_path: false, ..emitter.clone() };
        own = scene_of(scene, &unheard, span_s);
        generator = made(&unheard, &own)?;
    }
    let channels = channels_of(radar, &own.radar);
    let name = emitter.transmitter.name.clone();
    Ok(Emitting { name, scene: own, generator, waveform, offset_hz, channels })
}

fn window_s(radar: &Radar) -> f64 {
    radar.window.samples as f64 / radar.sample_rate_hz
}

/// Refuses pulses that overlap each other, unless they are segments of one signal, and more of them in a
/// window than anybody would wait for.
fn check(
    (name, train): (&str, &PulseTimes),
    (pulse_s, is_stream): (f64, bool),
    window_s: f64,
) -> Result<(), BuildError> {
    let (name, interval_s) = (name.to_owned(), train.shortest_pri_s());
    if pulse_s > interval_s * (1.0 + 1e-9) && !is_stream {
        return Err(BuildError::EmitterOverlaps { name, pulse_s, interval_s });
    }
    let received = (window_s + pulse_s) / interval_s;
    if received > MOST_RECEIVED {
        return Err(BuildError::EmitterCrowds { name, received, allowed: MOST_RECEIVED });
    }
    Ok(())
}

/// For every channel of an emitter those of the radar that it is added to.
fn channels_of(radar: &Radar, own: &Radar) -> Vec<Vec<usize>> {
    let of = |port: &Channel| {
        let same =
            |(_, channel): &(usize, &Channel)| (channel.receiver, channel.rx) == (port.receiver, port.rx);
        radar.channels.iter().enumerate().filter(same).map(|(place, _)| place).collect()
    };
    own.channels.iter().map(of).collect()
}

/// What pulses receive of what is emitted apart from them, in windows as those of `radar`.
pub(super) fn shares(generator: &PathGenerator, radar: &PathGenerator) -> Result<Shares, RadarError> {
    let pulses = generator.receiving_pulses();
    let at: Vec<u64> = spread_over(pulses, PULSES.min(pulses), 1).collect();
    let Shares { reached, received } = generator.shares_received(radar, &at)?;
    // None that were looked at are no share at all, and few of many may be the worst of all. What is as weak
    // as the filter rings is not worth any price.
    let all = received > 0.0 && pulses <= PULSES;
    let least = if all { LEAST_RECEIVED } else { 1.0 / PULSES as f64 };
    Ok(Shares { reached, received: received.max(least) })
}

/// How steadily a train radiates.
pub(super) fn steadiness(scene: &Scene, waveform: &dyn Waveform) -> f64 {
    waveform.steadiness(scene.radar.emissions.number(scene.pulses))
}

/// Pulses of a segment of what is emitted apart from them: no longer than blocks of emissions are planned,
/// and than grids have room for.
pub(super) fn segment_apart(
    plan: Option<&Plan>,
    scene: &Scene,
    generator: &PathGenerator,
    waveform: &dyn Waveform,
) -> u64 {
    let own = plan.map_or(1, |plan| plan.chosen.block_pulses(generator.hold_pulses())) as f64;
    // Emissions of a pulse, and those that its window receives beside these: where they are few, all of a
    // segment share nodes.
    let each = generator.mean_pulse_interval_s() / generator.mean_pri_s();
    let beside = (generator.emissions_received() as f64 - each.floor()).max(0.0);
    let most = if beside < 0.25 * own { (own - beside) / each } else { own / each } as u64;
    let grids = most_pulses(scene, generator, waveform);
    let room = if waveform.is_stream() { (grids as f64 / each) as u64 } else { grids };
    most.min(room).max(1)
}

/// A radar that receives continuously, as it radiates: its scene and its paths ([`sent_by`]). `None` for one
/// with windows.
///
/// # Errors
/// Pulses that overlap each other or crowd a block, faults of antennas and tracks.
pub(super) fn continuous(
    scene: &Scene,
    pulse_s: f64,
    tracks: &[PlatformTracks],
    drawn: Drawn<'_>,
) -> Result<Option<(Scene, PathGenerator)>, BuildErrors> {
    let radar = &scene.radar;
    if let (Some(sent), Some(transmitter)) = (&radar.sent, radar.transmitters.first()) {
        let is_stream = matches!(radar.waveform, Described::Stream { .. });
        check((&transmitter.name, sent), (pulse_s, is_stream), window_s(radar))?;
    }
    let until = |to_the_end| {
        let Some(own) = sent_by(scene, to_the_end) else { return Ok(None) };
        let made = PathGenerator::continuous(scene, &own, pulse_s, tracks.to_vec(), drawn)?;
        Ok::<_, BuildErrors>(Some((own, made)))
    };
    // Where tracks end before the last block does, until it begins.
    until(true).or_else(|_| until(false))
}

/// What receivers take of an emitter. Immutable, shared by all threads.
pub(crate) struct Overheard {
    name: String,
    /// By the receivers' carrier.
    waveform: Arc<dyn Waveform>,
    generator: PathGenerator,
    flown: OnceLock<PathGenerator>,
    engine: Arc<dyn EchoEngine>,
    channels: Vec<Vec<usize>>,
    window_samples: usize,
    plan: Option<Plan>,
    share_of_pulses: f64,
    /// Mean power of all pulses over that of the strongest.
    judged: f64,
}

impl Emitting {
    /// Plans what is made in segments of so many pulses, for a radar with these paths.
    ///
    /// # Errors
    /// What the fast echo cannot make.
    pub fn planned(
        self,
        radar: &PathGenerator,
        fidelity: &Fidelity,
        segment: u64,
        clocks: Option<Arc<RunningClocks>>,
    ) -> Result<Overheard, BuildErrors> {
        let Self { name, scene, generator, waveform, channels, offset_hz } = self;
        let shares = shares(&generator, radar)?;
        let judged = shares.received * steadiness(&scene, waveform.as_ref());
        let plan = match fidelity {
            Fidelity::Reference => None,
            Fidelity::Fast(asked) => {
                let seldom_db = 10.0 * judged.log10();
                let one_by_one = asked.node_pulses.filter(|pulses| *pulses <= 1);
                let error_db = asked.error_db - FINER_DB + seldom_db;
                let error_db =
                    if error_db <= ONE_BY_ONE_DB { error_db.clamp(FINEST_DB, EXACT_DB) } else { error_db };
                let asked =
                    Asked { node_pulses: one_by_one, variant: asked.variant, ..Asked::error_db(error_db) };
                Some(Chooser::new(&scene, &generator, &waveform, &asked)?.choose(&asked)?)
            }
        };
        // Delays turn the receiver's carrier: what the emitter's has more is in waveform and paths.
        let carrier_hz = scene.radar.carrier_hz - offset_hz;
        let received = Radar { carrier_hz, ..scene.radar.clone() };
        // A part of the radar's.
        let most = segment_apart(plan.as_ref(), &scene, &generator, waveform.as_ref());
        let segment = (1..=segment).rev().find(|n| segment.is_multiple_of(*n) && *n <= most).unwrap_or(1);
        let engine = engines::engine(plan.as_ref(), &received, Some(segment), &generator, &waveform)?;
        let generator = generator.with_clocks(clocks);
        let (flown, window_samples) = (OnceLock::new(), received.window.samples);
        Ok(Overheard {
            name,
            waveform,
            generator,
            flown,
            engine,
            channels,
            window_samples,
            plan,
            share_of_pulses: shares.reached,
            judged,
        })
    }
}

impl Overheard {
    /// Its name, the share of the pulses that receive it, and what it is made by; `None` for the reference.
    pub fn summary(&self) -> (&str, f64, Option<&Plan>) {
        (&self.name, self.share_of_pulses, self.plan.as_ref())
    }

    /// What it radiates, by the receivers' carrier.
    pub fn waveform(&self) -> &dyn Waveform {
        self.waveform.as_ref()
    }

    /// Its error over what a pulse has of it on average, a ratio of powers; 0 of the reference.
    pub fn error(&self) -> f64 {
        self.plan.map_or(0.0, |plan| plan.prediction.total() / self.judged)
    }

    /// Grids of one worker, bytes.
    pub fn grid_bytes(&self) -> u64 {
        self.engine.grid_bytes()
    }

    /// Goes by other tracks than it was prepared on.
    pub fn fly(&self, tracks: &[PlatformTracks]) {
        let _ = self.flown.set(self.generator.on_tracks(tracks.to_vec()));
    }

    fn generator(&self) -> &PathGenerator {
        self.flown.get().unwrap_or(&self.generator)
    }

    /// What adds it in one thread, to spectra of so many bins.
    pub fn listener(&self, fft_len: usize) -> Box<dyn Listen + '_> {
        let own_len = self.engine.fft_len();
        Box::new(Listener {
            of: self,
            worker: self.engine.worker(self.generator()),
            desk: Desk::new(self.generator(), own_len),
            lens: [own_len, fft_len],
            refit: Refit::new(self.window_samples, own_len, fft_len),
        })
    }
}

/// Adds an emitter to the pulses of one thread.
struct Listener<'f> {
    of: &'f Overheard,
    worker: Box<dyn EchoWorker + 'f>,
    desk: Desk<'f>,
    /// Bins of its spectra and of the radar's.
    lens: [usize; 2],
    refit: Option<Refit>,
}

impl Listen for Listener<'_> {
    fn take_off(&mut self) {
        self.desk.paths = self.of.generator();
    }

    fn add(
        &mut self,
        pulse: &mut Pulse,
        spectrum: &mut [Complex64],
        costs: &mut Costs,
    ) -> Result<(), PulseError> {
        self.worker.fill(pulse.index, pulse, &mut self.desk)?;
        let [own_len, fft_len] = self.lens;
        let of_channels = self.desk.spectrum.chunks_exact(own_len).zip(&self.of.channels);
        for (own, channels) in of_channels.filter(|(own, _)| own.iter().any(|bin| *bin != Complex64::ZERO)) {
            let own = match &mut self.refit {
                Some(refit) => refit.refitted(own),
                None => own,
            };
            for channel in channels {
                let to = &mut spectrum[channel * fft_len..][..fft_len];
                to.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        costs.lap(Stage::Others);
        Ok(())
    }
}
