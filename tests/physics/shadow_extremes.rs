//! Visibility at the ends of what is legal, and the test that spares it.

use nereus::frames::{Enu, Point};
use nereus::geometry::shadow::{Map, Relief, Settings, Shadow, ShadowError};
use proptest::prelude::*;

use crate::shadow::{Ground, sea};

/// Every line of sight over a rough sea that the test lets pass has weights of 1, and it passes many.
#[test]
fn what_cannot_shadow_does_not() {
    let (mut spared, mut asked, mut fully_illuminated) = (0, 0, 0);
    for seed in 0..4 {
        let ground = sea(40, seed, 0.0);
        let relief = Relief::of(&ground.map());
        for settings in [Settings::SHARP, Settings::for_map(&ground.map())] {
            for range_m in [15.0, 60.0, 4e3, 8e5] {
                for grazing_deg in [2.0, 10.0, 25.0, 35.0, 45.0, 60.0, 80.0] {
                    for azimuth_deg in [0.0, 45.0, 100.0, 190.0, 293.0] {
                        let terminal = ground.terminal(range_m, azimuth_deg, grazing_deg);
                        let illuminated =
                            ground.weights(settings, terminal).iter().all(|v| (v - 1.0).abs() <= 1e-15);
                        asked += 1;
                        fully_illuminated += usize::from(illuminated);
                        if relief.cannot_shadow(&ground.map(), terminal, settings) {
                            spared += 1;
                            assert!(illuminated, "{terminal:?}");
                        }
                    }
                }
            }
        }
    }
    println!("{asked} lines of sight: {fully_illuminated} fully illuminated, {spared} known beforehand");
    assert!(spared > fully_illuminated / 2 && spared < asked);
}

/// For ridges across the line of sight the test is sharp: the steepest slope that falls away decides.
#[test]
fn the_steepest_falling_slope_decides() {
    // Up by 0.1 a facet three times, down by 0.3 once.
    let ground = Ground::new([8, 40], 1.0, |_, iy| 0.1 * (iy % 4) as f64);
    let relief = Relief::of(&ground.map());
    assert!((relief.rise[1] - 0.1).abs() < 1e-12 && (relief.fall[1] - 0.3).abs() < 1e-12);
    assert_eq!([relief.rise[0], relief.fall[0]], [0.0, 0.0]);
    for (azimuth_deg, slope) in [(-90.0, 0.3_f64), (90.0, 0.1)] {
        for (factor, expected) in [(0.98, false), (1.02, true)] {
            let terminal = ground.terminal(1e7, azimuth_deg, (slope * factor).atan().to_degrees());
            assert_eq!(relief.cannot_shadow(&ground.map(), terminal, Settings::SHARP), expected);
            let illuminated = ground.weights(Settings::SHARP, terminal).iter().all(|&v| v == 1.0);
            assert_eq!(illuminated, expected, "azimuth {azimuth_deg}, {factor} of the slope");
        }
    }
}

/// Nothing is seen from below the horizon but the first facets, which have nothing before them.
#[test]
fn below_the_horizon_all_is_dark() {
    let ground = Ground::new([20, 20], 1.0, |_, _| 0.0);
    for depth_m in [300.0, 1e4] {
        let terminal = Point::new(ground.first_m[0] + 9.5, ground.first_m[1] - 1e5, -depth_m);
        for settings in [Settings::SHARP, Settings { width_rad: 0.1, ..Settings::SHARP }] {
            let weights = ground.weights(settings, terminal);
            assert!(weights[..20].iter().all(|&v| v == 1.0));
            assert!(weights[20..].iter().all(|&v| v == 0.0));
        }
    }
}

/// Towards grazing incidence less and less of a sea is seen, and some of it always is.
#[test]
fn grazing_darkens_the_sea() {
    let ground = sea(64, 2, 0.0);
    let settings = Settings::for_map(&ground.map());
    let mut before = 1.0 + 1e-12;
    for grazing_deg in [60.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.3, 0.1, 0.01, 1e-6, 0.0] {
        let weights = ground.weights(settings, ground.terminal(1e6, 12.0, grazing_deg));
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        println!("grazing {grazing_deg} deg: mean weight {mean:.4}");
        assert!(mean <= before && mean > 0.0);
        before = mean;
    }
    assert!(before < 0.2);
}

