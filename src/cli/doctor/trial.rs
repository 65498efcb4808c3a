//! What a trial of lateness says of the machine.

use super::Finding;
use crate::bench::lateness::Lateness;
use crate::cli::report::Report;

/// Whether it is fine, and what would help.
pub(super) fn finding(of: &Lateness) -> Finding {
    let remedy = if of.pacer_ahead {
        "end other programs, set the governor to performance, keep a core free (isolcpus=, stream.pacer_core)"
    } else if of.prf_hz > 1000.0 {
        "pulses above 1 kHz are released at ordinary priority: leave a processor free (stream.threads)"
    } else {
        "grant real-time priority (above), or leave a processor free (stream.threads)"
    };
    let found = format!("{} of {} pulses left more than an interval late", of.late, of.pulses);
    Finding::new("lateness", of.late == 0, found, remedy).of(of.max_us, "us")
}

/// The section of the report.
pub(super) fn add_to(report: &mut Report, of: &Lateness, tried: &Finding) {
    let threads = crate::units::counted(of.busy_threads, "busy thread");
    report.title(format!("lateness over {} s at {} Hz, beside {threads}", of.seconds, of.prf_hz));
    let Lateness { p50_us, p99_us, max_us, .. } = of;
    report.row("lateness", format!("p50 {p50_us:.0} us, p99 {p99_us:.0} us, max {max_us:.0} us"));
    let priority = if of.pacer_ahead { "real-time" } else { "ordinary" };
    report.row("pacer", format!("{priority} priority"));
    report.row("late", &tried.found);
    if of.stood_still_s > 0.0 {
        report.row("standstill", format!("the machine stood still for {:.2} s", of.stood_still_s));
    }
    if let Some(remedy) = &tried.remedy {
        report.row("", format!("-> {remedy}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remedies_suit_the_priority() {
        let late = Lateness {
            prf_hz: 250.0,
            seconds: 1.0,
            busy_threads: 2,
            pacer_ahead: false,
            pulses: 250,
            late: 3,
            p50_us: 4.0,
            p99_us: 900.0,
            max_us: 12_000.0,
            stood_still_s: 0.25,
        };
        let remedy = |lateness: &Lateness| finding(lateness).remedy.unwrap();
        assert!(remedy(&late).starts_with("grant"));
        assert!(remedy(&Lateness { prf_hz: 4000.0, ..late.clone() }).starts_with("pulses above 1 kHz"));
        assert!(remedy(&Lateness { pacer_ahead: true, ..late.clone() }).starts_with("end other programs"));
        let mut report = Report::default();
        add_to(&mut report, &late, &finding(&late));
        insta::assert_snapshot!(report.text(), @r"
        lateness over 1 s at 250 Hz, beside 2 busy threads
          lateness    p50 4 us, p99 900 us, max 12000 us
          pacer       ordinary priority
          late        3 of 250 pulses left more than an interval late
          standstill  the machine stood still for 0.25 s
                      -> grant real-time priority (above), or leave a processor free (stream.threads)
        ");
    }
}
