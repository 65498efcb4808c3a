//! Phase centres, aim points, and where an antenna really points.
//!
//! **Phase centre** of an antenna with lever arm `l` (body frame) on a platform with position `p`,
//! velocity `v`, acceleration `a`, attitude `C` (body to ENU) and angular rate `w`:
//!
//! `p + C l`, `v + w x C l`, `a + w x (w x C l)`.
//!
//! The angular acceleration is left out; over a light time `tau` it moves the phase centre by
//! `|dw/dt| |l| tau^2 / 2`: 1.4e-9 m for 1 rad/s^2, 5 m, 24 us.
//!
//! **Antenna frame** of an antenna that points at `q` from `p`: `x_a = unit(q - p)`,
//! `y_a = unit(z_up x x_a)` (horizontal, to the left of the boresight), `z_a = x_a x y_a` (upward).
//! Within 1e-6 rad of the vertical the body's forward axis takes the place of `x_a` in `z_up x x_a`.
//! A mount with zero angles gives the same frame on a level body: boresight forward, `y_a` to port,
//! `z_a` up.
//!
//! **Servo.** A real servo knows only what the platform reports. The wanted frame `A*` is computed from
//! the reported (or true) states at `t - lag`, turned into axis angles relative to the reported body,
//! and realised on the true body:
//!
//! `A = C_true(t) C_known(t - lag)^-1 A*(t - lag) B`, with the bias `B` (azimuth towards `+y_a`, then
//! elevation towards `+z_a`). So an error of the reported attitude moves the beam by that very angle.
//!
//! **Pedestal.** A scanning antenna is a mount whose yaw and pitch follow [`scan`]; one that is kept level is
//! that mount on a body that is level and heads North, turned into angles and back like a servo's.
//!
//! ```
//! use nereus::frames::{Point, Rotation, Vector};
//! use nereus::motion::pointing::towards;
//! let level_north = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
//! let a = towards(Point::new(0.0, 0.0, 3000.0), Point::new(3000.0, 0.0, 0.0), level_north);
//! let boresight = (a * Vector::new(1.0, 0.0, 0.0)).to_array();
//! assert!((boresight[0] - 0.5f64.sqrt()).abs() < 1e-12 && (boresight[2] + 0.5f64.sqrt()).abs() < 1e-12);
//! ```

use glam::{DQuat, DVec3};

use crate::frames::{Antenna, Body, Enu, Point, Rotation, SceneFrame, Vector};
use crate::motion::PlatformTracks;
use crate::motion::scan;
use crate::motion::track::{State, TrackError};
use crate::scene::radar::{Aim, AimFrom, AntennaMount, Pointing, Scan};
use crate::time::TimeTag;

/// Sine of the angle to the vertical below which a boresight has no azimuth of its own.
const VERTICAL_SINE: f64 = 1e-6;
/// Horizontal speed below which a platform's axes follow its nose and not its velocity, m/s.
const STANDING_MPS: f64 = 0.01;

/// An antenna's phase centre at an instant: its motion about that instant is
/// `p + v s + a s^2 / 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseCentre {
    /// Position.
    pub position: Point<Enu>,
    /// Velocity, m/s.
    pub velocity: Vector<Enu>,
    /// Acceleration, m/s^2.
    pub acceleration: Vector<Enu>,
}

impl PhaseCentre {
    /// The phase centre at the end of a lever arm.
    pub fn of(state: &State, lever_arm: Vector<Body>) -> Self {
        let arm = state.attitude * lever_arm;
        let turning = state.angular_rate.cross(arm);
        Self {
            position: state.position + arm,
            velocity: state.velocity + turning,
            acceleration: state.acceleration + state.angular_rate.cross(turning),
        }
    }

    /// A phase centre at rest.
    pub fn at_rest(position: Point<Enu>) -> Self {
        Self { position, velocity: Vector::ZERO, acceleration: Vector::ZERO }
    }
}

/// What servos and receive windows look at: the tracks in the order of `scene.platforms`, the frame, the
/// emission time of pulse 0.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// Trajectories, in the order of `scene.platforms`.
    pub tracks: &'a [PlatformTracks],
    /// The scene's frame.
    pub frame: &'a SceneFrame,
    /// Emission time of pulse 0.
    pub start: TimeTag,
}

