//! What the errors of `[platform.errors.position]` do, by closed forms alone: from the scenario of a
//! recording and the lines of sight at the first, the middle and the last pulse.
//!
//! Left out: presets, drawn biases, walks, rounding, and random parts of reports that do not come with every
//! pulse; errors of attitude and lever arm; turbulence.

use serde::Serialize;
use toml::Table;

use super::scenario::{Scenario, numbers};
use crate::processor::degradation::Look;
use crate::processor::degradation::laws::{
    PairedEchoes, gauss_markov_db, paired_echoes, ramp_cells, step_peak, white_db,
};
use crate::recording::header::ChannelRow;
use crate::units::SPEED_OF_LIGHT_MPS;

/// An error that is known, and what it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Law {
    /// A constant moves everything in range, and across as the line of sight turns.
    Bias { path_m: f64, range_cells: f64, cross_range_cells: f64 },
    /// A ramp moves everything in cross-range, and in range by what it has grown to.
    Ramp { path_mps: f64, range_cells: f64, cross_range_cells: f64 },
    /// A sinusoid raises paired echoes.
    Sinusoid { beta_rad: f64, echoes: PairedEchoes },
    /// A step splits the main lobe; peak and shift where it comes in the middle of an aperture without taper.
    Step { phase_rad: f64, loss_db: Option<f64>, cross_range_cells: Option<f64> },
    /// White noise, mean loss of an ensemble.
    White { sigma_rad: f64, mean_loss_db: f64 },
    /// Gauss-Markov noise, mean loss of an ensemble at the place expected, without taper.
    GaussMarkov { sigma_rad: f64, tau_s: f64, mean_loss_db: f64 },
}

/// Errors of the platforms of a channel, in the words of [`Law`].
pub(super) fn laws(
    scenario: &Scenario,
    row: &ChannelRow,
    look: &Look,
    point_m: [f64; 3],
    untapered: bool,
) -> Vec<Law> {
    let (Some(first_s), Some(last_s)) = (look.times_s.first(), look.times_s.last()) else {
        return Vec::new();
    };
    let count = look.times_s.len() as f64;
    let aperture_s = (last_s - first_s) * count / (count - 1.0).max(1.0);
    let middle_s = 0.5 * (first_s + last_s);
    let wavelength_m = SPEED_OF_LIGHT_MPS / look.carrier_hz;
    let wave_number = std::f64::consts::TAU / wavelength_m;
    // One platform may carry both ends: their unit vectors add up. At the first, the middle and the last
    // pulse.
    let instants_s = [*first_s, middle_s, *last_s];
    let mut carried: Vec<(String, [[f64; 3]; 3])> = Vec::new();
    for ((kind, name), path) in
        [("transmitter", &row.transmitter), ("receiver", &row.receiver)].into_iter().zip(look.truth)
    {
        let Some(platform) = scenario.platform(kind, name) else { return Vec::new() };
        let towards = instants_s.map(|t| {
            (glam::DVec3::from(path.at(t)) - glam::DVec3::from(point_m)).normalize_or_zero().to_array()
        });
        match carried.iter_mut().find(|(carrier, _)| carrier == platform) {
            Some((_, sum)) => {
                *sum = std::array::from_fn(|i| std::array::from_fn(|k| sum[i][k] + towards[i][k]));
            }
            None => carried.push((platform.to_owned(), towards)),
        }
    }
    let mut told = Vec::new();
    for (platform, towards) in carried {
        let Some(errors) = scenario.errors(&platform) else { continue };
        let Some(position) = errors.get("position").and_then(toml::Value::as_table) else { continue };
        let [_, middle, _] = towards;
        let sight = |key: &str| -> [f64; 3] {
            let axes: [f64; 3] = numbers(position, key).unwrap_or([0.0; 3]);
            towards.map(|towards| (0..3).map(|k| axes[k] * towards[k]).sum())
        };
        let along = |key: &str| sight(key)[1];
        let spread = |key: &str| -> f64 {
            let axes: [f64; 3] = numbers(position, key).unwrap_or([0.0; 3]);
            (0..3).map(|k| (axes[k] * middle[k]).powi(2)).sum::<f64>().sqrt()
        };
        let number = |table: &Table, key: &str, default: f64| {
            table.get(key).and_then(super::scenario::number).unwrap_or(default)
        };
        // Without a rate every pulse has its own report.
        let every_pulse = errors.get("preset").is_none() && number(errors, "rate_hz", 0.0) == 0.0;
        // The line of sight turns: a constant grows along it, and so does what grows.
        let slope_mps =
            |[first, _, last]: [f64; 3]| (last - first) / (last_s - first_s).max(f64::MIN_POSITIVE);
        let cross_cells = |rate_mps: f64| ramp_cells(rate_mps, aperture_s, wavelength_m);
        let bias_m = sight("bias_m");
        if bias_m != [0.0; 3] {
            told.push(Law::Bias {
                path_m: bias_m[1],
                range_cells: -bias_m[1] * look.bandwidth_hz / SPEED_OF_LIGHT_MPS,
                cross_range_cells: cross_cells(slope_mps(bias_m)),
            });
        }
        let ramp_mps = sight("ramp_mps");
        if ramp_mps != [0.0; 3] {
            let grown_m = std::array::from_fn(|i| ramp_mps[i] * (instants_s[i] - scenario.pulse_zero_s));
            told.push(Law::Ramp {
                path_mps: ramp_mps[1],
                range_cells: -grown_m[1] * look.bandwidth_hz / SPEED_OF_LIGHT_MPS,
                cross_range_cells: cross_cells(slope_mps(grown_m)),
            });
        }
        let amplitude_m = along("sinusoid_m").abs();
        if amplitude_m > 0.0 {
            let beta_rad = wave_number * amplitude_m;
            let echoes = paired_echoes(beta_rad, number(position, "sinusoid_hz", 0.1), aperture_s);
            told.push(Law::Sinusoid { beta_rad, echoes });
        }
        let step_m = along("step_m");
        if step_m != 0.0 {
            let phase_rad = wave_number * step_m;
            let at_s = scenario.pulse_zero_s + number(position, "step_at_s", 0.0);
            let central = untapered && (at_s - middle_s).abs() < 0.01 * aperture_s;
            let peak = central.then(|| step_peak(phase_rad));
            told.push(Law::Step {
                phase_rad,
                loss_db: peak.map(|(_, level_db)| -level_db),
                cross_range_cells: peak.map(|(cells, _)| cells),
            });
        }
        let sigma_rad = wave_number * spread("white_m");
        if sigma_rad > 0.0 && every_pulse {
            told.push(Law::White { sigma_rad, mean_loss_db: -white_db(sigma_rad) });
        }
        let sigma_rad = wave_number * spread("gm_sigma_m");
        if sigma_rad > 0.0 && every_pulse {
            let tau_s = number(position, "gm_tau_s", 100.0);
            let mean_loss_db = -gauss_markov_db(sigma_rad, tau_s, aperture_s);
            told.push(Law::GaussMarkov { sigma_rad, tau_s, mean_loss_db });
        }
    }
    told
}
