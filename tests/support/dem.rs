//! Height rasters for tests: GeoTIFF files of one band.

use std::fs::File;
use std::path::Path;

use nereus::frames::{Earth, Geodetic, SceneFrame};
use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
use tiff::tags::Tag;

/// Origin of the scenes: latitude and longitude, degrees.
pub const ORIGIN_DEG: [f64; 2] = [54.0, 10.0];

/// The georeference of a raster.
pub struct Georeference {
    pub scale: Option<[f64; 3]>,
    pub tie: Option<Vec<f64>>,
    pub transformation: Option<Vec<f64>>,
    pub keys: Option<Vec<u16>>,
    pub nodata: Option<&'static str>,
}

impl Georeference {
    /// Geographic, of coordinates of the corner of the first cell and steps in degrees.
    pub fn geographic([lon_deg, lat_deg]: [f64; 2], step_deg: [f64; 2]) -> Self {
        Self {
            scale: Some([step_deg[0], step_deg[1], 0.0]),
            tie: Some(vec![0.0, 0.0, 0.0, lon_deg, lat_deg, 0.0]),
            transformation: None,
            keys: Some(vec![1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326]),
            nodata: None,
        }
    }
}

/// Writes a raster.
pub fn write(path: &Path, [columns, rows]: [u32; 2], at: &Georeference, heights_m: &[f32]) {
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    let mut image = encoder.new_image::<Gray32Float>(columns, rows).unwrap();
    let tags = image.encoder();
    if let Some(scale) = &at.scale {
        tags.write_tag(Tag::ModelPixelScaleTag, &scale[..]).unwrap();
    }
    if let Some(tie) = &at.tie {
        tags.write_tag(Tag::ModelTiepointTag, &tie[..]).unwrap();
    }
    if let Some(transformation) = &at.transformation {
        tags.write_tag(Tag::ModelTransformationTag, &transformation[..]).unwrap();
    }
    if let Some(keys) = &at.keys {
        tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    }
    if let Some(nodata) = at.nodata {
        tags.write_tag(Tag::GdalNodata, nodata).unwrap();
    }
    image.write_data(heights_m).unwrap();
}

/// Writes a geographic raster of `cells` x `cells` cells of about `cell_m` around a place East and North of
/// the origin: `height_m` by the same.
pub fn around(path: &Path, centre_m: [f64; 2], cells: u32, cell_m: f64, height_m: impl Fn([f64; 2]) -> f64) {
    let frame = SceneFrame::at(Geodetic::from_deg(ORIGIN_DEG[0], ORIGIN_DEG[1], 0.0), Earth::Flat);
    let metres_a_degree = 111_200.0;
    let step = [cell_m / metres_a_degree / ORIGIN_DEG[0].to_radians().cos(), cell_m / metres_a_degree];
    let middle = frame.to_geodetic(frame.above_sea(centre_m[0], centre_m[1], 0.0)).unwrap();
    let first = [
        middle.lon_rad.to_degrees() - 0.5 * f64::from(cells) * step[0],
        middle.lat_rad.to_degrees() + 0.5 * f64::from(cells) * step[1],
    ];
    let mut heights = Vec::new();
    for row in 0..cells {
        for column in 0..cells {
            let lon_deg = first[0] + (f64::from(column) + 0.5) * step[0];
            let lat_deg = first[1] - (f64::from(row) + 0.5) * step[1];
            let [x, y, _] =
                frame.from_geodetic(Geodetic::from_deg(lat_deg, lon_deg, 0.0)).unwrap().to_array();
            heights.push(height_m([x, y]) as f32);
        }
    }
    write(path, [cells, cells], &Georeference::geographic(first, step), &heights);
}
