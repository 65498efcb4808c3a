//! What a radar sees around it, from above: range rings, bearing marks, a colour bar.
//!
//! The radar is in the middle, bearing 0 is up and bearings grow clockwise. Pixels that are no number stay
//! white. Rings and their labels are in metres, marks at the rim in degrees.
//!
//! ```
//! use nereus::plot::plan::{Mark, Plan};
//! let mut level_dbw = vec![-120.0; 65 * 65];
//! level_dbw[10 * 65 + 32] = -60.0;
//! let plan = Plan {
//!     title: "HH, North up",
//!     level: &level_dbw,
//!     side: 65,
//!     radius_m: 2400.0,
//!     limits: [-120.0, -60.0],
//!     quantity: "dBW",
//!     marks: &[Mark { name: "buoy", range_m: 1624.0, bearing_rad: 0.0 }],
//! };
//! assert!(plan.draw()?.width() > 65);
//! # Ok::<(), nereus::plot::picture::PictureError>(())
//! ```

use std::f64::consts::TAU;

use super::canvas::{Align, Area, Canvas, Face};
use super::colours::{CURVES, Colour, ColourMap, INK, WHITE};
use super::picture::PictureError;
use super::ticks;

/// Rings and what is between the marks.
const LINES: Colour = [168, 168, 176];
/// Marks of places.
const PLACES: Colour = CURVES[1];
/// Between letters and lines, pixels.
const GAP: i64 = 8;
/// Room for the labels about the rim, pixels.
const RIM: i64 = 44;
/// Width of the colour bar, pixels.
const BAR: i64 = 18;
/// Half the side of the mark of a place, pixels.
const PLACE: i64 = 9;
/// Pieces of a ring.
const PIECES: usize = 360;

/// A place to be marked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark<'a> {
    /// Stands beside it.
    pub name: &'a str,
    /// Range, m.
    pub range_m: f64,
    /// Bearing, clockwise from what is up, rad.
    pub bearing_rad: f64,
}

/// A plan to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// Above it.
    pub title: &'a str,
    /// Levels, `side` by `side`, row by row from above, each from the left.
    pub level: &'a [f64],
    /// Pixels along a side.
    pub side: usize,
    /// Range at the rim, m.
    pub radius_m: f64,
    /// Levels of the first and last colour.
    pub limits: [f64; 2],
    /// Along the colour bar.
    pub quantity: &'a str,
    /// Places to be marked.
    pub marks: &'a [Mark<'a>],
}

