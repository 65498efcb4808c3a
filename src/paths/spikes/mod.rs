//! Breaking waves as scatterer paths.
//!
//! A breaker (`super::breaking`) is a scatterer that runs straight on with its wave, with the cross section
//! of [`crate::scattering::breaking`] and a phase of its own. It is seen as the facets under it are: with
//! their weights, bilinear between the four nearest, so that nothing jumps as it runs from facet to facet.
//! The reference finds these paths exactly and at every pulse; the fast echo takes what is smooth through a
//! few pulses ([`stretch`]).

pub mod stretch;

use glam::{DQuat, DVec3};
use num_complex::Complex64;

use super::block::TileWork;
use super::breaking::{BreakingPlan, Riding};
use super::facets::Reception;
use super::sea::{SeaFailure, SeaPlan};
use super::{PathGenerator, Workspace};
use crate::frames::{Earth, Enu, Point, Vector};
use crate::geometry::light_time::{LightTime, Path, bistatic};
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;
use crate::scattering::breaking as scattering;
use crate::scattering::tilt::{self, ScatterMatrix};
use crate::scene::Patch;
use crate::sea::breaking::Breaker;
use crate::sea::wake::WakeError;

/// Weight at a place from those of the four facets about it.
fn between(patch: &Patch, [x, y]: [f64; 2], weight: impl Fn(usize) -> f64) -> f64 {
    let [x, y] = [(x, 0), (y, 1)].map(|(at, i)| at / patch.facet_m - patch.first[i] as f64);
    // Off the patch what its edge has.
    let side = |at: f64, facets: usize| {
        let at = at.clamp(0.0, (facets - 1) as f64);
        let low = at as usize;
        (low, (low + 1).min(facets - 1), at - low as f64)
    };
    let ((left, right, u), (low, high, v)) = (side(x, patch.facets[0]), side(y, patch.facets[1]));
    let at = |x: usize, y: usize| weight(y * patch.facets[0] + x);
    (1.0 - v) * ((1.0 - u) * at(left, low) + u * at(right, low))
        + v * ((1.0 - u) * at(left, high) + u * at(right, high))
}

/// A breaker at an instant.
#[derive(Clone, Copy)]
struct Moves {
    at_m: [f64; 2],
    position: Point<Enu>,
    velocity: Vector<Enu>,
    travel: DVec3,
}

impl Moves {
    fn of(riding: &Riding, earth: Earth, elapsed_s: f64) -> Self {
        let Riding { breaker, height_m, .. } = riding;
        let (at_m, [cos, sin]) = (breaker.at_m(elapsed_s), breaker.travel);
        let position = Point::new(at_m[0], at_m[1], height_m - earth.drop_m(at_m[0], at_m[1]));
        let travel = DVec3::new(cos, sin, 0.0);
        // The sea falls away from the plane of the frame.
        let [east, north] = earth.drop_slope(at_m[0], at_m[1]);
        let velocity = breaker.speed_mps * (travel - DVec3::Z * (east * cos + north * sin));
        Self { at_m, position, velocity: Vector::from_raw(velocity), travel }
    }

    /// Scattering matrix over a path, sqrt(m^2), rms of its life; angles are those to the sea where it is.
    fn matrix(&self, earth: Earth, permittivity: Complex64, breaker: &Breaker, path: &Path) -> ScatterMatrix {
        let level = DQuat::from_rotation_arc(earth.up(self.position).raw(), DVec3::Z);
        let directions = tilt::Path::new(level * path.incident, level * path.scattered);
        let returned = scattering::breaker(permittivity, &directions, self.travel);
        returned.matrix(breaker.area_m2, breaker.phases_rad)
    }
}

impl PathGenerator {
    /// Scatterers of breaking waves that are alive at a time, mean; 0 where none breaks.
    pub fn breakers_alive(&self) -> f64 {
        self.sea.as_ref().and_then(|sea| sea.breaking.as_ref()).map_or(0.0, BreakingPlan::alive)
    }

