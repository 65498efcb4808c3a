//! What is planned for an error, in figures and in words.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::adequacy::description::{Described, described};
use crate::bench::settings;
use crate::config::keys;
use crate::fidelity::Prediction;
use crate::fidelity::budget::Plan;
use crate::paths::MOST_RECEIVED;
use crate::pipeline::memory::Predicted;
use crate::pipeline::stages::PulseFactory;
use crate::units::{counted, digits};

const MIB: f64 = (1 << 20) as f64;

/// A plan in figures; all of it predicted.
#[derive(Debug, Serialize)]
pub struct PlanReport {
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
    /// Why pulses are made one by one, where they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    one_by_one: Option<String>,
    /// By the costs of a reference machine, the same on every machine; settings are compared by it.
    predicted_real_time_factor: f64,
    /// With every queue full, and while sinks keep up.
    predicted_rss_mib: f64,
    predicted_rss_kept_up_mib: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    emitters: Vec<EmitterReport>,
}

/// What is planned for an emitter.
#[derive(Debug, Serialize)]
struct EmitterReport {
    name: String,
    /// Share of the pulses that receive it, of the receiver that fewest reach, about.
    share_of_pulses: f64,
    node_pulses: u64,
    predicted_rel_rms_db: f64,
}

impl EmitterReport {
    fn row(&self) -> Described {
        let Self { name, share_of_pulses, node_pulses, predicted_rel_rms_db } = self;
        let share = 100.0 * share_of_pulses;
        let how = match node_pulses {
            0 | 1 => "pulse by pulse".to_owned(),
            _ => format!("nodes {node_pulses} of its own pulses apart"),
        };
        described(
            "emitter",
            format!(
                "{name}: it reaches {share:.0} % of the windows, {how}, {predicted_rel_rms_db:.1} dB predicted"
            ),
        )
    }
}

/// What was made before a run.
#[derive(Debug, Serialize)]
struct DryRunReport {
    pulses: u64,
    all: bool,
    tries: u32,
}

/// What the dry run found above the sum of the parts, next to the names of these.
const BY_DRY_RUN: &str = "dry_run";

