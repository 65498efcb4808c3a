//! Reads the pulses of a run on this machine where they lie, in shared memory. In two terminals:
//!
//! ```sh
//! cargo run --release --features shm --example shared_memory
//! cargo run --release --features shm -- run configs/live-wire.toml --set 'sink=[{ kind = "shm" }]'
//! ```
//!
//! Arguments: the service, and for how many seconds to wait for it. The last line is a summary.

use std::time::Duration;

use nereus::receive::shm::{Next, ShmError, Subscriber};

fn main() -> Result<(), ShmError> {
    let mut arguments = std::env::args().skip(1);
    let service = arguments.next().unwrap_or_else(|| "nereus".to_owned());
    let timeout_s = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(60);
    let mut subscriber = Subscriber::open(&service, Duration::from_secs(timeout_s))?;
    let mut power_w = 0.0;
    let end = loop {
        match subscriber.next(Duration::from_secs(2))? {
            Next::Pulse(pulse) => {
                let echo = pulse.channel(0);
                let sum: f64 = echo.iter().map(|sample| f64::from(sample.norm_sqr())).sum();
                power_w += sum / echo.len().max(1) as f64;
                if pulse.header().index % 1000 == 0 {
                    let aircraft = pulse.reported(pulse.header().platforms.saturating_sub(1) as usize);
                    println!(
                        "pulse {}, receiver at {:?}",
                        pulse.header().index,
                        aircraft.map(|at| at.position_m)
                    );
                }
            }
            Next::Quiet => {}
            Next::Ended => break "ended",
            Next::Gone => break "was killed",
        }
    };
    let channel = subscriber.run().map(|run| run["channels"][0]["name"].to_string()).unwrap_or_default();
    println!(
        "{} pulses, {} missed; mean power of channel {channel}: {:.3e} W; the run {end}",
        subscriber.received(),
        subscriber.missed(),
        power_w / subscriber.received().max(1) as f64
    );
    Ok(())
}
