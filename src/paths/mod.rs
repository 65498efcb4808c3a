//! From the scene to the scatterer paths of every receive window.
//!
//! The window of pulse `n` opens `w` seconds after its emission `t_n` and lasts `N / fs`. It receives every
//! emission `e` of the run whose echo overlaps it, not only its own: where the delay is longer than the
//! pulse repetition interval (spaceborne, or the direct path of the next pulse) several pulses are in
//! the air. A scatterer path of emission `e` with delay `tau` is kept when
//!
//! `[t_e - t_n + tau, t_e - t_n + tau + T_p]` touches `[w - 32/fs, w + (N + 32)/fs]`
//!
//! (`T_p` the pulse length; 32 samples is where the receive filter's response has died out). Emissions
//! are searched between bounds on their delays: those of emission `n`, widened by the fastest change of
//! delay, `(|v_T| + |v_R| + 2 |v_s| + 1000 m/s) / c`, the last term for manoeuvres.
//!
//! The sea, if there is one, contributes a scatterer path for every facet that the window receives and that
//! returns anything. It does not count for [`flags::OUTSIDE_WINDOW`]: a patch that reaches beyond the window
//! is the rule.
//!
//! Each emission has its own geometry: platforms, pointing and transmit polarisation at `t_e`, the
//! receive antenna at reception. When polarisations alternate, a channel receives an emission only if that
//! carries its transmit polarisation. Amplitudes are those of [`crate::radar::link`]. Scatterer paths
//! without amplitude in any channel (behind the antenna, in an exact null) are left out.
//!
//! The opening of the window with `Gate::Follow` is the exact light time over the aim point between the
//! *known* positions of the receiver and of the first transmitter that it hears, less the lead; it is not
//! rounded to samples. Every receiver has its own window ([`Radar::window_leads`]), and of an emission a pair
//! receives what reaches into that of its receiver.
//!
//! [`PathGenerator::pulse`] depends on nothing but the pulse's index, and does not allocate once the
//! scatterer path list has its room.
//!
//! ```
//! use nereus::frames::{Earth, Point, Rotation, SceneFrame, Vector};
//! use nereus::motion::{PlatformTracks, track::Track};
//! use nereus::pulse::Pulse;
//! use nereus::paths::PathGenerator;
//! use nereus::paths::list::ScattererPaths;
//! use nereus::scene::{Radar, Scene, Target, radar::*};
//! use nereus::time::{PulseTimes, TimeTag};
//!
//! let mount = AntennaMount {
//!     platform: 0,
//!     lever_arm: Vector::ZERO,
//!     of_array: Vector::ZERO,
//!     pattern: Pattern::Isotropic { gain_dbi: 30.0 },
//!     pointing: Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 },
//!     ports: PortErrors::default(),
//! };
//! let scene = Scene {
//!     frame: SceneFrame::plain(Earth::Flat),
//!     start: TimeTag::default(),
//!     pulses: 10,
//!     seed: 1,
//!     platforms: vec!["tower".into()],
//!     radar: Radar {
//!         transmitters: vec![Transmitter { name: "tx".into(), power_w: 1.0, antenna: mount.clone() }],
//!         receivers: vec![Receiver { name: "rx".into(), antenna: mount, gate: None }],
//!         channels: vec![Channel {
//!             name: "HH".into(), transmitter: 0, receiver: 0, tx: Polarisation::H, rx: Polarisation::H,
//!         }],
//!         ..Radar::new(
//!             10e9,
//!             100e6,
//!             Waveform::Lfm { bandwidth_hz: 60e6, duration_s: 0.333e-6, sweep: Sweep::Up },
//!             PulseTimes::uniform(222.0)?,
//!             Window { samples: 256, gate: Gate::Fixed { start_s: 19.5e-6 } },
//!         )
//!     },
//!     sea: None,
//!     ships: Vec::new(),
//!     targets: vec![
//!         Target::new("buoy", Point::new(3000.0, 0.0, 0.0), Vector::ZERO, Target::sphere(1.0)),
//!     ],
//! };
//! let level = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
//! let track = Track::fixed(Point::new(0.0, 0.0, 50.0), level);
//! let tracks = vec![PlatformTracks { truth: track.clone(), reported: track }];
//! let generator = PathGenerator::new(&scene, 0.333e-6, tracks)?;
//! let layout = scene.radar.layout(1, 1);
//! let (mut workspace, mut paths) = (generator.workspace(), ScattererPaths::new(1, 1, 1));
//! let mut record = Pulse::new(&layout);
//! generator.pulse(3, &mut workspace, &mut paths, &mut record)?;
//! assert_eq!(paths.len(), 1);
//! assert!((record.target_delay_s[0] * 299_792_458.0 - 2.0 * 3000f64.hypot(50.0)).abs() < 1e-8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod apart;
mod append;
mod aspect;
mod breaking;
pub mod drops;
mod facets;
mod far;
mod hearing;
mod heave;
mod hidden;
mod lifted;
mod multipath;
mod nodes;
mod panels;
mod sea;
mod ships;
mod emission;
mod kept;
pub mod list;
mod own_clutter;
mod partition;
mod patch_run;
mod phasors;
pub mod snapshot;
mod received;
pub mod spikes;
mod survey;
pub mod block;
mod truth;
mod visibility;
mod waves;
mod with_sea;

