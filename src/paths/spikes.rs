//! Breaking waves as scatterer paths.
//!
//! A breaker ([`super::breaking`]) is a point that runs straight on, with the cross section of
//! [`crate::scattering::breaking`] and a phase of its own. It is seen as the facets under it are: with their weights, bilinear
//! between the four nearest, so that nothing jumps as it runs from facet to facet. The reference and the fast
//! echo find these paths in the same way, exactly and at every pulse: breakers are few beside facets.

use glam::{DQuat, DVec3};
use num_complex::Complex64;

use super::block::TileWork;
use super::breaking::{BreakingPlan, Riding};
use super::facets::Reception;
use super::sea::{SeaFailure, SeaPlan};
use super::{PathGenerator, Workspace};
use crate::frames::{Point, Vector};
use crate::geometry::light_time::{LightTime, bistatic};
use crate::paths::list::ScattererPaths;
use crate::radar::fault::RadarError;
use crate::radar::window::Window;
use crate::scattering::breaking::breaker;
use crate::scattering::tilt;
use crate::scene::Patch;
use crate::sea::wake::WakeError;
use crate::units::SPEED_OF_LIGHT_MPS;

/// Weight at a place from those of the four facets about it.
fn between(patch: &Patch, [x, y]: [f64; 2], weight: impl Fn([i64; 2]) -> f64) -> f64 {
    let (x, y) = (x / patch.facet_m, y / patch.facet_m);
    let (left, low) = (x.floor(), y.floor());
    let (u, v, key) = (x - left, y - low, [left as i64, low as i64]);
    let at = |dx: i64, dy: i64| weight([key[0] + dx, key[1] + dy]);
    (1.0 - v) * ((1.0 - u) * at(0, 0) + u * at(1, 0)) + v * ((1.0 - u) * at(0, 1) + u * at(1, 1))
}

impl PathGenerator {
    /// Breaking waves that are alive at a time, mean; 0 where none breaks.
    pub fn breakers_alive(&self) -> f64 {
        self.sea.as_ref().and_then(|sea| sea.breaking.as_ref()).map_or(0.0, BreakingPlan::alive)
    }

    /// Appends the breaking waves that an emission illuminates and its window receives; `weight` is the
    /// visibility of a facet from an antenna.
    pub(super) fn append_breakers(
        &self,
        sea: &SeaPlan,
        reception: &Reception,
        patch: &Patch,
        weight: impl Fn(usize, [i64; 2]) -> f64,
        amplitude: &mut [Complex64],
        paths: &mut ScattererPaths,
    ) -> Result<(), SeaFailure> {
        let Some(breaking) = &sea.breaking else { return Ok(()) };
        let (emission, elapsed_s) = (reception.emission, reception.elapsed_s);
        let permittivity = sea.scattering.permittivity();
        let (earth, transmitters) = (self.frame.earth(), self.radar.transmitters.len());
        let found = breaking.each(patch, elapsed_s, |Riding { breaker: own, height_m }| {
            let (at_m, (sin, cos)) = (own.at_m(elapsed_s), own.travel_rad.sin_cos());
            let position = Point::new(at_m[0], at_m[1], height_m - earth.drop_m(at_m[0], at_m[1]));
            let velocity = Vector::new(own.speed_mps * cos, own.speed_mps * sin, 0.0);
            // Angles are those to the sea where the breaker is.
            let level = DQuat::from_rotation_arc(earth.up(position).raw(), DVec3::Z);
            let size = own.area_m2.sqrt() * own.envelope(elapsed_s);
            amplitude.fill(Complex64::ZERO);
            for (pair, plan) in self.plans.iter().enumerate() {
                let ends = [plan.pair.transmitter, transmitters + plan.pair.receiver];
                let [tx, rx] = ends.map(|end| &emission.centres[end]);
                let path = bistatic(LightTime::Exact, tx, position, velocity, rx);
                paths.delay_s[pair].push(path.delay_s);
                paths.delay_rate[pair].push(path.delay_rate);
                let within = reception.window.touches(reception.offset_s + path.delay_s);
                if !(within && plan.receives(reception.tx_pol)) {
                    continue;
                }
                let range = |leg_s: f64| leg_s * SPEED_OF_LIGHT_MPS;
                let seen = ends.map(|end| between(patch, at_m, |key| weight(end, key)));
                let scale =
                    plan.link.scattered(range(path.tx_leg_s), range(path.rx_leg_s)) * seen[0] * seen[1];
                if scale == 0.0 {
                    continue;
                }
                let directions = tilt::Path::new(level * path.incident, level * path.scattered);
                let returned = breaker(permittivity, &directions, DVec3::new(cos, sin, 0.0));
                let [like, cross] = own.phases_rad.map(Complex64::cis);
                // In these bases h turns round with the wave, v does not.
                let turned = returned.cross.sqrt() * cross * size;
                let matrix = [
                    [returned.vv.sqrt() * size * like, -turned],
                    [turned, -returned.hh.sqrt() * size * like],
                ];
                self.amplitudes(
                    plan,
                    (&path, None),
                    Some(&matrix),
                    scale,
                    reception.tx_pol,
                    emission,
                    amplitude,
                );
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
        let Workspace { own, amplitude, .. } = workspace;
        self.evaluate(index, own)?;
        let window = Window::new(&self.radar, self.window_start_of(index)?, self.pulse_length_s);
        let reception = self.reception(index, index, own, window);
        let weight = |antenna: usize, key| tiles.weight_at(pulse, antenna, patch.nearest_index(key));
        let appended = self.append_breakers(sea, &reception, patch, weight, amplitude, paths);
        appended.map_err(|failure| self.sea_error(index, failure))
    }
}
