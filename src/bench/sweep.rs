//! Error and speed over the settings of `[fidelity]`, on one run.
//!
//! The pulses of the reference are made once ([`Judge`]); each setting is built, its error found at the same
//! pulses, and its speed by a trial with all threads, without noise and recording. Pulses are
//! drawn for the blocks of the settings as written; other blocks have them at other places.
//!
//! A choice of the model is no error: it is compared with the model as written, both with the echo as
//! written, and listed apart ([`effect`]). What is nearer than the error of that echo is not resolved.

use std::time::Duration;

use num_complex::Complex32;
use serde::Serialize;
use serde_json::{Map, Value};

use super::accuracy::Judge;
use crate::bench::settings::{ERROR_KEY, MODELS, SETTINGS, Setting, settings};
use crate::config::{ConfigError, Run};
use crate::echo::Fidelity;
use crate::fidelity::echo_settings::EchoSettings;
use crate::fidelity::sidelobe::NONE_DB;
use crate::pipeline::fault::BuildErrors;

/// Keys and values to be set on top of a scenario.
pub type Overrides = Vec<(String, String)>;

/// One setting, measured.
#[derive(Clone, Debug, Serialize)]
pub struct Point {
    /// What was changed, `key=value`; "as written" where nothing was.
    pub change: String,
    /// What is set.
    pub settings: Map<String, Value>,
    /// Error of the worst pulse and channel, dB.
    pub rel_rms_db: f64,
    /// Mean error, dB.
    pub rel_rms_db_mean: f64,
    /// Pulses per second.
    pub pulses_per_s: f64,
    /// Facets of the whole patch times that.
    pub facet_pulses_per_s: f64,
    /// Pulses per second over those needed.
    pub real_time_factor: f64,
    /// What was predicted, dB; `None` for the reference.
    pub predicted_rel_rms_db: Option<f64>,
    /// Whether no other setting is both faster and better.
    pub on_front: bool,
}

/// What a choice of the model changes.
#[derive(Clone, Debug, Serialize)]
pub struct Effect {
    /// What was changed.
    pub change: String,
    /// Difference from the scenario as written, worst pulse and channel, dB.
    pub difference_db: f64,
    /// Its mean, dB.
    pub difference_db_mean: f64,
}

/// Something to be tried that the scenario does not allow.
#[derive(Clone, Debug, Serialize)]
pub struct Refused {
    /// What was changed.
    pub change: String,
    /// Why not.
    pub why: String,
}

fn changed(setting: &Setting, value: &str) -> (String, String) {
    (setting.key.to_owned(), value.to_owned())
}

/// What to try: each setting by itself, or all their combinations. The first one changes nothing.
pub fn trials(grid: bool) -> Vec<Overrides> {
    let mut trials = vec![Vec::new()];
    if grid {
        // An requested error decides nothing where all settings are given.
        for setting in SETTINGS.iter().filter(|setting| setting.key != ERROR_KEY) {
            trials = trials
                .iter()
                .flat_map(|before: &Overrides| {
                    let more =
                        |value: &&str| before.iter().cloned().chain([changed(setting, value)]).collect();
                    setting.values.iter().map(more).collect::<Vec<_>>()
                })
                .collect();
        }
        trials.insert(0, Vec::new());
    } else {
        for setting in SETTINGS {
            trials.extend(setting.values.iter().map(|value| vec![changed(setting, value)]));
        }
    }
    trials
}

/// What to try of the model.
pub fn models() -> Vec<Overrides> {
    MODELS
        .iter()
        .flat_map(|setting| setting.values.iter().map(|value| vec![changed(setting, value)]))
        .collect()
}

/// The name of a change.
pub fn name(change: &Overrides) -> String {
    let words: Vec<String> = change.iter().map(|(key, value)| format!("{key}={value}")).collect();
    if words.is_empty() { "as written".to_owned() } else { words.join(" ") }
}

