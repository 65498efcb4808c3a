//! Spectra against golden values, published moments, and their own definitions.

use std::f64::consts::{FRAC_PI_2, TAU};

use nereus::scene::water::{Development, Dispersion, Spreading, Swell, SwellShape, WindProfile};
use nereus::sea::spectrum::measured::{Measured, MeasuredError};
use nereus::sea::spectrum::moments::Moments;
use nereus::sea::spectrum::sampling::{self, FacetDensity};
use nereus::sea::spectrum::{
    Combined, Elfouhaily, FungLee, Jonswap, Mix, PiersonMoskowitz, Spectrum, SwellTrain, WaveVector,
};
use nereus::sea::wind::Wind;

use crate::sea_golden::{Judge, rows};

fn wind(speed_mps: f64, height_m: f64) -> Wind {
    Wind::from_speed(speed_mps, height_m, WindProfile::Cardone, 0.0).unwrap()
}

fn age(omega_c: f64) -> Development {
    Development::InverseWaveAge(omega_c)
}

#[test]
fn every_row_of_spectrum_elfouhaily() {
    let mut judge = Judge::new("spectrum_elfouhaily.csv", 1e-9);
    for row in rows("spectrum_elfouhaily.csv") {
        let wind = wind(row.get("U10_m_s"), 10.0);
        let sea = Elfouhaily::new(&wind, age(row.get("Omega_c"))).unwrap();
        let k = row.get("K_rad_m");
        judge.compare(&row, "ustar_m_s", wind.ustar_wu_mps);
        let [long, short] = sea.curvature(k);
        judge.compare(&row, "Bl", long);
        judge.compare(&row, "Bh", short);
        judge.compare(&row, "S_m3", sea.omnidirectional_m3(k));
        judge.compare(&row, "Delta", sea.delta(k));
        let down = row.get("Psi_down_m4");
        judge.compare(&row, "Psi_down_m4", sea.symmetric_m4(WaveVector::new(k, 0.0)));
        // Crosswind is proportional to 1 - Delta, where Delta is 1 but for a rounding of 1e-16: where it
        // cancels, the golden value itself is only known to 4 roundings of the downwind value.
        let cross = row.get("Psi_cross_m4");
        let scale = cross.abs() + 4.0 * f64::EPSILON * down / 1e-9;
        judge.compare_at(&row, "Psi_cross_m4", sea.symmetric_m4(WaveVector::new(0.0, k)), scale);
    }
    judge.verdict();
}

#[test]
fn every_row_of_spectrum_fung_lee_pm() {
    let mut judge = Judge::new("spectrum_fung_lee_pm.csv", 1e-9);
    for row in rows("spectrum_fung_lee_pm.csv") {
        let wind = wind(row.get("U19p5_m_s"), 19.5);
        let sea = FungLee::new(&wind);
        let k = row.get("K_rad_m");
        judge.compare(&row, "ustar_m_s", wind.ustar_cardone_mps);
        judge.compare(&row, "p", sea.capillary().p);
        judge.compare(&row, "a0_m3", sea.capillary().a0_m3);
        judge.compare(&row, "S_grav_m3", sea.gravity_m3(k));
        judge.compare(&row, "S_cap_m3", sea.capillary().omnidirectional_m3(k));
        let developed = PiersonMoskowitz::new(&wind, Spreading::default()).unwrap();
        judge.compare(&row, "S_pm_m3", developed.omnidirectional_m3(k));
        let branch = if k < 4.0 { "S_grav_m3" } else { "S_cap_m3" };
        judge.compare(&row, branch, sea.omnidirectional_m3(k));
    }
    judge.verdict();
}

#[test]
fn every_row_of_spreading_fung_lee() {
    let mut judge = Judge::new("spreading_fung_lee.csv", 1e-4);
    for row in rows("spreading_fung_lee.csv") {
        let wind = wind(row.get("U12p5_m_s"), 12.5);
        let sea = FungLee::new(&wind);
        let directional = sea.directional();
        judge.compare(&row, "ustar", wind.ustar_cardone_mps);
        judge.compare(&row, "mss", directional.mean_square_slope);
        judge.compare(&row, "D", directional.d);
        judge.compare(&row, "R", directional.r);
        judge.compare(&row, "a1", directional.a1);
        let k = WaveVector::polar(row.get("K_rad_m"), row.get("phi_deg").to_radians());
        judge.compare(&row, "Phi", sea.symmetric_spreading_per_rad(k));
        let mix = Mix::new(&wind, Development::default()).unwrap();
        judge.compare(&row, "Phi", mix.symmetric_spreading_per_rad(k));
    }
    judge.verdict();
}

