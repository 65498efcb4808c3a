//! Makes a recording as fast as the machine can, and reads it back.
//!
//! ```text
//! cargo run --release --example make_recording
//! ```

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use nereus::{Recording, Scenario};

/// Records so many pulses, and opens what was recorded.
pub fn record(path: &Path, pulses: u64) -> Result<Recording, Box<dyn Error>> {
    // A folder of plain files; kind = "hdf5" makes one file of it, in builds with HDF5.
    let sink = format!("[{{ kind = \"plain\", path = {:?} }}]", path.display().to_string());
    let changes = [("sink", &*sink), ("stream.pace", "fast"), ("scene.patch_size_m", "[16, 16]")];
    let scenario = Scenario::load("configs/sea.toml", &changes)?;
    scenario.stream(0..pulses)?.run(&Arc::default(), None)?.result?;
    Ok(Recording::open(path, None)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let recording = record(Path::new("example.plain"), 222)?;
    for pulse in (0..recording.pulses()).step_by(50) {
        let energy: f32 = recording.window(pulse, 0).iter().map(|sample| sample.norm_sqr()).sum();
        println!(
            "pulse {} at {:.4} s: {:.1} dB",
            recording.index[pulse],
            recording.emission_s[pulse],
            10.0 * energy.log10()
        );
    }
    Ok(())
}
