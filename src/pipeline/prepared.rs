//! A run with what its files hold: each is read once, and shared by all that build, check or measure the run.
//!
//! Tracks are loaded first; waveform, sea and hulls when somebody asks for them, so that each fault is met
//! where it always was. [`Prepared::at`] says where antennas, window and patch are at a pulse, without the
//! motion during the echo.

use std::sync::{Arc, OnceLock};

use super::fault::{BuildError, BuildErrors};
use super::hull_scatterers::with_scatterers;
use super::tracks::{TrackNote, flight, tracks};
use crate::config::Run;
use crate::frames::{Antenna, Enu, Point, Rotation, Vector};
use crate::motion::PlatformTracks;
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::motion::track::{State, TrackError};
use crate::radar::waveform::{self, Waveform, WaveformError};
use crate::scene::radar::{Aim, AimFrom, AntennaMount, Gate, Pair};
use crate::scene::sea::{PatchPlace, Sea};
use crate::scene::{Patch, Radar, Scene};
use crate::sea::fleet::FleetErrors;
use crate::sea::realise::{RealiseError, Realised, realise};
use crate::time::TimeTag;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Files of a scene beside its tracks. What cannot be read is tried again by the next one who asks.
#[derive(Default)]
pub(super) struct Files {
    waveform: Arc<OnceLock<Arc<dyn Waveform>>>,
    sea: Arc<OnceLock<Realised>>,
    /// The scene with what its ships carry; `None` where they carry nothing.
    laden: OnceLock<Option<Scene>>,
}

/// What stands in a cell, made where it is empty.
fn once<T, E>(cell: &OnceLock<T>, make: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
    if let Some(known) = cell.get() {
        return Ok(known);
    }
    let made = make()?;
    Ok(cell.get_or_init(|| made))
}

impl Files {
    /// The waveform of the scene.
    pub(super) fn waveform(&self, scene: &Scene) -> Result<&Arc<dyn Waveform>, WaveformError> {
        once(&self.waveform, || waveform::from_description(&scene.radar.waveform))
    }

    /// The sea of the scene, drawn or read. Copies share it.
    pub(super) fn sea(&self, sea: &Sea, seed: u64) -> Result<&Realised, RealiseError> {
        once(&self.sea, || realise(sea, seed))
    }

    /// The scene with the scatterers and panels of its ships.
    pub(super) fn laden<'a>(&'a self, scene: &'a Scene) -> Result<&'a Scene, FleetErrors> {
        Ok(once(&self.laden, || with_scatterers(scene))?.as_ref().unwrap_or(scene))
    }
}

/// What the sea of a scene follows from when it is drawn.
fn drawn(scene: &Scene) -> impl PartialEq {
    (scene.seed, scene.sea.as_ref().map(|sea| (&sea.water, &sea.realisation, &sea.patch)))
}

/// A run with its tracks, waveform and sea.
pub struct Prepared {
    run: Run,
    tracks: Vec<PlatformTracks>,
    notes: Vec<TrackNote>,
    files: Files,
}

impl Prepared {
    /// Loads the tracks of a run.
    ///
    /// # Errors
    /// The faults of all tracks.
    pub fn of(run: &Run) -> Result<Self, BuildErrors> {
        let (tracks, notes) = tracks(&run.nav, &run.scene)?;
        Ok(Self { run: run.clone(), tracks, notes, files: Files::default() })
    }

    /// Another run. Tracks, waveform and sea are shared where the two have the same.
    ///
    /// # Errors
    /// The faults of all tracks.
    pub fn again(&self, run: &Run) -> Result<Self, BuildErrors> {
        let (scene, other) = (&self.run.scene, &run.scene);
        let (tracks, notes) = match flight(&self.run) == flight(run) {
            true => (self.tracks.clone(), self.notes.clone()),
            false => tracks(&run.nav, other)?,
        };
        let mut files = Files::default();
        if scene.radar.waveform == other.radar.waveform {
            files.waveform = Arc::clone(&self.files.waveform);
        }
        if drawn(scene) == drawn(other) {
            files.sea = Arc::clone(&self.files.sea);
        }
        Ok(Self { run: run.clone(), tracks, notes, files })
    }