impl Plan<'_> {
    /// Draws it. Plans of one side and the same limits become pictures of one size.
    ///
    /// # Errors
    /// Not as many levels as pixels, no range, limits without a range.
    pub fn draw(&self) -> Result<Canvas, PictureError> {
        let (side, [low, high]) = (self.side, self.limits);
        if side == 0 || side.checked_mul(side) != Some(self.level.len()) {
            return Err(PictureError::Shape { values: self.level.len(), columns: side, rows: side });
        }
        if !ticks::is_axis([0.0, self.radius_m]) {
            return Err(PictureError::Axis { axis: 'y', from: 0.0, to: self.radius_m });
        }
        if !ticks::is_axis(self.limits) {
            return Err(PictureError::Limits { low, high });
        }
        let line = Face::Small.height();
        let bar_ticks = ticks::linear(self.limits, 10);
        let widest = bar_ticks.iter().map(|tick| Face::Small.width(&tick.label)).max().unwrap_or(0);
        let top = GAP + Face::Large.height() + RIM;
        let map = [RIM, top, RIM + side as i64, top + side as i64];
        let bar = [map[2] + RIM, top, map[2] + RIM + BAR, map[3]];
        let size = [bar[2] + GAP + widest + GAP + line + GAP, map[3] + RIM];
        let mut canvas = Canvas::new(size[0].unsigned_abs() as usize, size[1].unsigned_abs() as usize, WHITE);
        self.levels(&mut canvas, map);
        self.rings(&mut canvas, map);
        self.rim(&mut canvas, map);
        for mark in self.marks {
            self.mark(&mut canvas, map, mark);
        }
        self.colour_bar(&mut canvas, bar, &bar_ticks, widest);
        let middle = (map[0] + map[2]) / 2;
        canvas.text([middle, GAP + Face::Large.height() / 2], self.title, Face::Large, Align::Middle, INK);
        Ok(canvas)
    }

    fn levels(&self, canvas: &mut Canvas, [left, top, ..]: Area) {
        let [low, high] = self.limits;
        // The conversion is too slow to be done for every pixel.
        let table: Vec<Colour> = (0..=255).map(|i| ColourMap::Deep.colour(f64::from(i) / 255.0)).collect();
        for (row, levels) in (0i64..).zip(self.level.chunks_exact(self.side)) {
            for (column, level) in (0i64..).zip(levels).filter(|(_, level)| !level.is_nan()) {
                let share = ((level - low) / (high - low)).clamp(0.0, 1.0);
                canvas.set(left + column, top + row, table[(255.0 * share).round() as usize]);
            }
        }
    }

    /// Where a range and a bearing are, pixels.
    fn place(&self, [left, top, ..]: Area, range_m: f64, bearing_rad: f64) -> [f64; 2] {
        let half = 0.5 * self.side as f64;
        let along = half * range_m / self.radius_m;
        let (sin, cos) = bearing_rad.sin_cos();
        [left as f64 + half + along * sin, top as f64 + half - along * cos]
    }

    fn ring(&self, canvas: &mut Canvas, map: Area, range_m: f64, colour: Colour) {
        let at = |i: usize| self.place(map, range_m, i as f64 * TAU / PIECES as f64);
        let points: Vec<[f64; 2]> = (0..=PIECES).map(at).collect();
        canvas.line(&points, 1.0, [map[0] - 1, map[1] - 1, map[2] + 1, map[3] + 1], colour);
    }

    fn rings(&self, canvas: &mut Canvas, map: Area) {
        let step_m = ticks::round_below(self.radius_m / 3.0);
        let count = (self.radius_m / step_m * (1.0 - 1e-9)).floor() as usize;
        for n in 1..=count {
            self.ring(canvas, map, n as f64 * step_m, LINES);
        }
        for quarter in 0..4 {
            let bearing_rad = f64::from(quarter) * TAU / 4.0;
            let ends = [step_m.min(self.radius_m), self.radius_m];
            canvas.line(&ends.map(|range| self.place(map, range, bearing_rad)), 1.0, map, LINES);
        }
        for n in 1..=count {
            let range_m = n as f64 * step_m;
            let at = self.place(map, range_m, TAU / 16.0).map(|x| x.round() as i64);
            boxed(canvas, at, &format!("{range_m} m"), Align::Middle);
        }
        self.ring(canvas, map, self.radius_m, INK);
    }

    fn rim(&self, canvas: &mut Canvas, map: Area) {
        let pixel_m = 2.0 * self.radius_m / self.side as f64;
        let around = [0, 0, canvas.width() as i64, canvas.height() as i64];
        for tens in 0..36 {
            let bearing_rad = f64::from(tens) * TAU / 36.0;
            let is_labelled = tens % 3 == 0;
            let length = if is_labelled { 8.0 } else { 4.0 };
            let ends = [self.radius_m, self.radius_m + length * pixel_m];
            canvas.line(&ends.map(|range| self.place(map, range, bearing_rad)), 1.0, around, INK);
            if is_labelled {
                let at = self.place(map, self.radius_m + 24.0 * pixel_m, bearing_rad);
                let text = format!("{:03}\u{b0}", 10 * tens);
                canvas.text(at.map(|x| x.round() as i64), &text, Face::Small, Align::Middle, INK);
            }
        }
    }

    fn mark(&self, canvas: &mut Canvas, map: Area, mark: &Mark) {
        if !(0.0..=self.radius_m).contains(&mark.range_m) || !mark.bearing_rad.is_finite() {
            return;
        }
        let [x, y] = self.place(map, mark.range_m, mark.bearing_rad).map(|x| x.floor() as i64);
        let area = [x - PLACE, y - PLACE, x + PLACE + 1, y + PLACE + 1];
        canvas.outline(area, PLACES);
        canvas.outline([area[0] - 1, area[1] - 1, area[2] + 1, area[3] + 1], PLACES);
        let to_the_left = mark.bearing_rad.sin() > 0.0 && mark.range_m > 0.7 * self.radius_m;
        let side = if to_the_left { -1 } else { 1 };
        let align = if to_the_left { Align::End } else { Align::Start };
        boxed(canvas, [x + side * (PLACE + GAP), y], mark.name, align);
    }

    fn colour_bar(&self, canvas: &mut Canvas, bar: Area, bar_ticks: &[ticks::Tick], widest: i64) {
        let [left, top, right, bottom] = bar;
        let height = bottom - top;
        for y in top..bottom {
            let share = ((bottom - y) as f64 - 0.5) / height as f64;
            canvas.fill([left, y, right, y + 1], ColourMap::Deep.colour(share));
        }
        canvas.outline(bar, INK);
        let [low, high] = self.limits;
        for tick in bar_ticks {
            let share = (tick.at - low) / (high - low);
            let y = bottom - 1 - (share * (height - 1) as f64).round() as i64;
            canvas.fill([right, y, right + 5, y + 1], INK);
            canvas.text([right + GAP, y], &tick.label, Face::Small, Align::Start, INK);
        }
        let x = right + GAP + widest + GAP + Face::Small.height() / 2;
        canvas.text_up([x, (top + bottom) / 2], self.quantity, Face::Small, Align::Middle, INK);
    }
}