    /// Scatterers of breaking waves that are alive at any instant of so many pulses, mean, and bytes of those
    /// that are kept for all threads.
    pub fn breakers_within(&self, pulses: u64) -> (f64, u64) {
        let lasts_s = self.radar.emissions.interval_s(0, pulses);
        let breaking = self.sea.as_ref().and_then(|sea| sea.breaking.as_ref());
        breaking.map_or((0.0, 0), |of| (of.within(lasts_s), of.kept_bytes()))
    }

    /// Scatterers of breaking waves for which there is room beforehand in a stretch of so many pulses.
    pub fn breakers_room(&self, pulses: usize) -> usize {
        let lasts_s = self.radar.emissions.interval_s(0, pulses as u64);
        self.sea.as_ref().and_then(|sea| sea.breaking.as_ref()).map_or(0, |of| of.room(lasts_s))
    }

    /// Appends the breaking waves that an emission illuminates and its window receives; `weight` is the
    /// visibility of a facet from an antenna.
    pub(super) fn append_breakers(
        &self,
        sea: &SeaPlan,
        reception: &Reception,
        patch: &Patch,
        weight: impl Fn(usize, usize) -> f64,
        amplitude: &mut [Complex64],
        paths: &mut ScattererPaths,
    ) -> Result<(), SeaFailure> {
        let Some(breaking) = &sea.breaking else { return Ok(()) };
        let (emission, elapsed_s) = (reception.emission, reception.elapsed_s);
        let permittivity = sea.scattering.permittivity();
        let (earth, transmitters) = (self.frame.earth(), self.radar.transmitters.len());
        let found = breaking.each(patch, [elapsed_s; 2], |riding| {
            let envelope = riding.breaker.envelope(elapsed_s);
            if envelope == 0.0 {
                return;
            }
            let moves = Moves::of(riding, earth, elapsed_s);
            amplitude.fill(Complex64::ZERO);
            for (pair, plan) in self.plans.iter().enumerate() {
                let ends = [plan.pair.transmitter, transmitters + plan.pair.receiver];
                let [tx, rx] = ends.map(|end| &emission.centres[end]);
                let path = bistatic(LightTime::Exact, tx, moves.position, moves.velocity, rx);
                paths.delay_s[pair].push(path.delay_s);
                paths.delay_rate[pair].push(path.delay_rate);
                let within = reception.window(plan).touches(reception.offset_s + path.delay_s);
                if !(within && plan.receives(reception.tx_pol)) {
                    continue;
                }
                let seen = ends.map(|end| between(patch, moves.at_m, |facet| weight(end, facet)));
                let scale = plan.link.scattered_over(&path) * seen[0] * seen[1] * envelope;
                if scale == 0.0 {
                    continue;
                }
                let matrix = moves.matrix(earth, permittivity, &riding.breaker, &path);
                let path = (&path, None);
                self.amplitudes(plan, path, Some(&matrix), scale, reception.tx_pol, emission, amplitude);
            }
            paths.finish(reception.offset_s, amplitude);
        });
        Ok(found.map_err(WakeError::from)?)
    }

    /// Fills `paths` with the breaking waves of a pulse of the block that is open, its `pulse`th.
    ///
    /// # Errors
    /// A pulse that the tracks do not cover; a sea that cannot be found at it.
    pub fn breakers(
        &self,
        (index, pulse): (u64, usize),
        patch: &Patch,
        tiles: &TileWork,
        workspace: &mut Workspace,
        paths: &mut ScattererPaths,
    ) -> Result<(), RadarError> {
        paths.clear();
        let Some(sea) = self.sea.as_ref().filter(|sea| sea.breaking.is_some()) else { return Ok(()) };
        let Workspace { own, amplitude, windows, .. } = workspace;
        self.evaluate(index, own)?;
        self.windows_or_all(index, windows)?;
        let reception = self.reception_of_all(index, own, windows);
        let weight = |antenna: usize, facet| tiles.seen_from(antenna, pulse).of(facet);
        let appended = self.append_breakers(sea, &reception, patch, weight, amplitude, paths);
        appended.map_err(|failure| self.sea_error(index, failure))
    }
}