/// Measures one setting, its speed for a `trial`; `None` of one that is among those known.
///
/// # Errors
/// A setting with which the run cannot be built, or a pulse that cannot be made.
pub fn point(
    judge: &Judge,
    run: &Run,
    change: &Overrides,
    trial: Duration,
    known: &[Point],
) -> Result<Option<Point>, BuildErrors> {
    let stream = judge.stream(run)?;
    let plan = stream.factory().plan();
    let settings = settings(plan.map(|plan| &plan.chosen));
    if known.iter().any(|point| point.settings == settings) {
        return Ok(None);
    }
    let accuracy = judge.accuracy(&judge.make(stream.factory())?);
    let resources = stream.resources_over(&run.scene.radar, trial)?;
    Ok(Some(Point {
        change: name(change),
        settings,
        rel_rms_db: accuracy.rel_rms_db,
        rel_rms_db_mean: accuracy.rel_rms_db_mean,
        pulses_per_s: resources.pulses_per_s,
        facet_pulses_per_s: resources.pulses_per_s * stream.factory().facets() as f64,
        real_time_factor: resources.real_time_factor,
        predicted_rel_rms_db: plan.map(|plan| plan.prediction.total_db()),
        on_front: false,
    }))
}

/// The run with the settings that it leaves open set as they were chosen for another: so one setting changes
/// at a time.
fn filled(mut run: Run, chosen: &EchoSettings) -> Run {
    if let Fidelity::Fast(asked) = &mut run.fidelity {
        asked.node_pulses.get_or_insert(chosen.node_pulses);
        asked.scatter_pulses.get_or_insert(chosen.scatter_pulses());
        asked.gain_pulses.get_or_insert(chosen.gain_pulses);
        asked.panel_pulses = asked.panel_pulses.or(chosen.panel_pulses);
        asked.sidelobe_db.get_or_insert(chosen.sidelobe.map_or(NONE_DB, |sidelobe| sidelobe.below_db));
        asked.cutoff_db.get_or_insert(chosen.cutoff_db().unwrap_or(NONE_DB));
        asked.kernel_width.get_or_insert(chosen.echo.width);
        asked.doppler.get_or_insert(chosen.echo.doppler);
    }
    run
}

/// Marks the points that no other one beats in both speed and error. Of equals the first one stays.
pub fn mark_front(points: &mut [Point]) {
    let figures: Vec<(f64, f64)> = points.iter().map(|p| (p.real_time_factor, p.rel_rms_db)).collect();
    for (place, point) in points.iter_mut().enumerate() {
        let (speed, error_db) = figures[place];
        point.on_front = !figures.iter().enumerate().any(|(other, &(s, e))| {
            let better = s > speed || e < error_db || other < place;
            other != place && s >= speed && e <= error_db && better
        });
    }
}

/// The fastest setting whose error is at most what is wanted, as predicted for the whole run and as measured
/// at some of its pulses; `None` where none is.
pub fn taken(points: &[Point], error_db: f64) -> Option<&Point> {
    let promised = |point: &&Point| point.predicted_rel_rms_db.is_none_or(|predicted| predicted <= error_db);
    let kept = points.iter().filter(|point| point.rel_rms_db <= error_db).filter(promised);
    kept.max_by(|a, b| a.real_time_factor.total_cmp(&b.real_time_factor))
}

/// Samples of the sampled pulses as a run's own echo makes them.
pub struct Written(Vec<Vec<Complex32>>);

/// The scenario as written, to compare models with.
///
/// # Errors
/// A run that cannot be built, or a pulse that cannot be made.
pub fn written(judge: &Judge, run: &Run) -> Result<Written, BuildErrors> {
    let stream = judge.stream(run)?;
    Ok(Written(judge.make(stream.factory())?))
}

/// How far a run is from the scenario as written.
///
/// # Errors
/// A run that cannot be built, or a pulse that cannot be made.
pub fn effect(
    judge: &Judge,
    written: &Written,
    run: &Run,
    change: &Overrides,
) -> Result<Effect, BuildErrors> {
    let stream = judge.stream(run)?;
    let apart = judge.apart(&judge.make(stream.factory())?, &written.0);
    Ok(Effect {
        change: name(change),
        difference_db: apart.rel_rms_db,
        difference_db_mean: apart.rel_rms_db_mean,
    })
}

/// Everything that a sweep finds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Sweep {
    /// Settings, the one as written first.
    pub points: Vec<Point>,
    /// Choices of the model, apart from the one as written.
    pub models: Vec<Effect>,
    /// What could not be tried.
    pub refused: Vec<Refused>,
}

