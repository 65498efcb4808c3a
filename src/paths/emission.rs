//! One emission: where every platform, phase centre and antenna axis is, and every path it takes.
//!
//! Platforms and transmit antennas are taken at the emission `t`, receive antennas at the reception
//! `t + tau`: their axes are evaluated at `t` and at `t + T`, `T` about the longest delay of the run, and
//! interpolated linearly in `tau / T`. What that leaves of a turn `w T` is `(w T)^2 / 8`: 3e-10 rad for
//! 0.01 rad/s and 5 ms.

use glam::{DMat3, DVec3};

use crate::frames::{self, Enu, Point, Rotation, Vector};
use crate::geometry::light_time::{LightTime, Path, bistatic, direct};
use crate::motion::pointing::{PhaseCentre, Surroundings};
use crate::motion::track::{State, TrackError};
use crate::paths::aspect::Aspect;
use crate::paths::heave::Heave;
use crate::paths::hidden::Hills;
use crate::paths::multipath::{Bounce, Image, Mirror};
use crate::radar::fault::TrackUse;
use crate::radar::polarisation::{Axes, PortBasis};
use crate::scattering::target::{Scatterer, fluctuation};
use crate::scene::Target;
use crate::scene::radar::{AntennaMount, Pair, PolarisationBasis, Radar};
use crate::scene::target::Swerling;
use crate::time::TimeTag;

/// What an emission depends on.
pub(super) struct Circumstances<'a> {
    pub surroundings: Surroundings<'a>,
    pub radar: &'a Radar,
    pub pairs: &'a [Pair],
    pub targets: &'a [Target],
    /// Of targets whose cross section depends on the aspect; empty where there are none.
    pub aspects: &'a [Option<Aspect>],
    /// What lifts targets that float; empty where none does.
    pub heaves: &'a [Option<Heave>],
    /// Land that hides targets.
    pub hills: Option<&'a Hills>,
    /// Paths of targets by the sea, and what reflects them.
    pub images: &'a [Image],
    pub mirror: Option<&'a Mirror>,
    /// Seed of the scene.
    pub seed: u64,
    /// Length over which receive axes are interpolated, s; zero: they are taken at the emission.
    pub axes_span_s: f64,
}

impl Circumstances<'_> {
    /// Whether the amplitude of any target varies otherwise than with its path.
    pub fn varies(&self) -> bool {
        let fluctuates = |target: &Target| target.swerling != Swerling::Steady;
        !self.aspects.is_empty()
            || self.hills.is_some()
            || self.heaves.iter().flatten().any(Heave::hides)
            || self.targets.iter().any(fluctuates)
    }

    /// Share of the field of a pair that passes land and, unless they hide nothing, crests about a target.
    fn passes(&self, number: usize, pair: &Pair, elapsed_s: f64, crests: bool) -> Result<f64, TrackFailure> {
        let heave = self.heaves.get(number).and_then(Option::as_ref).filter(|_| crests);
        if heave.is_none() && self.hills.is_none() {
            return Ok(1.0);
        }
        let Surroundings { tracks, frame, start } = self.surroundings;
        let mut passes = 1.0;
        let receiver = self.radar.transmitters.len() + pair.receiver;
        for antenna in [pair.transmitter, receiver] {
            let Some(Mounted { mount, .. }) = antennas(self.radar).nth(antenna) else { continue };
            let centre = |time_s: f64| {
                let state = tracks[mount.platform].truth.state(start.plus(time_s));
                let state = state.map_err(failed(mount.platform, TrackUse::Truth))?;
                Ok(PhaseCentre::of(&state, mount.lever_arm))
            };
            if let Some(heave) = heave {
                passes *= heave.weight(frame, elapsed_s, antenna, centre)?;
            }
            if let Some(hills) = self.hills {
                passes *= hills.weight(number, antenna, elapsed_s, |t| self.target(number, t).0, centre)?;
            }
        }
        Ok(passes)
    }

    /// The vertical of a target at a time after pulse 0: where it floats, the normal of the surface.
    fn up(&self, number: usize, elapsed_s: f64) -> DVec3 {
        let up = self.surroundings.frame.earth().up(self.target(number, elapsed_s).0).raw();
        let Some(Some(heave)) = self.heaves.get(number) else { return up };
        let [east, north] = heave.tilt(elapsed_s);
        (up - DVec3::new(east, north, 0.0)).normalize_or(up)
    }

    /// Where a target is at a time after pulse 0, and how fast.
    fn target(&self, number: usize, elapsed_s: f64) -> (Point<Enu>, Vector<Enu>) {
        if let Some(Some(heave)) = self.heaves.get(number) {
            return heave.at(self.surroundings.frame, elapsed_s);
        }
        let scatterer = Scatterer::at(&self.targets[number], elapsed_s);
        (scatterer.position, scatterer.velocity)
    }
}

