//! A 2-D array in false colours.
//!
//! Values stand row by row, `[iy][ix]`, row 0 at the bottom: y is upward. The picture has a title, axes with
//! round numbers, a colour bar with its quantity and, if a unit is named, a scale bar. Pixels that are no
//! number are grey and named below the map. Where values go beyond the limits, the ends of the colour bar are
//! pointed.
//!
//! * Square cells on axes of one unit keep their shape ([`Picture::equal_aspect`]), and are drawn in whole
//!   pixels while there are no more of them than pixels; a side is never below [`LEAST_SIDE_PX`].
//! * Cells smaller than a pixel are averaged over it, weighted by the area that they share with it
//!   ([`Reduction`]).
//! * Limits are found from the pixels ([`Limits`]); a diverging colour map gets limits evenly about zero.
//! * Infinite values, and those beyond 1e150, take the colours of the ends; they do not count for the limits.
//!
//! An elementary contribution map, in dBW:
//!
//! ```
//! use nereus::plot::colours::ColourMap;
//! use nereus::plot::picture::{Axis, Limits, Picture, Reduction};
//! let contribution_dbw = [-120.0, -121.5, f64::NEG_INFINITY, f64::NAN];
//! let picture = Picture {
//!     title: "Pulse 0, VV",
//!     x: Axis { label: "East, m", from: -1.0, to: 1.0 },
//!     y: Axis { label: "North, m", from: -1.0, to: 1.0 },
//!     quantity: "dBW",
//!     limits: Limits::Below { percent: 99.9, span: 60.0 },
//!     reduction: Reduction::MeanPower,
//!     masked: "in shadow",
//!     scale_bar: Some("m"),
//!     ..Picture::new(&contribution_dbw, [2, 2])?
//! };
//! assert!(picture.draw()?.width() > 640);
//! # Ok::<(), nereus::plot::picture::PictureError>(())
//! ```

mod limits;
mod resample;

use super::canvas::{Align, Area, Canvas, Face};
use super::colours::{Colour, ColourMap, INK, MASKED, WHITE};
use super::ticks;

pub use limits::Limits;
pub use resample::Reduction;

/// Least side of a map, pixels.
pub const LEAST_SIDE_PX: usize = 24;
/// Sizes that may be asked, pixels.
pub const SIZE_RANGE_PX: [usize; 2] = [64, 8192];
/// Least height of the colour bar, pixels.
const LEAST_BAR_PX: i64 = 160;
/// Longest text that is written, characters.
const LONGEST_TEXT: usize = 120;

/// One axis of a picture, between the outer edges of its first and last cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<'a> {
    /// Quantity and unit.
    pub label: &'a str,
    /// Left or lower edge.
    pub from: f64,
    /// Right or upper edge.
    pub to: f64,
}

/// What is wrong with a picture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// Not so many values as cells.
    #[error("{values} values for {columns} x {rows} cells: they must be as many, and at least one")]
    Shape {
        /// Values given.
        values: usize,
        /// Cells along x.
        columns: usize,
        /// Cells along y.
        rows: usize,
    },
    /// Edges in the wrong order, or too close for round numbers between.
    #[error(
        "axis {axis} from {from} to {to}: two finite numbers are needed, the second larger by 1e-12 of its size"
    )]
    Axis {
        /// `x` or `y`.
        axis: char,
        /// First edge.
        from: f64,
        /// Last edge.
        to: f64,
    },
    /// Limits without a range.
    #[error("limits {low} to {high}: two finite numbers are needed, the second larger")]
    Limits {
        /// Lower limit.
        low: f64,
        /// Upper limit.
        high: f64,
    },
    /// Not a percentage.
    #[error("percentile of {percent}: allowed are numbers above 0 up to 100")]
    Percent {
        /// What was given.
        percent: f64,
    },
}

/// A map to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Above the map.
    pub title: &'a str,
    /// To the right.
    pub x: Axis<'a>,
    /// Upward.
    pub y: Axis<'a>,
    /// Along the colour bar: quantity and unit.
    pub quantity: &'a str,
    /// Its colours.
    pub colours: ColourMap,
    /// Values of the first and last colour.
    pub limits: Limits,
    /// What becomes of cells smaller than a pixel.
    pub reduction: Reduction,
    /// Whether a unit is as long upward as to the right.
    pub equal_aspect: bool,
    /// Unit of the scale bar, which shows lengths to the right.
    pub scale_bar: Option<&'a str>,
    /// What grey pixels are.
    pub masked: &'a str,
    /// Longest side of the map, pixels; held within [`SIZE_RANGE_PX`].
    pub size_px: usize,
    /// Values `[iy][ix]`.
    pub values: &'a [f64],
    /// Cells along x and y.
    pub cells: [usize; 2],
}

