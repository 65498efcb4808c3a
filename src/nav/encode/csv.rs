//! States as a table of comma-separated values.

use std::io::Write;

use crate::nav::solution::Solution;

/// Writes a table: times to a nanosecond, degrees to 1e-11 (1e-6 m), heights to 1e-5 m, angles to 1e-9
/// degrees.
pub fn write(solutions: &[Solution], out: &mut Vec<u8>) {
    let turned = solutions.iter().all(|solution| solution.yaw_pitch_roll_rad.is_some());
    // Writing to memory does not fail.
    let _ = writeln!(
        out,
        "unix_s,lat_deg,lon_deg,height_m{}",
        if turned { ",yaw_deg,pitch_deg,roll_deg" } else { "" }
    );
    for solution in solutions {
        let (mut seconds, mut ns) =
            (solution.time.seconds(), (solution.time.fraction_s() * 1e9).round() as u64);
        if ns >= 1_000_000_000 {
            (seconds, ns) = (seconds + 1, 0);
        }
        let place = solution.place;
        let _ = write!(
            out,
            "{seconds}.{ns:09},{:.11},{:.11},{:.5}",
            place.lat_rad.to_degrees(),
            place.lon_rad.to_degrees(),
            place.h_m
        );
        if let Some([yaw, pitch, roll]) = solution.yaw_pitch_roll_rad.filter(|_| turned) {
            let yaw = yaw.to_degrees().rem_euclid(360.0);
            let _ = write!(out, ",{yaw:.9},{:.9},{:.9}", pitch.to_degrees(), roll.to_degrees());
        }
        let _ = writeln!(out);
    }
}
