//! Replays a recorded flight: the aircraft of a navigation log carries the receiver, antennas and receive
//! window follow.
//!
//! ```text
//! cargo run --release --example replay_flight
//! ```

use nereus::{Scenario, ScenarioError};

/// Replays so many pulses from a time of the log on.
pub fn replay(start_utc: &str, pulses: u64) -> Result<(), ScenarioError> {
    // The log spans five minutes: any second of it can be flown.
    let scenario = Scenario::load("configs/calibration.toml", &[("scene.start_utc", start_utc)])?;
    scenario.each_pulse(0..pulses, |pulse| {
        let aircraft = &pulse.nav_true[1];
        let [east, north, up] = aircraft.position_m;
        let speed_mps = aircraft.velocity_mps.iter().map(|v| v * v).sum::<f64>().sqrt();
        if pulse.index.is_multiple_of(50) {
            println!(
                "{}: {east:.0} m East, {north:.0} m North, {up:.0} m up, {speed_mps:.1} m/s; window opens after {:.2} us",
                pulse.time,
                1e6 * pulse.window_start_s
            );
        }
    })
}

fn main() -> Result<(), ScenarioError> {
    replay("2018-05-30T18:38:35Z", 444)
}
