//! Phase centres, aim points, and where an antenna really points.
//!
//! * **Phase centre** of a lever arm `l` (body frame): `p = x + C l`, `v + w x C l`, `a + w x (w x C l)`; the angular
//!   acceleration is left out (1 rad/s^2 on 1 m moves it 1e-9 m while a pulse flies 15 km).
//! * **Aim point**: a ground point on a straight course, or a point of the mean sea surface beside a platform.
//! * **Servo**: it knows the platforms as they report themselves (or, by choice, as they are) at `t - lag`. From
//!   that it computes the antenna frame that looks at the aim point, as a rotation relative to the body;
//!   the true body at `t` carries that rotation, and a constant bias is added. An attitude error of the report
//!   therefore turns the beam by the same angle.
//!
//! The frame that looks from `p` at `q` has `x_a = unit(q - p)`, `y_a = unit(z_up x x_a)` (horizontal, to the left of
//! the boresight), `z_a = x_a x y_a`. Antenna frames are boresight, left, up; a mount without rotation looks along the
//! nose with `y_a` to port and `z_a` to the roof.

use glam::{DQuat, DVec3};

use super::track::State;
use crate::frames::{Antenna, Body, Enu, Point, Rotation, SceneFrame, Vector};
use crate::scene::radar::Aim;

/// Below this `|z_up x x_a|` the boresight counts as vertical.
const VERTICAL: f64 = 1e-6;
/// Below this horizontal speed, m/s, a platform has no course: its nose is used.
const NO_COURSE_MPS: f64 = 1e-3;

/// Motion of an antenna's phase centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseCentre {
    /// Position, m.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector<Enu>,
}

/// The phase centre that a body carries at a lever arm.
pub fn phase_centre(state: &State, lever_arm: Vector<Body>) -> PhaseCentre {
    let arm = state.attitude * lever_arm;
    let sweep = state.angular_rate.cross(arm);
    PhaseCentre {
        position: state.position + arm,
        velocity: state.velocity + sweep,
        acceleration: state.acceleration + state.angular_rate.cross(sweep),
    }
}

/// Where an aim point is, `since_start_s` after pulse 0. `state_of` tells a platform's state.
pub fn aim_point(
    aim: &Aim,
    since_start_s: f64,
    frame: &SceneFrame,
    state_of: impl Fn(usize) -> State,
) -> Point<Enu> {
    match *aim {
        Aim::Point { position, velocity } => position + velocity * since_start_s,
        Aim::Beside { platform, along_m, across_m } => {
            let state = state_of(platform);
            let ahead = course(&state);
            let starboard = DVec3::new(ahead.y, -ahead.x, 0.0);
            let ground = state.position.raw() + ahead * along_m + starboard * across_m;
            frame.above_sea(ground.x, ground.y, 0.0)
        }
    }
}

/// Horizontal unit vector along the ground track, or along the nose of a platform that stands still.
fn course(state: &State) -> DVec3 {
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    let velocity = flat(state.velocity.raw());
    if velocity.length() >= NO_COURSE_MPS {
        return velocity.normalize();
    }
    flat((state.attitude * Vector::new(1.0, 0.0, 0.0)).raw()).try_normalize().unwrap_or(DVec3::Y)
}

/// The antenna frame at `from` that looks at `target`. Where the boresight is vertical, the body's forward axis
/// takes the part of the vertical.
pub fn look_at(
    from: Point<Enu>,
    target: Point<Enu>,
    attitude: Rotation<Body, Enu>,
) -> Rotation<Antenna, Enu> {
    let nose = (attitude * Vector::new(1.0, 0.0, 0.0)).raw();
    let boresight = (target - from).raw().try_normalize().unwrap_or(nose);
    let across = DVec3::Z.cross(boresight);
    let across = if across.length() < VERTICAL {
        // The horizontal axis that stands square to the nose.
        nose.cross(boresight).try_normalize().unwrap_or(DVec3::Y)
    } else {
        across.normalize()
    };
    let up = boresight.cross(across);
    Rotation::from_axes(Vector::from_raw(boresight), Vector::from_raw(across), Vector::from_raw(up))
}

/// An antenna bolted to the body: yaw to starboard, then pitch upwards, then roll about the boresight, radians.
pub fn mount(yaw_rad: f64, pitch_rad: f64, roll_rad: f64) -> Rotation<Antenna, Body> {
    // The antenna frame is boresight, left, up; the body's is forward, starboard, down: half a turn.
    let half_turn = DQuat::from_rotation_x(std::f64::consts::PI);
    let turn = DQuat::from_rotation_z(yaw_rad)
        * DQuat::from_rotation_y(pitch_rad)
        * DQuat::from_rotation_x(roll_rad);
    Rotation::from_raw((turn * half_turn).normalize())
}

/// The servo's misalignment: about the antenna's z axis (azimuth), then its y axis (elevation), radians.
pub fn servo_bias(bias_rad: [f64; 2]) -> Rotation<Antenna, Antenna> {
    Rotation::from_raw(DQuat::from_rotation_z(bias_rad[0]) * DQuat::from_rotation_y(bias_rad[1]))
}

