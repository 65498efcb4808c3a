//! What the numbers of a raster are: their unit, and the scale and offset of GDAL.
//!
//! `height = factor (scale value + offset)`: scale and offset are items of the tag `GDAL_METADATA`; the
//! factor to metres follows from the GeoKey `VerticalUnits` or `VerticalCSType`, or from GDAL's item of the
//! role `unittype`. Where several name a unit, they must agree.

use quick_xml::Reader;
use quick_xml::events::Event;

use super::fault::RasterFault;

/// Metres in an international foot and in a foot of the US survey.
const FEET_M: [f64; 2] = [0.3048, 1200.0 / 3937.0];

/// From values to metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertical {
    /// What values are multiplied by.
    pub scale: f64,
    /// What is added then.
    pub offset: f64,
    /// Metres in the unit of the sum.
    pub unit_m: f64,
}

impl Vertical {
    /// By the GeoKeys `VerticalUnits` and `VerticalCSType` and the text of `GDAL_METADATA`.
    pub(super) fn of(
        [units, datum]: [Option<u16>; 2],
        metadata: Option<&str>,
        faults: &mut Vec<RasterFault>,
    ) -> Option<Self> {
        let before = faults.len();
        let mut found = Self { scale: 1.0, offset: 0.0, unit_m: 1.0 };
        let mut named: Vec<(String, f64)> = Vec::new();
        let mut unit = |name: String, unit_m: Option<f64>, faults: &mut Vec<RasterFault>| match unit_m {
            Some(unit_m) => named.push((name, unit_m)),
            None => faults.push(RasterFault::Unit(name)),
        };
        if let Some(code) = units {
            let unit_m = match code {
                9001 => Some(1.0),
                9002 => Some(FEET_M[0]),
                9003 => Some(FEET_M[1]),
                _ => None,
            };
            unit(format!("EPSG {code}"), unit_m, faults);
        }
        match datum {
            // NAVD88 and NGVD29 in feet of the US survey, NAVD88 in international feet.
            Some(code @ (6360 | 5702)) => unit(format!("EPSG {code}"), Some(FEET_M[1]), faults),
            Some(8228) => unit("EPSG 8228".to_owned(), Some(FEET_M[0]), faults),
            // Depths below mean sea level, the Caspian, NAVD88 and NGVD29.
            Some(code @ (5715 | 5706 | 6357 | 6358 | 6359 | 8050..=8053)) => {
                faults.push(RasterFault::Depths(code));
            }
            _ => {}
        }
        for (role, text) in metadata.map(items).unwrap_or_default() {
            let number = || text.parse::<f64>().ok().filter(|number| number.is_finite());
            match (role.as_str(), number()) {
                ("scale", Some(scale)) if scale != 0.0 => found.scale = scale,
                ("offset", Some(offset)) => found.offset = offset,
                ("unittype", _) => unit(text.clone(), metres(&text), faults),
                _ => faults.push(RasterFault::Metadata { role, text }),
            }
        }
        if let Some((name, unit_m)) = named.first() {
            found.unit_m = *unit_m;
            if let Some((other, _)) = named.iter().find(|(_, other_m)| other_m != unit_m) {
                faults.push(RasterFault::Units { names: [name.clone(), other.clone()] });
            }
        }
        (faults.len() == before).then_some(found)
    }

    /// The height that a value means, m.
    pub(super) fn height_m(&self, value: f64) -> f64 {
        self.unit_m * (self.scale * value + self.offset)
    }

    /// What is done to values, in words; `None` where they are metres.
    pub fn text(&self) -> Option<String> {
        let mut parts = Vec::new();
        if self.scale != 1.0 {
            parts.push(format!("times {}", self.scale));
        }
        if self.offset != 0.0 {
            parts.push(format!("plus {}", self.offset));
        }
        if self.unit_m != 1.0 {
            parts.push(if self.unit_m == FEET_M[0] { "in feet" } else { "in US survey feet" }.to_owned());
        }
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

/// Metres in a unit by the names that GDAL and its users give it.
fn metres(name: &str) -> Option<f64> {
    Some(match name.to_ascii_lowercase().replace(['_', '-'], " ").as_str() {
        "" | "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "ft" | "foot" | "feet" | "international foot" | "foot (international)" => FEET_M[0],
        "us survey foot" | "us survey feet" | "us ft" | "ftus" | "foot us" | "sfoot" => FEET_M[1],
        _ => return None,
    })
}

/// Roles and texts of the items of the first band that say what values mean.
fn items(xml: &str) -> Vec<(String, String)> {
    let mut reader = Reader::from_str(xml.trim_end_matches('\0'));
    let (mut found, mut open): (Vec<(String, String)>, Option<String>) = (Vec::new(), None);
    // What cannot be read ends it: GDAL passes over metadata that are no XML.
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Start(item) if item.name().as_ref() == "Item" => {
                let attribute = |name: &str| Some(item.try_get_attribute(name).ok()??.value.into_owned());
                let first = attribute("sample").is_none_or(|sample| sample == "0");
                let known = |role: &String| ["scale", "offset", "unittype"].contains(&role.as_str());
                open =
                    attribute("role").map(|role| role.to_ascii_lowercase()).filter(known).filter(|_| first);
                found.extend(open.clone().map(|role| (role, String::new())));
            }
            Event::Text(text) if open.is_some() => {
                if let Some((_, so_far)) = found.last_mut() {
                    so_far.push_str(text.trim());
                }
            }
            Event::End(_) => open = None,
            Event::Eof => break,
            _ => {}
        }
    }
    found
}
