//! What breaking waves return, beside published figures.

use std::f64::consts::TAU;

use glam::DVec3;
use nereus::paths::PathGenerator;
use nereus::radar::link::Link;
use nereus::scattering::breaking::{breaker, sigma0};
use nereus::scattering::tilt::Path;
use nereus::scene::Scene;
use nereus::scene::radar::{Gate, Pattern, Polarisation, Window};
use nereus::scene::sea::Breaking;
use nereus::scene::water::WindStrength;
use nereus::sea::breaking::{CELL_M, Law, SLOT_S, coverage};
use nereus::time::PulseTimes;
use nereus::units::SPEED_OF_LIGHT_MPS;
use num_complex::Complex64;
use rand::{RngExt, SeedableRng};

use super::radar_scenes::{PULSE_S, channels, evaluate, scene, straight};
use super::sea_paths::sea;

/// Sea water in X band.
const WATER: Complex64 = Complex64::new(55.062, -37.514);

fn down(incidence_deg: f64, azimuth_deg: f64) -> DVec3 {
    let ((sin, cos), (sin_a, cos_a)) =
        (incidence_deg.to_radians().sin_cos(), azimuth_deg.to_radians().sin_cos());
    DVec3::new(sin * cos_a, sin * sin_a, -cos)
}

/// Cross sections of a breaker: HH, VV.
fn hh_vv(path: &Path, travel: DVec3) -> [f64; 2] {
    let [[vv, _], [_, hh]] = breaker(WATER, path, travel).sigma();
    [hh, vv]
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

#[test]
fn whitecaps_cover_what_was_counted() {
    // Monahan and O'Muircheartaigh 1980: 3.84e-6 U^3.41; 1 % at 10 m/s, a tenth of that at 5.
    assert!((coverage(10.0) - 9.87e-3).abs() < 1e-5);
    assert!((coverage(5.0) - 9.29e-4).abs() < 1e-6);
    assert_eq!((coverage(0.0), coverage(-1.0)), (0.0, 0.0));
    assert!(coverage(40.0) == coverage(20.0) && coverage(20.0) < 0.12);
}

#[test]
fn backscatter_is_that_of_the_paper() {
    // sec^4/s^2 exp(-tan^2/s^2) + eps/s^2 with the tilt of the front face crosswind, where it adds 0.05^2.
    for incidence_deg in [5.0f64, 25.0, 40.0, 45.0, 60.0, 85.0] {
        let ki = down(incidence_deg, 0.0);
        let (sec, tan) = (1.0 / incidence_deg.to_radians().cos(), incidence_deg.to_radians().tan());
        let published = sec.powi(4) / 0.19 * (-(tan * tan + 0.0025) / 0.19).exp() + 0.005 / 0.19;
        let [found, _] = hh_vv(&Path::new(ki, -ki), DVec3::Y);
        assert!((found / published - 1.0).abs() < 1e-9, "{incidence_deg}: {found} {published}");
    }
    // Its text has -8.8 dB at 45 degrees.
    let ki = down(45.0, 0.0);
    assert!((db(hh_vv(&Path::new(ki, -ki), DVec3::Y)[0]) + 8.8).abs() < 0.15);
}

#[test]
fn spikes_have_hh_above_vv_as_liu_frasier_and_mcintosh_found() {
    // At 3 degrees grazing "typically about 5 dB"; at nadir none; nowhere VV above HH.
    let ratio = |grazing_deg: f64| {
        let ki = down(90.0 - grazing_deg, 30.0);
        let [hh, vv] = hh_vv(&Path::new(ki, -ki), DVec3::X);
        db(hh / vv)
    };
    assert!((ratio(3.0) - 5.0).abs() < 0.5, "{}", ratio(3.0));
    assert!(ratio(90.0).abs() < 1e-9);
    for tenth in 1..900 {
        let found = ratio(f64::from(tenth) / 10.0);
        assert!((-1e-9..8.0).contains(&found), "{tenth}: {found}");
    }
}

#[test]
fn the_front_face_is_seen_from_where_it_runs_to() {
    let ki = down(40.0, 0.0);
    let of = |travel| hh_vv(&Path::new(ki, -ki), travel)[0];
    // Looking upwind, crosswind, downwind.
    let (up, across, downwind) = (of(-DVec3::X), of(DVec3::Y), of(DVec3::X));
    assert!(up > 1.3 * across && across > 1.3 * downwind, "{up} {across} {downwind}");
    // What is left near grazing has no side.
    let ki = down(87.0, 0.0);
    let of = |travel| hh_vv(&Path::new(ki, -ki), travel)[0];
    assert!((of(-DVec3::X) / of(DVec3::X) - 1.0).abs() < 1e-9);
}

#[test]
fn breakers_are_reciprocal_and_bounded() {
    for (there, back) in
        [((60.0, 0.0), (75.0, 170.0)), ((10.0, 20.0), (80.0, 100.0)), ((0.0, 0.0), (0.0, 0.0))]
    {
        let (ki, ks) = (down(there.0, there.1), -down(back.0, back.1 + 180.0));
        let travel = DVec3::new(0.6, 0.8, 0.0);
        let one = breaker(WATER, &Path::new(ki, ks), travel);
        let other = breaker(WATER, &Path::new(-ks, -ki), travel);
        let (there, back) = (one.sigma(), other.sigma());
        for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let (a, b) = (there[p][q], back[q][p]);
            assert!(a > 0.0 && a.is_finite() && (a / b - 1.0).abs() < 1e-9, "{one:?} {other:?}");
        }
        assert!(one.cross < one.like[1][1], "{one:?}");
    }
    // From below, level, straight through.
    for (ki, ks) in [(-down(30.0, 0.0), down(30.0, 0.0)), (DVec3::X, -DVec3::X), (DVec3::X, DVec3::X)] {
        assert_eq!(breaker(WATER, &Path::new(ki, ks), DVec3::X), Default::default());
    }
    let level = DVec3::new(1.0, 0.0, -1e-9).normalize();
    let path = Path::new(level, -level);
    let ([hh, vv], found) = (hh_vv(&path, DVec3::X), breaker(WATER, &path, DVec3::X));
    assert!(hh.is_finite() && found.cross >= 0.0 && vv <= hh);
}

