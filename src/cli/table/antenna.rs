//! Antenna gains.

use std::io::Write;

use clap::{Args, ValueEnum};

use super::csv::{Cell, Table};
use super::sweep::{AngleSweep, Usual};
use crate::cli::error::{CliError, Refused};
use crate::cli::values::{Word, one_of, within};
use crate::frames::Vector;
use crate::radar::antenna::Antenna;
use crate::scene::radar::Pattern;
use crate::units::{SPEED_OF_LIGHT_MPS, cos_sin_of_degrees};

/// `nereus table antenna`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableAntennaArgs {
    /// Shape of the aperture
    #[arg(long, value_enum, default_value_t = Aperture::Rect)]
    pub shape: Aperture,
    /// Full width, or diameter of a circle, m
    #[arg(long)]
    pub width_m: Option<f64>,
    /// Full height, m
    #[arg(long)]
    pub height_m: Option<f64>,
    /// Gain of an isotropic antenna, dBi
    #[arg(long, default_value_t = 0.0)]
    pub gain_dbi: f64,
    /// Carrier frequency, Hz
    #[arg(long)]
    pub carrier_hz: f64,
    /// Plane of the cut
    #[arg(long, value_parser = one_of(CUTS), default_value = "az")]
    pub cut: [f64; 2],
    /// Angles from boresight
    #[command(flatten)]
    pub sweep: AngleSweep,
}

/// Planes of a cut: the unit vector of the cut across boresight, [along width, along height].
const CUTS: [Word<[f64; 2]>; 2] =
    [("az", "Azimuth: along the width", [1.0, 0.0]), ("el", "Elevation: along the height", [0.0, 1.0])];

/// Shape of an aperture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Aperture {
    /// Rectangle
    Rect,
    /// Ellipse
    Ellipse,
    /// Circle
    Circle,
    /// Equal gain everywhere
    Isotropic,
}

/// Prints the table.
pub(super) fn antenna(args: &TableAntennaArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let pattern = pattern(args)?;
    let wavelength_m = SPEED_OF_LIGHT_MPS / size("--carrier-hz", Some(args.carrier_hz))?;
    let angles_deg = args.sweep.sweep().values(Usual::steps(-5.0, 5.0, 0.05))?;
    within("--from-deg/--to-deg", &angles_deg, [-90.0, 90.0])?;
    let antenna = Antenna::open(&pattern, wavelength_m)?;
    let mut table = Table::new(out);
    for angle_deg in angles_deg {
        let (ahead, cosine) = cos_sin_of_degrees(angle_deg);
        let [across, up] = args.cut;
        // Apertures have a real field.
        let field = antenna.field_gain(Vector::new(ahead, across * cosine, up * cosine)).re;
        let cells = [
            ("angle_deg", Cell::Given(angle_deg)),
            ("direction_cosine", Cell::Value(cosine)),
            ("gain_dbi", Cell::Decibels(field * field)),
            ("field_gain", Cell::Value(field)),
        ];
        table.row(&cells)?;
    }
    Ok(())
}

fn pattern(args: &TableAntennaArgs) -> Result<Pattern, CliError> {
    let width_m = || size("--width-m", args.width_m);
    let height_m = || size("--height-m", args.height_m);
    Ok(match args.shape {
        Aperture::Isotropic => {
            within("--gain-dbi", &[args.gain_dbi], GAIN_RANGE_DBI)?;
            Pattern::Isotropic { gain_dbi: args.gain_dbi }
        }
        Aperture::Rect => Pattern::Rectangle { width_m: width_m()?, height_m: height_m()? },
        Aperture::Ellipse => Pattern::Ellipse { width_m: width_m()?, height_m: height_m()? },
        Aperture::Circle => Pattern::Ellipse { width_m: width_m()?, height_m: width_m()? },
    })
}

/// Gains of an isotropic antenna that mean something, dBi.
const GAIN_RANGE_DBI: [f64; 2] = [-200.0, 200.0];

fn size(key: &'static str, value: Option<f64>) -> Result<f64, Refused> {
    value.filter(|value| value.is_finite() && *value > 0.0).ok_or_else(|| Refused::NotAllowed {
        key,
        value: value.map_or("(missing)".to_owned(), |value| value.to_string()),
        allowed: "a number above 0".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::args::{Arguments, Command};
    use crate::cli::table::Quantity;

    fn antenna_args(options: &str) -> TableAntennaArgs {
        let words = ["nereus", "table", "antenna", "--carrier-hz", "1e10"];
        let arguments =
            Arguments::try_parse_from(words.into_iter().chain(options.split_whitespace())).unwrap();
        let Command::Table(args) = arguments.command else { panic!("another command") };
        match args.quantity {
            Quantity::Antenna(args) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn rows_follow_the_cut() {
        let options = "--width-m 4 --height-m 0.05 --cut el --from-deg -30 --to-deg 30 --step-deg 30";
        let mut out = Vec::new();
        antenna(&antenna_args(options), &mut out).unwrap();
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
            "--width-m 4",
            "--width-m -4 --height-m 1",
            "--width-m nan --height-m 1",
            "--shape circle --width-m 1 --step-deg 0",
            "--shape circle --width-m 1 --step-deg 1e-9",
            "--shape circle --width-m 1 --from-deg 3 --to-deg 2",
            "--shape circle --width-m 1 --from-deg -91",
            "--shape isotropic --gain-dbi inf",
        ] {
            let error = antenna(&antenna_args(options), &mut Vec::new()).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{options:?}: {error}");
        }
    }
}
