//! What no scenario models, effect by effect.

use super::{Described, described};
use crate::config::Run;
use crate::frames::Earth;
use crate::geometry::horizon;
use crate::scene::radar::Pattern;
use crate::units::neat;

/// Effects that are left out of every run: what, and what stands for it.
const NEVER: [(&str, &str); 9] = [
    ("multipath to ships", "no reflection from the sea between antenna and hull"),
    ("echo of spray", "none of its own"),
    (
        "higher orders of the sea",
        "no free waves from interactions of others; no double scattering from facet to facet",
    ),
    ("target shadows", "point targets neither hide each other nor the sea"),
    ("target polarimetry", "a scattering matrix does not change with the aspect"),
    (
        "antenna near field",
        "far-field patterns; no coupling between ports but cross_pol_isolation_db, no radome",
    ),
    ("pattern over frequency", "gain and phase are those of the carrier over the whole band"),
    ("transmitter", "its amplitude does not vary from pulse to pulse; no noise of its own"),
    ("intermodulation", "the receiver is linear up to its converter"),
];

/// Carrier above which evaporation ducts guide, Hz.
const DUCTED_FROM_HZ: f64 = 3e9;

/// What stands for refraction.
fn refraction(earth: Earth) -> String {
    let Earth::Curved { radius_factor } = earth else {
        return "straight rays over a flat earth, which has no horizon".to_owned();
    };
    // Horizon of an antenna at 10 m: sqrt(2 k R h).
    let horizon_m = horizon::distance_m(earth, [10.0, 0.0]);
    format!(
        "straight rays over an earth of {} times its radius (standard refraction: 4/3): 10 m of height see the sea to {:.1} km; \
         no scintillation",
        neat((1e3 * radius_factor).round() / 1e3),
        horizon_m / 1e3
    )
}

/// Adds what is not modelled in this or any run.
pub(super) fn models(run: &Run, without: &mut Vec<Described>) {
    for (what, how) in NEVER {
        // A scene without a sea has no waves to interact.
        if run.scene.sea.is_none() && what == "higher orders of the sea" {
            continue;
        }
        if run.scene.targets.is_empty() && what.starts_with("target") {
            continue;
        }
        without.push(described(what, how));
    }
    if run.scene.radar.rain_mmph == 0.0 {
        without
            .push(described("rain", "radar.rain_mmph = 0: attenuation is radar.atmosphere_db_per_km alone"));
    } else if run.scene.radar.rain_clutter.is_none() {
        without.push(described("echo of rain", "radar.rain_clutter = false: rain attenuates alone"));
    } else {
        let how = "main lobes alone; none from beyond the pulse interval; drops are spheres; no profile of rate and wind";
        without.push(described("more of rain", how));
    }
    without.push(if run.scene.radar.emitters.is_empty() {
        described("interference", "no [[emitter]]: no other radars, no jamming")
    } else {
        let how =
            "no echo of rain; no clock errors but those of the channels; no noise of their transmitters";
        described("more of emitters", how)
    });
    without.push(described("refraction", refraction(run.scene.frame.earth())));
    if run.scene.radar.carrier_hz > DUCTED_FROM_HZ {
        let how = "significant above 3 GHz at grazing angles below 1 degree, where it carries far beyond the horizon";
        without.push(described("evaporation duct", how));
    }
    let antennas = run.scene.radar.transmitters.iter().map(|tx| &tx.antenna);
    let mut antennas = antennas.chain(run.scene.radar.receivers.iter().map(|rx| &rx.antenna));
    if antennas.any(|mount| {
        matches!(mount.pattern, Pattern::Rectangle { .. } | Pattern::Tapered { .. } | Pattern::Ellipse { .. })
    }) {
        without.push(described("back lobes", "rear hemisphere: aperture patterns are zero behind"));
    }
}