use std::sync::Arc;

use num_complex::Complex64;

use crate::frames::{Enu, Point, SceneFrame};
use crate::motion::PlatformTracks;
use crate::motion::pointing::Surroundings;
use crate::paths::apart::Apart;
use crate::paths::aspect::Aspect;
use crate::paths::drops::RainPlan;
use crate::paths::emission::{Circumstances, Emission, TrackFailure};
pub(crate) use crate::paths::far::FAR_PULSES;
use crate::paths::far::FarPlan;
use crate::paths::hearing::Hearing;
use crate::paths::heave::Heave;
use crate::paths::hidden::Hills;
use crate::paths::list::ScattererPaths;
use crate::paths::multipath::{Image, Mirror};
use crate::paths::panels::ShipWork;
use crate::paths::ships::Ships;
use crate::pulse::costs::{Costs, Stage};
use crate::pulse::{Pulse, flags};
use crate::radar::antenna::Antenna;
use crate::radar::clock::RunningClocks;
use crate::radar::fault::{RadarError, RadarFault, check_numbers, check_references, mounts};
use crate::radar::link::Link;
use crate::scene::radar::{Aim, Pair, Polarisation};
use crate::scene::{Radar, Scene, Target};
use crate::sea::realise::realise;
use crate::time::TimeTag;

use crate::radar::window::{GUARD_SAMPLES, Window};
pub(crate) use apart::{Shares, scene_of, sent_by};
use facets::Reception;
use received::InAir;
pub use received::{MOST_RECEIVED, Received};
pub(crate) use sea::Drawn;
use sea::{SeaFailure, SeaPlan, SeaWork};
pub use survey::BeyondHorizon;

/// Change of the closing speed that a manoeuvre may bring while pulses are in the air, m/s.
const MANOEUVRE_MPS: f64 = 1000.0;
/// Pulses of the run at which its longest delay is sought.
const CHECKED_PULSES: u64 = 32;

/// What one transmitter-receiver pair needs.
#[derive(Clone, Debug)]
struct PairPlan {
    pair: Pair,
    link: Link,
    /// Its window.
    window: usize,
    /// Channels on this pair: index, transmit and receive polarisation.
    channels: Vec<(usize, Polarisation, Polarisation)>,
}

impl PairPlan {
    /// Places of both antennas among all, of which so many transmit.
    fn ends(&self, transmitters: usize) -> [usize; 2] {
        [self.pair.transmitter, transmitters + self.pair.receiver]
    }

    /// Whether an emission reaches any channel of the pair.
    fn receives(&self, tx_pol: Option<Polarisation>) -> bool {
        tx_pol.is_none_or(|port| self.channels.iter().any(|&(_, tx, _)| tx == port))
    }
}

/// What every pair needs; `channel_pairs` are the pairs of the channels.
fn pair_plans(radar: &Radar, pairs: &[Pair], windows: usize, channel_pairs: &[usize]) -> Vec<PairPlan> {
    pairs
        .iter()
        .enumerate()
        .map(|(index, &pair)| PairPlan {
            pair,
            link: Link::of(radar, pair.transmitter),
            window: Radar::window_of(pair.receiver, windows),
            channels: radar
                .channels
                .iter()
                .enumerate()
                .filter(|&(channel, _)| channel_pairs[channel] == index)
                .map(|(channel, row)| (channel, row.tx, row.rx))
                .collect(),
        })
        .collect()
}

