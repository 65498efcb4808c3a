//! Trains of pulses and waveforms, of the radar and of emitters.

use crate::config::choices::WaveformKind;
use crate::config::error::Problem;
use crate::config::keys::Key;
use crate::config::section::Section;
use crate::scene::radar::Waveform;
use crate::time::PulseTimes;

/// A train, by one of the keys.
pub(super) fn emissions(section: &Section<'_>, keys: [&'static Key; 2]) -> Option<PulseTimes> {
    let written = section.exactly_one(&keys);
    let (prf_hz, pri_us) = (section.number(keys[0]), section.numbers(keys[1]));
    written?;
    // Both ranges lie within those of PulseTimes, so that neither can fail.
    match (prf_hz, pri_us) {
        (Some(prf_hz), _) => PulseTimes::uniform(prf_hz).ok(),
        (None, Some(pri_us)) => {
            let pri_s: Vec<f64> = pri_us.iter().map(|us| us / 1e6).collect();
            PulseTimes::sequence(&pri_s).ok()
        }
        (None, None) => None,
    }
}

/// A waveform, which may be no wider than a sample rate if that is given.
pub(super) fn waveform(section: Section<'_>, sample_rate_hz: Option<f64>) -> Option<Waveform> {
    use crate::config::keys::waveform::{BANDWIDTH_HZ, KIND, PATH, PULSE_S, RATE_HZ, SWEEP};
    let waveform =
        match section.choice(&KIND) {
            Some(WaveformKind::Lfm) => {
                let bandwidth_hz = section.number(&BANDWIDTH_HZ);
                if let (Some(bandwidth_hz), Some(sample_rate_hz)) = (bandwidth_hz, sample_rate_hz)
                    && bandwidth_hz > sample_rate_hz
                {
                    section.fault(&BANDWIDTH_HZ, Problem::Bandwidth { bandwidth_hz, sample_rate_hz });
                }
                let duration_s = section.number(&PULSE_S);
                let sweep = section.choice(&SWEEP);
                bandwidth_hz.zip(duration_s).zip(sweep).map(|((bandwidth_hz, duration_s), sweep)| {
                    Waveform::Lfm { bandwidth_hz, duration_s, sweep }
                })
            }
            Some(WaveformKind::File) => {
                let (path, rate_hz) = (section.file(&PATH), section.number(&RATE_HZ));
                path.zip(rate_hz).map(|(path, rate_hz)| Waveform::Samples { path, rate_hz })
            }
            None => None,
        };
    section.finish();
    waveform
}
