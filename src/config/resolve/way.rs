//! How ships and targets move that do not go straight on: recorded tracks and waypoints.

use super::Ground;
use super::{platform, plausible};
use crate::config::choices::{HeightsKind, WayKind};
use crate::config::error::{Problem, Warning};
use crate::config::keys::{Key, track, way as k};
use crate::config::section::Section;
use crate::frames::{Geodetic, Vector};
use crate::motion::{SourceReport, Track, waypoints};
use crate::nav::{FileFormat, FileSource, TrackSource};
use crate::scene::Trajectory;
use crate::scene::ship::Sailed;
use crate::scene::trajectory::Knot;
use crate::time::TimeTag;

/// Slowest ship on a track, m/s: slower ones have no course to head along.
const SLOWEST_MPS: f64 = 0.1;

/// When pulse 0 is emitted, where that is written, and how long the run lasts.
#[derive(Clone, Copy)]
pub(super) struct Run {
    pub(super) start: Option<TimeTag>,
    pub(super) duration_s: Option<f64>,
}

/// What moves.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Mover {
    Ship,
    /// Its height above the sea, where that is sound.
    Target(Option<f64>),
}

/// The trajectory of a table `track`.
pub(super) fn way(section: Section<'_>, ground: &Ground, run: Run, mover: Mover) -> Option<Trajectory> {
    let kind = section.choice(&k::KIND);
    let heights = section.choice(&k::HEIGHTS);
    if mover == Mover::Ship && heights == Some(HeightsKind::Recorded) {
        let error = "a ship sails on the sea; allowed: heights = \"sea\"".to_owned();
        section.fault(&k::HEIGHTS, Problem::Refused { error });
    }
    let knots = match kind {
        Some(WayKind::Waypoints) => {
            if heights == Some(HeightsKind::Recorded) {
                section.idle(&[&k::HEIGHTS], "waypoints have no heights");
            }
            through_waypoints(&section, ground).map(|knots| (knots, true))
        }
        Some(WayKind::Recorded(format)) => {
            let on_sea = heights != Some(HeightsKind::Recorded);
            recorded(&section, ground, run, (format, on_sea)).map(|knots| (knots, on_sea))
        }
        None => None,
    };
    let found = knots.and_then(|(knots, on_sea)| {
        let height_m = match mover {
            Mover::Ship => Some(0.0),
            Mover::Target(height_m) => height_m,
        };
        let knots = if on_sea { at_height(ground, knots, height_m?) } else { knots };
        let trajectory = Trajectory::new(knots);
        if trajectory.is_none() {
            let error = "its knots do not follow each other in time".to_owned();
            section.fault(&k::KIND, Problem::Refused { error });
        }
        if let (Mover::Target(_), false, Some(way)) = (mover, on_sea, &trajectory) {
            plausible::target(&section, [&k::DATUM, &k::PATH], way.at(0.0).position, ground);
        }
        match mover {
            Mover::Ship => trajectory.and_then(|way| sailed(&section, &k::KIND, way, run.duration_s)),
            Mover::Target(_) => trajectory,
        }
    });
    section.finish();
    found
}

/// The part of a way that a ship sails under way: the segments that touch a run of this length, and those
/// before and after them up to the nearest in which it is too slow to have a course.
///
/// # Errors
/// Its slowest speed, m/s, and when that is, s after pulse 0, if that is too slow in a segment that touches
/// the run.
pub(super) fn under_way(way: Trajectory, duration_s: f64) -> Result<Trajectory, (f64, f64)> {
    let knots = way.knots();
    let last = knots.len() - 2;
    let begins = knots.windows(2).position(|pair| pair[1].time_s > 0.0).unwrap_or(last);
    let ends = knots.windows(2).rposition(|pair| pair[0].time_s < duration_s).unwrap_or(0);
    let (mut begin, mut end) = (begins.min(ends), begins.max(ends));
    let fast = |segment: usize| slowest(&way, &knots[segment..segment + 2]).0 >= SLOWEST_MPS;
    let slow = slowest(&way, &knots[begin..end + 2]);
    if slow.0 < SLOWEST_MPS {
        return Err(slow);
    }
    while begin > 0 && fast(begin - 1) {
        begin -= 1;
    }
    while end < last && fast(end + 1) {
        end += 1;
    }
    Ok(Trajectory::new(knots[begin..end + 2].to_vec()).unwrap_or(way))
}

/// The slowest speed between knots of a way, m/s, and when that is, s after pulse 0.
fn slowest(way: &Trajectory, knots: &[Knot]) -> (f64, f64) {
    let speed_mps = |time_s: f64| {
        let [vx, vy] = Sailed::on(way, time_s, [1.0, 0.0]).velocity_mps;
        (vx.hypot(vy), time_s)
    };
    let inside = |pair: &[Knot]| {
        let step_s = (pair[1].time_s - pair[0].time_s) / 8.0;
        (0..=8).map(|n| speed_mps(pair[0].time_s + step_s * f64::from(n))).collect::<Vec<_>>()
    };
    let speeds = knots.windows(2).flat_map(inside);
    speeds.fold((f64::INFINITY, 0.0), |least, speed| if speed.0 < least.0 { speed } else { least })
}

