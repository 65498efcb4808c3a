//! The ships of a scene: their hulls found, their wakes prepared for the patch that will be looked at.
//!
//! A hull is read (or is Wigley's), scaled to the length asked, and its Kochin function gives the amplitudes
//! of the free waves; they are prepared as far from the ship as any facet of the given patches lies, and fade
//! between 30 and 40 lengths astern. Ships that raise no waves on these facets (too slow, waves too short)
//! have a wake without waves, and say why ([`Wake::presence`]).
//!
//! ```
//! use nereus::scene::ship::{HullGiven, KelvinWake, Ship, TurbulentWake};
//! use nereus::scene::Patch;
//! use nereus::sea::fleet::Fleet;
//! use nereus::sea::surface::Selection;
//! let ship = Ship {
//!     name: "tanker".into(),
//!     hull: HullGiven::Wigley { beam_m: 13.0, draught_m: 4.3 },
//!     length_m: Some(100.0),
//!     position_m: [60.0, 0.0],
//!     heading_rad: 0.0,
//!     speed_mps: 9.0,
//!     kelvin: Some(KelvinWake::default()),
//!     turbulent: Some(TurbulentWake::default()),
//!     echo: false,
//!     mesh: Default::default(),
//!     trajectory: None,
//!     panels: Default::default(),
//! };
//! let patch = Patch::new([256.0, 128.0], 2.0, [0.0, 0.0])?;
//! let fleet = Fleet::muster(&[ship], &[(0.0, patch), (2.0, patch)])?;
//! assert!(!fleet.wakes[0].nodes().is_empty() && fleet.strips.len() == 1);
//! let waves = fleet.waves(&patch, Selection::HEIGHT, 2.0)?;
//! let summed = fleet.wakes[0].at(patch.centre_m(patch.key(40)), 2.0)?;
//! assert!((waves.height_m[40] - summed.height_m).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::Arc;

use glam::DVec3;

use super::surface::{Fields, Selection};
use super::wake::course::Pose;
use super::wake::kochin::{Kochin, KochinError, LEAST_SPEED_MPS, Transom};
use super::wake::leg::{Leg, legs};
use super::wake::map;
use super::wake::{Course, Reach, Settings, ShortWaves, TrackLine, TurbulentStrip, Wake, WakeError};
use crate::scene::hull::{Hull, HullError, Particulars};
use crate::scene::mesh::{self, MeshError, Triangle};
use crate::scene::ship::{HullForm, HullGiven, KelvinWake, ShipMesh, ShipMotion, UpAxis};
use crate::scene::{Patch, Ship};
use crate::sea::facet_surface::Wakes;

/// Distances astern of midship, in lengths of the ship, over which its waves fade: real ones are lost among
/// others and in turbulence. It bounds what a patch far from its ships costs.
const FADE_LENGTHS: [f64; 2] = [30.0, 40.0];

/// Error of [`Fleet::waves`] over the root sum square of the waves, dB: below half a unit of an f32.
const MAP_ERROR_DB: f64 = -150.0;

/// How long a patch is looked at after it was at a place, as far as legs care, s.
const MOST_HELD_S: f64 = 60.0;

/// A turbulent wake under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Its shape.
    pub strip: TurbulentStrip,
    /// Where its ship goes.
    pub course: Course,
    /// The track on which it lies, where that is not straight.
    pub track: Option<Arc<TrackLine>>,
    /// Wind that raises the short waves within, over the wind outside.
    pub wind_ratio: f64,
}

impl Strip {
    /// Its ship at a time, s.
    pub fn pose(&self, time_s: f64) -> Pose {
        let pose = self.course.pose(time_s);
        self.track.as_ref().map_or(pose, |track| Pose { run_m: track.run_m(time_s), ..pose })
    }

    /// Share of the water at a place that it covers, with its ship at a pose.
    pub fn cover(&self, place_m: [f64; 2], pose: &Pose) -> f64 {
        match &self.track {
            None => self.strip.cover(pose.astern_starboard_m(place_m)),
            Some(track) => track.cover(&self.strip, place_m, pose.run_m),
        }
    }

