//! Particulars of the shipped hulls, of forms known in closed form, and what does not change them.

use std::path::Path;

use nereus::frames::Point;
use nereus::scene::hull::{Facts, Hull, Particulars, QUANTITIES, Scatterer, Stated};
use proptest::prelude::*;

fn shipped(file: &str) -> Hull {
    Hull::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("hulls").join(file)).unwrap()
}

/// Computed apart from the same tables with Simpson's rule; to half the last digit that is printed.
#[test]
fn shipped_hulls_have_their_particulars() {
    let expected: [(&str, f64, f64, f64, f64, f64, f64); 4] = [
        ("dtmb5415.toml", 8452.216, 19.0928, 0.5069, 0.8191, 0.7747, -0.565),
        ("dtmb5415_fine.toml", 8453.151, 19.0932, 0.5070, 0.8206, 0.7747, -0.564),
        ("wigley.toml", 2777.778, 10.0, 0.4444, 0.6667, 0.6667, 0.0),
        ("series60.toml", 4246.809, 13.3333, 0.5972, 0.9730, 0.7073, -1.484),
    ];
    for (file, volume_m3, beam_m, block, midship, waterplane, lcb_percent) in expected {
        let found = Particulars::of(&shipped(file));
        for (name, found, expected, digits) in [
            ("volume", found.volume_m3, volume_m3, 3),
            ("beam", found.beam_m, beam_m, 4),
            ("block", found.block, block, 4),
            ("midship", found.midship, midship, 4),
            ("waterplane", found.waterplane, waterplane, 4),
            ("lcb", found.lcb_percent, lcb_percent, 3),
        ] {
            // Offsets are printed to a micrometre: 1e-7 of the volume, the ten thousandth part of what is
            // compared.
            let allowed = 0.5 * 10f64.powi(-digits) * 1.001 + 1e-7 * expected.abs();
            assert!((found - expected).abs() <= allowed, "{file} {name}: {found}, {expected}");
        }
    }
}

/// The figures published for the bare 5415 at full scale (SIMMAN), and how far a table lifted from its
/// surface is off.
#[test]
fn the_5415_is_the_published_ship() {
    for (file, surface_percent) in [("dtmb5415.toml", 2.0), ("dtmb5415_fine.toml", 1.0)] {
        let hull = shipped(file);
        let found = Particulars::of(&hull);
        let within = |found: f64, published: f64, percent: f64| {
            let off = 100.0 * (found / published - 1.0);
            assert!(off.abs() <= percent, "{file}: {found}, published {published}: {off:.2} %");
        };
        within(found.beam_m, 19.06, 0.2);
        within(found.volume_m3, 8424.4, 0.35);
        within(found.block, 0.507, 0.1);
        within(found.midship, 0.821, 0.25);
        within(found.wetted_surface_m2, 2972.6, surface_percent);
        assert!((found.lcb_percent + 0.683).abs() < 0.125);
        // The dome reaches below the draught; the transom's edge is at 0.56 m.
        assert!((9.1..9.3).contains(&hull.depth_m()) && hull.draught_m() == 6.15);
        assert!((0.5..0.8).contains(&hull.transom_depth_m()));
    }
    assert_eq!(shipped("wigley.toml").transom_depth_m(), 0.0);
}

