//! What is wrong with the keys of a table.

use thiserror::Error;

use crate::cli::values::OutOfRange;
use crate::scattering::clutter_nrl::ClutterError;
use crate::scattering::permittivity::PermittivityError;
use crate::scene::hull::HullError;
use crate::sea::spectrum::SpectrumError;
use crate::sea::wake::kochin::KochinError;
use crate::sea::wind::WindError;

/// What is wrong with the keys of a table.
#[derive(Debug, Error)]
pub enum TableError {
    /// A value out of range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A size that is missing or not positive and finite.
    #[error("{key} {value} is not allowed; allowed: a number above 0")]
    Size {
        /// The key.
        key: &'static str,
        /// What was given.
        value: String,
    },
    /// Modulation that nothing in the table would show.
    #[error(
        "--modulated has no effect with --splitting mars2007, which tilts nothing within a facet; allowed: --splitting consistent"
    )]
    Unmodulated,
    /// A sweep by steps without rows, or without end.
    #[error(
        "{from_key} {from} {to_key} {to} {step_key} {step}: allowed: finite numbers, from no greater than to, a step above 0 that gives at most {most} rows"
    )]
    Step {
        /// Key of the first value.
        from_key: &'static str,
        /// First value.
        from: f64,
        /// Key of the last value.
        to_key: &'static str,
        /// Last value.
        to: f64,
        /// Key of the step.
        step_key: &'static str,
        /// Step.
        step: f64,
        /// Most rows.
        most: usize,
    },
    /// A sweep by points without rows, or too many.
    #[error(
        "{from_key} {from} {to_key} {to} --points {points}: allowed: finite numbers, from no greater than to (and above 0 in log spacing), 1 to {most} points"
    )]
    Points {
        /// Key of the first value.
        from_key: &'static str,
        /// First value.
        from: f64,
        /// Key of the last value.
        to_key: &'static str,
        /// Last value.
        to: f64,
        /// Number of values.
        points: usize,
        /// Most rows.
        most: usize,
    },
    /// More rows than a table may have.
    #[error("these keys make a table of {rows} rows; allowed: at most {most}")]
    Rows {
        /// Rows asked for.
        rows: usize,
        /// Most rows.
        most: usize,
    },
    /// More seas than a table may prepare.
    #[error("these keys ask for {seas} different seas, each with its integrals; allowed: at most {most}")]
    Seas {
        /// Seas asked for.
        seas: usize,
        /// Most seas.
        most: usize,
    },
    /// A list and a sweep of the same key.
    #[error("{key} and {sweep_key} both say which values to take; allowed: one of them")]
    Both {
        /// The key of the list.
        key: &'static str,
        /// A key of the sweep.
        sweep_key: &'static str,
    },
    /// A height without the speed that holds there.
    #[error("--wind-height-m is the height of a wind speed; allowed with --wind-mps or a sweep of it")]
    HeightAlone,
    /// A key that means nothing to the chosen kind of spectrum.
    #[error("{key} means nothing to --kind {kind}; allowed with {allowed}")]
    Foreign {
        /// The key.
        key: &'static str,
        /// The kind of spectrum.
        kind: &'static str,
        /// The kinds it belongs to.
        allowed: &'static str,
    },
    /// A measured spectrum without its file.
    #[error("--kind measured needs --spectrum-path FILE")]
    NoFile,
    /// A wind too weak for the law asked.
    #[error("a wind of {u10_mps} m/s at 10 m raises no waves; allowed: at least {least_mps} m/s")]
    Calm {
        /// Wind at 10 m, m/s.
        u10_mps: f64,
        /// Weakest wind that raises waves, m/s.
        least_mps: f64,
    },
    /// The wind.
    #[error(transparent)]
    Wind(#[from] WindError),
    /// The spectrum.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// The ship's waves.
    #[error(transparent)]
    Kochin(#[from] KochinError),
    /// The permittivity.
    #[error(transparent)]
    Permittivity(#[from] PermittivityError),
    /// The model of measured clutter.
    #[error(transparent)]
    Clutter(#[from] ClutterError),
}