/// The field that a perfect mirror returns is `2 (m.e) m - e`, m its normal, halfway between the ways there
/// and back. It keeps its power, and its parts along v and h are those of the breaker.
#[test]
fn out_of_the_plane_polarisation_is_turned_as_by_the_facet_that_mirrors() {
    let mut cross = 0.0f64;
    for there in [0.0, 20.0, 45.0, 80.0] {
        for back in [10.0, 45.0, 75.0] {
            for azimuth in [0.0, 30.0, 90.0, 135.0, 180.0] {
                let (ki, ks) = (down(there, 20.0), -down(back, 200.0 + azimuth));
                let path = Path::new(ki, ks);
                if (ks - ki).length() < 0.1 {
                    continue;
                }
                let normal = (ks - ki).normalize();
                let found = breaker(WATER, &path, DVec3::X);
                for (q, field) in [path.incident.v, path.incident.h].into_iter().enumerate() {
                    let mirrored = 2.0 * normal.dot(field) * normal - field;
                    let parts = [path.scattered.v, path.scattered.h].map(|p| mirrored.dot(p).powi(2));
                    assert!((parts[0] + parts[1] - 1.0).abs() < 1e-12 && mirrored.dot(ks).abs() < 1e-12);
                    for (p, part) in parts.into_iter().enumerate() {
                        let error = found.turn[p][q].powi(2) - part;
                        assert!(error.abs() < 1e-12, "{there} {back} {azimuth}: {error:e}");
                        let like = found.sigma()[p][q] - if p == q { 0.0 } else { found.cross };
                        assert!((like - found.like[p][q] * part).abs() < 1e-9 * found.like[1][1]);
                    }
                    cross = cross.max(parts[1 - q]);
                }
            }
        }
    }
    assert!(cross > 0.99, "{cross}");
    // 45 degrees there and back, 90 degrees between: 1/9 stays. In C band at 8 m/s that is -32.5 dB in HH,
    // and in HV -23.5 but for what V loses on its one way and the 0.1 dB that Bragg waves on breakers add.
    let path = Path::new(down(45.0, 0.0), -down(45.0, 270.0));
    let water = Complex64::new(67.0, -36.0);
    let found = breaker(water, &path, DVec3::X);
    assert!((found.turn[1][1].powi(2) - 1.0 / 9.0).abs() < 1e-12 && path.ks.y.abs() > 0.7);
    let sea = sigma0(water, &path, 0.5 * TAU, 8.0);
    let [hh, hv, way] = [sea[1][1], sea[1][0], found.like[1][0] / found.like[1][1]].map(db);
    assert!((hh + 32.5).abs() < 0.1 && (hv - way + 23.4).abs() < 0.05, "{hh} {hv} {way}");
    assert!((-0.6..-0.4).contains(&way), "{way}");
}

