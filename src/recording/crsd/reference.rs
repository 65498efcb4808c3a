//! Reference geometry and polarisation parameters, by the equations of the standard's design document
//! (sections 8 and 9.4).
//!
//! The standard's ground range, `R acos(u_apc . u_point)` with unit vectors from the centre of the Earth, is
//! ill-conditioned in doubles. Near 1 a cosine is a multiple of `2^-53`, and one such step is
//! `2^-53 R / sin(angle)` on the ground: 1.5e-6 m at 3 km, 4.5e-6 m at 1 km. A checker that evaluates it
//! anew to 1e-6 m finds the same value only by the same operations. Products summed with fused
//! multiply-adds, as on some processors, differ by a step at one of four points. So the reference point,
//! which is ours to choose, is one at which both ways give the same: see [`steady`] (docs/decisions/0077).

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

/// How a scalar product is evaluated; `DVec3::dot` rounds every product and sum.
type Dot = fn(DVec3, DVec3) -> f64;

/// A scalar product by fused multiply-adds.
fn fused(a: DVec3, b: DVec3) -> f64 {
    a.z.mul_add(b.z, a.y.mul_add(b.y, a.x * b.x))
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
    fn of(
        (position_m, velocity_mps): (DVec3, DVec3),
        point_m: DVec3,
        [east, north, up]: [DVec3; 3],
        dot: Dot,
    ) -> Self {
        let slant_m = (position_m - point_m).length();
        let towards = (position_m - point_m) / slant_m;
        let range_rate_mps = dot(velocity_mps, towards);
        let towards_rate = (velocity_mps - range_rate_mps * towards) / slant_m;
        let from_centre_m = point_m.length();
        let up_point = point_m / from_centre_m;
        let up_centre = position_m / position_m.length();
        let below_m = from_centre_m * up_centre;
        let ground_m = from_centre_m * dot(up_centre, up_point).min(1.0).acos();
        let along = velocity_mps - dot(velocity_mps, up_centre) * up_centre;
        let speed_mps = along.length();
        let ahead = along / speed_mps;
        let left = up_centre.cross(ahead);
        let is_left = dot(left, towards) < 0.0 || speed_mps == 0.0 || ground_m == 0.0;
        let cone_deg = degrees((-range_rate_mps / velocity_mps.length()).clamp(-1.0, 1.0).acos());
        let squint_deg = degrees(dot(ahead, point_m - below_m).atan2(dot(left, point_m - below_m).abs()));
        let azimuth_deg = degrees(dot(east, towards).atan2(dot(north, towards))).rem_euclid(360.0);
        let incidence_deg = degrees(dot(up, towards).clamp(-1.0, 1.0).acos());
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
    fn of(transmitter: &OneWay, receiver: &OneWay, point_m: DVec3, axes: [DVec3; 3], dot: Dot) -> Self {
        let [east, north, up] = axes;
        let half = (transmitter.towards + receiver.towards) / 2.0;
        let rate = (transmitter.towards_rate + receiver.towards_rate) / 2.0;
        let length = half.length();
        let angle = if length >= 1.0 { 0.0 } else { 2.0 * length.acos() };
        let angle_rate =
            if length >= 1.0 || length == 0.0 { 0.0 } else { (-4.0 / angle.sin()) * dot(half, rate) };
        let towards = half / length;
        let towards_rate = (rate - dot(rate, towards) * towards) / length;
        let range_m = (transmitter.slant_m + receiver.slant_m) / 2.0;
        let range_rate_mps = (transmitter.range_rate_mps + receiver.range_rate_mps) / 2.0;
        let position_m = point_m + range_m * towards;
        let velocity_mps = range_rate_mps * towards + range_m * towards_rate;
        let reference = OneWay::of((position_m, velocity_mps), point_m, axes, dot);
        let level = half - dot(half, up) * up;
        let across = up.cross(level / level.length());
        let sign = if dot(rate, across) > 0.0 { 1.0 } else { -1.0 };
        let normal = sign * half.cross(rate);
        let normal = normal / normal.length();
        let layover_deg = degrees((-dot(east, normal)).atan2(-dot(north, normal))).rem_euclid(360.0);
        Self {
            reference,
            angle_deg: angle * (180.0 / std::f64::consts::PI),
            angle_rate_deg: angle_rate * (180.0 / std::f64::consts::PI),
            twist_deg: degrees(-dot(normal, across).clamp(-1.0, 1.0).asin()),
            slope_deg: degrees(dot(normal, up).clamp(-1.0, 1.0).acos()),
            layover_deg,
        }
    }
}

/// Both ends and the bistatic geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct Geometry {
    pub transmitter: OneWay,
    pub receiver: OneWay,
    pub both: Bistatic,
}

