//! Which engine makes what was planned.

use std::sync::Arc;

use super::block::{BlockEcho, Joint};
use super::engine::{EchoEngine, JointReference};
use super::joined::Span;
use super::single::SingleEcho;
use crate::echo::reference::{GUARD_SAMPLES, ReferenceEcho};
use crate::echo::synth::{Precision, Settings, Synth, SynthError};
use crate::fidelity::budget::Plan;
use crate::paths::PathGenerator;
use crate::radar::waveform::Waveform;
use crate::scene::Radar;

/// The engine of a plan, or the reference: of a radar's own pulses, or, in segments of so many, of what is
/// emitted apart from them.
///
/// # Errors
/// Settings that the fast echo refuses.
pub(crate) fn engine(
    plan: Option<&Plan>,
    radar: &Radar,
    segment: Option<u64>,
    generator: &PathGenerator,
    waveform: &Arc<dyn Waveform>,
) -> Result<Arc<dyn EchoEngine>, SynthError> {
    let of_channels = generator.channel_pairs();
    let (carrier_hz, rate_hz, samples) = (radar.carrier_hz, radar.sample_rate_hz, radar.window.samples);
    // Where windows may receive several emissions that are not alike, grids are those of emissions.
    if generator.is_apart() && !waveform.is_one() {
        return joint(plan, radar, segment, generator, waveform);
    }
    let waveform = Arc::clone(waveform);
    let Some(Plan { chosen, .. }) = plan else { return Ok(Arc::new(reference(radar, generator, waveform))) };
    Ok(match chosen.precision {
        Precision::Double => {
            let synth = Synth::new(waveform, carrier_hz, rate_hz, samples, of_channels, chosen.echo)?;
            let synth = if generator.is_of_emitter() { synth.with_exact_reach() } else { synth };
            Arc::new(SingleEcho::new(synth.in_windows(generator.pair_windows())))
        }
        Precision::Single => {
            let synth = Synth::new(waveform, carrier_hz, rate_hz, samples, of_channels, chosen.echo)?;
            let synth = synth.grouped(&generator.channel_groups()).in_windows(generator.pair_windows());
            let synth = if generator.is_of_emitter() { synth.with_exact_reach() } else { synth };
            let (pulses, hold) = (generator.receiving_pulses(), generator.hold_pulses());
            let echo = BlockEcho::new(synth, chosen, pulses, hold)?;
            Arc::new(match segment {
                Some(pulses) => echo.in_segments(pulses),
                None => echo,
            })
        }
    })
}

fn reference(radar: &Radar, generator: &PathGenerator, waveform: Arc<dyn Waveform>) -> ReferenceEcho {
    // Pulses, unlike segments, begin and end near windows, which receive what the filter rings of them.
    let joint = generator.is_apart() && !waveform.in_turn().is_empty();
    let ringing = if joint { Span::ringing(waveform.as_ref()) + GUARD_SAMPLES } else { 0 };
    let (pairs, guard) = (generator.channel_pairs().to_vec(), generator.guard_samples().max(ringing));
    let (rate_hz, samples) = (radar.sample_rate_hz, radar.window.samples);
    let echo = ReferenceEcho::with_guard(waveform, radar.carrier_hz, rate_hz, samples, pairs, guard);
    let echo = if joint { echo.reaching(ringing) } else { echo };
    echo.in_windows(generator.pair_windows())
}

/// The same of a train of which no two emissions are alike.
fn joint(
    plan: Option<&Plan>,
    radar: &Radar,
    segment: Option<u64>,
    generator: &PathGenerator,
    waveform: &Arc<dyn Waveform>,
) -> Result<Arc<dyn EchoEngine>, SynthError> {
    let of_channels = generator.channel_pairs();
    let (carrier_hz, rate_hz) = (radar.carrier_hz, radar.sample_rate_hz);
    // Tracks were followed before.
    let delays_s = generator.delay_span_of_run_s().ok().flatten().unwrap_or_default();
    let joint = Joint::new(waveform, radar, delays_s);
    let Some(Plan { chosen, .. }) = plan else {
        let echo = reference(radar, generator, Arc::clone(waveform));
        return Ok(Arc::new(JointReference { echo, waveform: Arc::clone(waveform) }));
    };
    // Grids are as long as an emission: what a window needs beside itself is not for them.
    let guard_samples = joint.span.ringing;
    let settings = Settings { guard_samples, ..chosen.echo };
    let (own, samples) = (Arc::clone(waveform), joint.span.samples);
    let hold = generator.hold_pulses();
    if chosen.precision == Precision::Double || chosen.block_pulses(hold) == 1 {
        let synth = Synth::new(own, carrier_hz, rate_hz, samples, of_channels, settings)?;
        return Ok(Arc::new(SingleEcho::new(synth).joining(joint)));
    }
    let synth = Synth::new(own, carrier_hz, rate_hz, samples, of_channels, settings)?;
    let synth = synth.grouped(&generator.channel_groups());
    let echo = BlockEcho::new(synth, chosen, generator.receiving_pulses(), hold)?.joining(joint);
    Ok(Arc::new(match segment {
        Some(pulses) => echo.in_segments(pulses),
        None => echo,
    }))
}
