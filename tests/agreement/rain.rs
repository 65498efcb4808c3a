//! The echo of rain: its power by the radar equation of volumes, its Doppler spectrum, its polarisation, and
//! that both echoes agree.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use nereus::config::Run;
use nereus::paths::list::ScattererPaths;
use nereus::pipeline::build;
use nereus::pipeline::factory::factory_by;
use nereus::pipeline::stages::PulseFactory;
use num_complex::Complex64;

use crate::cases::some_of;
use crate::runs::{keeps_the_error, pulses, scene};

const RAIN: &str = "tests/data/scenarios/rain.toml";
const C_MPS: f64 = 299_792_458.0;
const WAVELENGTH_M: f64 = C_MPS / 10e9;
/// Cross section per volume of 10 mm/h at 10 GHz, 1/m: `pi^5 0.93 200 10^1.6 1e-18/lambda^4`.
const ETA_PER_M: f64 = 2.805e-6;
/// Horizontal and vertical polarisation in [`db_per_km`].
const H: f64 = 1.0;
const V: f64 = -1.0;

/// Attenuation one way of 10 mm/h at 10 GHz, dB/km, of a port on a path of a sine of elevation: table 5 and
/// equations 4 and 5 of ITU-R P.838-3.
fn db_per_km(port: f64, rise: f64) -> f64 {
    let [(k_h, a_h), (k_v, a_v)] = [(0.01217, 1.2571), (0.01129, 1.2156)];
    let tilt = port * (1.0 - rise * rise);
    let k = 0.5 * (k_h + k_v + (k_h - k_v) * tilt);
    let alpha = (k_h * a_h + k_v * a_v + (k_h * a_h - k_v * a_v) * tilt) / (2.0 * k);
    k * 10f64.powf(alpha)
}

fn factory(run: &Run) -> PulseFactory {
    let (tracks, _) = build::tracks(&run.nav, &run.scene).unwrap();
    factory_by(&run.scene, tracks, &run.fidelity, &run.clocks).unwrap()
}

fn paths(settings: &[(&str, &str)]) -> ScattererPaths {
    let run = scene(RAIN, &[settings, &[("fidelity.echo", "\"reference\"")]].concat());
    factory(&run).scatterer_paths(0).unwrap().1
}