impl<'a> Picture<'a> {
    /// A picture of values `[iy][ix]` with so many cells along x and y, on axes that count cells.
    ///
    /// # Errors
    /// Not so many values as cells.
    pub fn new(values: &'a [f64], cells: [usize; 2]) -> Result<Self, PictureError> {
        let [columns, rows] = cells;
        check_shape(values, cells)?;
        Ok(Self {
            title: "",
            x: Axis { label: "column", from: 0.0, to: columns as f64 },
            y: Axis { label: "row", from: 0.0, to: rows as f64 },
            quantity: "",
            colours: ColourMap::Deep,
            limits: Limits::Percentile(98.0),
            reduction: Reduction::Mean,
            equal_aspect: true,
            scale_bar: None,
            masked: "no value",
            size_px: 640,
            values,
            cells,
        })
    }

    /// Pixels of the map across and down.
    fn size(&self) -> [usize; 2] {
        let longest = self.size_px.clamp(SIZE_RANGE_PX[0], SIZE_RANGE_PX[1]);
        let most = self.cells[0].max(self.cells[1]);
        let lengths = [self.x.to - self.x.from, self.y.to - self.y.from];
        let sides = [0, 1].map(|i| lengths[i] / self.cells[i] as f64);
        let square = (sides[0] / sides[1] - 1.0).abs() < 1e-6;
        let size = if self.equal_aspect && square && most <= longest {
            self.cells.map(|n| n * (longest / most))
        } else if self.equal_aspect {
            let greatest = lengths[0].max(lengths[1]);
            lengths.map(|length| (length / greatest * longest as f64).round() as usize)
        } else {
            [longest, (3 * longest).div_ceil(4)]
        };
        size.map(|side| side.max(LEAST_SIDE_PX))
    }

    /// Draws it.
    ///
    /// # Errors
    /// Not so many values as cells, edges in the wrong order, and limits without a range.
    pub fn draw(&self) -> Result<Canvas, PictureError> {
        check_shape(self.values, self.cells)?;
        for (name, axis) in [('x', self.x), ('y', self.y)] {
            if !ticks::is_axis([axis.from, axis.to]) {
                return Err(PictureError::Axis { axis: name, from: axis.from, to: axis.to });
            }
        }
        self.limits.check()?;
        let size = self.size();
        let pixels = resample::resample(self.values, self.cells, size, self.reduction);
        let limits = self.limits.of(&pixels, self.colours.is_diverging());
        Ok(Drawing::new(self, size, limits, &pixels).draw(self, &pixels))
    }
}

fn check_shape(values: &[f64], [columns, rows]: [usize; 2]) -> Result<(), PictureError> {
    if values.is_empty() || columns.checked_mul(rows) != Some(values.len()) {
        return Err(PictureError::Shape { values: values.len(), columns, rows });
    }
    Ok(())
}

fn shortened(text: &str) -> String {
    if text.chars().count() <= LONGEST_TEXT {
        return text.to_owned();
    }
    text.chars().take(LONGEST_TEXT - 3).chain("...".chars()).collect()
}

/// Where everything stands.
struct Drawing {
    size: [usize; 2],
    map: Area,
    bar: Area,
    limits: [f64; 2],
    beyond: [bool; 2],
    masked: bool,
    x_ticks: Vec<ticks::Tick>,
    y_ticks: Vec<ticks::Tick>,
    bar_ticks: Vec<ticks::Tick>,
    title: String,
    labels: [String; 3],
}

/// Between letters and lines, pixels.
const GAP: i64 = 8;
/// Length of ticks, pixels.
const TICK: i64 = 5;
/// Width of the colour bar, pixels.
const BAR: i64 = 18;
/// Height of its pointed ends, pixels.
const POINT: i64 = 12;

fn widest(ticks: &[ticks::Tick]) -> i64 {
    ticks.iter().map(|tick| Face::Small.width(&tick.label)).max().unwrap_or(0)
}

/// Ticks whose labels do not run into each other along x.
fn fitting(limits: [f64; 2], length_px: i64) -> Vec<ticks::Tick> {
    for most in (2..=8).rev() {
        let ticks = ticks::linear(limits, most);
        if (widest(&ticks) + 2 * GAP) * ticks.len() as i64 <= length_px {
            return ticks;
        }
    }
    ticks::linear(limits, 2).into_iter().take(1).collect()
}

