//! Fields of the sea: as layers of a map, as pictures; the arguments that ask for them.

use std::borrow::Cow;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::SeaError;
use crate::cli::json::legible;
use crate::cli::outputs::{axes, save_png};
use crate::cli::report::Report;
use crate::cli::scenario::{OutputArgs, ScenarioArgs};
use crate::plot::colours::ColourMap;
use crate::plot::picture::Picture;
use crate::recording::field_file::Attribute;
use crate::recording::map_file::{MapFile, sea_layers};
use crate::recording::output::Output;
use crate::scene::Patch;
use crate::sea::surface::{Fields, Selection};

/// A map of the patch at a time, and a picture of it.
#[derive(Debug, Args)]
pub struct MapArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Time after pulse 0
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    pub time_s: f64,
    /// Map to make: every field of the patch (HDF5)
    #[arg(long, value_name = "PATH.h5")]
    pub out: Option<PathBuf>,
    /// Picture to make
    #[arg(long, value_name = "PATH.png")]
    pub png: Option<PathBuf>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = Field::Height)]
    pub field: Field,
    /// What becomes of its output
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Files that a command makes, under their keys of `--json`.
pub(in crate::cli) fn files<const N: usize>(report: &mut Report, files: [(&str, &Option<PathBuf>); N]) {
    for (key, path) in files {
        report.value(key, path.as_deref().map(legible));
    }
}

/// Writes every field of a patch.
pub(in crate::cli) fn write_map(
    output: Output,
    format: &str,
    config: &str,
    attributes: &[(&str, Attribute<'_>)],
    patch: &Patch,
    fields: &Fields<f64>,
) -> Result<(), SeaError> {
    let layers = sea_layers(fields);
    let software = format!("nereus {}", env!("CARGO_PKG_VERSION"));
    let run = [("software", Attribute::Text(&software)), ("config", Attribute::Text(config))];
    let attributes = [&run, attributes].concat();
    let file = MapFile { format, attributes: &attributes, patch, layers: &layers };
    output.write(|partial| Ok(file.write(partial)?))
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Field {
    /// Height above the mean surface
    Height,
    /// Steepness, whatever its direction
    Slope,
    /// Slope to the East
    SlopeX,
    /// Slope to the North
    SlopeY,
    /// Orbital velocity to the East
    VelocityX,
    /// Orbital velocity to the North
    VelocityY,
    /// Orbital velocity upward
    VelocityUp,
    /// Horizontal displacement to the East
    DisplacementX,
    /// Horizontal displacement to the North
    DisplacementY,
}

impl Field {
    /// What must be evaluated for it.
    pub(in crate::cli) fn selection(self) -> Selection {
        Selection {
            slopes: matches!(self, Self::Slope | Self::SlopeX | Self::SlopeY),
            velocity: matches!(self, Self::VelocityX | Self::VelocityY | Self::VelocityUp),
            displacement: matches!(self, Self::DisplacementX | Self::DisplacementY),
            ..Selection::HEIGHT
        }
    }

    /// Its values, `[iy][ix]`.
    fn values(self, fields: &Fields<f64>) -> Cow<'_, [f64]> {
        let [slope_x, slope_y] = &fields.slope;
        Cow::Borrowed(match self {
            Self::Height => &fields.height_m,
            Self::Slope => return slope_x.iter().zip(slope_y).map(|(x, y)| x.hypot(*y)).collect(),
            Self::SlopeX => slope_x,
            Self::SlopeY => slope_y,
            Self::VelocityX => &fields.velocity_mps[0],
            Self::VelocityY => &fields.velocity_mps[1],
            Self::VelocityUp => &fields.velocity_mps[2],
            Self::DisplacementX => &fields.displacement_m[0],
            Self::DisplacementY => &fields.displacement_m[1],
        })
    }

    /// Draws it over a patch.
    pub(in crate::cli) fn draw(
        self,
        output: Output,
        title: &str,
        patch: &Patch,
        fields: &Fields<f64>,
    ) -> Result<(), SeaError> {
        let [x, y] = axes(patch);
        let values = self.values(fields);
        let picture = Picture {
            title,
            x,
            y,
            quantity: self.quantity(),
            colours: self.colours(),
            scale_bar: Some("m"),
            ..Picture::new(&values, patch.facets)?
        };
        save_png(output, &picture)
    }

    pub(in crate::cli) fn title(self) -> &'static str {
        match self {
            Self::Height => "Height of the sea",
            Self::Slope => "Slope of the sea",
            Self::SlopeX => "Slope of the sea to the East",
            Self::SlopeY => "Slope of the sea to the North",
            Self::VelocityX => "Orbital velocity to the East",
            Self::VelocityY => "Orbital velocity to the North",
            Self::VelocityUp => "Orbital velocity upward",
            Self::DisplacementX => "Displacement to the East",
            Self::DisplacementY => "Displacement to the North",
        }
    }

    /// Along the colour bar.
    fn quantity(self) -> &'static str {
        match self {
            Self::Height => "height, m",
            Self::Slope | Self::SlopeX | Self::SlopeY => "slope",
            Self::VelocityX | Self::VelocityY | Self::VelocityUp => "velocity, m/s",
            Self::DisplacementX | Self::DisplacementY => "displacement, m",
        }
    }

    fn colours(self) -> ColourMap {
        if self == Self::Slope { ColourMap::Deep } else { ColourMap::Swell }
    }
}
