//! The settings of `[fidelity]`, and what they are set to.
//!
//! A new setting gets a row in [`SETTINGS`], and what it is set to a line in [`settings`]; `nereus tradeoff`
//! sweeps it then, and `nereus bench` reports it.

use serde_json::{Map, Value, json};

use crate::echo::synth::Precision;
use crate::echo::synth::doppler::Doppler;
use crate::fidelity::echo_settings::EchoSettings;

/// A key of the scenario and values to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Dotted path of the key.
    pub key: &'static str,
    /// Values, as TOML.
    pub values: &'static [&'static str],
}

/// The requested error: the other settings are chosen for it.
pub const ERROR_KEY: &str = "fidelity.error_db";

/// What trades accuracy for speed.
pub const SETTINGS: &[Setting] = &[
    Setting { key: ERROR_KEY, values: &["-30.0", "-45.0", "-60.0", "-75.0", "-90.0"] },
    Setting { key: "fidelity.node_pulses", values: &["1", "4", "8", "12", "16"] },
    Setting { key: "fidelity.scatter_pulses", values: &["4", "6", "12"] },
    Setting { key: "fidelity.gain_pulses", values: &["1", "2", "4", "6"] },
    Setting { key: "fidelity.sidelobe_db", values: &["-30.0", "-40.0", "-50.0", "-400.0"] },
    Setting { key: "fidelity.cutoff_db", values: &["-30.0", "-40.0", "-60.0", "-400.0"] },
    Setting { key: "fidelity.kernel_width", values: &["3", "4", "5", "6", "7"] },
    Setting { key: "fidelity.doppler", values: &["mean", "shift", "taylor", "shift-taylor"] },
];

/// Choices of the model. They change what is emulated, for the reference too: their effect is no error.
pub const MODELS: &[Setting] = &[
    Setting { key: "sea.scattering.splitting", values: &["consistent", "mars2007"] },
    Setting { key: "sea.scattering.phases", values: &["polcoherent", "single"] },
    Setting { key: "sea.scattering.displacement", values: &["true", "false"] },
    Setting { key: "sea.shadow.enabled", values: &["true", "false"] },
    Setting { key: "sea.shadow.edge", values: &["soft", "sharp"] },
    Setting { key: "sea.shadow.update_ms", values: &["20.0", "45.0", "90.0", "180.0"] },
];

/// What an echo is set to, by name: that of a plan, or the reference.
pub fn settings(chosen: Option<&EchoSettings>) -> Map<String, Value> {
    let mut map = Map::new();
    let mut set = |name: &str, value: Value| map.insert(name.to_owned(), value);
    let Some(chosen) = chosen else {
        set("echo", json!("reference"));
        return map;
    };
    set("echo", json!("fast"));
    set("node_pulses", json!(chosen.node_pulses));
    set("gain_pulses", json!(chosen.gain_pulses));
    if let Some(panel_pulses) = chosen.panel_pulses {
        set("panel_pulses", json!(panel_pulses));
    }
    set("scatter_pulses", json!(chosen.scatter_pulses()));
    if let Some(pulses) = chosen.wake_scatter_pulses() {
        set("wake_scatter_pulses", json!(pulses));
    }
    set("sidelobe_db", chosen.sidelobe.map_or(json!("none"), |sidelobe| json!(sidelobe.below_db)));
    set("cutoff_db", chosen.cutoff_db().map_or(json!("none"), |cutoff_db| json!(cutoff_db)));
    set("kernel_width", json!(chosen.echo.width));
    set("oversampling", json!(chosen.echo.oversampling));
    let doppler = match chosen.echo.doppler {
        Doppler::Mean => "mean",
        Doppler::Shift => "shift",
        Doppler::Taylor => "taylor",
        Doppler::ShiftTaylor => "shift-taylor",
    };
    set("doppler", json!(doppler));
    if chosen.fine.surface {
        set("surface", json!("f64"));
    }
    set("precision", json!(if chosen.precision == Precision::Double { "f64" } else { "f32" }));
    map
}
