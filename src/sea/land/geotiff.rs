//! Heights of a GeoTIFF (OGC 19-008r4): one band, north up, geographic or UTM.
//!
//! What is read of the georeference: the pixel scale with one tie point, or a transformation without
//! rotation; whether coordinates are those of a pixel's corner or of its middle; the code of the coordinate
//! system. Cells without data (GDAL's tag) are sea.

use std::io::Cursor;
use std::path::Path;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::projection::Crs;
use crate::inputs;

/// Longest file that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 30;
/// Most cells of a raster.
pub const MAX_CELLS: u64 = 1 << 26;
/// Heights that are believed, m.
const BELIEVED_M: [f64; 2] = [-12_000.0, 9_000.0];

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

/// Heights on a grid.
#[derive(Debug)]
pub struct Raster {
    /// System of the coordinates.
    pub crs: Crs,
    /// Coordinates of the middle of the first cell: the north-western one.
    pub first: [f64; 2],
    /// Steps to the East and to the South, both positive.
    pub step: [f64; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row by row, m; NaN where there are no data.
    pub height_m: Vec<f32>,
}

impl Raster {
    /// Reads a file.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn read(path: &Path) -> Result<Self, Vec<RasterFault>> {
        let bytes = inputs::read(path, MAX_BYTES)
            .map_err(|error| vec![RasterFault::Unreadable(inputs::reason(error.kind()))])?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(vec![RasterFault::TooLong]);
        }
        Self::parse(&bytes)
    }

    /// The same of bytes at hand.
    ///
    /// # Errors
    /// All that is wrong with them.
    pub fn parse(bytes: &[u8]) -> Result<Self, Vec<RasterFault>> {
        let corrupt = |error: tiff::TiffError| {
            vec![RasterFault::NoTiff(inputs::one_line(&error.to_string()).into_owned())]
        };
        let mut limits = Limits::default();
        limits.decoding_buffer_size = 8 * MAX_CELLS as usize;
        limits.intermediate_buffer_size = 8 * MAX_CELLS as usize;
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(corrupt)?.with_limits(limits);
        let (columns, rows) = decoder.dimensions().map_err(corrupt)?;
        let mut faults = Vec::new();
        let cells = u64::from(columns) * u64::from(rows);
        if columns < 2 || rows < 2 || cells > MAX_CELLS {
            faults.push(RasterFault::Size { columns, rows });
        }
        match decoder.colortype() {
            Ok(tiff::ColorType::Gray(_)) => {}
            Ok(other) => faults.push(RasterFault::Bands(format!("{other:?}"))),
            Err(error) => faults.extend(corrupt(error)),
        }
        let georeference = Georeference::of(&mut decoder, &mut faults);
        let nodata = decoder
            .find_tag(Tag::GdalNodata)
            .ok()
            .flatten()
            .and_then(|value| value.into_string().ok())
            .and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        // The samples of what is too large or has several bands are not looked at.
        let sized = !faults.iter().any(|f| matches!(f, RasterFault::Size { .. } | RasterFault::Bands(_)));
        let mut height_m = Vec::new();
        if sized {
            match decoder.read_image() {
                Ok(samples) => height_m = heights(samples, nodata, columns as usize, &mut faults),
                Err(error) => faults.extend(corrupt(error)),
            }
            if faults.is_empty() && height_m.len() as u64 != cells {
                faults.push(RasterFault::NoTiff(format!("{} heights for {cells} cells", height_m.len())));
            }
        }
        match georeference {
            Some(Georeference { crs, first, step }) if faults.is_empty() => {
                Ok(Self { crs, first, step, size: [columns as usize, rows as usize], height_m })
            }
            _ => Err(faults),
        }
    }

    /// Column and row, counted from the middle of the first cell, of coordinates.
    pub fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let mut column = (x - self.first[0]) / self.step[0];
        if self.crs == Crs::Geographic {
            // Longitudes of rasters begin at -180, at 0, or anywhere.
            let turn = 360.0 / self.step[0];
            column -= turn * ((column - 0.5 * self.size[0] as f64) / turn).round();
        }
        [column, (self.first[1] - y) / self.step[1]]
    }

    /// Whether the middles of cells lie all around a place.
    pub fn holds(&self, [column, row]: [f64; 2]) -> bool {
        let within = |at: f64, count: usize| (-0.5..=count as f64 - 0.5).contains(&at);
        within(column, self.size[0]) && within(row, self.size[1])
    }

    /// Height at a place, bilinear between the middles of cells, m; cells without data have the given one.
    /// Beyond the outermost middles it is theirs.
    pub fn at(&self, [column, row]: [f64; 2], missing_m: f64) -> f64 {
        let of = |at: f64, count: usize| {
            let at = at.clamp(0.0, (count - 1) as f64);
            let low = (at as usize).min(count - 2);
            (low, at - low as f64)
        };
        let ((c, u), (r, v)) = (of(column, self.size[0]), of(row, self.size[1]));
        let cell = |column: usize, row: usize| {
            let height_m = self.height_m[row * self.size[0] + column];
            if height_m.is_nan() { missing_m } else { f64::from(height_m) }
        };
        let above = cell(c, r) * (1.0 - u) + cell(c + 1, r) * u;
        let below = cell(c, r + 1) * (1.0 - u) + cell(c + 1, r + 1) * u;
        above * (1.0 - v) + below * v
    }

    /// South-west and north-east corners.
    pub fn area(&self) -> [[f64; 2]; 2] {
        let [x, y] = [self.first[0] - 0.5 * self.step[0], self.first[1] + 0.5 * self.step[1]];
        let [width, height] = [self.size[0] as f64 * self.step[0], self.size[1] as f64 * self.step[1]];
        [[x, y - height], [x + width, y]]
    }
}

