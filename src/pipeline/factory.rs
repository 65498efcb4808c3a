//! From a scene to what makes its pulses.

use std::iter;
use std::sync::Arc;

use super::dry_run;
use super::engines;
use super::fault::{BuildError, BuildErrors};
use super::mixed;
use super::overheard::{self, Overheard, segment_apart};
use super::prepared::Files;
use super::relax;
use super::stages::PulseFactory;
use crate::echo::{Asked, Fidelity};
use crate::fidelity::Prediction;
use crate::fidelity::budget::Plan;
use crate::motion::PlatformTracks;
use crate::paths::PathGenerator;
use crate::radar::clock::RunningClocks;
use crate::radar::dechirp;
use crate::scene::clock::Clocks;
use crate::scene::{Scene, Sea};

/// What makes the pulses of a scene whose platforms move on the given tracks.
///
/// This is the way in for a scene built in Rust; see `examples/scene_in_rust.rs`.
///
/// # Errors
/// All faults of the scene.
pub fn factory(scene: &Scene, tracks: Vec<PlatformTracks>) -> Result<PulseFactory, BuildErrors> {
    factory_by(scene, tracks, &Fidelity::Reference, &Clocks::default())
}

/// The same with a choice of how echoes are made, and with clock errors.
///
/// # Errors
/// All faults of the scene and its clocks.
pub fn factory_by(
    scene: &Scene,
    tracks: Vec<PlatformTracks>,
    fidelity: &Fidelity,
    clocks: &Clocks,
) -> Result<PulseFactory, BuildErrors> {
    with_files(scene, tracks, fidelity, clocks, &Files::default())
}

/// The same from files that may have been read.
pub(super) fn with_files(
    scene: &Scene,
    tracks: Vec<PlatformTracks>,
    fidelity: &Fidelity,
    clocks: &Clocks,
    files: &Files,
) -> Result<PulseFactory, BuildErrors> {
    Ok(with_classes(scene, tracks, (fidelity, &[]), clocks, files)?.0)
}

/// The same, and what makes them at coarser errors, dB, of the fast echo.
pub(super) fn with_classes(
    scene: &Scene,
    tracks: Vec<PlatformTracks>,
    (fidelity, relax_db): (&Fidelity, &[f64]),
    clocks: &Clocks,
    files: &Files,
) -> Result<(PulseFactory, Vec<PulseFactory>), BuildErrors> {
    let recorded = files.laden(scene)?;
    let waveform = Arc::clone(files.waveform(recorded)?);
    // All but the receiver is that of the front end.
    let front_end = dechirp::front_end(&recorded.radar, waveform.bandwidth_hz())
        .map(|radar| Scene { radar, ..recorded.clone() });
    let scene = front_end.as_ref().unwrap_or(recorded);
    let radar = &scene.radar;
    let drawn = |sea: &Sea| files.sea(sea, scene.seed).cloned();
    let others = overheard::emitting(scene, &tracks, &drawn)?;
    let sent = overheard::continuous(scene, waveform.duration_s(), &tracks, &drawn)?;
    let (own, generator) = match &sent {
        Some((own, generator)) => (own, generator.clone()),
        None => (scene, PathGenerator::on(scene, waveform.duration_s(), tracks, &drawn)?),
    };
    if !waveform.is_one() && !generator.is_apart() && !generator.receives_itself_alone() {
        return Err(BuildError::SeveralInTurn.into());
    }
    if recorded.radar.front_end.instability.is_some() && !generator.receives_itself_alone() {
        return Err(BuildError::SeveralUnstable.into());
    }
    let (bandwidth_hz, pulse_s) = (waveform.bandwidth_hz(), waveform.duration_s());
    let clocks = RunningClocks::new(clocks, radar, scene.seed, scene.pulses, bandwidth_hz, pulse_s)?;
    let clocks = clocks.map(Arc::new);
    let generator = generator.with_clocks(clocks.clone());
    let make = |plan: Option<Plan>| {
        let segment =
            sent.is_some().then(|| segment_apart(plan.as_ref(), own, &generator, waveform.as_ref()));
        let echo = engines::engine(plan.as_ref(), radar, segment, &generator, &waveform)?;
        let segment = echo.segment_pulses();
        let fidelity = plan.map_or(Fidelity::Reference, |plan| Fidelity::Fast(plan.asked));
        let others: Vec<Overheard> = others
            .iter()
            .map(|other| other.clone().planned(&generator, &fidelity, segment, clocks.clone()))
            .collect::<Result<_, _>>()?;
        let emitters = others.iter().map(Overheard::error).fold(0.0, f64::max);
        let plan = plan.map(|plan| Plan { prediction: Prediction { emitters, ..plan.prediction }, ..plan });
        let factory = PulseFactory::new((echo, plan), (scene, radar), generator.clone(), waveform.clone());
        let factory = factory.with_dechirp((recorded, &recorded.radar), radar);
        Ok::<_, BuildErrors>(factory.with_clocks(clocks.clone()).with_others(others))
    };
    let Fidelity::Fast(asked) = fidelity else { return Ok((make(None)?, Vec::new())) };
    let coarser = relax_db.iter().map(|error_db| Asked { error_db: *error_db, ..*asked });
    let asked: Vec<Asked> = iter::once(*asked).chain(coarser).collect();
    let mixed = mixed::share((scene, &recorded.radar), &generator, waveform.as_ref())?;
    let mut plans = dry_run::plans(own, &generator, &waveform, mixed, &asked)?.into_iter().map(Some);
    let first = make(plans.next().flatten())?;
    let coarser = plans.map(make).collect::<Result<_, _>>()?;
    let coarser = relax::worth_having(&first, coarser);
    Ok((first, coarser))
}
