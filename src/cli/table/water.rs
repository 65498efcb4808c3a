//! What sea water is to a radar: permittivity, reflection.

use std::io::Write;

use clap::Args;

use super::csv::{Cell, Table, bound};
use super::sea_keys::WaterKeys;
use super::sweep::{AngleSweep, FrequencySweep, Usual};
use crate::cli::error::CliError;
use crate::cli::values::within;
use crate::scattering::fresnel::reflection;
use crate::units::cos_sin_of_degrees;

/// `nereus table permittivity`
#[derive(Debug, Args)]
pub struct TablePermittivityArgs {
    /// Carrier frequencies, Hz, instead of a sweep
    #[arg(long, value_name = "F,...", value_delimiter = ',')]
    carrier_hz: Vec<f64>,
    #[command(flatten)]
    sweep: FrequencySweep,
    #[command(flatten)]
    water: WaterKeys,
}

/// Prints the table.
pub(super) fn permittivity(args: &TablePermittivityArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let (from_hz, to_hz) = args.water.model.range().frequency_hz;
    let usual = Usual::log(from_hz, to_hz, 40);
    let carriers_hz = args.sweep.sweep().or_list("--carrier-hz", &args.carrier_hz, usual)?;
    bound(&[carriers_hz.len(), args.water.count()])?;
    let media = args.water.media(&carriers_hz)?;
    let mut table = Table::new(out);
    for (carrier_hz, water, permittivity) in media {
        table.row(&[
            ("carrier_hz", Cell::Given(carrier_hz)),
            ("temperature_c", Cell::Given(water.temperature_c)),
            ("salinity_psu", Cell::Given(water.salinity_gpkg)),
            ("permittivity_re", Cell::Value(permittivity.re)),
            ("permittivity_im", Cell::Value(permittivity.im)),
        ])?;
    }
    Ok(())
}

/// `nereus table fresnel`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableFresnelArgs {
    /// Incidence angles, degrees, instead of a sweep
    #[arg(long, value_name = "A,...", value_delimiter = ',')]
    incidence_deg: Vec<f64>,
    #[command(flatten)]
    sweep: AngleSweep,
    /// Carrier frequencies, Hz
    #[arg(long, value_name = "F,...", value_delimiter = ',', default_value = "10e9")]
    carrier_hz: Vec<f64>,
    #[command(flatten)]
    water: WaterKeys,
}

/// Prints the table.
pub(super) fn fresnel(args: &TableFresnelArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let usual = Usual::steps(0.0, 90.0, 5.0);
    let angles_deg = args.sweep.sweep().or_list("--incidence-deg", &args.incidence_deg, usual)?;
    within("--incidence-deg", &angles_deg, [0.0, 90.0])?;
    bound(&[angles_deg.len(), args.carrier_hz.len(), args.water.count()])?;
    let media = args.water.media(&args.carrier_hz)?;
    let mut table = Table::new(out);
    for (carrier_hz, water, permittivity) in media {
        for &angle_deg in &angles_deg {
            let found = reflection(permittivity, cos_sin_of_degrees(angle_deg).0);
            table.row(&[
                ("carrier_hz", Cell::Given(carrier_hz)),
                ("temperature_c", Cell::Given(water.temperature_c)),
                ("salinity_psu", Cell::Given(water.salinity_gpkg)),
                ("incidence_deg", Cell::Given(angle_deg)),
                ("rv_re", Cell::Value(found.v.re)),
                ("rv_im", Cell::Value(found.v.im)),
                ("rh_re", Cell::Value(found.h.re)),
                ("rh_im", Cell::Value(found.h.im)),
                ("power_v", Cell::Value(found.v.norm_sqr())),
                ("power_h", Cell::Value(found.h.norm_sqr())),
            ])?;
        }
    }
    Ok(())
}
