//! Where antennas are and look at the instants that CRSD asks for, as the platforms report it.
//!
//! Reports are given at emissions. Between them a phase centre is on the cubic through the four nearest, as
//! in [`PhasePath`]: the transmitter's at the middle of the pulse, the receiver's where its window opens. The
//! velocity is the platform's, interpolated alike; the turn of the lever arm is not in it (`w l`: 5 cm/s for
//! 1 m and 3 degrees a second). Axes are those at the emission: the true axes of the antenna in the body,
//! turned with the reported attitude.

use glam::{DQuat, DVec3};

use super::description::{Description, End};
use super::fault::CrsdError;
use crate::frames::{Enu, Point, Vector};
use crate::geometry::phase_path::PhasePath;
use crate::pulse::Pulse;
use crate::time::TimeTag;

/// Rows before a pulse from which its states are found.
pub(super) const BEFORE: usize = 64;
/// Rows beyond an instant from which the state there is found.
pub(super) const BEYOND: usize = 3;
/// Speed of a platform at rest, m/s, to the North: the angles of the reference geometry divide by it.
const AT_REST_MPS: f64 = 1e-9;

/// What is reported of an antenna at an emission, in the frame of the scene.
#[derive(Clone, Copy, Debug)]
pub struct AntennaRow {
    pub centre_m: [f64; 3],
    pub velocity_mps: [f64; 3],
    /// Antenna to the frame of the scene.
    pub axes: DQuat,
}

/// What is reported at an emission.
#[derive(Clone, Debug)]
pub(super) struct PulseRow {
    pub index: u64,
    pub time: TimeTag,
    pub window_start_s: f64,
    pub tx_pol: u8,
    pub flags: u32,
    /// Antennas in the order of [`Description::ends`].
    pub antennas: Vec<AntennaRow>,
}

/// An antenna at an instant, Earth-centred.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub position_m: DVec3,
    pub velocity_mps: DVec3,
    pub acx: DVec3,
    pub acy: DVec3,
}

fn quaternion([w, x, y, z]: [f64; 4]) -> DQuat {
    DQuat::from_xyzw(x, y, z, w).normalize()
}

/// The emission that a recording holds: rounded down to nanoseconds, and the rest of it.
pub(super) fn recorded_time(ns: i64, part_ns: f64) -> TimeTag {
    const NS: i64 = 1_000_000_000;
    TimeTag::new(ns.div_euclid(NS), (ns.rem_euclid(NS) as f64 + part_ns) * 1e-9)
}

impl AntennaRow {
    /// From axes and attitudes as recorded.
    pub fn new(
        centre_m: [f64; 3],
        velocity_mps: [f64; 3],
        axes: [f64; 4],
        true_attitude: [f64; 4],
        reported_attitude: [f64; 4],
    ) -> Self {
        let mounted = quaternion(true_attitude).conjugate() * quaternion(axes);
        Self { centre_m, velocity_mps, axes: quaternion(reported_attitude) * mounted }
    }
}

impl PulseRow {
    /// Of a pulse under way.
    pub fn of(pulse: &Pulse, description: &Description) -> Option<Self> {
        let antenna = |end: &End| {
            let (antenna, truth) = (pulse.antennas.get(end.place)?, pulse.nav_true.get(end.carrier)?);
            let reported = pulse.nav_reported.get(end.carrier)?;
            Some(AntennaRow::new(
                antenna.reported_phase_centre_m,
                reported.velocity_mps,
                antenna.boresight_quat,
                truth.attitude_quat,
                reported.attitude_quat,
            ))
        };
        let (ns, part_ns) = pulse.time.to_unix_ns();
        Some(Self {
            index: pulse.index,
            // As a recording rounds it, so that its export is the same file.
            time: recorded_time(ns, part_ns),
            window_start_s: pulse.window_start_of(description.receiver()),
            tx_pol: pulse.tx_pol,
            flags: pulse.flags,
            antennas: description.ends.iter().map(antenna).collect::<Option<_>>()?,
        })
    }
}

/// The state of an antenna some time after the emission of a row.
pub(super) fn state(
    description: &Description,
    rows: &[PulseRow],
    at: usize,
    end: usize,
    after_s: f64,
) -> Result<State, CrsdError> {
    let own = &rows[at];
    let not_finite = |what: &str| CrsdError::NotFinite {
        pulse: own.index,
        what: format!("reported {what} of {}", description.ends[end].name),
    };
    let first = at.saturating_sub(BEFORE);
    let beyond = rows[at..].partition_point(|row| row.time.since(own.time) <= after_s);
    let used = &rows[first..(at + beyond + BEYOND).min(rows.len())];
    let times_s: Vec<f64> = used.iter().map(|row| row.time.since(own.time)).collect();
    let path = |values: fn(&AntennaRow) -> [f64; 3]| {
        PhasePath::new(times_s.clone(), used.iter().map(|row| values(&row.antennas[end])).collect())
    };
    let centre_m = path(|row| row.centre_m).map_err(|_| not_finite("position"))?.at(after_s);
    let velocity_mps = path(|row| row.velocity_mps).map_err(|_| not_finite("velocity"))?.at(after_s);
    if !own.antennas[end].axes.is_finite() {
        return Err(not_finite("axes"));
    }
    let vector = |v: DVec3| -> Result<DVec3, CrsdError> {
        let turned = description.frame.vector_to_ecef(Vector::<Enu>::from_raw(v));
        Ok(turned.ok_or(CrsdError::NoOrigin)?.raw())
    };
    let [x, y, z] = centre_m;
    let place = Point::<Enu>::new(x, y, z);
    let position_m = description.frame.to_ecef(place).ok_or(CrsdError::NoOrigin)?.raw();
    let moving = DVec3::from(velocity_mps);
    let velocity = if moving == DVec3::ZERO { DVec3::Y * AT_REST_MPS } else { moving };
    let (acx, acy) = if description.ends[end].is_isotropic {
        level(description, place)
    } else {
        let axes = own.antennas[end].axes;
        (axes * DVec3::Y, axes * DVec3::Z)
    };
    let velocity_mps = vector(velocity)?;
    // Finite numbers that are too large to be turned.
    if !position_m.is_finite() {
        return Err(not_finite("position"));
    }
    if !velocity_mps.is_finite() {
        return Err(not_finite("velocity"));
    }
    Ok(State { position_m, velocity_mps, acx: vector(acx)?, acy: vector(acy)? })
}

/// H and V of an isotropic antenna on the ray to the middle of the scene: H is level.
fn level(description: &Description, place: Point<Enu>) -> (DVec3, DVec3) {
    let ahead = (description.nominal_point_m() - place.raw()).normalize_or(DVec3::NEG_Z);
    let up = description.frame.earth().up(place).raw();
    let across = up.cross(ahead).normalize_or(DVec3::X);
    (across, ahead.cross(across))
}