/// Where a servo really points: commanded from what is `known`, carried by the `true_attitude`.
pub fn servo(
    known: &State,
    lever_arm: Vector<Body>,
    aim: Point<Enu>,
    true_attitude: Rotation<Body, Enu>,
    bias: Rotation<Antenna, Antenna>,
) -> Rotation<Antenna, Enu> {
    let commanded = look_at(phase_centre(known, lever_arm).position, aim, known.attitude);
    let relative: Rotation<Antenna, Body> = commanded.then(known.attitude.inverse());
    bias.then(relative).then(true_attitude)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::Earth;

    fn state(yaw: f64, pitch: f64, roll: f64) -> State {
        State {
            position: Point::new(10.0, -20.0, 3000.0),
            velocity: Vector::new(0.0, 100.0, 0.0),
            acceleration: Vector::ZERO,
            attitude: Rotation::from_yaw_pitch_roll(yaw, pitch, roll),
            angular_rate: Vector::new(0.0, 0.0, -0.1),
        }
    }

    #[test]
    fn a_mount_turns_as_a_navigator_says() {
        // Heading North: 90 deg to starboard looks East, 30 deg up looks up.
        let attitude = state(0.0, 0.0, 0.0).attitude;
        let boresight = |yaw: f64, pitch: f64| {
            (mount(yaw, pitch, 0.0).then(attitude) * Vector::new(1.0, 0.0, 0.0)).to_array()
        };
        let east = boresight(std::f64::consts::FRAC_PI_2, 0.0);
        assert!((east[0] - 1.0).abs() < 1e-12, "{east:?}");
        let up = boresight(0.0, 30f64.to_radians());
        assert!((up[2] - 0.5).abs() < 1e-12, "{up:?}");
        // z of the antenna is up when the body is level.
        let z = (mount(0.3, 0.0, 0.0).then(attitude) * Vector::new(0.0, 0.0, 1.0)).to_array();
        assert!((z[2] - 1.0).abs() < 1e-12, "{z:?}");
    }

    #[test]
    fn an_attitude_error_turns_the_beam_by_its_angle() {
        let aim = Point::new(3000.0, -20.0, 0.0);
        let truth = state(0.2, 0.01, -0.02);
        let none = servo_bias([0.0, 0.0]);
        let ideal = servo(&truth, Vector::ZERO, aim, truth.attitude, none);
        let boresight = |r: Rotation<Antenna, Enu>| r * Vector::new(1.0, 0.0, 0.0);
        let wanted = (aim - truth.position).raw().normalize();
        assert!((boresight(ideal).raw() - wanted).length() < 1e-12);
        // A roll error of 5 mrad about a boresight square to the nose tilts the beam by 5 mrad.
        let truth = state(0.0, 0.0, 0.0);
        let mut reported = truth;
        reported.attitude = Rotation::from_yaw_pitch_roll(0.0, 0.0, 5e-3);
        let real = servo(&reported, Vector::ZERO, aim, truth.attitude, none);
        let wanted = (aim - truth.position).raw().normalize();
        let off = boresight(real).raw().cross(wanted).length().asin();
        assert!((off - 5e-3).abs() < 1e-9, "{off}");
        let biased = servo(&truth, Vector::ZERO, aim, truth.attitude, servo_bias([2e-3, 0.0]));
        let off = boresight(biased).raw().cross(wanted).length().asin();
        assert!((off - 2e-3).abs() < 1e-9, "{off}");
    }

    #[test]
    fn beside_lies_on_the_sea_to_starboard() {
        let frame = SceneFrame::plain(Earth::Curved { radius_factor: 1.0 });
        let aim = Aim::Beside { platform: 0, along_m: 7.0, across_m: 3000.0 };
        let point = aim_point(&aim, 0.0, &frame, |_| state(1.0, 0.0, 0.0)).to_array();
        assert_eq!(point[..2], [3010.0, -13.0]);
        assert!((point[2] + (3010f64.powi(2) + 169.0) / (2.0 * 6.371e6)).abs() < 1e-9);
    }

    #[test]
    fn a_lever_arm_moves_with_the_body() {
        let state = state(0.0, 0.0, 0.0);
        let centre = phase_centre(&state, Vector::new(2.0, 0.0, 0.0));
        assert_eq!(centre.position.to_array(), [10.0, -18.0, 3000.0]);
        // Turning to the right at 0.1 rad/s swings the nose East at 0.2 m/s and pulls it back at 0.02 m/s^2.
        assert!((centre.velocity.to_array()[0] - 0.2).abs() < 1e-12);
        assert!((centre.acceleration.to_array()[1] + 0.02).abs() < 1e-12);
    }

    #[test]
    fn looking_straight_down_is_defined() {
        let from = Point::new(0.0, 0.0, 3000.0);
        for yaw in [0.0, 1.0, -2.0] {
            let look = look_at(from, Point::new(0.0, 0.0, 0.0), state(yaw, 0.0, 0.0).attitude);
            let boresight = (look * Vector::new(1.0, 0.0, 0.0)).to_array();
            assert!((boresight[2] + 1.0).abs() < 1e-12);
        }
        let here = look_at(from, from, state(0.0, 0.0, 0.0).attitude);
        assert!(here.raw().is_finite());
    }
}