/// Makes the scatterer paths and the truth of any pulse of a run.
#[derive(Clone, Debug)]
pub struct PathGenerator {
    frame: SceneFrame,
    start: TimeTag,
    pulses: u64,
    platforms: Vec<String>,
    radar: Radar,
    targets: Vec<Target>,
    /// Of targets whose cross section depends on the aspect; empty where there are none.
    aspects: Vec<Option<Aspect>>,
    /// What lifts targets that float; empty where none does.
    heaves: Arc<Vec<Option<Heave>>>,
    /// Land that hides targets and ships.
    hills: Option<Arc<Hills>>,
    /// Paths of targets by the sea, and what reflects them; empty where nothing does.
    images: Vec<Image>,
    mirror: Option<Mirror>,
    /// Ships that echo by their mesh.
    ships: Ships,
    rain: Option<RainPlan>,
    /// Whether there is a sea beyond the patch, and how it is made.
    scene_has_far_sea: bool,
    far: Option<FarPlan>,
    seed: u64,
    pulse_length_s: f64,
    tracks: Vec<PlatformTracks>,
    /// Transmitters first.
    antennas: Vec<Antenna>,
    pairs: Vec<Pair>,
    /// Antennas of every pair.
    ends: Vec<[usize; 2]>,
    plans: Vec<PairPlan>,
    /// Pairs by which windows are found ([`Radar::window_leads`]).
    leads: Vec<Pair>,
    channel_pairs: Vec<usize>,
    fastest_target_mps: f64,
    axes_span_s: f64,
    guard_samples: usize,
    in_air: InAir,
    hold_pulses: Option<u64>,
    /// After how many pulses beams jump.
    dwells: Vec<u64>,
    /// Pulses, where these are not those emitted.
    apart: Option<Apart>,
    sea: Option<Arc<SeaPlan>>,
    clocks: Option<Arc<RunningClocks>>,
    /// Platforms by whose reports something is aimed, and the servo lag.
    report_steered: Vec<(usize, f64)>,
}

/// Buffers of [`PathGenerator::pulse`]; one per thread.
#[derive(Clone)]
pub struct Workspace {
    own: Emission,
    other: Emission,
    stretch: spikes::stretch::Buffers,
    amplitude: Vec<Complex64>,
    ships: ShipWork,
    sea: Option<SeaWork>,
    far: Option<far::Work>,
    places: Vec<Point<Enu>>,
    /// Of the pulse at hand.
    windows: Vec<Window>,
    /// Of the emission in the middle of a block.
    hearing: Hearing,
    /// What this thread has spent.
    pub costs: Costs,
}

impl PathGenerator {
    /// Prepares a scene: reads pattern files and checks that the tracks cover the run, from the first
    /// emission (less the servo lag) to the last one and its longest light time. `pulse_length_s` is the
    /// length of the waveform; `tracks` stand in the order of `scene.platforms`.
    ///
    /// # Errors
    /// All that is wrong with the radar and its references, pattern files that cannot be read, tracks that do
    /// not cover the run.
    pub fn new(scene: &Scene, pulse_length_s: f64, tracks: Vec<PlatformTracks>) -> Result<Self, RadarError> {
        Self::on(scene, pulse_length_s, tracks, &|sea| realise(sea, scene.seed))
    }

    /// The same on a sea that may have been drawn before.
    pub(crate) fn on(
        scene: &Scene,
        pulse_length_s: f64,
        tracks: Vec<PlatformTracks>,
        drawn: Drawn<'_>,
    ) -> Result<Self, RadarError> {
        let radar = &scene.radar;
        let mut faults = Vec::new();
        check_numbers(radar, pulse_length_s, &mut faults);
        check_references(scene, tracks.len(), &mut faults);
        let antennas = open_antennas(radar, &mut faults);
        let mut targets = scene.targets.clone();
        let aspects = aspect::open(&mut targets, &mut faults);
        if !faults.is_empty() {
            return Err(RadarError::Faults(faults));
        }
        let pairs = radar.pairs();
        let channel_pairs: Vec<usize> = radar
            .channels
            .iter()
            .filter_map(|channel| {
                let wanted = Pair { transmitter: channel.transmitter, receiver: channel.receiver };
                pairs.iter().position(|&pair| pair == wanted)
            })
            .collect();
        let leads = radar.window_leads();
        let plans = pair_plans(radar, &pairs, leads.len(), &channel_pairs);
        let fastest_target_mps = scene.targets.iter().map(Target::fastest_mps).fold(0.0, f64::max);
        let mut built = Self {
            frame: scene.frame,
            start: scene.start,
            pulses: scene.pulses,
            platforms: scene.platforms.clone(),
            radar: radar.clone(),
            targets,
            aspects,
            heaves: Arc::default(),
            hills: None,
            images: Vec::new(),
            mirror: None,
            ships: Ships::default(),
            rain: None,
            scene_has_far_sea: scene.sea.as_ref().is_some_and(|sea| sea.far.is_some()),
            far: None,
            seed: scene.seed,
            pulse_length_s,
            tracks,
            antennas,
            ends: pairs
                .iter()
                .map(|pair| [pair.transmitter, radar.transmitters.len() + pair.receiver])
                .collect(),
            pairs,
            plans,
            leads,
            channel_pairs,
            fastest_target_mps,
            axes_span_s: 0.0,
            guard_samples: GUARD_SAMPLES,
            in_air: InAir::default(),
            hold_pulses: None,
            dwells: partition::dwells(&scene.radar),
            apart: None,
            sea: None,
            clocks: None,
            report_steered: partition::report_steered(radar),
        };
        let counts = [radar.transmitters.len(), radar.receivers.len()];
        built.check_cover(0.0, &mut faults);
        if let (Some(sea), true) = (&scene.sea, faults.is_empty() && built.pulses > 0) {
            built.plan_sea(scene, sea, drawn, counts, &mut faults)?;
        }
        if faults.is_empty() && built.pulses > 0 {
            if built.sea.is_none() {
                built.ships = Ships::new(&scene.ships, counts, None);
            }
            built.fastest_target_mps = built.fastest_target_mps.max(built.ships.fastest_mps());
        }
        if faults.is_empty() {
            match built.longest_delay_s() {
                Ok(longest_s) => built.check_cover(longest_s, &mut faults),
                Err(error) => return Err(error),
            }
        }
        if !faults.is_empty() {
            return Err(RadarError::Faults(faults));
        }
        built.axes_span_s = built.longest_delay_s()?;
        built.guard_samples = built.find_guard_samples()?;
        built.in_air = built.find_in_air()?;
        built.let_it_rain(scene)?;
        if built.pulses > 0 {
            built.plan_far_sea(scene)?;
        }
        Ok(built)
    }