    /// Whether it may cover any place in a rectangle (least and largest x, and y).
    pub fn is_near(&self, bounds_m: [[f64; 2]; 2], pose: &Pose) -> bool {
        if let Some(track) = &self.track {
            return track.is_near(&self.strip, bounds_m, pose.run_m);
        }
        let [[x0, x1], [y0, y1]] = bounds_m;
        let corners = [[x0, y0], [x0, y1], [x1, y0], [x1, y1]];
        let places = corners.map(|corner| pose.astern_starboard_m(corner));
        let furthest_m = places.iter().fold(f64::NEG_INFINITY, |most, place| most.max(place[0]));
        let least = places.iter().fold(f64::INFINITY, |least, place| least.min(place[1]));
        let most = places.iter().fold(f64::NEG_INFINITY, |most, place| most.max(place[1]));
        let aside_m = self.strip.reach_aside_m(furthest_m);
        aside_m > 0.0 && least < aside_m && most > -aside_m
    }
}

/// Ships under way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fleet {
    /// Their gravity waves.
    pub wakes: Vec<Wake>,
    /// Their turbulent wakes.
    pub strips: Vec<Strip>,
}

/// Why a ship cannot sail.
#[derive(Debug, thiserror::Error)]
#[error("ship '{ship}': {source}")]
pub struct FleetError {
    /// The ship.
    pub ship: String,
    /// What is wrong.
    pub source: ShipError,
}

/// The faults of all ships.
#[derive(Debug, thiserror::Error)]
#[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
pub struct FleetErrors(pub Vec<FleetError>);

