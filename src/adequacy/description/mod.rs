//! A scenario in words: what is modelled of it, and what is not and why.

mod limits;
mod reports;
pub mod scenario;
pub mod sea;
pub mod ships;
mod targets;

use std::f64::consts::LN_10;

use serde::Serialize;

use crate::config::Run;
use crate::echo::Fidelity;
use crate::frames::Earth;
use crate::radar::filter::ReceiveFilter;
use crate::radar::front_end::imbalance;
use crate::radar::rain::{Attenuation, fall_mps, volume_reflectivity_per_m};
use crate::radar::receiver::thermal_noise_w;
use crate::scene::Scene;
use crate::scene::front_end::{Agc, FrontEnd, Instability, Jitter, Stc};
use crate::scene::radar::{Aim, RainClutter};
use crate::units::{Decibels, neat};

/// The row of the echo among what is modelled.
pub const ECHO: &str = "echo";
/// That of the sea beyond the patch.
pub const FAR_SEA: &str = "far sea";
/// That of the echo of rain.
pub const RAIN: &str = "echo of rain";
/// That of land.
pub const LAND: &str = "land";

/// Something and what there is to say about it.
#[derive(Clone, Debug, Serialize)]
pub struct Described {
    /// What it is.
    pub what: String,
    /// What there is to say about it.
    pub how: String,
}

/// Something and what there is to say about it.
pub fn described(what: &str, how: impl Into<String>) -> Described {
    Described { what: what.to_owned(), how: how.into() }
}

/// Effects of a run.
#[derive(Debug)]
pub struct Models {
    /// What is modelled, and how.
    pub with: Vec<Described>,
    /// What is not, and why.
    pub without: Vec<Described>,
}

/// What is modelled, and what is not and why.
pub fn models(run: &Run) -> Models {
    let radar = &run.scene.radar;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    with.push(described(
        "propagation",
        "exact light time of every pulse; Doppler within the pulse, carrier and envelope stretched alike",
    ));
    horizon(&run.scene, &mut with, &mut without);
    if radar.rain_mmph > 0.0 {
        let Attenuation { h, v, circular } = Attenuation::new(radar.carrier_hz, radar.rain_mmph);
        let how = format!(
            "{} mm/h along the whole of every path: H {h:.3}, V {v:.3}, circular {circular:.3} dB/km one way on \
             level paths (ITU-R P.838-3)",
            radar.rain_mmph
        );
        with.push(described("rain", how));
    }
    if let Some(RainClutter { top_m, spread_mps }) = radar.rain_clutter {
        let how = format!(
            "Rayleigh scattering, {:.1} dB of 1/m up to {} m; falls at {:.1} m/s, {} m/s rms",
            Decibels::from_power_ratio(volume_reflectivity_per_m(radar.carrier_hz, radar.rain_mmph)).0,
            neat(top_m),
            fall_mps(radar.rain_mmph),
            neat(spread_mps)
        );
        with.push(described(RAIN, how));
    }
    with.push(described(
        ECHO,
        match run.fidelity {
            Fidelity::Reference => "the reference: every pulse from its own paths, f64".to_owned(),
            Fidelity::Fast(asked) => {
                // What is predicted takes its place where the run can be planned.
                format!("fast: error against the reference {} dB requested", asked.error_db)
            }
        },
    ));
    if run.scene.targets.is_empty() {
        without.push(described("point targets", "no [[target]]"));
    } else {
        with.push(described("point targets", run.scene.targets.len().to_string()));
        targets::models(&run.scene.targets, &mut with, &mut without);
    }
    if radar.direct_path {
        with.push(described("direct path", "transmitter to receiver"));
    } else {
        without.push(described("direct path", "radar.direct_path = false"));
    }
    match radar.noise_figure_db {
        Some(figure_db) => {
            let bandwidth_hz = ReceiveFilter::new(radar.sample_rate_hz).noise_bandwidth_hz();
            let noise_w = thermal_noise_w(bandwidth_hz, Decibels(figure_db));
            with.push(described(
                "thermal noise",
                format!(
                    "noise figure {figure_db} dB: k T0 F B = {:.1} dBW per sample, in the noise bandwidth of the receive filter, \
                     {} MHz (0.875 of the sample rate)",
                    Decibels::from_power_ratio(noise_w).0,
                    neat(bandwidth_hz / 1e6)
                ),
            ));
        }
        None => without.push(described("thermal noise", "no radar.noise_figure_db")),
    }
    front_end(&radar.front_end, &mut with, &mut without);
    match radar.adc {
        Some(adc) => with.push(described("ADC", format!("{} bits", adc.bits))),
        None => without.push(described("ADC", "no [radar.adc]: floating-point samples")),
    }
    reports::models(run, &mut with, &mut without);
    sea::models(&run.scene, &mut with, &mut without);
    ships::models(&run.scene, &mut with, &mut without);
    limits::models(run, &mut without);
    Models { with, without }
}

