//! Rasters of heights: what is read, and what is refused, by name and with what is allowed.

use std::path::{Path, PathBuf};

use nereus::frames::{Earth, Geodetic, SceneFrame};
use nereus::scene::{Land, Patch};
use nereus::sea::land::Dem;
use nereus::sea::land::fault::RasterFault;
use nereus::sea::land::geotiff::Raster;

use crate::dem::{Georeference, ORIGIN_DEG, around, write};

fn frame() -> SceneFrame {
    SceneFrame::at(Geodetic::from_deg(ORIGIN_DEG[0], ORIGIN_DEG[1], 0.0), Earth::Flat)
}

fn land(dem: &Path, sea_level_m: f64) -> Land {
    Land { dem: dem.to_owned(), sea_level_m, gamma: 0.1, hh_over_vv: 1.0, cross_over_vv: 0.1 }
}

fn patch(side_m: f64) -> Patch {
    Patch::new([side_m, side_m], 2.0, [0.0, 0.0]).unwrap()
}

fn sound() -> Georeference {
    Georeference::geographic([9.99, 54.01], [1e-3, 1e-3])
}

/// What is refused of a raster of 20 x 20 heights.
fn refused(at: &Georeference, heights_m: &[f32]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.tif");
    write(&path, [20, 20], at, heights_m);
    Dem::open(&land(&path, 0.0), frame(), 1, &[patch(200.0)]).unwrap_err().to_string()
}

#[test]
fn heights_are_those_of_the_raster_in_both_kinds_of_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let [geographic, utm] = ["geographic.tif", "utm.tif"].map(|name| folder.path().join(name));
    // A plane: bilinear is exact but for the turn of the raster's axes.
    let plane = |[x, y]: [f64; 2]| 30.0 + 0.1 * x - 0.2 * y;
    around(&geographic, [0.0, 0.0], 100, 10.0, plane);
    // Zone 32 has its central meridian at 9 degrees: North of its grid is turned against that of the scene by
    // 1 degree times the sine of the latitude. The origin lies at 565548.52 m East, 5983984.46 m North by
    // Snyder's series (USGS Professional Paper 1395, eqs. 8-9 and 8-10), which is not the one of the program.
    let (east_m, north_m) = (565_548.518, 5_983_984.455);
    let turn = (0.809f64).to_radians();
    let heights: Vec<f32> = (0..100 * 100)
        .map(|cell| {
            let (column, row) = (f64::from(cell % 100), f64::from(cell / 100));
            let (e, n) = ((column - 49.5) * 10.0, (49.5 - row) * 10.0);
            // The scale of the zone is 0.99965 here.
            let (x, y) = (e * turn.cos() + n * turn.sin(), n * turn.cos() - e * turn.sin());
            plane([x, y]) as f32
        })
        .collect();
    let at = Georeference {
        scale: None,
        tie: None,
        transformation: Some(
            [
                10.0,
                0.0,
                0.0,
                east_m - 500.0,
                0.0,
                -10.0,
                0.0,
                north_m + 500.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
                1.0,
            ]
            .to_vec(),
        ),
        keys: Some(vec![1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32632]),
        nodata: None,
    };
    write(&utm, [100, 100], &at, &heights);
    for (path, tolerance_m) in [(&geographic, 0.01), (&utm, 0.05)] {
        let dem = Dem::open(&land(path, 2.0), frame(), 1, &[patch(200.0)]).unwrap();
        for place in [[0.0, 0.0], [123.0, -77.0], [-300.0, 250.0]] {
            let off_m = dem.height_m(place) - (plane(place) - 2.0);
            println!("{place:?}: {off_m:.4} m off");
            assert!(off_m.abs() < tolerance_m, "{path:?} {place:?} {off_m}");
        }
        // Beyond the raster is sea.
        assert_eq!(dem.height_m([2000.0, 0.0]), 0.0);
    }
}

#[test]
fn cells_without_data_are_sea() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.tif");
    let mut heights = vec![50.0f32; 400];
    heights[..200].fill(-9999.0);
    write(&path, [20, 20], &Georeference { nodata: Some("-9999"), ..sound() }, &heights);
    let dem = Dem::open(&land(&path, 0.0), frame(), 1, &[patch(200.0)]).unwrap();
    assert_eq!((dem.height_m([0.0, 600.0]), dem.top_m()), (0.0, 50.0));
    assert!((dem.height_m([0.0, -600.0]) - 50.0).abs() < 1e-6);
}

