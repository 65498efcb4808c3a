//! What a dechirp leaves of the power of echoes.
//!
//! An echo is planned, and its error predicted, over what the front end takes. Behind the mixer that may be
//! less: the reference has a begin and an end, and the filter takes tones beyond its band away.
//!
//! ```text
//! share = min over channels of  sum |a|^2 H(f_b)^2 |echo n reference n window| / sum |a|^2 |echo n window|
//! ```
//!
//! over the scatterer paths of some pulses, `|..|` lengths of time. An error behind the mixer is at most one
//! over that share larger, for the mixer takes nothing but power away.

use super::engine::full_list;
use crate::fidelity::probe::spread_over;
use crate::paths::PathGenerator;
use crate::pulse::Pulse;
use crate::radar::dechirp::LEAD;
use crate::radar::fault::RadarError;
use crate::radar::filter::ReceiveFilter;
use crate::radar::waveform::Waveform;
use crate::scene::Scene;
use crate::scene::radar::{Dechirp, Radar};

/// Pulses that are looked at.
const PULSES: u64 = 8;
/// Less than that is nothing.
const LEAST: f64 = 1e-12;

/// The share of the power of a scene's echoes that a radar receives behind its mixer, in the channel that has
/// least; 1 without a dechirp. The paths are those of the front end.
///
/// # Errors
/// A track that ends early.
pub(super) fn share(
    (scene, radar): (&Scene, &Radar),
    paths: &PathGenerator,
    waveform: &dyn Waveform,
) -> Result<f64, RadarError> {
    let Some(Dechirp { delay_s }) = radar.dechirp else { return Ok(1.0) };
    let (rate_hz, pulse_s) = (radar.sample_rate_hz, waveform.duration_s());
    let lead_s = LEAD as f64 / rate_hz;
    let window_s = radar.window.samples as f64 / rate_hz;
    let of_halves = || radar.waveform.steepness_hz_per_s().unwrap_or(0.0);
    let sweep_hz_s = waveform.sweep_rate_hz_per_s().unwrap_or_else(of_halves);
    let filter = ReceiveFilter::new(rate_hz);
    let layout = scene.radar.layout(scene.platforms.len(), scene.targets.len());
    let (mut list, mut record, mut memory) = (full_list(paths), Pulse::new(&layout), paths.workspace());
    let mut sums = vec![[0.0; 2]; radar.channels.len()];
    let pulses = paths.receiving_pulses();
    for index in spread_over(pulses, PULSES.min(pulses), radar.tx_polarisation.cycle()) {
        paths.pulse(index, &mut memory, &mut list, &mut record)?;
        let channels = radar.channels.iter().zip(paths.channel_pairs()).zip(&list.amplitude).zip(&mut sums);
        for (((channel, pair), amplitudes), sum) in channels {
            let opens_s = record.window_start_of(channel.receiver) + lead_s;
            for (n, amplitude) in amplitudes.iter().enumerate() {
                let power = amplitude.norm_sqr();
                let begins_s = list.emission_offset_s[n] + list.delay_s[*pair][n];
                if power == 0.0 || !begins_s.is_finite() {
                    continue;
                }
                let (from_s, to_s) = (begins_s.max(opens_s), (begins_s + pulse_s).min(opens_s + window_s));
                let mixed_s = to_s.min(delay_s + pulse_s) - from_s.max(delay_s);
                let doppler_hz = -radar.carrier_hz * list.delay_rate[*pair][n];
                let beat_hz = doppler_hz - sweep_hz_s * (begins_s - delay_s);
                sum[0] += power * (to_s - from_s).max(0.0);
                sum[1] += power * mixed_s.max(0.0) * filter.response(beat_hz).powi(2);
            }
        }
    }
    let received = sums.iter().filter(|sum| sum[0] > 0.0);
    Ok(received.map(|[taken, left]| left / taken).fold(1.0, f64::min).max(LEAST))
}
