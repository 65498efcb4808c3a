//! Ships under way.

use std::sync::Arc;

use super::ais;
use super::place;
use super::ship_mesh;
use super::turbulent::turbulent;
use super::{Ground, Names};
use crate::config::error::Problem;
use crate::config::keys::{self, MOST_SHIPS};
use crate::config::section::Section;
use crate::scene::Ship;
use crate::scene::ship::{HullGiven, KelvinWake};
use crate::time::TimeTag;

/// Carrier below which short waves of ships scatter by default.
const BRAGG_BELOW_HZ: f64 = 6e9;

/// `[[ship]]`, then `[[ais]]`.
pub(super) fn ships(root: &Section<'_>, ground: &Ground, start: Option<TimeTag>) -> Option<Vec<Ship>> {
    let carrier_hz = root.peek_in(&keys::root::RADAR, &keys::radar::CARRIER_HZ);
    let bragg = carrier_hz.is_some_and(|carrier_hz| carrier_hz < BRAGG_BELOW_HZ);
    let mut names = Names::new("ship");
    let mut ships = Vec::new();
    for (index, section) in root.sections(&keys::root::SHIP).into_iter().enumerate() {
        names.take_or(&section, &keys::ship::NAME, Some(format!("ship-{index}")));
        ships.push(ship(section, names.last(), ground, bragg));
    }
    for section in root.sections(&keys::root::AIS) {
        ships.extend(ais::ships(section, ground, start, bragg, &mut names));
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

fn ship(section: Section<'_>, name: Option<String>, ground: &Ground, bragg_by_default: bool) -> Option<Ship> {
    use keys::ship as k;
    let hull = hull(&section);
    let length_m = section.number(&k::LENGTH_M);
    let sound_length = length_m.is_some() || !section.has(&k::LENGTH_M);
    let position_m = place::on_sea(&section, [&k::POSITION_M, &k::LAT_DEG, &k::LON_DEG], ground);
    let written = section.exactly_one(&[&k::HEADING_DEG, &k::TOWARDS_DEG]);
    let (heading_deg, towards_deg) = (section.number(&k::HEADING_DEG), section.number(&k::TOWARDS_DEG));
    let speed_mps = section.number(&k::SPEED_MPS);
    let wake = section.flag(&k::WAKE);
    if wake == Some(false) {
        section.idle(&[&k::BAND_LIMIT_RADPM, &k::WAKE_BRAGG], "wake = false");
    }
    let band_limit_radpm = section.number(&k::BAND_LIMIT_RADPM);
    let sound_limit = band_limit_radpm.is_some() || !section.has(&k::BAND_LIMIT_RADPM);
    let short_waves = section.flag_or(&k::WAKE_BRAGG, bragg_by_default);
    let turbulent = section.switched(&k::TURBULENT).map(|section| section.map(turbulent));
    let echo = section.flag(&k::ECHO);
    let mesh = ship_mesh::mesh(&section, echo, &k::PANEL_M);
    section.finish();
    written?;
    if !(sound_length && sound_limit) {
        return None;
    }
    Some(Ship {
        name: name?,
        hull: hull?,
        length_m,
        position_m: position_m?,
        heading_rad: towards_deg.or(heading_deg.map(|heading_deg| 90.0 - heading_deg))?.to_radians(),
        speed_mps: speed_mps?,
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
