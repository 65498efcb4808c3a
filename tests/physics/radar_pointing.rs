//! Where antennas point, and where they point when the platform is wrong about itself.

use nereus::frames::{Antenna, Earth, Enu, Point, Rotation, SceneFrame, Vector};
use nereus::motion::PlatformTracks;
use nereus::motion::pointing::{PhaseCentre, Surroundings, fixed_mount, towards};
use nereus::motion::track::{State, Track};
use nereus::scene::radar::*;
use nereus::time::TimeTag;

use crate::radar_scenes::*;

fn frame_of(
    mount: &AntennaMount,
    tracks: &[PlatformTracks],
    frame: &SceneFrame,
    t: TimeTag,
) -> Rotation<Antenna, Enu> {
    let around = Surroundings { tracks, frame, start: TimeTag::default() };
    let state = tracks[mount.platform].truth.state(t).unwrap();
    around.antenna_frame(mount, state.attitude, [t; 2]).unwrap()
}

fn boresight(frame: Rotation<Antenna, Enu>) -> Vector<Enu> {
    frame * Vector::new(1.0, 0.0, 0.0)
}

fn angle(a: Vector<Enu>, b: Vector<Enu>) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// An error of the reported attitude moves the beam by that angle.
#[test]
fn a_wrong_attitude_misaims_by_its_own_angle() {
    let plain = SceneFrame::plain(Earth::Flat);
    let place = Point::new(-3000.0, 200.0, 2500.0);
    let truth = Rotation::from_yaw_pitch_roll(0.3, 0.02, -0.05);
    for error in [0.0, 1e-4, 0.003, 0.2] {
        let wrong = Rotation::from_yaw_pitch_roll(0.3 + error, 0.02, -0.05);
        let tracks =
            [PlatformTracks { truth: Track::fixed(place, truth), reported: Track::fixed(place, wrong) }];
        let mount = pointed_at(0, [0.0; 3]);
        let real = boresight(frame_of(&mount, &tracks, &plain, TimeTag::default()));
        let wanted = Point::new(0.0, 0.0, 0.0) - place;
        // A yaw error turns about the vertical: the beam moves by that angle, seen from above.
        let heading = |v: Vector<Enu>| v.raw().x.atan2(v.raw().y);
        assert!((heading(wanted) - heading(real) - error).abs() < 1e-13, "{error}");
        // The body believes to be turned clockwise by the error, so its antenna ends up turned
        // the other way; its depression stays.
        assert!((real.raw().z - wanted.raw().z / wanted.norm()).abs() < 1e-13);
        // A servo that knows the truth does not care.
        let mut knowing = mount;
        let Pointing::At { aim_from, .. } = &mut knowing.pointing else { panic!() };
        *aim_from = AimFrom::True;
        assert!(angle(boresight(frame_of(&knowing, &tracks, &plain, TimeTag::default())), wanted) < 1e-14);
    }
}

/// A wrong reported position misaims by the parallax.
#[test]
fn a_wrong_position_misaims_by_the_parallax() {
    let plain = SceneFrame::plain(Earth::Flat);
    let (truth, reported) = (Point::new(-3000.0, 0.0, 0.0), Point::new(-3000.0, 3.0, 0.0));
    let tracks =
        [PlatformTracks { truth: Track::fixed(truth, level()), reported: Track::fixed(reported, level()) }];
    let real = boresight(frame_of(&pointed_at(0, [0.0; 3]), &tracks, &plain, TimeTag::default()));
    assert!((angle(real, Vector::new(1.0, 0.0, 0.0)) - (3.0f64 / 3000.0).atan()).abs() < 1e-14);
}

#[test]
fn bias_and_lag() {
    let plain = SceneFrame::plain(Earth::Flat);
    let t = TimeTag::new(10, 0.0);
    let tracks = [same(Track::straight(
        Point::new(-1000.0, -2000.0, 0.0),
        TimeTag::default(),
        Vector::new(0.0, 200.0, 0.0),
        None,
    ))];
    // At t = 10 s the aircraft is abeam of the origin, which lies to the east.
    let mut mount = pointed_at(0, [0.0; 3]);
    let level_east = frame_of(&mount, &tracks, &plain, t);
    assert!(angle(boresight(level_east), Vector::new(1.0, 0.0, 0.0)) < 1e-14);
    let Pointing::At { bias_rad, .. } = &mut mount.pointing else { panic!() };
    *bias_rad = [0.01, 0.004];
    let d = (level_east.inverse() * boresight(frame_of(&mount, &tracks, &plain, t))).raw();
    assert!((d.y.atan2(d.x) - 0.01).abs() < 1e-14 && (d.z.asin() - 0.004).abs() < 1e-14);
    // Half a second ago it was 100 m short of abeam.
    let Pointing::At { bias_rad, lag_s, .. } = &mut mount.pointing else { panic!() };
    (*bias_rad, *lag_s) = ([0.0; 2], 0.5);
    let late = boresight(frame_of(&mount, &tracks, &plain, t));
    assert!((angle(late, Vector::new(1.0, 0.0, 0.0)) - (0.1f64).atan()).abs() < 1e-13);
    assert!(late.raw().y > 0.0);
}

