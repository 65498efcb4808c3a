//! Feeds a processor live: every pulse at its time, with the navigation that the receiver's platform reports.
//!
//! ```text
//! cargo run --release --example feed_processor
//! ```

use std::error::Error;
use std::sync::Arc;

use nereus::{Pulse, Samples, Scenario};

/// Stands for your processor: it gets samples `[channel][sample]` and reported states, platform by platform.
fn process(pulse: &Pulse) {
    let Samples::Cf32(iq) = &pulse.samples else { return };
    let energy: f32 = iq.iter().map(|sample| sample.norm_sqr()).sum();
    if let (0, Some(aircraft)) = (pulse.index % 100, pulse.nav_reported.last()) {
        let [east, north, up] = aircraft.position_m;
        println!(
            "pulse {} at {}: {:.1} dB, aircraft at {east:.1} m East, {north:.1} m North, {up:.1} m up",
            pulse.index,
            pulse.time,
            10.0 * energy.log10()
        );
    }
}

/// Feeds so many pulses, at the PRF.
pub fn feed(pulses: u64) -> Result<(), Box<dyn Error>> {
    // Without this override the scenario sends its pulses as VITA 49.2 over UDP as well.
    let scenario = Scenario::load("configs/live-wire.toml", &[("sink", "[]")])?;
    let outcome = scenario.stream(0..pulses)?.tap(&Arc::default(), process)?;
    outcome.result?;
    println!("{} pulses, {} late", outcome.summary.health.pulses, outcome.summary.health.late);
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    feed(1000)
}
