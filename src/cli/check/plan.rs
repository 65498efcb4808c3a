//! What was planned, as rows.

use serde::Serialize;
use serde_json::{Map, Value};

use super::{Described, described, digits};
use crate::cli::bench::settings_text;
use crate::pipeline::knobs;
use crate::plan::settle::Plan;

/// A plan in figures; all of it predicted.
#[derive(Debug, Serialize)]
pub(super) struct PlanReport {
    error_db: f64,
    settings: Map<String, Value>,
    predicted_rel_rms_db: f64,
    /// By cause, dB.
    predicted_error_db: Map<String, Value>,
    /// By the prices of a common machine.
    predicted_real_time_factor: f64,
    predicted_rss_mib: f64,
}

/// Parts of a predicted error, dB; what is none is left out.
pub(in crate::cli) fn parts_db(plan: &Plan) -> Map<String, Value> {
    let parts = plan.prediction.parts().into_iter().filter(|(_, part)| *part > 0.0);
    parts.map(|(name, part)| (name.to_owned(), Value::from(10.0 * part.log10()))).collect()
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
            settings: knobs::settings(Some(&plan.settled)),
            predicted_rel_rms_db: plan.prediction.total_db(),
            predicted_error_db: parts_db(plan),
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
        vec![
            described("settings", settings_text(&self.settings)),
            described("error", format!("{:.1} dB, asked {} dB", self.predicted_rel_rms_db, self.error_db)),
            described("by cause", format!("{} dB", parts.join(", "))),
            described(
                "speed",
                format!("{} times real time by the price list", digits(self.predicted_real_time_factor)),
            ),
            described("memory", format!("{:.0} MiB resident", self.predicted_rss_mib)),
        ]
    }
}
