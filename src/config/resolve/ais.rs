//! Ships of recorded AIS logs.
//!
//! Of every vessel the report nearest to the start that has course and speed is taken and carried along its
//! course to that instant; from there the ship sails straight on. Speed over the ground is taken for the
//! speed through the water: currents are not known. Courses are turned from the North of the ship's place to
//! that of the scene, by the convergence of meridians `(lon - lon_0) sin lat`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::{Ground, Names};
use crate::config::error::{Problem, Warning};
use crate::config::keys;
use crate::config::resolve::plausible;
use crate::config::resolve::ship_mesh;
use crate::config::resolve::turbulent::turbulent;
use crate::config::section::Section;
use crate::frames::Geodetic;
use crate::nav::ais::{self, Log, Report};
use crate::scene::Ship;
use crate::scene::ship::{HullGiven, KelvinWake, ShipMesh, TurbulentWake};
use crate::time::TimeTag;

/// Fastest ship, m/s.
const MOST_SPEED_MPS: f64 = 100.0;
/// Beam and draught of DTMB 5415 over its length.
const SHAPE: [f64; 2] = [0.134, 0.043];
/// Panels along a length, unless it is said how long they are.
const PANELS_A_LENGTH: f64 = 50.0;

/// Which vessels sail, and as what.
struct Choice {
    start: TimeTag,
    /// `None` for the Wigley hull of each vessel.
    hull: Option<PathBuf>,
    length_m: f64,
    most_age_s: f64,
    least_speed_mps: f64,
    within_m: f64,
    kelvin: Option<KelvinWake>,
    turbulent: Option<TurbulentWake>,
    echo: bool,
    mesh: ShipMesh,
    /// Whether it says how long panels are; else there are [`PANELS_A_LENGTH`].
    own_panel_m: bool,
}

/// Vessels left out.
#[derive(Default)]
struct LeftOut {
    old: usize,
    unknown: usize,
    at_rest: usize,
    far: usize,
}

/// One `[[ais]]`.
pub(super) fn ships(
    section: Section<'_>,
    ground: &Ground,
    scene_start: Option<TimeTag>,
    bragg_by_default: bool,
    names: &mut Names,
) -> Vec<Option<Ship>> {
    use keys::ais as k;
    let log = section.file(&k::LOG);
    let mmsi = section.numbers(&k::MMSI);
    let sound_mmsi = mmsi.is_some() || !section.has(&k::MMSI);
    let given = section.time(&k::START_UTC);
    let start = if section.has(&k::START_UTC) { given } else { scene_start };
    if start.is_none() && !section.has(&k::START_UTC) {
        section.fault(&k::START_UTC, Problem::NeedsStart);
    }
    let hull = if section.has(&k::HULL) { section.file_or(&k::HULL) } else { Some(None) };
    let length_m = section.number(&k::LENGTH_M);
    let most_age_s = section.number(&k::MOST_AGE_S);
    let least_speed_mps = section.number(&k::LEAST_SPEED_MPS);
    let within_m = section.number(&k::WITHIN_M);
    let wake = section.flag(&k::WAKE);
    if wake == Some(false) {
        section.idle(&[&k::WAKE_BRAGG], "wake = false");
    }
    let short_waves = section.flag_or(&k::WAKE_BRAGG, bragg_by_default);
    let turbulent = section.switched(&k::TURBULENT).map(|section| section.map(turbulent));
    let echo = section.flag(&k::ECHO);
    let mesh = ship_mesh::mesh(&section, echo, &k::PANEL_M);
    let anchored = ground.geodetic_allowed();
    if !anchored {
        section.fault(&k::LOG, Problem::LogNeedsOrigin);
    }
    let choice = || {
        Some(Choice {
            start: start?,
            hull: hull?,
            length_m: length_m?,
            most_age_s: most_age_s?,
            least_speed_mps: least_speed_mps?,
            within_m: within_m?,
            kelvin: wake?.then_some(KelvinWake { band_limit_radpm: None, short_waves: short_waves? }),
            turbulent: match turbulent? {
                Some(turbulent) => Some(turbulent?),
                None => None,
            },
            echo: echo?,
            mesh: mesh.clone()?,
            own_panel_m: section.has(&k::PANEL_M),
        })
    };
    if log.as_ref().is_some_and(|path| section.reader().is_left_aside(path)) {
        section.finish();
        return Vec::new();
    }
    let reports = log.and_then(|path| match ais::load(&path) {
        Ok(Log { reports, passed_over }) => {
            let log = path.display().to_string();
            if !passed_over.is_nothing() {
                let (log, reports) = (log.clone(), reports.len());
                section.reader().warn(Warning::AisPassedOver { log, reports, passed_over });
            }
            Some((log, reports))
        }
        Err(error) => {
            section.fault(&k::LOG, Problem::Log { error: error.to_string() });
            None
        }
    });
    let found = match (choice(), reports) {
        (Some(choice), Some((log, reports))) if sound_mmsi && anchored => {
            sail(&section, ground, &choice, &log, &reports, mmsi.as_deref(), names)
        }
        _ => vec![None],
    };
    section.finish();
    found
}