#[test]
fn straight_back_no_polarisation_is_turned() {
    for incidence_deg in [0.0, 7.0, 33.0, 60.0, 88.0] {
        let ki = down(incidence_deg, 77.0);
        let found = breaker(WATER, &Path::new(ki, -ki), DVec3::X);
        let [[vv, vh], [hv, hh]] = found.sigma();
        assert_eq!([vv, hh], [found.like[0][0], found.like[1][1]]);
        assert_eq!([vh, hv], [found.cross; 2]);
        // So near that it may be: a satellite's own motion.
        let ks = (-ki + DVec3::new(1e-5, 3e-5, 2e-5)).normalize();
        if ks.z > 0.0 {
            let near = breaker(WATER, &Path::new(ki, ks), DVec3::X);
            assert!((near.turn[1][1] + 1.0).abs() < 1e-6 || incidence_deg == 0.0, "{near:?}");
        }
    }
}

#[test]
fn what_breaks_covers_what_it_should() {
    // Area times life of all births of an area and time: the coverage, whatever the spread over speeds.
    for u10_mps in [3.0, 10.0, 25.0] {
        let law = Law::new(u10_mps, 0.3, 5).unwrap();
        let (mut covered, mut births, mut lives) = (0.0, 0.0, 0.0);
        // Scatterers of a wave come together: their counts vary as the sum of squares of those of waves.
        let mut squares = 0.0;
        let (cells, slots) = (if u10_mps < 5.0 { 60 } else { 12 }, 16);
        for cell in 0..cells * cells {
            for slot in 0..slots {
                law.candidates([cell % cells, cell / cells - 3], slot, |wave| {
                    // In still water the lot decides; in waves their acceleration.
                    if !wave.breaks(None) {
                        return;
                    }
                    let mut count = 0.0;
                    law.scatterers(wave, |own| {
                        assert!((0.1..=1.0).contains(&own.life_s), "{own:?}");
                        assert!((0.65..=6.0).contains(&own.speed_mps), "{own:?}");
                        assert!(own.area_m2 > 0.0 && own.area_m2 <= 1.0, "{own:?}");
                        // An eighth of a wave before and after, a whole one to either side.
                        let [east, north] = [0, 1].map(|i| own.place_m[i] - wave.place_m[i]);
                        let [cos, sin] = own.travel;
                        let length_m = TAU * own.speed_mps * own.speed_mps / 9.81;
                        let (along, across) = (east * cos + north * sin, north * cos - east * sin);
                        assert!(along.abs() < 0.126 * length_m && across.abs() < 1.01 * length_m, "{own:?}");
                        covered += own.area_m2 * own.life_s;
                        (count, lives) = (count + 1.0, lives + own.life_s);
                    });
                    births += count;
                    squares += count * count;
                });
            }
        }
        let deviation = f64::sqrt(squares) / births;
        println!("{u10_mps} m/s: births {births}, deviation {deviation:.4}, covered {covered:.1}");
        let all = (cells * cells) as f64 * CELL_M * CELL_M * slots as f64 * SLOT_S;
        // Areas grow as c^4, so that a few large ones carry much: 4 deviations of some 8 % of one thousand.
        assert!(
            (covered / all / law.coverage() - 1.0).abs() < 0.2,
            "{u10_mps}: {}",
            covered / all / law.coverage()
        );
        assert!((births / all / law.births_per_m2_s() - 1.0).abs() < 4.0 * deviation, "{u10_mps}: {births}");
        assert!((lives / all / law.alive_per_m2() - 1.0).abs() < 5.0 * deviation, "{u10_mps}: {lives}");
    }
    assert!(Law::new(0.0, 0.0, 1).is_none());
}

