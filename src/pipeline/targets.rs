//! What a radar and AIS report of the targets and ships of a scene.
//!
//! Positions of targets and ships are the true ones, and so is what AIS sends: every ship reports itself. The
//! radar measures from own ship: it finds the true offset, turned by the error of the heading that own ship
//! reports, and adds it to the position that own ship reports. Velocities likewise: that relative to own
//! ship, turned, and the reported one. From the truth, both errors are zero.
//!
//! Targets come first, in the order of the scene, then ships; their numbers count from 1. Scatterers of
//! ships are none.

use std::f64::consts::TAU;

use glam::DQuat;

use crate::frames::{Earth, Enu, Geodetic, Point, Rotation, SceneFrame, Vector};
use crate::nav::ais::encode::{NO_TURN, PositionReport, StaticReport, particulars, position};
use crate::nav::encode::targets::{MOST_TARGETS, Tracked, rsd, tll, ttm};
use crate::pulse::{PlatformRecord, Pulse};
use crate::recording::header::Header;
use crate::scene::{Scene, Target};
use crate::sea::fleet;
use crate::sinks::nav::{Encoder, TargetSentence, TargetSettings};
use crate::time::TimeTag;
use crate::units::{KNOT_MPS, SPEED_OF_LIGHT_MPS};

/// Time between two reports of the particulars of a ship, s (ITU-R M.1371-5, table 2).
const PARTICULARS_S: f64 = 360.0;
/// Number of the first ship that has none of its own: those below 201000000 belong to no country.
const FIRST_MMSI: u32 = 200_000_001;
/// Names of ships of a log, up to their number.
const OF_LOG: &str = "mmsi-";

/// What there is to report.
#[derive(Clone, Debug)]
pub(super) struct Observed {
    targets: Vec<Target>,
    ships: Vec<StaticReport>,
}

impl Observed {
    /// The targets and ships of a scene, without what ships carry.
    pub(super) fn of(scene: &Scene) -> Self {
        let ships = scene.ships.iter().zip(FIRST_MMSI..).map(|(ship, made_up)| {
            let own = ship.name.strip_prefix(OF_LOG).and_then(|number| number.parse().ok());
            let size_m = fleet::hull(ship).map_or([ship.length_m.unwrap_or(0.0), 0.0, 0.0], |hull| {
                [hull.length_m(), hull.beam_m(), hull.draught_m()]
            });
            StaticReport { mmsi: own.unwrap_or(made_up), name: ship.name.clone(), size_m }
        });
        Self { targets: scene.targets.clone(), ships: ships.collect() }
    }
}

/// What says it in sentences; `None` if the scene lies nowhere on Earth.
pub(super) fn encoder(
    settings: &TargetSettings,
    observed: &Observed,
    header: &Header,
) -> Option<Box<dyn Encoder>> {
    let origin = header.origin?;
    let frame = SceneFrame::at(Geodetic::from_deg(origin.lat_deg, origin.lon_deg, origin.h_m), Earth::Flat);
    Some(Box::new(Reports {
        frame,
        start: header.start,
        settings: settings.clone(),
        window_s: header.layout.samples as f64 / header.sample_rate_hz,
        observed: observed.clone(),
        particulars_due: None,
        sequence: 0,
    }))
}

/// Own ship, as it is and as it says.
struct Own {
    /// East, North and up where it is.
    local: SceneFrame,
    /// The same where it says it is.
    said: SceneFrame,
    velocity: Vector<Enu>,
    said_velocity: Vector<Enu>,
    /// Sine and cosine of the heading that it says less that which it has, clockwise.
    turn: [f64; 2],
}

struct Reports {
    frame: SceneFrame,
    start: TimeTag,
    settings: TargetSettings,
    window_s: f64,
    observed: Observed,
    /// When the particulars of ships are due again.
    particulars_due: Option<TimeTag>,
    /// Of messages in two sentences.
    sequence: u8,
}

fn heading_rad(record: &PlatformRecord) -> f64 {
    let [w, x, y, z] = record.attitude_quat;
    Rotation::from_raw(DQuat::from_xyzw(x, y, z, w)).to_yaw_pitch_roll()[0]
}

impl Reports {
    fn own(&self, pulse: &Pulse) -> Option<Own> {
        let truth = pulse.nav_true.get(self.settings.platform)?;
        let said =
            if self.settings.from_truth { truth } else { pulse.nav_reported.get(self.settings.platform)? };
        let at = |record: &PlatformRecord| {
            let [x, y, z] = record.position_m;
            Some(SceneFrame::at(self.frame.to_geodetic(Point::new(x, y, z))?, Earth::Flat))
        };
        let (local, said_local) = (at(truth)?, at(said)?);
        let velocity = |frame: &SceneFrame, [x, y, z]: [f64; 3]| self.turned(frame, Vector::new(x, y, z));
        let (sin, cos) = (heading_rad(said) - heading_rad(truth)).sin_cos();
        Some(Own {
            velocity: velocity(&local, truth.velocity_mps)?,
            said_velocity: velocity(&said_local, said.velocity_mps)?,
            local,
            said: said_local,
            turn: [sin, cos],
        })
    }

