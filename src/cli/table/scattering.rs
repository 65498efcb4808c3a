//! What the sea returns: radar cross section, and the density of slopes behind its specular part.

use std::f64::consts::PI;
use std::io::Write;

use clap::{Args, ValueEnum};
use glam::DVec3;

use super::TableError;
use super::csv::{self, Cell};
use super::sea_keys::{SpectrumKeys, WaterKeys, WindKeys, bound_seas};
use super::sweep::{AngleSweep, SlopeSweep, Usual};
use super::waves::WAVE_NUMBER_RANGE_RAD_M;
use crate::cli::error::CliError;
use crate::cli::values::within;
use crate::scattering::breaking;
use crate::scattering::kind::Kind;
use crate::scattering::kind::clean::Clean;
use crate::scattering::kind::slick::Slick;
use crate::scattering::modulation::of_bragg_waves_per_s;
use crate::scattering::slope_pdf::SlopePdf;
use crate::scattering::tilt::Path;
use crate::scattering::two_scale::{self, Medium, TwoScale};
use crate::scene::sea::LightWinds;
use crate::scene::water::Dispersion;
use crate::sea::spectrum::WaveVector;
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
    #[arg(long, value_enum, default_value_t = Splitting::Consistent)]
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
    #[arg(long, value_enum, default_value_t = LightWind::Threshold)]
    light_wind: LightWind,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Splitting {
    /// Each wave counts once
    Consistent,
    /// As the paper: all slopes and the whole spectrum
    Mars2007,
}

/// Bragg waves in light wind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightWind {
    /// None below the wind that sustains them, never fewer in more wind
    Threshold,
    /// Those of the spectrum as published
    Published,
}

/// The angles of a table, degrees.
struct Angles {
    incidence: Vec<f64>,
    /// Empty: the incidence.
    scattering: Vec<f64>,
    azimuth: Vec<f64>,
    aspect: Vec<f64>,
}