impl Drawing {
    fn new(picture: &Picture, size: [usize; 2], limits: [f64; 2], pixels: &[f64]) -> Self {
        let [width, height] = size.map(|side| side as i64);
        let line = Face::Small.height();
        let rows = |length: i64| usize::try_from(length / (2 * line)).unwrap_or(0).clamp(2, 10);
        let x_ticks = fitting([picture.x.from, picture.x.to], width);
        let y_ticks = ticks::linear([picture.y.from, picture.y.to], rows(height));
        let bar_height = height.max(LEAST_BAR_PX);
        let bar_ticks = ticks::linear(limits, rows(bar_height));
        let title = shortened(picture.title);
        let left = GAP + line + GAP + widest(&y_ticks) + TICK + GAP;
        let top = GAP + Face::Large.height() + GAP + POINT;
        let map = [left, top, left + width, top + height];
        let bar_left = map[2] + 3 * GAP;
        let bar = [bar_left, top, bar_left + BAR, top + bar_height];
        Self {
            size,
            map,
            bar,
            limits,
            beyond: [
                pixels.iter().any(|value| *value < limits[0]),
                pixels.iter().any(|value| *value > limits[1]),
            ],
            masked: pixels.iter().any(|value| value.is_nan()),
            x_ticks,
            y_ticks,
            bar_ticks,
            title,
            labels: [picture.x.label, picture.y.label, picture.quantity].map(shortened),
        }
    }

    fn draw(&self, picture: &Picture, pixels: &[f64]) -> Canvas {
        let [left, _, right, bottom] = self.map;
        let line = Face::Small.height();
        let below = bottom + TICK + line + GAP + line / 2;
        let bar_right = self.bar[2] + TICK + GAP + widest(&self.bar_ticks) + GAP + line;
        let key_y = below.max(self.bar[3] + POINT) + GAP + line;
        let (key, key_width) = self.key(picture, key_y);
        let width = [
            bar_right + GAP,
            left + key_width + GAP,
            Face::Large.width(&self.title) + 2 * GAP,
            Face::Small.width(&self.labels[0]) + 2 * GAP,
        ];
        let width = width.into_iter().max().unwrap_or(0);
        // A text along a low map may be longer than all else is high.
        let upright = self.labels[1..].iter().map(|label| Face::Small.width(label)).max().unwrap_or(0);
        let height = (if key.is_empty() { key_y - line } else { key_y + line }).max(upright + 2 * GAP);
        let mut canvas = Canvas::new(width.unsigned_abs() as usize, height.unsigned_abs() as usize, WHITE);
        self.map(&mut canvas, picture.colours, pixels);
        self.axes(&mut canvas, picture);
        self.colour_bar(&mut canvas, picture.colours);
        for part in &key {
            part.draw(&mut canvas);
        }
        let middle = (left + right) / 2;
        centred(&mut canvas, [middle, GAP + Face::Large.height() / 2], &self.title, Face::Large);
        centred(&mut canvas, [middle, below], &self.labels[0], Face::Small);
        canvas
    }

    fn share(&self, value: f64) -> f64 {
        let [low, high] = self.limits;
        (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0)
    }

    fn map(&self, canvas: &mut Canvas, colours: ColourMap, pixels: &[f64]) {
        let [left, _, _, bottom] = self.map;
        // One colour for every step of 8 bit: the conversion is too slow to be done for every pixel.
        let table: Vec<Colour> = (0..=255).map(|i| colours.colour(f64::from(i) / 255.0)).collect();
        for (iy, row) in pixels.chunks_exact(self.size[0]).enumerate() {
            for (ix, value) in row.iter().enumerate() {
                let colour = if value.is_nan() {
                    MASKED
                } else {
                    table[(255.0 * self.share(*value).clamp(0.0, 1.0)).round() as usize]
                };
                canvas.set(left + ix as i64, bottom - 1 - iy as i64, colour);
            }
        }
        canvas.outline(self.map, INK);
    }

    fn axes(&self, canvas: &mut Canvas, picture: &Picture) {
        let [left, top, right, bottom] = self.map;
        let line = Face::Small.height();
        for tick in &self.x_ticks {
            let x = left + along(tick.at, picture.x.from, picture.x.to, right - left);
            canvas.fill([x, bottom, x + 1, bottom + TICK], INK);
            canvas.text([x, bottom + TICK + line / 2 + 1], &tick.label, Face::Small, Align::Middle, INK);
        }
        for tick in &self.y_ticks {
            let y = bottom - 1 - along(tick.at, picture.y.from, picture.y.to, bottom - top);
            canvas.fill([left - TICK, y, left, y + 1], INK);
            canvas.text([left - TICK - 3, y], &tick.label, Face::Small, Align::End, INK);
        }
        upward(canvas, [GAP + line / 2, (top + bottom) / 2], &self.labels[1]);
    }

