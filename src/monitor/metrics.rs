//! `/metrics`: the figures of the run in the text format of Prometheus (version 0.0.4).

use std::fmt::Write;
use std::sync::atomic::Ordering;

use super::hub::Hub;
use crate::transport::health::LATENESS_BOUNDS_NS;

/// A text under construction.
#[derive(Default)]
struct Page(String);

impl Page {
    /// A metric: what it is, and its values by label.
    fn metric(&mut self, name: &str, kind: &str, help: &str, values: &[(String, f64)]) {
        let _ = write!(self.0, "# HELP nereus_{name} {help}\n# TYPE nereus_{name} {kind}\n");
        for (labels, value) in values {
            let _ = writeln!(self.0, "nereus_{name}{labels} {value}");
        }
    }

    fn counter(&mut self, name: &str, help: &str, value: u64) {
        self.metric(name, "counter", help, &[(String::new(), value as f64)]);
    }

    fn gauge(&mut self, name: &str, help: &str, value: f64) {
        self.metric(name, "gauge", help, &[(String::new(), value)]);
    }
}

/// A label with its value escaped as the format asks.
fn label(name: &str, value: &str) -> String {
    let escaped = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
    format!("{{{name}=\"{escaped}\"}}")
}

/// All figures now.
pub fn metrics(hub: &Hub) -> String {
    let state = hub.state();
    let counters = &state.counters;
    let mut page = Page::default();
    page.counter("pulses_released_total", "Pulses released.", counters.released);
    page.counter(
        "pulses_late_total",
        "Pulses released more than one PRI after their deadline.",
        counters.late,
    );
    page.counter("pulses_dropped_total", "Pulses not made in time and never released.", counters.dropped);
    page.counter("pulses_made_total", "Pulses made.", counters.made);
    page.counter("pulses_extrapolated_total", "Pulses on extrapolated navigation.", counters.extrapolated);
    page.counter("pulses_stale_total", "Pulses on stale navigation.", counters.stale);
    let by_class = hub.classes_db.iter().zip(counters.by_class);
    let by_class: Vec<_> = by_class.map(|(db, n)| (label("error_db", &db.to_string()), n as f64)).collect();
    page.metric("pulses_by_error_total", "counter", "Pulses released by the error asked of them.", &by_class);
    page.gauge("slipped_seconds", "How far the schedule was moved.", counters.slipped_s);
    page.gauge("ring_filled", "Pulses ready at the last release.", counters.ring_filled as f64);
    page.gauge("ring_slots", "Slots of the ring before the release.", counters.ring_slots as f64);
    if let Some(factor) = state.real_time_factor {
        page.gauge("real_time_factor", "Emission time made in a second of generation.", factor);
    }
    let _ = write!(
        page.0,
        "# HELP nereus_lateness_seconds Release minus deadline.\n# TYPE nereus_lateness_seconds histogram\n"
    );
    let mut below = 0;
    for (bucket, pulses) in counters.lateness.iter().enumerate() {
        below += pulses;
        let bound =
            LATENESS_BOUNDS_NS.get(bucket).map_or("+Inf".to_owned(), |ns| (*ns as f64 / 1e9).to_string());
        let _ = writeln!(page.0, "nereus_lateness_seconds_bucket{} {below}", label("le", &bound));
    }
    let _ = writeln!(page.0, "nereus_lateness_seconds_sum {}", counters.lateness_sum_s);
    let _ = writeln!(page.0, "nereus_lateness_seconds_count {below}");
    let sinks = |value: fn(&crate::transport::health::SinkCounters) -> u64| -> Vec<(String, f64)> {
        counters.sinks.iter().map(|sink| (label("sink", &sink.name), value(sink) as f64)).collect()
    };
    page.metric("sink_written_total", "counter", "Pulses that a sink took.", &sinks(|sink| sink.written));
    page.metric("sink_dropped_total", "counter", "Pulses that a sink missed.", &sinks(|sink| sink.dropped));
    page.metric("sink_queue", "gauge", "Pulses that wait for a sink.", &sinks(|sink| sink.queue));
    if let Some(now) = &state.now {
        let ages = hub.platforms.iter().zip(&now.reported);
        let ages: Vec<_> = ages.map(|(name, record)| (label("platform", name), record.age_s)).collect();
        page.metric("report_age_seconds", "gauge", "Emission minus the epoch of the report.", &ages);
    }
    page.gauge("monitor_browsers", "Browsers connected.", hub.browsers.load(Ordering::Relaxed) as f64);
    page.counter("monitor_not_shown_total", "Pulses that the monitor did not take.", state.not_shown);
    page.counter(
        "monitor_left_out_total",
        "Range lines left out for slow browsers.",
        hub.left_out.load(Ordering::Relaxed),
    );
    page.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_escaped() {
        assert_eq!(label("sink", "a\"b\\c\nd"), r#"{sink="a\"b\\c\nd"}"#);
    }
}