/// A text on a white ground.
fn boxed(canvas: &mut Canvas, [x, y]: [i64; 2], text: &str, align: Align) {
    let (width, height) = (Face::Small.width(text), Face::Small.height());
    let left = match align {
        Align::Start => x,
        Align::Middle => x - width / 2,
        Align::End => x - width,
    };
    canvas.fill([left - 2, y - height / 2, left + width + 2, y + height / 2], WHITE);
    canvas.text([x, y], text, Face::Small, align, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan<'a>(level: &'a [f64], marks: &'a [Mark<'a>]) -> Plan<'a> {
        let limits = [-100.0, -50.0];
        Plan { title: "t", level, side: 201, radius_m: 900.0, limits, quantity: "dBW", marks }
    }

    #[test]
    fn bearing_0_is_up_and_bearings_grow_clockwise() {
        let mut level = vec![f64::NAN; 201 * 201];
        level[30 * 201 + 160] = -50.0;
        let canvas = plan(&level, &[]).draw().unwrap();
        let [left, top] = [RIM, GAP + Face::Large.height() + RIM];
        assert_eq!(canvas.pixel(left + 160, top + 30), Some(ColourMap::Deep.colour(1.0)));
        let mark = |range_m, bearing_deg: f64| {
            let marks = [Mark { name: "", range_m, bearing_rad: bearing_deg.to_radians() }];
            let canvas = plan(&level, &marks).draw().unwrap();
            let found = (0..canvas.height() as i64)
                .flat_map(|y| (0..canvas.width() as i64).map(move |x| [x, y]))
                .find(|[x, y]| canvas.pixel(*x, *y) == Some(PLACES));
            found.map(|[x, y]| [x + PLACE + 2 - left, y + PLACE + 2 - top])
        };
        for (bearing_deg, place) in
            [(0.0, [100, 50]), (90.0, [150, 100]), (180.0, [100, 150]), (270.0, [50, 100])]
        {
            // 450 m are half of the way to the rim.
            let found = mark(450.0, bearing_deg).unwrap();
            assert!((0..2).all(|i| found[i].abs_diff(place[i]) <= 1), "{bearing_deg}: {found:?}");
        }
        assert_eq!(mark(901.0, 0.0), None);
    }

    #[test]
    fn what_cannot_be_drawn_is_reported() {
        let level = vec![0.0; 201 * 201];
        let good = plan(&level, &[]);
        assert!(matches!(Plan { side: 200, ..good }.draw(), Err(PictureError::Shape { .. })));
        assert!(matches!(Plan { radius_m: 0.0, ..good }.draw(), Err(PictureError::Axis { .. })));
        assert!(matches!(Plan { limits: [1.0, 1.0], ..good }.draw(), Err(PictureError::Limits { .. })));
    }
}
