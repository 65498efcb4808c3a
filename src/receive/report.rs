//! The report of a receiver.

use std::path::PathBuf;

use serde::Serialize;

use super::context::{Context, Ephemeris};

/// Counters and figures of a reception.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Where it listened.
    pub listen: String,
    /// Room for datagrams that wait to be read, bytes.
    pub receive_buffer_bytes: usize,
    /// Datagrams that the system dropped for want of that room, where it reports that.
    pub kernel_drops: Option<u64>,
    /// Datagrams received.
    pub datagrams: u64,
    /// Bytes in them.
    pub bytes: u64,
    /// Datagrams that are no VITA 49.2 packets, or bad ones.
    pub malformed: u64,
    /// What was wrong with the first of them.
    pub first_fault: Option<String>,
    /// Packets of kinds, classes or streams that are not understood.
    pub unknown: u64,
    /// Signal packets and states that came before the run was described.
    pub undescribed: u64,
    /// Descriptions that contradict earlier ones: another run began, or two send here.
    pub contradictions: u64,
    /// Whole pulses that were received.
    pub pulses: u64,
    /// Pulses of the recordings in `out`, as a reader finds them; none where nothing was to be recorded.
    pub recorded: Option<u64>,
    /// Pulses of which something is missing.
    pub incomplete: u64,
    /// Number of the first pulse.
    pub first_pulse: Option<u64>,
    /// Number of the last.
    pub last_pulse: Option<u64>,
    /// Pulses of which nothing came.
    pub missing: Missing,
    /// Packets that came after later ones of their stream.
    pub overtaken: u64,
    /// Packets that came again.
    pub duplicates: u64,
    /// Packets that came when their pulse had been given up.
    pub too_late: u64,
    /// Signal packets that lie on no pulse's grid of samples.
    pub stray: u64,
    /// Packets whose time stamp is not of the run as it was described, or far from all others.
    pub implausible: u64,
    /// States whose pulse number is not of the run as it was described, not that of their time, or not that
    /// of the other states of their pulse.
    pub misnumbered: u64,
    /// Datagrams of senders that are not listened to (`--from`).
    pub strangers: u64,
    /// Times that the sender restarted: another run was described, or the time stamps went back.
    pub restarts: u64,
    /// Pulses with a number not above that of the one before.
    pub backwards: u64,
    /// From the emission of the first whole pulse to that of the last, s.
    pub emission_span_s: f64,
    /// The same for their arrivals.
    pub arrival_span_s: f64,
    /// Arrivals against time stamps; none where the stream was not sent in real time.
    pub lateness: Option<Lateness>,
    /// The standard contexts of the channels, by channel.
    pub contexts: Vec<Context>,
    /// Last reported state of each platform.
    pub platforms: Vec<Platform>,
    /// What was recorded, where it is.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub out: Vec<PathBuf>,
    /// Older recordings that stay although they were to be replaced.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub kept: Vec<PathBuf>,
    /// Recordings of runs before the last that another program has moved on or removed after they were
    /// complete.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub gone: Vec<PathBuf>,
    /// What ended the reception or the recording early.
    pub error: Option<String>,
    /// What a recording of a run has and the wire does not carry.
    pub not_carried: &'static [&'static str],
}

/// Gaps by three kinds of evidence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Numbers that were skipped.
    pub pulses_by_index: u64,
    /// Pulse intervals without a pulse, by the time stamps and the mean PRF.
    pub pulses_by_time: u64,
    /// Packets, by the packet counts of all streams; sixteen in a row are not seen.
    pub packets_by_count: u64,
}

/// Arrivals of whole pulses against their time stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lateness {
    /// Pulses that it is taken from.
    pub pulses: usize,
    /// Arrival minus emission by the clock of this machine, of the earliest pulse, s: the latency where the
    /// emission is stamped with that clock, else the distance of the clocks.
    pub least_offset_s: f64,
    /// Beyond that offset: median, us.
    pub p50_us: f64,
    /// 99 of 100 are below, us.
    pub p99_us: f64,
    /// The latest, us.
    pub max_us: f64,
}

/// Last reported state of a platform.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Platform {
    /// Its name.
    pub name: String,
    /// The pulse.
    pub pulse: u64,
    /// Position, ENU of the origin, metres.
    pub position_m: [f64; 3],
    /// Velocity, ENU, m/s.
    pub velocity_mps: [f64; 3],
    /// Body to ENU.
    pub attitude_quat: [f64; 4],
    /// Position, ECEF, metres; null where the scene is not georeferenced.
    pub ecef_position_m: [f64; 3],
    /// Velocity, ECEF, m/s.
    pub ecef_velocity_mps: [f64; 3],
    /// Body to ECEF.
    pub ecef_attitude_quat: [f64; 4],
    /// Age of the report at the emission, s.
    pub age_s: f64,
    /// Flags of the platform.
    pub flags: u32,
    /// The standard's ephemeris.
    pub ephemeris: Option<Ephemeris>,
}