/// What is wrong between echo and converter.
fn front_end(of: &FrontEnd, with: &mut Vec<Described>, without: &mut Vec<Described>) {
    if of.is_ideal() {
        let why =
            "no [radar.front_end]: I and Q alike, no offset, gain control, blanking, instability and jitter";
        without.push(described("front end errors", why));
        return;
    }
    let mut parts = Vec::new();
    if of.iq_gain_db != 0.0 || of.iq_phase_rad != 0.0 {
        let [alpha, beta] = imbalance(of.iq_gain_db, of.iq_phase_rad);
        let image_db = 20.0 * (beta.norm() / alpha.norm()).log10();
        parts.push(format!("image of I/Q imbalance at {image_db:.1} dB"));
    }
    let offset_w = of.offset[0].powi(2) + of.offset[1].powi(2);
    if offset_w > 0.0 {
        parts.push(format!("offset of {:.1} dBW", 10.0 * offset_w.log10()));
    }
    if let Some(Stc { full_s, exponent, depth_db }) = of.stc {
        let full_us = neat(full_s * 1e6);
        parts
            .push(format!("sensitivity time control t^{exponent} until {full_us} us, {depth_db} dB at most"));
    }
    if let Some(after_s) = of.blanked_s {
        parts.push(format!("blanked during pulses and {} us after", neat(after_s * 1e6)));
    }
    if let Some(Agc { level_w, attack_s, release_s, depth_db }) = of.agc {
        let [attack_us, release_us] = [attack_s, release_s].map(|s| neat(s * 1e6));
        parts.push(format!(
            "gain control above {:.1} dBW, attack {attack_us} us, release {release_us} us, {depth_db} dB at most",
            10.0 * level_w.log10()
        ));
    }
    if let Some(Instability { level_db, phase_rad }) = of.instability {
        let power = (level_db * LN_10 / 20.0).powi(2) + phase_rad.powi(2);
        let cancelled_db = 10.0 * (2.0 * power).log10();
        parts.push(format!(
            "transmitters unstable by {level_db} dB and {} deg rms: two pulses cancel to {cancelled_db:.1} dB",
            neat(phase_rad.to_degrees())
        ));
    }
    if let Some(Jitter { rms_s, intermediate_hz }) = of.jitter {
        let met = if intermediate_hz > 0.0 { format!(" at {intermediate_hz:e} Hz") } else { String::new() };
        parts.push(format!("sampling jitter of {rms_s:e} s rms{met}"));
    }
    with.push(described("front end errors", parts.join("; ")));
}

/// What the curve of the earth hides.
fn horizon(scene: &Scene, with: &mut Vec<Described>, without: &mut Vec<Described>) {
    let hides = scene.frame.hiding_earth() != Earth::Flat;
    if hides {
        let hidden = "the curved earth hides sea, targets and direct path beyond the horizon of an antenna";
        with.push(described("horizon", hidden));
        without.push(described("diffraction", "beyond the horizon nothing is seen, at any wavelength"));
    } else if scene.frame.earth() == Earth::Flat {
        without.push(described("horizon", "flat earth"));
    } else {
        without.push(described(
            "horizon",
            "scene.horizon = false: what lies beyond it is illuminated all the same",
        ));
    }
}

fn aim_text(aim: &Aim, platforms: &[String]) -> String {
    match aim {
        Aim::Point { position, .. } => {
            let [e, n, u] = position.to_array();
            format!("the point {e:.1} m East, {n:.1} m North, {u:.1} m up")
        }
        Aim::Beside { platform, along_m, across_m } => {
            let name = platforms.get(*platform).map_or("", String::as_str);
            let side = if *across_m < 0.0 { "port" } else { "starboard" };
            format!("the sea {} m to {side} and {along_m} m ahead of {name}", across_m.abs())
        }
    }
}