#[test]
fn envelopes_have_the_power_of_their_life_and_breakers_run() {
    let law = Law::new(10.0, 0.0, 5).unwrap();
    let scatterers = |cell| {
        let mut found = Vec::new();
        law.candidates(cell, 3, |wave| law.scatterers(wave, |own| found.push(own)));
        found
    };
    let found = scatterers([0, 0]);
    let own = found[0];
    let at = |share: f64| own.born_s + share * own.life_s;
    let steps = 1000;
    let power =
        (0..steps).map(|n| own.envelope(at((f64::from(n) + 0.5) / f64::from(steps))).powi(2)).sum::<f64>();
    assert!((power / f64::from(steps) - 1.0).abs() < 1e-9);
    assert_eq!((own.envelope(at(-0.01)), own.envelope(at(1.01))), (0.0, 0.0));
    let [a, b] = [own.at_m(1.0), own.at_m(3.0)];
    assert!(((b[0] - a[0]).hypot(b[1] - a[1]) / 2.0 - own.speed_mps).abs() < 1e-9);
    // The same cell and slot again, and another.
    assert_eq!(found, scatterers([0, 0]));
    assert!(scatterers([0, 1]).iter().all(|own| !found.contains(own)));
}

#[test]
fn a_sixth_of_a_gaussian_sea_breaks_whatever_its_facets() {
    // The share above one deviation is Q(1) = 0.1587, and of the height under them: in a sea of one frequency
    // height and downward acceleration are one, and the mean above one deviation is phi(1)/Q(1) = 1.525.
    let own = {
        let mut first = None;
        Law::new(10.0, 0.0, 5).unwrap().candidates([0, 0], 0, |own| first = first.or(Some(*own)));
        first.unwrap()
    };
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let draws: Vec<f64> = (0..200_000).map(|_| rng.sample(rand_distr::StandardNormal)).collect();
    let kept: Vec<f64> = draws.iter().copied().filter(|own_sigma| own.breaks(Some(*own_sigma))).collect();
    let (share, mean) = (kept.len() as f64 / 2e5, kept.iter().sum::<f64>() / kept.len() as f64);
    assert!((share - 0.158_66).abs() < 4.0 * (0.1587f64 * 0.8413 / 2e5).sqrt(), "{share}");
    assert!((mean - 1.5251).abs() < 0.01, "{mean}");
}