#[test]
fn every_row_of_spectrum_jonswap() {
    let mut judge = Judge::new("spectrum_jonswap.csv", 1e-9);
    for row in rows("spectrum_jonswap.csv") {
        let sea =
            Jonswap::new(&wind(row.get("U10_m_s"), 10.0), row.get("fetch_m"), Spreading::default()).unwrap();
        judge.compare(&row, "S_m3", sea.omnidirectional_m3(row.get("K_rad_m")));
        // Not at the printed frequency: 13 digits of it are too few on the steep side.
        let omega_rad_s = (9.81 * row.get("K_rad_m")).sqrt();
        judge.compare(&row, "omega_rad_s", omega_rad_s);
        judge.compare(&row, "S_omega_m2s", sea.frequency_m2s(omega_rad_s));
    }
    judge.verdict();
}

#[test]
fn every_row_of_spectrum_moments() {
    let mut judge = Judge::new("spectrum_moments.csv", 1e-6);
    for row in rows("spectrum_moments.csv") {
        let sea = Elfouhaily::new(&wind(row.get("U10_m_s"), 10.0), age(row.get("Omega_c"))).unwrap();
        let moments = Moments::of(&sea, [row.get("K_lo"), row.get("K_hi")]);
        judge.compare(&row, "Hs_m", moments.significant_height_m());
        judge.compare(&row, "mss_total", moments.mean_square_slope);
        judge.compare(&row, "mss_up", moments.slope_variance(0.0));
        judge.compare(&row, "mss_cross", moments.slope_variance(FRAC_PI_2));
    }
    judge.verdict();
}

#[test]
fn every_row_of_kpeak_lmin() {
    let mut judge = Judge::new("kpeak_lmin.csv", 1e-9);
    for row in rows("kpeak_lmin.csv") {
        let wind = wind(row.get("U19p5_m_s"), 19.5);
        let sea = PiersonMoskowitz::new(&wind, Spreading::default()).unwrap();
        judge.compare(&row, "Kpeak", sea.peak_rad_m());
        let [low, high] = sea.half_power_band_rad_m();
        judge.compare(&row, "K3dB_1", low);
        judge.compare(&row, "K3dB_2", high);
        judge.compare(&row, "Lmin_m", sampling::least_length_m(&sea, row.get("alpha")));
        // Fung and Lee's gravity branch has the same shape, where it holds the whole band.
        if high < 4.0 {
            let sea = FungLee::new(&wind);
            judge.compare(&row, "Kpeak", sea.peak_rad_m());
            judge.compare(&row, "Lmin_m", sampling::least_length_m(&sea, row.get("alpha")));
        }
    }
    judge.verdict();
}

#[test]
fn every_row_of_rayleigh_density() {
    let mut judge = Judge::new("rayleigh_density.csv", 1e-8);
    for row in rows("rayleigh_density.csv") {
        let wind = wind(row.get("U19p5_m_s"), 19.5);
        judge.compare(&row, "ustar", wind.ustar_cardone_mps);
        let incidence_rad = row.get("theta_deg").to_radians();
        let density = FacetDensity::rayleigh(wind.ustar_cardone_mps, row.get("f_hz"), incidence_rad);
        judge.compare(&row, "h_rayleigh_m", density.rayleigh_height_m);
        judge.compare(&row, "h_c_m", density.joint_height_m);
        judge.compare(&row, "K_rayleigh", density.wave_number_rad_m);
        judge.compare(&row, "facets_per_m", density.facets_per_m);
    }
    judge.verdict();
}

