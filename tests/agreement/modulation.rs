//! Modulated Bragg waves in the echo: the error that is predicted and the one that is measured, over all
//! pulses, and that a pulse depends on its number alone.

use crate::cases::some_of;
use crate::runs::{FOLLOWS, keeps_the_error, pulses, scene};

const SEA: &str = "configs/sea.toml";
/// Waves alone, far above the noise.
const ON: [(&str, &str); 5] = [
    ("sea.scattering.modulation", "relaxation"),
    ("scene.patch_size_m", "[64, 64]"),
    ("scene.facet_m", "2"),
    ("transmitter.0.power_w", "1e9"),
    ("target.0.rcs_m2", "1e-9"),
];

#[test]
fn modulated_waves_keep_the_error() {
    let cases: [&[(&str, &str)]; 4] = [
        &[("sea.wind_from_deg", "90"), ("sea.scattering.bragg", "frozen")],
        &[("sea.wind_from_deg", "345")],
        &[("radar.carrier_hz", "1.3e9"), ("sea.wind_from_deg", "0"), ("sea.scattering.bragg", "frozen")],
        &FOLLOWS,
    ];
    for settings in some_of(cases) {
        let fast = [("fidelity.echo", "fast"), ("fidelity.error_db", "-60.0")];
        let run = scene(SEA, &[&ON[..], settings, &fast].concat());
        keeps_the_error(&format!("{settings:?}"), &run);
    }
}

#[test]
fn a_part_of_a_run_with_modulated_waves_is_bit_identical() {
    for settings in some_of([&[][..], &FOLLOWS]) {
        let settings = [&ON[..], settings].concat();
        let whole = pulses(SEA, &settings, "2", 20..60);
        for begin in some_of([33, 51]) {
            assert!(pulses(SEA, &settings, "1", begin..60) == whole[begin as usize - 20..], "a part differs");
        }
        let off = [&settings[..], &[("sea.scattering.modulation", "off")]].concat();
        assert!(pulses(SEA, &off, "2", 20..60) != whole, "nothing is modulated");
    }
}