    /// The same with clock errors: windows open by them.
    pub fn with_clocks(self, clocks: Option<Arc<RunningClocks>>) -> Self {
        Self { clocks, ..self }
    }

    /// The same on other tracks, in the order of the platforms, where those that it was prepared with were a
    /// nominal trajectory.
    pub fn on_tracks(&self, tracks: Vec<PlatformTracks>) -> Self {
        let mut flown = Self { tracks, ..self.clone() };
        // What crests and land hide was found from the others.
        flown.heaves = Arc::new(flown.lifted_by(flown.sea.as_deref()));
        flown.hills = flown.hidden_by(flown.sea.as_deref()).map(Arc::new);
        flown.ships = flown.ships.renewed();
        flown.rain = flown.rain.as_ref().map(RainPlan::renewed);
        flown.far = flown.far.as_ref().map(FarPlan::renewed);
        flown
    }

    /// The pair of each channel.
    pub fn channel_pairs(&self) -> &[usize] {
        &self.channel_pairs
    }

    /// The transmitter-receiver pairs, in the order of [`ScattererPaths::delay_s`].
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// The longest delay found when the run was prepared (at a few dozen instants of it), s: how far
    /// after the last emission tracks are evaluated.
    pub fn light_time_s(&self) -> f64 {
        self.axes_span_s
    }

    /// Buffers for [`Self::pulse`].
    pub fn workspace(&self) -> Workspace {
        let amplitude = vec![Complex64::ZERO; self.radar.channels.len()];
        // The sea's own buffers are large, and blocks of pulses do without: they are made when first asked
        // for.
        let [own, other] = [(); 2].map(|()| Emission::default());
        let places = Vec::with_capacity(self.antennas.len());
        let (stretch, ships) = (Default::default(), self.ship_work());
        let windows = Vec::with_capacity(self.windows());
        let (hearing, costs) = (Hearing::default(), Costs::default());
        let (sea, far) = (None, None);
        Workspace { own, other, stretch, amplitude, ships, sea, far, places, windows, hearing, costs }
    }

    /// Fills `paths` with all that the window of pulse `index` receives, and index, time, window start,
    /// transmit polarisation, navigation, phase centres, target truth and flags of `record` (its samples
    /// are left alone; flags are replaced, with [`flags::OUTSIDE_WINDOW`] when an echo of this very
    /// emission lies partly or wholly outside the window; the direct path counts as any other echo). Of
    /// an emitter only `paths`: the record has its windows.
    ///
    /// # Errors
    /// A pulse outside of the run, or that its tracks do not cover; a sea or shadows that cannot be found at
    /// it.
    pub fn pulse(
        &self,
        index: u64,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
        record: &mut Pulse,
    ) -> Result<(), RadarError> {
        if index >= self.receiving_pulses() {
            return Err(RadarError::NoSuchPulse { index, pulses: self.receiving_pulses() });
        }
        paths.clear();
        if self.is_apart() {
            self.fill_record_apart(index, workspace, record)?;
            self.append_received(index, record.window_starts_s(), workspace, paths)?;
            workspace.costs.lap(Stage::ScattererPaths);
            return Ok(());
        }
        self.evaluate(index, &mut workspace.own)?;
        self.fill_record(index, &workspace.own, record)?;
        let mut windows = std::mem::take(&mut workspace.windows);
        self.recorded_windows(record, &mut windows);
        let made = self.append_all(index, &windows, workspace, paths);
        workspace.windows = windows;
        if made? {
            record.flags |= flags::OUTSIDE_WINDOW;
        }
        workspace.costs.lap(Stage::ScattererPaths);
        Ok(())
    }

