//! How finely and how far a sea must be sampled.

use std::io::Write;

use clap::Args;

use super::csv::{Cell, Table, bound};
use super::sea_keys::{SpectrumKeys, WindKeys, refuse_calm};
use super::sweep::{FrequencySweep, SpeedSweep, Usual};
use crate::cli::error::CliError;
use crate::cli::values::within;
use crate::sea::spectrum::sampling::{BAND_STEP, FacetDensity, least_length_m};

/// Carriers for which facets are counted, Hz.
const CARRIER_RANGE_HZ: [f64; 2] = [1e8, 1e12];

/// `nereus table facet-density`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableFacetDensityArgs {
    /// Carrier frequencies, Hz, instead of a sweep
    #[arg(long, value_name = "F,...", value_delimiter = ',')]
    carrier_hz: Vec<f64>,
    #[command(flatten)]
    sweep: FrequencySweep,
    /// Incidence angles, degrees
    #[arg(long, value_name = "A,...", value_delimiter = ',', default_value = "0")]
    incidence_deg: Vec<f64>,
    #[command(flatten)]
    wind: WindKeys,
}

/// Prints the table.
pub(super) fn facet_density(args: &TableFacetDensityArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let usual = Usual::steps(1e9, 10e9, 1e9);
    let carriers_hz = args.sweep.sweep().or_list("--carrier-hz", &args.carrier_hz, usual)?;
    within("--carrier-hz", &carriers_hz, CARRIER_RANGE_HZ)?;
    // At the horizon itself every surface is smooth and no height is a limit.
    within("--incidence-deg", &args.incidence_deg, [0.0, 89.999])?;
    let winds = args.wind.winds()?;
    refuse_calm(&winds)?;
    bound(&[carriers_hz.len(), args.incidence_deg.len(), winds.len()])?;
    let mut table = Table::new(out);
    for wind in &winds {
        for &incidence_deg in &args.incidence_deg {
            for &carrier_hz in &carriers_hz {
                let ustar_mps = wind.ustar_cardone_mps;
                let found = FacetDensity::rayleigh(ustar_mps, carrier_hz, incidence_deg.to_radians());
                table.row(&[
                    ("u19p5_mps", Cell::Given(wind.u19_5_mps)),
                    ("ustar_cardone_mps", Cell::Given(ustar_mps)),
                    ("incidence_deg", Cell::Given(incidence_deg)),
                    ("carrier_hz", Cell::Given(carrier_hz)),
                    ("rayleigh_height_m", Cell::Value(found.rayleigh_height_m)),
                    ("joint_height_m", Cell::Value(found.joint_height_m)),
                    ("k_rayleigh_rad_m", Cell::Value(found.wave_number_rad_m)),
                    ("facets_per_m", Cell::Value(found.facets_per_m)),
                ])?;
            }
        }
    }
    Ok(())
}

/// `nereus table kpeak-lmin`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableLeastLengthArgs {
    #[command(flatten)]
    spectrum: SpectrumKeys,
    #[command(flatten)]
    wind: WindKeys,
    #[command(flatten)]
    sweep: SpeedSweep,
    /// Steps of wave number, in half-power bandwidths
    #[arg(long, value_name = "X,...", value_delimiter = ',', default_values_t = [BAND_STEP])]
    band_step: Vec<f64>,
}

/// Prints the table.
pub(super) fn least_length(args: &TableLeastLengthArgs, out: &mut dyn Write) -> Result<(), CliError> {
    within("--band-step", &args.band_step, [1e-3, 1.0])?;
    let winds = args.wind.listed_or_swept(args.sweep.sweep())?;
    let mut table = Table::new(out);
    for (wind, sea) in args.spectrum.spectra(&winds, &[args.band_step.len()])? {
        let [low, high] = sea.half_power_band_rad_m();
        for &band_step in &args.band_step {
            table.row(&[
                ("u10_mps", Cell::Given(wind.u10_mps)),
                ("u19p5_mps", Cell::Given(wind.u19_5_mps)),
                ("band_step", Cell::Given(band_step)),
                ("k_peak_rad_m", Cell::Value(sea.peak_rad_m())),
                ("k_low_rad_m", Cell::Value(low)),
                ("k_high_rad_m", Cell::Value(high)),
                ("least_length_m", Cell::Value(least_length_m(sea.as_ref(), band_step))),
            ])?;
        }
    }
    Ok(())
}