/// Sweeps settings and models, the speed of each measured for a `trial`. `load` makes a run of the scenario
/// with some keys set; `progress` is reported how many of how many are done, and what is found so far (which
/// of it is on the front is known at the end).
/// Settings and models that come to what is written already are left out.
///
/// # Errors
/// Where the scenario as written cannot be built.
pub fn sweep(
    judge: &Judge,
    written_run: &Run,
    trial: Duration,
    grid: bool,
    load: impl Fn(&Overrides) -> Result<Run, ConfigError>,
    mut progress: impl FnMut(usize, usize, &Sweep),
) -> Result<Sweep, BuildErrors> {
    let (trials, models) = (trials(grid), models());
    let all = trials.len() + models.len();
    let mut sweep = Sweep::default();
    let chosen = judge.stream(written_run)?.factory().plan().map(|plan| plan.chosen);
    for (done, change) in trials.iter().enumerate() {
        progress(done, all, &sweep);
        let open = change.iter().all(|(key, _)| key == ERROR_KEY);
        let run = if change.is_empty() { Ok(written_run.clone()) } else { load(change) };
        let measured = match run {
            Ok(run) => {
                let run = match &chosen {
                    Some(chosen) if !open => filled(run, chosen),
                    _ => run,
                };
                point(judge, &run, change, trial, &sweep.points).map_err(|errors| errors.to_string())
            }
            Err(error) => Err(error.to_string()),
        };
        match measured {
            Ok(point) => sweep.points.extend(point),
            Err(why) => sweep.refused.push(Refused { change: name(change), why }),
        }
    }
    mark_front(&mut sweep.points);
    let base = written(judge, written_run)?;
    for (done, change) in models.iter().enumerate() {
        progress(trials.len() + done, all, &sweep);
        // A scene without sea refuses them: it has no such choice.
        let Ok(run) = load(change) else { continue };
        if run.scene.sea == written_run.scene.sea {
            continue;
        }
        match effect(judge, &base, &run, change) {
            Ok(effect) => sweep.models.push(effect),
            Err(errors) => {
                sweep.refused.push(Refused { change: name(change), why: errors.to_string() });
            }
        }
    }
    progress(all, all, &sweep);
    Ok(sweep)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(real_time_factor: f64, rel_rms_db: f64) -> Point {
        Point {
            change: String::new(),
            settings: Map::new(),
            rel_rms_db,
            rel_rms_db_mean: rel_rms_db,
            pulses_per_s: real_time_factor,
            facet_pulses_per_s: real_time_factor,
            real_time_factor,
            predicted_rel_rms_db: None,
            on_front: false,
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let mut points =
            [at(1.0, -80.0), at(2.0, -60.0), at(1.5, -60.0), at(3.0, -40.0), at(1.0, -80.0), at(0.5, -70.0)];
        mark_front(&mut points);
        let front: Vec<bool> = points.iter().map(|point| point.on_front).collect();
        assert_eq!(front, [true, true, false, true, false, false]);
        assert_eq!(taken(&points, -60.0).unwrap().real_time_factor, 2.0);
        assert_eq!(taken(&points, -61.0).unwrap().real_time_factor, 1.0);
        assert!(taken(&points, -90.0).is_none());
        // Measured at a few pulses, and not promised for the others.
        points[1].predicted_rel_rms_db = Some(-59.0);
        points[2].predicted_rel_rms_db = Some(-61.0);
        assert_eq!(taken(&points, -60.0).unwrap().real_time_factor, 1.5);
    }

    #[test]
    fn a_grid_has_every_combination_once() {
        let one_by_one = trials(false);
        let values: usize = SETTINGS.iter().map(|setting| setting.values.len()).sum();
        assert_eq!(one_by_one.len(), 1 + values);
        let grid = trials(true);
        let product: usize = SETTINGS
            .iter()
            .filter(|setting| setting.key != ERROR_KEY)
            .map(|setting| setting.values.len())
            .product();
        assert_eq!(grid.len(), 1 + product);
        let names: std::collections::BTreeSet<String> = grid.iter().map(name).collect();
        assert_eq!(names.len(), grid.len());
        assert_eq!(name(&grid[0]), "as written");
    }
}
