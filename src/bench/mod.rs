//! Assesses a run before it, and measures a pipeline: speed, cost of its stages, error against the reference
//! echo.
//!
//! | page | holds |
//! | --- | --- |
//! | [`assessment`] | all that is found of a run without emitting a pulse |
//! | [`gather`] | pulses of a run, kept in memory |
//! | [`speed`] | real-time factor and the share of each stage |
//! | [`cost`] | calibrated cost of one unit of work on this machine |
//! | [`accuracy`] | error of the streamed echo against the reference |
//! | [`settings`] | the settings that trade speed for accuracy |
//! | [`fit`] | changes that make a run fit into real time, with what each costs |
//! | [`fit_trials`] | which of these do so on this machine |
//! | [`plan`] | what is planned for an error, in figures and in words |
//! | [`clutter`] | statistics of the sea's echo over the azimuth of the wind |
//! | [`clutter_files`] | these as CSV and as a picture |
//! | [`sweep_files`] | that table as CSV and as a picture |
//! | [`sweep`] | a table of speed and error over one or two settings |
//! | [`resources`] | memory, data rate and size of a run, before it |

pub mod accuracy;
pub mod assessment;
pub mod clutter;
pub mod clutter_files;
pub mod cost;
pub mod fit;
pub mod fit_trials;
pub mod gather;
pub mod lateness;
pub mod plan;
pub mod resources;
pub mod settings;
pub mod speed;
pub mod sweep;
pub mod sweep_files;
pub(crate) mod table_and_picture;