/// What is wrong with a ship.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShipError {
    /// Its hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// A hull without a length of its own.
    #[error("a Wigley hull needs a length")]
    NoLength,
    /// A scatterer named like a target.
    #[error("its scatterer would be named \"{name}\" like a target: allowed are unique names")]
    NameTaken {
        /// The name.
        name: String,
    },
    /// A motion that its echo does not have.
    #[error(
        "motion = \"waves\" moves its mesh, but its hull's file has scatterers, which ride level: allowed are \
         mesh = true or motion = \"level\""
    )]
    NothingMoves,
    /// Its mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Its speed.
    #[error(transparent)]
    Kochin(#[from] KochinError),
    /// Its wake.
    #[error(transparent)]
    Wake(#[from] WakeError),
}

/// The hull of a ship, scaled.
///
/// # Errors
/// A file that cannot be read, or dimensions out of range.
pub fn hull(ship: &Ship) -> Result<Hull, ShipError> {
    Ok(match (&ship.hull, ship.length_m) {
        (HullGiven::File(path), None) => Hull::load(path)?,
        (HullGiven::File(path), Some(length_m)) => Hull::load(path)?.scaled_to_length(length_m)?,
        (HullGiven::Wigley { beam_m, draught_m }, Some(length_m)) => {
            Hull::wigley(length_m, *beam_m, *draught_m)?
        }
        (HullGiven::Wigley { .. }, None) => return Err(ShipError::NoLength),
    })
}

/// The triangles by which a ship echoes; none where its mesh is not used.
///
/// # Errors
/// A superstructure that cannot be read, or too many panels.
pub fn panels(ship: &Ship, hull: &Hull) -> Result<Vec<Triangle>, ShipError> {
    let ShipMesh { used, freeboard_m, panel_m, motion, .. } = &ship.mesh;
    if !used.unwrap_or(hull.scatterers().is_empty()) {
        return if *motion == ShipMotion::Level { Ok(Vec::new()) } else { Err(ShipError::NothingMoves) };
    }
    let panel_m = *panel_m;
    let freeboard_m = freeboard_m.unwrap_or(mesh::FREEBOARD_RATIO * hull.length_m());
    let mut triangles = mesh::of_hull(hull, freeboard_m, panel_m)?;
    let above = superstructure(ship, hull)?;
    triangles.extend(mesh::divided(above, panel_m).ok_or(MeshError::TooMany { panel_m })?);
    if triangles.len() > mesh::MOST_PANELS {
        return Err(MeshError::TooMany { panel_m }.into());
    }
    Ok(triangles)
}

/// What stands on the hull, in its axes and scaled with it; nothing where no file is given.
///
/// # Errors
/// A file that cannot be read.
pub fn superstructure(ship: &Ship, hull: &Hull) -> Result<Vec<Triangle>, ShipError> {
    let Some(path) = &ship.mesh.superstructure else { return Ok(Vec::new()) };
    let turned = |corner: DVec3| match ship.mesh.up {
        UpAxis::Z => corner,
        UpAxis::Y => DVec3::new(corner.x, -corner.z, corner.y),
    };
    let placed = |triangle: Triangle| triangle.map(|corner| turned(corner) * hull.scale());
    Ok(mesh::file::load(path)?.into_iter().map(placed).collect())
}

/// What the motion of a hull in waves depends on.
pub fn form(hull: &Hull) -> HullForm {
    let Particulars { length_m, block, .. } = Particulars::of(hull);
    HullForm { length_m, beam_m: hull.beam_m(), draught_m: hull.draught_m(), block }
}

/// The course of a ship.
pub fn course(ship: &Ship) -> Course {
    Course::straight(ship.position_m, ship.heading_rad, ship.speed_mps)
}

/// The short waves of the ships that are asked for theirs, on facets of a side, for wave vectors up to a wave
/// number.
///
/// # Errors
/// The first ship that cannot sail.
pub fn short_waves(ships: &[Ship], facet_m: f64, shortest_radpm: f64) -> Result<Vec<ShortWaves>, FleetError> {
    let of_ship = |ship: &Ship, kelvin: &KelvinWake| -> Result<ShortWaves, ShipError> {
        let (hull, course) = (hull(ship)?, course(ship));
        let kochin = Kochin::new(&hull, ship.speed_mps, Transom::Open)?;
        let settings = Settings {
            cutoff_rad_m: kelvin.band_limit_radpm,
            fade_m: Some(FADE_LENGTHS.map(|lengths| lengths * hull.length_m())),
            ..Settings::new(facet_m, Reach::disc(0.0))
        };
        Ok(ShortWaves::new(course, hull.length_m(), &settings, shortest_radpm, |t| kochin.amplitude_m(t))?)
    };
    let mut found = Vec::new();
    for ship in ships {
        if let Some(kelvin) = ship.kelvin.as_ref().filter(|kelvin| kelvin.short_waves) {
            let waves =
                of_ship(ship, kelvin).map_err(|source| FleetError { ship: ship.name.clone(), source })?;
            found.extend(Some(waves).filter(|waves| !waves.is_empty()));
        }
    }
    Ok(found)
}

impl Fleet {
    /// Prepares ships for the patch as it lies at some times, s after pulse 0. The faults of all ships are
    /// reported.
    ///
    /// # Errors
    /// The faults of all ships.
    pub fn muster(ships: &[Ship], patches: &[(f64, Patch)]) -> Result<Self, FleetErrors> {
        Self::muster_between(ships, patches, f64::INFINITY, 0.0)
    }

    /// The same for a patch that moves from place to place no faster than `patch_mps` and is looked at until
    /// `held_s` after it was there: the less it can stray from these places, the fewer waves a ship needs.
    ///
    /// # Errors
    /// The faults of all ships.
    pub fn muster_between(
        ships: &[Ship],
        patches: &[(f64, Patch)],
        patch_mps: f64,
        held_s: f64,
    ) -> Result<Self, FleetErrors> {
        let mut fleet = Self::default();
        let mut faults = Vec::new();
        for ship in ships {
            let enlisted = fleet.enlist(ship, patches, patch_mps, held_s);
            faults.extend(enlisted.err().map(|source| FleetError { ship: ship.name.clone(), source }));
        }
        if faults.is_empty() { Ok(fleet) } else { Err(FleetErrors(faults)) }
    }

    /// The waves of all ships alone over a patch at a time, s, in the order of the patch.
    ///
    /// # Errors
    /// A patch of other facets, or a time that is out of reach.
    pub fn waves(&self, patch: &Patch, selection: Selection, time_s: f64) -> Result<Fields<f64>, WakeError> {
        let mut fields = Fields::sized(patch.len(), selection);
        Wakes::new(&self.wakes, patch, MAP_ERROR_DB)?.add(time_s, patch, &mut fields)?;
        Ok(fields)
    }

    fn enlist(
        &mut self,
        ship: &Ship,
        patches: &[(f64, Patch)],
        patch_mps: f64,
        held_s: f64,
    ) -> Result<(), ShipError> {
        let (hull, course) = (hull(ship)?, course(ship));
        let places = Places { patches, patch_mps, held_s };
        match (&ship.kelvin, &ship.trajectory) {
            (None, _) => {
                // Faults of its speed are found all the same.
                Kochin::new(&hull, ship.speed_mps, Transom::Open)?;
            }
            (Some(kelvin), None) => {
                let leg = Leg { course, window: None };
                self.wakes.extend(places.wake(&hull, kelvin, &leg)?);
            }
            (Some(kelvin), Some(way)) => {
                for leg in legs(way) {
                    if places.see(&hull, &leg) {
                        self.wakes.extend(places.wake(&hull, kelvin, &leg)?);
                    }
                }
            }
        }
        // A ship at rest stirs nothing behind it.
        if let Some(turbulent) = ship.turbulent.as_ref().filter(|_| ship.speed_mps >= LEAST_SPEED_MPS) {
            let decay_m = turbulent.decay_lengths * hull.length_m();
            let strip =
                TurbulentStrip::with(hull.length_m(), hull.beam_m(), turbulent.spread_exponent, decay_m)?;
            let track = ship.trajectory.as_ref().map(|way| Arc::new(TrackLine::new(way)));
            self.strips.push(Strip { strip, course, track, wind_ratio: turbulent.wind_ratio });
        }
        Ok(())
    }
}

/// Where a patch lies at some times, and how it moves in between.
struct Places<'a> {
    patches: &'a [(f64, Patch)],
    patch_mps: f64,
    held_s: f64,
}