fn sail(
    section: &Section<'_>,
    ground: &Ground,
    choice: &Choice,
    log: &str,
    reports: &[Report],
    wanted: Option<&[f64]>,
    names: &mut Names,
) -> Vec<Option<Ship>> {
    use keys::ais::{LOG, MMSI};
    let mut nearest: BTreeMap<u32, (f64, &Report)> = BTreeMap::new();
    let says_nothing = |report: &Report| motion(report).is_none();
    for report in reports {
        let age_s = report.time.since(choice.start).abs();
        let best = nearest.entry(report.mmsi).or_insert((age_s, report));
        if (says_nothing(report), age_s) < (says_nothing(best.1), best.0) {
            *best = (age_s, report);
        }
    }
    if let Some(wanted) = wanted {
        let vessels: BTreeSet<u64> = nearest.keys().map(|known| u64::from(*known)).collect();
        // Whole numbers, as the key has it.
        let missing = wanted.iter().find(|mmsi| mmsi.fract() != 0.0 || !vessels.contains(&(**mmsi as u64)));
        if let Some(missing) = missing {
            let known: Vec<String> = nearest.keys().take(20).map(u32::to_string).collect();
            let more = if nearest.len() > known.len() { ", ..." } else { "" };
            let known = format!("{}{more}", known.join(", "));
            section.fault(&MMSI, Problem::NoSuch { name: missing.to_string(), what: "vessel", known });
            return vec![None];
        }
        let chosen: BTreeSet<u64> = wanted.iter().map(|mmsi| *mmsi as u64).collect();
        nearest.retain(|known, _| chosen.contains(&u64::from(*known)));
    }
    let mut left_out = LeftOut::default();
    let mut ships = Vec::new();
    for (age_s, report) in nearest.values() {
        let Some(ship) = ship(ground, choice, *age_s, report, &mut left_out) else { continue };
        if names.has(&ship.name) {
            section.fault(&LOG, Problem::Duplicate { name: ship.name, what: "ship" });
            return vec![None];
        }
        names.push(Some(ship.name.clone()));
        ships.push(Some(ship));
    }
    if ships.is_empty() {
        let LeftOut { old, unknown, at_rest, far } = left_out;
        let why = format!(
            "{old} have no report within most_age_s, {unknown} no course or speed, {at_rest} are slower than \
             least_speed_mps, {far} are beyond within_m"
        );
        let swapped = nearest.values().any(|(_, report)| {
            plausible::swapped(ground, Geodetic::from_deg(report.lat_deg, report.lon_deg, 0.0))
        });
        let vessels = nearest.len();
        let problem = Problem::NobodySails { log: log.to_owned(), vessels, why, swapped };
        section.fault(&LOG, problem);
        return vec![None];
    }
    ships
}

/// Course and speed of a report, where both are those of a ship.
fn motion(report: &Report) -> Option<(f64, f64)> {
    report.course_deg.zip(report.speed_mps.filter(|speed| *speed <= MOST_SPEED_MPS))
}

/// The ship of a report, if it is under way there and then.
fn ship(
    ground: &Ground,
    choice: &Choice,
    age_s: f64,
    report: &Report,
    left_out: &mut LeftOut,
) -> Option<Ship> {
    if age_s > choice.most_age_s {
        left_out.old += 1;
        return None;
    }
    let Some((course_deg, speed_mps)) = motion(report) else {
        left_out.unknown += 1;
        return None;
    };
    if speed_mps < choice.least_speed_mps {
        left_out.at_rest += 1;
        return None;
    }
    let origin = ground.frame.origin()?;
    let at = Geodetic::from_deg(report.lat_deg, report.lon_deg, ground.origin_h_m?);
    let turn = (at.lon_rad - origin.lon_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
        - std::f64::consts::PI;
    let heading_rad = (90.0 - course_deg).to_radians() + turn * at.lat_rad.sin();
    let placed = ground.frame.from_geodetic(at).map(|point| {
        let [x_m, y_m, _] = point.to_array();
        let way_m = speed_mps * choice.start.since(report.time);
        [x_m + way_m * heading_rad.cos(), y_m + way_m * heading_rad.sin()]
    });
    let Some(position_m) = placed.filter(|[x_m, y_m]| x_m.hypot(*y_m) <= choice.within_m) else {
        left_out.far += 1;
        return None;
    };
    let [length_m, beam_m, draught_m] = report.size_m;
    let length_m = length_m.unwrap_or(choice.length_m).max(0.05);
    let hull = match &choice.hull {
        Some(path) => HullGiven::File(path.clone()),
        None => HullGiven::Wigley {
            beam_m: beam_m.unwrap_or(SHAPE[0] * length_m).clamp(1e-4 * length_m, length_m),
            draught_m: draught_m.unwrap_or(SHAPE[1] * length_m).clamp(1e-4 * length_m, length_m),
        },
    };
    Some(Ship {
        name: format!("mmsi-{}", report.mmsi),
        hull,
        length_m: Some(length_m),
        position_m,
        heading_rad,
        speed_mps,
        kelvin: choice.kelvin,
        turbulent: choice.turbulent,
        echo: choice.echo,
        mesh: ShipMesh {
            panel_m: if choice.own_panel_m { choice.mesh.panel_m } else { length_m / PANELS_A_LENGTH },
            ..choice.mesh.clone()
        },
        panels: Default::default(),
    })
}