impl Angles {
    fn of(args: &TableSigma0Args) -> Result<Self, TableError> {
        let values = |angle, key, list: &[f64], usual: Usual, single: &[f64], range| {
            let values = if angle == args.vary {
                args.sweep.sweep().or_list(key, list, usual)?
            } else if list.is_empty() {
                single.to_vec()
            } else {
                list.to_vec()
            };
            within(key, &values, range)?;
            Ok::<_, TableError>(values)
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
    fn check(&self) -> Result<(), CliError> {
        if let Some(facet_m) = self.facet_m {
            within("--facet-m", &[facet_m], FACET_RANGE_M)?;
        }
        if let Some(cut_rad_m) = self.cut_rad_m {
            within("--cut-rad-m", &[cut_rad_m], WAVE_NUMBER_RANGE_RAD_M)?;
        }
        if self.modulated && self.splitting == Splitting::Mars2007 {
            return Err(TableError::Unmodulated.into());
        }
        if let Some(relaxation_per_s) = self.relaxation_per_s {
            within("--relaxation-per-s", &[relaxation_per_s], RELAXATION_RANGE_PER_S)?;
        }
        within("--slope-x", &[self.slope_x], [-STEEPEST, STEEPEST])?;
        within("--slope-y", &[self.slope_y], [-STEEPEST, STEEPEST])?;
        Ok(())
    }

    fn light_winds(&self) -> LightWinds {
        match self.light_wind {
            LightWind::Threshold => LightWinds::Threshold,
            LightWind::Published => LightWinds::AsPublished,
        }
    }

    fn settings(&self) -> two_scale::Settings {
        two_scale::Settings {
            splitting: match self.splitting {
                Splitting::Consistent => two_scale::Splitting::Consistent,
                Splitting::Mars2007 => two_scale::Splitting::Mars2007,
            },
            cut_radpm: self.cut_rad_m,
            tilt_average: !self.untilted,
            gram_charlier: self.gram_charlier,
        }
    }

    /// The names of the columns.
    fn columns(&self) -> Vec<String> {
        let mut columns: Vec<String> = [
            "carrier_hz",
            "temperature_c",
            "salinity_psu",
            "u10_mps",
            "aspect_deg",
            "incidence_deg",
            "scattering_deg",
            "azimuth_deg",
        ]
        .map(str::to_owned)
        .into();
        for part in ["sigma0", "spm", "go"].into_iter().chain(self.breaking.then_some("breaking")) {
            columns.extend(["hh", "hv", "vh", "vv"].map(|channel| format!("{part}_{channel}_db")));
        }
        columns
    }
}

/// Prints the table.
pub(super) fn sigma0(args: &TableSigma0Args, out: &mut dyn Write) -> Result<(), CliError> {
    match args.surface {
        Surface::Clean => sigma0_of(Clean, args, out),
        Surface::Slick => sigma0_of(Slick::default(), args, out),
    }
}

fn sigma0_of<K: Kind + Copy>(kind: K, args: &TableSigma0Args, out: &mut dyn Write) -> Result<(), CliError> {
    let angles = Angles::of(args)?;
    args.check()?;
    let waters = args.water.waters();
    let media = args.water.permittivities(&args.carrier_hz, &waters)?;
    let winds = args.wind.winds(0.0)?;
    bound_seas(&[media.len(), winds.len(), angles.aspect.len()])?;
    let scatterings = angles.scattering.len().max(1);
    csv::bound(&[
        media.len(),
        winds.len(),
        angles.aspect.len(),
        angles.incidence.len(),
        scatterings,
        angles.azimuth.len(),
    ])?;
    let spectra = args.spectrum.that_scatter(&winds, args.light_winds())?;
    let settings = args.settings();
    csv::header(out, &args.columns())?;
    for &(carrier_hz, water, permittivity) in &media {
        for (wind, spectrum) in winds.iter().zip(&spectra) {
            for &aspect_deg in &angles.aspect {
                let (cos, sin) = cos_sin_of_degrees(aspect_deg);
                let medium = Medium {
                    carrier_hz,
                    permittivity,
                    wind_12p5_mps: wind.u12_5_mps,
                    downwind_rad: sin.atan2(cos),
                    resolved_radpm: args.facet_m.map_or(0.0, |facet_m| PI / facet_m),
                    // The direction of incidence.
                    axis: DVec3::X,
                };
                // The spectrum's own axis is downwind.
                let turned = |kx: f64, ky: f64| WaveVector::new(cos * kx + sin * ky, cos * ky - sin * kx);
                let psi = |kx: f64, ky: f64| spectrum.symmetric_m4(turned(kx, ky));
                let mut sea = TwoScale::new(settings, medium, kind, psi);
                if args.modulated {
                    let usual = of_bragg_waves_per_s(medium.wavenumber_radpm(), wind.ustar_wu_mps);
                    let rate_per_s = args.relaxation_per_s.unwrap_or(usual);
                    let wave_psi = |kx: f64, ky: f64| spectrum.wave_m4(turned(kx, ky));
                    sea = sea.modulated(wave_psi, Dispersion::default(), rate_per_s);
                }
                let parameters =
                    [carrier_hz, water.temperature_c, water.salinity_gpkg, wind.u10_mps, aspect_deg];
                for of_path in angles.paths() {
                    let path = path(of_path);
                    // Under a film the whole facet is.
                    let response = sea.response(&path, (args.slope_x, args.slope_y), 1.0);
                    let breaking = args
                        .breaking
                        .then(|| breaking::sigma0(permittivity, &path, medium.downwind_rad, wind.u10_mps));
                    let mut all = response.sigma0();
                    for (all, breaking) in
                        all.as_flattened_mut().iter_mut().zip(breaking.iter().flatten().flatten())
                    {
                        *all += breaking;
                    }
                    let mut cells: Vec<Cell> = parameters.map(Cell::Given).into();
                    cells.extend(of_path.map(Cell::Given));
                    let parts = [all, response.bragg_sigma0(), response.specular_sigma0()];
                    for [[vv, vh], [hv, hh]] in parts.into_iter().chain(breaking) {
                        cells.extend([hh, hv, vh, vv].map(Cell::Decibels));
                    }
                    csv::row(out, &cells)?;
                }
            }
        }
    }
    Ok(())
}

/// The path whose direction of incidence is that of +x.
fn path([incidence_deg, scattering_deg, azimuth_deg]: [f64; 3]) -> Path {
    let (cos_i, sin_i) = cos_sin_of_degrees(incidence_deg);
    let (cos_s, sin_s) = cos_sin_of_degrees(scattering_deg);
    let (cos_d, sin_d) = cos_sin_of_degrees(azimuth_deg);
    Path::new(DVec3::new(sin_i, 0.0, -cos_i), DVec3::new(sin_s * cos_d, sin_s * sin_d, cos_s))
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
        let values = if direction == args.vary {
            args.sweep.sweep().or_list(key, list, Usual::steps(-0.5, 0.5, 0.02))?
        } else if list.is_empty() {
            vec![0.0]
        } else {
            list.to_vec()
        };
        within(key, &values, [-STEEPEST, STEEPEST])?;
        Ok::<_, TableError>(values)
    };
    let downwind = slopes(Direction::Downwind, "--downwind-slope", &args.downwind_slope)?;
    let crosswind = slopes(Direction::Crosswind, "--crosswind-slope", &args.crosswind_slope)?;
    let winds = args.wind.winds(0.0)?;
    csv::bound(&[winds.len(), downwind.len(), crosswind.len()])?;
    let mut table = csv::Table::new(out);
    for wind in &winds {
        let u = wind.u12_5_mps;
        let (variances, series) = match args.surface {
            Surface::Clean => (Clean.slopes(u), Clean.gram_charlier(u)),
            Surface::Slick => (Slick::default().slopes(u), Slick::default().gram_charlier(u)),
        };
        let pdf = SlopePdf::new(variances, args.gram_charlier.then_some(series), 0.0);
        for &down in &downwind {
            for &cross in &crosswind {
                let density = pdf.density(down, cross);
                let cells = [
                    ("u12p5_mps", Cell::Given(u)),
                    ("downwind_slope", Cell::Given(down)),
                    ("crosswind_slope", Cell::Given(cross)),
                    ("density", Cell::Value(density)),
                ];
                table.row(&cells)?;
            }
        }
    }
    Ok(())
}
