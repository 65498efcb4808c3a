//! What the sea returns as it was measured.

use std::io::Write;

use clap::Args;

use super::csv::{Cell, Table, bound};
use super::sweep::{AngleSweep, Usual};
use crate::cli::error::CliError;
use crate::cli::values::within;
use crate::scattering::clutter_nrl::{self, ClutterError, Copolar, GRAZING_DEG, SeaState};

/// `nereus table sigma0-nrl`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableClutterArgs {
    /// Grazing angles, degrees
    #[arg(long, value_name = "A,...", value_delimiter = ',')]
    grazing_deg: Vec<f64>,
    #[command(flatten)]
    sweep: AngleSweep,
    /// Sea states, 0 to 6, fractions allowed [default: all seven]
    #[arg(long, value_name = "S,...", value_delimiter = ',', conflicts_with = "wind_mps")]
    sea_state: Vec<f64>,
    /// Winds of a fully developed sea, m/s at 10 m, 1.98 to 12.9
    #[arg(long, value_name = "U,...", value_delimiter = ',')]
    wind_mps: Vec<f64>,
    /// Carrier frequencies, Hz
    #[arg(long, value_name = "F,...", value_delimiter = ',', default_value = "10e9")]
    carrier_hz: Vec<f64>,
}

impl TableClutterArgs {
    /// Sea states with their winds, m/s; what was given stays as it was given.
    fn seas(&self) -> Result<Vec<(SeaState, f64)>, ClutterError> {
        let of_wind = |&wind_mps: &f64| Ok((SeaState::of_wind(wind_mps)?, wind_mps));
        let of_number = |&number: &f64| SeaState::new(number).map(|sea| (sea, sea.wind_mps()));
        match (&self.wind_mps[..], &self.sea_state[..]) {
            ([], []) => (0..=6).map(|number| of_number(&f64::from(number))).collect(),
            ([], states) => states.iter().map(of_number).collect(),
            (winds_mps, _) => winds_mps.iter().map(of_wind).collect(),
        }
    }
}

/// Prints the table.
pub(super) fn sigma0(args: &TableClutterArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let [least_deg, most_deg] = GRAZING_DEG;
    let usual = Usual::log(least_deg, most_deg, 28);
    let grazing = args.sweep.sweep().or_list("--grazing-deg", &args.grazing_deg, usual)?;
    within("--grazing-deg", &grazing, GRAZING_DEG)?;
    let seas = args.seas()?;
    bound(&[args.carrier_hz.len(), seas.len(), grazing.len()])?;
    // All is computed before anything is printed: a carrier may be out of range.
    let mut rows = Vec::with_capacity(args.carrier_hz.len() * seas.len() * grazing.len());
    for &carrier_hz in &args.carrier_hz {
        for &(sea, u10_mps) in &seas {
            for &grazing_deg in &grazing {
                let Copolar { hh, vv } = clutter_nrl::sigma0(carrier_hz, grazing_deg.to_radians(), sea)?;
                rows.push([
                    ("carrier_hz", Cell::Given(carrier_hz)),
                    ("sea_state", Cell::Given(sea.number())),
                    ("wave_height_m", Cell::Value(sea.wave_height_m())),
                    ("u10_mps", Cell::Given(u10_mps)),
                    ("grazing_deg", Cell::Given(grazing_deg)),
                    ("incidence_deg", Cell::Given(90.0 - grazing_deg)),
                    ("sigma0_hh_db", Cell::Decibels(hh)),
                    ("sigma0_vv_db", Cell::Decibels(vv)),
                ]);
            }
        }
    }
    let mut table = Table::new(out);
    rows.iter().try_for_each(|cells| table.row(cells))
}
