//! Known errors in words: of reports, of the air, of clocks.

use super::{Described, described};
use crate::config::Run;
use crate::motion::changes::Event;
use crate::motion::errors::{AXES, AxisErrors, ErrorModel, Recorded, VELOCITY};
use crate::radar::clock::adev;
use crate::scene::clock::{Clock, NamedClock};
use crate::units::neat;

/// Events that are listed one by one.
const MOST_LISTED: usize = 8;

/// Adds what is modelled, and what not.
pub(super) fn models(run: &Run, with: &mut Vec<Described>, without: &mut Vec<Described>) {
    let platforms = run.scene.platforms.iter().zip(&run.nav);
    let mut listed = Vec::new();
    for (name, nav) in platforms.clone() {
        if nav.reported.is_some() {
            listed.push(format!("{name} reports another track"));
        }
        if let Some(model) = &nav.errors {
            listed.push(format!("{name}: {}", model_text(model)));
        }
    }
    if listed.is_empty() {
        let why = "no [platform.reported], no [platform.errors]: platforms report the truth";
        without.push(described("navigation errors", why));
    } else {
        with.push(described("navigation errors", listed.join("; ")));
    }
    if !run.events.is_empty() {
        let text = |event: &Event| {
            let name = run.scene.platforms.get(event.platform).map_or("", String::as_str);
            format!("from pulse {} {} on {name}", event.pulse, event.change)
        };
        let mut listed: Vec<String> = run.events.iter().take(MOST_LISTED).map(text).collect();
        let more = run.events.len().saturating_sub(MOST_LISTED);
        listed.extend((more > 0).then(|| format!("{more} more")));
        with.push(described("changes of reports", listed.join("; ")));
    }
    let gusts = platforms.filter_map(|(name, nav)| {
        nav.gusts.map(|gusts| format!("{name}, wind of {} m/s at 20 ft", neat(gusts.wind20_mps)))
    });
    let gusts: Vec<String> = gusts.collect();
    if gusts.is_empty() {
        without.push(described("turbulence", "no [platform.turbulence]"));
    } else {
        with.push(described("turbulence", gusts.join("; ")));
    }
    let clock = |named: &NamedClock| {
        let Clock { offset_s, drift, noise, .. } = named.clock;
        let rate = if drift == 0.0 { "0".to_owned() } else { format!("{drift:e}") };
        let noise = adev(&noise, 1.0, 0.5 * run.scene.radar.emissions.mean_prf_hz());
        format!(
            "{}: offset {} ns, rate {} at pulse 0, Allan deviation {noise:.2e} at 1 s",
            named.name,
            neat(1e9 * offset_s),
            rate
        )
    };
    let clocks: Vec<String> = run.clocks.clocks.iter().map(clock).collect();
    if clocks.is_empty() {
        without.push(described("clocks", "no [transmitter.clock], no [receiver.clock]: ideal clocks"));
    } else {
        with.push(described("clocks", clocks.join("; ")));
    }
}

fn model_text(model: &ErrorModel) -> String {
    let mut parts = Vec::new();
    if model.recorded == Recorded::Reported {
        parts.push("the track is what it reports; the truth differs from it by the errors".to_owned());
    }
    parts.push(match model.rate_hz {
        Some(rate_hz) => format!("{} reports/s", neat(rate_hz)),
        None => "a report at every pulse".to_owned(),
    });
    if model.latency_s > 0.0 || model.jitter_s > 0.0 {
        parts.push(format!("{} ms late", neat(model.latency_s * 1e3)));
    }
    if let Some(dropouts) = model.dropouts {
        parts.push(format!("{} dropouts per hour of {} s", neat(dropouts.per_hour), neat(dropouts.mean_s)));
    }
    let kinds =
        [("position", 0..VELOCITY), ("velocity", VELOCITY..2 * VELOCITY), ("attitude", 2 * VELOCITY..AXES)];
    for (kind, axes) in kinds {
        let axes = &model.axes[axes];
        let known =
            |a: &AxisErrors| [a.bias, a.bias_sigma, a.sinusoid, a.step, a.ramp].iter().any(|x| *x != 0.0);
        let of = match (axes.iter().any(|axis| axis.is_random()), axes.iter().any(known)) {
            (true, true) => "noise and known errors",
            (true, false) => "noise",
            (false, true) => "known errors",
            (false, false) => continue,
        };
        parts.push(format!("{of} of the {kind}"));
    }
    parts.join(", ")
}