    /// A velocity of the scene in axes elsewhere.
    fn turned(&self, local: &SceneFrame, velocity: Vector<Enu>) -> Option<Vector<Enu>> {
        local.vector_from_ecef(self.frame.vector_to_ecef(velocity)?)
    }

    /// What the radar finds of something.
    fn tracked<'a>(
        &self,
        own: &Own,
        (number, name): (usize, &'a str),
        (at, velocity): (Point<Enu>, Vector<Enu>),
        time: TimeTag,
    ) -> Option<Tracked<'a>> {
        let [sin, cos] = own.turn;
        let turn = |[east, north]: [f64; 2]| [east * cos + north * sin, north * cos - east * sin];
        let [east, north, up] = own.local.from_ecef(self.frame.to_ecef(at)?)?.to_array();
        let offset_m = turn([east, north]);
        let [vx, vy, _] = (self.turned(&own.local, velocity)? - own.velocity).to_array();
        let relative = turn([vx, vy]);
        let [own_x, own_y, _] = own.said_velocity.to_array();
        Some(Tracked {
            number,
            name,
            time,
            place: own.said.to_geodetic(Point::new(offset_m[0], offset_m[1], up))?,
            offset_m,
            velocity_mps: [relative[0] + own_x, relative[1] + own_y],
            own_velocity_mps: [own_x, own_y],
        })
    }

    /// Everything that the radar tracks.
    fn all_tracked(&self, own: &Own, pulse: &Pulse) -> Vec<Tracked<'_>> {
        let elapsed_s = pulse.time.since(self.start);
        let Observed { targets, ships } = &self.observed;
        let targets = targets.iter().map(|target| (target.name.as_str(), target.at(elapsed_s)));
        let states = pulse.ship_position_m.iter().zip(&pulse.ship_velocity_mps);
        let ships = ships.iter().zip(states).map(|(ship, (&[x, y, z], &[vx, vy, vz]))| {
            (ship.name.as_str(), (Point::new(x, y, z), Vector::new(vx, vy, vz)))
        });
        let numbered = (1..=MOST_TARGETS).zip(targets.chain(ships));
        numbered.filter_map(|(n, (name, state))| self.tracked(own, (n, name), state, pulse.time)).collect()
    }

    /// What ships send by AIS.
    fn automatic(&mut self, pulse: &Pulse, out: &mut Vec<u8>) {
        let states = pulse.ship_position_m.iter().zip(&pulse.ship_velocity_mps).zip(&pulse.ship_heading_deg);
        for (ship, ((&[x, y, z], &[vx, vy, vz]), heading_deg)) in self.observed.ships.iter().zip(states) {
            let Some(place) = self.frame.to_geodetic(Point::new(x, y, z)) else { continue };
            let local = SceneFrame::at(place, Earth::Flat);
            let Some(velocity) = self.turned(&local, Vector::new(vx, vy, vz)) else { continue };
            let [east, north, _] = velocity.to_array();
            // The heading counts from the North of the scene, as the velocity in its axes does.
            let turn = east.atan2(north) - vx.atan2(vy);
            let speed_knots = east.hypot(north) / KNOT_MPS;
            let report = PositionReport {
                mmsi: ship.mmsi,
                status: 0,
                turn: NO_TURN,
                speed_knots: Some(speed_knots),
                lat_deg: place.lat_rad.to_degrees(),
                lon_deg: (place.lon_rad.to_degrees() + 180.0).rem_euclid(360.0) - 180.0,
                course_deg: (speed_knots >= 0.05).then(|| east.atan2(north).rem_euclid(TAU).to_degrees()),
                heading_deg: Some(heading_deg + turn.to_degrees()),
                second: pulse.time.seconds().rem_euclid(60) as u8,
                radio: 0,
            };
            position(&report, 'A', out);
        }
        if self.particulars_due.is_some_and(|due| pulse.time.since(due) < 0.0) {
            return;
        }
        self.particulars_due = Some(pulse.time.plus(PARTICULARS_S));
        for ship in &self.observed.ships {
            particulars(ship, 'B', self.sequence, out);
            self.sequence = (self.sequence + 1) % 10;
        }
    }
}

impl Encoder for Reports {
    fn encode(&mut self, pulse: &Pulse, out: &mut Vec<u8>) -> u64 {
        let known = self.observed.targets.len() + self.observed.ships.len();
        let Some(own) = self.own(pulse) else { return known as u64 };
        let mut lost = 0;
        for place in 0..self.settings.sentences.len() {
            let write = match self.settings.sentences[place] {
                TargetSentence::Ttm => ttm,
                TargetSentence::Tll => tll,
                TargetSentence::Rsd => {
                    let far_s = pulse.window_start_s + self.window_s;
                    rsd(0.5 * SPEED_OF_LIGHT_MPS * far_s, out);
                    continue;
                }
                TargetSentence::Vdm => {
                    self.automatic(pulse, out);
                    continue;
                }
            };
            let tracked = self.all_tracked(&own, pulse);
            lost += known - tracked.len();
            tracked.iter().for_each(|tracked| write(tracked, out));
        }
        lost as u64
    }
}
