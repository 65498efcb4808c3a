//! Ships of recorded AIS logs.
//!
//! Of every vessel the report nearest to the start that has course and speed is taken and carried along its
//! course to that instant; from there the ship sails straight on. One that follows its reports goes through
//! those that it can have made ([`crate::motion::reported_courses`]). Speed over the ground is taken for the
//! speed through the water: currents are not known. Courses are turned from the North of the ship's place to
//! that of the scene, by the convergence of meridians `(lon - lon_0) sin lat`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::{Ground, Names, way};
use crate::config::error::{Problem, Warning};
use crate::config::keys;
use crate::config::resolve::plausible as unlikely;
use crate::config::resolve::ship_mesh;
use crate::config::resolve::turbulent::turbulent;
use crate::config::section::Section;
use crate::frames::Geodetic;
use crate::motion::reported_courses::{Reported, knots, plausible};
use crate::nav::ais::{self, Log, Report};
use crate::scene::ship::{HullGiven, KelvinWake, Sailed, ShipMesh, ShipMotion, TurbulentWake};
use crate::scene::{Ship, Trajectory};
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
    /// Of vessels that follow their reports: the fastest turn, rad/s, and how long the run lasts, s.
    follow: Option<(f64, f64)>,
}

/// Vessels left out.
#[derive(Default)]
struct LeftOut {
    old: usize,
    unknown: usize,
    at_rest: usize,
    far: usize,
    /// They stop on their way.
    stopping: usize,
}

/// One `[[ais]]`.
pub(super) fn ships(
    section: Section<'_>,
    (ground, run): (&Ground, way::Run),
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
    let (follow, turn) = (section.flag(&k::FOLLOW), section.number(&k::MAX_TURN_DEGPS));
    let follows = follow == Some(true);
    if follow == Some(false) {
        section.idle(&[&k::MAX_TURN_DEGPS], "follow = false");
    }
    let short_waves = section.flag_or(&k::WAKE_BRAGG, bragg_by_default && !follows);
    if follows && short_waves == Some(true) {
        let error = "short waves are those of a straight course; allowed with follow: wake_bragg = false";
        section.fault(&k::WAKE_BRAGG, Problem::Refused { error: error.to_owned() });
    }
    let turbulent = section.switched(&k::TURBULENT).map(|section| section.map(turbulent));
    let echo = section.flag(&k::ECHO);
    let mesh = ship_mesh::mesh(&section, echo, &k::PANEL_M);
    if follows && mesh.as_ref().is_some_and(|mesh| mesh.motion != ShipMotion::Level) {
        let error = "waves move ships that sail straight on; allowed with follow: motion = \"level\"";
        section.fault(&k::MOTION, Problem::Refused { error: error.to_owned() });
    }
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
            follow: if follow? { Some((turn?.to_radians(), run.duration_s?)) } else { None },
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
    let (mut ships, mut refused, mut silent) = (Vec::new(), 0, 0);
    for (age_s, report) in nearest.values() {
        let Some(ship) = ship(ground, choice, *age_s, report, &mut left_out) else { continue };
        let own = reports.iter().filter(|of| of.mmsi == report.mmsi);
        let followed = match choice.follow {
            None => Ok(ship),
            Some(follow) => follow_reports(ground, choice, follow, own, ship, &mut refused),
        };
        let ship = match followed {
            Ok(ship) => ship,
            Err(Lost::Old) => {
                left_out.old += 1;
                silent += 1;
                continue;
            }
            Err(Lost::Stopping) => {
                left_out.stopping += 1;
                continue;
            }
        };
        if names.has(&ship.name) {
            section.fault(&LOG, Problem::Duplicate { name: ship.name, what: "ship" });
            return vec![None];
        }
        names.push(Some(ship.name.clone()));
        ships.push(Some(ship));
    }
    if ships.is_empty() {
        let LeftOut { old, unknown, at_rest, far, stopping } = left_out;
        let why = format!(
            "{old} have no report within most_age_s, {unknown} no course or speed, {at_rest} are slower than \
             least_speed_mps, {far} are beyond within_m"
        );
        let why = if stopping > 0 { format!("{why}, {stopping} stop on their way") } else { why };
        let swapped = nearest.values().any(|(_, report)| {
            unlikely::swapped(ground, Geodetic::from_deg(report.lat_deg, report.lon_deg, 0.0))
        });
        let vessels = nearest.len();
        let problem = Problem::NobodySails { log: log.to_owned(), vessels, why, swapped };
        section.fault(&LOG, problem);
        return vec![None];
    }
    let LeftOut { stopping, .. } = left_out;
    if refused + stopping + silent > 0 {
        let log = log.to_owned();
        section.reader().warn(Warning::AisFollowed { log, refused, stopping, silent });
    }
    ships
}

