//! What the errors of `[platform.errors.position]` do, by [closed forms](super::laws) alone: from the
//! scenario of a recording and the lines of sight at the first, the middle and the last pulse.
//!
//! Left out: drawn biases, walks, rounding, and random parts of reports that do not come with every pulse
//! (those of presets too); errors of attitude and lever arm; turbulence.

use std::fmt;

use glam::DVec3;
use serde::Serialize;

use super::Degradation;
use super::laws::{PairedEchoes, gauss_markov_db, paired_echoes, ramp_cells, step_peak, white_db};
use crate::motion::errors::{AxisErrors, ErrorModel};
use crate::processor::focus::Described;
use crate::processor::taper::Taper;
use crate::recording::header::ChannelRow;
use crate::units::SPEED_OF_LIGHT_MPS;

/// An error that is known, and what it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Law {
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

/// What it does, in words.
impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bias { path_m, range_cells, cross_range_cells } => write!(
                f,
                "bias of {path_m:+.3} m of path: {range_cells:+.3} cells of range, {cross_range_cells:+.3} of cross-range"
            ),
            Self::Ramp { path_mps, range_cells, cross_range_cells } => write!(
                f,
                "ramp of {path_mps:+.4} m/s of path: {range_cells:+.3} cells of range, {cross_range_cells:+.3} of cross-range"
            ),
            Self::Sinusoid { beta_rad, echoes } => write!(
                f,
                "sinusoid of {beta_rad:.4} rad: main lobe {:.3} dB, echoes at +-{:.3} cells, {:.2} dB",
                echoes.main_db, echoes.distance_cells, echoes.level_db
            ),
            Self::Step { phase_rad, loss_db: Some(loss), cross_range_cells: Some(cells) } => {
                write!(
                    f,
                    "step of {phase_rad:+.4} rad in the middle: loss {loss:.3} dB, {cells:+.3} cells of cross-range"
                )
            }
            Self::Step { phase_rad, .. } => write!(f, "step of {phase_rad:+.4} rad"),
            Self::White { sigma_rad, mean_loss_db } => {
                write!(f, "white noise of {sigma_rad:.4} rad: mean loss {mean_loss_db:.3} dB")
            }
            Self::GaussMarkov { sigma_rad, tau_s, mean_loss_db } => {
                write!(
                    f,
                    "Gauss-Markov noise of {sigma_rad:.4} rad, {tau_s} s: mean loss at the place expected {mean_loss_db:.3} dB"
                )
            }
        }
    }
}

/// Laws of the errors of the platforms of a channel for a point. `zero_s`: emission of pulse 0 on the clock
/// of the paths, s; `aperture_taper`: over the pulses.
pub fn laws(
    described: Described,
    row: &ChannelRow,
    paths: &Degradation,
    point_m: [f64; 3],
    zero_s: f64,
    aperture_taper: Taper,
) -> Vec<Law> {
    let (Some(first_s), Some(last_s)) = (paths.times_s.first(), paths.times_s.last()) else {
        return Vec::new();
    };
    let instants_s = [*first_s, 0.5 * (first_s + last_s), *last_s];
    // One platform may carry both ends: their unit vectors add up.
    let mut carried: Vec<(usize, [DVec3; 3])> = Vec::new();
    for (name, path) in [&row.transmitter, &row.receiver].into_iter().zip(paths.truth) {
        let Some(antenna) = described.scene.radar.antenna(name) else { return Vec::new() };
        let towards =
            instants_s.map(|t| (DVec3::from(path.at(t)) - DVec3::from(point_m)).normalize_or_zero());
        match carried.iter_mut().find(|(carrier, _)| *carrier == antenna.platform) {
            Some((_, sum)) => *sum = std::array::from_fn(|i| sum[i] + towards[i]),
            None => carried.push((antenna.platform, towards)),
        }
    }
    let untapered = aperture_taper == Taper::Uniform;
    let errors = |platform: usize| described.nav.get(platform)?.errors.as_ref();
    let found = carried.into_iter().filter_map(|(platform, towards)| {
        let sight = Sight { paths, towards, instants_s, zero_s, untapered };
        Some(sight.laws(errors(platform)?))
    });
    found.flatten().collect()
}

/// How a platform is seen from a point.
struct Sight<'a> {
    paths: &'a Degradation<'a>,
    /// Unit vectors from the point to its antennas, summed, at the first, the middle and the last pulse.
    towards: [DVec3; 3],
    instants_s: [f64; 3],
    zero_s: f64,
    untapered: bool,
}

