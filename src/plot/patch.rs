//! Pictures of a patch of sea: its fields, and what its facets contribute to an echo.

use std::borrow::Cow;

use super::canvas::Canvas;
use super::colours::ColourMap;
use super::picture::{Axis, Limits, Picture, PictureError, Reduction};
use crate::paths::snapshot::Snapshot;
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
    /// Quantity and unit.
    quantity: &'static str,
    /// What must be evaluated for it.
    selection: Selection,
    /// The values that are shown, or those whose magnitude is.
    values: &'static [Values],
}

/// Where values are among all fields.
type Values = fn(&Fields<f64>) -> &[f64];

const HEIGHT: SeaField = SeaField {
    name: "height",
    meaning: "Height above the mean surface",
    title: "Height of the sea",
    quantity: "height, m",
    selection: Selection::HEIGHT,
    values: &[|f| &f.height_m],
};
const SLOPE: SeaField = SeaField {
    name: "slope",
    meaning: "Steepness, whatever its direction",
    title: "Slope of the sea",
    quantity: "slope",
    selection: Selection { slopes: true, ..Selection::HEIGHT },
    values: &[|f| &f.slope[0], |f| &f.slope[1]],
};

/// Every field that can be shown, the height first.
pub const SEA_FIELDS: [SeaField; 9] = [
    HEIGHT,
    SLOPE,
    SeaField {
        name: "slope-x",
        meaning: "Slope to the East",
        title: "Slope of the sea to the East",
        values: &[|f| &f.slope[0]],
        ..SLOPE
    },
    SeaField {
        name: "slope-y",
        meaning: "Slope to the North",
        title: "Slope of the sea to the North",
        values: &[|f| &f.slope[1]],
        ..SLOPE
    },
    velocity("velocity-x", "Orbital velocity to the East", &[|f| &f.velocity_mps[0]]),
    velocity("velocity-y", "Orbital velocity to the North", &[|f| &f.velocity_mps[1]]),
    velocity("velocity-up", "Orbital velocity upward", &[|f| &f.velocity_mps[2]]),
    SeaField {
        name: "displacement-x",
        meaning: "Horizontal displacement to the East",
        title: "Displacement to the East",
        ..displacement(&[|f| &f.displacement_m[0]])
    },
    SeaField {
        name: "displacement-y",
        meaning: "Horizontal displacement to the North",
        title: "Displacement to the North",
        ..displacement(&[|f| &f.displacement_m[1]])
    },
];

const fn velocity(name: &'static str, meaning: &'static str, values: &'static [Values]) -> SeaField {
    let selection = Selection { velocity: true, ..Selection::HEIGHT };
    SeaField { name, meaning, title: meaning, quantity: "velocity, m/s", selection, values }
}

const fn displacement(values: &'static [Values]) -> SeaField {
    let selection = Selection { displacement: true, ..Selection::HEIGHT };
    SeaField { quantity: "displacement, m", selection, values, ..HEIGHT }
}

impl SeaField {
    /// What must be evaluated for it.
    pub fn selection(&self) -> Selection {
        self.selection
    }

    /// Its values, `[iy][ix]`.
    fn values<'a>(&self, fields: &'a Fields<f64>) -> Cow<'a, [f64]> {
        match self.values {
            [x, y] => x(fields).iter().zip(y(fields)).map(|(x, y)| x.hypot(*y)).collect(),
            several => Cow::Borrowed(several.first().map_or(&[], |values| values(fields))),
        }
    }

    /// Draws it over a patch.
    ///
    /// # Errors
    /// Fields that do not fill the patch.
    pub fn draw(&self, title: &str, patch: &Patch, fields: &Fields<f64>) -> Result<Canvas, PictureError> {
        let (values, [x, y]) = (self.values(fields), axes(patch));
        // A magnitude has no sign.
        let colours = if self.values.len() > 1 { ColourMap::Deep } else { ColourMap::Swell };
        let picture = Picture::new(&values, patch.facets)?;
        Picture { title, x, y, quantity: self.quantity, colours, scale_bar: Some("m"), ..picture }.draw()
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
