//! What the sea returns: radar cross section, and the density of slopes behind its specular part.

use std::io::Write;

use clap::{Args, ValueEnum};

use super::csv::{Cell, Table, bound};
use super::sea_keys::{SpectrumKeys, WaterKeys, WindKeys, bound_seas};
use super::sweep::{AngleSweep, SlopeSweep, Sweep, Usual};
use super::waves::WAVE_NUMBER_RANGE_RAD_M;
use crate::cli::error::{CliError, Refused};
use crate::cli::values::{Word, one_of, within};
use crate::scattering::kind::Kind;
use crate::scattering::kind::clean::Clean;
use crate::scattering::kind::slick::Slick;
use crate::scattering::sigma0::{Relaxation, SeaView, path};
use crate::scattering::slope_pdf::SlopePdf;
use crate::scattering::two_scale;
use crate::scene::sea::{LightWinds, Splitting};
use crate::units::cos_sin_of_degrees;

/// Facets that may be asked for, m.
const FACET_RANGE_M: [f64; 2] = [1e-3, 1e4];
/// Relaxation rates that may be asked for, 1/s.
const RELAXATION_RANGE_PER_S: [f64; 2] = [0.01, 1000.0];
/// Steepest slope of a facet, or of a density, that may be asked for.
const STEEPEST: f64 = 10.0;

/// Kind of water surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Surface {
    /// Clean water
    Clean,
    /// Under an oil film
    Slick,
}

impl Surface {
    fn kind(self) -> Box<dyn Kind> {
        match self {
            Self::Clean => Box::new(Clean),
            Self::Slick => Box::new(Slick::default()),
        }
    }
}

/// `nereus table sigma0`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableSigma0Args {
    /// The angle that is swept
    #[arg(long, value_enum, default_value_t = Angle::Incidence)]
    vary: Angle,
    #[command(flatten)]
    sweep: AngleSweep,
    /// Angles between the vertical and the transmitter, degrees [default: 45 when another angle is swept]
    #[arg(long, value_name = "A,...", value_delimiter = ',')]
    incidence_deg: Vec<f64>,
    /// Angles between the vertical and the receiver, degrees [default: the incidence]
    #[arg(long, value_name = "A,...", value_delimiter = ',')]
    scattering_deg: Vec<f64>,
    /// Azimuths of the receiver from the direction of incidence, degrees: 0 forward [default: 180, back]
    #[arg(long, value_name = "A,...", value_delimiter = ',', allow_hyphen_values = true)]
    azimuth_deg: Vec<f64>,
    /// Directions the wind blows towards, from the direction of incidence, degrees
    /// [default: 180, the transmitter looks upwind]
    #[arg(long, value_name = "A,...", value_delimiter = ',', allow_hyphen_values = true)]
    aspect_deg: Vec<f64>,
    /// Carrier frequencies, Hz
    #[arg(long, value_name = "F,...", value_delimiter = ',', default_value = "10e9")]
    carrier_hz: Vec<f64>,
    /// How waves are shared between specular and Bragg part
    #[arg(long, value_parser = one_of(SPLITTINGS), default_value = "consistent")]
    splitting: Splitting,
    /// Side of a facet, whose own slopes are resolved, m
    #[arg(long, value_name = "X")]
    facet_m: Option<f64>,
    /// Slope of the facet along the direction of incidence
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    slope_x: f64,
    /// Slope of the facet to the left of the direction of incidence
    #[arg(long, value_name = "X", default_value_t = 0.0)]
    slope_y: f64,
    /// Wave number above which waves scatter by Bragg, rad/m
    /// [default: a third of the radar's, or the highest resolved]
    #[arg(long, value_name = "K")]
    cut_rad_m: Option<f64>,
    /// Do not average the Bragg part over unresolved tilts
    #[arg(long)]
    untilted: bool,
    /// Modulate the Bragg waves of unresolved tilts by the relaxation-rate model
    #[arg(long, conflicts_with = "untilted")]
    modulated: bool,
    /// Rate at which modulated waves relax, 1/s
    /// [default: the growth rate of the Bragg waves seen at 45 degrees]
    #[arg(long, value_name = "X", requires = "modulated")]
    relaxation_per_s: Option<f64>,
    /// Bragg waves in light wind
    #[arg(long, value_parser = one_of(LIGHT_WINDS), default_value = "threshold")]
    light_wind: LightWinds,
    /// Give the slope density its Gram-Charlier terms
    #[arg(long)]
    gram_charlier: bool,
    /// Add breaking waves, in columns of their own and to the sum
    #[arg(long)]
    breaking: bool,
    /// Kind of water surface
    #[arg(long, value_enum, default_value_t = Surface::Clean)]
    surface: Surface,
    #[command(flatten)]
    spectrum: SpectrumKeys,
    #[command(flatten)]
    wind: WindKeys,
    #[command(flatten)]
    water: WaterKeys,
}

