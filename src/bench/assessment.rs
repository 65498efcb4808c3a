//! Assesses a run without emitting a pulse: models, adequacy, settings, predicted speed and memory.

use super::fit_trials::{Predicted, predicted};
use super::plan::{PlanReport, echo_text, not_kept};
use super::resources::Resources;
use crate::adequacy::description::{Described, ECHO, FAR_SEA, LAND, Models, RAIN, described, models};
use crate::adequacy::emitter_budget::{self, EmitterBudget, emitter_budgets};
use crate::adequacy::link_budget::{LinkBudget, link_budget};
use crate::adequacy::polarisation::polarisation;
use crate::adequacy::{Adequacy, adequacy_with_edge, hidden_targets};
use crate::config::Run;
use crate::motion::PlatformNav;
use crate::nav::TrackSource;
use crate::paths::drops;
use crate::pipeline::build::{self, PulseStream};
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::{outputs, plausible};
use crate::transport::Pace;
use crate::transport::pacer::InHand;
use crate::units::digits;

/// The assessment of a run, without emitting a pulse.
pub struct Assessment {
    /// What is modelled, and what is not.
    pub models: Models,
    /// What may be meant but is suspicious.
    pub warnings: Vec<String>,
    /// How the recorded tracks were made.
    pub tracks: Vec<Described>,
    /// How the sea fits the radar.
    pub sea: Option<Adequacy>,
    /// What antennas, noise and pulse interval mean for the targets.
    pub link: Option<LinkBudget>,
    /// What receivers get of emitters straight.
    pub emitters: Vec<EmitterBudget>,
    /// What is chosen for the error that is asked; none for the reference.
    pub plan: Option<PlanReport>,
    /// What the run takes.
    pub resources: Option<Resources>,
    /// Changes that are predicted to make it run in real time, where it does not.
    pub remedies: Vec<Predicted>,
}

impl Assessment {
    /// Assesses a run. Warnings go to `warned` as soon as they are known, and are kept as well.
    ///
    /// # Errors
    /// What keeps the run from being built, all at once.
    pub fn of(run: &Run, mut warned: impl FnMut(&[String])) -> Result<Self, BuildErrors> {
        let mut warnings: Vec<String> = run.warnings.iter().map(ToString::to_string).collect();
        // An output that exists stands in the way of a run, not of a look at the scenario.
        warnings.extend(outputs::preflight(&run.sinks).iter().map(ToString::to_string));
        warned(&warnings);
        let (first, models) = (warnings.len(), models(run));
        let tracks = Vec::new();
        let mut found = Self {
            models,
            warnings,
            tracks,
            sea: None,
            link: None,
            emitters: Vec::new(),
            plan: None,
            resources: None,
            remedies: Vec::new(),
        };
        let unknown = without_trajectory(run);
        if unknown.is_empty() {
            found.predict(run)?;
        } else {
            // What needs a trajectory is left out, rather than predicted of a wrong one.
            found.warnings.extend(unknown);
        }
        warned(&found.warnings[first..]);
        Ok(found)
    }