/// Sections of the fine table, integrated apart and printed to 1e-5 m^2.
#[test]
fn sections_of_the_fine_table() {
    let path = format!("{}/tests/data/hulls/dtmb5415_sectional_area.csv", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    let hull = shipped("dtmb5415_fine.toml");
    let sections = hull.section_areas_m2();
    assert_eq!(text.lines().skip(1).count(), sections.len());
    for ((line, found), x) in text.lines().skip(1).zip(sections).zip(hull.stations_m()) {
        let [x_m, area_m2] = line.split(',').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>()[..]
        else {
            panic!("{line}")
        };
        // Printed digits, and half-breadths to half a micrometre over 9 m of depth, both sides.
        assert!((x + 71.0 - x_m).abs() < 1e-5 && (found - area_m2).abs() < 0.5e-5 + 1e-5, "{line}: {found}");
    }
}

#[test]
fn the_parabolic_hull_in_closed_form() {
    let (length_m, beam_m, draught_m) = (100.0, 10.0, 6.25);
    let found = Particulars::of(&Hull::wigley(length_m, beam_m, draught_m).unwrap());
    let near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
    near(found.volume_m3, 4.0 / 9.0 * length_m * beam_m * draught_m);
    near(found.block, 4.0 / 9.0);
    near(found.midship, 2.0 / 3.0);
    near(found.waterplane, 2.0 / 3.0);
    assert!(found.lcb_percent.abs() < 1e-12);
    // Inscribed triangles lose 1/24 of the square of the turn between neighbours: Y_z goes from 0 to B/T =
    // 1.6 over 24 waterlines, 1.9e-4 at most. At the four lower corners half a triangle pair lies on the
    // centre plane and is not counted: a quarter of 2 m x 0.26 m each, 3.5e-4 of the whole.
    let surface_m2 = 0.148_790_63 * length_m * length_m;
    let lost = 1.0 - found.wetted_surface_m2 / surface_m2;
    assert!((3.5e-4..5.4e-4).contains(&lost), "{lost:e}");
    // The table that is shipped is the same hull, to its six decimals.
    let table = shipped("wigley.toml");
    let formula = Hull::wigley(length_m, beam_m, draught_m).unwrap();
    for i in 0..51 {
        for (a, b) in table.half_breadths_m(i).iter().zip(formula.half_breadths_m(i)) {
            assert!((a - b).abs() <= 0.5001e-6);
        }
    }
}

/// A box: everything is exact, its flat bottom and blunt bow are skin.
#[test]
fn a_box() {
    let hull = Hull::new(&[0.0, 5.0, 10.0], &[-1.0, -0.5, 0.0], &[1.0; 9], Facts::default()).unwrap();
    let found = Particulars::of(&hull);
    assert_eq!((found.volume_m3, found.block, found.midship, found.waterplane), (20.0, 1.0, 1.0, 1.0));
    // Two sides of 10 x 1, a bottom of 10 x 2.
    assert!((found.wetted_surface_m2 - 40.0).abs() < 1e-13);
    assert_eq!((hull.depth_m(), hull.transom_depth_m()), (1.0, 1.0));
}

#[test]
fn scaling_keeps_the_form() {
    let hull = shipped("dtmb5415.toml");
    let small = hull.scaled_to_length(100.0).unwrap();
    let ratio: f64 = 100.0 / 142.0;
    let powers = [1, 1, 1, 3, 2, 0, 0, 0, 0];
    let pairs = Particulars::of(&hull).values().into_iter().zip(Particulars::of(&small).values());
    for (((large, small), power), quantity) in pairs.zip(powers).zip(QUANTITIES) {
        assert!((small - large * ratio.powi(power)).abs() < 1e-12 * large.abs().max(1.0), "{quantity}");
    }
    for ((large, small), power) in hull.stated().values.iter().zip(small.stated().values).zip(powers) {
        assert_eq!(small, large.map(|value| value * ratio.powi(power)));
    }
    assert!(small.stated().disagreements(&Particulars::of(&small)).is_empty());
    for length_m in [0.0, 0.04, -100.0, 1000.1, f64::NAN, f64::INFINITY] {
        let error = hull.scaled_to_length(length_m).unwrap_err().to_string();
        assert_eq!(error, format!("hull of {length_m} m: allowed are 0.05 to 1000 m"));
    }
    let mast = Scatterer { name: "mast".to_owned(), position: Point::new(10.0, 0.0, -20.0), rcs_m2: 50.0 };
    let facts = Facts { scatterers: vec![mast.clone()], ..Facts::default() };
    let hull = Hull::new(&[0.0, 5.0, 10.0], &[-1.0, -0.5, 0.0], &[1.0; 9], facts).unwrap();
    let scaled = hull.scaled_to_length(5.0).unwrap();
    assert_eq!(scaled.scatterers(), [Scatterer { position: Point::new(5.0, 0.0, -10.0), ..mast }]);
}

#[test]
fn numbers_that_are_no_hull_are_refused() {
    let refused = |stations: &[f64], waterlines: &[f64], half: &[f64], words: &str| {
        let error = Hull::new(stations, waterlines, half, Facts::default()).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    };
    let (x, z) = ([0.0, 5.0, 10.0], [-1.0, -0.5, 0.0]);
    refused(&[], &[], &[], "0 stations; allowed: an odd number, 3 to 2001");
    refused(&x, &z, &[1.0; 8], "8 half-breadths; needed are 9");
    refused(&[0.0, f64::NAN, 1.0], &z, &[1.0; 9], "station 1: NaN where a finite number is needed");
    refused(&x, &[f64::NEG_INFINITY, -1.0, 0.0], &[1.0; 9], "waterline 0: -inf where");
    refused(&x, &z, &[f64::INFINITY; 9], "station 2: inf where");
    refused(&x, &z, &[0.0; 9], "no volume");
    refused(&[0.0, 5.0, 1e9], &z, &[1.0; 9], "lies too far from the middle");
    refused(&[0.0, 5e8, 1e9], &z, &[1.0; 9], "the length is 1000000000 m; allowed: 0.05 to 1000 m");
    refused(&x, &z, &[6.0; 9], "the beam is 12 m; allowed: 0.001 to 10 m");
    refused(&x, &[-20.0, -10.0, 0.0], &[1.0; 9], "the depth of the table is 20 m");
    let facts = |draught_m, block| {
        let mut stated = Stated::default();
        stated.values[5] = Some(block);
        Facts { draught_m: Some(draught_m), stated, ..Facts::default() }
    };
    let deep = Hull::new(&x, &z, &[1.0; 9], facts(2.0, 0.5)).unwrap_err().to_string();
    assert!(deep.contains("draught_m is 2 m; allowed: 0.001 to 1.0"), "{deep}");
    let wrong = Hull::new(&x, &z, &[1.0; 9], facts(1.0, 0.9)).unwrap_err().to_string();
    assert!(
        wrong.contains("block is stated as 0.9, the table gives 1.000000; allowed: within 1 percent"),
        "{wrong}"
    );
    for dimensions_m in
        [[0.0, 1.0, 1.0], [f64::NAN; 3], [10.0, 0.0, 1.0], [10.0, 1.0, -1.0], [1e-300; 3], [1e300; 3]]
    {
        let [length_m, beam_m, draught_m] = dimensions_m;
        assert!(Hull::wigley(length_m, beam_m, draught_m).is_err(), "{dimensions_m:?}");
    }
}

proptest! {
    #![proptest_config(crate::cases::proptests(64))]

    #[test]
    fn particulars_of_any_hull_are_finite(
        numbers in prop::collection::vec(prop_oneof![0.0..1.0f64, Just(0.0)], 35),
        length_m in prop_oneof![0.05..1000.0f64, Just(0.05), Just(1000.0)],
        depth in 1e-4..1.0f64,
    ) {
        let stations: Vec<f64> = (0..7).map(|i| length_m * f64::from(i) / 6.0).collect();
        let waterlines: Vec<f64> = (0..5).map(|j| depth * length_m * (f64::from(j) / 4.0 - 1.0)).collect();
        let half: Vec<f64> = numbers.iter().map(|y| 0.5 * y * length_m).collect();
        if let Ok(hull) = Hull::new(&stations, &waterlines, &half, Facts::default()) {
            for (value, quantity) in Particulars::of(&hull).values().into_iter().zip(QUANTITIES) {
                prop_assert!(value.is_finite(), "{} {}", quantity, value);
            }
        }
    }
}