/// A track that failed to say where its platform is.
#[derive(Debug)]
pub(super) struct TrackFailure {
    pub platform: usize,
    pub which: TrackUse,
    pub source: TrackError,
}

/// The geometry of one emission. Buffers are kept from one emission to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Emission {
    /// True state of every platform.
    pub states: Vec<State>,
    /// Phase centres, transmitters first.
    pub centres: Vec<PhaseCentre>,
    /// Antenna axes at the emission, transmitters first.
    axes: Vec<Axes>,
    /// Change of the axes over `axes_span_s`; zero for transmitters.
    axes_change: Vec<Axes>,
    /// Polarisation bases at the emission, transmitters first.
    bases: Vec<PortBasis>,
    /// Change of their axes over `axes_span_s`; zero for transmitters.
    bases_change: Vec<Axes>,
    /// `[target, then image, then direct path][pair]`
    pub paths: Vec<Path>,
    /// What the sea does to the path of an image, `[image][pair]`.
    pub bounces: Vec<Bounce>,
    /// Amplitude of a target over its steady one, `[target, then image][pair]`; empty where none varies.
    pub variation: Vec<f64>,
}

impl Emission {
    /// Everything of emission `index` at time `t`, `elapsed_s` after pulse 0.
    pub fn evaluate(
        &mut self,
        of: &Circumstances,
        index: u64,
        t: TimeTag,
        elapsed_s: f64,
    ) -> Result<(), TrackFailure> {
        self.stand(of, t)?;
        self.paths.clear();
        let transmitters = of.radar.transmitters.len();
        for number in 0..of.targets.len() {
            let (position, velocity) = of.target(number, elapsed_s);
            for pair in of.pairs {
                let tx = &self.centres[pair.transmitter];
                let rx = &self.centres[transmitters + pair.receiver];
                self.paths.push(bistatic(LightTime::Exact, tx, position, velocity, rx));
            }
        }
        self.bounces.clear();
        for (image, mirror) in of.images.iter().filter_map(|image| Some((image, of.mirror?))) {
            let (position, velocity) = of.target(image.target, elapsed_s);
            for pair in of.pairs {
                let ends = [pair.transmitter, transmitters + pair.receiver].map(|end| &self.centres[end]);
                let (path, bounce) = mirror.path(image, ends, position, velocity);
                self.paths.push(path);
                self.bounces.push(bounce);
            }
        }
        if of.radar.direct_path {
            for pair in of.pairs {
                let tx = &self.centres[pair.transmitter];
                let rx = &self.centres[transmitters + pair.receiver];
                self.paths.push(direct(LightTime::Exact, tx, rx));
            }
        }
        self.vary(of, index, elapsed_s, None)
    }

    /// Platforms, phase centres and axes at a time; what depends on them stays as it was.
    pub fn stand(&mut self, of: &Circumstances, t: TimeTag) -> Result<(), TrackFailure> {
        self.states.clear();
        for (platform, tracks) in of.surroundings.tracks.iter().enumerate() {
            self.states.push(tracks.truth.state(t).map_err(failed(platform, TrackUse::Truth))?);
        }
        self.centres.clear();
        self.axes.clear();
        self.axes_change.clear();
        self.bases.clear();
        self.bases_change.clear();
        let earth = of.surroundings.frame.earth();
        for Mounted { mount, receives } in antennas(of.radar) {
            let state_now = &self.states[mount.platform];
            let centre = PhaseCentre::of(state_now, mount.lever_arm);
            let now = axes(of, mount, state_now, [t; 2])?;
            let up = earth.up(centre.position).raw();
            let (change, later_up) = if receives && of.axes_span_s > 0.0 {
                let then = t.plus(of.axes_span_s);
                let later = of.surroundings.tracks[mount.platform]
                    .truth
                    .state(then)
                    .map_err(failed(mount.platform, TrackUse::Truth))?;
                let later_up = earth.up(PhaseCentre::of(&later, mount.lever_arm).position).raw();
                (axes(of, mount, &later, [then, t])? - now, later_up)
            } else {
                (DMat3::ZERO, up)
            };
            let kind = PolarisationBasis::of(&mount.pattern);
            let basis = PortBasis::of(kind, now, up);
            let basis_change = match kind {
                PolarisationBasis::Ludwig3 => change,
                PolarisationBasis::LocalHorizontal => PortBasis::local_horizontal(later_up).axes - basis.axes,
            };
            self.centres.push(centre);
            self.axes.push(now);
            self.axes_change.push(change);
            self.bases.push(basis);
            self.bases_change.push(basis_change);
        }
        Ok(())
    }

