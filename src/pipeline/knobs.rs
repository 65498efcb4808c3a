//! The knobs of `[fidelity]`, and what they are set to.
//!
//! A new knob gets a row in [`KNOBS`], and what it is set to a line in [`settings`]; `nereus tradeoff` sweeps it then, and
//! `nereus bench` tells it.

use serde_json::{Map, Value, json};

use crate::echo::Fidelity;
use crate::echo::synth::doppler::Doppler;

/// A key of the scenario and values to try.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Knob {
    /// Dotted path of the key.
    pub key: &'static str,
    /// Values, as TOML.
    pub values: &'static [&'static str],
}

/// What trades accuracy for speed.
pub const KNOBS: &[Knob] = &[
    Knob { key: "fidelity.node_pulses", values: &["1", "4", "8", "12", "16"] },
    Knob { key: "fidelity.scatter_pulses", values: &["4", "6", "12"] },
    Knob { key: "fidelity.gain_pulses", values: &["1", "2", "4", "6"] },
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

/// What a fidelity is set to, by name.
pub fn settings(fidelity: &Fidelity) -> Map<String, Value> {
    let mut map = Map::new();
    let mut set = |name: &str, value: Value| map.insert(name.to_owned(), value);
    match fidelity {
        Fidelity::Reference => {
            set("echo", json!("reference"));
        }
        Fidelity::Fast { node_pulses, gain_pulses, scatter_pulses, settings } => {
            set("echo", json!("fast"));
            set("node_pulses", json!(node_pulses));
            set("gain_pulses", json!(gain_pulses));
            set("scatter_pulses", json!(scatter_pulses));
            set("kernel_width", json!(settings.width));
            set("oversampling", json!(settings.oversampling));
            let doppler = match settings.doppler {
                Doppler::Mean => "mean",
                Doppler::Shift => "shift",
                Doppler::Taylor => "taylor",
            };
            set("doppler", json!(doppler));
        }
    }
    map
}
