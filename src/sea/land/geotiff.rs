//! Heights of a GeoTIFF (OGC 19-008r4): one band, north up, geographic or UTM.
//!
//! What is read of the georeference: the pixel scale with one tie point, or a transformation without
//! rotation; whether coordinates are those of a pixel's corner or of its middle; the code of the coordinate
//! system. Cells without data (GDAL's tag) are sea; what the others mean: [`super::vertical`].
//!
//! A file is unpacked piece by piece, and its heights take memory in proportion to it: at most
//! [`MOST_UNPACKED`] bytes for each of its own, and [`FREE_BYTES`].

use std::io::Cursor;
use std::path::Path;

use tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::fault::{BELIEVED_M, FREE_BYTES, MAX_BYTES, MAX_CELLS, MOST_UNPACKED, RasterFault};
use super::heights::Heights;
use super::projection::Crs;
use super::vertical::Vertical;
use crate::inputs;

/// Tag of GDAL's metadata.
const GDAL_METADATA: Tag = Tag::Unknown(42112);

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
    /// Of its cells, m; NaN where there are no data.
    pub heights: Heights,
    /// What values of the file mean.
    pub vertical: Vertical,
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
        let most_bytes = FREE_BYTES.saturating_add(MOST_UNPACKED.saturating_mul(bytes.len()));
        limits.decoding_buffer_size = most_bytes.min(8 * MAX_CELLS as usize);
        limits.intermediate_buffer_size = limits.decoding_buffer_size;
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
        let nodata = text(&mut decoder, Tag::GdalNodata)
            .and_then(|text| text.trim_matches(['\0', ' ']).parse::<f64>().ok());
        let units =
            geo_keys(&mut decoder).map(|keys| [VERTICAL_UNITS, VERTICAL].map(|key| of_key(&keys, key)));
        let metadata = text(&mut decoder, GDAL_METADATA);
        let vertical = Vertical::of(units.unwrap_or_default(), metadata.as_deref(), &mut faults);
        // The samples of what is too large or has several bands are not looked at.
        let sized = !faults.iter().any(|f| matches!(f, RasterFault::Size { .. } | RasterFault::Bands(_)));
        let mut heights = Heights::new([0, 0], 0);
        if let Some(vertical) = vertical.filter(|_| sized) {
            let size = [columns as usize, rows as usize];
            heights = Heights::new(size, most_bytes);
            let mut values = Values { vertical, nodata, odd: 0, first: [0, 0] };
            match unpack(&mut decoder, size, &mut values, &mut heights) {
                Ok(Some(())) => faults.extend(values.fault()),
                Ok(None) | Err(tiff::TiffError::LimitsExceeded) => {
                    faults.push(RasterFault::Swollen { bytes: bytes.len() });
                }
                Err(error) => faults.extend(corrupt(error)),
            }
        }
        match (georeference, vertical) {
            (Some(Georeference { crs, first, step }), Some(vertical)) if faults.is_empty() => {
                Ok(Self { crs, first, step, size: [columns as usize, rows as usize], heights, vertical })
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
            let height_m = self.heights.at([column, row]);
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

/// From the values of a file to heights.
struct Values {
    vertical: Vertical,
    nodata: Option<f64>,
    /// Cells whose height is none, and the first of them.
    odd: u64,
    first: [usize; 2],
}

impl Values {
    /// Height of a cell, m; NaN without data.
    fn height_m(&mut self, value: f64, cell: [usize; 2]) -> f32 {
        let missing = self.nodata.is_some_and(|nodata| {
            // Rasters in f32 name a nodata value that f32 rounds.
            value == nodata || value as f32 == nodata as f32 || value.is_nan() && nodata.is_nan()
        });
        if missing {
            return f32::NAN;
        }
        let height_m = self.vertical.height_m(value);
        if !(BELIEVED_M[0]..=BELIEVED_M[1]).contains(&height_m) {
            self.first = if self.odd == 0 || cell[1] < self.first[1] { cell } else { self.first };
            self.odd += 1;
        }
        height_m as f32
    }

    fn fault(&self) -> Option<RasterFault> {
        let (count, [column, row]) = (self.odd, self.first);
        (count > 0).then_some(RasterFault::Heights { count, column, row })
    }
}

/// Unpacks strips or tiles one by one; `None` where heights take more memory than is allowed.
fn unpack(
    decoder: &mut Decoder<Cursor<&[u8]>>,
    [columns, rows]: [usize; 2],
    values: &mut Values,
    heights: &mut Heights,
) -> Result<Option<()>, tiff::TiffError> {
    let chunk = match decoder.get_chunk_type() {
        // A strip may claim more rows than there are.
        ChunkType::Strip => {
            [columns, decoder.get_tag_u32(Tag::RowsPerStrip).map_or(rows, |n| n as usize).min(rows)]
        }
        ChunkType::Tile => {
            [Tag::TileWidth, Tag::TileLength].map(|tag| decoder.get_tag_u32(tag).map_or(0, |n| n as usize))
        }
    };
    if chunk.contains(&0) {
        return Err(tiff::TiffError::FormatError(tiff::TiffFormatError::InconsistentSizesEncountered));
    }
    let [across, down] = [columns.div_ceil(chunk[0]), rows.div_ceil(chunk[1])];
    for index in 0..across * down {
        let first = [index % across * chunk[0], index / across * chunk[1]];
        let size = [chunk[0].min(columns - first[0]), chunk[1].min(rows - first[1])];
        let samples = decoder.read_chunk(u32::try_from(index)?)?;
        let short = || tiff::TiffError::FormatError(tiff::TiffFormatError::InconsistentSizesEncountered);
        for at in 0..size[0] * size[1] {
            let cell = [first[0] + at % size[0], first[1] + at / size[0]];
            let height_m = values.height_m(sample(&samples, at).ok_or_else(short)?, cell);
            if heights.set(cell, height_m).is_none() {
                return Ok(None);
            }
        }
    }
    Ok(Some(()))
}

/// A sample as a number.
fn sample(samples: &DecodingResult, at: usize) -> Option<f64> {
    match samples {
        DecodingResult::U8(of) => of.get(at).copied().map(f64::from),
        DecodingResult::U16(of) => of.get(at).copied().map(f64::from),
        DecodingResult::U32(of) => of.get(at).copied().map(f64::from),
        DecodingResult::U64(of) => of.get(at).map(|value| *value as f64),
        DecodingResult::I8(of) => of.get(at).copied().map(f64::from),
        DecodingResult::I16(of) => of.get(at).copied().map(f64::from),
        DecodingResult::I32(of) => of.get(at).copied().map(f64::from),
        DecodingResult::I64(of) => of.get(at).map(|value| *value as f64),
        DecodingResult::F16(of) => of.get(at).map(|value| f64::from(f32::from(*value))),
        DecodingResult::F32(of) => of.get(at).copied().map(f64::from),
        DecodingResult::F64(of) => of.get(at).copied(),
    }
}

fn text(decoder: &mut Decoder<Cursor<&[u8]>>, tag: Tag) -> Option<String> {
    decoder.find_tag(tag).ok().flatten()?.into_string().ok()
}

fn geo_keys(decoder: &mut Decoder<Cursor<&[u8]>>) -> Option<Vec<u16>> {
    decoder.find_tag(Tag::GeoKeyDirectoryTag).ok().flatten()?.into_u16_vec().ok()
}

/// The value of a GeoKey that is a number.
fn of_key(keys: &[u16], wanted: u16) -> Option<u16> {
    keys.chunks_exact(4).skip(1).find(|entry| entry[0] == wanted && entry[1] == 0).map(|entry| entry[3])
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
const VERTICAL: u16 = 4096;
const VERTICAL_UNITS: u16 = 4099;

impl Georeference {
    fn of(decoder: &mut Decoder<Cursor<&[u8]>>, faults: &mut Vec<RasterFault>) -> Option<Self> {
        let mut numbers = |tag| -> Option<Vec<f64>> { decoder.find_tag(tag).ok()??.into_f64_vec().ok() };
        let (scale, tie) = (numbers(Tag::ModelPixelScaleTag), numbers(Tag::ModelTiepointTag));
        let transformation = numbers(Tag::ModelTransformationTag);
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
        let Some(keys) = geo_keys(decoder) else {
            faults.push(RasterFault::NoGeoreference("no GeoKeys"));
            return None;
        };
        let key = |wanted: u16| of_key(&keys, wanted);
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