#[test]
fn beside_follows_the_ground_track_on_the_curved_sea() {
    let earth = Earth::Curved { radius_factor: 4.0 / 3.0 };
    let frame = SceneFrame::plain(earth);
    // Flies east, crabbing: the axes follow the velocity and not the nose.
    let attitude = Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0);
    let track = Track::straight(
        Point::new(20e3, 0.0, 3000.0),
        TimeTag::default(),
        Vector::new(100.0, 0.0, 5.0),
        Some(attitude),
    );
    let tracks = [same(track)];
    let around = Surroundings { tracks: &tracks, frame: &frame, start: TimeTag::default() };
    let aim = Aim::Beside { platform: 0, along_m: 500.0, across_m: 3000.0 };
    let (p, v) = around.aim_point(&aim, AimFrom::True, TimeTag::default()).unwrap();
    let [x, y, z] = p.to_array();
    assert!((x - 20_500.0).abs() < 1e-9 && (y + 3000.0).abs() < 1e-9);
    assert!((z + earth.drop_m(20_500.0, -3000.0)).abs() < 1e-9 && z < -20.0);
    assert_eq!(v, Vector::ZERO);
    // A platform that stands uses its nose.
    let tracks = [same(Track::fixed(Point::new(0.0, 0.0, 15.0), attitude))];
    let around = Surroundings { tracks: &tracks, frame: &frame, start: TimeTag::default() };
    let (p, _) = around.aim_point(&aim, AimFrom::Reported, TimeTag::default()).unwrap();
    assert!((p.to_array()[0] - 3000.0).abs() < 1e-9 && (p.to_array()[1] - 500.0).abs() < 1e-9);
}

#[test]
fn a_mount_without_angles_is_a_servo_that_points_ahead() {
    for yaw in [0.0, 1.0, -2.0] {
        let body = Rotation::from_yaw_pitch_roll(yaw, 0.0, 0.0);
        let ahead = body * Vector::new(1.0, 0.0, 0.0);
        let (from, to) = (Point::new(5.0, 6.0, 100.0), Point::new(5.0, 6.0, 100.0) + ahead * 1000.0);
        let (bolted, servo) = (fixed_mount(0.0, 0.0, 0.0).then(body), towards(from, to, body));
        for axis in [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0), Vector::new(0.0, 0.0, 1.0)] {
            assert!((bolted * axis - servo * axis).norm() < 1e-12);
        }
    }
    // Positive yaw looks to starboard (east when heading north), positive pitch up.
    let east = boresight(fixed_mount(std::f64::consts::FRAC_PI_2, 0.0, 0.0).then(level()));
    assert!((east - Vector::new(1.0, 0.0, 0.0)).norm() < 1e-15);
    let up = boresight(fixed_mount(0.0, 0.5, 0.0).then(level()));
    assert!((up.raw().z - 0.5f64.sin()).abs() < 1e-15);
}

#[test]
fn pointing_straight_down_takes_the_azimuth_of_the_body() {
    let from = Point::new(0.0, 0.0, 3000.0);
    for yaw in [0.0, 0.8, 3.0] {
        let body = Rotation::from_yaw_pitch_roll(yaw, 0.0, 0.0);
        let down = towards(from, Point::new(0.0, 0.0, 0.0), body);
        let port = body * Vector::new(0.0, -1.0, 0.0);
        assert!((down * Vector::new(0.0, 1.0, 0.0) - port).norm() < 1e-12);
        // A hair forward of straight down it is the same frame.
        let ahead = (body * Vector::new(1.0, 0.0, 0.0)) * 0.01;
        let nearly = towards(from, Point::new(0.0, 0.0, 0.0) + ahead, body);
        assert!((down * Vector::new(0.0, 1.0, 0.0) - nearly * Vector::new(0.0, 1.0, 0.0)).norm() < 1e-9);
    }
    // Nose down as well, and no distance at all: still a frame.
    let diving = Rotation::from_yaw_pitch_roll(0.4, -std::f64::consts::FRAC_PI_2, 0.0);
    for to in [Point::new(0.0, 0.0, 0.0), from] {
        let frame = towards(from, to, diving);
        let [w, x, y, z] = frame.to_wxyz();
        assert!((w * w + x * x + y * y + z * z - 1.0).abs() < 1e-12);
    }
}

