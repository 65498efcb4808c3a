//! Which changes make a run fit into real time on this machine: predicted from its measured speed, built, and
//! made for a moment.
//!
//! Kinds of change are tried one by one, then, of those that alone are not enough, two at a time. Of each set
//! of kinds the one with the least harm that is [predicted](super::fit::Model) to be enough is built, by the
//! scenario with these keys set, so that whatever refuses a scenario refuses it; then it is measured. Where
//! that falls short, or is far more than is wanted, the prediction of these kinds is corrected by it, once.

use std::fmt;
use std::thread;
use std::time::{Duration, Instant};

use super::fit::{
    self, Fit, HARM_OF_WARNING, Kind, Limit, Model, Remedy, Step, error_step, fastest, harm, least,
    new_warnings, overrides, patch_steps, shadow_steps, thread_steps,
};
use super::plan::not_kept;
use super::resources::Resources;
use super::sweep::{Overrides, Refused};
use crate::adequacy::adequacy_with_edge;
use crate::config::{ConfigError, Run};
use crate::echo::{Asked, Fidelity};
use crate::fidelity::budget::{EXACT_DB, Plan};
use crate::fidelity::choose::Chooser;
use crate::fidelity::cost::CostTable;
use crate::pipeline::build::{self, PulseStream};
use crate::pipeline::changing;
use crate::pipeline::fault::BuildErrors;
use crate::pulse::costs::Stage;
use crate::units::digits;

/// Errors that `check` asks for, dB: it gives a glance.
const GLANCE_DB: [f64; 3] = [-45.0, -30.0, fit::COARSEST_DB];
/// Settings of a set of kinds that are measured: where a prediction was off, one more.
const TRIES: usize = 2;
/// Times what is wanted from which on less change may do, and how much of that a second try leaves.
const AMPLE: f64 = 1.5;
const OF_AMPLE: f64 = 1.2;
/// Cores that are proposed, at most.
const MOST_CORES: f64 = 128.0;
/// Changes that are enough.
const MOST: usize = 5;

/// How a fit is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Times real time that are wanted.
    pub margin: f64,
    /// How long each change is measured; nothing but the run as written where that is zero.
    pub trial: Duration,
    /// Nothing new is tried after so long, or after twice as long where nothing is enough yet.
    pub limit: Duration,
}

/// Plans of a stream for other errors than its own.
struct Plans<'a> {
    stream: &'a PulseStream,
    asked: Asked,
    chooser: Option<Chooser<'a>>,
}

impl<'a> Plans<'a> {
    fn new(stream: &'a PulseStream, asked: Asked) -> Result<Self, BuildErrors> {
        let (generator, prepared) = (stream.factory().generator(), stream.prepared());
        let chooser = if generator.is_apart() {
            None
        } else {
            Some(Chooser::new(prepared.scene(), generator, prepared.waveform()?, &asked)?)
        };
        Ok(Self { stream, asked, chooser })
    }

    fn of(&mut self, error_db: f64) -> Result<Option<Plan>, BuildErrors> {
        let asked = Asked { error_db, ..self.asked };
        Ok(match &mut self.chooser {
            Some(chooser) => Some(chooser.choose(&asked)?),
            // Blocks of samples have a generator and a scene of their own.
            None => changing::factory_for(self.stream.prepared(), &Fidelity::Fast(asked))?.plan().copied(),
        })
    }
}

/// Threads of this machine.
fn machine_threads() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// A run whose speed is known, and the steps that come into question for it.
struct Outlook<'a> {
    plans: Plans<'a>,
    model: Model,
    steps: Vec<Step>,
}

impl<'a> Outlook<'a> {
    /// Without steps of the error; `None` of the reference.
    fn new(run: &Run, stream: &'a PulseStream, factor: f64) -> Result<Option<Self>, BuildErrors> {
        let (Fidelity::Fast(asked), Some(plan)) = (&run.fidelity, stream.factory().plan()) else {
            return Ok(None);
        };
        let mut steps: Vec<Step> = thread_steps(stream.threads(), machine_threads()).collect();
        if let Some(sea) = &run.scene.sea {
            steps.extend(sea.shadow.iter().flat_map(|shadow| shadow_steps(shadow.update_s)));
            steps.extend(patch_steps(&sea.patch));
        }
        let model = Model { factor, plan: *plan, plans: Vec::new() };
        Ok(Some(Self { plans: Plans::new(stream, *asked)?, model, steps }))
    }

    /// The error that is asked, dB.
    fn error_db(&self) -> f64 {
        self.plans.asked.error_db
    }

