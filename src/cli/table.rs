//! `nereus table`: physics as CSV on standard output.

use std::io::Write;

use super::args::{Aperture, Cut, Quantity, TableAntennaArgs, TableArgs};
use super::error::CliError;
use crate::frames::Vector;
use crate::radar::antenna::Antenna;
use crate::scene::radar::Pattern;
use crate::units::{Decibels, SPEED_OF_LIGHT_MPS};

/// Most rows of a table.
const MOST_ROWS: usize = 1_000_000;

/// Prints the table.
pub(super) fn table(args: &TableArgs, out: &mut dyn Write) -> Result<(), CliError> {
    match &args.quantity {
        Quantity::Antenna(args) => antenna(args, out),
    }
}

/// One row an angle: the angle from boresight, its direction cosine, power gain and signed field gain.
fn antenna(args: &TableAntennaArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let pattern = pattern(args)?;
    let wavelength_m = SPEED_OF_LIGHT_MPS / size("--carrier-hz", Some(args.carrier_hz))?;
    let angles_deg = angles_deg(args)?;
    let antenna = Antenna::open(&pattern, wavelength_m)?;
    writeln!(out, "angle_deg,direction_cosine,gain_dbi,field_gain").map_err(CliError::Output)?;
    for angle_deg in angles_deg {
        let (cosine, ahead) = angle_deg.to_radians().sin_cos();
        let direction = match args.cut {
            Cut::Az => Vector::new(ahead, cosine, 0.0),
            Cut::El => Vector::new(ahead, 0.0, cosine),
        };
        // Apertures have a real field.
        let field = antenna.field_gain(direction).re;
        let gain_dbi = Decibels::from_power_ratio(field * field).0;
        writeln!(out, "{angle_deg},{cosine:.12e},{gain_dbi:.9},{field:.12e}").map_err(CliError::Output)?;
    }
    Ok(())
}

fn pattern(args: &TableAntennaArgs) -> Result<Pattern, CliError> {
    Ok(match args.shape {
        Aperture::Isotropic if args.gain_dbi.is_finite() => Pattern::Isotropic { gain_dbi: args.gain_dbi },
        Aperture::Isotropic => {
            return Err(CliError::Gain { value: args.gain_dbi });
        }
        Aperture::Rect => Pattern::Rectangle {
            width_m: size("--width-m", args.width_m)?,
            height_m: size("--height-m", args.height_m)?,
        },
        Aperture::Ellipse => Pattern::Ellipse {
            width_m: size("--width-m", args.width_m)?,
            height_m: size("--height-m", args.height_m)?,
        },
        Aperture::Circle => {
            let diameter_m = size("--width-m", args.width_m)?;
            Pattern::Ellipse { width_m: diameter_m, height_m: diameter_m }
        }
    })
}

fn size(option: &'static str, value: Option<f64>) -> Result<f64, CliError> {
    match value {
        Some(value) if value.is_finite() && value > 0.0 => Ok(value),
        other => {
            let value = other.map_or("(missing)".to_owned(), |value| value.to_string());
            Err(CliError::Size { option, value })
        }
    }
}

/// The angles of the table: `from + i step`, never accumulated.
fn angles_deg(args: &TableAntennaArgs) -> Result<impl Iterator<Item = f64>, CliError> {
    let (from_deg, to_deg, step_deg) = (args.from_deg, args.to_deg, args.step_deg);
    let range = -90.0..=90.0;
    // Half a thousandth of a step, so that the last angle is not lost to rounding.
    let steps = ((to_deg - from_deg) / step_deg + 5e-4).floor();
    let legal = range.contains(&from_deg)
        && range.contains(&to_deg)
        && from_deg <= to_deg
        && step_deg > 0.0
        && steps < MOST_ROWS as f64;
    if !legal {
        return Err(CliError::Sweep { from_deg, to_deg, step_deg, most: MOST_ROWS });
    }
    Ok((0..=steps as usize).map(move |i| from_deg + i as f64 * step_deg))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::args::{Arguments, Command};

    fn antenna_args(options: &[&str]) -> TableAntennaArgs {
        let words = ["nereus", "table", "antenna", "--carrier-hz", "1e10"];
        let arguments = Arguments::try_parse_from(words.iter().chain(options)).unwrap();
        match arguments.command {
            Command::Table(TableArgs { quantity: Quantity::Antenna(args) }) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn rows_follow_the_cut() {
        let options = [
            "--width-m",
            "4",
            "--height-m",
            "0.05",
            "--cut",
            "el",
            "--from-deg",
            "-30",
            "--to-deg",
            "30",
            "--step-deg",
            "30",
        ];
        let mut out = Vec::new();
        antenna(&antenna_args(&options), &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let rows: Vec<Vec<f64>> =
            text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[0][0], -30.0);
        // Twelve decimals of the mantissa are printed.
        assert!((rows[2][1] - 0.5).abs() < 1e-12);
        assert!((rows[2][2] - 20.0 * rows[2][3].abs().log10()).abs() < 1e-8);
        // 4 m x 5 cm at 10 GHz: 34.47 dBi on boresight, the first elevation null beyond 30 deg.
        assert!((rows[1][2] - 34.47).abs() < 0.005, "{}", rows[1][2]);
        assert!(rows[2][2] < rows[1][2] - 2.0 && rows[2][3] > 0.0);
    }

    #[test]
    fn odd_sizes_and_sweeps_are_refused() {
        for options in [
            &["--width-m", "4"][..],
            &["--width-m", "-4", "--height-m", "1"],
            &["--width-m", "nan", "--height-m", "1"],
            &["--shape", "circle", "--width-m", "1", "--step-deg", "0"],
            &["--shape", "circle", "--width-m", "1", "--step-deg", "1e-9"],
            &["--shape", "circle", "--width-m", "1", "--from-deg", "3", "--to-deg", "2"],
            &["--shape", "circle", "--width-m", "1", "--from-deg", "-91"],
            &["--shape", "isotropic", "--gain-dbi", "inf"],
        ] {
            let error = antenna(&antenna_args(options), &mut Vec::new()).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{options:?}: {error}");
        }
    }
}