/// An angle of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Angle {
    /// Incidence
    Incidence,
    /// Scattering angle
    Scattering,
    /// Azimuth of the receiver
    Azimuth,
    /// Aspect of the wind
    Aspect,
}

/// How waves are shared.
const SPLITTINGS: [Word<Splitting>; 2] = [
    ("consistent", "Each wave counts once", Splitting::Consistent),
    ("mars2007", "As the paper: all slopes and the whole spectrum", Splitting::Mars2007),
];
/// Bragg waves in light wind.
const LIGHT_WINDS: [Word<LightWinds>; 2] = [
    ("threshold", "None below the wind that sustains them, never fewer in more wind", LightWinds::Threshold),
    ("published", "Those of the spectrum as published", LightWinds::AsPublished),
];
/// Names of the columns of each part, by channel.
const PARTS: [[&str; 4]; 4] = [
    ["sigma0_hh_db", "sigma0_hv_db", "sigma0_vh_db", "sigma0_vv_db"],
    ["spm_hh_db", "spm_hv_db", "spm_vh_db", "spm_vv_db"],
    ["go_hh_db", "go_hv_db", "go_vh_db", "go_vv_db"],
    ["breaking_hh_db", "breaking_hv_db", "breaking_vh_db", "breaking_vv_db"],
];

/// The angles of a table, degrees.
struct Angles {
    incidence: Vec<f64>,
    /// Empty: the incidence.
    scattering: Vec<f64>,
    azimuth: Vec<f64>,
    aspect: Vec<f64>,
}

impl Angles {
    fn of(args: &TableSigma0Args) -> Result<Self, Refused> {
        let values = |angle, key, list: &[f64], usual: Usual, single: &[f64], range| {
            varied(args.sweep.sweep(), angle == args.vary, (key, list), usual, single, range)
        };
        let (rise, turn) = (Usual::steps(0.0, 80.0, 5.0), Usual::steps(0.0, 360.0, 10.0));
        let (up, around) = ([0.0, 90.0], [-360.0, 360.0]);
        let incidence = &args.incidence_deg;
        Ok(Self {
            incidence: values(Angle::Incidence, "--incidence-deg", incidence, rise, &[45.0], up)?,
            scattering: values(Angle::Scattering, "--scattering-deg", &args.scattering_deg, rise, &[], up)?,
            azimuth: values(Angle::Azimuth, "--azimuth-deg", &args.azimuth_deg, turn, &[180.0], around)?,
            aspect: values(Angle::Aspect, "--aspect-deg", &args.aspect_deg, turn, &[180.0], around)?,
        })
    }

    /// How many values each angle of a path has.
    fn lengths(&self) -> [usize; 3] {
        [self.incidence.len(), self.scattering.len().max(1), self.azimuth.len()]
    }

    /// Incidence, scattering angle and azimuth of every path, degrees.
    fn paths(&self) -> impl Iterator<Item = [f64; 3]> {
        self.incidence.iter().flat_map(move |incidence| {
            let scattering =
                if self.scattering.is_empty() { std::slice::from_ref(incidence) } else { &self.scattering };
            scattering.iter().flat_map(move |scattering| {
                self.azimuth.iter().map(move |azimuth| [*incidence, *scattering, *azimuth])
            })
        })
    }
}

impl TableSigma0Args {
    /// Refuses numbers out of range.
    fn check(&self) -> Result<(), Refused> {
        within("--facet-m", &self.facet_m, FACET_RANGE_M)?;
        within("--cut-rad-m", &self.cut_rad_m, WAVE_NUMBER_RANGE_RAD_M)?;
        if self.modulated && self.splitting == Splitting::Mars2007 {
            return Err(Refused::Unmodulated);
        }
        within("--relaxation-per-s", &self.relaxation_per_s, RELAXATION_RANGE_PER_S)?;
        within("--slope-x", &[self.slope_x], [-STEEPEST, STEEPEST])?;
        within("--slope-y", &[self.slope_y], [-STEEPEST, STEEPEST])
    }
}

