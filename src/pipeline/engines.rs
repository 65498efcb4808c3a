//! Which engine makes what was planned.

use std::sync::Arc;

use super::block::BlockEcho;
use super::engine::EchoEngine;
use super::single::SingleEcho;
use crate::echo::reference::ReferenceEcho;
use crate::echo::synth::{Precision, Synth, SynthError};
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
    let waveform = Arc::clone(waveform);
    let Some(Plan { chosen, .. }) = plan else {
        let (pairs, guard) = (of_channels.to_vec(), generator.guard_samples());
        let echo = ReferenceEcho::with_guard(waveform, carrier_hz, rate_hz, samples, pairs, guard);
        return Ok(Arc::new(echo.in_windows(generator.pair_windows())));
    };
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
