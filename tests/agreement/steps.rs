//! Beams that jump: each pulse is that of an antenna which stands where the beam was set, and the fast echo
//! keeps its error from jump to jump.

use nereus::pipeline::build;

use crate::cases::some_of;
use crate::{blocks, runs};

const ENDS: [&str; 2] = ["transmitter.0.pointing", "receiver.0.pointing"];

fn settings<'a>(pointing: &'a str, more: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    let small = [("scene.patch_size_m", "[48, 48]"), ("stream.pace", "fast")];
    ENDS.map(|end| (end, pointing)).into_iter().chain(small).chain(more.iter().copied()).collect()
}

/// Three directions, seven pulses in each: the reference has the bits of runs whose antennas stand still.
#[test]
fn a_pulse_has_the_bits_of_an_antenna_that_stands_still() {
    let more = [("fidelity.echo", "reference"), ("scene.duration_s", "0.04")];
    let made = |pointing: &str| {
        let run = runs::scene("configs/scan.toml", &settings(pointing, &more));
        runs::kept(build::stream(&run, 0..run.scene.pulses).unwrap())
    };
    let directions = [(-3.0, -2.0), (0.0, -1.5), (4.0, -2.5)];
    let jumping = made(
        "{ kind = 'steps', azimuths_deg = [-3.0, 0.0, 4.0], elevations_deg = [-2.0, -1.5, -2.5], \
         dwell_pulses = 7 }",
    );
    assert!(jumping.len() > 42);
    for (place, (yaw, pitch)) in directions.into_iter().enumerate() {
        let still = made(&format!("{{ kind = 'fixed', yaw_deg = {yaw:.1}, pitch_deg = {pitch:.1} }}"));
        for (jumping, still) in jumping.iter().zip(&still).filter(|(p, _)| p.index as usize / 7 % 3 == place)
        {
            assert!(jumping.samples == still.samples, "pulse {}", still.index);
            let reading = jumping.antennas[1].encoder_deg.unwrap();
            assert!((reading[0] - f64::rem_euclid(yaw, 360.0)).abs() < 1e-9, "{reading:?}");
            assert_eq!(jumping.antennas[1].boresight_quat, still.antennas[1].boresight_quat);
        }
    }
}

/// Dwells as long as a few blocks, as half a block, of one pulse; with intervals in turn.
#[test]
fn the_fast_echo_keeps_its_error() {
    let of = |dwell: u32| {
        format!(
            "{{ kind = 'steps', azimuths_deg = [-3.0, 3.0, -1.0, 40.0], elevations_deg = [-2.0], \
             dwell_pulses = {dwell} }}"
        )
    };
    for (dwell, error_db, pri_us) in some_of([
        (16, "-60", None),
        (150, "-50", None),
        (1, "-60", None),
        (67, "-60", None),
        (12, "-70", Some("[800.0, 850.0, 900.0]")),
    ]) {
        let pointing = of(dwell);
        let more = [("scene.duration_s", "0.15"), ("fidelity.error_db", error_db)];
        let mut own = settings(&pointing, &more);
        own.extend(pri_us.map(|pri_us| ("radar.pri_us", pri_us)));
        let run = blocks::scenario("scan.toml", &own);
        runs::keeps_the_error(&format!("{dwell} pulses in a direction"), &run);
    }
}
