//! Wave spectra: S and Psi, spreading, moments.

use std::f64::consts::FRAC_PI_2;
use std::io::Write;

use clap::Args;

use super::csv::{Cell, Table};
use super::sea_keys::{SpectrumKeys, WindKeys};
use super::sweep::{AngleSweep, SpeedSweep, Usual, WaveNumberSweep};
use crate::cli::error::CliError;
use crate::cli::values::within;
use crate::scattering::slope_pdf::MeanSquareSlope;
use crate::sea::spectrum::moments::Moments;
use crate::sea::spectrum::{MAX_WAVE_NUMBER_RAD_M, WaveVector};
use crate::units::cos_sin_of_degrees;

/// Wave numbers that may be asked for, rad/m: the longest is longer than any ocean.
pub(super) const WAVE_NUMBER_RANGE_RAD_M: [f64; 2] = [1e-9, MAX_WAVE_NUMBER_RAD_M];

/// `nereus table spectrum`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableSpectrumArgs {
    /// Wave numbers, rad/m, instead of a sweep
    #[arg(long, value_name = "K,...", value_delimiter = ',')]
    k_rad_m: Vec<f64>,
    #[command(flatten)]
    sweep: WaveNumberSweep,
    #[command(flatten)]
    spectrum: SpectrumKeys,
    #[command(flatten)]
    wind: WindKeys,
}

/// Prints the table.
pub(super) fn spectrum(args: &TableSpectrumArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let usual = Usual::log(1e-3, 1e4, 141);
    let wave_numbers = args.sweep.sweep().or_list("--k-rad-m", &args.k_rad_m, usual)?;
    within("--k-rad-m", &wave_numbers, WAVE_NUMBER_RANGE_RAD_M)?;
    let winds = args.wind.winds()?;
    let mut table = Table::new(out);
    for (wind, sea) in args.spectrum.spectra(&winds, &[wave_numbers.len()])? {
        for &k in &wave_numbers {
            let [down, up, cross] =
                [WaveVector::new(k, 0.0), WaveVector::new(-k, 0.0), WaveVector::new(0.0, k)];
            let s_m3 = sea.omnidirectional_m3(k);
            table.row(&[
                ("u10_mps", Cell::Given(wind.u10_mps)),
                ("k_rad_m", Cell::Given(k)),
                ("s_m3", Cell::Value(s_m3)),
                ("b", Cell::Value(k * k * k * s_m3)),
                ("psi_downwind_m4", Cell::Value(sea.wave_m4(down))),
                ("psi_upwind_m4", Cell::Value(sea.wave_m4(up))),
                ("psi_crosswind_m4", Cell::Value(sea.wave_m4(cross))),
                ("psi_symmetric_along_m4", Cell::Value(sea.symmetric_m4(down))),
                ("psi_symmetric_across_m4", Cell::Value(sea.symmetric_m4(cross))),
            ])?;
        }
    }
    Ok(())
}

/// `nereus table spreading`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableSpreadingArgs {
    /// Azimuths from downwind, degrees, instead of a sweep
    #[arg(long, value_name = "A,...", value_delimiter = ',', allow_hyphen_values = true)]
    azimuth_deg: Vec<f64>,
    #[command(flatten)]
    sweep: AngleSweep,
    /// Wave numbers, rad/m
    #[arg(long, value_name = "K,...", value_delimiter = ',', default_value = "0.1,1,10,100")]
    k_rad_m: Vec<f64>,
    #[command(flatten)]
    spectrum: SpectrumKeys,
    #[command(flatten)]
    wind: WindKeys,
}

/// Prints the table.
pub(super) fn spreading(args: &TableSpreadingArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let usual = Usual::steps(0.0, 360.0, 10.0);
    let azimuths_deg = args.sweep.sweep().or_list("--azimuth-deg", &args.azimuth_deg, usual)?;
    within("--azimuth-deg", &azimuths_deg, [-360.0, 360.0])?;
    within("--k-rad-m", &args.k_rad_m, WAVE_NUMBER_RANGE_RAD_M)?;
    let winds = args.wind.winds()?;
    let mut table = Table::new(out);
    for (wind, sea) in args.spectrum.spectra(&winds, &[azimuths_deg.len(), args.k_rad_m.len()])? {
        for &k in &args.k_rad_m {
            for &azimuth_deg in &azimuths_deg {
                let (cos, sin) = cos_sin_of_degrees(azimuth_deg);
                let wave = WaveVector::new(k * cos, k * sin);
                table.row(&[
                    ("u10_mps", Cell::Given(wind.u10_mps)),
                    ("k_rad_m", Cell::Given(k)),
                    ("azimuth_deg", Cell::Given(azimuth_deg)),
                    ("spreading_per_rad", Cell::Value(sea.spreading_per_rad(wave))),
                    ("spreading_symmetric_per_rad", Cell::Value(sea.symmetric_spreading_per_rad(wave))),
                ])?;
            }
        }
    }
    Ok(())
}

/// `nereus table moments`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableMomentsArgs {
    #[command(flatten)]
    spectrum: SpectrumKeys,
    #[command(flatten)]
    wind: WindKeys,
    #[command(flatten)]
    sweep: SpeedSweep,
    /// Longest wave that counts, rad/m
    #[arg(long, value_name = "K", default_value_t = 1e-4)]
    low_rad_m: f64,
    /// Shortest wave that counts, rad/m
    #[arg(long, value_name = "K", default_value_t = 2e4)]
    high_rad_m: f64,
}

/// Prints the table.
pub(super) fn moments(args: &TableMomentsArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let [least, most] = WAVE_NUMBER_RANGE_RAD_M;
    within("--low-rad-m", &[args.low_rad_m], [least, most])?;
    within("--high-rad-m", &[args.high_rad_m], [args.low_rad_m, most])?;
    let winds = args.wind.listed_or_swept(args.sweep.sweep())?;
    let mut table = Table::new(out);
    for (wind, sea) in args.spectrum.spectra(&winds, &[])? {
        let found = Moments::of(sea.as_ref(), [args.low_rad_m, args.high_rad_m]);
        let measured = MeanSquareSlope::cox_munk_clean(wind.u12_5_mps);
        table.row(&[
            ("u10_mps", Cell::Given(wind.u10_mps)),
            ("u12p5_mps", Cell::Given(wind.u12_5_mps)),
            ("significant_height_m", Cell::Value(found.significant_height_m())),
            ("mss", Cell::Value(found.mean_square_slope)),
            ("mss_up", Cell::Value(found.slope_variance(0.0))),
            ("mss_cross", Cell::Value(found.slope_variance(FRAC_PI_2))),
            ("cox_munk_mss", Cell::Value(measured.total())),
            ("cox_munk_up", Cell::Value(measured.up)),
            ("cox_munk_cross", Cell::Value(measured.cross)),
        ])?;
    }
    Ok(())
}
