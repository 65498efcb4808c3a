//! Tests motion compensation: what a point target loses when it is focused with the reported track.
//!
//! ```text
//! cargo run --release --example motion_compensation
//! ```
//!
//! Reports of this scenario rise and fall by 1.5 mm at 2.5 Hz: theory expects a loss of 0.43 dB.

use nereus::units::SPEED_OF_LIGHT_MPS;
use nereus::{Scenario, ScenarioError};
use num_complex::Complex64;

/// Loss of the point in the origin over so many pulses, dB.
pub fn loss_db(pulses: u64) -> Result<f64, ScenarioError> {
    let scenario = Scenario::load("configs/mocomp-sinusoid.toml", &[])?;
    let wave_number_radpm = std::f64::consts::TAU * scenario.0.scene.radar.carrier_hz / SPEED_OF_LIGHT_MPS;
    let mut sum = Complex64::ZERO;
    scenario.each_pulse(0..pulses, |pulse| {
        // Distance of the point in the origin, by the true and by the reported position of the aircraft.
        let [truth_m, reported_m] = [&pulse.nav_true[0], &pulse.nav_reported[0]]
            .map(|state| state.position_m.iter().map(|x| x * x).sum::<f64>().sqrt());
        sum += Complex64::cis(2.0 * wave_number_radpm * (truth_m - reported_m));
    })?;
    Ok(-20.0 * (sum.norm() / pulses as f64).log10())
}

fn main() -> Result<(), ScenarioError> {
    println!("loss {:.2} dB; expected 0.43 dB", loss_db(600)?);
    Ok(())
}