    /// Times real time with another error, which becomes a step; `None` where nothing is planned that keeps
    /// it.
    fn with_error(&mut self, error_db: f64) -> Result<Option<f64>, BuildErrors> {
        let Some(plan) = self.plans.of(error_db)?.filter(Plan::keeps) else { return Ok(None) };
        self.model.plans.push((error_db, plan));
        let step = error_step(self.error_db(), error_db);
        let factor = self.model.factor(&[&step]);
        self.steps.push(step);
        Ok(Some(factor))
    }

    /// The finest error of a ladder, from fine to coarse, with which the run is fast enough, found by asking
    /// for a few of them: coarser errors are faster.
    fn finest(&mut self, ladder: &[f64], wanted: f64) -> Result<Option<f64>, BuildErrors> {
        let (mut below, mut above) = (0, ladder.len());
        while below < above {
            let middle = (below + above) / 2;
            match self.with_error(ladder[middle])? {
                Some(factor) if factor >= wanted => above = middle,
                _ => below = middle + 1,
            }
        }
        Ok(ladder.get(above).copied())
    }

    /// Asks for what is left of a ladder.
    fn complete(&mut self, ladder: &[f64]) -> Result<(), BuildErrors> {
        for error_db in ladder {
            if !self.model.plans.iter().any(|(known_db, _)| known_db == error_db) {
                self.with_error(*error_db)?;
            }
        }
        Ok(())
    }

    /// The least steps of some kinds that are enough.
    fn least(&self, kinds: &[Kind], wanted: f64) -> Option<Vec<&Step>> {
        least(kinds, &self.steps, wanted, |steps| self.model.factor(steps))
    }
}

/// The answer of `check`, predicted from the speed that it has measured: the least change of the error, and
/// of the facets, that makes a run fit which does not, and the cores that would; empty of one that fits.
///
/// # Errors
/// A scene for whose errors nothing can be planned.
pub fn predicted(run: &Run, stream: &PulseStream, factor: f64) -> Result<Vec<Predicted>, BuildErrors> {
    let outlook = if factor < 1.0 { Outlook::new(run, stream, factor)? } else { None };
    let Some(mut outlook) = outlook else { return Ok(Vec::new()) };
    let ladder = GLANCE_DB.map(|error_db| error_db.max(outlook.error_db()));
    let coarser = ladder.partition_point(|error_db| *error_db <= outlook.error_db());
    outlook.finest(&ladder[coarser..], fit::MARGIN)?;
    let of_kind = |kind: &Kind| {
        let steps = outlook.least(&[*kind], fit::MARGIN)?;
        let (step, real_time_factor) = (*steps.first()?, outlook.model.factor(&steps));
        Some(Predicted { how: step.short.clone(), set: Some(assignment(&step.set)), real_time_factor })
    };
    let mut remedies: Vec<Predicted> = [Kind::Error, Kind::Facets].iter().filter_map(of_kind).collect();
    // Whether this machine has them or not: it says what would do.
    let cores = (stream.threads() as f64 * fit::MARGIN / factor).ceil();
    let real_time_factor = factor * cores / stream.threads() as f64;
    let set = (cores <= machine_threads() as f64).then(|| format!("stream.threads={cores}"));
    let on = Predicted { how: format!("on {cores} cores"), set, real_time_factor };
    remedies.extend((cores <= MOST_CORES).then_some(on));
    Ok(remedies)
}

/// A change that is predicted to be enough.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Predicted {
    /// How the run then is.
    pub how: String,
    /// `key=value`; none of more cores than this machine has.
    pub set: Option<String>,
    /// Times real time.
    pub real_time_factor: f64,
}

impl fmt::Display for Predicted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} times)", self.how, digits(self.real_time_factor))
    }
}

fn assignment((key, value): &(String, String)) -> String {
    format!("{key}={value}")
}

/// A run whose speed is known.
struct Measured {
    stream: PulseStream,
    resources: Resources,
    warnings: Vec<String>,
}

/// Builds a run and measures it, if for a time at all.
fn built(run: &Run, known: Option<&PulseStream>) -> Result<(PulseStream, Vec<String>), BuildErrors> {
    let pulses = 0..run.scene.pulses;
    let stream = match known {
        Some(known) => build::again(known.prepared(), run, pulses)?,
        None => build::on_nominal_tracks(run, pulses)?,
    };
    let mut warnings: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
    warnings.extend(adequacy_with_edge(&stream)?.into_iter().flat_map(|sea| sea.warnings));
    warnings.extend(stream.factory().plan().and_then(not_kept));
    Ok((stream, warnings))
}

fn measured(run: &Run, known: Option<&PulseStream>, trial: Duration) -> Result<Measured, BuildErrors> {
    let (stream, warnings) = built(run, known)?;
    let resources = stream.resources_over(&run.scene.radar, trial)?;
    Ok(Measured { stream, resources, warnings })
}