impl Surroundings<'_> {
    /// Position and velocity of an aim point at time `t`, as far as `aim_from` knows.
    ///
    /// `Aim::Beside` lies on the (curved) mean sea surface and stands still as a scatterer: what moves
    /// is the choice of the point.
    ///
    /// # Errors
    /// An instant that the track of the platform does not cover.
    pub fn aim_point(
        &self,
        aim: &Aim,
        aim_from: AimFrom,
        t: TimeTag,
    ) -> Result<(Point<Enu>, Vector<Enu>), TrackError> {
        match *aim {
            Aim::Point { position, velocity } => Ok((position + velocity * t.since(self.start), velocity)),
            Aim::Beside { platform, along_m, across_m } => {
                let state = self.tracks[platform].known(aim_from).state(t)?;
                let ahead = ground_track(state.velocity, state.attitude);
                let starboard = DVec3::new(ahead.y, -ahead.x, 0.0);
                let p = state.position.raw() + ahead * along_m + starboard * across_m;
                Ok((self.frame.above_sea(p.x, p.y, 0.0), Vector::ZERO))
            }
        }
    }

    /// The true antenna frame at time `t` on a platform whose true attitude is given: mount, servo, lag
    /// and bias included. A beam that jumps is that of the emission at `emitted`.
    ///
    /// # Errors
    /// An instant that a track does not cover.
    pub fn antenna_frame(
        &self,
        mount: &AntennaMount,
        true_attitude: Rotation<Body, Enu>,
        [t, emitted]: [TimeTag; 2],
    ) -> Result<Rotation<Antenna, Enu>, TrackError> {
        match &mount.pointing {
            Pointing::Fixed { yaw_rad, pitch_rad, roll_rad } => {
                Ok(fixed_mount(*yaw_rad, *pitch_rad, *roll_rad).then(true_attitude))
            }
            Pointing::At { aim, aim_from, lag_s, bias_rad } => {
                let known_at = t.plus(-lag_s);
                let known = self.tracks[mount.platform].known(*aim_from).state(known_at)?;
                let (target, _) = self.aim_point(aim, *aim_from, known_at)?;
                let from = PhaseCentre::of(&known, mount.lever_arm - mount.of_array).position;
                let axes = towards(from, target, known.attitude).then(known.attitude.inverse());
                Ok(bias(*bias_rad).then(axes).then(true_attitude))
            }
            Pointing::Scan(Scan { law, level_by, .. }) => {
                let of = if law.dwell_pulses().is_some() { emitted } else { t };
                let [az_rad, el_rad] = scan::direction(law, of.since(self.start));
                let pedestal = fixed_mount(az_rad, el_rad, 0.0);
                let Some(from) = level_by else { return Ok(pedestal.then(true_attitude)) };
                let known = self.tracks[mount.platform].known(*from).state(t)?;
                let level = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
                Ok(pedestal.then(level).then(known.attitude.inverse()).then(true_attitude))
            }
        }
    }
}

/// Horizontal unit vector along the ground track; of a platform that stands, along its nose.
pub fn ground_track(velocity: Vector<Enu>, attitude: Rotation<Body, Enu>) -> DVec3 {
    let v = velocity.raw();
    let nose = attitude.raw() * DVec3::X;
    let along = if v.x.hypot(v.y) > STANDING_MPS { v } else { nose };
    DVec3::new(along.x, along.y, 0.0).try_normalize().unwrap_or(DVec3::Y)
}

/// Antenna frame of a mount bolted to the body: yaw about body z (down), pitch about the new y,
/// roll about the boresight; with zero angles the boresight is forward, `y_a` to port, `z_a` up.
pub fn fixed_mount(yaw_rad: f64, pitch_rad: f64, roll_rad: f64) -> Rotation<Antenna, Body> {
    let turned = DQuat::from_rotation_z(yaw_rad)
        * DQuat::from_rotation_y(pitch_rad)
        * DQuat::from_rotation_x(roll_rad);
    // Half a turn about the boresight: starboard and down become port and up.
    Rotation::from_raw((turned * DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0)).normalize())
}

/// Misalignment of the boresight to azimuth `bias[0]` (towards `+y_a`) and elevation `bias[1]`
/// (towards `+z_a`) of the frame it should have had.
fn bias(bias_rad: [f64; 2]) -> Rotation<Antenna, Antenna> {
    Rotation::from_raw(DQuat::from_rotation_z(bias_rad[0]) * DQuat::from_rotation_y(-bias_rad[1]))
}

/// Antenna frame with the boresight from `from` to `target`, `y_a` horizontal.
///
/// Where the two coincide the boresight is the body's forward axis.
pub fn towards(
    from: Point<Enu>,
    target: Point<Enu>,
    attitude: Rotation<Body, Enu>,
) -> Rotation<Antenna, Enu> {
    let nose = attitude.raw() * DVec3::X;
    let wing = attitude.raw() * DVec3::Y;
    let x = (target - from).raw().try_normalize().unwrap_or(nose);
    let level = DVec3::Z.cross(x);
    let y = if level.length() >= VERTICAL_SINE {
        level.normalize()
    } else {
        // The last two are at right angles to one another, so that one of them always has a part
        // across the boresight.
        [DVec3::Z.cross(nose), wing, nose]
            .into_iter()
            .map(|y| y - x * y.dot(x))
            .find(|y| y.length() > 0.1)
            .map_or(DVec3::Y, DVec3::normalize)
    };
    Rotation::from_axes(Vector::from_raw(x), Vector::from_raw(y), Vector::from_raw(x.cross(y)))
}
