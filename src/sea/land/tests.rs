//! What values of a raster mean, and what memory its heights take.

use std::io::Cursor;

use tiff::encoder::colortype::{Gray16, Gray32Float, GrayI16};
use tiff::encoder::{Compression, DeflateLevel, TiffEncoder};
use tiff::tags::Tag;

use super::fault::{FREE_BYTES, RasterFault};
use super::geotiff::Raster;

/// GeoKeys of WGS 84 in degrees, and others.
fn keys(more: &[u16]) -> Vec<u16> {
    let count = 3 + (more.len() / 4) as u16;
    [&[1, 1, 0, count, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326], more].concat()
}

/// A raster of 100 x 70 values from -200 in steps of 0.1: more than a block.
fn raster(metadata: &str, more_keys: &[u16]) -> Result<Raster, Vec<RasterFault>> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<Gray32Float>(100, 70).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[1e-3, 1e-3, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 10.0, 54.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(more_keys)[..]).unwrap();
    tags.write_tag(Tag::GdalNodata, "-199.9").unwrap();
    if !metadata.is_empty() {
        tags.write_tag(Tag::Unknown(42112), metadata).unwrap();
    }
    let values: Vec<f32> = (0..7000).map(|at| -200.0 + at as f32 / 10.0).collect();
    image.write_data(&values).unwrap();
    Raster::parse(bytes.get_ref())
}

fn item(role: &str, text: &str) -> String {
    format!("<Item name=\"x\" sample=\"0\" role=\"{role}\">{text}</Item>")
}

#[test]
fn heights_are_scaled_and_in_metres() {
    let us_foot_m = 1200.0 / 3937.0;
    let units = |code: u16| [4099, 0, 1, code];
    let all = |items: &[String]| format!("<GDALMetadata>{}</GDALMetadata>", items.concat());
    let second =
        "<Item name=\"x\" sample=\"1\" role=\"scale\">7</Item><Item name=\"AREA\">scale</Item>".to_owned();
    let cases = [
        (String::new(), vec![], [1.0, 0.0, 1.0]),
        (all(&[item("scale", "0.1"), item("offset", " -5 "), second]), vec![], [0.1, -5.0, 1.0]),
        (String::new(), units(9001).to_vec(), [1.0, 0.0, 1.0]),
        (String::new(), units(9002).to_vec(), [1.0, 0.0, 0.3048]),
        (String::new(), units(9003).to_vec(), [1.0, 0.0, us_foot_m]),
        // NAVD88 in feet of the US survey, by its datum alone.
        (String::new(), vec![4096, 0, 1, 6360], [1.0, 0.0, us_foot_m]),
        (String::new(), vec![4096, 0, 1, 5703], [1.0, 0.0, 1.0]),
        (all(&[item("unittype", "ft"), item("scale", "2")]), vec![], [2.0, 0.0, 0.3048]),
        (all(&[item("unittype", "US survey foot")]), units(9003).to_vec(), [1.0, 0.0, us_foot_m]),
        // No XML at all.
        ("<GDALMetadata><Item".to_owned(), vec![], [1.0, 0.0, 1.0]),
    ];
    for (metadata, more, [scale, offset, unit_m]) in cases {
        let found = raster(&metadata, &more).unwrap();
        for (cell, value) in [([0, 0], -200.0), ([99, 0], -190.1), ([70, 69], 497.0), ([99, 69], 499.9)] {
            let height_m = unit_m * (scale * value + offset);
            // An f32 has 24 bits.
            assert!(
                (f64::from(found.heights.at(cell)) / height_m - 1.0).abs() < 1.2e-7,
                "{metadata} {cell:?}"
            );
        }
        // Nodata is a value of the file, before all that.
        assert!(found.heights.at([1, 0]).is_nan(), "{metadata}");
        let [low_m, high_m] = found.heights.range_m().unwrap().map(f64::from);
        let [low, high] = [-200.0, 499.9].map(|value| unit_m * (scale * value + offset));
        assert!((low_m / low - 1.0).abs() < 1.2e-7 && (high_m / high - 1.0).abs() < 1.2e-7);
    }
}

#[test]
fn values_that_are_no_heights_in_metres_or_feet_are_refused() {
    let one = |role: &str, text: &str| format!("<GDALMetadata>{}</GDALMetadata>", item(role, text));
    for (metadata, more, expected) in [
        (one("scale", "ten"), vec![], "GDAL's metadata have the scale \"ten\"; allowed: a number"),
        (one("scale", "0"), vec![], "have the scale \"0\""),
        (one("offset", "inf"), vec![], "have the offset \"inf\""),
        (one("unittype", "fathom"), vec![], "heights in the unit \"fathom\"; allowed: metres, feet"),
        (String::new(), vec![4099, 0, 1, 9005], "heights in the unit \"EPSG 9005\""),
        (one("unittype", "m"), vec![4099, 0, 1, 9002], "in \"EPSG 9002\" and in \"m\": allowed is one unit"),
        (String::new(), vec![4096, 0, 1, 5715], "values are depths, down from EPSG 5715"),
        // A hundred times as high is no mountain.
        (one("scale", "100"), vec![], "cells without a height between -12000 and 9000 m"),
    ] {
        let faults = raster(&metadata, &more).unwrap_err();
        let text = faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        assert!(text.contains(expected), "{metadata}: {text}");
    }
}

/// A raster of 4096 x 4096 deflated cells of 16 bits.
fn packed(value: impl Fn(usize) -> i16) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut encoder = encoder.with_compression(Compression::Deflate(DeflateLevel::Best));
    let mut image = encoder.new_image::<GrayI16>(4096, 4096).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[1e-3, 1e-3, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, 10.0, 54.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys(&[])[..]).unwrap();
    let values: Vec<i16> = (0..4096 * 4096).map(value).collect();
    image.write_data(&values).unwrap();
    bytes.into_inner()
}

/// 64 MiB of heights from less than 100 kB: those of one value with an island take the island's memory, those
/// of a pattern that no survey has are refused.
#[test]
fn memory_is_in_proportion_to_the_file() {
    let island = |at: usize| if at / 4096 < 100 && at % 4096 < 100 { (at % 97) as i16 } else { 3 };
    let bytes = packed(island);
    assert!(bytes.len() < 200_000, "{}", bytes.len());
    let found = Raster::parse(&bytes).unwrap();
    assert_eq!(
        (found.heights.at([50, 3]), found.heights.at([4000, 4000])),
        (island(3 * 4096 + 50).into(), 3.0)
    );
    assert!(found.heights.bytes() < 1 << 20, "{}", found.heights.bytes());
    let bytes = packed(|at| (at % 2) as i16);
    let faults = Raster::parse(&bytes).unwrap_err();
    assert!(matches!(faults[..], [RasterFault::Swollen { .. }]), "{faults:?}");
    assert!(256 * bytes.len() + FREE_BYTES < 4 * 4096 * 4096, "{}", bytes.len());
    // Nor is a strip unpacked that is larger than that.
    let mut one = Cursor::new(Vec::new());
    let mut encoder =
        TiffEncoder::new(&mut one).unwrap().with_compression(Compression::Deflate(DeflateLevel::Best));
    let mut image = encoder.new_image::<Gray16>(8192, 4096).unwrap();
    image.rows_per_strip(4096).unwrap();
    image.write_data(&vec![5; 8192 * 4096]).unwrap();
    let faults = Raster::parse(one.get_ref()).unwrap_err();
    assert!(faults.iter().any(|fault| matches!(fault, RasterFault::Swollen { .. })), "{faults:?}");
}
