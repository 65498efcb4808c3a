//! The sea of a run at a time, with every field that is asked for, on its patch.
//!
//! The map is that of the patch at pulse 0; a patch that follows moves over the same water. With ships, whose
//! waves are part of the map, it lies where it does at the time asked.

use std::fs::File;
use std::io::BufWriter;

use super::fault::BuildErrors;
use super::prepared::patch_at;
use crate::config::Run;
use crate::plot::canvas::Canvas;
use crate::plot::patch::SeaField;
use crate::plot::picture::PictureError;
use crate::recording::field_file::{Attribute, FieldFileError};
use crate::recording::map_file::{self, Layer, sea_layers};
use crate::recording::output::{Output, OutputError};
use crate::scene::Patch;
use crate::scene::sea::{Sea, Waves};
use crate::sea::facet_surface::FacetSurface;
use crate::sea::fleet::Fleet;
use crate::sea::realise::{RealiseError, Realised, realise};
use crate::sea::summary::Summary;
use crate::sea::surface::choppy::Choppy;
use crate::sea::surface::{Fields, Selection, StateError};
use crate::sea::wake::WakeError;

/// Why there is no map of the sea.
#[derive(Debug, thiserror::Error)]
pub enum SeaMapError {
    /// Wind, spectrum, grid or saved state.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// Tracks or ships.
    #[error(transparent)]
    Build(#[from] BuildErrors),
    /// A time out of range.
    #[error(transparent)]
    Surface(#[from] WakeError),
}

/// Why a map or a state of the sea is not written.
#[derive(Debug, thiserror::Error)]
pub enum SeaMapFileError {
    /// The file cannot be made.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The map cannot be written.
    #[error(transparent)]
    Map(#[from] FieldFileError),
    /// The state cannot be written.
    #[error(transparent)]
    State(#[from] StateError),
}

impl SeaMapFileError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Output(error) => error.is_wrong_input(),
            Self::Map(error) => error.is_wrong_input(),
            Self::State(_) => false,
        }
    }
}

/// The sea of a run at a time.
pub struct SeaMap {
    realised: Realised,
    patch: Patch,
    fields: Fields<f64>,
    summary: Summary,
}

impl SeaMap {
    /// The sea of a run at a time, s after pulse 0, with such fields.
    ///
    /// # Errors
    /// What keeps it from being made.
    pub fn of(run: &Run, sea: &Sea, time_s: f64, selection: Selection) -> Result<Self, SeaMapError> {
        let realised = realise(sea, run.scene.seed)?;
        let ships = &run.scene.ships;
        // Ships do not repeat with the waves of the wind: it matters where the patch lies.
        let patch = if ships.is_empty() { sea.patch } else { patch_at(run, sea, time_s)? };
        let fleet = Fleet::muster(ships, &[(time_s, patch)]).map_err(BuildErrors::from)?;
        let choppy = (sea.waves == Waves::Choppy).then(|| Choppy::of(&realised.surface));
        let surface = FacetSurface::new(&realised.surface, selection).with_choppy(choppy);
        let mut surface = surface.with_wakes(&fleet.wakes, &patch)?;
        let mut fields = surface.fields(&patch);
        surface.evaluate(time_s, &patch, &mut fields)?;
        let summary = Summary::new(&realised, &patch, &fields, time_s);
        Ok(Self { realised, patch, fields, summary })
    }

    /// Every field, facet by facet from South to North and in a row from West to East.
    pub fn layers(&self) -> [Layer<'_>; 11] {
        sea_layers(&self.fields)
    }

    /// Centres of the facets, East and North, m.
    pub fn axes_m(&self) -> [Vec<f64>; 2] {
        let Patch { facets, facet_m, first } = self.patch;
        [0, 1].map(|axis| {
            let places = first[axis]..first[axis] + facets[axis] as i64;
            places.map(|place| place as f64 * facet_m).collect()
        })
    }

    /// The sea in figures: what `nereus sea --json` prints.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Writes the state of its waves, for `sea.state_path` of other scenarios.
    ///
    /// # Errors
    /// A file that cannot be made or written.
    pub fn save_state(&self, output: Output) -> Result<(), SeaMapFileError> {
        output.write(|partial| {
            let file = File::create_new(partial).map_err(OutputError::io(partial, "making the file"))?;
            Ok(self.realised.surface.save(&mut BufWriter::new(file))?)
        })
    }

    /// Writes every field; all must have been asked for. `config` is the scenario's text.
    ///
    /// # Errors
    /// A file that cannot be made or written.
    pub fn save(&self, output: Output, config: &str) -> Result<(), SeaMapFileError> {
        let Summary { seed, time_s, facet_m, wind_10m_mps, .. } = self.summary;
        let attributes = [
            ("seed", Attribute::Whole(seed)),
            ("time_s", Attribute::Real(time_s)),
            ("facet_m", Attribute::Real(facet_m)),
            ("wind_10m_mps", Attribute::Real(wind_10m_mps)),
            ("significant_height_m", Attribute::Real(self.summary.significant_height_m)),
            ("expected_significant_height_m", Attribute::Real(self.summary.expected_significant_height_m)),
        ];
        let (patch, fields) = (&self.patch, &self.fields);
        let write = |path: &_| map_file::write_sea(path, "nereus-sea", config, &attributes, patch, fields);
        output.write(|partial| Ok(write(partial)?))
    }

    /// Draws a field.
    ///
    /// # Errors
    /// A field that was not asked for.
    pub fn draw(&self, field: &SeaField) -> Result<Canvas, PictureError> {
        let title = format!("{}, {} s", field.title, self.summary.time_s);
        field.draw(&title, &self.patch, &self.fields)
    }
}
