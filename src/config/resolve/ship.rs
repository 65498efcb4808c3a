//! Ships under way.

use std::sync::Arc;

use super::ais;
use super::place;
use super::ship_mesh;
use super::turbulent::turbulent;
use super::{Ground, Names, way};
use crate::config::error::Problem;
use crate::config::keys::{self, MOST_SHIPS};
use crate::config::section::Section;
use crate::scene::ship::{HullGiven, KelvinWake, Sailed, ShipMotion};
use crate::scene::{Ship, Trajectory};
use crate::time::TimeTag;

/// Carrier below which short waves of ships scatter by default.
const BRAGG_BELOW_HZ: f64 = 6e9;

/// `[[ship]]`, then `[[ais]]`.
pub(super) fn ships(
    root: &Section<'_>,
    ground: &Ground,
    start: Option<TimeTag>,
    run: way::Run,
) -> Option<Vec<Ship>> {
    let carrier_hz = root.peek_in(&keys::root::RADAR, &keys::radar::CARRIER_HZ);
    let bragg = carrier_hz.is_some_and(|carrier_hz| carrier_hz < BRAGG_BELOW_HZ);
    let mut names = Names::new("ship");
    let mut ships = Vec::new();
    for (index, section) in root.sections(&keys::root::SHIP).into_iter().enumerate() {
        names.take_or(&section, &keys::ship::NAME, Some(format!("ship-{index}")));
        ships.push(ship(section, names.last(), (ground, run), bragg));
    }
    for section in root.sections(&keys::root::AIS) {
        ships.extend(ais::ships(section, (ground, run), start, bragg, &mut names));
    }
    if !root.has(&keys::root::SEA) {
        root.idle(&[&keys::root::SHIP, &keys::root::AIS], "there is no [sea]");
    }
    let count = ships.len() as u64;
    if count > MOST_SHIPS {
        let problem = Problem::TooMany { count, what: "ships", allowed: MOST_SHIPS };
        root.fault(&keys::root::SHIP, problem);
        return None;
    }
    ships.into_iter().collect()
}

/// Where a ship is at pulse 0, where it heads, and how fast; and its track.
type Course = ([f64; 2], f64, f64, Option<Trajectory>);

fn course(section: &Section<'_>, ground: &Ground, run: way::Run) -> Option<Course> {
    use keys::ship as k;
    if section.has(&k::TRACK) {
        let own = [&k::POSITION_M, &k::LAT_DEG, &k::LON_DEG, &k::HEADING_DEG, &k::TOWARDS_DEG, &k::SPEED_MPS];
        section.idle(&own, "the ship has a track");
        let table = section.section(&k::TRACK)?;
        let trajectory = way::way(table, ground, run, way::Mover::Ship)?;
        let Sailed { position_m, velocity_mps: [vx, vy], ahead, .. } =
            Sailed::on(&trajectory, 0.0, [1.0, 0.0]);
        return Some((position_m, ahead[1].atan2(ahead[0]), vx.hypot(vy), Some(trajectory)));
    }
    section.section(&k::TRACK);
    let position_m = place::on_sea(section, [&k::POSITION_M, &k::LAT_DEG, &k::LON_DEG], ground);
    let written = section.exactly_one(&[&k::HEADING_DEG, &k::TOWARDS_DEG]);
    let (heading_deg, towards_deg) = (section.number(&k::HEADING_DEG), section.number(&k::TOWARDS_DEG));
    let speed_mps = section.number(&k::SPEED_MPS);
    if !section.has(&k::SPEED_MPS) {
        section.fault(&k::SPEED_MPS, Problem::Missing { allowed: k::SPEED_MPS.kind.allowed() });
    }
    written?;
    let heading_deg = towards_deg.or(heading_deg.map(|heading_deg| 90.0 - heading_deg));
    Some((position_m?, heading_deg?.to_radians(), speed_mps?, None))
}

fn ship(
    section: Section<'_>,
    name: Option<String>,
    (ground, run): (&Ground, way::Run),
    bragg_by_default: bool,
) -> Option<Ship> {
    use keys::ship as k;
    let hull = hull(&section);
    let length_m = section.number(&k::LENGTH_M);
    let sound_length = length_m.is_some() || !section.has(&k::LENGTH_M);
    let course = course(&section, ground, run);
    let wake = section.flag(&k::WAKE);
    if wake == Some(false) {
        section.idle(&[&k::BAND_LIMIT_RADPM, &k::WAKE_BRAGG], "wake = false");
    }
    let band_limit_radpm = section.number(&k::BAND_LIMIT_RADPM);
    let sound_limit = band_limit_radpm.is_some() || !section.has(&k::BAND_LIMIT_RADPM);
    let tracked = section.has(&k::TRACK);
    let short_waves = section.flag_or(&k::WAKE_BRAGG, bragg_by_default && !tracked);
    if tracked && short_waves == Some(true) {
        let error = "short waves are those of a straight course; allowed with a track: wake_bragg = false";
        section.fault(&k::WAKE_BRAGG, Problem::Refused { error: error.to_owned() });
    }
    let turbulent = section.switched(&k::TURBULENT).map(|section| section.map(turbulent));
    let echo = section.flag(&k::ECHO);
    let mesh = ship_mesh::mesh(&section, echo, &k::PANEL_M);
    let rides = mesh.as_ref().is_some_and(|mesh| mesh.motion != ShipMotion::Level);
    if rides && tracked {
        let error = "waves move ships that sail straight on; allowed with a track: motion = \"level\"";
        section.fault(&k::MOTION, Problem::Refused { error: error.to_owned() });
    }
    section.finish();
    let (position_m, heading_rad, speed_mps, trajectory) = course?;
    if !(sound_length && sound_limit) {
        return None;
    }
    Some(Ship {
        name: name?,
        hull: hull?,
        length_m,
        position_m,
        heading_rad,
        speed_mps,
        trajectory,
        kelvin: wake?.then_some(KelvinWake { band_limit_radpm, short_waves: short_waves? }),
        turbulent: match turbulent? {
            Some(turbulent) => Some(turbulent?),
            None => None,
        },
        echo: echo?,
        mesh: mesh?,
        panels: Arc::default(),
    })
}

fn hull(section: &Section<'_>) -> Option<HullGiven> {
    use keys::ship::{BEAM_M, DRAUGHT_M, HULL, LENGTH_M};
    match section.file_or(&HULL) {
        Some(Some(path)) => {
            section.idle(&[&BEAM_M, &DRAUGHT_M], "the hull is that of a file");
            Some(HullGiven::File(path))
        }
        Some(None) => {
            if !section.has(&LENGTH_M) {
                let allowed = LENGTH_M.kind.allowed();
                section.fault(&LENGTH_M, Problem::NeedsLength { allowed });
            }
            let (beam_m, draught_m) = (section.number(&BEAM_M), section.number(&DRAUGHT_M));
            Some(HullGiven::Wigley { beam_m: beam_m?, draught_m: draught_m? })
        }
        None => {
            // It is not known whether these belong here: they are read where they are written.
            for key in [&BEAM_M, &DRAUGHT_M].into_iter().filter(|key| section.has(key)) {
                section.number(key);
            }
            None
        }
    }
}
