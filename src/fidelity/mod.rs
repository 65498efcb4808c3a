//! From an error that is wanted to the settings of the fast echo, with a prediction of error and cost.
//!
//! Powers of independent errors add, relative to the echo:
//!
//! `e^2 = gridding + Doppler + rounding + in_flight + path + tilt + gain + culled`
//!
//! | part | what it is | found by |
//! | --- | --- | --- |
//! | gridding, Doppler, rounding | images of the grid, Doppler off the mean, word length | [`PredictedError`] of the echo itself |
//! | in flight | acceleration of the water while the pulse is on its way: tiles take it to move evenly | `(2 pi/lambda x g rms slope x tau^2)^2`, `tau` one way |
//! | path | delays between nodes: flight, waves that facets ride on, their heights in f32 | [`probe`] |
//! | tilt | scattering between scattering epochs: facets that the waves turn | [`probe`] |
//! | gain | beams that sweep over the water, between gain epochs; targets between theirs | [`probe`] |
//! | culled | facets left out because they are weak | [`probe`] |
//!
//! of mainlobe tiles and of [`sidelobe`] tiles; each at the worst pulse ([`worst`]) and channel.
//! [`choose::Chooser`] takes the cheapest settings that keep what is asked ([`cost`]). What a sample
//! finds of beams is compared with a closed form in `tests/agreement`.
//!
//! Nothing here knows threads, memory or speed of the machine: the same scene gets the same settings
//! anywhere. Costs are those of a common machine; only their ratios matter.
//!
//! ```
//! use nereus::fidelity::cost::CostTable;
//! use nereus::fidelity::Prediction;
//! let prediction = Prediction { gain: 1e-7, tilt: 1e-7, ..Prediction::default() };
//! assert!((prediction.total_db() + 67.0).abs() < 0.1);
//! assert_eq!(CostTable::TABLE.seconds(&Default::default()), 0.0);
//! ```

pub mod budget;
pub mod cost;
pub mod echo_settings;
pub mod sidelobe;
pub mod choose;
pub mod probe;
mod search;
mod synth_choice;
pub mod turning;
pub mod worst;

use std::f64::consts::TAU;

use thiserror::Error;

use crate::echo::synth::{PredictedError, SynthError};
use crate::paths::PathGenerator;
use crate::radar::fault::RadarError;
use crate::scene::Scene;
use crate::sea::GRAVITY_MPS2;

/// Why there is no plan.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The instrument or its way through the scene.
    #[error(transparent)]
    Radar(#[from] RadarError),
    /// The fast echo.
    #[error(transparent)]
    Echo(#[from] SynthError),
}

/// What pulses have that were made before a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DryRun {
    /// How many they are.
    pub pulses: u64,
    /// Whether they are all pulses of the run.
    pub all: bool,
    /// How many settings were tried until these.
    pub tries: u32,
    /// What is predicted now, a ratio of powers.
    pub error: f64,
}

/// Predicted relative error powers by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prediction {
    /// Of the echo itself.
    pub echo: PredictedError,
    /// Acceleration of the water on the way to it.
    pub in_flight: f64,
    /// Delays between nodes.
    pub path: f64,
    /// Scattering between scattering epochs.
    pub tilt: f64,
    /// Gains between their instants.
    pub gain: f64,
    /// Facets left out.
    pub culled: f64,
    /// Pulses between the supports of their tiles.
    pub between: f64,
    /// Where pulses were made to find out: stands above the sum of all parts.
    pub dry_run: Option<DryRun>,
    /// Of emitters beside the radar's transmitters, over what a pulse receives of them on average: of echoes
    /// that add as powers the sum has no more than the worse of both.
    pub emitters: f64,
}

impl Prediction {
    /// All parts with their names, ratios of powers.
    pub fn parts(&self) -> [(&'static str, f64); 9] {
        let PredictedError { gridding, doppler, rounding } = self.echo;
        [
            ("gridding", gridding),
            ("doppler", doppler),
            ("rounding", rounding),
            ("in_flight", self.in_flight),
            ("path", self.path),
            ("tilt", self.tilt),
            ("gain", self.gain),
            ("culled", self.culled),
            ("between", self.between),
        ]
    }

    /// The sum of all parts, a ratio of powers.
    pub fn modelled(&self) -> f64 {
        self.parts().iter().map(|(_, part)| part).sum()
    }

    /// The same over the mean of pulses of which such a share receives what all of it is predicted of.
    pub(crate) fn over_share(self, share: f64) -> Self {
        let PredictedError { gridding, doppler, rounding } = self.echo;
        let [gridding, doppler, rounding] = [gridding, doppler, rounding].map(|part| part / share);
        Self {
            echo: PredictedError { gridding, doppler, rounding },
            in_flight: self.in_flight / share,
            path: self.path / share,
            tilt: self.tilt / share,
            gain: self.gain / share,
            culled: self.culled / share,
            between: self.between / share,
            ..self
        }
    }

    /// What is predicted, a ratio of powers.
    pub fn total(&self) -> f64 {
        self.dry_run.map_or_else(|| self.modelled(), |run| run.error).max(self.emitters)
    }

    /// What is predicted, dB.
    pub fn total_db(&self) -> f64 {
        10.0 * self.total().log10()
    }
}

/// What the acceleration of the water leaves in the phase: `a tau^2/2` along a path of gradient 2 at most. In
/// deep water `w^2 = g K`, so the rms of `a` is that of the slopes times g, along and up alike.
fn in_flight(scene: &Scene, generator: &PathGenerator) -> f64 {
    let one_way_s = 0.5 * generator.light_time_s();
    let path_m = GRAVITY_MPS2 * generator.rms_slope() * one_way_s * one_way_s;
    (TAU / scene.radar.wavelength_m() * path_m).powi(2)
}
