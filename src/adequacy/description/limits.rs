//! What no scenario models, effect by effect.

use super::{Described, described};
use crate::config::Run;
use crate::scene::radar::Pattern;

/// Effects that are left out of every run: what, and what stands for it.
const NEVER: [(&str, &str); 13] = [
    ("multipath to ships", "no reflection from the sea between antenna and hull"),
    ("refraction", "straight rays, but for scene.earth_radius_factor; no ducts, no scintillation"),
    ("rain, spray, breakers", "no echo of its own; attenuation is radar.atmosphere_db_per_km"),
    ("higher orders of the sea", "linear waves; no breaking, no double scattering from facet to facet"),
    ("target shadows", "point targets neither hide each other nor the sea"),
    ("target polarimetry", "a scattering matrix does not change with the aspect"),
    (
        "antenna near field",
        "far-field patterns; no coupling between ports but cross_pol_isolation_db, no radome",
    ),
    ("pattern over frequency", "gain and phase are those of the carrier over the whole band"),
    ("blanking", "no T/R blanking: the receiver is open during transmission"),
    ("transmitter", "every pulse has the same amplitude and shape; no droop, no noise of its own"),
    ("receiver errors", "no I/Q imbalance, offset, gain control or intermodulation; the ADC has no jitter"),
    ("interference", "no other emitters, no jamming"),
    ("land", "no echo and no shadow of coasts"),
];

/// Adds what is not modelled in this or any run.
pub(super) fn models(run: &Run, without: &mut Vec<Described>) {
    for (what, how) in NEVER {
        // A scene without a sea has no waves to be linear.
        if run.scene.sea.is_none() && what == "higher orders of the sea" {
            continue;
        }
        if run.scene.targets.is_empty() && what.starts_with("target") {
            continue;
        }
        without.push(described(what, how));
    }
    let antennas = run.scene.radar.transmitters.iter().map(|tx| &tx.antenna);
    let mut antennas = antennas.chain(run.scene.radar.receivers.iter().map(|rx| &rx.antenna));
    if antennas.any(|mount| matches!(mount.pattern, Pattern::Rectangle { .. } | Pattern::Ellipse { .. })) {
        without.push(described("back lobes", "rear hemisphere: aperture patterns are zero behind"));
    }
}
