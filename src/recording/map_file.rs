//! Several fields over one patch in an HDF5 file.
//!
//! Root attributes `format`, `version` (1) and those of the caller. `/x_m` and `/y_m`: centres of the facets,
//! f64, m. One dataset `[iy][ix]` for every layer, f32 (half a unit of the 24th bit: 6e-8), with the
//! attributes `unit`, `meaning` and `axes` (`["y_m", "x_m"]`). HDF5 format bounds 1.10.
//!
//! ```
//! use nereus::recording::map_file::{Attribute, Layer, MapFile};
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
#[cfg(not(feature = "hdf5"))]
use std::path::PathBuf;

use crate::scene::Patch;

/// Version of the structure.
pub const VERSION: u32 = 1;

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

/// Value of a root attribute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attribute<'a> {
    /// Text.
    Text(&'a str),
    /// A number.
    Real(f64),
    /// Several numbers.
    Reals(&'a [f64]),
    /// A count.
    Whole(u64),
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

/// Why a map cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// Not so many values as facets.
    #[error("layer {layer}: {values} values for {facets} facets")]
    Size {
        /// The layer.
        layer: String,
        /// Its values.
        values: usize,
        /// Facets of the patch.
        facets: usize,
    },
    /// The HDF5 library refused.
    #[cfg(feature = "hdf5")]
    #[error("{}: {detail}", path.display())]
    Hdf5 {
        /// The file.
        path: std::path::PathBuf,
        /// What the library said.
        detail: String,
    },
    /// Built without HDF5.
    #[cfg(not(feature = "hdf5"))]
    #[error("{}: this build has no HDF5 (feature `hdf5`)", path.display())]
    NoHdf5 {
        /// The file asked for.
        path: PathBuf,
    },
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

    fn check(&self) -> Result<(), MapError> {
        let facets = self.patch.len();
        match self.layers.iter().find(|layer| layer.values.len() != facets) {
            Some(Layer { name, values, .. }) => {
                Err(MapError::Size { layer: (*name).to_owned(), values: values.len(), facets })
            }
            None => Ok(()),
        }
    }

    /// Writes the file, which must not exist.
    #[cfg(feature = "hdf5")]
    pub fn write(&self, path: &Path) -> Result<(), MapError> {
        self.check()?;
        self.fill(path).map_err(|fault| MapError::Hdf5 { path: path.to_owned(), detail: fault.to_string() })
    }

    /// Says that this build has no HDF5.
    #[cfg(not(feature = "hdf5"))]
    pub fn write(&self, path: &Path) -> Result<(), MapError> {
        self.check()?;
        Err(MapError::NoHdf5 { path: path.to_owned() })
    }

    #[cfg(feature = "hdf5")]
    fn fill(&self, path: &Path) -> Result<(), crate::recording::hdf5::fault::Fault> {
        use crate::recording::hdf5::attributes::{attribute, list, text};
        let file = create(path, self.format, VERSION, self.attributes)?;
        for (axis, name, meaning) in
            [(0, "x_m", "centres of the facets, East"), (1, "y_m", "centres of the facets, North")]
        {
            let dataset = file.new_dataset_builder().with_data(&self.centres_m(axis)).create(name)?;
            attribute(&dataset, "unit", &text("m")?)?;
            attribute(&dataset, "meaning", &text(meaning)?)?;
        }
        let axes = [text("y_m")?, text("x_m")?];
        let [nx, ny] = self.patch.facets;
        let mut rounded = Vec::with_capacity(self.patch.len());
        for layer in self.layers {
            rounded.clear();
            rounded.extend(layer.values.iter().map(|value| *value as f32));
            let dataset = file.new_dataset::<f32>().shape((ny, nx)).create(layer.name)?;
            dataset.write_raw(&rounded)?;
            attribute(&dataset, "unit", &text(layer.unit)?)?;
            attribute(&dataset, "meaning", &text(layer.meaning)?)?;
            list(&dataset, "axes", &axes)?;
        }
        // A full disk shows when the file is closed.
        file.flush()?;
        Ok(file.close()?)
    }
}

/// A new file with its root attributes.
#[cfg(feature = "hdf5")]
pub(super) fn create(
    path: &Path,
    format: &str,
    version: u32,
    attributes: &[(&str, Attribute)],
) -> Result<::hdf5::File, crate::recording::hdf5::fault::Fault> {
    use ::hdf5::File;
    use ::hdf5::file::LibraryVersion;

    use crate::recording::hdf5::attributes::{attribute, text};
    let file = File::with_options()
        .with_fapl(|fapl| fapl.libver_bounds(LibraryVersion::V110, LibraryVersion::V110))
        .create_excl(path)?;
    attribute(&file, "format", &text(format)?)?;
    attribute(&file, "version", &version)?;
    for (name, value) in attributes {
        match value {
            Attribute::Text(value) => attribute(&file, name, &text(value)?),
            Attribute::Real(value) => attribute(&file, name, value),
            Attribute::Reals(values) => {
                file.new_attr_builder().with_data(*values).create(*name).map(|_| ()).map_err(Into::into)
            }
            Attribute::Whole(value) => attribute(&file, name, value),
        }?;
    }
    Ok(file)
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
