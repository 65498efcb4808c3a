//! Waveforms of several pulses, which leave in turn.

use super::described;
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
        let kind: Option<&str> = section.peek_text(&KIND);
        if let Some(kind @ ("in-turn" | "stepped")) = kind {
            let found = format!("kind = \"{kind}\" among waveforms");
            section.fault(&KIND, Problem::Type { found, allowed: "a single pulse".to_owned() });
        }
        let offset_hz = section.number(&OFFSET_HZ);
        let found = described(&section, sample_rate_hz, (None, number));
        let continuous = ["noise", "dvb-t", "fm", "gps-l1-ca", "iq-file"];
        if let Some(kind) = kind.filter(|kind| continuous.contains(kind)) {
            let found = format!("kind = \"{kind}\" among waveforms");
            section.fault(&KIND, Problem::Type { found, allowed: "pulses, which end".to_owned() });
        }
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

/// Faults a pulse whose band reaches beyond what is sampled about the carrier.
fn fits((section, key): (&Section<'_>, &'static Key), pulse: &Waveform, sample_rate_hz: Option<f64>) {
    let (Some([from_hz, to_hz]), Some(sample_rate_hz)) = (pulse.band_hz(), sample_rate_hz) else { return };
    if from_hz.abs().max(to_hz.abs()) > 0.5 * sample_rate_hz * (1.0 + 4.0 * f64::EPSILON) {
        let found = format!("a band from {} to {} Hz about the carrier", figure(from_hz), figure(to_hz));
        let allowed = format!("within {} Hz of it: half of sample_rate_hz", figure(0.5 * sample_rate_hz));
        section.fault(key, Problem::Type { found, allowed });
    }
}
