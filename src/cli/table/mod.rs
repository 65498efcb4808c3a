//! `nereus table`: physics as CSV on standard output.
//!
//! One file a family of tables. Keys bear their units and angles are in degrees, here and nowhere below.
//! Where a key takes a list, a table has one row for every combination of the lists; one key of each table
//! may be swept instead ([`sweep`]). Columns bear their units too; decibels of nothing are `-inf`.

mod antenna;
mod clutter;
mod csv;
mod hull;
mod sampling;
mod scattering;
mod sea_keys;
mod sweep;
mod water;
mod waves;
mod wind;

use std::io::Write;

use clap::{Args, Subcommand};

use antenna::TableAntennaArgs;
use clutter::TableClutterArgs;
use hull::{TableHullArgs, TableWakeResistanceArgs};
use sampling::{TableFacetDensityArgs, TableLeastLengthArgs};
use scattering::{TableSigma0Args, TableSlopePdfArgs};
use water::{TableFresnelArgs, TablePermittivityArgs};
use waves::{TableMomentsArgs, TableSpectrumArgs, TableSpreadingArgs};
use wind::TableWindArgs;

use super::error::CliError;

/// How its defaults differ from those of scenarios.
const USUAL: &str = "The default sea is that of the paper (--kind elfouhaily-fung-lee, --ustar-mps 0.36), not that of \
                     scenarios: for theirs give --kind elfouhaily and --wind-mps, the sea.wind_mps of yours.";

/// Most rows of a table.
const MOST_ROWS: usize = 1_000_000;

/// `nereus table`
#[derive(Debug, Args)]
#[command(after_help = USUAL)]
pub struct TableArgs {
    /// Which quantity
    #[command(subcommand)]
    pub quantity: Quantity,
}

/// What can be tabulated.
#[derive(Debug, Subcommand)]
pub enum Quantity {
    /// Gain of an aperture along a cut through its boresight
    ///
    /// The field gain is signed: sidelobes alternate. Sweep: angle from boresight, -5 to 5 degrees by 0.05
    /// unless given.
    Antenna(TableAntennaArgs),
    /// Relative permittivity of sea water against frequency
    ///
    /// Time convention exp(+jwt), so the imaginary part is negative. Sweep: carrier, 40 points in log spacing
    /// over the range of the model unless given.
    Permittivity(TablePermittivityArgs),
    /// Fresnel reflection of sea water against incidence
    ///
    /// Field coefficients and their powers, both polarisations. Sweep: incidence, 0 to 90 degrees by 5 unless
    /// given.
    Fresnel(TableFresnelArgs),
    /// Wind at the heights of the laws, from a speed or a friction velocity
    ///
    /// Sweep: speed at --wind-height-m, 1 to 25 m/s by 1.
    Wind(TableWindArgs),
    /// Wave spectrum against wave number
    ///
    /// Omnidirectional S, curvature B = K^3 S, and Psi of waves that travel downwind, upwind and crosswind;
    /// then the symmetrised Psi, which scattering uses, along and across the wind. Sweep: wave number, 0.001
    /// to 10000 rad/m, 141 points in log spacing unless given.
    Spectrum(TableSpectrumArgs),
    /// Directional spreading of waves against azimuth
    ///
    /// Azimuth from the direction the wind blows towards, counter-clockwise. Sweep: azimuth, 0 to 360 degrees
    /// by 10 unless given.
    Spreading(TableSpreadingArgs),
    /// Significant height and slopes against wind, Cox and Munk's slopes beside them
    ///
    /// Sweep: speed at --wind-height-m, 1 to 25 m/s by 1.
    Moments(TableMomentsArgs),
    /// Normalised radar cross section of the sea, mono- and bistatic, all channels
    ///
    /// Channels are named receiver first. sigma0 is the sum of the Bragg part (spm) and the specular part
    /// (go), per unit area of the facet's plane; without --facet-m per unit area of the mean sea surface: no
    /// wave is resolved then. Without --scattering-deg the scattering angle is the incidence; with the
    /// default azimuth of 180 that is monostatic. Sweep: the angle named by --vary; incidence or scattering 0
    /// to 80 degrees by 5, azimuth or aspect 0 to 360 by 10 unless given.
    Sigma0(TableSigma0Args),
    /// Measured cross section of the sea, by the empirical NRL clutter model
    ///
    /// For comparison only: no echo is computed with it. Mean over the wind's directions, by sea state; with
    /// --wind-mps that of the fully developed sea. Sweep: grazing angle, 0.1 to 60 degrees, 28 points in log
    /// spacing unless given.
    #[command(name = "sigma0-nrl")]
    Sigma0Nrl(TableClutterArgs),
    /// Density of sea slopes (Cox and Munk)
    ///
    /// Sweep: the slope named by --vary, -0.5 to 0.5 by 0.02 unless given.
    SlopePdf(TableSlopePdfArgs),
    /// Facets per metre by Rayleigh's criterion against carrier
    ///
    /// Sweep: carrier, 1 to 10 GHz by 1 GHz unless given.
    FacetDensity(TableFacetDensityArgs),
    /// Peak of a spectrum and least length of a patch against wind
    ///
    /// The half-power band is that of the spectrum itself. Sweep: speed at --wind-height-m, 1 to 25 m/s by 1.
    KpeakLmin(TableLeastLengthArgs),
    /// Particulars of a hull, those stated in its file beside those of its offsets
    ///
    /// A difference is in percent of what is stated; that of the centre of buoyancy in percent of the length.
    /// --png draws the body plan.
    Hull(TableHullArgs),
    /// Wave resistance of a thin ship against speed
    ///
    /// cw is the resistance over the dynamic pressure and the wetted surface. Sweep: speed, 1 to 15 m/s by
    /// 0.5 unless given.
    WakeResistance(TableWakeResistanceArgs),
}

/// Prints the table.
pub(super) fn table(args: &TableArgs, out: &mut dyn Write) -> Result<(), CliError> {
    match &args.quantity {
        Quantity::Antenna(args) => antenna::antenna(args, out),
        Quantity::Permittivity(args) => water::permittivity(args, out),
        Quantity::Fresnel(args) => water::fresnel(args, out),
        Quantity::Wind(args) => wind::wind(args, out),
        Quantity::Spectrum(args) => waves::spectrum(args, out),
        Quantity::Spreading(args) => waves::spreading(args, out),
        Quantity::Moments(args) => waves::moments(args, out),
        Quantity::Sigma0(args) => scattering::sigma0(args, out),
        Quantity::Sigma0Nrl(args) => clutter::sigma0(args, out),
        Quantity::SlopePdf(args) => scattering::slope_pdf(args, out),
        Quantity::FacetDensity(args) => sampling::facet_density(args, out),
        Quantity::KpeakLmin(args) => sampling::least_length(args, out),
        Quantity::Hull(args) => hull::hull(args, out),
        Quantity::WakeResistance(args) => hull::wake_resistance(args, out),
    }
}