/// docs/physics.md section 6.9: heights and slopes of Elfouhaily's sea, to the digits printed, and within its
/// acceptance bands of 0.0246 U10^2 and of Cox and Munk.
#[test]
fn heights_and_slopes_of_the_table() {
    // U10, Hs and the unit of its last digit, slopes and the unit of theirs, Cox and Munk.
    let table: [(f64, [f64; 2], [f64; 4], f64); 4] = [
        (5.0, [0.644, 1e-3], [0.0316, 0.0189, 0.0127, 1e-4], 0.0291),
        (10.0, [2.603, 1e-3], [0.0603, 0.0355, 0.0248, 1e-4], 0.0552),
        (15.0, [5.87, 1e-2], [0.0843, 0.0503, 0.0341, 1e-4], 0.0813),
        (25.0, [16.25, 1e-2], [0.116, 0.072, 0.044, 1e-3], 0.134),
    ];
    for (u10_mps, [height_m, height_digit], [total, up, cross, digit], cox_munk) in table {
        let sea = Elfouhaily::new(&wind(u10_mps, 10.0), age(0.84)).unwrap();
        let moments = Moments::of(&sea, [1e-4, 2e4]);
        let found = [
            moments.significant_height_m(),
            moments.mean_square_slope,
            moments.slope_variance(0.0),
            moments.slope_variance(FRAC_PI_2),
        ];
        println!("U10 {u10_mps}: {found:?}");
        let printed = [height_m, total, up, cross].into_iter().zip([height_digit, digit, digit, digit]);
        for (found, (printed, digit)) in found.into_iter().zip(printed) {
            assert!((found - printed).abs() <= 0.5 * digit, "{found} against {printed}");
        }
        if (5.0..=20.0).contains(&u10_mps) {
            assert!((found[0] / (0.0246 * u10_mps * u10_mps) - 1.0).abs() < 0.08);
            assert!((found[1] / cox_munk - 1.0).abs() < 0.15);
        }
    }
}

/// docs/physics.md section 8.1: the least length of a patch depends on the spectrum.
#[test]
fn least_length_of_the_actual_spectrum() {
    let wind = wind(10.0, 19.5);
    let length = |sea: &dyn Spectrum| sampling::least_length_m(sea, 0.25);
    let jonswap = |fetch_m| length(&Jonswap::new(&wind, fetch_m, Spreading::default()).unwrap());
    let found = [
        (length(&FungLee::new(&wind)), 328.0),
        (length(&Elfouhaily::new(&wind, age(0.84)).unwrap()), 290.0),
        (length(&Elfouhaily::new(&wind, age(1.5)).unwrap()), 146.0),
        (jonswap(100e3), 618.0),
        (jonswap(500e3), 1806.0),
    ];
    println!("least lengths: {found:?}");
    for (found, printed) in found {
        // Printed to a metre; U10 was rounded to 9.4 m/s there, or to 10: 1 percent of the wind is 2
        // percent of the length at most.
        assert!((found / printed - 1.0_f64).abs() < 0.02, "{found} against {printed}");
    }
}

#[test]
fn printed_facet_densities() {
    // docs/physics.md section 8.2: facets per metre at 10, 5 and 1 GHz, normal incidence, for 5, 10 and 15
    // m/s at 19.5 m.
    let printed = [(10e9, [26.4, 42.7, 62.7]), (5e9, [10.0, 14.8, 20.6]), (1e9, [1.01, 1.08, 1.17])];
    for (carrier_hz, row) in printed {
        for (speed_mps, printed) in [5.0, 10.0, 15.0].into_iter().zip(row) {
            let ustar_mps = wind(speed_mps, 19.5).ustar_cardone_mps;
            let found = FacetDensity::rayleigh(ustar_mps, carrier_hz, 0.0).facets_per_m;
            let digit = if printed < 2.0 { 0.01 } else { 0.1 };
            assert!((found - printed).abs() <= 0.51 * digit, "{found} against {printed}");
        }
    }
}

