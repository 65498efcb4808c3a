//! Reference geometry and polarisation parameters, by the equations of the standard's design document
//! (sections 8 and 9.4), in the order of operations of sarkit's, which checks them to 1e-6 m and degrees: a
//! ground range of a few kilometres comes from an arc cosine near 1.

use std::f64::consts::TAU;

use glam::DVec3;

use super::states::State;
use crate::frames::Point;
use crate::scene::radar::Polarisation;

/// East, North and up of a point, Earth-centred.
pub(super) fn local(point_m: DVec3) -> [DVec3; 3] {
    let place = Point::<crate::frames::Ecef>::from_raw(point_m).to_geodetic();
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (place.lat_rad.sin_cos(), place.lon_rad.sin_cos());
    [
        DVec3::new(-sin_lon, cos_lon, 0.0),
        DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
    ]
}

/// What a phase centre sees of a point, and the point of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneWay {
    pub position_m: DVec3,
    pub velocity_mps: DVec3,
    pub side: &'static str,
    pub slant_m: f64,
    pub ground_m: f64,
    pub cone_deg: f64,
    pub squint_deg: f64,
    pub azimuth_deg: f64,
    pub graze_deg: f64,
    pub incidence_deg: f64,
    range_rate_mps: f64,
    towards: DVec3,
    towards_rate: DVec3,
}

fn degrees(radians: f64) -> f64 {
    radians.to_degrees()
}

impl OneWay {
    /// Section 8.3.
    pub fn of(position_m: DVec3, velocity_mps: DVec3, point_m: DVec3, [east, north, up]: [DVec3; 3]) -> Self {
        let slant_m = (position_m - point_m).length();
        let towards = (position_m - point_m) / slant_m;
        let range_rate_mps = velocity_mps.dot(towards);
        let towards_rate = (velocity_mps - range_rate_mps * towards) / slant_m;
        let from_centre_m = point_m.length();
        let up_point = point_m / from_centre_m;
        let up_centre = position_m / position_m.length();
        let below_m = from_centre_m * up_centre;
        let ground_m = from_centre_m * up_centre.dot(up_point).min(1.0).acos();
        let along = velocity_mps - velocity_mps.dot(up_centre) * up_centre;
        let speed_mps = along.length();
        let ahead = along / speed_mps;
        let left = up_centre.cross(ahead);
        let is_left = left.dot(towards) < 0.0 || speed_mps == 0.0 || ground_m == 0.0;
        let cone_deg = degrees((-range_rate_mps / velocity_mps.length()).clamp(-1.0, 1.0).acos());
        let squint_deg = degrees(ahead.dot(point_m - below_m).atan2(left.dot(point_m - below_m).abs()));
        let azimuth_deg = degrees(east.dot(towards).atan2(north.dot(towards))).rem_euclid(360.0);
        let incidence_deg = degrees(up.dot(towards).clamp(-1.0, 1.0).acos());
        Self {
            position_m,
            velocity_mps,
            side: if is_left { "L" } else { "R" },
            slant_m,
            ground_m,
            cone_deg,
            squint_deg,
            azimuth_deg: if ground_m == 0.0 { 0.0 } else { azimuth_deg },
            graze_deg: 90.0 - incidence_deg,
            incidence_deg,
            range_rate_mps,
            towards,
            towards_rate,
        }
    }
}

/// The bistatic geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bistatic {
    pub reference: OneWay,
    pub angle_deg: f64,
    pub angle_rate_deg: f64,
    pub twist_deg: f64,
    pub slope_deg: f64,
    pub layover_deg: f64,
}

impl Bistatic {
    /// Section 8.4.2.
    pub fn of(transmitter: &OneWay, receiver: &OneWay, point_m: DVec3, axes: [DVec3; 3]) -> Self {
        let [east, north, up] = axes;
        let half = (transmitter.towards + receiver.towards) / 2.0;
        let rate = (transmitter.towards_rate + receiver.towards_rate) / 2.0;
        let length = half.length();
        let angle = if length >= 1.0 { 0.0 } else { 2.0 * length.acos() };
        let angle_rate =
            if length >= 1.0 || length == 0.0 { 0.0 } else { (-4.0 / angle.sin()) * half.dot(rate) };
        let towards = half / length;
        let towards_rate = (rate - rate.dot(towards) * towards) / length;
        let range_m = (transmitter.slant_m + receiver.slant_m) / 2.0;
        let range_rate_mps = (transmitter.range_rate_mps + receiver.range_rate_mps) / 2.0;
        let position_m = point_m + range_m * towards;
        let velocity_mps = range_rate_mps * towards + range_m * towards_rate;
        let reference = OneWay::of(position_m, velocity_mps, point_m, axes);
        let level = half - half.dot(up) * up;
        let across = up.cross(level / level.length());
        let sign = if rate.dot(across) > 0.0 { 1.0 } else { -1.0 };
        let normal = sign * half.cross(rate);
        let normal = normal / normal.length();
        let layover_deg = degrees((-east.dot(normal)).atan2(-north.dot(normal))).rem_euclid(360.0);
        Self {
            reference,
            angle_deg: angle * (180.0 / std::f64::consts::PI),
            angle_rate_deg: angle_rate * (180.0 / std::f64::consts::PI),
            twist_deg: degrees(-normal.dot(across).clamp(-1.0, 1.0).asin()),
            slope_deg: degrees(normal.dot(up).clamp(-1.0, 1.0).acos()),
            layover_deg,
        }
    }
}

/// Amplitudes and phases (cycles) along two axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct TwoAxes {
    pub amplitudes: [f64; 2],
    pub phases: [f64; 2],
}

/// What a port radiates along the axes of its antenna.
pub(super) fn port(polarisation: Polarisation) -> TwoAxes {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (amplitudes, phases) = match polarisation {
        Polarisation::H => ([1.0, 0.0], [0.0; 2]),
        Polarisation::V => ([0.0, 1.0], [0.0; 2]),
        Polarisation::R => ([half; 2], [0.0, -0.25]),
        Polarisation::L => ([half; 2], [0.0, 0.25]),
    };
    TwoAxes { amplitudes, phases }
}

/// H and V at a point (section 9.4): `sense` is 1 for what is radiated, -1 for what is received.
pub(super) fn at_point(state: &State, port: TwoAxes, point_m: DVec3, sense: f64) -> TwoAxes {
    let [.., up] = local(point_m);
    let sight = (point_m - state.position_m).normalize();
    let across = up.cross(sight).normalize_or(DVec3::X);
    let upward = sight.cross(across);
    let onto = |axis: DVec3| axis - axis.dot(sight) * sight;
    let (x, y) = (onto(state.acx), onto(state.acy));
    let component = |direction: DVec3| {
        let turned = |amplitude: f64, axis: DVec3, phase: f64| {
            let (sin, cos) = (sense * TAU * phase).sin_cos();
            let along = amplitude * axis.dot(direction);
            [along * cos, along * sin]
        };
        let [a, b] = turned(port.amplitudes[0], x, port.phases[0]);
        let [c, d] = turned(port.amplitudes[1], y, port.phases[1]);
        [a + c, b + d]
    };
    let parts = [component(across), component(upward)];
    let lengths = parts.map(|[re, im]| re.hypot(im));
    let whole = lengths[0].hypot(lengths[1]);
    TwoAxes {
        amplitudes: lengths.map(|length| (length / whole).min(1.0)),
        phases: parts.map(|[re, im]| (im.atan2(re) / TAU).clamp(-0.5, 0.5)),
    }
}