/// Lever arm on a turning platform, against a finite difference of the turning arm.
#[test]
fn the_lever_arm_turns_with_the_platform() {
    let rate = Vector::new(0.02, -0.05, 0.3);
    let attitude_at = |s: f64| {
        let turn = glam::DQuat::from_scaled_axis(rate.raw() * s);
        Rotation::from_raw(turn * Rotation::from_yaw_pitch_roll(0.5, 0.1, -0.2).raw())
    };
    let arm = Vector::new(3.0, -1.0, 2.0);
    let (v, a) = (Vector::new(80.0, 10.0, 1.0), Vector::new(0.5, -1.0, 0.2));
    let state = |s: f64| State {
        position: Point::new(0.0, 0.0, 0.0) + v * s + a * (0.5 * s * s),
        velocity: v + a * s,
        acceleration: a,
        attitude: attitude_at(s),
        angular_rate: rate,
    };
    let centre = PhaseCentre::of(&state(0.0), arm);
    let at = |s: f64| PhaseCentre::of(&state(s), arm).position;
    let h = 1e-3;
    let velocity = (at(h) - at(-h)) * (0.5 / h);
    let acceleration = ((at(h) - at(0.0)) - (at(0.0) - at(-h))) * (1.0 / (h * h));
    // Truncation |w|^3 |l| h^2 / 6 = 2e-8; roundings of 0.1 m over h: 1e-13, over h^2: 1e-10.
    assert!((centre.velocity - velocity).norm() < 3e-8);
    assert!((centre.acceleration - acceleration).norm() < 3e-8);
}

/// A pedestal on the deck turns with the ship; one that is kept level knows no roll, and is misled by a wrong
/// heading.
#[test]
fn pedestals_on_a_ship_that_rolls() {
    let plain = SceneFrame::plain(Earth::Flat);
    let place = Point::new(0.0, 0.0, 20.0);
    let (yaw, roll, error) = (0.4, 0.15, 0.02);
    let truth = Rotation::from_yaw_pitch_roll(yaw, 0.0, roll);
    let tracks = [PlatformTracks {
        truth: Track::fixed(place, truth),
        reported: Track::fixed(place, Rotation::from_yaw_pitch_roll(yaw + error, 0.0, roll)),
    }];
    let turning = |level_by| AntennaMount {
        pointing: Pointing::Scan(Scan {
            law: ScanLaw::Rotation { rate_rad_per_s: 2.0, start_rad: -0.3, elevation_rad: 0.0 },
            level_by,
            encoder: Encoder::default(),
        }),
        ..pointed_at(0, [0.0; 3])
    };
    for t_s in [0.0, 0.35, 1.1] {
        let (t, az) = (TimeTag::new(0, t_s), -0.3 + 2.0 * t_s);
        let of = |level_by| boresight(frame_of(&turning(level_by), &tracks, &plain, t)).raw();
        // On the deck: ahead by the azimuth, to starboard and down by the roll.
        let (ahead, starboard) = (az.cos(), az.sin());
        let nose = Vector::<Enu>::new(yaw.sin(), yaw.cos(), 0.0).raw();
        let wing = Vector::<Enu>::new(yaw.cos(), -yaw.sin(), 0.0).raw() * roll.cos();
        let deck = nose * ahead + wing * starboard;
        assert!((of(None) - deck.with_z(-roll.sin() * starboard)).length() < 1e-12, "{t_s}");
        // Level: East by the sine of the bearing, North by its cosine.
        let level = of(Some(AimFrom::True));
        assert!((level - Vector::<Enu>::new(az.sin(), az.cos(), 0.0).raw()).length() < 1e-12, "{t_s}");
        // Whoever believes to head more to starboard turns the beam back by as much.
        let misled = of(Some(AimFrom::Reported));
        let bearing = misled.x.atan2(misled.y);
        // Roll takes a small part of it out of the plane: errors of second order.
        assert!(((bearing - (az - error)).sin()).abs() < error * roll, "{t_s}: {bearing}");
    }
}