#[test]
fn the_echo_has_the_mean_of_the_law_and_the_doppler_of_breakers_for_facets_of_any_size() {
    // A radar in the east, where the waves of 15 m/s run to, at 3 degrees grazing.
    let at = [10e3, 0.0, 524.0];
    for (n, facet_m) in [(48, 0.5), (24, 2.0)] {
        let mut water = sea(n, facet_m, 0.0);
        water.water.wind.strength = WindStrength::Speed { speed_mps: 15.0, height_m: 10.0 };
        let area_m2 = (n * n) as f64 * facet_m * facet_m;
        let mut scene = Scene { sea: Some(water), targets: Vec::new(), pulses: 400, ..scene() };
        scene.radar.emissions = PulseTimes::uniform(1.0).unwrap();
        scene.radar.window = Window { samples: 512, gate: Gate::Fixed { start_s: 66e-6 } };
        scene.radar.channels =
            channels(&[(Polarisation::H, Polarisation::H), (Polarisation::V, Polarisation::V)]);
        for mount in [&mut scene.radar.transmitters[0].antenna, &mut scene.radar.receivers[0].antenna] {
            mount.pattern = Pattern::Isotropic { gain_dbi: 0.0 };
        }
        let tracks = vec![straight(&scene, at, [0.0; 3]); 2];
        let quiet = PathGenerator::new(&scene, PULSE_S, tracks.clone()).unwrap();
        scene.sea.as_mut().unwrap().scattering.breaking = Breaking::Whitecaps;
        let breaking = PathGenerator::new(&scene, PULSE_S, tracks).unwrap();
        let (mut hh, mut vv, mut closing_mps, mut count) = (0.0, 0.0, 0.0, 0.0);
        for index in 0..scene.pulses {
            let (without, with) = (evaluate(&scene, &quiet, index).0, evaluate(&scene, &breaking, index).0);
            // Facets are those of the quiet sea, breakers come after them.
            assert_eq!(without.amplitude[0], with.amplitude[0][..without.len()]);
            for path in without.len()..with.len() {
                let [h, v] = [0, 1].map(|channel: usize| with.amplitude[channel][path].norm());
                assert!(h >= v && v > 0.0, "{h} {v}");
                (hh, vv, count) = (hh + h * h, vv + v * v, count + 1.0);
                closing_mps -= 0.5 * with.delay_rate[0][path] * SPEED_OF_LIGHT_MPS;
            }
        }
        let radar = &scene.radar;
        let link = Link::new(
            radar.transmitters[0].power_w,
            radar.wavelength_m(),
            radar.losses_db,
            radar.atmosphere_db_per_km,
        );
        let range_m = at[0].hypot(at[2]);
        let of_one_m2 =
            link.scattered(range_m, range_m).powi(2) * coverage(15.0) * area_m2 * scene.pulses as f64;
        let ki = down(87.0, 180.0);
        let expected = hh_vv(&Path::new(ki, -ki), DVec3::X);
        let ratios = [hh / of_one_m2 / expected[0], vv / of_one_m2 / expected[1]];
        let alive = Law::new(15.0, 0.0, 1).unwrap().alive_per_m2() * area_m2 * scene.pulses as f64;
        // Mean speed of those alive: waves of c^-8 from 2 to 6 m/s, parts of a square metre of each.
        let [speeds, parts] = [1, 0].map(|power| {
            let of = |n: u32| {
                let speed_mps = 2.0 + 4.0 * (f64::from(n) + 0.5) / 4000.0;
                let area_m2 = (TAU * speed_mps * speed_mps / 9.81).powi(2) / 8.0;
                speed_mps.powi(power - 8) / (1.0 - (-1.0 / area_m2).exp())
            };
            (0..4000).map(of).sum::<f64>()
        });
        let speed_mps = speeds / parts;
        let expected_mps = speed_mps * (-0.5 * 30f64.to_radians().powi(2)).exp() * at[0] / range_m;
        println!(
            "{facet_m} m: {ratios:?}, {count} of {alive:.0} alive, {} of {expected_mps:.3} m/s",
            closing_mps / count
        );
        // How much of so small a sea is steep.
        assert!((count / alive - 1.0).abs() < 0.15, "{count} {alive}");
        // Over their number what is left of the scatter of waves is that of the envelope, of variance 0.944,
        // over areas of <A^2>/<A>^2 = 5.54: 2 for areas of one speed, 2.77 for speeds (c^4 under c^-8). Four
        // deviations of the mean of as many waves, of which one has 2.41 parts in the mean.
        let allowed = 4.0 * f64::sqrt(0.944 * 5.54 / (count / 2.41));
        let each = ratios.map(|ratio| ratio * alive / count);
        assert!(each.iter().all(|ratio| (ratio - 1.0).abs() < allowed), "{each:?}, allowed {allowed}");
        assert!((closing_mps / count / expected_mps - 1.0).abs() < 0.05, "{}", closing_mps / count);
    }
}
