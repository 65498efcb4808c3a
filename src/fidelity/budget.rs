//! The requested error, and the plan that is made to keep it.

use super::Prediction;
use super::cost::{CostTable, Size, Work};
use super::echo_settings::EchoSettings;
use crate::echo::Asked;
use crate::echo::synth::Precision;

/// Budgets from here down are kept in f64, pulse by pulse, dB.
pub const EXACT_DB: f64 = -100.0;

/// What is left out because it is weak stays so far below the budget, dB.
pub const CULLED_DB: f64 = 10.0;

/// What interpolation leaves of the panels of ships stays so far below the budget, dB.
pub const PANELS_DB: f64 = 10.0;

/// A facet that turns away a pulse early or late leaves no more than so far below the budget, dB: a channel
/// may have half of the power of all.
const TURNING_DB: f64 = 3.0;

/// What pulses between the supports of their tiles lack stays so far below the budget, dB.
pub const BETWEEN_DB: f64 = 10.0;

/// Budgets below this may have the surface at nodes found in f64, dB: what transforms in f32 leave of
/// heights is some -83 dB of a sea of 0.6 m rms in X band, and the strongest pulse may have 10 dB over the
/// mean.
const FINE_SURFACE_DB: f64 = -65.0;

/// Budgets below this have the shadows of few facets from heights found anew, dB: between nodes these are off
/// by up to some 1e-3 of the soft edge of a shadow.
const EXACT_SHADOWS_DB: f64 = -60.0;

/// Whether the surface at nodes may be found in f64 for an error; pulses by themselves have no nodes.
pub fn may_have_fine_surface(asked: &Asked) -> bool {
    asked.error_db < FINE_SURFACE_DB && !Budget::of(asked).exact
}

/// What was planned for a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What was asked.
    pub asked: Asked,
    /// What is set.
    pub chosen: EchoSettings,
    /// Its error.
    pub prediction: Prediction,
    /// What it has to do.
    pub work: Work,
    /// Sizes from which that follows.
    pub size: Size,
}

impl Plan {
    /// Seconds of one worker for a pulse, by the cost model.
    pub fn seconds(&self) -> f64 {
        CostTable::TABLE.seconds(&self.work)
    }

    /// The error that pulses keep, dB: what is asked, or what is predicted where that is more.
    pub fn promised_db(&self) -> f64 {
        self.asked.error_db.max(self.prediction.total_db())
    }

    /// Whether the requested error is kept.
    pub fn keeps(&self) -> bool {
        self.prediction.total_db() <= self.asked.error_db
    }

    /// What it would have to do with so many times the facets, the area and the interval of shadows.
    pub fn work_with(&self, times: [f64; 3]) -> Work {
        let interpolates = !self.work.is_one_by_one();
        self.size.scaled(times).work(&self.chosen, interpolates)
    }
}

/// The requested error, and what follows from it for all settings.
#[derive(Clone, Copy)]
pub(super) struct Budget {
    /// What is asked.
    pub asked: Asked,
    /// The error over the power of the echo.
    pub power: f64,
    /// Power of a facet over the mean below which it is left out.
    pub least_power: f64,
    /// Pulses are made one by one with exact scatterer paths.
    pub exact: bool,
    /// Word length.
    pub precision: Precision,
}

impl Budget {
    /// Share of the power of the echo above which a facet that turns away is decided at its pulse.
    pub fn turning(&self) -> f64 {
        10f64.powf((self.asked.error_db - TURNING_DB) / 10.0)
    }

    /// Whether shadows of few facets are those of the reference.
    pub fn needs_exact_shadows(&self) -> bool {
        self.asked.error_db < EXACT_SHADOWS_DB
    }

    pub fn of(asked: &Asked) -> Self {
        let exact = asked.node_pulses.map_or(asked.error_db <= EXACT_DB, |node_pulses| node_pulses <= 1);
        Self {
            asked: *asked,
            power: 10f64.powf(asked.error_db / 10.0),
            least_power: 10f64.powf((asked.error_db - CULLED_DB) / 10.0),
            exact,
            precision: if exact && asked.error_db <= EXACT_DB {
                Precision::Double
            } else {
                Precision::Single
            },
        }
    }
}