    /// The run.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// Its scene.
    pub fn scene(&self) -> &Scene {
        &self.run.scene
    }

    /// Its tracks without changes of reports, in the order of its platforms.
    pub fn tracks(&self) -> &[PlatformTracks] {
        &self.tracks
    }

    /// How the tracks were made.
    pub fn notes(&self) -> &[TrackNote] {
        &self.notes
    }

    /// Its waveform.
    ///
    /// # Errors
    /// A file that cannot be read, or a pulse out of range.
    pub fn waveform(&self) -> Result<&Arc<dyn Waveform>, WaveformError> {
        self.files.waveform(&self.run.scene)
    }

    /// Its sea, drawn or read; `None` without one.
    ///
    /// # Errors
    /// A wind, spectrum or surface out of range, or a state that cannot be read.
    pub fn sea(&self) -> Result<Option<(&Sea, &Realised)>, RealiseError> {
        let Some(sea) = &self.run.scene.sea else { return Ok(None) };
        Ok(Some((sea, self.files.sea(sea, self.run.scene.seed)?)))
    }

    pub(super) fn files(&self) -> &Files {
        &self.files
    }

    /// What servos and the window look at.
    fn surroundings(&self) -> Surroundings<'_> {
        let Scene { frame, start, .. } = &self.run.scene;
        Surroundings { tracks: &self.tracks, frame, start: *start }
    }

    /// The run at a pulse.
    pub fn at(&self, pulse: u64) -> Moment<'_> {
        let Scene { start, radar, .. } = &self.run.scene;
        let elapsed_s = radar.emissions.interval_s(0, pulse);
        Moment { prepared: self, pulse, elapsed_s, time: start.plus(elapsed_s) }
    }

    /// The run at pulses spread over it, `most` at most, its ends among them.
    pub fn spread(&self, most: u64) -> impl Iterator<Item = Moment<'_>> {
        let last = self.run.scene.pulses.saturating_sub(1);
        let count = most.min(self.run.scene.pulses);
        // In 128 bits: pulses of long runs times the instants.
        let at =
            move |step: u64| (u128::from(last) * u128::from(step) / u128::from((count - 1).max(1))) as u64;
        (0..count).map(move |step| self.at(at(step)))
    }

    /// The patch of its sea at a time, s after pulse 0.
    ///
    /// # Errors
    /// Tracks that do not reach to the time.
    pub fn patch_at(&self, sea: &Sea, time_s: f64) -> Result<Patch, BuildErrors> {
        patch(sea, |aim, aim_from| {
            let aimed = self.surroundings().aim_point(aim, aim_from, self.run.scene.start.plus(time_s));
            let platform = || self.run.scene.platforms[beside(aim)].clone();
            aimed.map_err(|source| BuildError::Away { platform: platform(), time_s, source })
        })
        .map_err(BuildErrors::from)
    }
}

/// The platform beside which an aim point lies; of any other there is nothing to lose.
fn beside(aim: &Aim) -> usize {
    if let Aim::Beside { platform, .. } = aim { *platform } else { 0 }
}

/// The patch of a run at a time, s after pulse 0. Of one that stays no track is read.
///
/// # Errors
/// Tracks that cannot be loaded, or do not reach to the time.
pub fn patch_at(run: &Run, sea: &Sea, time_s: f64) -> Result<Patch, BuildErrors> {
    match sea.place {
        PatchPlace::Fixed => Ok(sea.patch),
        PatchPlace::Follow { .. } => Prepared::of(run)?.patch_at(sea, time_s),
    }
}

/// The patch of a sea that follows what `aimed` finds.
fn patch<E>(
    sea: &Sea,
    aimed: impl FnOnce(&Aim, AimFrom) -> Result<(Point<Enu>, Vector<Enu>), E>,
) -> Result<Patch, E> {
    let PatchPlace::Follow { aim, aim_from } = &sea.place else { return Ok(sea.patch) };
    let [x_m, y_m, _] = aimed(aim, *aim_from)?.0.to_array();
    Ok(sea.patch.centred_at([x_m, y_m]))
}

