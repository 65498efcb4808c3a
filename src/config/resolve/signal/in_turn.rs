//! Waveforms of several pulses, which leave in turn.

use super::described;
use crate::config::choices::{Choice, WaveformKind};
use crate::config::error::Problem;
use crate::config::keys::waveform::{BANDWIDTH_HZ, KIND, OFFSET_HZ, PULSE_S, STEP_HZ, STEPS, WAVEFORMS};
use crate::config::keys::{Key, MOST_TURNS, figure};
use crate::config::section::Section;
use crate::scene::radar::{Sweep, Waveform};

/// Steps of frequency about the carrier, each of them a plain pulse or a sweep.
pub(super) fn stepped(section: &Section<'_>, sample_rate_hz: Option<f64>) -> Option<Waveform> {
    let (steps, step_hz) = (section.count(&STEPS), section.number(&STEP_HZ));
    let duration_s = section.number(&PULSE_S);
    let swept = section.has(&BANDWIDTH_HZ);
    let bandwidth_hz = if swept { section.number(&BANDWIDTH_HZ) } else { None };
    if step_hz == Some(0.0) {
        let (found, allowed) = ("0 Hz".to_owned(), "a step that is not 0".to_owned());
        section.fault(&STEP_HZ, Problem::Type { found, allowed });
    }
    let (steps, step_hz, duration_s) = (steps?, step_hz?, duration_s?);
    let pulse = match bandwidth_hz {
        Some(bandwidth_hz) => Waveform::Lfm { bandwidth_hz, duration_s, sweep: Sweep::Up },
        None if swept => return None,
        None => Waveform::Cw { duration_s },
    };
    let middle = 0.5 * (steps - 1) as f64;
    let of =
        |k: u64| Waveform::Offset { of: Box::new(pulse.clone()), offset_hz: (k as f64 - middle) * step_hz };
    let all = Waveform::InTurn { of: (0..steps).map(of).collect(), stepped: true };
    fits((section, &STEP_HZ), &all, sample_rate_hz);
    Some(all)
}

/// Pulses as they are listed.
pub(super) fn pulses(
    section: &Section<'_>,
    (sample_rate_hz, number): (Option<f64>, u64),
) -> Option<Waveform> {
    let listed = section.sections(&WAVEFORMS);
    let count = listed.len();
    let pulse = |section: Section<'_>| {
        let kind = section.peek_text(&KIND).and_then(WaveformKind::named);
        if let Some((kind, allowed)) = kind.and_then(|kind| Some((kind, instead(kind)?))) {
            let found = format!("kind = \"{}\" among waveforms", kind.word());
            section.fault(&KIND, Problem::Type { found, allowed: allowed.to_owned() });
        }
        let offset_hz = section.number(&OFFSET_HZ);
        let found = described(&section, sample_rate_hz, (None, number));
        let found = found.zip(offset_hz).map(|(pulse, offset_hz)| match offset_hz {
            0.0 => pulse,
            _ => Waveform::Offset { of: Box::new(pulse), offset_hz },
        });
        found.iter().for_each(|pulse| fits((&section, &OFFSET_HZ), pulse, sample_rate_hz));
        section.finish();
        found
    };
    let found: Vec<Waveform> = listed.into_iter().filter_map(pulse).collect();
    if count > 0 && !(2..=MOST_TURNS as usize).contains(&count) {
        let (found, allowed) = (format!("{count} of them"), format!("2 to {MOST_TURNS} pulses"));
        section.fault(&WAVEFORMS, Problem::Type { found, allowed });
    }
    (found.len() == count && count > 1).then_some(Waveform::InTurn { of: found, stepped: false })
}

/// What is allowed in the place of a kind that is no pulse.
fn instead(kind: WaveformKind) -> Option<&'static str> {
    use WaveformKind::{Cw, DvbT, File, Fm, GpsCa, InTurn, IqFile, Lfm, Nlfm, Noise, PhaseCode, Stepped};
    match kind {
        Lfm | Nlfm | Cw | PhaseCode | File => None,
        InTurn | Stepped => Some("a single pulse"),
        Noise | DvbT | Fm | GpsCa | IqFile => Some("pulses, which end"),
    }
}

/// Faults a pulse whose band reaches beyond what is sampled about the carrier.
fn fits((section, key): (&Section<'_>, &'static Key), pulse: &Waveform, sample_rate_hz: Option<f64>) {
    let (Some(band), Some(sample_rate_hz)) = (pulse.band(), sample_rate_hz) else { return };
    if band.reach_hz() > 0.5 * sample_rate_hz * (1.0 + 4.0 * f64::EPSILON) {
        let found =
            format!("a band from {} to {} Hz about the carrier", figure(band.from_hz), figure(band.to_hz));
        let allowed = format!("within {} Hz of it: half of sample_rate_hz", figure(0.5 * sample_rate_hz));
        section.fault(key, Problem::Type { found, allowed });
    }
}
