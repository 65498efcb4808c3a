//! States as a KML track.

use std::io::Write;

use super::lon_deg;
use crate::nav::solution::Solution;

/// Writes a document of one `gx:Track`: times to a microsecond, degrees to 1e-9, heights above mean sea level
/// (absolute, as KML has it) to 1e-3 m, heading, pitch and roll where all states have them.
pub fn write(solutions: &[Solution], out: &mut Vec<u8>) {
    let turned = solutions.iter().all(|solution| solution.yaw_pitch_roll_rad.is_some());
    // Writing to memory does not fail.
    let _ = out.write_all(
        b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
          <kml xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n\
          <Document><Placemark><gx:Track>\n<altitudeMode>absolute</altitudeMode>\n",
    );
    for solution in solutions {
        let _ = writeln!(out, "<when>{}</when>", solution.time);
    }
    for solution in solutions {
        let place = solution.place;
        let height_m = place.h_m - solution.undulation_m;
        let lat_deg = place.lat_rad.to_degrees();
        let _ =
            writeln!(out, "<gx:coord>{:.9} {lat_deg:.9} {height_m:.3}</gx:coord>", lon_deg(place.lon_rad));
    }
    for [yaw, pitch, roll] in
        solutions.iter().filter_map(|solution| solution.yaw_pitch_roll_rad).filter(|_| turned)
    {
        let [yaw, pitch, roll] = [yaw.to_degrees().rem_euclid(360.0), pitch.to_degrees(), roll.to_degrees()];
        let _ = writeln!(out, "<gx:angles>{yaw:.6} {pitch:.6} {roll:.6}</gx:angles>");
    }
    let _ = out.write_all(b"</gx:Track></Placemark></Document>\n</kml>\n");
}
