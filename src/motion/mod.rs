//! Where everything is at an instant.
//!
//! [`Track`] is the trajectory of a platform: recorded, straight, live, in turbulence, or as the platform
//! reports it. [`track`] makes one from recorded fixes with [`outliers`] and [`smoother`]; [`attitude`]
//! derives what a recording leaves out. [`pointing`] mounts antennas on the body
//! and turns them, by the law of a [`scan`] too. Live fixes pass a [`gate`]. [`errors`] and [`changes`] are
//! what is wrong with a report, and what changes of it in mid-run.

#[doc(hidden)]
pub mod attitude;
#[doc(hidden)]
pub mod changes;
pub mod errors;
#[doc(hidden)]
pub mod gate;
#[doc(hidden)]
pub mod gusts;
#[doc(hidden)]
pub mod outliers;
mod place;
#[doc(hidden)]
pub mod pointing;
#[doc(hidden)]
pub mod proposal;
#[doc(hidden)]
pub mod reported_courses;
#[doc(hidden)]
pub mod scan;
#[doc(hidden)]
pub mod smoother;
mod source;
pub mod track;
#[doc(hidden)]
pub mod waypoints;

pub use source::PlatformNav;
pub use track::{FitReport, Report, SourceError, SourceReport, State, Track, TrackError};

use std::sync::Arc;

use crate::frames::SceneFrame;
use crate::motion::changes::PlatformChanges;
use crate::motion::errors::{Circumstances, ErrorModel, Recorded};
use crate::scene::radar::AimFrom;
use crate::time::TimeTag;

/// The two trajectories of a platform, never mixed. In a run they stand in the order of
/// `scene.platforms`.
#[derive(Clone, Debug)]
pub struct PlatformTracks {
    /// What happens: drives delays, phases and gains.
    pub truth: Track,
    /// What the platform reports: all that a servo, a receive window and the record's reader know.
    pub reported: Track,
}

impl PlatformTracks {
    /// The tracks of a platform that flies as `nav` has it, from its track and, where it has one of its own,
    /// its report. Turbulence is true motion; errors are those of the report, or of the truth where the track
    /// is what was reported.
    ///
    /// # Errors
    /// Models that have no meaning or take too much memory.
    pub fn of(
        track: Track,
        reported: Option<Track>,
        nav: &PlatformNav,
        frame: &SceneFrame,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        let recorded = nav.errors.as_ref().filter(|model| model.recorded == Recorded::Reported);
        let mut truth = match recorded {
            Some(model) => track.less_errors(model, of, start)?,
            None => track.clone(),
        };
        if let Some(gusts) = &nav.gusts {
            truth = truth.in_gusts(gusts, frame, of, start)?;
        }
        let report = reported.unwrap_or_else(|| if recorded.is_some() { track } else { truth.clone() });
        let reported = match (&nav.errors, recorded) {
            (None, _) => report,
            // What is recorded as reported is right by definition; it may still come late.
            (_, Some(model)) => report.with_errors(
                &ErrorModel {
                    rate_hz: model.rate_hz,
                    latency_s: model.latency_s,
                    jitter_s: model.jitter_s,
                    between: model.between,
                    dropouts: model.dropouts,
                    ..ErrorModel::default()
                },
                of,
                start,
            )?,
            (Some(model), None) => report.with_errors(model, of, start)?,
        };
        Ok(Self { truth, reported })
    }

    /// The same where what is reported changes while the run goes on.
    ///
    /// # Errors
    /// None of a sound run.
    pub fn with_changes(
        self,
        changes: &Arc<PlatformChanges>,
        of: &Circumstances,
        start: TimeTag,
    ) -> Result<Self, SourceError> {
        Ok(Self { reported: self.reported.with_changes(changes, of, start)?, ..self })
    }

    /// The trajectory that a servo or a receive window acts on.
    pub fn known(&self, aim_from: AimFrom) -> &Track {
        match aim_from {
            AimFrom::Reported => &self.reported,
            AimFrom::True => &self.truth,
        }
    }
}