/// How far two evaluations may differ, m and degrees: a tenth of what sarkit's checker allows.
const SAME: f64 = 1e-7;
/// Points that are tried, and what lies between them, m. Three of five fail, so all do once in 1e14 files.
const TRIED: u32 = 64;
const STEP_M: f64 = 1e-3;

impl Geometry {
    /// Of a transmitter and a receiver.
    pub fn of(ends: [State; 2], point_m: DVec3) -> Self {
        Self::by(DVec3::dot, ends, point_m)
    }

    fn by(dot: Dot, ends: [State; 2], point_m: DVec3) -> Self {
        let axes = local(point_m);
        let way = |end: State| OneWay::of((end.position_m, end.velocity_mps), point_m, axes, dot);
        let [transmitter, receiver] = ends.map(way);
        let both = Bistatic::of(&transmitter, &receiver, point_m, axes, dot);
        Self { transmitter, receiver, both }
    }

    /// Sides of the track, and numbers.
    fn values(&self) -> ([&'static str; 3], Vec<f64>) {
        let both = &self.both;
        let ways = [&self.transmitter, &self.receiver, &both.reference];
        let mut numbers =
            vec![both.angle_deg, both.angle_rate_deg, both.twist_deg, both.slope_deg, both.layover_deg];
        for way in ways {
            numbers.extend(way.position_m.to_array());
            numbers.extend(way.velocity_mps.to_array());
            numbers.extend([way.slant_m, way.ground_m, way.cone_deg, way.squint_deg]);
            numbers.extend([way.azimuth_deg, way.incidence_deg]);
        }
        (ways.map(|way| way.side), numbers)
    }

    /// Whether the geometry is the same, however scalar products are rounded.
    fn is_steady(ends: [State; 2], point_m: DVec3) -> bool {
        let [(sides, plain), (others, fused)] =
            [DVec3::dot as Dot, fused].map(|dot| Self::by(dot, ends, point_m).values());
        sides == others && plain.iter().zip(&fused).all(|(a, b)| (a - b).abs() <= SAME)
    }
}

/// The reference point: the middle, or the nearest of the points 1 mm, 2 mm and so on East of it where the
/// geometry does not depend on how scalar products are rounded. Returns how far East it is, m, and the
/// point. Where there is none, as with an antenna in the middle itself, the middle is taken.
pub(super) fn steady(ends: [State; 2], middle_m: DVec3, east: DVec3) -> (f64, DVec3) {
    let aside = |n: u32| {
        let aside_m = STEP_M * f64::from(n);
        (aside_m, middle_m + aside_m * east)
    };
    let found = (0..TRIED).map(aside).find(|(_, point_m)| Geometry::is_steady(ends, *point_m));
    found.unwrap_or((0.0, middle_m))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Antennas around many places on Earth: the geometry at the reference point does not depend on how
    /// products are rounded. In the middle itself it often does.
    #[test]
    fn the_geometry_at_the_reference_point_is_steady() {
        let mut unsteady = 0;
        for n in 0..500_u32 {
            // Golden angles spread the places, ranges and courses.
            let [a, b, c] = [0.618_034, 0.754_878, 0.569_840].map(|step| (f64::from(n) * step).fract());
            let place = crate::frames::Geodetic::from_deg(-89.0 + 178.0 * a, -180.0 + 360.0 * b, 50.0 * c);
            let middle_m = place.to_ecef().raw();
            let [east, north, up] = local(middle_m);
            let end = |far_m: f64, high_m: f64, angle: f64, speed_mps: f64| State {
                position_m: middle_m + far_m * (angle.sin() * east + angle.cos() * north) + high_m * up,
                velocity_mps: speed_mps * (east * angle.cos() - north * angle.sin() + 0.01 * up),
                acx: east,
                acy: north,
            };
            let ends = [
                end(50.0 * 400.0_f64.powf(b), 15.0, TAU * c, 1e-9),
                end(5e3 * a + 10.0, 3e3 * c + 10.0, TAU * b, 60.0 + 200.0 * a),
            ];
            let (aside_m, point_m) = steady(ends, middle_m, east);
            assert!(Geometry::is_steady(ends, point_m), "{n}: {aside_m} m");
            assert!((0.0..0.064).contains(&aside_m), "{n}: {aside_m} m");
            assert!((point_m.distance(middle_m) - aside_m).abs() < 2e-9, "{n}");
            unsteady += u32::from(aside_m > 0.0);
        }
        println!("{unsteady} of 500 middles would not do");
        assert!(unsteady > 50, "{unsteady}");
    }
}
