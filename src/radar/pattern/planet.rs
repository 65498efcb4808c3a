//! Antenna files of Planet (MSI): two cuts of attenuation, and the gain.
//!
//! ```text
//! GAIN 17.2 dBi             dBd without a unit
//! HORIZONTAL 360            angle clockwise from the boresight, seen from above, and attenuation, dB
//! 0 0.0
//! ...
//! VERTICAL 360              angle from the horizon ahead, downwards, through the back at 180
//! ```
//!
//! All directions follow from both cuts, attenuations `H` and `V`, by horizontal projection:
//!
//! `A(az, el) = H(az) + (1 - w) (V(el) - H(0)) + w (V(180 - el) - H(180))`, `w = |az|/180`
//!
//! which is each cut in its plane, and no less than 0. There is no phase: side lobes keep their sign. What
//! the file says of frequency, widths and tilt is not read: the tilt is in the vertical cut.

use num_complex::Complex64;

use super::axis::{Axis, Gridded};
use super::columns::MOST_POINTS;
use super::fault::{Faults, PatternFault};
use crate::units::Decibels;

/// Gain of a dipole, dBi.
const DIPOLE_DBI: f64 = 2.15;
/// Rows of a cut, at most.
const MOST_ROWS: usize = 3600;
/// How far an angle may lie off its place, degrees.
const OFF_DEG: f64 = 0.02;

/// A cut all around: attenuations, dB.
struct Cut {
    name: &'static str,
    rows: Vec<f64>,
}

impl Cut {
    /// At an angle, degrees, straight between its rows.
    fn at(&self, angle_deg: f64) -> f64 {
        let count = self.rows.len();
        let place = angle_deg.rem_euclid(360.0) / 360.0 * count as f64;
        let (row, rest) = (place.floor() as usize, place.fract());
        self.rows[row % count] * (1.0 - rest) + self.rows[(row + 1) % count] * rest
    }
}

/// Reads the text of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Gridded, Vec<PatternFault>> {
    let text = String::from_utf8_lossy(bytes);
    let mut faults = Faults::default();
    let mut gain_dbi = None;
    let mut cuts = ["HORIZONTAL", "VERTICAL"].map(|name| Cut { name, rows: Vec::new() });
    let mut wanted = [0, 0];
    // The cut at hand.
    let mut own: Option<usize> = None;
    for (number, line) in (1u64..).zip(text.lines()) {
        let fields: Vec<&str> = line.split([' ', '\t', ';']).filter(|field| !field.is_empty()).collect();
        let [first, rest @ ..] = &fields[..] else { continue };
        let mut wrong = |wanted| {
            let found = line.trim().chars().take(40).collect();
            faults.push(PatternFault::Line { line: number, found, wanted });
        };
        let keyword = first.to_ascii_uppercase();
        if let Some(cut) = cuts.iter().position(|cut| cut.name == keyword) {
            let count = rest.first().map_or(Some(360), |count| count.parse().ok());
            match count.filter(|count| (4..=MOST_ROWS).contains(count) && count.is_multiple_of(4)) {
                Some(count) if cuts[cut].rows.is_empty() && wanted[cut] == 0 => {
                    (own, wanted[cut]) = (Some(cut), count);
                }
                Some(_) => wrong("each cut once"),
                None => wrong("a number of rows from 4 to 3600 that 4 divides"),
            }
            continue;
        }
        if keyword == "GAIN" {
            gain_dbi = match (rest.first().and_then(|value| value.parse::<f64>().ok()), rest.get(1)) {
                (Some(gain), None) => Some(gain + DIPOLE_DBI),
                (Some(gain), Some(unit)) if unit.eq_ignore_ascii_case("dbd") => Some(gain + DIPOLE_DBI),
                (Some(gain), Some(unit)) if unit.eq_ignore_ascii_case("dbi") => Some(gain),
                _ => None,
            };
            if gain_dbi.is_none_or(|gain| !(-100.0..=100.0).contains(&gain)) {
                wrong("GAIN, a number from -100 to 100, and dBi or dBd");
                gain_dbi = gain_dbi.or(Some(0.0));
            }
            continue;
        }
        // Other words, and rows beyond those of a cut, say nothing here.
        let Some(cut) = own.filter(|cut| cuts[*cut].rows.len() < wanted[*cut]) else { continue };
        let rows = &mut cuts[cut].rows;
        let angle_deg = 360.0 / wanted[cut] as f64 * rows.len() as f64;
        let near = |angle: f64| (angle - angle_deg).abs() < OFF_DEG;
        let values = [Some(*first), rest.first().copied()].map(|text| text?.parse::<f64>().ok());
        match values {
            [Some(angle), Some(attenuation)] if near(angle) && attenuation.abs() <= 300.0 => {
                rows.push(attenuation.abs());
            }
            [Some(_), Some(_)] => {
                wrong("angles from 0 on in equal steps once around, and at most 300 dB");
                rows.push(0.0);
            }
            _ => {
                wrong("an angle and an attenuation in dB");
                rows.push(0.0);
            }
        }
    }
    for (cut, wanted) in cuts.iter().zip(wanted) {
        if cut.rows.is_empty() || cut.rows.len() < wanted {
            let (name, found) = (cut.name, cut.rows.len());
            let wanted = if wanted == 0 { 360 } else { wanted };
            faults.push(PatternFault::Lacks { what: format!("{name}: {found} rows, {wanted} wanted") });
        }
    }
    let Some(gain_dbi) = gain_dbi else {
        faults.push(PatternFault::Lacks { what: "no GAIN: a line like GAIN 12.5 dBi wanted".to_owned() });
        return Err(faults.finish());
    };
    if cuts[0].rows.len() * (cuts[1].rows.len() / 2 + 1) > MOST_POINTS {
        faults.push(PatternFault::TooMany);
    }
    if !faults.list.is_empty() {
        return Err(faults.finish());
    }
    Ok(gridded(gain_dbi, &cuts))
}