/// Every spectrum of a wind, with a swell and a sum.
pub fn every_spectrum(wind: &Wind) -> Vec<(&'static str, Box<dyn Spectrum>)> {
    let gaussian = SwellShape::Gaussian { relative_width: 0.06 };
    let peaked = SwellShape::Jonswap { peak_enhancement: 10.0 };
    let swell = |shape, depth_m| -> Box<dyn Spectrum> {
        let swell = Swell {
            significant_height_m: 1.5,
            peak_period_s: 9.0,
            direction_rad: 2.0,
            spread_rad: 0.3,
            shape,
        };
        Box::new(SwellTrain::new(&swell, Dispersion { capillary: false, depth_m }).unwrap())
    };
    let jonswap = |spreading| -> Box<dyn Spectrum> { Box::new(Jonswap::new(wind, 1e5, spreading).unwrap()) };
    vec![
        ("elfouhaily", Box::new(Elfouhaily::new(wind, age(0.84)).unwrap())),
        ("elfouhaily young", Box::new(Elfouhaily::new(wind, age(2.0)).unwrap())),
        ("fung_lee", Box::new(FungLee::new(wind))),
        ("mix", Box::new(Mix::new(wind, age(0.84)).unwrap())),
        ("pierson_moskowitz", Box::new(PiersonMoskowitz::new(wind, Spreading::Mitsuyasu).unwrap())),
        ("jonswap", jonswap(Spreading::Mitsuyasu)),
        ("jonswap, constant", jonswap(Spreading::Constant(4.5))),
        ("jonswap, like elfouhaily", jonswap(Spreading::LikeElfouhaily)),
        ("swell", swell(gaussian, None)),
        ("swell, peaked, shallow", swell(peaked, Some(8.0))),
        (
            "combined",
            Box::new(Combined::new(vec![
                Box::new(Elfouhaily::new(wind, age(0.84)).unwrap()),
                swell(gaussian, None),
            ])),
        ),
    ]
}

/// A spectrum with only what must be given, so that the defaults of the trait are used.
#[derive(Debug)]
struct Bare(Box<dyn Spectrum>);

impl Spectrum for Bare {
    fn omnidirectional_m3(&self, k: f64) -> f64 {
        self.0.omnidirectional_m3(k)
    }
    fn spreading_per_rad(&self, k: WaveVector) -> f64 {
        self.0.spreading_per_rad(k)
    }
    fn peak_rad_m(&self) -> f64 {
        self.0.peak_rad_m()
    }
}

#[test]
fn spreading_is_a_density_on_the_circle() {
    let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.7).unwrap();
    for (name, sea) in every_spectrum(&wind) {
        let bare = Bare(every_spectrum(&wind).into_iter().find(|(n, _)| *n == name).unwrap().1);
        let mut worst = [0.0f64; 3];
        for k in [0.05, 0.1, 0.3, 1.0, 4.0, 30.0, 370.0, 1000.0] {
            let points = 3600;
            let step = TAU / points as f64;
            let (mut wave, mut symmetric) = (0.0, 0.0);
            for i in 0..points {
                let at = WaveVector::polar(k, (i as f64 + 0.5) * step);
                wave += step * sea.spreading_per_rad(at);
                symmetric += step * sea.symmetric_spreading_per_rad(at);
                let mean = 0.5 * (sea.spreading_per_rad(at) + sea.spreading_per_rad(-at));
                worst[1] = worst[1].max((mean - sea.symmetric_spreading_per_rad(at)).abs());
            }
            worst[0] = worst[0].max((wave - 1.0).abs()).max((symmetric - 1.0).abs());
            let [a, b] = [sea.second_harmonic(k), bare.second_harmonic(k)];
            worst[2] = worst[2].max((a[0] - b[0]).abs()).max((a[1] - b[1]).abs());
        }
        println!("{name}: norm {:.1e}, symmetry {:.1e}, harmonic {:.1e}", worst[0], worst[1], worst[2]);
        // A cosine power that falls below s = 1 has a cusp upwind, at worst (s -> 0) a hole in a uniform
        // density: a step of 1/(2 pi), 1/3600 in the norm and 1/128 in the harmonic. The border of a half
        // circle falls between points: half a step on both sides, of a density below 1/pi, twice that.
        // The other forms are smooth: rounding.
        let (norm, harmonic) = match name {
            "pierson_moskowitz" | "jonswap" | "jonswap, like elfouhaily" => (1.0 / 3600.0, 1.0 / 128.0),
            "jonswap, constant" | "swell" | "swell, peaked, shallow" => (1e-10, 1e-6),
            _ => (2.0 / 3600.0, 2.0 / 128.0),
        };
        assert!(worst[0] < norm && worst[1] < 1e-12 && worst[2] < harmonic, "{name}");
    }
}