/// Prints the table.
pub(super) fn sigma0(args: &TableSigma0Args, out: &mut dyn Write) -> Result<(), CliError> {
    let angles = Angles::of(args)?;
    args.check()?;
    let media = args.water.media(&args.carrier_hz)?;
    let winds = args.wind.winds()?;
    let seas = [media.len(), winds.len(), angles.aspect.len()];
    bound_seas(&seas)?;
    bound(&[&seas[..], &angles.lengths()].concat())?;
    let spectra = args.spectrum.that_scatter(&winds, args.light_wind)?;
    let settings = two_scale::Settings {
        splitting: args.splitting,
        cut_radpm: args.cut_rad_m,
        tilt_average: !args.untilted,
        gram_charlier: args.gram_charlier,
    };
    let usual = args.modulated.then_some(Relaxation::Growth);
    let relaxation = args.relaxation_per_s.map(Relaxation::Rate).or(usual);
    let kind = args.surface.kind();
    let mut table = Table::new(out);
    for (carrier_hz, water, permittivity) in media {
        for (wind, spectrum) in winds.iter().zip(&spectra) {
            for &aspect_deg in &angles.aspect {
                let view = SeaView {
                    carrier_hz,
                    permittivity,
                    wind,
                    spectrum: spectrum.as_ref(),
                    kind: kind.as_ref(),
                    aspect: cos_sin_of_degrees(aspect_deg),
                    facet_m: args.facet_m,
                    relaxation,
                    breaking: args.breaking,
                    settings,
                };
                let sigma0 = view.sigma0();
                for of_path @ [incidence_deg, scattering_deg, azimuth_deg] in angles.paths() {
                    let found = sigma0(&path(of_path.map(cos_sin_of_degrees)), [args.slope_x, args.slope_y]);
                    let mut cells = vec![
                        ("carrier_hz", Cell::Given(carrier_hz)),
                        ("temperature_c", Cell::Given(water.temperature_c)),
                        ("salinity_psu", Cell::Given(water.salinity_gpkg)),
                        ("u10_mps", Cell::Given(wind.u10_mps)),
                        ("aspect_deg", Cell::Given(aspect_deg)),
                        ("incidence_deg", Cell::Given(incidence_deg)),
                        ("scattering_deg", Cell::Given(scattering_deg)),
                        ("azimuth_deg", Cell::Given(azimuth_deg)),
                    ];
                    let parts = [found.sum, found.bragg, found.specular].into_iter().chain(found.breaking);
                    for (names, [[vv, vh], [hv, hh]]) in PARTS.iter().zip(parts) {
                        cells.extend(names.iter().copied().zip([hh, hv, vh, vv].map(Cell::Decibels)));
                    }
                    table.row(&cells)?;
                }
            }
        }
    }
    Ok(())
}

/// Values of a key: of the one that is varied those of its list or of the sweep, of others those of the list
/// or a single one.
fn varied(
    sweep: Sweep,
    is_varied: bool,
    (key, list): (&'static str, &[f64]),
    usual: Usual,
    single: &[f64],
    range: [f64; 2],
) -> Result<Vec<f64>, Refused> {
    let values = match list {
        _ if is_varied => sweep.or_list(key, list, usual)?,
        [] => single.to_vec(),
        list => list.to_vec(),
    };
    within(key, &values, range)?;
    Ok(values)
}

/// `nereus table slope-pdf`
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct TableSlopePdfArgs {
    /// The slope that is swept
    #[arg(long, value_enum, default_value_t = Direction::Downwind)]
    vary: Direction,
    #[command(flatten)]
    sweep: SlopeSweep,
    /// Slopes downwind (rising the way the wind blows) [default: 0 when the other is swept]
    #[arg(long, value_name = "X,...", value_delimiter = ',', allow_hyphen_values = true)]
    downwind_slope: Vec<f64>,
    /// Slopes crosswind (rising to the left of it) [default: 0 when the other is swept]
    #[arg(long, value_name = "X,...", value_delimiter = ',', allow_hyphen_values = true)]
    crosswind_slope: Vec<f64>,
    /// Kind of water surface
    #[arg(long, value_enum, default_value_t = Surface::Clean)]
    surface: Surface,
    /// Give the density its Gram-Charlier terms
    #[arg(long)]
    gram_charlier: bool,
    #[command(flatten)]
    wind: WindKeys,
}

/// A direction of slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Direction {
    /// Downwind
    Downwind,
    /// Crosswind
    Crosswind,
}

/// Prints the table.
pub(super) fn slope_pdf(args: &TableSlopePdfArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let slopes = |direction, key, list: &[f64]| {
        let (swept, usual) = (direction == args.vary, Usual::steps(-0.5, 0.5, 0.02));
        varied(args.sweep.sweep(), swept, (key, list), usual, &[0.0], [-STEEPEST, STEEPEST])
    };
    let downwind = slopes(Direction::Downwind, "--downwind-slope", &args.downwind_slope)?;
    let crosswind = slopes(Direction::Crosswind, "--crosswind-slope", &args.crosswind_slope)?;
    let winds = args.wind.winds()?;
    bound(&[winds.len(), downwind.len(), crosswind.len()])?;
    let kind = args.surface.kind();
    let mut table = Table::new(out);
    for wind in &winds {
        let u = wind.u12_5_mps;
        let series = args.gram_charlier.then(|| kind.gram_charlier(u));
        let pdf = SlopePdf::new(kind.slopes(u), series, 0.0);
        for &down in &downwind {
            for &cross in &crosswind {
                table.row(&[
                    ("u12p5_mps", Cell::Given(u)),
                    ("downwind_slope", Cell::Given(down)),
                    ("crosswind_slope", Cell::Given(cross)),
                    ("density", Cell::Value(pdf.density(down, cross))),
                ])?;
            }
        }
    }
    Ok(())
}