    fn colour_bar(&self, canvas: &mut Canvas, colours: ColourMap) {
        let [left, top, right, bottom] = self.bar;
        let height = bottom - top;
        for y in top..bottom {
            let share = (bottom - y) as f64 - 0.5;
            canvas.fill([left, y, right, y + 1], colours.colour(share / height as f64));
        }
        canvas.outline(self.bar, INK);
        let middle = (left + right) / 2;
        for (beyond, share, edge, way) in
            [(self.beyond[0], 0.0, bottom + 1, 1), (self.beyond[1], 1.0, top - 2, -1)]
        {
            for step in 0..if beyond { POINT - 2 } else { 0 } {
                let half = BAR / 2 * (POINT - 2 - step) / (POINT - 2);
                let y = edge + way * step;
                canvas.fill([middle - half, y, middle + half, y + 1], colours.colour(share));
            }
        }
        for tick in &self.bar_ticks {
            let y = bottom - 1 - along(tick.at, self.limits[0], self.limits[1], height);
            canvas.fill([right, y, right + TICK, y + 1], INK);
            canvas.text([right + TICK + 3, y], &tick.label, Face::Small, Align::Start, INK);
        }
        let line = Face::Small.height();
        let x = right + TICK + GAP + widest(&self.bar_ticks) + GAP + line / 2;
        upward(canvas, [x, (top + bottom) / 2], &self.labels[2]);
    }

    /// Scale bar and the meaning of grey, and how far they reach to the right of the map's edge.
    fn key(&self, picture: &Picture, y: i64) -> (Vec<Key>, i64) {
        let [left, _, right, _] = self.map;
        let mut parts = Vec::new();
        let mut at = left;
        if let Some(unit) = picture.scale_bar {
            let span = picture.x.to - picture.x.from;
            let length = ticks::round_below(span / 4.0);
            let pixels = along(length, 0.0, span, right - left).max(1);
            let text = shortened(&measure(length, unit));
            parts.push(Key { at: [at, y], width: pixels, height: 5, colour: INK, text });
        }
        if let Some(bar) = parts.first() {
            at = bar.right() + 3 * GAP;
        }
        if self.masked {
            let text = shortened(picture.masked);
            parts.push(Key { at: [at, y], width: 14, height: 14, colour: MASKED, text });
        }
        let reach = parts.last().map_or(0, |part| part.right() - left);
        (parts, reach)
    }
}

/// A mark below the map with its meaning beside it.
struct Key {
    at: [i64; 2],
    width: i64,
    height: i64,
    colour: Colour,
    text: String,
}

impl Key {
    fn right(&self) -> i64 {
        self.at[0] + self.width + GAP + Face::Small.width(&self.text)
    }

    fn draw(&self, canvas: &mut Canvas) {
        let [x, y] = self.at;
        let top = y - self.height / 2;
        canvas.fill([x, top, x + self.width, top + self.height], self.colour);
        canvas.text([x + self.width + GAP, y], &self.text, Face::Small, Align::Start, INK);
    }
}

/// A length with its unit; thousands of metres are kilometres.
fn measure(length: f64, unit: &str) -> String {
    let (length, unit) =
        if unit == "m" && length >= 1000.0 { (length / 1000.0, "km") } else { (length, unit) };
    if (1e-3..1e5).contains(&length) { format!("{length} {unit}") } else { format!("{length:.0e} {unit}") }
}

/// Pixels from the beginning of an axis of so many.
fn along(value: f64, from: f64, to: f64, pixels: i64) -> i64 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    ((share * pixels as f64).floor() as i64).min(pixels - 1)
}

/// A text about a place, moved where it would leave the canvas.
fn centred(canvas: &mut Canvas, [x, y]: [i64; 2], text: &str, face: Face) {
    let half = face.width(text) / 2;
    let most = (canvas.width() as i64 - GAP - half).max(GAP + half);
    canvas.text([x.clamp(GAP + half, most), y], text, face, Align::Middle, INK);
}

fn upward(canvas: &mut Canvas, [x, y]: [i64; 2], text: &str) {
    let half = Face::Small.width(text) / 2;
    let most = (canvas.height() as i64 - GAP - half).max(GAP + half);
    canvas.text_up([x, y.clamp(GAP + half, most)], text, Face::Small, Align::Middle, INK);
}

#[cfg(test)]
mod tests;
