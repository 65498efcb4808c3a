//! Pictures of a patch of sea: its fields, and what its facets contribute to an echo.

use std::borrow::Cow;

use super::canvas::Canvas;
use super::colours::ColourMap;
use super::picture::{Axis, Limits, Picture, PictureError, Reduction};
use crate::paths::snapshot::Snapshot;
use crate::recording::map_file::sea_layers;
use crate::scene::Patch;
use crate::sea::surface::{Fields, Selection};

/// Decibels that the colours of contributions span.
const SPAN_DB: f64 = 60.0;

/// A field of the sea that can be shown.
#[derive(Clone, Copy, Debug)]
pub struct SeaField {
    /// Its name.
    pub name: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Title of its picture.
    pub title: &'static str,
    kind: Kind,
    /// The layer of a map of the sea that is shown, or those whose magnitude is.
    layers: &'static [&'static str],
}

/// Quantity and unit, and what must be evaluated.
type Kind = (&'static str, Selection);

const HEIGHT: Kind = ("height, m", Selection::HEIGHT);
const SLOPE: Kind = ("slope", Selection { slopes: true, ..Selection::HEIGHT });
const VELOCITY: Kind = ("velocity, m/s", Selection { velocity: true, ..Selection::HEIGHT });
const DISPLACEMENT: Kind = ("displacement, m", Selection { displacement: true, ..Selection::HEIGHT });

const EAST: &str = "Orbital velocity to the East";
const NORTH: &str = "Orbital velocity to the North";
const UP: &str = "Orbital velocity upward";

/// Every field that can be shown, the height first.
pub const SEA_FIELDS: [SeaField; 9] = [
    of("height", ["Height above the mean surface", "Height of the sea"], HEIGHT, &["height_m"]),
    of("slope", ["Steepness, whatever its direction", "Slope of the sea"], SLOPE, &["slope_x", "slope_y"]),
    of("slope-x", ["Slope to the East", "Slope of the sea to the East"], SLOPE, &["slope_x"]),
    of("slope-y", ["Slope to the North", "Slope of the sea to the North"], SLOPE, &["slope_y"]),
    of("velocity-x", [EAST, EAST], VELOCITY, &["velocity_x_mps"]),
    of("velocity-y", [NORTH, NORTH], VELOCITY, &["velocity_y_mps"]),
    of("velocity-up", [UP, UP], VELOCITY, &["velocity_up_mps"]),
    of(
        "displacement-x",
        ["Horizontal displacement to the East", "Displacement to the East"],
        DISPLACEMENT,
        &["displacement_x_m"],
    ),
    of(
        "displacement-y",
        ["Horizontal displacement to the North", "Displacement to the North"],
        DISPLACEMENT,
        &["displacement_y_m"],
    ),
];

const fn of(
    name: &'static str,
    [meaning, title]: [&'static str; 2],
    kind: Kind,
    layers: &'static [&'static str],
) -> SeaField {
    SeaField { name, meaning, title, kind, layers }
}

impl SeaField {
    /// What must be evaluated for it.
    pub fn selection(&self) -> Selection {
        self.kind.1
    }

    /// Its values, `[iy][ix]`.
    fn values<'a>(&self, fields: &'a Fields<f64>) -> Cow<'a, [f64]> {
        let mut shown = sea_layers(fields).into_iter().filter(|layer| self.layers.contains(&layer.name));
        match (shown.next(), shown.next()) {
            (Some(x), Some(y)) => x.values.iter().zip(y.values).map(|(x, y)| x.hypot(*y)).collect(),
            (only, _) => Cow::Borrowed(only.map_or(&[], |layer| layer.values)),
        }
    }

    /// Draws it over a patch.
    ///
    /// # Errors
    /// Fields that do not fill the patch.
    pub fn draw(&self, title: &str, patch: &Patch, fields: &Fields<f64>) -> Result<Canvas, PictureError> {
        let (values, [x, y]) = (self.values(fields), axes(patch));
        // A magnitude has no sign.
        let colours = if self.layers.len() > 1 { ColourMap::Deep } else { ColourMap::Swell };
        let picture = Picture::new(&values, patch.facets)?;
        Picture { title, x, y, quantity: self.kind.0, colours, scale_bar: Some("m"), ..picture }.draw()
    }
}

/// Draws what every facet contributes to a channel of such a name; facets that return nothing are masked.
///
/// # Errors
/// A snapshot that does not fill its patch.
pub fn contributions(snapshot: &Snapshot, channel: usize, name: &str) -> Result<Canvas, PictureError> {
    let values = snapshot.power_dbw(channel);
    let [x, y] = axes(&snapshot.patch);
    Picture {
        title: &format!("Contribution of each facet, {name}, pulse {}", snapshot.index),
        x,
        y,
        quantity: "dBW",
        colours: ColourMap::Deep,
        limits: Limits::Below { percent: 99.9, span: SPAN_DB },
        reduction: Reduction::MeanPower,
        masked: "dark",
        scale_bar: Some("m"),
        ..Picture::new(&values, snapshot.patch.facets)?
    }
    .draw()
}

/// Axes of a picture of a patch; facets lie about their centres.
fn axes(patch: &Patch) -> [Axis<'static>; 2] {
    [("East, m", 0), ("North, m", 1)].map(|(label, axis)| {
        let from = (patch.first[axis] as f64 - 0.5) * patch.facet_m;
        Axis { label, from, to: from + patch.size_m()[axis] }
    })
}