/// Means over seeds, and the deviations of these means.
fn over_seeds<const N: usize>(
    seeds: u32,
    settings: &[(&str, &str)],
    of: impl Fn(&ScattererPaths) -> [f64; N],
) -> [(f64, f64); N] {
    let values: Vec<[f64; N]> = (0..seeds)
        .map(|seed| of(&paths(&[settings, &[("scene.seed", &seed.to_string())]].concat())))
        .collect();
    std::array::from_fn(|i| {
        let n = f64::from(seeds);
        let mean = values.iter().map(|own| own[i]).sum::<f64>() / n;
        let variance = values.iter().map(|own| (own[i] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    })
}

/// Power of a channel between two delays of the first pair, W.
fn power_w(paths: &ScattererPaths, channel: usize, ranges_m: [f64; 2]) -> f64 {
    let delays_s = ranges_m.map(|range_m| 2.0 * range_m / C_MPS);
    let of = paths.delay_s[0].iter().zip(&paths.amplitude[channel]);
    of.filter(|(delay_s, _)| (delays_s[0]..delays_s[1]).contains(*delay_s)).map(|(_, a)| a.norm_sqr()).sum()
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

/// Power that the beam of [`RAIN`] returns from between two ranges, W, where all of it lies between the sea
/// and the top: `dP = P lambda^2 G^2 eta/((4 pi)^3 R^2) dR dOmega`, over the direction cosines up to the
/// first nulls, where `dOmega = du dv/w`, of a port and a beam of such an elevation.
fn expected_w(ranges_m: [f64; 2], port: f64, elevation_deg: f64) -> f64 {
    let db_per_km = db_per_km(port, elevation_deg.to_radians().sin());
    let (width_m, height_m) = (1.2, 0.6);
    let peak = 4.0 * PI * width_m * height_m / WAVELENGTH_M.powi(2);
    let (null_u, null_v) = (WAVELENGTH_M / width_m, WAVELENGTH_M / height_m);
    let steps = 400;
    let mut beam_sr = 0.0;
    for i in 0..steps {
        for j in 0..steps {
            let [u, v] = [(i, null_u), (j, null_v)]
                .map(|(n, null)| null * (2.0 * (f64::from(n) + 0.5) / f64::from(steps) - 1.0));
            let gain = peak * (sinc(PI * u / null_u) * sinc(PI * v / null_v)).powi(2);
            beam_sr += gain * gain / (1.0 - u * u - v * v).sqrt();
        }
    }
    beam_sr *= 4.0 * null_u * null_v / f64::from(steps * steps);
    let along = |range_m: f64| 10f64.powf(-0.2 * db_per_km * range_m / 1e3) / range_m.powi(2);
    let step_m = (ranges_m[1] - ranges_m[0]) / 1000.0;
    let of = |n: i32| along(ranges_m[0] + (f64::from(n) + 0.5) * step_m) * step_m;
    let along: f64 = (0..1000).map(of).sum();
    1000.0 * WAVELENGTH_M.powi(2) * ETA_PER_M * beam_sr * along / (4.0 * PI).powi(3)
}

#[test]
fn a_beam_in_rain_returns_what_the_radar_equation_asks() {
    let ranges_m = [[2200.0, 2800.0], [3200.0, 3900.0]];
    let of = |paths: &ScattererPaths| [power_w(paths, 0, ranges_m[0]), power_w(paths, 1, ranges_m[1])];
    let found = over_seeds(24, &[], of);
    for ((ranges_m, port), (mean_w, deviation_w)) in ranges_m.into_iter().zip([H, V]).zip(found) {
        let [share, deviation] = [mean_w, deviation_w].map(|w| w / expected_w(ranges_m, port, 20.0));
        println!("{ranges_m:?}: {share:.4} of the expected, deviation {deviation:.4}");
        assert!(deviation < 0.03);
        // A thousandth for the figures above.
        assert!((share - 1.0).abs() < 4.0 * deviation + 1e-3);
    }
}

/// Where a fine radar on a mast points that follows something fast and high: from `x` on, 3 km above it.
fn following(x_m: f64) -> [(String, String); 5] {
    let pointing = format!(
        "{{ kind = \"at\", position_m = [{x_m:.1}, 0.0, 3000.0], velocity_mps = [3000.0, 0.0, 0.0], aim_from = \"true\" }}"
    );
    [
        ("transmitter.0.pointing", pointing.as_str()),
        ("receiver.0.pointing", &pointing),
        ("radar.waveform", "{ kind = \"lfm\", bandwidth_hz = 200e6, pulse_s = 0.5e-6 }"),
        ("radar.sample_rate_hz", "240e6"),
        ("radar.window.samples", "1600"),
    ]
    .map(|(key, value)| (key.to_owned(), value.to_owned()))
}

fn paths_at(index: u64, of: &[(String, String)], settings: &[(&str, &str)]) -> ScattererPaths {
    let of: Vec<_> = of.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
    let run = scene(RAIN, &[&of, settings, &[("fidelity.echo", "\"reference\"")]].concat());
    factory(&run).scatterer_paths(index).unwrap().1
}

#[test]
fn a_pulse_in_rain_does_not_depend_on_the_length_of_the_run() {
    // The beam comes down into the rain: 12,000 points at the begin, 40,000 two seconds later.
    let of = following(3000.0);
    let at = |duration_s| {
        paths_at(10, &of, &[("radar.window.start_us", "26.0"), ("scene.duration_s", duration_s)])
    };
    let (short, long) = (at("0.05"), at("4.0"));
    println!("{} points", short.len());
    assert!(short.len() > 8_000 && short.len() < 16_384);
    assert!(short == long, "{} {}", short.len(), long.len());
}

#[test]
fn a_beam_that_turns_into_rain_loses_nothing() {
    // 45 degrees high when the slot begins, above the rain; 27 degrees a second later, wholly in it.
    let of = following(0.0);
    let paths = paths_at(995, &of, &[("radar.window.start_us", "28.7"), ("scene.duration_s", "2.0")]);
    let ranges_m = [[4350.0, 4750.0], [4800.0, 5200.0]];
    let shares = ranges_m.map(|ranges_m| power_w(&paths, 0, ranges_m) / expected_w(ranges_m, H, 27.0));
    println!("{} points, {shares:.4?} of the expected", paths.len());
    // Some 17,000 points each, of exponential gains squared at most: 2 in a hundred, three of them.
    assert!(paths.len() > 40_000 && shares.iter().all(|share| (share - 1.0).abs() < 0.06));
}

#[test]
fn where_there_would_be_too_many_points_they_stand_for_more() {
    // 1 km of range cells of 0.75 m in the rain would take 45,000 points.
    let of = following(3000.0);
    // At pulse 0 those of the later slot do not stand yet.
    let paths = paths_at(10, &of, &[("radar.window.start_us", "18.0"), ("scene.duration_s", "0.05")]);
    let share = power_w(&paths, 0, [2750.0, 3650.0]) / expected_w([2750.0, 3650.0], H, 20.0);
    println!("{} points, {share:.4} of the expected", paths.len());
    // Volumes double until no more than half of what is allowed is seen of each of two slots.
    assert!(paths.len() > 8_000 && paths.len() < 16_384);
    // Exponential gains squared at most: 2 in a hundred, three of them.
    assert!((share - 1.0).abs() < 0.06);
}

/// Uniform numbers by Weyl's sequence.
fn uniform(n: u32, roots: [f64; 3]) -> [f64; 3] {
    roots.map(|root| (f64::from(n) * root.fract()).fract())
}

#[test]
fn both_ends_apart_see_a_dipole_in_a_shell() {
    // Isotropic antennas 3 km apart: an integral over the space under the top, with the ports along
    // horizontal vectors and what completes them.
    let settings = [
        (
            "platform",
            "[{ name = \"mast\", track = { kind = \"fixed\", position_m = [0.0, 0.0, 300.0] } }, { name = \"far\", track = { kind = \"fixed\", position_m = [3000.0, 0.0, 200.0] } }]",
        ),
        (
            "receiver",
            "[{ name = \"rx\", platform = \"far\", antenna = { kind = \"isotropic\", gain_dbi = 0.0 } }]",
        ),
        (
            "transmitter",
            "[{ name = \"tx\", platform = \"mast\", power_w = 1000.0, antenna = { kind = \"isotropic\", gain_dbi = 0.0 } }]",
        ),
        ("radar.rain_top_m", "1500.0"),
        ("radar.rain_mmph", "10.0"),
        ("radar.window.start_us", "10.0"),
    ];
    let (tx, rx) = (DVec3::new(0.0, 0.0, 300.0), DVec3::new(3000.0, 0.0, 200.0));
    let delays_s = [13e-6, 22e-6];
    let mut expected_w = [0.0; 3];
    let (low, high) = (DVec3::new(-2500.0, -4000.0, 0.0), DVec3::new(5500.0, 4000.0, 1500.0));
    let (count, size) = (400_000, high - low);
    for n in 0..count {
        let at = low + size * DVec3::from_array(uniform(n, [2f64.sqrt(), 3f64.sqrt(), 5f64.sqrt()]));
        let (sent, received) = (at - tx, rx - at);
        let way_m = sent.length() + received.length();
        if !(delays_s[0]..delays_s[1]).contains(&(way_m / C_MPS)) {
            continue;
        }
        let rain = |r: f64, t: f64| {
            let db = |leg: DVec3, port: f64| db_per_km(port, leg.normalize().z) * leg.length() / 1e3;
            10f64.powf(-0.1 * (db(received, r) + db(sent, t)))
        };
        let scale = (sent.length() * received.length()).powi(-2);
        let basis = |k: DVec3| {
            let h = DVec3::Z.cross(k).normalize();
            (h, h.cross(k.normalize()))
        };
        let ((h_t, v_t), (h_r, v_r)) = (basis(sent), basis(received));
        let channels = [(h_r, h_t, rain(H, H)), (v_r, v_t, rain(V, V)), (v_r, h_t, rain(V, H))];
        for (sum, (r, t, rain)) in expected_w.iter_mut().zip(channels) {
            *sum += scale * rain * r.dot(t).powi(2);
        }
    }
    let each = 1000.0 * WAVELENGTH_M.powi(2) * ETA_PER_M / (4.0 * PI).powi(3) * size.x * size.y * size.z
        / f64::from(count);
    let ranges_m = delays_s.map(|delay_s| 0.5 * C_MPS * delay_s);
    let found = over_seeds(12, &settings, |paths| [0, 1, 2].map(|channel| power_w(paths, channel, ranges_m)));
    for (of, (mean_w, deviation_w)) in expected_w.into_iter().zip(found) {
        let [share, deviation] = [mean_w, deviation_w].map(|w| w / (each * of));
        println!("{share:.4} of the expected, deviation {deviation:.4}");
        assert!(deviation < 0.04);
        // One in a hundred for the sequence of 4e5 points.
        assert!((share - 1.0).abs() < 4.0 * deviation + 0.01);
    }
}

#[test]
fn nothing_of_the_other_polarisation_comes_back() {
    let paths = paths(&[]);
    let of = |channel: usize| paths.amplitude[channel].iter().map(|a| a.norm_sqr()).sum::<f64>();
    let [hh, vh] = [0, 2].map(of);
    assert!(paths.len() > 500 && vh < 1e-12 * hh, "{hh} {vh}");
    // Spheres return H and V alike, and rain attenuates H more: 20 degrees high, 3 to either side.
    let differ = db_per_km(H, 20f64.to_radians().sin()) - db_per_km(V, 20f64.to_radians().sin());
    for (delay_s, (hh, vv)) in paths.delay_s[0].iter().zip(paths.amplitude[0].iter().zip(&paths.amplitude[1]))
    {
        let way_km = C_MPS * delay_s / 1e3;
        let found = 20.0 * (vv / hh).norm().log10() / way_km;
        assert!((found / differ - 1.0).abs() < 0.06, "{found} dB/km of {differ}");
    }
}

#[test]
fn velocities_are_those_of_wind_fall_and_turbulence() {
    // A narrow beam: along it the fall, -3.8 Z^(1/14), by the sine of 20 degrees; without a sea there is no
    // wind.
    let fall_mps = 3.8 * (200.0 * 10f64.powf(1.6)).powf(1.0 / 14.0);
    let narrow = [
        ("transmitter.0.antenna", "{ kind = \"rectangle\", width_m = 6.0, height_m = 6.0 }"),
        ("receiver.0.antenna", "{ kind = \"rectangle\", width_m = 6.0, height_m = 6.0 }"),
    ];
    for spread in [0.0, 1.0, 2.5] {
        let spread_text = format!("{spread:.1}");
        let paths = paths(&[&narrow[..], &[("radar.rain_spread_mps", &spread_text)]].concat());
        let (mut n, mut sums) = (0.0, [0.0; 2]);
        for rate in &paths.delay_rate[0] {
            let away_mps = 0.5 * C_MPS * rate;
            n += 1.0;
            sums = [sums[0] + away_mps, sums[1] + away_mps * away_mps];
        }
        let mean = sums[0] / n;
        let rms = (sums[1] / n - mean * mean).max(0.0).sqrt();
        let expected = -fall_mps * 20f64.to_radians().sin();
        println!("{n} points: {mean:.3} m/s of {expected:.3}, rms {rms:.3} of {spread}");
        // The lobe, 0.3 degrees to either side, adds 0.02 m/s.
        assert!(n > 500.0 && (mean - expected).abs() < 4.0 * spread / n.sqrt() + 0.01);
        assert!((rms - spread).abs() < 4.0 * spread / (2.0 * n).sqrt() + 0.03);
    }
}

#[test]
fn pulses_forget_each_other_as_the_spread_asks() {
    // The correlation at a lag t is exp(-(4 pi s t/lambda)^2/2) and turns with the mean Doppler.
    let run = scene(
        RAIN,
        &[("radar.rain_spread_mps", "1.0"), ("radar.prf_hz", "1000.0"), ("fidelity.echo", "\"reference\"")],
    );
    let factory = factory(&run);
    let cells = 150;
    let field = |index: u64| {
        let paths = factory.scatterer_paths(index).unwrap().1;
        let mut field = vec![Complex64::ZERO; cells];
        for (delay_s, a) in paths.delay_s[0].iter().zip(&paths.amplitude[0]) {
            let cell = (0.5 * (delay_s - 13e-6) * C_MPS / 15.0).floor();
            if (0.0..cells as f64).contains(&cell) {
                // As loud near as far.
                field[cell as usize] += a * delay_s * Complex64::cis(-TAU * 10e9 * delay_s);
            }
        }
        field
    };
    let lags = [1u64, 2, 3, 4];
    let (mut power, mut products) = (0.0, [Complex64::ZERO; 4]);
    for first in [0, 30, 60, 90] {
        let at = field(first);
        power += at.iter().map(Complex64::norm_sqr).sum::<f64>();
        for (product, lag) in products.iter_mut().zip(lags) {
            *product += at.iter().zip(field(first + lag)).map(|(a, b)| a.conj() * b).sum::<Complex64>();
        }
    }
    let fall_mps = 3.8 * (200.0 * 10f64.powf(1.6)).powf(1.0 / 14.0);
    let closing_mps = fall_mps * 20f64.to_radians().sin();
    for (product, lag) in products.into_iter().zip(lags) {
        let lag_s = lag as f64 * 1e-3;
        let turn = 4.0 * PI * lag_s / WAVELENGTH_M;
        let expected = Complex64::from_polar((-0.5 * turn * turn).exp(), turn * closing_mps);
        let found = product / power;
        println!("{lag} ms: {found:.3}, expected {expected:.3}");
        // Of some 500 cells that are independent: 0.045, three of them.
        assert!((found - expected).norm() < 0.14);
    }
}

#[test]
fn without_rain_or_clutter_there_is_nothing() {
    let off = paths(&[("radar.rain_clutter", "false")]);
    assert!(off.is_empty());
}

/// Rain alone; over a sea from an aircraft, with targets; of alternating polarisations; over a ship.
const SCENES: [(&str, &[(&str, &str)]); 4] = [
    (RAIN, &[("radar.window.samples", "64"), ("scene.duration_s", "0.04")]),
    (
        "configs/sea.toml",
        &[
            ("scene.patch_size_m", "[32, 32]"),
            ("scene.duration_s", "0.1"),
            ("radar.channels", "['HH', 'HV']"),
            ("radar.rain_mmph", "20.0"),
            ("radar.rain_clutter", "true"),
        ],
    ),
    (
        "configs/monostatic.toml",
        &[
            ("scene.duration_s", "0.01"),
            ("radar.rain_mmph", "20.0"),
            ("radar.rain_clutter", "true"),
            ("radar.adc", "{ bits = 16, full_scale_dbw = -85.0 }"),
        ],
    ),
    // The panels of a ship, in rain that attenuates H and V by decibels.
    (
        "configs/mars-1.toml",
        &[
            ("scene.patch_size_m", "[32, 32]"),
            ("scene.duration_s", "0.1"),
            ("radar.rain_mmph", "100.0"),
            ("ship.0.length_m", "40"),
            ("ship.0.panel_m", "1.2"),
            ("ship.0.echo", "true"),
        ],
    ),
];

#[test]
fn rain_keeps_the_error() {
    for (path, settings) in some_of(SCENES) {
        let fast = [("fidelity.echo", "\"fast\""), ("fidelity.error_db", "-60.0")];
        let run = scene(path, &[settings, &fast].concat());
        keeps_the_error(path, &run);
    }
}

#[test]
fn a_part_of_a_run_in_rain_is_bit_identical() {
    // Slots begin every second: at pulse 500.
    let long = [("scene.duration_s", "1.1"), ("radar.window.samples", "64")];
    let whole = pulses(RAIN, &long, "2", 490..510);
    for begin in some_of([497, 504]) {
        assert!(pulses(RAIN, &long, "1", begin..510) == whole[begin as usize - 490..], "a part differs");
    }
}