/// Why a vessel cannot be followed.
enum Lost {
    /// Its reports do not cover the run.
    Old,
    /// It is nowhere to head when it stops.
    Stopping,
}

/// The ship on the way through the reports of its vessel; on its straight course where there is one report.
fn follow_reports<'a>(
    ground: &Ground,
    choice: &Choice,
    (most_turn_radps, duration_s): (f64, f64),
    reports: impl Iterator<Item = &'a Report>,
    ship: Ship,
    refused: &mut usize,
) -> Result<Ship, Lost> {
    let of = |report: &Report| {
        let (course_deg, speed_mps) = motion(report)?;
        let (position_m, heading_rad) = placed(ground, report, course_deg)?;
        let (sin, cos) = heading_rad.sin_cos();
        let time_s = report.time.since(choice.start);
        Some(Reported { time_s, position_m, velocity_mps: [speed_mps * cos, speed_mps * sin] })
    };
    let mut own: Vec<Reported> = reports.filter_map(of).collect();
    own.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    let (kept, implausible) = plausible(&own, most_turn_radps);
    *refused += implausible;
    let Some(way) = Trajectory::new(way::at_height(ground, knots(&kept), 0.0)) else { return Ok(ship) };
    let [first_s, last_s] = way.span_s();
    let touches = |pair: &[Reported]| pair[0].time_s < duration_s && pair[1].time_s > 0.0;
    let gap_s = |pair: &[Reported]| pair[1].time_s - pair[0].time_s;
    let longest_s = kept.windows(2).filter(|pair| touches(pair)).map(gap_s).fold(0.0, f64::max);
    if first_s.max(duration_s - last_s).max(longest_s) > choice.most_age_s {
        return Err(Lost::Old);
    }
    let way = way::under_way(way, duration_s).map_err(|_| Lost::Stopping)?;
    let Sailed { position_m, velocity_mps: [vx, vy], ahead, .. } = Sailed::on(&way, 0.0, [1.0, 0.0]);
    Ok(Ship {
        position_m,
        heading_rad: ahead[1].atan2(ahead[0]),
        speed_mps: vx.hypot(vy),
        trajectory: Some(way),
        ..ship
    })
}

/// Where a report is in the scene, and where it heads, from East counter-clockwise.
fn placed(ground: &Ground, report: &Report, course_deg: f64) -> Option<([f64; 2], f64)> {
    let origin = ground.frame.origin()?;
    let at = Geodetic::from_deg(report.lat_deg, report.lon_deg, ground.origin_h_m?);
    let turn = (at.lon_rad - origin.lon_rad + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
        - std::f64::consts::PI;
    let heading_rad = (90.0 - course_deg).to_radians() + turn * at.lat_rad.sin();
    let [x_m, y_m, _] = ground.frame.from_geodetic(at)?.to_array();
    Some(([x_m, y_m], heading_rad))
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
    let carried = placed(ground, report, course_deg).map(|([x_m, y_m], heading_rad)| {
        let way_m = speed_mps * choice.start.since(report.time);
        ([x_m + way_m * heading_rad.cos(), y_m + way_m * heading_rad.sin()], heading_rad)
    });
    let near = |([x_m, y_m], _): &([f64; 2], f64)| x_m.hypot(*y_m) <= choice.within_m;
    let Some((position_m, heading_rad)) = carried.filter(near) else {
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
        trajectory: None,
        panels: Default::default(),
    })
}
