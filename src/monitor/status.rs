//! What browsers get, as JSON.

use serde_json::{Value, json};

use super::history::Instant;
use super::hub::{Hub, Now};
use super::misreport::misreports;
use crate::pulse::PlatformRecord;
use crate::pulse::flags::error_class;
use crate::transport::health::LATENESS_BOUNDS_NS;

/// A number as the page needs it: to so many decimals.
fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (value * scale).round() / scale
}

fn all(values: &[f64], decimals: i32) -> Vec<f64> {
    values.iter().map(|value| rounded(*value, decimals)).collect()
}

/// Figures of the run: what `/api/status` answers and the page shows as its health.
pub fn status(hub: &Hub) -> Value {
    let changes = hub.changes();
    let state = hub.state();
    let counters = &state.counters;
    let ages = |records: &[PlatformRecord]| {
        records.iter().map(|record| rounded(record.age_s, 4)).collect::<Vec<_>>()
    };
    let (reported_ages, true_ages) =
        state.now.as_ref().map_or_else(Default::default, |now| (ages(&now.reported), ages(&now.truth)));
    let navigation: Vec<Value> = hub
        .platforms
        .iter()
        .enumerate()
        .map(|(place, name)| {
            json!({ "platform": name, "report_age_s": reported_ages.get(place), "live_age_s": true_ages.get(place) })
        })
        .collect();
    json!({
        "kind": "status",
        "ended": hub.has_ended(),
        "elapsed_s": rounded(hub.elapsed_s(), 3),
        "pulse": state.now.as_ref().map(|now| now.pulse),
        "time_s": state.now.as_ref().map(|now| rounded(now.time_s, 6)),
        "unix_ns": state.now.as_ref().map(|now| now.unix_ns),
        "released": counters.released,
        "late": counters.late,
        "held_up": counters.held_up,
        "dropped": counters.dropped,
        "slipped_s": counters.slipped_s,
        "made": counters.made,
        "real_time_factor": state.real_time_factor.map(|factor| rounded(factor, 3)),
        "extrapolated": counters.extrapolated,
        "stale": counters.stale,
        "by_class": hub.classes_db.iter().zip(counters.by_class).map(|(db, pulses)| json!({
            "error_db": rounded(*db, 1), "pulses": pulses,
        })).collect::<Vec<_>>(),
        "error_db": state.now.as_ref().and_then(|now| hub.classes_db.get(error_class(now.flags))),
        "lateness": { "bounds_ns": LATENESS_BOUNDS_NS, "pulses": counters.lateness },
        "ring": { "filled": counters.ring_filled, "slots": counters.ring_slots },
        "sinks": counters.sinks,
        "navigation": navigation,
        "losses": state.losses,
        "misreported": misreports(state.history.points(), &hub.platforms, &changes),
        "changes": changes,
        "monitor": {
            "browsers": hub.browsers.load(std::sync::atomic::Ordering::Relaxed),
            "not_shown": state.not_shown,
            "left_out": hub.left_out.load(std::sync::atomic::Ordering::Relaxed),
            "turned_away": hub.turned_away.load(std::sync::atomic::Ordering::Relaxed),
        },
    })
}

/// The latest pulse: the plan and the markers.
pub fn now(now: &Now) -> Value {
    let outline = |points: &[[f64; 2]]| points.iter().map(|point| all(point, 1)).collect::<Vec<_>>();
    json!({
        "kind": "now",
        "pulse": now.pulse,
        "time_s": rounded(now.time_s, 6),
        "window_start_s": now.window_start_s,
        "flags": now.flags,
        "platforms": now.truth.iter().zip(&now.reported).map(|(truth, reported)| json!({
            "true_m": all(&truth.position_m, 3),
            "reported_m": all(&reported.position_m, 3),
            "velocity_mps": all(&truth.velocity_mps, 3),
        })).collect::<Vec<_>>(),
        "antennas": now.antennas_m.iter().zip(&now.footprints).map(|(at, footprint)| json!({
            "position_m": all(at, 1),
            "middle_m": footprint.middle_m.map(|middle| all(&middle, 1)),
            "outline_m": outline(&footprint.outline_m),
        })).collect::<Vec<_>>(),
        "delays_s": now.delays_s,
        "dopplers_hz": all(&now.dopplers_hz, 3),
        "ships": now.ships_m.iter().zip(&now.headings_deg).map(|(at, heading)| json!({
            "position_m": all(at, 2), "heading_deg": rounded(*heading, 2),
        })).collect::<Vec<_>>(),
        "patch_centre_m": now.patch_m.map(|centre| all(&centre, 1)),
    })
}

/// Points of the history from a place on: per point `[pulse, time, then 16 numbers per platform]`.
pub fn history(points: &[Instant], epoch: u32, first: usize) -> Value {
    let row = |point: &Instant| {
        let mut row = vec![point.pulse as f64, rounded(point.time_s, 6)];
        for sample in &point.platforms {
            row.extend(all(&sample.true_m, 3));
            row.extend(all(&sample.reported_m, 3));
            row.extend(all(&sample.position_m, 4));
            row.extend(all(&sample.velocity_mps, 5));
            row.extend(all(&sample.attitude_deg, 5));
            row.push(rounded(sample.age_s, 4));
        }
        row
    };
    json!({ "kind": "history", "epoch": epoch, "first": first, "points": points.iter().map(row).collect::<Vec<_>>() })
}