    /// How the amplitudes of targets differ at an emission from their steady ones; with the most of a run in
    /// place of its draws, and with nothing hidden by crests, where that is given.
    pub fn vary(
        &mut self,
        of: &Circumstances,
        index: u64,
        elapsed_s: f64,
        most_of_run: Option<&[f64]>,
    ) -> Result<(), TrackFailure> {
        self.variation.clear();
        if !of.varies() {
            return Ok(());
        }
        for (number, target) in of.targets.iter().enumerate() {
            let power = match most_of_run.and_then(|most| most.get(number)) {
                Some(most) => *most,
                None => fluctuation(target.swerling, of.seed, number as u64, index, elapsed_s),
            };
            let aspect = of.aspects.get(number).and_then(Option::as_ref);
            let way = aspect.map(|_| (of.up(number, elapsed_s), of.target(number, elapsed_s).1));
            for (n, pair) in of.pairs.iter().enumerate() {
                let path = || &self.paths[number * of.pairs.len() + n];
                let seen = aspect
                    .zip(way)
                    .map_or(1.0, |(aspect, (up, velocity))| aspect.over_mean(up, velocity, path()));
                let passes = of.passes(number, pair, elapsed_s, most_of_run.is_none())?;
                self.variation.push((power * seen).sqrt() * passes);
            }
        }
        for image in of.images {
            let first = image.target * of.pairs.len();
            self.variation.extend_from_within(first..first + of.pairs.len());
        }
        Ok(())
    }

    /// Axes of an antenna (transmitters first) at the emission.
    pub fn axes(&self, antenna: usize) -> Axes {
        self.axes[antenna]
    }

    /// Axes of an antenna (transmitters first) `delay_s` after the emission.
    pub fn axes_after(&self, antenna: usize, delay_s: f64, axes_span_s: f64) -> Axes {
        if axes_span_s > 0.0 {
            self.axes[antenna] + self.axes_change[antenna] * (delay_s / axes_span_s)
        } else {
            self.axes[antenna]
        }
    }

    /// Polarisation basis of an antenna (transmitters first) at the emission.
    pub fn basis(&self, antenna: usize) -> PortBasis {
        self.bases[antenna]
    }

    /// Polarisation basis of an antenna (transmitters first) `delay_s` after the emission.
    pub fn basis_after(&self, antenna: usize, delay_s: f64, axes_span_s: f64) -> PortBasis {
        let mut basis = self.bases[antenna];
        if axes_span_s > 0.0 {
            basis.axes += self.bases_change[antenna] * (delay_s / axes_span_s);
        }
        basis
    }

    /// Shortest and longest delay of all paths, s; `None` without paths.
    pub fn delay_span_s(&self) -> Option<(f64, f64)> {
        self.paths.iter().map(|path| path.delay_s).fold(None, |span, delay| match span {
            None => Some((delay, delay)),
            Some((least, most)) => Some((delay.min(least), delay.max(most))),
        })
    }
}

/// An antenna of the radar and whether it receives.
struct Mounted<'a> {
    mount: &'a AntennaMount,
    receives: bool,
}

fn antennas(radar: &Radar) -> impl Iterator<Item = Mounted<'_>> {
    let transmit = radar.transmitters.iter().map(|t| Mounted { mount: &t.antenna, receives: false });
    transmit.chain(radar.receivers.iter().map(|r| Mounted { mount: &r.antenna, receives: true }))
}

fn axes(
    of: &Circumstances,
    mount: &AntennaMount,
    now: &State,
    at: [TimeTag; 2],
) -> Result<Axes, TrackFailure> {
    let frame: Rotation<frames::Antenna, Enu> = of
        .surroundings
        .antenna_frame(mount, now.attitude, at)
        .map_err(failed(mount.platform, known_track(mount)))?;
    Ok(DMat3::from_quat(frame.raw()))
}

fn known_track(mount: &AntennaMount) -> TrackUse {
    mount.pointing.steering().map_or(TrackUse::Truth, |by| by.from.into())
}

fn failed(platform: usize, which: TrackUse) -> impl Fn(TrackError) -> TrackFailure {
    move |source| TrackFailure { platform, which, source }
}