fn gridded(gain_dbi: f64, [horizontal, vertical]: &[Cut; 2]) -> Gridded {
    let steps = [horizontal, vertical].map(|cut| 360.0 / cut.rows.len() as f64);
    let azimuth = Axis { first_deg: -180.0, step_deg: steps[0], len: horizontal.rows.len() };
    let elevation = Axis { first_deg: -90.0, step_deg: steps[1], len: vertical.rows.len() / 2 + 1 };
    let mut field = Vec::with_capacity(azimuth.len * elevation.len);
    for row in 0..elevation.len {
        let el_deg = elevation.value_deg(row);
        let [ahead_db, behind_db] =
            [vertical.at(-el_deg) - horizontal.at(0.0), vertical.at(180.0 + el_deg) - horizontal.at(180.0)];
        for column in 0..azimuth.len {
            // Azimuth is to the left here, clockwise there.
            let az_deg = azimuth.value_deg(column);
            let w = az_deg.abs() / 180.0;
            let attenuation_db = horizontal.at(-az_deg) + (1.0 - w) * ahead_db + w * behind_db;
            let gain = Decibels(gain_dbi - attenuation_db.max(0.0)).amplitude_ratio();
            field.push(Some(Complex64::from(gain)));
        }
    }
    Gridded { azimuth, elevation, field }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sector antenna that looks 6 degrees down.
    fn file() -> String {
        let parabola = |angle: f64, width: f64, most: f64| (12.0 * (angle / width).powi(2)).min(most);
        let signed = |n: usize| if n > 180 { n as f64 - 360.0 } else { n as f64 };
        let mut text =
            "NAME sector\nFREQUENCY 902\nGAIN 15.0 dBd\nTILT ELECTRICAL\nHORIZONTAL 360\n".to_owned();
        // Weaker to the right than to the left.
        for n in 0..360 {
            let angle = signed(n);
            text +=
                &format!("{n} {:.2}\n", parabola(angle, if angle > 0.0 { 50.0 } else { 80.0 }, 25.0) + 2.43);
        }
        text += "VERTICAL 360\n";
        (0..360).for_each(|n| text += &format!("{n}\t{:.2}\n", parabola(signed(n) - 6.0, 13.33, 27.43)));
        text
    }

    #[test]
    fn both_cuts_are_those_of_the_file() {
        let found = read(file().as_bytes()).unwrap();
        assert_eq!((found.azimuth.len, found.elevation.len), (360, 181));
        let at = |az: isize, el: isize| {
            let place = ((el + 90) * 360 + az + 180) as usize;
            20.0 * found.field[place].unwrap().norm().log10() - (15.0 + 2.15)
        };
        // The beam is strongest 6 degrees below the horizon.
        assert!(at(0, -6).abs() < 1e-9 && (at(0, 0) + 2.43).abs() < 0.01 && at(0, 6) < -9.0);
        // 20 degrees to the right and to the left.
        assert!((at(-20, 0) + 12.0 * 0.16 + 2.43).abs() < 0.01, "{}", at(-20, 0));
        assert!((at(20, 0) + 12.0 / 16.0 + 2.43).abs() < 0.01, "{}", at(20, 0));
        // Straight back, level and from above.
        assert!((at(-180, 0) + 27.43).abs() < 0.01 && (at(-180, 30) + 27.43).abs() < 0.01);
    }

    #[test]
    fn faults_are_named_with_their_lines() {
        let text = file().replace("GAIN 15.0 dBd", "GAIN high").replace("\n90 25.00", "\n91 25.00");
        let faults: Vec<String> =
            read(text.as_bytes()).err().unwrap().iter().map(ToString::to_string).collect();
        assert!(faults[0].starts_with("line 3: 'GAIN high': GAIN, a number"), "{faults:?}");
        assert!(read(b"GAIN 3\nVERTICAL 360\n0 1\n").err().unwrap().len() == 2);
    }
}