impl Places<'_> {
    /// Whether there are waves of a leg at any of these times.
    fn see(&self, hull: &Hull, leg: &Leg) -> bool {
        let (Some(first), Some(last)) = (self.patches.first(), self.patches.last()) else { return false };
        let Some(window) = leg.window else { return true };
        let end_m = FADE_LENGTHS[1] * hull.length_m();
        let slack_s = self.held_s.min(MOST_HELD_S) + last.0 - first.0;
        // Its waves drift astern: what is seen at all lies between the ends of the window at both times.
        let [from_m, _] = window.range_m(first.0 - slack_s, leg.course.speed_mps);
        let [_, to_m] = window.range_m(last.0 + slack_s, leg.course.speed_mps);
        from_m < end_m && to_m > -0.5 * hull.length_m()
    }

    /// The waves of a leg; `None` without any patch.
    fn wake(&self, hull: &Hull, kelvin: &KelvinWake, leg: &Leg) -> Result<Option<Wake>, ShipError> {
        let Self { patches, patch_mps, held_s } = *self;
        let kochin = Kochin::new(hull, leg.course.speed_mps, Transom::Open)?;
        let Some(&(_, Patch { facet_m, .. })) = patches.first() else { return Ok(None) };
        let mut reach = Reach { along_m: 0.0, across_m: 0.0 };
        let fade_m = FADE_LENGTHS.map(|lengths| lengths * hull.length_m());
        let moves = patches.iter().any(|(_, patch)| patch.first != patches[0].1.first);
        for (index, &(time_s, ref patch)) in patches.iter().enumerate() {
            // A patch that moves strays no further than its speed allows until half-way to the next
            // place, and waves are only asked for within the wake's end and the patch that touches it.
            let [x_m, y_m] = patch.size_m();
            let (end_m, patch_m) = (fade_m[1] + 0.5 * hull.length_m(), x_m.hypot(y_m));
            let most = Reach {
                along_m: end_m + patch_m,
                across_m: map::SIDE * fade_m[1] + end_m - fade_m[1] + patch_m,
            };
            let half_s = if moves { half_gap_s(patches, index) + held_s } else { 0.0 };
            let Reach { along_m, across_m } =
                Reach::of(patch, &leg.course, [time_s - half_s, time_s + half_s])?;
            // Places are whole facets.
            let stray_m = if moves { patch_mps * half_s + 2.0 * facet_m } else { 0.0 };
            reach.along_m = reach.along_m.max((along_m + stray_m).min(most.along_m));
            reach.across_m = reach.across_m.max((across_m + stray_m).min(most.across_m));
        }
        let settings = Settings {
            cutoff_rad_m: kelvin.band_limit_radpm,
            fade_m: Some(fade_m),
            ..Settings::new(facet_m, reach)
        };
        let amplitude_m = |tan_theta| kochin.amplitude_m(tan_theta);
        let wake = Wake::new(leg.course, hull.length_m(), &settings, amplitude_m)?;
        Ok(Some(wake.of_leg(leg.window)))
    }
}

