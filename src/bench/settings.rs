//! The knobs of `[fidelity]`, and what they are set to.
//!
//! A new knob gets a row in [`KNOBS`], and what it is set to a line in [`settings`]; `nereus tradeoff` sweeps it then, and
//! `nereus bench` tells it.

use serde_json::{Map, Value, json};

use crate::echo::synth::Precision;
use crate::echo::synth::doppler::Doppler;
use crate::fidelity::echo_settings::Settled;

/// A key of the scenario and values to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knob {
    /// Dotted path of the key.
    pub key: &'static str,
    /// Values, as TOML.
    pub values: &'static [&'static str],
}

/// The error that is asked: the other knobs are chosen for it.
pub const ERROR_KEY: &str = "fidelity.error_db";

/// What trades accuracy for speed.
pub const KNOBS: &[Knob] = &[
    Knob { key: ERROR_KEY, values: &["-30.0", "-45.0", "-60.0", "-75.0", "-90.0"] },
    Knob { key: "fidelity.node_pulses", values: &["1", "4", "8", "12", "16"] },
    Knob { key: "fidelity.scatter_pulses", values: &["4", "6", "12"] },
    Knob { key: "fidelity.gain_pulses", values: &["1", "2", "4", "6"] },
    Knob { key: "fidelity.faint_db", values: &["-30.0", "-40.0", "-50.0", "-400.0"] },
    Knob { key: "fidelity.kernel_width", values: &["4", "5", "6", "7"] },
    Knob { key: "fidelity.doppler", values: &["mean", "shift", "taylor"] },
];

/// Choices of the model. They change what is emulated, for the reference too: their effect is no error.
pub const MODELS: &[Knob] = &[
    Knob { key: "sea.scattering.splitting", values: &["consistent", "mars2007"] },
    Knob { key: "sea.scattering.phases", values: &["polcoherent", "single"] },
    Knob { key: "sea.scattering.displacement", values: &["true", "false"] },
    Knob { key: "sea.shadow.enabled", values: &["true", "false"] },
    Knob { key: "sea.shadow.edge", values: &["soft", "sharp"] },
    Knob { key: "sea.shadow.update_ms", values: &["20.0", "45.0", "90.0", "180.0"] },
];

/// What an echo is set to, by name: that of a plan, or the reference.
pub fn settings(settled: Option<&Settled>) -> Map<String, Value> {
    let mut map = Map::new();
    let mut set = |name: &str, value: Value| map.insert(name.to_owned(), value);
    let Some(settled) = settled else {
        set("echo", json!("reference"));
        return map;
    };
    set("echo", json!("fast"));
    set("node_pulses", json!(settled.node_pulses));
    set("gain_pulses", json!(settled.gain_pulses));
    set("scatter_pulses", json!(settled.scatter_pulses()));
    set("faint_db", settled.faint.map_or(json!("none"), |faint| json!(faint.below_db)));
    set("kernel_width", json!(settled.echo.width));
    set("oversampling", json!(settled.echo.oversampling));
    let doppler = match settled.echo.doppler {
        Doppler::Mean => "mean",
        Doppler::Shift => "shift",
        Doppler::Taylor => "taylor",
    };
    set("doppler", json!(doppler));
    set("precision", json!(if settled.precision == Precision::Double { "f64" } else { "f32" }));
    map
}
