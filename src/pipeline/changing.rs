//! A run whose reports change: its events, and a list for those that come while it goes on.

use std::sync::Arc;

use super::factory;
use super::prepared::Prepared;
use super::stages::PulseFactory;
use crate::config::Run;
use crate::echo::Fidelity;
use crate::motion::changes::{ChangeFault, Changes, Event};
use crate::motion::errors::Circumstances;
use crate::motion::{PlatformTracks, SourceError};
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::pulse::log::Origin;
use crate::scene::Scene;
use crate::scene::clock::Clocks;

/// An empty list, where the run has events or may be changed from outside.
pub(super) fn list(run: &Run) -> Option<Arc<Changes>> {
    let scene = &run.scene;
    let changes = || Changes::new(&scene.platforms, &scene.radar.emissions, scene.start);
    (run.control || !run.events.is_empty()).then(|| Arc::new(changes()))
}

/// The tracks as they are reported under that list.
pub(super) fn tracks(
    tracks: Vec<PlatformTracks>,
    scene: &Scene,
    changes: Option<&Arc<Changes>>,
) -> Result<Vec<PlatformTracks>, BuildErrors> {
    let Some(changes) = changes else { return Ok(tracks) };
    let (seed, times, pulses) = (scene.seed, &scene.radar.emissions, scene.pulses);
    let listening = tracks.into_iter().enumerate().map(|(place, both)| {
        let of = Circumstances { seed, platform: place, times, pulses, before_s: 0.0 };
        match changes.of(place) {
            Some(own) => both.with_changes(own, &of, scene.start),
            None => Ok(both),
        }
    });
    listening.collect::<Result<_, SourceError>>().map_err(|source| {
        BuildError::Track { platform: "of the scene".to_owned(), role: "reported", source }.into()
    })
}

/// Enters the events of a run. This comes after everything that is planned: a plan knows no change, whether
/// it stands in the scenario or comes later.
pub(super) fn enter(events: &[Event], changes: Option<&Arc<Changes>>) -> Result<(), ChangeFault> {
    let Some(changes) = changes else { return Ok(()) };
    events.iter().try_for_each(|event| changes.enter(event, Origin::Scenario))
}

/// What makes the pulses of a run with its events, by ideal clocks.
///
/// # Errors
/// All faults of the input.
pub fn factory(run: &Run, fidelity: &Fidelity) -> Result<PulseFactory, BuildErrors> {
    factory_for(&Prepared::of(run)?, fidelity)
}

/// The same of a run that is prepared.
///
/// # Errors
/// All faults of the input.
pub fn factory_for(prepared: &Prepared, fidelity: &Fidelity) -> Result<PulseFactory, BuildErrors> {
    let (run, changes) = (prepared.run(), list(prepared.run()));
    let tracks = tracks(prepared.tracks().to_vec(), &run.scene, changes.as_ref())?;
    let files = prepared.files();
    let factory = factory::with_files(&run.scene, tracks, fidelity, &Clocks::default(), files)?;
    enter(&run.events, changes.as_ref())?;
    Ok(factory)
}