/// Over the map, on a facet, on a grid line, in the water: the way in does not jump.
#[test]
fn a_terminal_may_be_anywhere() {
    let ground = sea(32, 4, 0.0);
    let settings = Settings::for_map(&ground.map());
    let [x, y] = ground.first_m;
    let high = ground.weights(settings, Point::new(x + 15.3, y + 16.8, 200.0));
    assert!(high.iter().all(|v| (v - 1.0).abs() < 1e-15));
    for (dx, dy) in [(15.0, 16.0), (15.0, 16.4), (15.7, 16.0), (0.0, 0.0), (31.0, 31.0), (-1e-10, 5.0)] {
        for z in [-5.0, 0.0, 0.5, 3.0] {
            let terminal = Point::new(x + dx, y + dy, z);
            let weights = ground.weights(settings, terminal);
            assert!(weights.iter().all(|v| (0.0..=1.0).contains(v)));
            let foot = dy.round().max(0.0) as usize * 32 + dx.round().max(0.0) as usize;
            assert_eq!(weights[foot], 1.0, "{terminal:?}");
            // In the water, what is beyond the neighbours is hidden.
            if z == -5.0 {
                let far = |i: usize| ((i % 32) as f64 - dx).abs().max(((i / 32) as f64 - dy).abs()) > 3.0;
                let seen = (0..1024).filter(|&i| far(i) && weights[i] > 0.0).count();
                // But along the edges of the map, where rays leave it.
                assert!(seen <= 64, "{seen} seen from {terminal:?}");
            }
        }
    }
}

/// As a terminal flies over the diagonals of facets, from row to row and onto the map, weights move with it.
#[test]
fn weights_follow_a_moving_terminal_without_jumps() {
    let ground = sea(40, 6, 0.0);
    let settings = Settings::for_map(&ground.map());
    let [x, y] = ground.first_m;
    let step = |fine: f64| {
        let path = |s: f64| Point::new(x - 60.0 + 130.0 * s, y - 75.0 + 120.0 * s, 14.0);
        let mut largest = 0.0_f64;
        // A stretch that crosses the diagonal of the map's middle.
        for k in 0..20 {
            let s = 0.10 + 0.011 * f64::from(k);
            let (a, b) = (ground.weights(settings, path(s)), ground.weights(settings, path(s + fine)));
            for [ix, iy] in (2..38).flat_map(|iy| (2..38).map(move |ix| [ix, iy])) {
                // Rays that come in by the side meet the map's edge suddenly.
                let i = iy * 40 + ix;
                largest = largest.max((a[i] - b[i]).abs());
            }
        }
        largest
    };
    let [coarse, fine] = [1e-4, 1e-6].map(step);
    println!("largest change over 1.8 cm of flight {coarse:.2e}, over 0.18 mm {fine:.2e}");
    assert!(fine < coarse / 20.0);
}

/// A workspace remembers nothing.
#[test]
fn results_do_not_depend_on_what_was_asked_before() {
    let ground = sea(36, 8, 0.0);
    let settings = Settings::for_map(&ground.map());
    let mut shadow = Shadow::new([36, 36], settings).unwrap();
    let terminals = [(1e4, 30.0), (50.0, 120.0), (10.0, 240.0), (8e5, 45.0)];
    let terminals = terminals.map(|(range_m, azimuth_deg)| ground.terminal(range_m, azimuth_deg, 2.0));
    let mut out = vec![f64::NAN; 36 * 36];
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 2, 0, 1]] {
        for i in order {
            shadow.weights(&ground.map(), terminals[i], &mut out).unwrap();
            assert_eq!(out, ground.weights(settings, terminals[i]));
        }
    }
}

