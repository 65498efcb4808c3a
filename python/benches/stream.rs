//! Pulses per second of a program in Rust that takes every pulse of a stream: what `stream.py` is compared
//! with.
//!
//!     cargo bench -p nereus-python --bench stream -- configs/mars-1.toml 444

use std::time::Instant;

use nereus::transport::Pace;
use nereus::{Samples, Scenario, ScenarioError};

fn main() -> Result<(), ScenarioError> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let path = words.first().map_or("configs/quickstart.toml", String::as_str);
    let pulses = words.get(1).and_then(|text| text.parse().ok()).unwrap_or(444);
    let scenario = Scenario::load(path, &[])?;
    let (mut first, mut taken, mut sum) = (None, 0u64, 0.0);
    for pulse in scenario.released(0..pulses, Pace::Fast)? {
        let pulse = pulse?;
        // From the first pulse on: what comes before is the same for both programs.
        let begun = *first.get_or_insert_with(Instant::now);
        if let Samples::Cf32(iq) = &pulse.samples {
            sum += f64::from(iq[0].re);
        }
        taken += 1;
        if taken == pulses {
            let rate = (taken - 1) as f64 / begun.elapsed().as_secs_f64();
            println!("{rate:.2}");
        }
    }
    assert!(sum.is_finite());
    Ok(())
}