/// Looks for what makes a run fit. `load` makes a run of the scenario with some keys set; `progress` is
/// reported how many changes of how many are done.
///
/// # Errors
/// Where the scenario as written cannot be built.
pub fn search(
    written: &Run,
    asked: &Search,
    load: impl Fn(&Overrides) -> Result<Run, ConfigError>,
    progress: impl Fn(usize, usize),
) -> Result<Fit, BuildErrors> {
    let begun = Instant::now();
    let first = measured(written, None, asked.trial.max(super::resources::TRIAL))?;
    let factor = first.resources.real_time_factor;
    let mut found = Fit {
        real_time_factor: factor,
        margin: asked.margin,
        fits: factor >= asked.margin,
        threads: first.stream.threads(),
        error_db: error_db(written),
        ..Fit::default()
    };
    if found.fits {
        found.fits_at_db = finest(written, &first.stream, factor, asked.margin)?;
        return Ok(found);
    }
    let mut searcher = Searcher { asked, load, begun, known: &first, base: Vec::new(), found };
    if written.fidelity == Fidelity::Reference {
        return searcher.of_reference(progress);
    }
    searcher.look(written, &first.stream, factor, progress)?;
    Ok(searcher.found)
}

fn error_db(run: &Run) -> Option<f64> {
    if let Fidelity::Fast(asked) = &run.fidelity { Some(asked.error_db) } else { None }
}

/// The finest error with which a run is predicted to fit, if that is finer than its own.
fn finest(run: &Run, stream: &PulseStream, factor: f64, margin: f64) -> Result<Option<f64>, BuildErrors> {
    let Some(mut outlook) = Outlook::new(run, stream, factor)? else { return Ok(None) };
    let finer = fit::finer(outlook.error_db()).take_while(|error_db| *error_db > EXACT_DB);
    let mut ladder: Vec<f64> = finer.collect();
    ladder.reverse();
    outlook.finest(&ladder, margin)
}

/// What is known while changes are tried.
struct Searcher<'a, L> {
    asked: &'a Search,
    load: L,
    begun: Instant,
    /// The run as written.
    known: &'a Measured,
    /// What is set in every change.
    base: Overrides,
    found: Fit,
}