/// Heights of samples, without those that are none.
fn heights(
    samples: DecodingResult,
    nodata: Option<f64>,
    columns: usize,
    faults: &mut Vec<RasterFault>,
) -> Vec<f32> {
    fn wide<T: Copy>(samples: &[T], to: impl Fn(T) -> f64 + Copy) -> impl Iterator<Item = f64> {
        samples.iter().map(move |sample| to(*sample))
    }
    let values: Vec<f64> = match &samples {
        DecodingResult::U8(of) => wide(of, f64::from).collect(),
        DecodingResult::U16(of) => wide(of, f64::from).collect(),
        DecodingResult::U32(of) => wide(of, f64::from).collect(),
        DecodingResult::U64(of) => wide(of, |v| v as f64).collect(),
        DecodingResult::I8(of) => wide(of, f64::from).collect(),
        DecodingResult::I16(of) => wide(of, f64::from).collect(),
        DecodingResult::I32(of) => wide(of, f64::from).collect(),
        DecodingResult::I64(of) => wide(of, |v| v as f64).collect(),
        DecodingResult::F16(of) => wide(of, |v| f64::from(f32::from(v))).collect(),
        DecodingResult::F32(of) => wide(of, f64::from).collect(),
        DecodingResult::F64(of) => of.clone(),
    };
    let (mut count, mut first) = (0, 0);
    let missing = |value: f64| {
        nodata.is_some_and(|nodata| value == nodata || value.is_nan() && nodata.is_nan())
            // Rasters in f32 name a nodata value that f32 rounds.
            || nodata.is_some_and(|nodata| value as f32 == nodata as f32)
    };
    let height_m = values.iter().enumerate().map(|(at, &value)| {
        if missing(value) {
            return f32::NAN;
        }
        if !(BELIEVED_M[0]..=BELIEVED_M[1]).contains(&value) {
            first = if count == 0 { at } else { first };
            count += 1;
        }
        value as f32
    });
    let height_m = height_m.collect();
    if count > 0 {
        faults.push(RasterFault::Heights { count, column: first % columns, row: first / columns });
    }
    height_m
}

struct Georeference {
    crs: Crs,
    first: [f64; 2],
    step: [f64; 2],
}

/// Keys of the directory.
const MODEL: u16 = 1024;
const RASTER: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;

impl Georeference {
    fn of(decoder: &mut Decoder<Cursor<&[u8]>>, faults: &mut Vec<RasterFault>) -> Option<Self> {
        let mut numbers = |tag| -> Option<Vec<f64>> { decoder.find_tag(tag).ok()??.into_f64_vec().ok() };
        let (scale, tie) = (numbers(Tag::ModelPixelScaleTag), numbers(Tag::ModelTiepointTag));
        let transformation = numbers(Tag::ModelTransformationTag);
        let keys: Option<Vec<u16>> =
            decoder.find_tag(Tag::GeoKeyDirectoryTag).ok().flatten().and_then(|v| v.into_u16_vec().ok());
        let place = match (scale.as_deref(), tie.as_deref(), transformation.as_deref()) {
            (_, _, Some(&[a, b, _, x, c, d, _, y, ..])) => {
                if b != 0.0 || c != 0.0 || !(a > 0.0 && d < 0.0) {
                    faults.push(RasterFault::Rotated);
                }
                Some(([x, y], [a, -d]))
            }
            (Some(&[sx, sy, ..]), Some(&[i, j, _, x, y, _]), _) => {
                if !(sx > 0.0 && sy > 0.0) {
                    faults.push(RasterFault::Rotated);
                }
                Some(([x - i * sx, y + j * sy], [sx, sy]))
            }
            (None, Some(_), _) => {
                faults.push(RasterFault::NoGeoreference("tie points alone"));
                None
            }
            _ => {
                faults.push(RasterFault::NoGeoreference("neither pixel scale nor transformation"));
                None
            }
        };
        let place = place.filter(|(first, step)| {
            let sound = first.iter().chain(step).all(|v| v.is_finite());
            if !sound {
                faults.push(RasterFault::NoGeoreference("coordinates that are no numbers"));
            }
            sound
        });
        let Some(keys) = keys else {
            faults.push(RasterFault::NoGeoreference("no GeoKeys"));
            return None;
        };
        let key = |wanted: u16| {
            keys.chunks_exact(4)
                .skip(1)
                .find(|entry| entry[0] == wanted && entry[1] == 0)
                .map(|entry| entry[3])
        };
        let unnamed = || "without an EPSG code".to_owned();
        let code = |of: Option<u16>| of.map_or_else(unnamed, |code| format!("EPSG {code}"));
        let crs = match key(MODEL) {
            Some(1) => key(PROJECTED).and_then(Crs::of_projected).ok_or_else(|| code(key(PROJECTED))),
            Some(2) => key(GEOGRAPHIC).and_then(Crs::of_geographic).ok_or_else(|| code(key(GEOGRAPHIC))),
            _ => Err("that is neither projected nor geographic".to_owned()),
        };
        let crs = crs.map_err(|name| faults.push(RasterFault::UnknownCrs(name))).ok();
        // Coordinates are those of a pixel's corner, unless they say that they are those of its middle.
        let offset = if key(RASTER) == Some(2) { 0.0 } else { 0.5 };
        let (origin, step) = place?;
        let first = [origin[0] + offset * step[0], origin[1] - offset * step[1]];
        Some(Self { crs: crs?, first, step })
    }
}
