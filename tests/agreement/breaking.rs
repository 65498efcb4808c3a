//! Breaking waves in the echo: the error that is predicted and the one that is measured, over all pulses;
//! that a pulse depends on its number alone; and that off is as it was.

use crate::cases::some_of;
use crate::runs::{keeps_the_error, pulses, scene};

const ON: (&str, &str) = ("sea.scattering.breaking", "whitecaps");

/// Small seas in which breakers count: seen from above, and at 3 degrees grazing with crests that hide them.
const SCENES: [(&str, &[(&str, &str)]); 2] = [
    (
        "configs/sea.toml",
        &[
            ("scene.patch_size_m", "[32, 32]"),
            ("scene.duration_s", "0.15"),
            ("radar.channels", "['HH', 'HV']"),
            ("sea.wind_mps", "15"),
        ],
    ),
    (
        "configs/sea.toml",
        &[
            ("scene.patch_size_m", "[32, 32]"),
            ("scene.duration_s", "0.15"),
            ("radar.channels", "['HH', 'VV']"),
            ("sea.wind_mps", "20"),
            ("platform.0.track.position_m", "[-3000, -55.5, 160]"),
            ("radar.window.start_us", "19.5"),
        ],
    ),
];

#[test]
fn breaking_waves_keep_the_error() {
    for (path, settings) in SCENES {
        let fast = [ON, ("fidelity.echo", "fast"), ("fidelity.error_db", "-60.0")];
        let run = scene(path, &[settings, &fast].concat());
        keeps_the_error(path, &run);
    }
}

#[test]
fn breaking_waves_out_of_plane_keep_the_error() {
    let path = "tests/data/cases/breaking-bistatic-90.toml";
    let settings = [
        ("scene.patch_size_m", "[32, 32]"),
        ("scene.duration_s", "0.1"),
        ("radar.prf_hz", "200.0"),
        ("sea.wind_mps", "18.0"),
        ("fidelity.error_db", "-60.0"),
    ];
    keeps_the_error(path, &scene(path, &settings));
}

#[test]
fn a_part_of_a_run_with_breaking_waves_is_bit_identical() {
    for (path, settings) in &SCENES[..] {
        // Breakers are found half a second at a time: at pulse 111.
        let long = ("scene.duration_s", "0.6");
        let on = [settings, &[ON, long][..]].concat();
        let whole = pulses(path, &on, "2", 95..125);
        for begin in some_of([108, 119]) {
            assert!(pulses(path, &on, "1", begin..125) == whole[begin as usize - 95..], "a part differs");
        }
        let off = [settings, &[(ON.0, "off"), long][..]].concat();
        assert!(pulses(path, &off, "2", 95..125) != whole, "nothing breaks");
    }
}

#[test]
fn extremes_are_made() {
    for settings in [
        &[("sea.wind_mps", "0")][..],
        &[("sea.wind_mps", "40")],
        &[("scene.patch_size_m", "[1, 1]"), ("sea.wind_mps", "40")],
        &[("scene.facet_m", "0.25"), ("scene.patch_size_m", "[8, 8]")],
    ] {
        for echo in ["fast", "reference"] {
            let short = [
                ON,
                ("scene.patch_size_m", "[16, 16]"),
                ("radar.channels", "['HH']"),
                ("fidelity.echo", echo),
            ];
            let made = pulses("configs/sea.toml", &[&short[..], settings].concat(), "2", 0..12);
            assert_eq!(made.len(), 12);
            let nereus::pulse::Samples::Cf32(samples) = &made[11].samples else { panic!("a converter") };
            assert!(samples.iter().all(|s| s.re.is_finite() && s.im.is_finite()), "{settings:?}");
        }
    }
}