/// Rows are 111.3 m apart; that at -55.6 m is the last with data, the next one lies at the height of the sea.
#[test]
fn a_coast_slopes_to_cells_without_data() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.tif");
    let mut heights = vec![50.0f32; 400];
    heights[..200].fill(f32::NAN);
    write(&path, [20, 20], &Georeference { nodata: Some("nan"), ..sound() }, &heights);
    for sea_level_m in [0.0, 10.0, -10.0] {
        let dem = Dem::open(&land(&path, sea_level_m), frame(), 1, &[patch(200.0)]).unwrap();
        for y_m in [-60.0, -55.7, -40.0, 0.0, 30.0, 55.0, 56.0] {
            let share = (0.5f64 - y_m / 111.3).clamp(0.0, 1.0);
            let off_m = dem.height_m([0.0, y_m]) - (50.0 - sea_level_m) * share;
            assert!(off_m.abs() < 0.1, "{sea_level_m} {y_m}: {off_m}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_raster_is_named() {
    let flat = vec![5.0f32; 400];
    let keys =
        |last: [u16; 4], model: u16| Some([vec![1, 1, 0, 2, 1024, 0, 1, model], last.to_vec()].concat());
    let cases: [(Georeference, &str); 6] = [
        (Georeference { scale: None, tie: None, ..sound() }, "without georeference"),
        (Georeference { scale: None, ..sound() }, "tie points alone"),
        (Georeference { keys: None, ..sound() }, "no GeoKeys"),
        (
            Georeference { keys: keys([3072, 0, 1, 3857], 1), ..sound() },
            "coordinate system EPSG 3857; allowed: EPSG 4326",
        ),
        (
            Georeference {
                transformation: Some(vec![
                    0.7, 0.7, 0.0, 9.99, 0.7, -0.7, 0.0, 54.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
                ]),
                ..sound()
            },
            "rotated or flipped",
        ),
        (
            Georeference::geographic([11.0, 54.01], [1e-3, 1e-3]),
            "does not cover the patch: 100 % of its edge",
        ),
    ];
    for (at, expected) in cases {
        let message = refused(&at, &flat);
        println!("{message}");
        assert!(message.contains(expected) && message.starts_with("land.dem "), "{message}");
    }
    let mut odd = flat.clone();
    (odd[45], odd[46]) = (f32::NAN, -32_768.0);
    let message = refused(&sound(), &odd);
    assert!(message.contains("2 cells without a height") && message.contains("column 5, row 2"), "{message}");
    // All at once.
    let message = refused(&Georeference { scale: None, tie: None, keys: None, ..sound() }, &odd);
    assert!(
        ["neither pixel scale", "no GeoKeys", "2 cells"].iter().all(|part| message.contains(part)),
        "{message}"
    );
}

/// Facets of 50 m, with centres from -100 to 50 m and corners from -125 to 75 m both ways.
#[test]
fn a_raster_must_hold_the_corners_of_the_outermost_facets() {
    let folder = tempfile::tempdir().unwrap();
    let wide = Patch::new([200.0, 200.0], 50.0, [0.0, 0.0]).unwrap();
    let open = |cells: u32| {
        let path = folder.path().join(format!("{cells}.tif"));
        around(&path, [-25.0, -25.0], cells, 10.0, |_| 80.0);
        Dem::open(&land(&path, 0.0), frame(), 1, &[wide])
    };
    // 190 m hold all centres, 210 m all corners.
    let message = open(19).unwrap_err().to_string();
    assert!(message.contains("does not cover the patch"), "{message}");
    let dem = open(21).unwrap();
    for corner in [[-125.0, -125.0], [75.0, -125.0], [-125.0, 75.0], [75.0, 75.0]] {
        assert!((dem.height_m(corner) - 80.0).abs() < 1e-9, "{corner:?}");
    }
}

#[test]
fn a_scene_that_is_not_georeferenced_has_no_land() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.tif");
    write(&path, [20, 20], &sound(), &[5.0; 400]);
    let plain = SceneFrame::plain(Earth::Flat);
    let error = Dem::open(&land(&path, 0.0), plain, 1, &[patch(200.0)]).unwrap_err();
    assert_eq!(error.faults, [RasterFault::NoOrigin]);
    let missing = Dem::open(&land(&PathBuf::from("none.tif"), 0.0), frame(), 1, &[]).unwrap_err().to_string();
    assert!(missing.contains("cannot be read"), "{missing}");
}

/// A file cut anywhere, or with a byte changed, is refused or read, and nothing panics.
#[test]
fn corrupt_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("coast.tif");
    write(&path, [20, 20], &sound(), &[5.0; 400]);
    let whole = std::fs::read(&path).unwrap();
    assert!(Raster::parse(&whole).is_ok());
    for length in (0..whole.len()).step_by(7) {
        assert!(Raster::parse(&whole[..length]).is_err(), "{length} bytes");
    }
    for at in 0..whole.len() {
        for bit in [0x01, 0x80, 0xff] {
            let mut corrupt = whole.clone();
            corrupt[at] ^= bit;
            let _ = Raster::parse(&corrupt);
        }
    }
    let message = Raster::parse(b"GIF89a").unwrap_err();
    assert!(matches!(&message[..], [RasterFault::NoTiff(_)]), "{message:?}");
}
