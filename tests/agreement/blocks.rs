//! Echoes in blocks against the reference, pulse by pulse, in the run that streams.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nereus::config::{self, Run};
use nereus::echo::Fidelity;
use nereus::pipeline::build;
use nereus::pulse::Samples;
use num_complex::Complex64;

use crate::cases::{sized, some_of};

/// A scenario of the repository with some keys set, without recordings.
pub(super) fn scenario(name: &str, settings: &[(&str, &str)]) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(name);
    let mut text = std::fs::read_to_string(&path).unwrap();
    if settings.iter().any(|(key, _)| *key == "radar.pri_us") {
        // Intervals instead of a PRF.
        text = text.lines().filter(|line| !line.starts_with("prf_hz")).collect::<Vec<_>>().join("\n");
    }
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::parse(&text, &path, &settings).unwrap();
    run.sinks.clear();
    run.stream.pace = nereus::transport::Pace::Fast;
    run
}

/// The same run with the reference echo.
fn reference(mut run: Run) -> Run {
    run.fidelity = Fidelity::Reference;
    run
}

/// Samples of some pulses, `[pulse][channel x sample]`.
pub(super) fn samples(run: &Run, range: std::ops::Range<u64>) -> Vec<Vec<Complex64>> {
    let mut pulses = Vec::new();
    let outcome = build::stream(run, range)
        .unwrap()
        .tap(&Arc::new(AtomicBool::new(false)), |pulse| {
            let widen = |s: &num_complex::Complex32| Complex64::new(s.re.into(), s.im.into());
            let Samples::Cf32(samples) = &pulse.samples else { panic!("a converter") };
            pulses.push(samples.iter().map(widen).collect());
        })
        .unwrap();
    outcome.result.unwrap();
    pulses
}

/// The error as it is defined: the largest over pulses and channels of a pulse's error over the rms of that
/// channel in the reference of the run, dB.
pub(super) fn worst_db(found: &[Vec<Complex64>], reference: &[Vec<Complex64>]) -> f64 {
    let channel = |pulse: &[Complex64], c: usize| pulse.chunks(pulse.len() / 4).nth(c).unwrap().to_vec();
    let power = |samples: &[Complex64]| samples.iter().map(|s| s.norm_sqr()).sum::<f64>();
    let mut worst_db = f64::NEG_INFINITY;
    for c in 0..4 {
        let rms: f64 = reference.iter().map(|p| power(&channel(p, c))).sum::<f64>() / reference.len() as f64;
        for (a, b) in found.iter().zip(reference) {
            let apart: Vec<_> = channel(a, c).iter().zip(channel(b, c)).map(|(a, b)| a - b).collect();
            if rms > 0.0 {
                worst_db = worst_db.max(10.0 * (power(&apart) / rms).log10());
            }
        }
    }
    worst_db
}

const SMALL: [(&str, &str); 2] = [("scene.patch_size_m", "[64, 64]"), ("stream.threads", "2")];

/// [`SMALL`], or smaller.
fn small() -> [(&'static str, &'static str); 2] {
    [("scene.patch_size_m", sized(SMALL[0].1, "[32, 32]")), SMALL[1]]
}

fn with<'a>(more: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    [&small()[..], more].concat()
}

#[test]
fn blocks_keep_the_error_that_their_nodes_allow() {
    // The beam passes over the patch; a whole block and parts of two.
    let range = sized(236..285, 240..264);
    let patch = [("scene.patch_size_m", sized("[64, 64]", "[48, 48]")), SMALL[1]];
    let of = |more: &[(&str, &str)]| {
        samples(&scenario("mars-1.toml", &[&patch[..], more].concat()), range.clone())
    };
    let exact = of(&[("fidelity.echo", "reference")]);
    // Kernel width 5 and single precision leave -80 dB. Cubics through nodes: the error grows with the fourth
    // power of the spacing, 7 dB from 8 to 12 pulses and 5 from there to 16, and more where the shortest
    // waves are no longer resolved. Gains at 4 pulses do not show, at 8 they are all that does (six points
    // over a beam's tenth of a lobe).
    for (node, gain, allowed_db) in
        [("1", "1", -75.0), ("8", "4", -72.0), ("12", "4", -66.0), ("16", "4", -58.0), ("12", "8", -25.0)]
    {
        let written = [
            ("fidelity.node_pulses", node),
            ("fidelity.gain_pulses", gain),
            ("fidelity.kernel_width", "5"),
            ("fidelity.sidelobe_db", "-400"),
        ];
        let error_db = worst_db(&of(&written), &exact);
        println!("mars-1, nodes {node} pulses apart, gains {gain}: worst {error_db:.1} dB");
        assert!(error_db < allowed_db);
        assert!(gain == "4" || gain == "1" || error_db > -50.0, "gains 8 pulses apart make a difference");
    }
}

