//! Complex images in an HDF5 file, for whoever wants to go on from them or to compare.
//!
//! | dataset | what | unit |
//! | --- | --- | --- |
//! | `/image` `[channel, y, x]` | complex64 | sqrt(W) |
//! | `/x_m` `[x]`, `/y_m` `[y]` | middles of the pixels, East and North | m |
//!
//! Root attributes: `format = "nereus-image"`, `version` (1), `channels`, and those of the caller. HDF5
//! format bounds 1.10.
//!
//! ```
//! use nereus::recording::ground::Ground;
//! use nereus::recording::image_file::ImageFile;
//! let ground = Ground::map([0.0; 3], [4.0, 2.0], 1.0)?;
//! let file = ImageFile { attributes: &[], channels: &["VV".to_owned()], ground: &ground, images: &[vec![]] };
//! assert!(file.check().is_err());
//! # Ok::<(), nereus::recording::ground::GroundError>(())
//! ```

use std::path::{Path, PathBuf};

use num_complex::Complex32;

use super::map_file::Attribute;
use crate::recording::ground::Ground;

/// Version of the structure.
pub const VERSION: u32 = 1;

/// What a file holds.
#[derive(Clone, Copy, Debug)]
pub struct ImageFile<'a> {
    /// Further root attributes.
    pub attributes: &'a [(&'a str, Attribute<'a>)],
    /// Name of each channel.
    pub channels: &'a [String],
    /// Where the pixels are.
    pub ground: &'a Ground,
    /// The image of each channel, row by row.
    pub images: &'a [Vec<Complex32>],
}

/// Why an image cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ImageFileError {
    /// Not so many values as pixels.
    #[error(
        "{channels} channels of {pixels} pixels are named; {images} images, the shortest of {least} pixels, are given"
    )]
    Size {
        /// Channels named.
        channels: usize,
        /// Pixels of the ground.
        pixels: usize,
        /// Images given.
        images: usize,
        /// Pixels of the smallest.
        least: usize,
    },
    /// The HDF5 library refused.
    #[error("{}: {detail}", path.display())]
    Hdf5 {
        /// The file.
        path: PathBuf,
        /// What the library said.
        detail: String,
    },
    /// Built without HDF5.
    #[error("{}: this build has no HDF5 (feature `hdf5`)", path.display())]
    NoHdf5 {
        /// The file asked for.
        path: PathBuf,
    },
}

impl ImageFile<'_> {
    /// Whether names, pixels and images agree.
    pub fn check(&self) -> Result<(), ImageFileError> {
        let pixels = self.ground.len();
        if self.images.len() == self.channels.len() && self.images.iter().all(|image| image.len() == pixels) {
            return Ok(());
        }
        let least = self.images.iter().map(Vec::len).min().unwrap_or(0);
        Err(ImageFileError::Size { channels: self.channels.len(), pixels, images: self.images.len(), least })
    }

    /// Writes the file, which must not exist.
    #[cfg(feature = "hdf5")]
    pub fn write(&self, path: &Path) -> Result<(), ImageFileError> {
        self.check()?;
        self.fill(path)
            .map_err(|fault| ImageFileError::Hdf5 { path: path.to_owned(), detail: fault.to_string() })
    }

    /// Says that this build has no HDF5.
    #[cfg(not(feature = "hdf5"))]
    pub fn write(&self, path: &Path) -> Result<(), ImageFileError> {
        self.check()?;
        Err(ImageFileError::NoHdf5 { path: path.to_owned() })
    }

    #[cfg(feature = "hdf5")]
    fn fill(&self, path: &Path) -> Result<(), crate::recording::hdf5::fault::Fault> {
        use crate::recording::hdf5::attributes::{attribute, list, text};
        let file = super::map_file::create(path, "nereus-image", VERSION, self.attributes)?;
        let names = self.channels.iter().map(|name| text(name)).collect::<Result<Vec<_>, _>>()?;
        list(&file, "channels", &names)?;
        for (axis, name, meaning) in
            [(0, "x_m", "middles of the pixels, East"), (1, "y_m", "middles of the pixels, North")]
        {
            let middles: Vec<f64> = (0..self.ground.pixels[axis])
                .map(|i| self.ground.point_m(i as f64, i as f64)[axis])
                .collect();
            let dataset = file.new_dataset_builder().with_data(&middles).create(name)?;
            attribute(&dataset, "unit", &text("m")?)?;
            attribute(&dataset, "meaning", &text(meaning)?)?;
        }
        let [columns, rows] = self.ground.pixels;
        let image =
            file.new_dataset::<Complex32>().shape((self.channels.len(), rows, columns)).create("image")?;
        image.write_raw(&self.images.concat())?;
        attribute(&image, "unit", &text("sqrt(W)")?)?;
        attribute(&image, "meaning", &text("echo of a point at rest")?)?;
        // A full disk shows when the file is closed.
        file.flush()?;
        Ok(file.close()?)
    }
}
