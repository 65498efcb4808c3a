//! A radar on the way with another platform beside it, and two masts between which a carrier goes straight:
//! what the tests of emitters and of continuous reception look at.

use std::path::Path;

use nereus::config::{self, Run};
use nereus::transport::Pace;
use num_complex::Complex64;

pub const C: f64 = 299_792_458.0;
pub const RATE_HZ: f64 = 40e6;

/// Puts the receiver on the near mast, and the target out of its sight.
pub const ON_MAST: [(&str, &str); 3] = [
    ("receiver.0.platform", "mast"),
    ("receiver.0.antenna", "{ kind = 'isotropic' }"),
    ("target.0.rcs_dbsm", "-300"),
];

/// A radar of so long a run over a target and, with `sea`, a patch of sea; `more` is appended.
pub fn run(duration_s: f64, sea: bool, radar: &str, more: &str, settings: &[(&str, &str)]) -> Run {
    let (patch, water) = if sea {
        ("patch_size_m = [32, 32]\nfacet_m = 1.0", "[sea]\nwind_mps = 8.0\nwind_from_deg = 200.0")
    } else {
        ("", "")
    };
    let text = format!(
        r#"
        [scene]
        duration_s = {duration_s:?}
        seed = 3
        {patch}
        {water}
        [radar]
        carrier_hz = 9.4e9
        sample_rate_hz = {RATE_HZ:?}
        {radar}
        [[platform]]
        name = "aircraft"
        track = {{ kind = "straight", position_m = [-40, -2000, 1500], velocity_mps = [90, 0, 0] }}
        [[platform]]
        name = "other"
        track = {{ kind = "straight", position_m = [2500, 600, 1100], velocity_mps = [-60, 30, 2] }}
        [[transmitter]]
        name = "tx"
        platform = "aircraft"
        power_w = 3.0
        antenna = {{ kind = "rectangle", width_m = 0.3, height_m = 0.2 }}
        pointing = {{ kind = "at", position_m = [0, 0, 0] }}
        [[receiver]]
        name = "rx"
        platform = "aircraft"
        antenna = {{ kind = "rectangle", width_m = 0.3, height_m = 0.2 }}
        pointing = {{ kind = "at", position_m = [0, 0, 0] }}
        [[target]]
        position_m = [3, -4, 1]
        velocity_mps = [3, -5, 0]
        rcs_dbsm = 12
        {more}
        "#
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scene.toml");
    let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    let mut run = config::parse(&text, &path, &settings).unwrap();
    run.stream.pace = Pace::Fast;
    run
}

/// Two masts so far apart, m.
pub fn masts(distance_m: f64) -> String {
    format!(
        r#"
        [[platform]]
        name = "mast"
        track = {{ kind = "fixed", position_m = [0, 0, 0] }}
        [[platform]]
        name = "far"
        track = {{ kind = "fixed", position_m = [0, {distance_m:?}, 0] }}
        "#
    )
}

/// An emitter of plain pulses on the far mast, received straight; `keys` are the others that it has.
pub fn tone(keys: &str, pulse_s: f64) -> String {
    format!(
        r#"
        [[emitter]]
        polarisation = "V"
        platform = "far"
        echo = false
        antenna = {{ kind = "isotropic" }}
        waveform = {{ kind = "lfm", bandwidth_hz = 1e-3, pulse_s = {pulse_s:?} }}
        {keys}
        "#
    )
}

/// An emitter on the other platform that looks at the target; `keys` are the others that it has.
pub fn beside(keys: &str) -> String {
    format!(
        r#"
        [[emitter]]
        name = "beside"
        platform = "other"
        power_w = 20.0
        antenna = {{ kind = "rectangle", width_m = 0.2, height_m = 0.4 }}
        pointing = {{ kind = "at", position_m = [0, 0, 0] }}
        {keys}
        "#
    )
}

pub fn power(samples: &[Complex64]) -> f64 {
    samples.iter().map(|s| s.norm_sqr()).sum()
}