/// Half the time to the furthest neighbour of a place, s.
fn half_gap_s(patches: &[(f64, Patch)], index: usize) -> f64 {
    let time_s = |index: usize| patches.get(index).map(|(time_s, _)| *time_s);
    let before = index.checked_sub(1).and_then(time_s);
    let gap_s = |other: Option<f64>| other.map_or(0.0, |other| (other - patches[index].0).abs());
    0.5 * gap_s(before).max(gap_s(time_s(index + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ship::{KelvinWake, TurbulentWake};

    /// A patch that flies past a ship at 50 m/s, at 2 of the places between which it moves, and the ship.
    fn passing() -> (Ship, Vec<(f64, Patch)>) {
        let ship = Ship {
            name: "tug".into(),
            hull: HullGiven::Wigley { beam_m: 8.0, draught_m: 2.5 },
            length_m: Some(50.0),
            position_m: [0.0, 0.0],
            heading_rad: 0.0,
            speed_mps: 6.0,
            kelvin: Some(KelvinWake::default()),
            turbulent: Some(TurbulentWake::default()),
            echo: false,
            mesh: Default::default(),
            trajectory: None,
            panels: Default::default(),
        };
        let patch = |x_m: f64| Patch::new([64.0, 48.0], 2.0, [x_m, 0.0]).unwrap();
        (ship, (0..=4).map(|place| (f64::from(place), patch(50.0 * f64::from(place) - 150.0))).collect())
    }

    #[test]
    fn a_known_way_needs_fewer_waves_of_the_same_sum() {
        let (ship, places) = passing();
        let ships = [ship];
        let anywhere = Fleet::muster(&ships, &places).unwrap();
        let known = Fleet::muster_between(&ships, &places, 50.0, 0.0).unwrap();
        let (many, few) = (anywhere.wakes[0].nodes().len(), known.wakes[0].nodes().len());
        assert!(few * 2 < many, "{few} {many}");
        // Both sums are of the same integral; each map errs by so much of the root sum square of its waves.
        let rss_m = |fleet: &Fleet| {
            fleet.wakes[0].nodes().iter().map(|node| node.amplitude_m.norm_sqr()).sum::<f64>().sqrt()
        };
        let allowed_m = 10f64.powf(MAP_ERROR_DB / 20.0) * (rss_m(&anywhere) + rss_m(&known));
        // Between the places too.
        for quarter in 0..=16 {
            let time_s = 0.25 * f64::from(quarter);
            let patch = Patch::new([64.0, 48.0], 2.0, [50.0 * time_s - 150.0, 0.0]).unwrap();
            let of = |fleet: &Fleet| fleet.waves(&patch, Selection::HEIGHT, time_s).unwrap().height_m;
            let (a, b) = (of(&anywhere), of(&known));
            let apart = a.iter().zip(&b).fold(0f64, |most, (a, b)| most.max((a - b).abs()));
            println!("{time_s} s: {apart:.1e} m, {allowed_m:.1e} m allowed");
            assert!(apart <= allowed_m);
        }
    }
}
