//! Point targets.

use num_complex::Complex64;

use super::place::{self, SurfaceKeys};
use super::{Ground, Names, plausible, way};
use crate::config::choices::{Alignment, HeightsKind, Waves};
use crate::config::error::Problem;
use crate::config::keys::{self, Key, MOST_FLOATING, MOST_TARGETS};
use crate::config::section::Section;
use crate::frames::{Enu, Point, Vector};
use crate::scene::target::{Aspect, Floating, Swerling};
use crate::scene::{Target, Trajectory};
use crate::units::Decibels;

/// `[[target]]`, then `[[target_grid]]`.
pub(super) fn targets(root: &Section<'_>, ground: &Ground, run: way::Run) -> Option<Vec<Target>> {
    let mut names = Names::new("target");
    let mut targets = Vec::new();
    let mut sound = true;
    let choppy = root.peek_choice_in(&keys::root::SEA, &keys::sea::WAVES) == Some(Waves::Choppy);
    for (index, section) in root.sections(&keys::root::TARGET).into_iter().enumerate() {
        names.take_or(&section, &keys::target::NAME, Some(format!("target-{index}")));
        match target(section, (root.has(&keys::root::SEA), choppy), names.last(), ground, run) {
            Some(target) => targets.push(target),
            None => sound = false,
        }
    }
    let grids = root.sections(&keys::root::TARGET_GRID);
    let mut grid_names = Names::new("target_grid");
    for (index, section) in grids.into_iter().enumerate() {
        grid_names.take_or(&section, &keys::target_grid::NAME, Some(format!("grid-{index}")));
        let first = targets.len();
        match grid(section, grid_names.last(), ground, &mut targets) {
            Some(()) => {
                for target in &targets[first..] {
                    // Only a [[target]] can have taken such a name: grids have names of their own.
                    if names.has(&target.name) {
                        let problem = Problem::Duplicate { name: target.name.clone(), what: "target" };
                        root.fault(&keys::root::TARGET_GRID, problem);
                    }
                }
            }
            None => sound = false,
        }
    }
    let floating = targets.iter().filter(|target| target.floating.is_some()).count() as u64;
    if floating > MOST_FLOATING {
        let (count, allowed) = (floating, MOST_FLOATING);
        root.fault_here(Problem::TooMany { count, what: "targets that float", allowed });
        sound = false;
    }
    let count = targets.len() as u64;
    if count > MOST_TARGETS {
        root.fault_here(Problem::TooMany { count, what: "targets", allowed: MOST_TARGETS });
        sound = false;
    }
    sound.then_some(targets)
}

fn target(
    section: Section<'_>,
    sea: (bool, bool),
    name: Option<String>,
    ground: &Ground,
    run: way::Run,
) -> Option<Target> {
    use keys::target as k;
    let tracked = section.has(&k::TRACK);
    let trajectory = if tracked { track(&section, ground, run) } else { None };
    if !tracked {
        section.section(&k::TRACK);
    }
    let surface = SurfaceKeys {
        position_m: &k::POSITION_M,
        lat_deg: &k::LAT_DEG,
        lon_deg: &k::LON_DEG,
        height_m: if section.has(&k::POSITION_M) { None } else { Some(&k::HEIGHT_M) },
    };
    let now = trajectory.as_ref().map(|way| way.at(0.0));
    let position =
        if tracked { now.map(|now| now.position) } else { place::above_sea(&section, &surface, ground) };
    let heights = section.peek_choice_in::<HeightsKind>(&k::TRACK, &keys::way::HEIGHTS);
    let own_heights = heights == Some(HeightsKind::Recorded);
    if own_heights {
        section.idle(&[&k::HEIGHT_M], "heights = \"recorded\"");
    } else if let Some(position) = position {
        plausible::target(&section, [&k::POSITION_M, &k::HEIGHT_M], position, ground);
    }
    let velocity = if tracked { now.map(|now| now.velocity) } else { velocity(&section, &k::VELOCITY_MPS) };
    let scattering = scattering(&section);
    let aspect = aspect(&section, velocity, tracked);
    let swerling = swerling(&section, &k::SWERLING, &k::SWERLING_SCAN_S);
    if own_heights && section.flag(&k::FLOATING) == Some(true) {
        let error = "the sea lifts a floating target, whose heights are recorded too; allowed with floating = true: \
                     heights = \"sea\"";
        section.fault(&k::FLOATING, Problem::Refused { error: error.to_owned() });
    }
    let floating = floating(&section, sea, velocity.filter(|_| !tracked));
    let multipath = section.flag(&k::MULTIPATH);
    if multipath == Some(true) && !sea.0 {
        section.fault(&k::MULTIPATH, Problem::Idle { when: "there is no [sea] that reflects".to_owned() });
    }
    section.finish();
    Some(Target {
        floating: floating?,
        multipath: multipath?,
        swerling: swerling?,
        aspect: aspect?,
        trajectory,
        ..Target::new(name?, position?, velocity?, scattering?)
    })
}

