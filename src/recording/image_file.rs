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
//! assert!(file.write("never.h5".as_ref()).is_err());
//! # Ok::<(), nereus::recording::ground::GroundError>(())
//! ```

use std::path::Path;

use num_complex::Complex32;

use super::field_file::{self, Attribute, FieldFileError, Fields};
#[cfg(feature = "hdf5")]
use super::field_file::{Fault, list, put, texts};
use super::ground::Ground;

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

impl ImageFile<'_> {
    /// Writes the file, which must not exist.
    ///
    /// # Errors
    /// Images that do not fill the ground, and what the library refuses.
    pub fn write(&self, path: &Path) -> Result<(), FieldFileError> {
        field_file::write(self, path)
    }
}

impl Fields for ImageFile<'_> {
    fn root(&self) -> (&str, &[(&str, Attribute<'_>)]) {
        ("nereus-image", self.attributes)
    }

    fn check(&self) -> Result<(), FieldFileError> {
        let pixels = self.ground.len();
        if self.images.len() == self.channels.len() && self.images.iter().all(|image| image.len() == pixels) {
            return Ok(());
        }
        let least = self.images.iter().map(Vec::len).min().unwrap_or(0);
        let (channels, images) = (self.channels.len(), self.images.len());
        Err(FieldFileError::Pixels { channels, pixels, images, least })
    }

    #[cfg(feature = "hdf5")]
    fn fill(&self, file: &::hdf5::File) -> Result<(), Fault> {
        list(file, "channels", &texts(self.channels)?)?;
        for (axis, name, meaning) in
            [(0, "x_m", "middles of the pixels, East"), (1, "y_m", "middles of the pixels, North")]
        {
            let middles: Vec<f64> = (0..self.ground.pixels[axis])
                .map(|i| self.ground.point_m(i as f64, i as f64)[axis])
                .collect();
            put(file, name, (middles.len(),), &middles, "m", meaning)?;
        }
        let [columns, rows] = self.ground.pixels;
        let shape = (self.channels.len(), rows, columns);
        put(file, "image", shape, &self.images.concat(), "sqrt(W)", "echo of a point at rest").map(drop)
    }
}
