//! What HDF5 files of maps, images and paths have in common: root attributes, fields with unit and meaning.
//!
//! HDF5 format bounds 1.10. Root attributes `format`, `version` ([`VERSION`]) and those of the caller; each
//! dataset has `unit` and `meaning`.

use std::path::{Path, PathBuf};

#[cfg(feature = "hdf5")]
use super::hdf5::attributes::attribute;
#[cfg(feature = "hdf5")]
pub(super) use super::hdf5::{
    attributes::{list, text, texts},
    fault::Fault,
};

/// Version of the structures.
pub const VERSION: u32 = 1;
/// The program that writes them, as they name it.
pub(super) const SOFTWARE: &str = concat!("nereus ", env!("CARGO_PKG_VERSION"));

/// Value of a root attribute.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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

/// Why fields cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FieldFileError {
    /// Not so many values as facets.
    #[error("layer {layer}: {values} values for {facets} facets")]
    Facets {
        /// The layer.
        layer: String,
        /// Its values.
        values: usize,
        /// Facets of the patch.
        facets: usize,
    },
    /// Not so many values as pixels.
    #[error(
        "{channels} channels of {pixels} pixels are named; {images} images, the shortest of {least} pixels, are given"
    )]
    Pixels {
        /// Channels named.
        channels: usize,
        /// Pixels of the ground.
        pixels: usize,
        /// Images given.
        images: usize,
        /// Pixels of the smallest.
        least: usize,
    },
    /// Names that are not those of the list.
    #[error("{names} {what} are named; the path list has {columns}")]
    Names {
        /// Pairs or channels.
        what: &'static str,
        /// So many names.
        names: usize,
        /// So many columns.
        columns: usize,
    },
    /// A channel on a pair that is not there.
    #[error("channel {channel} lies on pair {pair}; there are {pairs}")]
    Pair {
        /// The channel.
        channel: usize,
        /// Its pair.
        pair: usize,
        /// Pairs of the list.
        pairs: usize,
    },
    /// The HDF5 library refused.
    #[error("{}: {detail}", path.display())]
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// What the library reported.
        detail: String,
    },
    /// Built without HDF5.
    #[error("{}: this build has no HDF5 (feature `hdf5`)", path.display())]
    NoHdf5 {
        /// The file asked for.
        path: PathBuf,
    },
}

impl FieldFileError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        matches!(self, Self::NoHdf5 { .. })
    }
}

/// What fills a file.
pub(super) trait Fields {
    /// Attribute `format` of the root, and further ones.
    fn root(&self) -> (&str, &[(&str, Attribute<'_>)]);
    /// Whether names, sizes and values agree.
    fn check(&self) -> Result<(), FieldFileError>;
    /// Writes the datasets.
    #[cfg(feature = "hdf5")]
    fn fill(&self, file: &::hdf5::File) -> Result<(), Fault>;
}

/// Writes a file, which must not exist.
#[cfg(feature = "hdf5")]
pub(super) fn write(fields: &impl Fields, path: &Path) -> Result<(), FieldFileError> {
    fields.check()?;
    let done = create(path, fields).and_then(|file| {
        fields.fill(&file)?;
        // A full disk shows when the file is closed.
        file.flush()?;
        Ok(file.close()?)
    });
    done.map_err(|fault| FieldFileError::Hdf5 { path: path.to_owned(), detail: fault.to_string() })
}

/// This build has no HDF5.
#[cfg(not(feature = "hdf5"))]
pub(super) fn write(fields: &impl Fields, path: &Path) -> Result<(), FieldFileError> {
    fields.check()?;
    let _ = fields.root();
    Err(FieldFileError::NoHdf5 { path: path.to_owned() })
}

/// A new file with its root attributes.
#[cfg(feature = "hdf5")]
fn create(path: &Path, fields: &impl Fields) -> Result<::hdf5::File, Fault> {
    use ::hdf5::file::LibraryVersion::V110;
    let file =
        ::hdf5::File::with_options().with_fapl(|fapl| fapl.libver_bounds(V110, V110)).create_excl(path)?;
    let (format, attributes) = fields.root();
    attribute(&file, "format", &text(format)?)?;
    attribute(&file, "version", &VERSION)?;
    for (name, value) in attributes {
        match value {
            Attribute::Text(value) => attribute(&file, name, &text(value)?),
            Attribute::Real(value) => attribute(&file, name, value),
            Attribute::Reals(values) => {
                Ok(file.new_attr_builder().with_data(*values).create(*name).map(drop)?)
            }
            Attribute::Whole(value) => attribute(&file, name, value),
        }?;
    }
    Ok(file)
}

/// Writes a dataset with its unit and meaning.
#[cfg(feature = "hdf5")]
pub(super) fn put<T: ::hdf5::H5Type>(
    file: &::hdf5::File,
    name: &str,
    shape: impl Into<::hdf5::Extents>,
    values: &[T],
    unit: &str,
    meaning: &str,
) -> Result<::hdf5::Dataset, Fault> {
    let dataset = file.new_dataset::<T>().shape(shape).create(name)?;
    if !values.is_empty() {
        dataset.write_raw(values)?;
    }
    attribute(&dataset, "unit", &text(unit)?)?;
    attribute(&dataset, "meaning", &text(meaning)?)?;
    Ok(dataset)
}