#[test]
fn a_turned_wind_turns_the_spectrum() {
    let turn: f64 = 1.1;
    for ((name, still), (_, turned)) in every_spectrum(&wind(9.0, 10.0))
        .into_iter()
        .zip(every_spectrum(&Wind::from_speed(9.0, 10.0, WindProfile::Cardone, turn).unwrap()))
    {
        if name.contains("swell") || name == "combined" {
            continue; // Their direction is not the wind's.
        }
        for azimuth in [0.1f64, 0.9, 1.4, 2.5, 4.0] {
            let a = still.wave_m4(WaveVector::polar(0.2, azimuth));
            let b = turned.wave_m4(WaveVector::polar(0.2, azimuth + turn));
            assert!((a - b).abs() <= 1e-12 * a.max(b), "{name} {azimuth}: {a} {b}");
        }
    }
}

/// The slope ratio for which Fung and Lee's directional function was made (docs/physics.md section 6.3):
/// crosswind over upwind is R. The band is that of the integral, its rule another one: 1e-4.
#[test]
fn fung_lee_has_the_slope_ratio_of_cox_and_munk() {
    let sea = FungLee::new(&wind(10.0, 12.5));
    let moments = Moments::of(&sea, [1e-3, 2e4]);
    let ratio = moments.slope_variance(FRAC_PI_2) / moments.slope_variance(0.0);
    println!("cross/up {ratio:.5}, R {:.5}", sea.directional().r);
    assert!((ratio / sea.directional().r - 1.0).abs() < 1e-4);
    assert!((sea.directional().d - 0.1734).abs() < 5e-5 && (sea.directional().a1 - 0.0673).abs() < 5e-5);
}

#[test]
fn the_mix_has_the_crosswind_ratio_of_its_spreading() {
    // docs/physics.md section 6.3: up over cross 3.8 dB at X band (K_B = 2 k sin 45 deg) with D from Fung and
    // Lee.
    let wind = Wind::from_friction_velocity(0.36, WindProfile::Cardone, 0.0).unwrap();
    let mix = Mix::new(&wind, age(0.84)).unwrap();
    let k = 2.0 * TAU * 10e9 / 299_792_458.0 * 0.5f64.sqrt();
    let ratio = mix.symmetric_m4(WaveVector::new(k, 0.0)) / mix.symmetric_m4(WaveVector::new(0.0, k));
    let ratio_db = 10.0 * ratio.log10();
    println!("mix, up/cross: {ratio_db:.2} dB");
    // One unit of the printed digit: the wind of the printed figure is not given.
    assert!((ratio_db - 3.8).abs() < 0.1);
}

#[test]
fn parameters_out_of_range_are_refused_in_words() {
    let wind = wind(10.0, 10.0);
    let words = [
        Elfouhaily::new(&wind, age(0.5)).unwrap_err().to_string(),
        Elfouhaily::new(&wind, Development::Fetch(1.0)).unwrap_err().to_string(),
        Elfouhaily::new(&wind, Development::Fetch(150.0)).unwrap_err().to_string(),
        Jonswap::new(&wind, f64::NAN, Spreading::default()).unwrap_err().to_string(),
        PiersonMoskowitz::new(&wind, Spreading::Constant(-1.0)).unwrap_err().to_string(),
    ];
    assert_eq!(
        words,
        [
            "inverse wave age of 0.5: allowed are 0.84 (fully developed) to 5",
            "fetch of 1 m: allowed are 100 to 10000000 m",
            "fetch of 150 m at 10 m/s means an inverse wave age of 7.53: at most 5 is allowed",
            "fetch of NaN m: allowed are 100 to 10000000 m",
            "spreading exponent of -1: allowed are 0 to 1000",
        ]
    );
}