impl<L: Fn(&Overrides) -> Result<Run, ConfigError>> Searcher<'_, L> {
    /// The fast echo in place of the reference, and where that is not enough, changes of it.
    fn of_reference(mut self, progress: impl Fn(usize, usize)) -> Result<Fit, BuildErrors> {
        self.base = vec![("fidelity.echo".to_owned(), "fast".to_owned())];
        let run = match (self.load)(&self.base) {
            Ok(run) => run,
            Err(error) => {
                self.refuse(&self.base.clone(), error.to_string());
                return Ok(self.found);
            }
        };
        let fast = measured(&run, Some(&self.known.stream), self.asked.trial.max(super::resources::TRIAL))?;
        let factor = fast.resources.real_time_factor;
        let remedy = self.remedy(&[], (factor, Some(factor)), &fast.stream, &fast.warnings);
        if factor >= self.asked.margin {
            self.found.remedies.push(remedy);
        } else {
            self.found.missed(remedy);
            self.look(&run, &fast.stream, factor, progress)?;
        }
        Ok(self.found)
    }

    /// Tries every set of kinds.
    fn look(
        &mut self,
        run: &Run,
        stream: &PulseStream,
        factor: f64,
        progress: impl Fn(usize, usize),
    ) -> Result<(), BuildErrors> {
        let wanted = self.asked.margin;
        let Some(mut outlook) = Outlook::new(run, stream, factor)? else { return Ok(()) };
        outlook.finest(&fit::coarser(outlook.error_db()).collect::<Vec<_>>(), wanted)?;
        let sets = Kind::sets();
        let mut enough: Vec<Kind> = Vec::new();
        let order = |kinds: &Vec<Kind>| {
            (kinds.len(), outlook.least(kinds, wanted).map_or(f64::INFINITY, |steps| harm(&steps)))
        };
        let mut ordered: Vec<(_, &Vec<Kind>)> = sets.iter().map(|kinds| (order(kinds), kinds)).collect();
        ordered.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for (done, (_, kinds)) in ordered.iter().enumerate() {
            progress(done, ordered.len());
            // What is enough alone needs no other.
            let is_done = kinds.len() > 1 && kinds.iter().any(|kind| enough.contains(kind));
            if is_done || self.found.remedies.len() >= MOST {
                continue;
            }
            let more = if self.found.remedies.is_empty() { 2 } else { 1 };
            if self.begun.elapsed() > more * self.asked.limit {
                self.found.out_of_time = true;
                break;
            }
            if self.fits_by(kinds, &mut outlook)? && kinds.len() == 1 {
                enough.extend(kinds.iter());
            }
        }
        progress(ordered.len(), ordered.len());
        if self.found.remedies.is_empty() {
            self.miss(&sets, &outlook);
        }
        self.found.sort();
        Ok(())
    }

    /// Whether changes of some kinds are enough.
    fn fits_by(&mut self, kinds: &[Kind], outlook: &mut Outlook<'_>) -> Result<bool, BuildErrors> {
        let (mut wanted, mut enough) = (self.asked.margin, None::<(Remedy, f64)>);
        for tries in 0..TRIES {
            // The few errors that are known tell whether these kinds are enough, all of them the least.
            let all = kinds.contains(&Kind::Error) && kinds.len() + tries > 1;
            if all && outlook.least(kinds, wanted).is_some() {
                outlook.complete(&fit::coarser(outlook.error_db()).collect::<Vec<_>>())?;
            }
            let Some(steps) = outlook.least(kinds, wanted) else { break };
            let predicted = outlook.model.factor(&steps);
            // Not the same once more.
            if enough.as_ref().is_some_and(|(_, before)| harm(&steps) >= *before) {
                break;
            }
            let Some(remedy) = self.tried(&steps, predicted) else { break };
            let over = remedy.factor() / self.asked.margin;
            wanted = predicted / over.max(1e-9);
            if over < 1.0 {
                self.found.missed(remedy);
                continue;
            }
            enough = Some((remedy, harm(&steps)));
            if over < AMPLE || self.begun.elapsed() > self.asked.limit {
                break;
            }
            wanted *= OF_AMPLE;
        }
        let is_enough = enough.is_some();
        self.found.remedies.extend(enough.map(|(remedy, _)| remedy));
        Ok(is_enough)
    }

    /// Builds the run with some steps and measures it; `None` where it is refused.
    fn tried(&mut self, steps: &[&Step], predicted: f64) -> Option<Remedy> {
        let set: Overrides = self.base.iter().cloned().chain(overrides(steps)).collect();
        let made = (self.load)(&set).map_err(|error| error.to_string()).and_then(|run| {
            let (stream, warnings) =
                built(&run, Some(&self.known.stream)).map_err(|errors| errors.to_string())?;
            let factor = if self.asked.trial.is_zero() {
                None
            } else {
                let resources = stream.resources_over(&run.scene.radar, self.asked.trial);
                Some(resources.map_err(|error| error.to_string())?.real_time_factor)
            };
            Ok((stream, warnings, factor))
        });
        match made {
            Ok((stream, warnings, factor)) => {
                Some(self.remedy(steps, (predicted, factor), &stream, &warnings))
            }
            Err(why) => {
                self.refuse(&set, why);
                None
            }
        }
    }

    fn refuse(&mut self, set: &Overrides, why: String) {
        self.found.refused.push(Refused { change: super::sweep::name(set), why });
    }

    /// What is said of a change, with its speed, predicted and measured.
    fn remedy(
        &self,
        steps: &[&Step],
        (predicted_factor, real_time_factor): (f64, Option<f64>),
        stream: &PulseStream,
        warnings: &[String],
    ) -> Remedy {
        let warnings = new_warnings(warnings, &self.known.warnings);
        let predicted_rel_rms_db = stream.factory().plan().map(|plan| plan.prediction.total_db());
        let fast = (!self.base.is_empty()).then(|| "the fast echo in place of the reference".to_owned());
        Remedy {
            set: self.base.iter().chain(&overrides(steps)).map(assignment).collect(),
            costs: fast.into_iter().chain(steps.iter().map(|step| step.costs.clone())).collect(),
            harm: harm(steps) + HARM_OF_WARNING * warnings.len() as f64,
            warnings,
            predicted_factor,
            real_time_factor,
            predicted_rel_rms_db,
        }
    }

    /// What comes nearest where nothing is enough, and what it is that is not.
    fn miss(&mut self, sets: &[Vec<Kind>], Outlook { steps, model, .. }: &Outlook<'_>) {
        let Some(fastest) = fastest(sets, steps, |steps| model.factor(steps)) else { return };
        let predicted = model.factor(&fastest);
        if self.found.nearest.as_ref().is_none_or(|nearest| nearest.factor() < predicted)
            && let Some(remedy) = self.tried(&fastest, predicted)
        {
            if remedy.factor() >= self.asked.margin {
                return self.found.remedies.push(remedy);
            }
            self.found.missed(remedy);
        }
        let work = model.work(&fastest);
        let seconds = |stage: Stage| CostTable::TABLE.stage_seconds(&work, stage);
        let most = Stage::ALL.into_iter().max_by(|a, b| seconds(*a).total_cmp(&seconds(*b)));
        let share = |stage| seconds(stage) / CostTable::TABLE.seconds(&work);
        self.found.limit = most.map(|stage| Limit { stage: stage.name(), share: share(stage) });
    }
}