/// How it moves on a track, which stands for its place and velocity.
fn track(section: &Section<'_>, ground: &Ground, run: way::Run) -> Option<Trajectory> {
    use keys::target as k;
    section.idle(&[&k::POSITION_M, &k::LAT_DEG, &k::LON_DEG, &k::VELOCITY_MPS], "the target has a track");
    let height_m = section.number(&k::HEIGHT_M);
    section.section(&k::TRACK).and_then(|table| way::way(table, ground, run, way::Mover::Target(height_m)))
}

/// The file of cross sections by aspect, where there is one.
fn aspect(section: &Section<'_>, velocity: Option<Vector<Enu>>, tracked: bool) -> Option<Option<Aspect>> {
    use keys::target::{HEADING_DEG, RCS_CSV, RCS_FLOOR_DBSM};
    let (path, floor_dbsm) = (section.file(&RCS_CSV), section.number(&RCS_FLOOR_DBSM));
    let heading_deg = section.number(&HEADING_DEG);
    if !section.has(&RCS_CSV) {
        for key in [&HEADING_DEG, &RCS_FLOOR_DBSM] {
            if section.has(key) {
                section.fault(key, Problem::Idle { when: "the target has no rcs_csv".to_owned() });
            }
        }
        return Some(None);
    }
    let heading_rad = if section.has(&HEADING_DEG) {
        Some(heading_deg?.to_radians())
    } else if tracked {
        None
    } else {
        let [east, north, _] = velocity?.to_array();
        if east == 0.0 && north == 0.0 {
            let allowed = format!("with rcs_csv, of a target at rest: {}", HEADING_DEG.kind.allowed());
            section.fault(&HEADING_DEG, Problem::Missing { allowed });
            return None;
        }
        Some(east.atan2(north))
    };
    Some(Some(Aspect { path: path?, heading_rad, floor_dbsm: floor_dbsm? }))
}

/// How it floats, if it does, where there is a sea, and whether that is choppy.
fn floating(
    section: &Section<'_>,
    (sea, choppy): (bool, bool),
    velocity: Option<Vector<Enu>>,
) -> Option<Option<Floating>> {
    use keys::target::{FLOATING, VELOCITY_MPS, WATERLINE_M};
    let (floats, waterline_m) = (section.flag(&FLOATING), section.number(&WATERLINE_M));
    if !floats? {
        if section.has(&WATERLINE_M) {
            section.fault(&WATERLINE_M, Problem::Idle { when: "floating = false".to_owned() });
        }
        return Some(None);
    }
    if !sea {
        section.fault(&FLOATING, Problem::Idle { when: "there is no [sea] to float on".to_owned() });
    }
    if choppy {
        let error = "a floating target rides on linear waves, apart from the choppy ones around it; allowed: \
                     sea.waves = \"linear\", or floating = false";
        section.fault(&FLOATING, Problem::Refused { error: error.to_owned() });
    }
    if velocity.is_some_and(|velocity| velocity.to_array()[2] != 0.0) {
        let error = "a floating target rises with the sea alone; allowed: [east, north, 0]".to_owned();
        section.fault(&VELOCITY_MPS, Problem::Refused { error });
    }
    Some(Some(Floating { waterline_m: waterline_m? }))
}

/// Swerling's case, and its scan where it has one.
fn swerling(section: &Section<'_>, case: &'static Key, scan_s: &'static Key) -> Option<Swerling> {
    let number = section.count(case);
    let length_s = section.number(scan_s);
    let scans = matches!(number?, 1 | 3);
    if scans && !section.has(scan_s) {
        section.fault(scan_s, Problem::Missing { allowed: scan_s.kind.allowed() });
    }
    if !scans && section.has(scan_s) {
        let when = "only swerling 1 and 3 are constant over a scan".to_owned();
        section.fault(scan_s, Problem::Idle { when });
    }
    match number? {
        1 => length_s.map(|scan_s| Swerling::Case1 { scan_s }),
        2 => Some(Swerling::Case2),
        3 => length_s.map(|scan_s| Swerling::Case3 { scan_s }),
        4 => Some(Swerling::Case4),
        _ => Some(Swerling::Steady),
    }
}

fn velocity(section: &Section<'_>, key: &'static Key) -> Option<Vector<Enu>> {
    section.vector(key).map(|[e, n, u]| Vector::new(e, n, u))
}