/// Grazing incidence: scattering changes faster than the waves, near the angle at which vertical polarisation
/// is least.
#[test]
fn grazing_facets_need_more_epochs_than_the_sea() {
    let range = sized(240..282, 246..270);
    let exact = samples(
        &scenario("mars-4.toml", &[&SMALL[..], &[("fidelity.echo", "reference")]].concat()),
        range.clone(),
    );
    let of = |epochs| {
        let written = [
            ("fidelity.node_pulses", "12"),
            ("fidelity.scatter_pulses", epochs),
            ("fidelity.gain_pulses", "3"),
        ];
        worst_db(&samples(&scenario("mars-4.toml", &[&SMALL[..], &written].concat()), range.clone()), &exact)
    };
    let (often, seldom) = (of("4"), of("12"));
    println!("mars-4, 64 x 64: epochs 4 pulses apart {often:.1} dB, 12 apart {seldom:.1} dB");
    assert!(often < -66.0 && seldom > often + 10.0);
}

/// Isotropic antennas that point ahead, with the sea abeam and with the sea beneath, where their ports turn
/// quickest.
#[test]
fn isotropic_antennas_keep_the_error() {
    let isotropic = [
        ("transmitter.0.antenna", r#"{ kind = "isotropic" }"#),
        ("receiver.0.antenna", r#"{ kind = "isotropic" }"#),
        ("transmitter.0.pointing", r#"{ kind = "fixed" }"#),
        ("receiver.0.pointing", r#"{ kind = "fixed" }"#),
    ];
    let beneath = [
        ("platform.0.track.position_m", "[-140, -3, 300]"),
        ("platform.0.track.velocity_mps", "[120, 0, 0]"),
        ("radar.window.start_us", "1.0"),
    ];
    for (name, more) in some_of([("beneath", &beneath[..]), ("abeam", &[])]) {
        let settings = with(&[&isotropic[..], more].concat());
        let run = scenario("mars-1.toml", &settings);
        let range = 236..285;
        let error_db = worst_db(&samples(&run, range.clone()), &samples(&reference(run.clone()), range));
        println!("mars-1, 64 x 64, isotropic antennas, the sea {name}: worst {error_db:.1} dB");
        assert!(error_db < -60.0, "{name}: {error_db}");
    }
}

/// What only side lobes light is evaluated less often, and loses no more than its share of the echo allows.
#[test]
fn sidelobe_tiles_leave_what_their_gain_allows() {
    let range = sized(236..285, 248..254);
    // So large that the beam of 42 m leaves most to its side lobes.
    let size = ("scene.patch_size_m", sized("[512, 512]", "[320, 320]"));
    let wide = [size, ("scene.facet_m", "4.0"), ("stream.threads", "2")];
    let of =
        |more: &[(&str, &str)]| samples(&scenario("mars-1.toml", &[&wide[..], more].concat()), range.clone());
    let exact = of(&[("fidelity.echo", "reference")]);
    let [none, far, near, all] = ["-400", "-55", "-35", "0"].map(|sidelobe_db| {
        let written = [
            ("fidelity.node_pulses", "12"),
            ("fidelity.scatter_pulses", "12"),
            ("fidelity.gain_pulses", "3"),
            ("fidelity.kernel_width", "6"),
            ("fidelity.sidelobe_db", sidelobe_db),
        ];
        let error_db = worst_db(&of(&written), &exact);
        println!("mars-1, facets of 4 m, sidelobe below {sidelobe_db} dB: worst {error_db:.1} dB");
        error_db
    });
    assert!(none < -70.0 && far < none + 3.0 && near > none + 3.0 && all > near + 10.0);
}

/// Grazing incidence with shadows, and a patch that moves under a block.
#[test]
fn blocks_of_grazing_and_following_seas() {
    // The edges of mars-live are out of sight in a patch of full size, here of larger facets.
    let wide = [("scene.facet_m", "4.0"), ("stream.threads", "2")];
    for (name, settings, range) in some_of([
        ("mars-live.toml", &wide, sized(13_320..13_344, 13_320..13_326)),
        ("mars-4.toml", &small(), 240..264),
    ]) {
        let settings = |echo| [&settings[..], &[("fidelity.echo", echo)]].concat();
        let exact = samples(&reference(scenario(name, &settings("fast"))), range.clone());
        let error_db = worst_db(&samples(&scenario(name, &settings("fast")), range), &exact);
        println!("{name}: worst pulse and channel {error_db:.1} dB");
        assert!(error_db < -60.0);
    }
}

/// Nodes are functions of time, evaluated when a pulse is emitted, in the channels that it fills, with phases
/// as they are then: intervals that differ (of two dozens, too, and by whole intervals), polarisations that
/// alternate, facets that forget their phases (one tilt and nine), all of them at once, with waves that
/// travel, facets of Gaussian amplitude (at rest, forgotten and travelling) and a patch that follows.
#[test]
fn blocks_follow_stagger_alternation_and_phases_that_are_forgotten() {
    let irregular = "[1500, 1000, 12000, 1200, 3000]";
    let alternating = ("radar.tx_polarisation", "alternating");
    let stagger = ("radar.pri_us", "[4400, 4600, 4500]");
    let forgets = ("sea.scattering.decorrelation_ms", "10.0");
    let travelling = ("sea.scattering.bragg", "travelling");
    let gaussian = ("sea.scattering.speckle", "gaussian");
    for (name, more) in some_of([
        ("mars-1.toml", &[stagger, alternating, forgets][..]),
        ("mars-1.toml", &[stagger]),
        ("mars-1.toml", &[alternating]),
        ("mars-1.toml", &[forgets]),
        ("mars-1.toml", &[forgets, ("sea.scattering.tilt_average", "true")]),
        ("mars-1.toml", &[travelling, gaussian, ("sea.scattering.tilt_average", "true")]),
        ("mars-1.toml", &[gaussian, forgets, ("sea.scattering.tilt_average", "true")]),
        ("mars-1.toml", &[gaussian]),
        ("mars-1.toml", &[("radar.pri_us", irregular), travelling]),
        ("mars-live.toml", &[stagger, alternating]),
    ]) {
        let settings = |echo| {
            let own = [
                ("fidelity.echo", echo),
                ("fidelity.node_pulses", "12"),
                ("fidelity.gain_pulses", "4"),
                ("fidelity.sidelobe_db", "-400"),
            ];
            with(&[&own, more].concat())
        };
        let (range, run) = (sized(236..285, 240..264), scenario(name, &settings("fast")));
        let stream = build::stream(&run, range.clone()).unwrap();
        assert!(stream.factory().plan().unwrap().prediction.path > 0.0, "{name} {more:?}: pulse by pulse");
        drop(stream);
        let exact = samples(&scenario(name, &settings("reference")), range.clone());
        let error_db = worst_db(&samples(&run, range), &exact);
        println!("{name} {more:?}: worst pulse and channel {error_db:.1} dB");
        assert!(error_db < -58.0, "{name} {more:?}: {error_db}");
    }
}

/// At a high PRF nodes lie as far apart as the water moves, and tiles are evaluated at their supports alone:
/// with equal intervals and staggered, alternating polarisations, waves that travel, and phases that are
/// forgotten.
#[test]
fn nodes_and_supports_lie_as_far_apart_as_the_sea_allows() {
    let even = ("radar.prf_hz", "2000");
    let stagger = ("radar.pri_us", "[470, 520, 510]");
    let alternating = ("radar.tx_polarisation", "alternating");
    let travelling = ("sea.scattering.bragg", "travelling");
    let forgets = ("sea.scattering.decorrelation_ms", "20.0");
    for more in some_of([
        &[even][..],
        &[stagger, alternating, travelling],
        &[even, forgets],
        &[even, ("radar.carrier_hz", "1.3e9")],
        &[even, travelling, ("radar.window.samples", "200"), ("radar.window.start_us", "27.6")],
    ]) {
        let settings = |echo| {
            let own = [
                ("scene.duration_s", "0.256"),
                ("platform.0.track.position_m", "[-28, -3000, 3000]"),
                ("fidelity.error_db", "-50"),
                ("fidelity.echo", echo),
            ];
            with(&[&own, more].concat())
        };
        let run = scenario("mars-1.toml", &settings("fast"));
        let plan = *build::stream(&run, 0..run.scene.pulses).unwrap().factory().plan().unwrap();
        println!("{more:?}: {:?}, predicted {:.1} dB", plan.chosen, plan.prediction.total_db());
        assert!(plan.chosen.node_pulses > 21 && plan.keeps(), "{plan:?}");
        assert!(plan.chosen.between.is_some(), "{more:?}");
        let range = 0..sized(512, 128);
        let exact = samples(&scenario("mars-1.toml", &settings("reference")), range.clone());
        let error_db = worst_db(&samples(&run, range), &exact);
        println!("{more:?}: worst pulse and channel {error_db:.1} dB");
        assert!(error_db < -50.0, "{more:?}");
    }
}

/// Waves that travel keep the error that is asked, -60 dB, at all pulses of a run: in X and L band, wind
/// along and across the line of sight and between (where both lines change), and from nearly above, where
/// specular points turn by a phasor of their own.
#[test]
fn travelling_waves_keep_the_error() {
    let above = [
        ("platform.0.track.position_m", "[-300.0, -55.5, 3000.0]"),
        ("transmitter.0.pointing.across_m", "300.0"),
        ("receiver.0.pointing.across_m", "300.0"),
        ("radar.window.start_us", "19.7"),
    ];
    for (carrier_hz, wind_from_deg, more) in some_of([
        ("10e9", "345", &[][..]),
        ("1.3e9", "0", &[]),
        ("10e9", "0", &[]),
        ("10e9", "90", &[]),
        ("1.3e9", "90", &[]),
        ("10e9", "90", &above),
    ]) {
        let settings = |echo| {
            let own = [
                ("radar.carrier_hz", carrier_hz),
                ("sea.wind_from_deg", wind_from_deg),
                ("fidelity.echo", echo),
                ("sea.scattering.bragg", "travelling"),
                ("scene.facet_m", "2"),
                // Far above the noise.
                ("transmitter.0.power_w", "1e9"),
                ("target.0.rcs_m2", "1e-9"),
            ];
            with(&[&own, more].concat())
        };
        let found = samples(&scenario("sea.toml", &settings("fast")), 0..111);
        let exact = samples(&scenario("sea.toml", &settings("reference")), 0..111);
        let error_db = worst_db(&found, &exact);
        println!(
            "{carrier_hz} Hz, wind from {wind_from_deg}, {} more: worst pulse {error_db:.1} dB",
            more.len()
        );
        assert!(error_db < -60.0);
    }
}

/// Waves that are modulated keep it, too, frozen and travelling.
#[test]
fn any_part_of_a_run_has_the_same_bits() {
    let small = ("scene.patch_size_m", "[32, 32]");
    let of_ship = ("ship.0.wake_bragg", "true");
    let travelling = [("sea.scattering.bragg", "travelling"), ("radar.carrier_hz", "1.3e9"), of_ship, small];
    for (name, more) in [("mars-1.toml", &[][..]), ("mars-live.toml", &[]), ("mars-1.toml", &travelling)] {
        let settings = |threads| {
            let own = [("stream.threads", threads), ("scene.duration_s", "2.0")];
            with(&[&own, more].concat())
        };
        let whole = samples(&scenario(name, &settings("1")), 230..262);
        assert!(whole.iter().flatten().any(|s| s.norm_sqr() > 0.0));
        let two = samples(&scenario(name, &settings("2")), 230..262);
        let part = samples(&scenario(name, &settings("3")), 243..257);
        assert!(whole == two, "{name}: 1 and 2 threads");
        assert!(whole[13..27] == part[..], "{name}: a part");
    }
}

/// At L and C band the short waves of a ship scatter within facets: the narrow V sails through the patch
/// while blocks are interpolated. Spectra on nodes keep what is asked, also where little is allowed.
#[test]
fn blocks_follow_the_short_waves_of_a_ship() {
    for (carrier_hz, error) in some_of([("1.3e9", "-60"), ("5.4e9", "-60"), ("1.3e9", "-80")]) {
        let settings = |echo, bragg| {
            let ship = [("ship.0.position_m", "[200, 0]"), ("ship.0.speed_mps", "9")];
            let asked = [
                ("radar.carrier_hz", carrier_hz),
                ("fidelity.error_db", error),
                ("fidelity.echo", echo),
                ("ship.0.wake_bragg", bragg),
            ];
            with(&[&ship[..], &asked].concat())
        };
        let range = sized(246..258, 250..254);
        let of = |echo, bragg| samples(&scenario("mars-1.toml", &settings(echo, bragg)), range.clone());
        let exact = of("reference", "true");
        let effect_db = worst_db(&of("reference", "false"), &exact);
        let error_db = worst_db(&of("fast", "true"), &exact);
        println!("{carrier_hz} Hz: short waves are worth {effect_db:.1} dB, blocks leave {error_db:.1} dB");
        assert!(effect_db > -40.0 && error_db < error.parse().unwrap());
    }
}
