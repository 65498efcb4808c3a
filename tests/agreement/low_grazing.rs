//! sigma0 near grazing, from every facet of a run: without shadows, with them, and with the ray that the sea
//! reflects, beside what was measured; the tables of docs/sigma0.md on low grazing angles.
//!
//! Power is the sum over facets behind 400 m of water and more, normalised facet by facet by the radar
//! equation. Facets of 2 m, one sea: a coarse figure, that repeats.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::units::SPEED_OF_LIGHT_MPS;

use crate::cases::{sized, some_of};
use crate::runs::{keeps_the_error, scene};

const FAR_M: f64 = 100e3;
const SCENE: &str = "tests/data/clutter/low-grazing.toml";
/// Nothing hidden; shadows; shadows and two rays.
const STEPS: [&str; 3] = ["{ enabled = false }", "{ enabled = true }", "{ enabled = true, two_rays = true }"];
/// Receiver of Pidgeon's measurements, degrees: his were 10 to 90.
const PIDGEON_RX_DEG: f64 = 20.0;
/// Transmitter's grazing angle, degrees, and what Pidgeon measured in VV, dB (sea state 3).
const PIDGEON: [(f64, f64); 4] = [(0.2, -54.0), (3.0, -42.0), (0.6, -49.0), (1.0, -47.0)];
/// Receiver's grazing angle, degrees, of Kochanski's measurements, and their mean in VV, dB (sea state 1).
const KOCHANSKI: [(f64, f64); 3] = [(5.0, -50.0), (40.0, -50.0), (20.0, -50.0)];
/// Bistatic angle, degrees, and what Ewell and Zehner measured of bistatic over monostatic, VV and HH, dB
/// (sea state 4).
const EWELL: [(f64, [f64; 2]); 4] =
    [(24.0, [-4.5, -5.9]), (60.0, [-25.3, -19.4]), (45.0, [-23.3, -17.4]), (35.0, [-14.3, -11.0])];
/// Heights of their transmitter and receiver, and the distance between these, m.
const EWELL_M: [f64; 3] = [22.9, 8.2, 3500.0];

/// An end, seen from the patch: azimuth and grazing angle, degrees.
#[derive(Clone, Copy)]
struct Place {
    azimuth_deg: f64,
    grazing_deg: f64,
}

impl Place {
    fn position_m(self) -> [f64; 3] {
        let [azimuth, grazing] = [self.azimuth_deg, self.grazing_deg].map(f64::to_radians);
        [FAR_M * grazing.cos() * azimuth.cos(), FAR_M * grazing.cos() * azimuth.sin(), FAR_M * grazing.sin()]
    }
}

/// sigma0 of VV and HH, dB, between two ends, with such shadows.
fn sigma0_db(sea: &[(&str, &str)], ends: [Place; 2], shadow: &str) -> [f64; 2] {
    let [tx, rx] = ends.map(Place::position_m);
    let [from, to] = [format!("{tx:?}"), format!("{rx:?}")];
    let places = [
        ("platform.far.track.position_m", &from[..]),
        ("platform.near.track.position_m", &to),
        ("sea.shadow", shadow),
        ("fidelity.echo", "\"reference\""),
    ];
    let run = scene(SCENE, &[sea, &places].concat());
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    let factory = factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap();
    let snapshot = factory.snapshots(&[0]).unwrap().pop().unwrap();
    let wavelength_m = SPEED_OF_LIGHT_MPS / run.scene.radar.carrier_hz;
    let patch = snapshot.patch;
    let (mut sums, mut area_m2) = ([0.0; 2], 0.0);
    for facet in 0..patch.len() {
        let [x, y] = patch.centre_m(patch.key(facet));
        if x > 0.0 || y.abs() > 96.0 {
            continue;
        }
        area_m2 += patch.facet_m * patch.facet_m;
        let square_m2 = |end: [f64; 3]| {
            (end[0] - x).powi(2) + (end[1] - y).powi(2) + (end[2] - snapshot.height_m[facet]).powi(2)
        };
        let link = (4.0 * PI).powi(3) * square_m2(tx) * square_m2(rx) / wavelength_m.powi(2);
        for (sum, channel) in sums.iter_mut().zip(&snapshot.amplitude) {
            *sum += channel[facet].norm_sqr() * link;
        }
    }
    sums.map(|sum| 10.0 * (sum / area_m2).log10())
}

/// The rows of numbers under a heading of the page.
fn page(heading: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sigma0.md")).unwrap();
    let (_, below) = text.split_once(&format!("### {heading}\n\n")).unwrap_or_else(|| panic!("no {heading}"));
    let rows =
        below.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    rows.skip(2)
        .map(|row| row.trim_matches('|').split('|').map(|cell| cell.trim().parse().unwrap()).collect())
        .collect()
}

