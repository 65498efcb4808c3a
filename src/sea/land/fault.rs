//! What may be wrong with a raster of heights.

use super::projection::Crs;

/// Longest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 30;
/// Most cells of a raster.
pub const MAX_CELLS: u64 = 1 << 26;
/// Most bytes of heights for a byte of the file; packed heights of land take a quarter to a fiftieth.
pub const MOST_UNPACKED: usize = 256;
/// Bytes of heights that any file may take.
pub const FREE_BYTES: usize = 1 << 24;
/// Heights that are believed, m.
pub(super) const BELIEVED_M: [f64; 2] = [-12_000.0, 9_000.0];

/// What is wrong with a raster of heights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RasterFault {
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// It is longer than is read.
    #[error("longer than {} MiB; cut the part of the coast that the patch needs (gdalwarp -te)", MAX_BYTES >> 20)]
    TooLong,
    /// It is no TIFF, or corrupt.
    #[error("no GeoTIFF, or corrupt ({0}); allowed: an uncompressed, LZW or deflate GeoTIFF")]
    NoTiff(String),
    /// Too many cells.
    #[error(
        "{columns} x {rows} cells; allowed: 2 x 2 to {MAX_CELLS} cells; cut the part that the patch needs"
    )]
    Size {
        /// Columns.
        columns: u32,
        /// Rows.
        rows: u32,
    },
    /// Its heights take too much memory.
    #[error(
        "unpacks to more than {MOST_UNPACKED} times its {bytes} bytes: such heights are no survey's; rewrite it \
         (gdal_translate -co TILED=YES), or cut the part that the patch needs (gdalwarp -te)"
    )]
    Swollen {
        /// Length of the file.
        bytes: usize,
    },
    /// A unit of heights that is not known.
    #[error(
        "heights in the unit \"{0}\"; allowed: metres, feet, US survey feet (GeoKey VerticalUnits 9001, 9002, 9003)"
    )]
    Unit(String),
    /// Two units.
    #[error("heights in \"{}\" and in \"{}\": allowed is one unit", names[0], names[1])]
    Units {
        /// As they are named.
        names: [String; 2],
    },
    /// Depths.
    #[error("values are depths, down from EPSG {0}; allowed: heights (gdal_calc.py --calc=-A turns them)")]
    Depths(u16),
    /// Scale or offset that are no numbers.
    #[error("GDAL's metadata have the {role} \"{text}\"; allowed: a number, not 0 for a scale")]
    Metadata {
        /// `scale` or `offset`.
        role: String,
        /// As written.
        text: String,
    },
    /// Not one band of numbers.
    #[error("its colour type is {0}; allowed: one band of heights")]
    Bands(String),
    /// It is not georeferenced.
    #[error(
        "without georeference ({0}); allowed: ModelPixelScale with one ModelTiepoint, or ModelTransformation, beside GeoKeys of EPSG 4326, \
         4258, 4979, 326xx, 327xx or 258xx (gdal_translate -a_srs EPSG:4326 -a_ullr ... writes them)"
    )]
    NoGeoreference(&'static str),
    /// It is turned.
    #[error(
        "rotated or flipped; allowed: rows from North to South, columns from West to East (gdalwarp makes them)"
    )]
    Rotated,
    /// An unknown system.
    #[error(
        "coordinate system {0}; allowed: EPSG 4326, 4258, 4979, 326xx, 327xx or 258xx (gdalwarp -t_srs EPSG:4326)"
    )]
    UnknownCrs(String),
    /// Heights that are none.
    #[error(
        "{count} cells without a height between {} and {} m, the first in column {column}, row {row}; \
         declare them as nodata (gdal_translate -a_nodata), which is sea", BELIEVED_M[0], BELIEVED_M[1]
    )]
    Heights {
        /// Cells.
        count: u64,
        /// Column of the first.
        column: usize,
        /// Row of the first.
        row: usize,
    },
    /// The patch leaves it.
    #[error(
        "does not cover the patch: {share:.0} % of its edge lie outside {}; a larger raster, or a patch within",
        area(*crs, *low, *high)
    )]
    Uncovered {
        /// Per cent of the points along the patch's edge.
        share: f64,
        /// System of the coordinates.
        crs: Crs,
        /// South-west corner of the raster.
        low: [f64; 2],
        /// North-east corner.
        high: [f64; 2],
    },
    /// The scene is not georeferenced.
    #[error("the scene is not georeferenced; set scene.origin_lat_deg, origin_lon_deg and origin_h_m")]
    NoOrigin,
}

fn area(crs: Crs, low: [f64; 2], high: [f64; 2]) -> String {
    match crs {
        Crs::Geographic => {
            format!("latitude {:.5} to {:.5}, longitude {:.5} to {:.5} deg", low[1], high[1], low[0], high[0])
        }
        Crs::Utm { zone, south } => format!(
            "UTM zone {zone}{}, {:.0} to {:.0} m East, {:.0} to {:.0} m North",
            if south { "S" } else { "N" },
            low[0],
            high[0],
            low[1],
            high[1]
        ),
    }
}