/// A spectrum written to a file and read back is the same sea.
#[test]
fn a_measured_spectrum_comes_back() {
    let sea = PiersonMoskowitz::new(&wind(9.0, 19.5), Spreading::Constant(3.0)).unwrap();
    let (nodes, step) = (161i32, 0.005);
    let mut text = String::from("# made for the test\nkx_rad_m,ky_rad_m,psi_m4\n");
    for i in 0..nodes {
        for j in 0..nodes {
            let k = WaveVector::new(f64::from(i - nodes / 2) * step, f64::from(j - nodes / 2) * step);
            text += &format!("{:.4},{:.4},{:e}\n", k.x_rad_m, k.y_rad_m, sea.wave_m4(k));
        }
    }
    let measured = Measured::parse(text.as_bytes()).unwrap();
    let node = WaveVector::new(0.085, -0.035);
    assert!((measured.wave_m4(node) / sea.wave_m4(node) - 1.0).abs() < 1e-9);
    let band = [0.03, 0.39];
    let (a, b) = (Moments::of(&measured, band), Moments::of(&sea, band));
    println!("measured {a:?}\ndirect {b:?}");
    // Bilinear error is step^2/12 of the Laplacian: (step/K)^2 20/12 of the value beyond the peak,
    // 0.7 percent at K = 0.078, up to 2 percent on the steep side of the peak.
    assert!((a.significant_height_m() / b.significant_height_m() - 1.0).abs() < 0.01);
    assert!((a.slope_variance(0.0) / b.slope_variance(0.0) - 1.0).abs() < 0.02);
    assert!((a.slope_variance(FRAC_PI_2) / b.slope_variance(FRAC_PI_2) - 1.0).abs() < 0.02);
    let nearest = (measured.peak_rad_m() - sea.peak_rad_m()).abs();
    assert!(nearest <= step, "{nearest}");
}

#[test]
fn faults_of_a_measured_spectrum_are_all_named() {
    let head = "kx_rad_m,ky_rad_m,psi_m4\n";
    let words = |text: &str| Measured::parse(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        words(&format!("{head}0,0,1\n0,1,-2\nx,0,1\n1,1\n1,1,inf\n0,0,3\n")),
        "measured spectrum: line 3: psi_m4 is -2: it must not be negative; line 4: kx_rad_m is not a finite \
         number; line 5: 2 fields where 3 are needed; line 6: psi_m4 is not a finite number; line 7: the \
         node (0, 0) is already on line 2; line 7: kx_rad_m has 1 values: a grid needs 2 or more"
    );
    assert_eq!(words("a,b\n"), "measured spectrum: line 1: the header must be `kx_rad_m,ky_rad_m,psi_m4`");
    assert_eq!(words(""), "measured spectrum: line 1: the header must be `kx_rad_m,ky_rad_m,psi_m4`");
    assert_eq!(
        words(&format!("{head}0,0,1\n0,1,1\n1,0,1\n")),
        "measured spectrum: line 4: the node (1, 1) is missing"
    );
    assert_eq!(
        words(&format!("{head}0,0,1\n0,1,1\n0,2,1\n0,4,1\n1,0,1\n1,1,1\n1,2,1\n1,4,1\n")),
        "measured spectrum: line 5: ky_rad_m = 4 is not on the even steps of 1 that the grid has elsewhere"
    );
    assert_eq!(
        words(&format!("{head}0,0,1e13\n0,2e8,0\n1,0,0\n")),
        "measured spectrum: line 2: psi_m4 is 10000000000000: at most 1000000000000 is allowed; line 3: \
         ky_rad_m is 200000000: at most 100000000 is allowed; line 4: kx_rad_m has 1 values: a grid needs 2 \
         or more; line 4: ky_rad_m has 1 values: a grid needs 2 or more"
    );
    let bytes = [head.as_bytes(), b"0,0,1\n0,1,\xff\n"].concat();
    let error = Measured::parse(&bytes).unwrap_err();
    assert_eq!(error.to_string(), "measured spectrum: line 3: not UTF-8 text");
    let many = head.to_string() + &"?\n".repeat(1000);
    match Measured::parse(many.as_bytes()).unwrap_err() {
        MeasuredError::Text(faults) => assert_eq!((faults.listed.len(), faults.count), (50, 1000)),
        other => panic!("{other}"),
    }
    let missing = Measured::load(std::path::Path::new("no/such/file.csv")).unwrap_err();
    assert_eq!(missing.to_string(), "measured spectrum no/such/file.csv: cannot be read: entity not found");
}