#[test]
fn faults_are_named() {
    let heights_m = [0.0; 6];
    let text = |result: Result<_, ShadowError>| result.map(|_: Map<f64>| ()).unwrap_err().to_string();
    assert_eq!(
        text(Map::new(&heights_m, [0, 6], 1.0, [0.0; 2])),
        "height map of 0 x 6 facets: allowed are 1 to 1048576 a side, 268435456 in all"
    );
    assert_eq!(
        text(Map::new(&heights_m, [4, 2], 1.0, [0.0; 2])),
        "heights of a height map of 8 facets: 6 entries"
    );
    assert_eq!(
        text(Map::new(&heights_m, [3, 2], -1.0, [0.0; 2])),
        "facet of -1 m in a height map: it must be a length from 1e-6 to 1e9 m"
    );
    assert_eq!(
        text(Map::new(&heights_m, [3, 2], 1.0, [0.0, f64::NAN])),
        "first facet at NaN m along y: it must be within 1e12 m of the origin"
    );
    let map = Map::new(&heights_m, [3, 2], 1.0, [0.0; 2]).unwrap();
    let new = |width_rad, rays_per_facet| Shadow::<f64>::new([3, 2], Settings { width_rad, rays_per_facet });
    for width_rad in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(
            new(width_rad, 2).unwrap_err().to_string(),
            format!("shadow edge of {width_rad} rad: allowed are 0 to 1000")
        );
    }
    assert_eq!(new(0.0, 0).unwrap_err().to_string(), "0 shadow rays per facet: allowed are 1 to 64");
    let mut shadow = new(0.0, 1).unwrap();
    let origin = Point::new(0.0, 0.0, 1.0);
    assert_eq!(
        shadow.weights(&map, origin, &mut [0.0; 5]).unwrap_err().to_string(),
        "output of a height map of 6 facets: 5 entries"
    );
    assert_eq!(
        shadow.weights(&map, Point::new(0.0, 0.0, 1e13), &mut [0.0; 6]).unwrap_err().to_string(),
        "terminal at 10000000000000 m along z: it must be within 1e12 m of the origin"
    );
    let other = Map::new(&heights_m, [2, 3], 1.0, [0.0; 2]).unwrap();
    assert_eq!(
        shadow.weights(&other, origin, &mut [0.0; 6]).unwrap_err().to_string(),
        "height map of [2, 3] facets, the workspace was made for [3, 2]"
    );
}

/// Any coordinate: on centres, between them, near the map, out of this world.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-3..16).prop_map(f64::from),
        (-6..30).prop_map(|i| 0.5 * f64::from(i) + 1e-9),
        -3.0..16.0,
        -1e3..1e3,
        -1e12..1e12,
        Just(1e-300),
        Just(-1e-12),
    ]
}

fn height() -> BoxedStrategy<f64> {
    prop_oneof![
        8 => -2.0..2.0,
        1 => -1e9..1e9,
        1 => prop_oneof![Just(0.0), Just(1e300), Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
    ]
    .boxed()
}

type Case = ([usize; 2], Vec<f64>, f64, [f64; 3], f64, usize);

fn case(height: impl Strategy<Value = f64> + Clone + 'static) -> impl Strategy<Value = Case> {
    (1_usize..14, 1_usize..14).prop_flat_map(move |(nx, ny)| {
        (
            Just([nx, ny]),
            prop::collection::vec(height.clone(), nx * ny),
            prop_oneof![Just(1.0), 1e-6..1e-3, 1e3..1e9],
            [coordinate(), coordinate(), coordinate()],
            prop_oneof![Just(0.0), Just(5e-324), 1e-9..10.0, Just(1e3)],
            1_usize..5,
        )
    })
}

fn weights_of((facets, heights_m, facet_m, [x, y, z], width_rad, rays_per_facet): Case) -> Vec<f64> {
    let ground = Ground { heights_m, facets, facet_m, first_m: [0.0, 0.0] };
    let settings = Settings { width_rad, rays_per_facet };
    let terminal: Point<Enu> = Point::new(x, y, z);
    let relief = Relief::of(&ground.map());
    let weights = ground.weights(settings, terminal);
    if relief.cannot_shadow(&ground.map(), terminal, settings) {
        assert!(weights.iter().all(|v| (v - 1.0).abs() <= 1e-15), "reported as illuminated");
    }
    weights
}

proptest! {
    #![proptest_config(crate::cases::proptests(2000))]

    #[test]
    fn weights_of_any_scene_lie_between_0_and_1(case in case(-1e6..1e6)) {
        for v in weights_of(case) {
            prop_assert!((0.0..=1.0 + 1e-15).contains(&v));
        }
    }

    #[test]
    fn heights_that_are_no_numbers_never_give_nan(case in case(height())) {
        let (facets, heights_m, facet_m, [x, y, z], width_rad, rays_per_facet) = case;
        let ground = Ground { heights_m, facets, facet_m, first_m: [0.0, 0.0] };
        let settings = Settings { width_rad, rays_per_facet };
        for v in ground.weights(settings, Point::new(x, y, z)) {
            prop_assert!((0.0..=1.0 + 1e-15).contains(&v));
        }
    }
}