/// A run at the emission of a pulse. Its functions fail where a track does not reach to that.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    prepared: &'a Prepared,
    /// The pulse.
    pub pulse: u64,
    /// Its emission after that of pulse 0, s.
    pub elapsed_s: f64,
    /// Its emission.
    pub time: TimeTag,
}

impl<'a> Moment<'a> {
    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        &self.prepared.run.scene
    }

    /// The fault of a track of a platform, which does not reach to this pulse.
    fn lost(&self, platform: usize) -> impl FnOnce(TrackError) -> BuildError {
        let (platform, pulse) = (self.scene().platforms[platform].clone(), self.pulse);
        move |source| BuildError::Lost { platform, pulse, source }
    }

    /// The true state of the platform that carries an antenna.
    fn state(&self, mount: &AntennaMount) -> Result<State, BuildError> {
        let track = &self.prepared.tracks[mount.platform].truth;
        track.state(self.time).map_err(self.lost(mount.platform))
    }

    /// The phase centre of an antenna.
    pub fn phase_centre(&self, mount: &AntennaMount) -> Result<PhaseCentre, BuildError> {
        Ok(PhaseCentre::of(&self.state(mount)?, mount.lever_arm))
    }

    /// Phase centre and axes of an antenna.
    pub fn antenna(&self, mount: &AntennaMount) -> Result<(PhaseCentre, Rotation<Antenna, Enu>), BuildError> {
        let state = self.state(mount)?;
        let axes = self.prepared.surroundings().antenna_frame(mount, state.attitude, [self.time; 2]);
        Ok((PhaseCentre::of(&state, mount.lever_arm), axes.map_err(self.lost(mount.platform))?))
    }

    /// Phase centres of the antennas of a pair, transmitter first.
    pub fn ends(&self, pair: Pair) -> Result<[Point<Enu>; 2], BuildError> {
        let radar = &self.scene().radar;
        let transmitter = self.phase_centre(&radar.transmitters[pair.transmitter].antenna)?;
        let receiver = self.phase_centre(&radar.receivers[pair.receiver].antenna)?;
        Ok([transmitter.position, receiver.position])
    }

    /// When the windows of some pairs open after the emission, s.
    pub fn open_s(&self, pairs: &[Pair]) -> Result<Vec<f64>, BuildError> {
        let radar = &self.scene().radar;
        let leads = radar.window_leads();
        let opens_s = leads.iter().map(|lead| self.opens_s(*lead)).collect::<Result<Vec<f64>, _>>()?;
        let of = |pair: &Pair| opens_s.get(Radar::window_of(pair.receiver, leads.len())).copied();
        Ok(pairs.iter().filter_map(of).collect())
    }

    /// When a window opens after the emission, by the ends of a pair, s.
    fn opens_s(&self, pair: Pair) -> Result<f64, BuildError> {
        match self.scene().radar.gate(pair.receiver) {
            Gate::Fixed { start_s } => Ok(*start_s),
            Gate::Follow { aim, lead_s, aim_from } => {
                let (point, _) = self.aim_point(aim, *aim_from)?;
                let path_m: f64 = self.ends(pair)?.iter().map(|end| (*end - point).norm()).sum();
                Ok(path_m / SPEED_OF_LIGHT_MPS - lead_s)
            }
        }
    }

    /// The patch of a sea.
    pub fn patch(&self, sea: &Sea) -> Result<Patch, BuildError> {
        patch(sea, |aim, aim_from| self.aim_point(aim, aim_from))
    }

    fn aim_point(&self, aim: &Aim, aim_from: AimFrom) -> Result<(Point<Enu>, Vector<Enu>), BuildError> {
        let aimed = self.prepared.surroundings().aim_point(aim, aim_from, self.time);
        aimed.map_err(self.lost(beside(aim)))
    }
}