impl Sight<'_> {
    fn laws(&self, errors: &ErrorModel) -> Vec<Law> {
        let [east, north, up, ..] = &errors.axes;
        let axes = [east, north, up];
        // Noise that comes with every pulse, each with a report of its own.
        let noise = errors.rate_hz.is_none().then(|| [self.white(axes), self.gauss_markov(axes)]);
        let known = [self.bias(axes), self.ramp(axes), self.sinusoid(axes), self.step(axes)];
        known.into_iter().chain(noise.into_iter().flatten()).flatten().collect()
    }

    /// An error along the path at the three instants.
    fn along(&self, axes: [&AxisErrors; 3], value: fn(&AxisErrors) -> f64) -> [f64; 3] {
        let error = axes.map(value);
        self.towards.map(|towards| error.iter().zip(towards.to_array()).map(|(e, u)| e * u).sum())
    }

    /// Standard deviation along the path of independent axes, as a phase.
    fn spread_rad(&self, axes: [&AxisErrors; 3], value: fn(&AxisErrors) -> f64) -> f64 {
        let [_, middle, _] = self.towards;
        let sigma = axes.map(value);
        let power: f64 = sigma.iter().zip(middle.to_array()).map(|(s, u)| (s * u).powi(2)).sum();
        self.wave_number() * power.sqrt()
    }

    fn wave_number(&self) -> f64 {
        std::f64::consts::TAU / self.wavelength_m()
    }

    fn wavelength_m(&self) -> f64 {
        SPEED_OF_LIGHT_MPS / self.paths.carrier_hz
    }

    fn aperture_s(&self) -> f64 {
        let [first_s, _, last_s] = self.instants_s;
        let count = self.paths.times_s.len() as f64;
        (last_s - first_s) * count / (count - 1.0).max(1.0)
    }

    fn range_cells(&self, path_m: f64) -> f64 {
        -path_m * self.paths.bandwidth_hz / SPEED_OF_LIGHT_MPS
    }

    /// The line of sight turns: a constant grows along it, and so does what grows.
    fn cross_range_cells(&self, [first_m, _, last_m]: [f64; 3]) -> f64 {
        let [first_s, _, last_s] = self.instants_s;
        let slope_mps = (last_m - first_m) / (last_s - first_s).max(f64::MIN_POSITIVE);
        ramp_cells(slope_mps, self.aperture_s(), self.wavelength_m())
    }

    fn bias(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let bias_m = self.along(axes, |axis| axis.bias);
        (bias_m != [0.0; 3]).then(|| Law::Bias {
            path_m: bias_m[1],
            range_cells: self.range_cells(bias_m[1]),
            cross_range_cells: self.cross_range_cells(bias_m),
        })
    }

    fn ramp(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let ramp_mps = self.along(axes, |axis| axis.ramp);
        let grown_m = std::array::from_fn(|i| ramp_mps[i] * (self.instants_s[i] - self.zero_s));
        (ramp_mps != [0.0; 3]).then(|| Law::Ramp {
            path_mps: ramp_mps[1],
            range_cells: self.range_cells(grown_m[1]),
            cross_range_cells: self.cross_range_cells(grown_m),
        })
    }

    fn sinusoid(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let beta_rad = self.wave_number() * self.along(axes, |axis| axis.sinusoid)[1].abs();
        let echoes = || paired_echoes(beta_rad, axes[0].sinusoid_hz, self.aperture_s());
        (beta_rad > 0.0).then(|| Law::Sinusoid { beta_rad, echoes: echoes() })
    }

    fn step(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let phase_rad = self.wave_number() * self.along(axes, |axis| axis.step)[1];
        let off_s = self.zero_s + axes[0].step_at_s - self.instants_s[1];
        let central = self.untapered && off_s.abs() < 0.01 * self.aperture_s();
        let peak = central.then(|| step_peak(phase_rad));
        (phase_rad != 0.0).then(|| Law::Step {
            phase_rad,
            loss_db: peak.map(|(_, level_db)| -level_db),
            cross_range_cells: peak.map(|(cells, _)| cells),
        })
    }

    fn white(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let sigma_rad = self.spread_rad(axes, |axis| axis.white);
        (sigma_rad > 0.0).then(|| Law::White { sigma_rad, mean_loss_db: -white_db(sigma_rad) })
    }

    fn gauss_markov(&self, axes: [&AxisErrors; 3]) -> Option<Law> {
        let sigma_rad = self.spread_rad(axes, |axis| axis.gm_sigma);
        let tau_s = axes[0].gm_tau_s;
        (sigma_rad > 0.0).then(|| Law::GaussMarkov {
            sigma_rad,
            tau_s,
            mean_loss_db: -gauss_markov_db(sigma_rad, tau_s, self.aperture_s()),
        })
    }
}
