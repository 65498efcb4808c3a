//! Why a stream ended before its time, and what helps.

use thiserror::Error;

use super::Settings;
use super::schedule::Schedule;

/// Why the pacer ended a run.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PacerError {
    /// Policy `stop`: a pulse was not made in time.
    #[error(
        "{stage} cannot keep up: {:.1} ms after its deadline pulse {index} is not made yet; {}. Allowed: {}, a lighter \
         scene, policy = \"slip\" or \"drop\", or --pace fast",
        late_by_s * 1e3, so_far(*made_hz, *needed_hz), latency.more()
    )]
    Underrun {
        /// The stage that cannot keep up.
        stage: &'static str,
        /// The pulse that was missing.
        index: u64,
        /// How long after its deadline it was still missing, s.
        late_by_s: f64,
        /// Pulses made per second since the start.
        made_hz: f64,
        /// Pulses due per second.
        needed_hz: f64,
        /// What the latency holds.
        latency: InHand,
    },
    /// Policy `stop`: the machine stood still, and a pulse was not made in time afterwards.
    #[error(
        "the machine, or this program, stood still for {stood_still_s:.1} s, and echo generation has not made up for \
         it: {:.1} ms after its deadline pulse {index} is not made yet. Allowed: policy = \"slip\" (time stretches) or \
         \"drop\" (the pulses of that time are missing)", late_by_s * 1e3
    )]
    StoodStill {
        /// For how long, in all, since pulses were last released in time, s.
        stood_still_s: f64,
        /// The pulse that was missing.
        index: u64,
        /// How long after its deadline it was still missing, s.
        late_by_s: f64,
    },
    /// Policy `drop`: every pulse of the run came too late.
    #[error(
        "not one pulse of {pulses} was released: policy = \"drop\" discards what is made too late, and all of them \
         were. Allowed: {}, a lighter scene, policy = \"slip\", or --pace fast", latency.more()
    )]
    NothingReleased {
        /// Pulses of the run.
        pulses: u64,
        /// What the latency holds.
        latency: InHand,
    },
    /// Generation handed over a pulse that is not after the last one.
    #[error("echo generation handed over pulse {index} where {expected} or a later one was due")]
    Order {
        /// The pulse that came.
        index: u64,
        /// The smallest index allowed.
        expected: u64,
    },
}

/// The latency, and what is made before the first pulse is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InHand {
    /// The latency, s.
    pub latency_s: f64,
    /// Emission time of the pulses that are made at once ([`Settings::batch_pulses`]), s.
    pub batch_s: f64,
}

impl InHand {
    /// Of a stream.
    pub(crate) fn of(settings: &Settings, schedule: &Schedule) -> Self {
        let batch_s = settings.batch_pulses as f64 / schedule.times.mean_prf_hz();
        Self { latency_s: settings.latency_s, batch_s }
    }

    /// The latency that would do, as words, where this one is shorter than what is made at once: pulses come
    /// too late then, however fast they are made.
    pub fn remedy(&self) -> Option<String> {
        let Self { latency_s, batch_s } = *self;
        // Not a millisecond more for the last bit of a quotient.
        let enough_ms = (batch_s * 1e3 - 1e-6).ceil();
        (latency_s < batch_s).then(|| {
            format!(
                "stream.latency_ms = {enough_ms:.0} or more (it is {}; pulses are made in blocks, and a block for \
                 every thread is that long)",
                (latency_s * 1e6).round() / 1e3
            )
        })
    }

    /// The latency that helps.
    fn more(&self) -> String {
        self.remedy().unwrap_or_else(|| "more stream.latency_ms".to_owned())
    }
}

/// What was made since the start. Before there is a rate, nothing follows from it.
fn so_far(made_hz: f64, needed_hz: f64) -> String {
    if made_hz == 0.0 {
        return "no other is, either".to_owned();
    }
    let factor = made_hz / needed_hz;
    format!("{made_hz:.1} pulses/s made since the start, {needed_hz:.1} needed (factor {factor:.3})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortage_reads_as_it_should() {
        let error = |index, made_hz, latency_s| PacerError::Underrun {
            stage: "echo generation",
            index,
            late_by_s: 0.00512,
            made_hz,
            needed_hz: 222.0,
            latency: InHand { latency_s, batch_s: 74.0 / 222.0 },
        };
        insta::assert_snapshot!(error(812, 111.0, 0.5), @r#"echo generation cannot keep up: 5.1 ms after its deadline pulse 812 is not made yet; 111.0 pulses/s made since the start, 222.0 needed (factor 0.500). Allowed: more stream.latency_ms, a lighter scene, policy = "slip" or "drop", or --pace fast"#);
        insta::assert_snapshot!(error(0, 0.0, 0.0015), @r#"echo generation cannot keep up: 5.1 ms after its deadline pulse 0 is not made yet; no other is, either. Allowed: stream.latency_ms = 334 or more (it is 1.5; pulses are made in blocks, and a block for every thread is that long), a lighter scene, policy = "slip" or "drop", or --pace fast"#);
    }
}