/// Rows of tables that were computed, by heading: angles, degrees, of which the first names the row, and dB.
#[derive(Default)]
struct Computed(Vec<(&'static str, Vec<f64>, Vec<f64>)>);

impl Computed {
    fn add(&mut self, heading: &'static str, angles_deg: &[f64], row_db: &[f64]) {
        let angles = angles_deg.iter().map(|angle| format!("{}", (100.0 * angle).round() / 100.0));
        let printed: Vec<String> = angles.chain(row_db.iter().map(|cell| format!("{cell:.1}"))).collect();
        println!("{heading}: | {} |", printed.join(" | "));
        self.0.push((heading, angles_deg.to_vec(), row_db.to_vec()));
    }

    /// Asserts that the page has them.
    fn stand_on_the_page(&self) {
        for (heading, angles_deg, row_db) in &self.0 {
            let rows = page(heading);
            let found = rows.iter().find(|own| own[0] == angles_deg[0]);
            let found = found.unwrap_or_else(|| panic!("{heading}: no {}", angles_deg[0]));
            assert_eq!(found.len(), angles_deg.len() + row_db.len(), "{heading}");
            // Half the page's last digit.
            let angles = angles_deg.iter().map(|angle| (angle, 0.005));
            for (cell, (expected, off)) in found.iter().zip(angles.chain(row_db.iter().map(|db| (db, 0.05))))
            {
                assert!(
                    (cell - expected).abs() <= off + 1e-6,
                    "{heading}: page {found:?}, computed {row_db:?}"
                );
            }
        }
    }
}

#[test]
fn shadows_make_sigma0_fall_with_the_transmitters_angle_as_measured() {
    let sea = [("radar.carrier_hz", "5.3e9"), ("sea.wind_mps", "9.3")];
    let rx = Place { azimuth_deg: 0.0, grazing_deg: PIDGEON_RX_DEG };
    let (mut above_db, mut computed) = (Vec::new(), Computed::default());
    for (grazing_deg, measured_db) in some_of(PIDGEON) {
        let tx = Place { azimuth_deg: 0.0, grazing_deg };
        let [bare, shadows, two_rays] = STEPS.map(|step| sigma0_db(&sea, [tx, rx], step)[0]);
        computed.add("Transmitter near grazing", &[grazing_deg], &[bare, shadows, two_rays, measured_db]);
        assert!(shadows < bare - 1.0, "nothing is hidden");
        above_db.push(two_rays - measured_db);
    }
    // What remains is a level, not a fall: the same at all angles.
    let spread_db =
        above_db.iter().fold(f64::MIN, |a, b| a.max(*b)) - above_db.iter().fold(f64::MAX, |a, b| a.min(*b));
    println!("above what was measured by {above_db:.1?} dB");
    assert!(spread_db < 6.0, "{above_db:?}");
    computed.stand_on_the_page();
}

#[test]
fn the_smaller_angle_of_the_receiver_makes_most_of_the_fall_with_azimuth() {
    let sea =
        [("radar.carrier_hz", "9.38e9"), ("sea.wind_mps", "9.2"), ("scene.patch_size_m", "[1024.0, 640.0]")];
    let [tx_m, rx_m, apart_m] = EWELL_M;
    let mut computed = Computed::default();
    for (bistatic_deg, measured_db) in some_of(EWELL) {
        let angle = bistatic_deg.to_radians();
        // The transmitter looks at right angles to the line between both ends.
        let [tx_deg, rx_deg] = [tx_m / (apart_m / angle.tan()), rx_m / (apart_m / angle.sin())]
            .map(|sine| sine.asin().to_degrees());
        let tx = Place { azimuth_deg: 0.5 * bistatic_deg, grazing_deg: tx_deg };
        let rx = Place { azimuth_deg: -0.5 * bistatic_deg, grazing_deg: rx_deg };
        let ratios = STEPS.map(|step| {
            let [bistatic, monostatic] = [[tx, rx], [tx, tx]].map(|ends| sigma0_db(&sea, ends, step));
            [bistatic[0] - monostatic[0], bistatic[1] - monostatic[1]]
        });
        for (channel, heading) in ["Azimuth, VV", "Azimuth, HH"].into_iter().enumerate() {
            let [bare, shadows, two_rays] = ratios.map(|ratio| ratio[channel]);
            computed.add(
                heading,
                &[bistatic_deg, tx_deg, rx_deg],
                &[bare, shadows, two_rays, measured_db[channel]],
            );
            assert!(bare > -4.0 && shadows < bare - 4.0 && two_rays < shadows - 1.0, "{bistatic_deg}");
        }
    }
    computed.stand_on_the_page();
}

#[test]
fn over_a_calm_sea_shadows_agree_and_two_rays_do_not() {
    let sea = [("radar.carrier_hz", "10e9"), ("sea.wind_mps", "3.3")];
    let tx = Place { azimuth_deg: 0.0, grazing_deg: 0.3 };
    let mut computed = Computed::default();
    for (grazing_deg, measured_db) in some_of(KOCHANSKI) {
        let rx = Place { azimuth_deg: 0.0, grazing_deg };
        let [bare, shadows, two_rays] = STEPS.map(|step| sigma0_db(&sea, [tx, rx], step)[0]);
        computed.add("Receiver at altitude", &[grazing_deg], &[bare, shadows, two_rays, measured_db]);
        assert!((shadows - measured_db).abs() < 6.0 && two_rays < measured_db - 6.0);
    }
    computed.stand_on_the_page();
}

#[test]
fn two_rays_keep_the_error() {
    let low = [
        ("sea.shadow.two_rays", "true"),
        ("scene.patch_size_m", sized("[64, 64]", "[48, 48]")),
        ("scene.facet_m", "2"),
        ("platform.aircraft.track.position_m", "[-3000.0, -55.5, 15.0]"),
        ("radar.window.start_us", "19.5"),
        ("transmitter.0.power_w", "1e9"),
        ("target.0.rcs_m2", "1e-9"),
        ("fidelity.echo", "fast"),
        ("fidelity.error_db", "-60.0"),
    ];
    let curved =
        [("scene.earth", "\"curved\""), ("sea.waves", "linear"), ("scene.patch_size_m", "[132, 132]")];
    for settings in some_of([&[][..], &curved]) {
        keeps_the_error(&format!("{settings:?}"), &scene("configs/sea.toml", &[&low[..], settings].concat()));
    }
}

#[test]
fn every_facet_has_the_field_of_two_rays() {
    let [tx, rx] = [0.2, 20.0].map(|grazing_deg| Place { azimuth_deg: 0.0, grazing_deg });
    let [from, to] = [tx, rx].map(|place| format!("{:?}", place.position_m()));
    // Linear waves and frozen tilts: heights are those that hide, and slopes within a facet are none.
    let snapshot = |shadow: &str| {
        let run = scene(
            SCENE,
            &[
                ("platform.far.track.position_m", &from[..]),
                ("platform.near.track.position_m", &to),
                ("scene.patch_size_m", "[256.0, 64.0]"),
                ("sea.waves", "linear"),
                ("sea.scattering.tilt_average", "false"),
                ("sea.shadow", shadow),
                ("fidelity.echo", "\"reference\""),
            ],
        );
        let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
        factory_by(&run.scene, tracks, &run.fidelity, &run.clocks)
            .unwrap()
            .snapshots(&[0])
            .unwrap()
            .pop()
            .unwrap()
    };
    let [off, on] = [STEPS[1], STEPS[2]].map(snapshot);
    let [nx, ny] = off.patch.facets;
    let (wavenumber_radpm, sine) = (2.0 * PI * 5.3e9 / SPEED_OF_LIGHT_MPS, 0.2f64.to_radians().sin());
    let mut compared = 0;
    for iy in 1..ny - 1 {
        for ix in 1..nx - 1 {
            let at = |dx: isize| off.height_m[iy * nx + (ix as isize + dx) as usize];
            let [without, with] = [&off, &on].map(|of| of.amplitude[0][iy * nx + ix].norm());
            let slope = (at(-1) - at(1)) / (2.0 * off.patch.facet_m);
            if without == 0.0 || slope < 3.0 * sine {
                continue;
            }
            // Steep towards the transmitter; towards the receiver, at 20 degrees, nothing is reflected.
            let share = (slope - sine) / (slope + sine);
            let phase = 2.0 * wavenumber_radpm * at(0) * sine;
            let rough = 2.0 * (wavenumber_radpm * sine).powi(2) * variance(&off.height_m);
            let share = share * (1.0 - rough + 0.75 * rough * rough);
            let expected = (1.0 - 2.0 * share * phase.cos() + share * share).sqrt();
            compared += 1;
            assert!((with / without - expected).abs() < 0.03, "{ix} {iy}: {} {expected}", with / without);
        }
    }
    assert!(compared > 100, "{compared} facets");
}

fn variance(of: &[f64]) -> f64 {
    let mean = of.iter().sum::<f64>() / of.len() as f64;
    of.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / of.len() as f64
}