/// Offsets of arrivals, as many as are kept.
const KEPT: usize = 1 << 22;

/// Arrivals and emissions of whole pulses.
#[derive(Clone, Debug, Default)]
pub(super) struct Arrivals {
    /// Arrival minus emission, relative to those of the first pulse, s.
    offsets_s: Vec<f64>,
    pub(super) emission_span_s: f64,
    pub(super) arrival_span_s: f64,
    /// Arrival minus emission of the first pulse, s.
    pub(super) first_offset_s: f64,
}

impl Arrivals {
    /// A pulse, by its emission and arrival after those of the first one, s.
    pub(super) fn note(&mut self, emission_s: f64, arrival_s: f64) {
        (self.emission_span_s, self.arrival_span_s) = (emission_s, arrival_s);
        if self.offsets_s.len() < KEPT {
            self.offsets_s.push(arrival_s - emission_s);
        }
    }

    /// Lateness, if arrivals keep step with emissions: within 1 % and the time of a hiccup, 50 ms.
    pub(super) fn lateness(&self) -> Option<Lateness> {
        const STEP: f64 = 0.01;
        const HICCUP_S: f64 = 0.05;
        let drift_s = (self.arrival_span_s - self.emission_span_s).abs();
        if self.offsets_s.len() < 2 || drift_s > STEP * self.emission_span_s + HICCUP_S {
            return None;
        }
        // A burst is not real time either, however short.
        if self.arrival_span_s < 0.5 * self.emission_span_s {
            return None;
        }
        let mut sorted = self.offsets_s.clone();
        sorted.sort_by(f64::total_cmp);
        let least = *sorted.first()?;
        let quantile = |share: f64| {
            let rank = ((share * sorted.len() as f64).ceil() as usize).clamp(1, sorted.len());
            sorted.get(rank - 1).map_or(f64::NAN, |offset| (offset - least) * 1e6)
        };
        Some(Lateness {
            pulses: sorted.len(),
            least_offset_s: self.first_offset_s + least,
            p50_us: quantile(0.5),
            p99_us: quantile(0.99),
            max_us: quantile(1.0),
        })
    }
}

impl Report {
    /// How late pulses came, or why that is not known.
    pub fn lateness_text(&self) -> String {
        match &self.lateness {
            Some(late) => format!(
                "p50 {:.0} us, p99 {:.0} us, max {:.0} us above the earliest pulse; {}",
                late.p50_us,
                late.p99_us,
                late.max_us,
                earliest(late.least_offset_s)
            ),
            None if self.datagrams == 0 => "not reported: nothing was received".to_owned(),
            None if self.pulses < 2 => "not reported: fewer than two whole pulses were received".to_owned(),
            None => "not reported: the stream was not sent in real time".to_owned(),
        }
    }
}

/// When the earliest pulse came. Where that is an hour off, the scenario has another date than this clock.
fn earliest(offset_s: f64) -> String {
    if offset_s.abs() < 3600.0 {
        return format!("that one came {offset_s:.6} s after its emission by this clock");
    }
    let side = if offset_s > 0.0 { "before" } else { "after" };
    let apart_d = offset_s.abs() / 86_400.0;
    format!("emission times are {apart_d:.1} days {side} this machine's clock, so latency cannot be measured")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Before: no report at all of older recordings with names that are not UTF-8.
    #[cfg(unix)]
    #[test]
    fn every_path_of_a_report_is_legible() {
        use std::os::unix::ffi::OsStringExt;
        let paths = vec![PathBuf::from(std::ffi::OsString::from_vec(b"rec\xff".to_vec()))];
        let report = Report { out: paths.clone(), kept: paths.clone(), gone: paths, ..Report::default() };
        let value = serde_json::to_value(&report).unwrap();
        for key in ["out", "kept", "gone"] {
            assert_eq!(value[key], serde_json::json!(["rec\u{fffd}"]), "{key}");
        }
    }

    #[test]
    fn dates_of_scenarios_are_told_from_latencies() {
        assert_eq!(earliest(0.012_345_6), "that one came 0.012346 s after its emission by this clock");
        let years = earliest(208_590_567.0);
        assert!(years.starts_with("emission times are 2414.2 days before this machine's clock"), "{years}");
        assert!(earliest(-86_400.0).starts_with("emission times are 1.0 days after"));
    }
}