/// Parts of a predicted error, dB; what is none is left out. A dry run that found less than their sum stands
/// for itself.
pub fn parts_db(prediction: &Prediction) -> Map<String, Value> {
    let found = prediction.dry_run.map_or(0.0, |run| run.error - prediction.modelled());
    let others = [(BY_DRY_RUN, found), ("emitters", prediction.emitters)];
    let parts = prediction.parts().into_iter().chain(others).filter(|(_, part)| *part > 0.0);
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

/// What to say where the requested error is not kept.
pub fn not_kept(plan: &Plan) -> Option<String> {
    let (asked_db, predicted_db) = (plan.asked.error_db, plan.prediction.total_db());
    if plan.keeps() {
        return None;
    }
    let asked = &plan.asked;
    let given: Vec<&str> = [
        ("node_pulses", asked.node_pulses.is_some()),
        ("scatter_pulses", asked.scatter_pulses.is_some()),
        ("gain_pulses", asked.gain_pulses.is_some()),
        ("panel_pulses", asked.panel_pulses.is_some()),
        ("sidelobe_db", asked.sidelobe_db.is_some()),
        ("cutoff_db", asked.cutoff_db.is_some()),
        ("kernel_width", asked.kernel_width.is_some()),
        ("doppler", asked.doppler.is_some()),
    ]
    .into_iter()
    .filter_map(|(name, given)| given.then_some(name))
    .collect();
    let with = match &given[..] {
        [] => "in this scene".to_owned(),
        keys => format!("with the [fidelity] keys set in this file ({})", keys.join(", ")),
    };
    Some(format!("{asked_db} dB cannot be reached {with}; best {predicted_db:.1} dB"))
}

/// Why no pulses have nodes in common.
fn one_by_one(plan: &Plan) -> Option<String> {
    let received = plan.size.emissions_received();
    if plan.chosen.node_pulses > 1 {
        None
    } else if plan.asked.node_pulses.is_some() {
        Some("node_pulses is 1".to_owned())
    } else if received > MOST_RECEIVED {
        Some(format!(
            "a window receives up to {received} emissions, those of a block {MOST_RECEIVED} at most"
        ))
    } else {
        Some(format!("no nodes keep {} dB", plan.asked.error_db))
    }
}

/// What the fast echo keeps of the reference, as predicted.
pub fn echo_text(plan: &Plan) -> String {
    let (asked_db, predicted_db) = (plan.asked.error_db, plan.prediction.total_db());
    format!(
        "fast: error against the reference {predicted_db:.1} dB predicted, {asked_db} dB requested; settings below"
    )
}

impl PlanReport {
    pub fn new(plan: &Plan, factory: &PulseFactory, real_time_factor: f64, bytes: Predicted) -> Self {
        let emitters = factory.others().filter_map(|(name, share_of_pulses, plan)| {
            let (name, plan) = (name.to_owned(), plan?);
            let predicted_rel_rms_db = plan.prediction.total_db();
            let node_pulses = plan.chosen.node_pulses;
            Some(EmitterReport { name, share_of_pulses, node_pulses, predicted_rel_rms_db })
        });
        Self {
            emitters: emitters.collect(),
            error_db: plan.asked.error_db,
            settings: settings::settings(Some(&plan.chosen)),
            asked: set_otherwise(plan),
            predicted_rel_rms_db: plan.prediction.total_db(),
            predicted_error_db: parts_db(&plan.prediction),
            dry_run: plan.prediction.dry_run.map(|run| DryRunReport {
                pulses: run.pulses,
                all: run.all,
                tries: run.tries,
            }),
            one_by_one: one_by_one(plan),
            predicted_real_time_factor: real_time_factor,
            predicted_rss_mib: bytes.at_most as f64 / MIB,
            predicted_rss_kept_up_mib: bytes.kept_up as f64 / MIB,
        }
    }

    /// The error that is asked, dB.
    pub fn error_db(&self) -> f64 {
        self.error_db
    }

    pub fn rows(&self) -> Vec<Described> {
        let parts = self.predicted_error_db.iter().filter_map(|(name, db)| Some((name, db.as_f64()?)));
        let name_of = |name: &str| if name == BY_DRY_RUN { "found by the dry run" } else { name }.to_owned();
        let parts: Vec<String> = parts.map(|(name, db)| format!("{} {db:.0}", name_of(name))).collect();
        // What can be written into a scenario, and what comes of it.
        let is_key = |name: &str| keys::fidelity::TABLE.keys.iter().any(|key| key.name == name);
        let (given, derived): (Map<_, _>, Map<_, _>) =
            self.settings.clone().into_iter().partition(|(name, _)| is_key(name));
        let mut rows = vec![
            described("settings", format!("{} (keys of [fidelity])", settings_text(&given))),
            described("derived", settings_text(&derived)),
        ];
        let rounded = self.asked.iter().map(|(name, asked)| {
            let set = self.settings.get(name).unwrap_or(&Value::Null);
            let why = match name.as_str() {
                "node_pulses" => " (blocks divide the pulses for which a patch that follows stays)",
                "scatter_pulses" => " (it is node_pulses, or about half or a third of it)",
                _ => "",
            };
            format!("{name} {set}, requested {asked}{why}")
        });
        let rounded: Vec<String> = rounded.collect();
        if !rounded.is_empty() {
            rows.push(described("rounded", rounded.join("; ")));
        }
        let why = self.one_by_one.iter().map(|why| described("pulse by pulse", why.clone()));
        rows.extend(why);
        let tried = self.dry_run.as_ref().map(|run| {
            let of = if run.all { "all " } else { "" };
            let settings =
                if run.tries > 1 { format!(", {} settings tried", run.tries) } else { String::new() };
            described("dry run", format!("{of}{}{settings}", counted(run.pulses, "pulse")))
        });
        rows.push(described(
            "error",
            format!("{:.1} dB predicted, {} dB requested", self.predicted_rel_rms_db, self.error_db),
        ));
        let sum: f64 =
            self.predicted_error_db.values().filter_map(Value::as_f64).map(|db| 10f64.powf(db / 10.0)).sum();
        // Parts are rounded to a decibel: what rounding alone makes is no difference.
        let less = 10.0 * sum.log10() - self.predicted_rel_rms_db > 0.5;
        let less = if less { "; the dry run found less than their sum" } else { "" };
        rows.push(described("by cause", format!("{} dB{less}", parts.join(", "))));
        rows.extend(tried);
        rows.extend(self.emitters.iter().map(EmitterReport::row));
        rows.extend([
            described(
                "reference speed",
                format!(
                    "{} times real time on a reference machine (cost model); the forecast is measured on this machine",
                    digits(self.predicted_real_time_factor)
                ),
            ),
            described("memory", self.memory()),
        ]);
        rows
    }

    fn memory(&self) -> String {
        let [most, kept_up] = [self.predicted_rss_mib, self.predicted_rss_kept_up_mib].map(f64::round);
        let full = if most > kept_up {
            format!(", {most} with the queues of all sinks full")
        } else {
            String::new()
        };
        format!("up to {kept_up} MiB resident{full}")
    }
}

/// `name = value` of every setting.
pub fn settings_text(settings: &Map<String, Value>) -> String {
    let one = |(name, value): (&String, &Value)| match value {
        Value::String(word) => format!("{name} {word}"),
        value => format!("{name} {value}"),
    };
    settings.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fidelity::DryRun;

    /// Before: of -56.2 dB the largest part that was printed was -69 dB.
    #[test]
    fn what_the_dry_run_finds_above_the_parts_has_a_name() {
        let found = |error| DryRun { pulses: 17, all: false, tries: 2, error };
        let with = |dry_run| Prediction { path: 1e-7, tilt: 2e-8, dry_run, ..Prediction::default() };
        let sum_db = |parts: &Map<String, Value>| {
            let powers = parts.values().map(|db| 10f64.powf(db.as_f64().unwrap() / 10.0));
            10.0 * powers.sum::<f64>().log10()
        };
        let more = with(Some(found(2.4e-6)));
        let parts = parts_db(&more);
        assert!(parts.contains_key(BY_DRY_RUN), "{parts:?}");
        assert!((sum_db(&parts) - more.total_db()).abs() < 1e-9, "{parts:?}");
        for other in [None, Some(found(5e-8))] {
            assert_eq!(parts_db(&with(other)).keys().collect::<Vec<_>>(), ["path", "tilt"]);
        }
    }
}
