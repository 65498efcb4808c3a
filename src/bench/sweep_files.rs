//! A sweep as files: a table, and a picture of error over speed.

use std::fmt::Write as _;

use serde_json::Value;

use super::settings::SETTINGS;
use super::sweep::{Point, Sweep};
use crate::plot::canvas::Canvas;
use crate::plot::chart::{Curve, Mark, Plot, PlotAxis, PlotError, Spacing};

/// A setting of a point, as a word.
fn setting(point: &Point, name: &str) -> String {
    match point.settings.get(name) {
        Some(Value::String(word)) => word.clone(),
        Some(value) => value.to_string(),
        None => String::new(),
    }
}

/// The table. Its first word must stay the first: by it the file is recognised.
pub fn csv(sweep: &Sweep, taken: Option<&Point>) -> String {
    let names: Vec<&String> =
        sweep.points.first().map_or(Vec::new(), |point| point.settings.keys().collect());
    let mut csv = "setting".to_owned();
    for name in &names {
        let _ = write!(csv, ",{name}");
    }
    csv += ",rel_rms_db,rel_rms_db_mean,pulses_per_s,facet_pulses_per_s,real_time_factor,predicted_rel_rms_db,on_front,taken\n";
    for point in &sweep.points {
        let _ = write!(csv, "{}", point.change);
        for name in &names {
            let _ = write!(csv, ",{}", setting(point, name));
        }
        let _ = writeln!(
            csv,
            ",{:.3},{:.3},{:.6e},{:.6e},{:.6e},{},{},{}",
            point.rel_rms_db,
            point.rel_rms_db_mean,
            point.pulses_per_s,
            point.facet_pulses_per_s,
            point.real_time_factor,
            point.predicted_rel_rms_db.map_or(String::new(), |db| format!("{db:.3}")),
            point.on_front,
            taken.is_some_and(|taken| std::ptr::eq(taken, point))
        );
    }
    csv
}

/// Error over speed: a colour for each setting, a line through what nothing beats.
///
/// # Errors
/// Figures that cannot be drawn.
pub fn picture(scenario: &str, sweep: &Sweep, error_db: f64) -> Result<Canvas, PlotError> {
    let at = |point: &Point| [point.real_time_factor, 10f64.powf(0.1 * point.rel_rms_db)];
    let of = |key: &str| -> Vec<[f64; 2]> {
        let its = |point: &&Point| point.change.starts_with(key);
        sweep.points.iter().filter(its).map(at).collect()
    };
    let mut front: Vec<[f64; 2]> = sweep.points.iter().filter(|point| point.on_front).map(at).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let slow_fast = sweep
        .points
        .iter()
        .map(|point| point.real_time_factor)
        .fold([f64::INFINITY, 0.0], |[low, high], x| [low.min(x), high.max(x)]);
    let wanted = slow_fast.map(|speed| [speed, 10f64.powf(0.1 * error_db)]);
    let mut named = vec![("wanted", wanted.to_vec(), Mark::Line), ("front", front, Mark::Line)];
    named.push(("as written", of("as written"), Mark::Dots));
    for setting in SETTINGS {
        let name = setting.key.rsplit('.').next().unwrap_or(setting.key);
        named.push((name, of(setting.key), Mark::Dots));
    }
    let curves: Vec<Curve> =
        named.iter().map(|(name, points, mark)| Curve { name, points, mark: *mark }).collect();
    Plot {
        title: &format!("Error against speed, {scenario}"),
        x: PlotAxis { label: "times real time", spacing: Spacing::Logarithmic, limits: None },
        y: PlotAxis { label: "error, worst pulse, dB", spacing: Spacing::Decibels, limits: None },
        curves: &curves,
        size_px: [720, 480],
    }
    .draw()
}