    /// What follows from the tracks: how sea, horizon, polarisation and receiver fit, settings, speed.
    fn predict(&mut self, run: &Run) -> Result<(), BuildErrors> {
        let unrecorded = Run { sinks: Vec::new(), ..run.clone() };
        let stream = build::on_nominal_tracks(&unrecorded, 0..run.scene.pulses)?;
        let prepared = stream.prepared();
        for note in prepared.notes() {
            let what = format!("{}, {} track", note.platform, note.role);
            self.tracks.push(described(&what, note.report.to_string()));
        }
        let link = link_budget(prepared)?;
        self.warnings.extend(link.warning(&prepared.scene().radar));
        self.link = Some(link);
        self.emitters = emitter_budgets(prepared)?;
        self.warnings.extend(emitter_budget::warnings(&self.emitters));
        self.sea = adequacy_with_edge(&stream)?;
        self.warnings.extend(hidden_targets::warnings(&stream).map_err(BuildErrors::from)?);
        self.warnings.extend(self.sea.iter().flat_map(|sea| sea.warnings.iter().cloned()));
        self.warnings.extend(polarisation(prepared)?);
        self.plan(run, &stream);
        if let Some(dem) = stream.factory().dem()
            && let Some(row) = self.models.with.iter_mut().find(|row| row.what == LAND)
        {
            row.how += &format!("; {}", dem.text());
        }
        if let Some((points, in_cell)) = stream.factory().rain()
            && let Some(row) = self.models.with.iter_mut().find(|row| row.what == RAIN)
        {
            row.how += &format!("; {points:.0} points at a pulse, {in_cell} in a resolution cell");
            if in_cell < drops::DROPS {
                row.how += &format!(": {} would make more than {} at some pulse", drops::DROPS, drops::MOST);
            }
        }
        if let Some((cells, in_cell)) = stream.factory().far_sea()
            && let Some(row) = self.models.with.iter_mut().find(|row| row.what == FAR_SEA)
        {
            row.how += &format!("; {cells:.0} cells at a pulse, {in_cell} in a resolution cell");
        }
        self.warnings.extend(plausible::geometry(prepared)?);
        let resources = stream.resources(&run.scene.radar).map_err(BuildErrors::from)?;
        let levels = resources.converter.iter().flat_map(|converter| converter.warnings());
        self.warnings.extend(levels);
        if resources.real_time_factor < 1.0 && run.stream.pace == Pace::Realtime {
            self.warnings.push(format!(
                "{} times real time on this machine: a run in real time falls behind; --pace fast, or stream.pace = \"fast\"",
                digits(resources.real_time_factor)
            ));
        }
        // The latency of live navigation that is not given follows from its fixes.
        let is_live = run.nav.iter().any(|nav| matches!(nav.truth, TrackSource::Live(_)));
        if run.stream.pace == Pace::Realtime && (run.stream.latency_given || !is_live) {
            self.warnings.extend(short_latency(stream.in_hand(), resources.real_time_factor));
        }
        self.remedies = predicted(run, &stream, resources.real_time_factor)?;
        self.resources = Some(resources);
        Ok(())
    }

    /// What is predicted of the settings takes the place of what was asked.
    fn plan(&mut self, run: &Run, stream: &PulseStream) {
        let Some(planned) = stream.factory().plan() else { return };
        let speed = stream.threads() as f64 / planned.seconds();
        let factor = speed / run.scene.radar.sends().mean_prf_hz();
        self.warnings.extend(not_kept(planned));
        for row in self.models.with.iter_mut().filter(|row| row.what == ECHO) {
            row.how = echo_text(planned);
        }
        self.plan =
            Some(PlanReport::new(planned, stream.factory(), factor, stream.predicted_bytes(&run.sinks)));
    }
}

/// What to do about a latency in which the pulses that are made at once are not made.
fn short_latency(in_hand: InHand, real_time_factor: f64) -> Option<String> {
    let takes_s = in_hand.batch_s / real_time_factor;
    let remedy = in_hand.remedy().filter(|_| takes_s > in_hand.latency_s)?;
    // Where generation falls behind, no latency helps.
    let behind = if real_time_factor < 1.0 { ", which is enough once generation keeps up" } else { "" };
    Some(format!(
        "pulses come too late in real time: those that are made at once take about {} ms on this machine; {remedy}{behind}",
        digits(takes_s * 1e3)
    ))
}

/// Live platforms of which nothing is known beforehand.
fn without_trajectory(run: &Run) -> Vec<String> {
    let live = |(name, nav): (&String, &PlatformNav)| match &nav.truth {
        TrackSource::Live(source) if source.nominal.is_none() => Some(format!(
            "platform '{name}' is live, and where it will be is not known: sea, window, plan and speed are not predicted; \
             a nominal trajectory (track.nominal) lets check predict them"
        )),
        _ => None,
    };
    run.scene.platforms.iter().zip(&run.nav).filter_map(live).collect()
}
