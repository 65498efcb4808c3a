//! Waves and turbulent wake of ships on tracks: sums and maps agree, rates are those of heights, and behind a
//! straight leg the wake is that of a straight course.

use nereus::motion::waypoints::knots;
use nereus::scene::ship::{HullGiven, KelvinWake, Ship, TurbulentWake};
use nereus::scene::{Patch, Trajectory};
use nereus::sea::fleet::Fleet;
use nereus::sea::surface::Selection;

const SPEED_MPS: f64 = 6.0;

fn ship(trajectory: Option<Trajectory>) -> Ship {
    Ship {
        name: "tug".into(),
        hull: HullGiven::Wigley { beam_m: 6.0, draught_m: 2.0 },
        length_m: Some(40.0),
        position_m: [0.0, 0.0],
        heading_rad: 0.0,
        speed_mps: SPEED_MPS,
        trajectory,
        kelvin: Some(KelvinWake::default()),
        turbulent: Some(TurbulentWake::default()),
        echo: false,
        mesh: Default::default(),
        panels: Default::default(),
    }
}

/// East for 2 km, through the origin at pulse 0, then about to the North.
fn turning() -> Ship {
    let way = knots(&[[-1800.0, 0.0], [240.0, 0.0], [240.0, 900.0]], SPEED_MPS, 120.0, -300.0).unwrap();
    ship(Some(Trajectory::new(way).unwrap()))
}

#[test]
fn maps_are_sums_of_legs() {
    let patch = Patch::new([400.0, 400.0], 2.0, [150.0, 60.0]).unwrap();
    for time_s in [20.0, 45.0, 80.0] {
        let fleet = Fleet::muster(&[turning()], &[(time_s, patch)]).unwrap();
        assert!(fleet.wakes.len() >= 2, "{}", fleet.wakes.len());
        let fields = fleet.waves(&patch, Selection::ALL, time_s).unwrap();
        let most = |of: &[f64]| of.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let [height, up, slope] =
            [&fields.height_m, &fields.velocity_mps[2], &fields.slope[0]].map(|f| most(f));
        assert!(height > 0.05, "{height}");
        for index in (0..patch.len()).step_by(977) {
            let place = patch.centre_m(patch.key(index));
            let mut sum = [0.0; 3];
            for wake in &fleet.wakes {
                // Beyond its reach a leg has no waves.
                let Ok(sample) = wake.at(place, time_s) else { continue };
                sum = [sum[0] + sample.height_m, sum[1] + sample.velocity_mps[2], sum[2] + sample.slope[0]];
            }
            let found = [fields.height_m[index], fields.velocity_mps[2][index], fields.slope[0][index]];
            for ((found, sum), scale) in found.iter().zip(sum).zip([height, up, slope]) {
                assert!((found - sum).abs() < 1e-6 * scale, "{time_s} {place:?}: {found} {sum}");
            }
        }
    }
}

/// Vertical velocity is the rate of the height, its acceleration that of the velocity, and slopes are those
/// of the heights, where legs fade as well: second differences over 0.02 s and 0.02 m.
#[test]
fn rates_are_those_of_the_heights() {
    let patch = Patch::new([500.0, 500.0], 2.0, [150.0, 60.0]).unwrap();
    let (time_s, h) = (70.0, 0.01);
    let fleet = Fleet::muster(&[turning()], &[(time_s - 1.0, patch), (time_s + 1.0, patch)]).unwrap();
    let at = |place: [f64; 2], time_s: f64| {
        let found = fleet.wakes.iter().filter_map(|wake| wake.at(place, time_s).ok());
        found.fold([0.0; 4], |sum, s| {
            [
                sum[0] + s.height_m,
                sum[1] + s.velocity_mps[2],
                sum[2] + s.acceleration_mps2[2],
                sum[3] + s.slope[1],
            ]
        })
    };
    let mut most = [0.0f64; 3];
    for n in 0..400 {
        let place = [-60.0 + 15.0 * f64::from(n % 20), -80.0 + 12.0 * f64::from(n / 20)];
        let (before, now, after) = (at(place, time_s - h), at(place, time_s), at(place, time_s + h));
        let aside = [h, -h].map(|d| at([place[0], place[1] + d], time_s)[0]);
        let off = [
            (after[0] - before[0]) / (2.0 * h) - now[1],
            (after[1] - before[1]) / (2.0 * h) - now[2],
            (aside[0] - aside[1]) / (2.0 * h) - now[3],
        ];
        most = [0, 1, 2].map(|i| most[i].max(off[i].abs()));
    }
    println!("off by {most:?}");
    assert!(most[0] < 1e-4 && most[1] < 1e-3 && most[2] < 1e-4, "{most:?}");
}

/// Long before it turns, the ship has the wake of a straight course; the leg ends where the course has
/// changed by 1e-4 rad, and its chord lies off by as little.
#[test]
fn a_straight_leg_is_a_straight_course() {
    let patch = Patch::new([400.0, 200.0], 2.0, [-250.0, 0.0]).unwrap();
    let of = |ship: Ship| {
        let fleet = Fleet::muster(&[ship], &[(0.0, patch)]).unwrap();
        fleet.waves(&patch, Selection::HEIGHT, 0.0).unwrap().height_m
    };
    let (plain, tracked) = (of(ship(None)), of(turning()));
    let most = plain.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let apart = plain.iter().zip(&tracked).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    println!("{apart:.1e} of {most:.3} m");
    assert!(most > 0.05 && apart < 1e-4 * most);
}

/// The strip lies on the track after the turn: where the ship was, and not where it would have sailed.
#[test]
fn the_turbulent_wake_follows_the_track() {
    let patch = Patch::new([16.0, 16.0], 2.0, [0.0, 0.0]).unwrap();
    let fleet = Fleet::muster(&[turning()], &[(0.0, patch)]).unwrap();
    let strip = &fleet.strips[0];
    let pose = strip.pose(110.0);
    for (place_m, covered) in [([240.0, 150.0], true), ([100.0, 0.0], true), ([400.0, 0.0], false)] {
        assert_eq!(strip.cover(place_m, &pose) > 0.5, covered, "{place_m:?}");
    }
    assert_eq!(strip.cover([240.0, 600.0], &pose), 0.0);
}

/// A row of facets from ahead of a small boat to far beyond the end of its wake has the wake in between.
#[test]
fn a_long_row_has_its_wake() {
    let patch = Patch::new([1024.0, 16.0], 1.0, [-400.0, 0.0]).unwrap();
    let boat = Ship {
        hull: HullGiven::Wigley { beam_m: 1.5, draught_m: 0.5 },
        length_m: Some(6.0),
        speed_mps: 4.0,
        heading_rad: std::f64::consts::PI,
        position_m: [-880.0, 0.0],
        ..ship(None)
    };
    let fleet = Fleet::muster(&[boat], &[(0.0, patch)]).unwrap();
    let fields = fleet.waves(&patch, Selection::HEIGHT, 0.0).unwrap();
    let place = [-830.0, 0.0];
    let index = (0..patch.len())
        .min_by(|a, b| {
            let off = |i: usize| {
                let [x, y] = patch.centre_m(patch.key(i));
                (x - place[0]).hypot(y - place[1])
            };
            off(*a).total_cmp(&off(*b))
        })
        .unwrap();
    let sum = fleet.wakes[0].at(patch.centre_m(patch.key(index)), 0.0).unwrap().height_m;
    assert!(sum.abs() > 1e-4, "{sum}");
    assert!((fields.height_m[index] - sum).abs() < 1e-6, "{} {sum}", fields.height_m[index]);
}
