//! Choppy waves in the echo: the error that is predicted and the one that is measured, over all pulses, and
//! that a pulse depends on its number alone.

use crate::cases::{sized, some_of};
use crate::runs::{FOLLOWS, keeps_the_error, pulses, scene};

const SEA: &str = "configs/sea.toml";
/// Waves alone, far above the noise.
fn on() -> [(&'static str, &'static str); 5] {
    [
        ("sea.waves", "choppy"),
        ("scene.patch_size_m", sized("[64, 64]", "[48, 48]")),
        ("scene.facet_m", "2"),
        ("transmitter.0.power_w", "1e9"),
        ("target.0.rcs_m2", "1e-9"),
    ]
}

#[test]
fn choppy_waves_keep_the_error() {
    let cases: [&[(&str, &str)]; 5] = [
        &[("sea.wind_from_deg", "345"), ("sea.wind_mps", "12")],
        &[
            ("radar.carrier_hz", "1.3e9"),
            ("sea.wind_from_deg", "0"),
            ("sea.scattering.modulation", "relaxation"),
        ],
        &[
            ("scene.patch_size_m", "[32, 32]"),
            ("scene.facet_m", "0.5"),
            ("sea.scattering.breaking", "whitecaps"),
        ],
        &FOLLOWS,
        // More facets than a block has its shadows for apart.
        &[("scene.patch_size_m", "[132, 132]"), ("scene.facet_m", "1"), ("sea.wind_mps", "12")],
    ];
    for settings in some_of(cases) {
        let fast = [("fidelity.echo", "fast"), ("fidelity.error_db", "-60.0")];
        let run = scene(SEA, &[&on()[..], settings, &fast].concat());
        keeps_the_error(&format!("{settings:?}"), &run);
    }
}

#[test]
fn a_part_of_a_run_with_choppy_waves_is_bit_identical() {
    for settings in some_of([&[][..], &FOLLOWS]) {
        let settings = [&on()[..], settings].concat();
        let whole = pulses(SEA, &settings, "2", 20..60);
        for begin in some_of([33, 51]) {
            assert!(pulses(SEA, &settings, "1", begin..60) == whole[begin as usize - 20..], "a part differs");
        }
        let off = [&settings[..], &[("sea.waves", "linear")]].concat();
        let linear = pulses(SEA, &off, "2", 20..60);
        assert!(linear != whole, "nothing is choppy");
        // They are the default.
        let default: Vec<_> = settings.iter().filter(|(key, _)| *key != "sea.waves").copied().collect();
        assert!(pulses(SEA, &default, "2", 20..60) == whole, "the default is not choppy");
    }
}
