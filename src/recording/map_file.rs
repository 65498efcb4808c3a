//! Several fields over one patch in an HDF5 file.
//!
//! Root attributes `format`, `version` (1) and those of the caller. `/x_m` and `/y_m`: centres of the facets,
//! f64, m. One dataset `[iy][ix]` for every layer, f32 (half a unit of the 24th bit: 6e-8), with the
//! attributes `unit`, `meaning` and `axes` (`["y_m", "x_m"]`). HDF5 format bounds 1.10.
//!
//! ```
//! use nereus::recording::field_file::Attribute;
//! use nereus::recording::map_file::{Layer, MapFile};
//! use nereus::scene::Patch;
//! let patch = Patch::new([4.0, 2.0], 1.0, [0.0, 0.0])?;
//! let map = MapFile {
//!     format: "nereus-sea",
//!     attributes: &[("seed", Attribute::Whole(1)), ("time_s", Attribute::Real(0.5))],
//!     patch: &patch,
//!     layers: &[Layer { name: "height_m", unit: "m", meaning: "height", values: &[0.0; 8] }],
//! };
//! assert_eq!(map.centres_m(0), [-2.0, -1.0, 0.0, 1.0]);
//! # Ok::<(), nereus::scene::patch::PatchError>(())
//! ```

use std::path::Path;

use super::field_file::{self, Attribute, FieldFileError, Fields, SOFTWARE};
#[cfg(feature = "hdf5")]
use super::field_file::{Fault, list, put, text};
use crate::scene::Patch;
use crate::sea::surface;

/// A field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer<'a> {
    /// Name of its dataset.
    pub name: &'a str,
    /// Unit; `1` for a pure number.
    pub unit: &'a str,
    /// What it is.
    pub meaning: &'a str,
    /// Values `[iy][ix]`.
    pub values: &'a [f64],
}

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapFile<'a> {
    /// Attribute `format`.
    pub format: &'a str,
    /// Further root attributes.
    pub attributes: &'a [(&'a str, Attribute<'a>)],
    /// Where the facets are.
    pub patch: &'a Patch,
    /// The fields.
    pub layers: &'a [Layer<'a>],
}

/// Name, unit and meaning of a layer of the sea, and where its values are.
type SeaLayer = (&'static str, &'static str, &'static str, fn(&surface::Fields<f64>) -> &[f64]);

const SEA_LAYERS: [SeaLayer; 11] = [
    ("height_m", "m", "height above the mean surface", |f| &f.height_m),
    ("slope_x", "1", "slope dz/dx, x to the East", |f| &f.slope[0]),
    ("slope_y", "1", "slope dz/dy, y to the North", |f| &f.slope[1]),
    ("velocity_x_mps", "m/s", "orbital velocity, East", |f| &f.velocity_mps[0]),
    ("velocity_y_mps", "m/s", "orbital velocity, North", |f| &f.velocity_mps[1]),
    ("velocity_up_mps", "m/s", "orbital velocity, up", |f| &f.velocity_mps[2]),
    ("acceleration_x_mps2", "m/s^2", "orbital acceleration, East", |f| &f.acceleration_mps2[0]),
    ("acceleration_y_mps2", "m/s^2", "orbital acceleration, North", |f| &f.acceleration_mps2[1]),
    ("acceleration_up_mps2", "m/s^2", "orbital acceleration, up", |f| &f.acceleration_mps2[2]),
    ("displacement_x_m", "m", "horizontal displacement of the water, East", |f| &f.displacement_m[0]),
    ("displacement_y_m", "m", "horizontal displacement of the water, North", |f| &f.displacement_m[1]),
];

/// The layers of a map of the sea, of which all fields must be there.
pub fn sea_layers(fields: &surface::Fields<f64>) -> [Layer<'_>; 11] {
    SEA_LAYERS.map(|(name, unit, meaning, values)| Layer { name, unit, meaning, values: values(fields) })
}

/// Writes every field of the sea over a patch; `config` is the scenario's text.
///
/// # Errors
/// What cannot be written.
pub fn write_sea(
    path: &Path,
    format: &str,
    config: &str,
    attributes: &[(&str, Attribute<'_>)],
    patch: &Patch,
    fields: &surface::Fields<f64>,
) -> Result<(), FieldFileError> {
    let run = [("software", Attribute::Text(SOFTWARE)), ("config", Attribute::Text(config))];
    let attributes = [&run, attributes].concat();
    MapFile { format, attributes: &attributes, patch, layers: &sea_layers(fields) }.write(path)
}

impl MapFile<'_> {
    /// Centres of the facets along x (0) or y (1), m.
    pub fn centres_m(&self, axis: usize) -> Vec<f64> {
        let axis = axis.min(1);
        (0..self.patch.facets[axis])
            .map(|i| {
                let mut key = self.patch.first;
                key[axis] += i as i64;
                self.patch.centre_m(key)[axis]
            })
            .collect()
    }

    /// Writes the file, which must not exist.
    ///
    /// # Errors
    /// A layer that does not fill the patch, and what the library refuses.
    pub fn write(&self, path: &Path) -> Result<(), FieldFileError> {
        field_file::write(self, path)
    }
}

impl Fields for MapFile<'_> {
    fn root(&self) -> (&str, &[(&str, Attribute<'_>)]) {
        (self.format, self.attributes)
    }

    fn check(&self) -> Result<(), FieldFileError> {
        let facets = self.patch.len();
        match self.layers.iter().find(|layer| layer.values.len() != facets) {
            Some(Layer { name, values, .. }) => {
                Err(FieldFileError::Facets { layer: (*name).to_owned(), values: values.len(), facets })
            }
            None => Ok(()),
        }
    }

    #[cfg(feature = "hdf5")]
    fn fill(&self, file: &::hdf5::File) -> Result<(), Fault> {
        for (axis, name, meaning) in
            [(0, "x_m", "centres of the facets, East"), (1, "y_m", "centres of the facets, North")]
        {
            let centres = self.centres_m(axis);
            put(file, name, (centres.len(),), &centres, "m", meaning)?;
        }
        let axes = [text("y_m")?, text("x_m")?];
        let [nx, ny] = self.patch.facets;
        for layer in self.layers {
            let rounded: Vec<f32> = layer.values.iter().map(|value| *value as f32).collect();
            let dataset = put(file, layer.name, (ny, nx), &rounded, layer.unit, layer.meaning)?;
            list(&dataset, "axes", &axes)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_must_fill_the_patch() {
        let patch = Patch::new([4.0, 2.0], 1.0, [0.0, 0.0]).unwrap();
        let layers = [Layer { name: "height_m", unit: "m", meaning: "", values: &[0.0; 7] }];
        let map = MapFile { format: "x", attributes: &[], patch: &patch, layers: &layers };
        let error = map.write(Path::new("never.h5")).unwrap_err().to_string();
        assert_eq!(error, "layer height_m: 7 values for 8 facets");
    }
}