    /// What the windows of pulse `index` meet of emission `emitted`.
    fn reception<'a>(
        &'a self,
        index: u64,
        emitted: u64,
        emission: &'a Emission,
        windows: &'a [Window],
    ) -> Reception<'a> {
        Reception {
            surroundings: self.surroundings(),
            radar: &self.radar,
            antennas: &self.antennas,
            plans: &self.plans,
            emission,
            t: self.radar.emissions.emission(self.start, emitted),
            elapsed_s: self.radar.emissions.elapsed_s(emitted),
            offset_s: self.offset_s(index, emitted),
            tx_pol: self.radar.tx_polarisation.of_pulse(emitted),
            axes_span_s: self.axes_span_s,
            windows,
        }
    }

    /// The same of its own emission, in all polarisations: what a node has, whichever pulses fill from it.
    fn reception_of_all<'a>(
        &'a self,
        index: u64,
        emission: &'a Emission,
        windows: &'a [Window],
    ) -> Reception<'a> {
        Reception { tx_pol: None, offset_s: 0.0, ..self.reception(index, index, emission, windows) }
    }

    /// The buffers of the sea, made unless they are there.
    fn sea_work<'a>(&self, sea: &SeaPlan, work: &'a mut Option<SeaWork>) -> Option<&'a mut SeaWork> {
        if work.is_none() {
            *work = sea.work(self.pairs.len(), self.radar.channels.len());
        }
        work.as_mut()
    }

    fn sea_error(&self, index: u64, failure: SeaFailure) -> RadarError {
        match failure {
            SeaFailure::Track(failure) => self.track_error(index, failure),
            SeaFailure::Sea(source) => RadarError::Sea { index, source },
            SeaFailure::Shadow(source) => RadarError::Shadow { index, source },
        }
    }

    /// Whether there is a sea whose patch moves.
    pub fn follows(&self) -> bool {
        self.sea.as_ref().is_some_and(|sea| sea.moves())
    }

    /// Facets of the patch, if there is a sea.
    pub fn facets(&self) -> usize {
        self.sea.as_ref().map_or(0, |sea| sea.patch.len())
    }

    fn surroundings(&self) -> Surroundings<'_> {
        Surroundings { tracks: &self.tracks, frame: &self.frame, start: self.start }
    }

    fn circumstances(&self) -> Circumstances<'_> {
        Circumstances {
            surroundings: self.surroundings(),
            radar: &self.radar,
            pairs: &self.pairs,
            targets: &self.targets,
            aspects: &self.aspects,
            heaves: &self.heaves,
            hills: self.hills.as_deref(),
            images: &self.images,
            mirror: self.mirror.as_ref(),
            seed: self.seed,
            axes_span_s: self.axes_span_s,
        }
    }

    fn evaluate(&self, index: u64, emission: &mut Emission) -> Result<(), RadarError> {
        let t = self.radar.emissions.emission(self.start, index);
        let elapsed_s = self.radar.emissions.elapsed_s(index);
        emission
            .evaluate(&self.circumstances(), index, t, elapsed_s)
            .map_err(|failure| self.track_error(index, failure))
    }

    fn track_error(&self, index: u64, failure: TrackFailure) -> RadarError {
        let TrackFailure { platform, which, source } = failure;
        RadarError::Track { index, platform: self.platforms[platform].clone(), which, source }
    }
}

/// The platform beside which an aim point lies.
fn beside(aim: &Aim) -> Option<usize> {
    match aim {
        Aim::Beside { platform, .. } => Some(*platform),
        Aim::Point { .. } => None,
    }
}

fn open_antennas(radar: &Radar, faults: &mut Vec<RadarFault>) -> Vec<Antenna> {
    let mut antennas = Vec::new();
    for (name, mount) in mounts(radar) {
        match Antenna::open(&mount.pattern, radar.wavelength_m()) {
            Ok(antenna) => antennas.push(antenna),
            Err(source) => faults.push(RadarFault::Pattern { antenna: name.to_owned(), source }),
        }
    }
    antennas
}