/// The part of a way that a ship sails under way; a fault where it stops in the run.
fn sailed(section: &Section<'_>, key: &Key, way: Trajectory, duration_s: Option<f64>) -> Option<Trajectory> {
    let (slowest_mps, time_s) = match under_way(way, duration_s.unwrap_or(f64::INFINITY)) {
        Ok(way) => return Some(way),
        Err(slowest) => slowest,
    };
    let error = format!(
        "the ship makes {slowest_mps:.3} m/s {time_s:.1} s after pulse 0, too slow to head anywhere; \
         allowed: {SLOWEST_MPS} m/s or more throughout the run, or a ship without track at speed_mps = 0"
    );
    section.fault(key, Problem::Refused { error });
    None
}

/// Knots at a constant height above the mean sea.
pub(super) fn at_height(ground: &Ground, knots: Vec<Knot>, height_m: f64) -> Vec<Knot> {
    let earth = ground.frame.earth();
    let lifted = |knot: Knot| {
        let ([x, y, _], [vx, vy, _], [ax, ay, _]) =
            (knot.position.to_array(), knot.velocity.to_array(), knot.acceleration.to_array());
        let fall = earth.drop_slope(x, y);
        // A paraboloid: its slope is linear.
        let bent = earth.drop_slope(vx, vy);
        Knot {
            position: ground.frame.above_sea(x, y, height_m),
            velocity: Vector::new(vx, vy, -(fall[0] * vx + fall[1] * vy)),
            acceleration: Vector::new(ax, ay, -(fall[0] * ax + fall[1] * ay + bent[0] * vx + bent[1] * vy)),
            ..knot
        }
    };
    knots.into_iter().map(lifted).collect()
}

fn through_waypoints(section: &Section<'_>, ground: &Ground) -> Option<Vec<Knot>> {
    let written = section.exactly_one(&[&k::WAYPOINTS_M, &k::WAYPOINTS_DEG]);
    let (local, geodetic) = (section.points(&k::WAYPOINTS_M), section.points(&k::WAYPOINTS_DEG));
    let (speed_mps, radius_m) = (section.number(&k::SPEED_MPS), section.number(&k::TURN_RADIUS_M));
    let begin_s = section.number(&k::BEGIN_S);
    let key = written?;
    if section.has(&k::WAYPOINTS_DEG) && !ground.geodetic_allowed() {
        section.fault(&k::WAYPOINTS_DEG, Problem::NeedsOrigin);
        return None;
    }
    let on_earth = |points: Vec<[f64; 2]>| {
        let sea_m = ground.origin_h_m?;
        if let Some(index) = points.iter().position(|[lat_deg, _]| lat_deg.abs() > 90.0) {
            let found = format!("entry {index}, {:?},", points[index]);
            let allowed = "pairs [latitude, longitude], latitudes from -90 to 90 deg".to_owned();
            section.fault(&k::WAYPOINTS_DEG, Problem::Range { found, allowed });
            return None;
        }
        let place = |[lat_deg, lon_deg]: [f64; 2]| {
            let [x, y, _] =
                ground.frame.from_geodetic(Geodetic::from_deg(lat_deg, lon_deg, sea_m))?.to_array();
            Some([x, y])
        };
        points.into_iter().map(place).collect::<Option<Vec<_>>>()
    };
    let points = local.or_else(|| geodetic.and_then(on_earth))?;
    match waypoints::knots(&points, speed_mps?, radius_m?, begin_s?) {
        Ok(knots) => Some(knots),
        Err(fault) => {
            section.fault(key, Problem::Refused { error: fault.to_string() });
            None
        }
    }
}

fn recorded(
    section: &Section<'_>,
    ground: &Ground,
    run: Run,
    (format, on_sea): (FileFormat, bool),
) -> Option<Vec<Knot>> {
    let format = match format {
        FileFormat::Sbet { .. } => {
            let week = section.count(&track::GPS_WEEK).and_then(|week| u32::try_from(week).ok());
            FileFormat::Sbet { gps_week: week? }
        }
        format => format,
    };
    if on_sea && section.has(&k::DATUM) {
        section.idle(&[&k::DATUM, &k::BAROMETRIC_OFFSET_M], "heights = \"sea\"");
    }
    let source: FileSource = platform::recording(section, ground, format, on_sea)?;
    if section.reader().is_left_aside(&source.path) {
        return None;
    }
    let Some(start) = run.start else {
        section.fault(&k::PATH, Problem::NeedsStart);
        return None;
    };
    let fault = |error: String| {
        section.fault(&k::PATH, Problem::Refused { error });
        None
    };
    if !(ground.sound) {
        return None;
    }
    let path = source.path.display().to_string();
    let knots = match Track::from_source(&TrackSource::File(source), &ground.frame, start) {
        Ok((track, report)) => {
            let key = section.path_of(k::PATH.name);
            let noted = report.filter(SourceReport::is_noted).map(|report| report.to_string());
            noted
                .into_iter()
                .for_each(|report| section.reader().warn(Warning::TrackNoted { key: key.clone(), report }));
            track.knots(start)?
        }
        Err(error) => return fault(error.to_string()),
    };
    let (first_s, last_s) = (knots.first()?.time_s, knots.last()?.time_s);
    let duration_s = run.duration_s?;
    if first_s > 0.0 || last_s < duration_s {
        return fault(format!(
            "{path} covers {first_s:.3} to {last_s:.3} s after pulse 0, the run 0 to {duration_s} s; allowed: \
             a recording that covers the run (scene.start_utc, scene.duration_s)"
        ));
    }
    Some(knots)
}