fn scattering(section: &Section<'_>) -> Option<[[Complex64; 2]; 2]> {
    use keys::target::{CONVENTION, RCS_CSV, RCS_DBSM, RCS_M2, S_HH, S_HV, S_VH, S_VV};
    let elements = [&S_VV, &S_VH, &S_HV, &S_HH];
    let matrix = elements.iter().any(|key| section.has(key));
    let table = section.has(&RCS_CSV);
    let others = [&RCS_M2, &RCS_DBSM].into_iter().filter(|key| section.has(key)).count();
    let written = usize::from(matrix) + usize::from(table) + others;
    let rcs_m2 = section.number(&RCS_M2);
    let rcs_dbsm = section.number(&RCS_DBSM);
    let values = elements.map(|key| {
        let value = section.vector::<2>(key);
        if section.has(key) { value } else { Some([0.0, 0.0]) }
    });
    let convention = if matrix { section.choice(&CONVENTION) } else { Some(Alignment(1.0)) };
    let keys = "rcs_m2, rcs_dbsm, rcs_csv, (s_vv, s_vh, s_hv, s_hh)".to_owned();
    match written {
        0 => section.fault_here(Problem::NoneOf { keys }),
        1 => {}
        _ => section.fault_here(Problem::Several { keys }),
    }
    if written != 1 {
        return None;
    }
    if table {
        // Its mean takes the place, once the file is read.
        return Some(Target::sphere(1.0));
    }
    if !matrix {
        return Some(Target::sphere(rcs_m2.or(rcs_dbsm.map(|db| Decibels(db).power_ratio()))?));
    }
    let [vv, vh, hv, hh] = values;
    let complex = |[re, im]: [f64; 2]| Complex64::new(re, im);
    // The received h of the forward-scatter alignment is the opposite of the back-scatter one.
    let Alignment(sign) = convention?;
    Some([[complex(vv?), complex(vh?)], [complex(hv?) * sign, complex(hh?) * sign]])
}

fn grid(
    section: Section<'_>,
    name: Option<String>,
    ground: &Ground,
    targets: &mut Vec<Target>,
) -> Option<()> {
    use keys::target_grid as k;
    let surface = SurfaceKeys {
        position_m: &k::POSITION_M,
        lat_deg: &k::LAT_DEG,
        lon_deg: &k::LON_DEG,
        height_m: if section.has(&k::POSITION_M) { None } else { Some(&k::HEIGHT_M) },
    };
    let centre = place::above_sea(&section, &surface, ground);
    if let Some(centre) = centre {
        plausible::target(&section, [&k::POSITION_M, &k::HEIGHT_M], centre, ground);
    }
    let count = match section.vector::<2>(&k::COUNT) {
        Some(count) if count.iter().any(|n| n.fract() != 0.0) => {
            let problem = Problem::Type {
                found: format!("{count:?}"),
                allowed: "two whole numbers from 1 to 1000".to_owned(),
            };
            section.fault(&k::COUNT, problem);
            None
        }
        Some([columns, rows]) if targets.len() as u64 + (columns * rows) as u64 > MOST_TARGETS => {
            let count = targets.len() as u64 + (columns * rows) as u64;
            section.fault(&k::COUNT, Problem::TooMany { count, what: "targets", allowed: MOST_TARGETS });
            None
        }
        other => other,
    };
    let spacing = section.vector::<2>(&k::SPACING_M);
    let velocity = velocity(&section, &k::VELOCITY_MPS);
    let written = section.exactly_one(&[&k::RCS_M2, &k::RCS_DBSM]);
    let rcs_m2 = section.number(&k::RCS_M2);
    let rcs_dbsm = section.number(&k::RCS_DBSM);
    let swerling = swerling(&section, &k::SWERLING, &k::SWERLING_SCAN_S);
    section.finish();
    written?;
    let (name, centre, velocity, swerling) = (name?, centre?, velocity?, swerling?);
    let ([columns, rows], [east_m, north_m]) = (count?, spacing?);
    let scattering = Target::sphere(rcs_m2.or(rcs_dbsm.map(|db| Decibels(db).power_ratio()))?);
    let [x_m, y_m, z_m] = centre.to_array();
    let height_m = z_m + ground.frame.earth().drop_m(x_m, y_m);
    // Whole numbers up to 1000: the casts are exact.
    for column in 0..columns as usize {
        for row in 0..rows as usize {
            let x_m = x_m + (column as f64 - (columns - 1.0) / 2.0) * east_m;
            let y_m = y_m + (row as f64 - (rows - 1.0) / 2.0) * north_m;
            let position: Point<Enu> = ground.frame.above_sea(x_m, y_m, height_m);
            let name = format!("{name}-{column}-{row}");
            targets.push(Target { swerling, ..Target::new(name, position, velocity, scattering) });
        }
    }
    Some(())
}
