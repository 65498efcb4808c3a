//! What was planned, as rows.

use serde::Serialize;
use serde_json::{Map, Value};

use super::{Described, described, digits};
use crate::bench::settings;
use crate::cli::counted;
use crate::config::keys;
use crate::fidelity::budget::Plan;

/// A plan in figures; all of it predicted.
#[derive(Debug, Serialize)]
pub(super) struct PlanReport {
    error_db: f64,
    settings: Map<String, Value>,
    /// What was given of the settings and is set otherwise.
    #[serde(skip_serializing_if = "Map::is_empty")]
    asked: Map<String, Value>,
    predicted_rel_rms_db: f64,
    /// By cause, dB.
    predicted_error_db: Map<String, Value>,
    /// Pulses that were made to find that out, and how many settings were tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    dry_run: Option<DryRunReport>,
    /// By the prices of a common machine.
    predicted_real_time_factor: f64,
    predicted_rss_mib: f64,
}

/// What was made before a run.
#[derive(Debug, Serialize)]
struct DryRunReport {
    pulses: u64,
    all: bool,
    tries: u32,
}

/// Parts of a predicted error, dB; what is none is left out.
pub(in crate::cli) fn parts_db(plan: &Plan) -> Map<String, Value> {
    let parts = plan.prediction.parts().into_iter().filter(|(_, part)| *part > 0.0);
    parts.map(|(name, part)| (name.to_owned(), Value::from(10.0 * part.log10()))).collect()
}

/// Settings that were given and are set otherwise, as given: instants lie where a block has room for them.
fn set_otherwise(plan: &Plan) -> Map<String, Value> {
    let (asked, chosen) = (&plan.asked, &plan.chosen);
    let pulses = [
        ("node_pulses", asked.node_pulses, chosen.node_pulses),
        ("gain_pulses", asked.gain_pulses, chosen.gain_pulses),
        ("scatter_pulses", asked.scatter_pulses, chosen.scatter_pulses()),
    ];
    let other =
        pulses.into_iter().filter_map(|(name, asked, set)| Some((name, asked.filter(|n| *n != set)?)));
    other.map(|(name, asked)| (name.to_owned(), Value::from(asked))).collect()
}

/// What to say where the error that is asked is not kept.
pub(in crate::cli) fn not_kept(asked_db: f64, predicted_db: f64) -> Option<String> {
    (predicted_db > asked_db).then(|| {
        format!(
            "an error of {asked_db} dB is asked, {predicted_db:.1} dB are predicted: what the knobs of [fidelity] leave open does not allow less"
        )
    })
}

impl PlanReport {
    pub(super) fn new(plan: &Plan, real_time_factor: f64, bytes: u64) -> Self {
        Self {
            error_db: plan.asked.error_db,
            settings: settings::settings(Some(&plan.chosen)),
            asked: set_otherwise(plan),
            predicted_rel_rms_db: plan.prediction.total_db(),
            predicted_error_db: parts_db(plan),
            dry_run: plan.prediction.dry_run.map(|run| DryRunReport {
                pulses: run.pulses,
                all: run.all,
                tries: run.tries,
            }),
            predicted_real_time_factor: real_time_factor,
            predicted_rss_mib: bytes as f64 / f64::from(1 << 20),
        }
    }

    /// What to say where the error is not kept.
    pub(super) fn warning(&self) -> Option<String> {
        not_kept(self.error_db, self.predicted_rel_rms_db)
    }

    pub(super) fn rows(&self) -> Vec<Described> {
        let parts = self.predicted_error_db.iter().filter_map(|(name, db)| Some((name, db.as_f64()?)));
        let parts: Vec<String> = parts.map(|(name, db)| format!("{name} {db:.0}")).collect();
        // What can be written into a scenario, and what comes of it.
        let is_key = |name: &str| keys::fidelity::TABLE.keys.iter().any(|key| key.name == name);
        let (given, follow): (Map<_, _>, Map<_, _>) =
            self.settings.clone().into_iter().partition(|(name, _)| is_key(name));
        let mut rows = vec![
            described("settings", format!("{} (keys of [fidelity])", settings_text(&given))),
            described(
                "follow",
                format!("{} (no keys: they follow from the settings)", settings_text(&follow)),
            ),
        ];
        let rounded = self.asked.iter().map(|(name, asked)| {
            let set = self.settings.get(name).unwrap_or(&Value::Null);
            let why = match name.as_str() {
                "node_pulses" => " (blocks divide the pulses for which a patch that follows stays)",
                "scatter_pulses" => " (it is node_pulses, or about half or a third of it)",
                _ => "",
            };
            format!("{name} {set}, asked {asked}{why}")
        });
        let rounded: Vec<String> = rounded.collect();
        if !rounded.is_empty() {
            rows.push(described("rounded", rounded.join("; ")));
        }
        let tried = self.dry_run.as_ref().map(|run| {
            let of = if run.all { "all " } else { "" };
            let settings =
                if run.tries > 1 { format!(", {} settings tried", run.tries) } else { String::new() };
            described("dry run", format!("{of}{}{settings}", counted(run.pulses, "pulse")))
        });
        rows.push(described(
            "error",
            format!("{:.1} dB, asked {} dB", self.predicted_rel_rms_db, self.error_db),
        ));
        rows.push(described("by cause", format!("{} dB, as the plan expects", parts.join(", "))));
        rows.extend(tried);
        rows.extend([
            described(
                "speed",
                format!("{} times real time by the price list", digits(self.predicted_real_time_factor)),
            ),
            described("memory", format!("{:.0} MiB resident", self.predicted_rss_mib)),
        ]);
        rows
    }
}

/// `name = value` of every setting.
pub(in crate::cli) fn settings_text(settings: &Map<String, Value>) -> String {
    let one = |(name, value): (&String, &Value)| match value {
        Value::String(word) => format!("{name} {word}"),
        value => format!("{name} {value}"),
    };
    settings.iter().map(one).collect::<Vec<_>>().join(", ")
}
