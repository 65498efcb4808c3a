//! Curves on linear, logarithmic or decibel axes.
//!
//! Limits of an axis are those of the points, with a small margin, unless given. Points that an axis cannot
//! show (no number, beyond 1e150, not positive on a logarithmic or decibel axis) break their curve. The
//! legend stands beside the frame and hides nothing. Colours repeat after eight curves.
//!
//! ```
//! use nereus::plot::chart::{Curve, Mark, Plot, PlotAxis, Spacing};
//! let cost: Vec<[f64; 2]> = (0..40).map(|i| [10f64.powf(0.05 * f64::from(i)), 10f64.powi(-i)]).collect();
//! let plot = Plot {
//!     title: "Error against cost",
//!     x: PlotAxis { label: "cost, s", spacing: Spacing::Logarithmic, limits: None },
//!     y: PlotAxis { label: "error, dB", spacing: Spacing::Decibels, limits: Some([1e-12, 1.0]) },
//!     curves: &[Curve { name: "width 6", points: &cost, mark: Mark::Dots }],
//!     size_px: [640, 400],
//! };
//! let mut png = Vec::new();
//! plot.draw()?.write_png(&mut png)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::canvas::{Align, Area, Canvas, Face};
use super::colours::{CURVES, Colour, FAINT, INK, WHITE};
use super::ticks::{self, Tick};

/// Sides of the frame that may be asked, pixels.
pub const SIZE_RANGE_PX: [usize; 2] = [64, 8192];
/// Curves that the legend names.
const LISTED: usize = 64;
/// Longest text that is written, characters.
const LONGEST_TEXT: usize = 120;
const GAP: i64 = 8;
const TICK: i64 = 5;

/// How numbers are put along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Spacing {
    /// Evenly.
    #[default]
    Linear,
    /// By their logarithm.
    Logarithmic,
    /// By their logarithm; ratios of power, labelled in decibels.
    Decibels,
}

impl Spacing {
    /// Place of a number along the axis; none if it has none.
    fn place(self, value: f64) -> Option<f64> {
        let place = match self {
            Self::Linear => value,
            Self::Logarithmic => value.log10(),
            Self::Decibels => 10.0 * value.log10(),
        };
        (place.is_finite() && place.abs() <= ticks::LARGEST).then_some(place)
    }
}

/// One axis of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotAxis<'a> {
    /// Quantity and unit.
    pub label: &'a str,
    /// How numbers are put along it.
    pub spacing: Spacing,
    /// First and last number; `None` for those of the points.
    pub limits: Option<[f64; 2]>,
}

/// How points are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mark {
    /// By the line through them.
    #[default]
    Line,
    /// By a dot each.
    Dots,
}

/// One curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve<'a> {
    /// Text of the legend; nothing for a curve that it does not name.
    pub name: &'a str,
    /// Points (x, y) in their order.
    pub points: &'a [[f64; 2]],
    /// How they are shown.
    pub mark: Mark,
}

/// Limits that an axis cannot have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "axis {axis} from {low} to {high}: two numbers in their order are needed, above 0 unless the axis is linear"
)]
pub struct PlotError {
    /// `x` or `y`.
    pub axis: char,
    /// First number.
    pub low: f64,
    /// Last number.
    pub high: f64,
}

/// Curves to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plot<'a> {
    /// Above the frame.
    pub title: &'a str,
    /// To the right.
    pub x: PlotAxis<'a>,
    /// Upward.
    pub y: PlotAxis<'a>,
    /// The curves, the first one lowest.
    pub curves: &'a [Curve<'a>],
    /// Width and height of the frame, pixels; held within [`SIZE_RANGE_PX`].
    pub size_px: [usize; 2],
}

/// An axis with its limits and round numbers.
struct Ruler {
    spacing: Spacing,
    limits: [f64; 2],
    ticks: Vec<Tick>,
}

impl Ruler {
    fn new(
        name: char,
        axis: &PlotAxis,
        values: impl Iterator<Item = f64>,
        most: usize,
    ) -> Result<Self, PlotError> {
        let limits = match axis.limits {
            Some([low, high]) => {
                let places = axis.spacing.place(low).zip(axis.spacing.place(high));
                places
                    .map(|(low, high)| [low, high])
                    .filter(|limits| ticks::is_axis(*limits))
                    .ok_or(PlotError { axis: name, low, high })?
            }
            None => {
                let places = values.filter_map(|value| axis.spacing.place(value));
                let [low, high] = places
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
                let [low, high] = ticks::spread([low, high]);
                // So that no curve runs along the frame.
                let room = 0.03 * (high - low);
                ticks::spread([low - room, high + room].map(|v| v.clamp(-ticks::LARGEST, ticks::LARGEST)))
            }
        };
        let ticks = match axis.spacing {
            Spacing::Linear | Spacing::Decibels => ticks::linear(limits, most),
            Spacing::Logarithmic => ticks::logarithmic(limits, most),
        };
        Ok(Self { spacing: axis.spacing, limits, ticks })
    }

    /// Share of the axis at which a place on it lies.
    fn share(&self, place: f64) -> f64 {
        let [low, high] = self.limits;
        (place / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0)
    }

    fn widest(&self) -> i64 {
        self.ticks.iter().map(|tick| Face::Small.width(&tick.label)).max().unwrap_or(0)
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(LONGEST_TEXT).collect()
}

fn colour(index: usize) -> Colour {
    CURVES[index % CURVES.len()]
}

impl Plot<'_> {
    /// Draws it.
    ///
    /// # Errors
    /// Axes without a finite extent.
    pub fn draw(&self) -> Result<Canvas, PlotError> {
        let [width, height] = self.size_px.map(|side| side.clamp(SIZE_RANGE_PX[0], SIZE_RANGE_PX[1]) as i64);
        let values = |i: usize| self.curves.iter().flat_map(|c| c.points).map(move |point| point[i]);
        let line = Face::Small.height();
        let room = |pixels: i64| usize::try_from(pixels).unwrap_or(0).clamp(2, 10);
        let x = (2..=room(width / 60))
            .rev()
            .map(|most| Ruler::new('x', &self.x, values(0), most))
            .find(|ruler| match ruler {
                Ok(ruler) => (ruler.widest() + GAP) * ruler.ticks.len() as i64 <= width,
                Err(_) => true,
            })
            .unwrap_or_else(|| Ruler::new('x', &self.x, values(0), 2))?;
        let y = Ruler::new('y', &self.y, values(1), room(height / (2 * line)))?;
        let left = GAP + line + GAP + y.widest() + TICK + GAP;
        let top = GAP + Face::Large.height() + GAP;
        let frame = [left, top, left + width, top + height];
        let [_, _, right, bottom] = frame;
        let named: Vec<(usize, String)> = self
            .curves
            .iter()
            .enumerate()
            .filter(|(_, curve)| !curve.name.is_empty())
            .take(LISTED)
            .map(|(i, curve)| (i, shortened(curve.name)))
            .collect();
        let legend = named.iter().map(|(_, name)| Face::Small.width(name) + 5 * GAP).max().unwrap_or(0);
        let [title, across, up] = [self.title, self.x.label, self.y.label].map(shortened);
        // Round about the middle of the frame.
        let half = (Face::Large.width(&title)).max(Face::Small.width(&across)) / 2;
        let middle = ((left + right) / 2).max(half + GAP);
        let canvas_width = (right + 2 * GAP + legend).max(middle + half + GAP);
        let canvas_height = [
            bottom + TICK + line + GAP + line + GAP,
            top + line * named.len() as i64 + GAP,
            Face::Small.width(&up) + 2 * GAP,
        ];
        let canvas_height = canvas_height.into_iter().max().unwrap_or(0);
        let mut canvas =
            Canvas::new(canvas_width.unsigned_abs() as usize, canvas_height.unsigned_abs() as usize, WHITE);
        canvas.text([middle, GAP + Face::Large.height() / 2], &title, Face::Large, Align::Middle, INK);
        canvas.text(
            [middle, bottom + TICK + line + GAP + line / 2],
            &across,
            Face::Small,
            Align::Middle,
            INK,
        );
        let up_half = Face::Small.width(&up) / 2;
        let up_middle = ((top + bottom) / 2).max(up_half + GAP);
        canvas.text_up([GAP + line / 2, up_middle], &up, Face::Small, Align::Middle, INK);
        rulers(&mut canvas, frame, &x, &y);
        self.curves(&mut canvas, frame, &x, &y);
        for (row, (i, name)) in named.iter().enumerate() {
            let at = [right + GAP, top + line / 2 + line * row as i64];
            let mark = [
                [at[0], at[1] - 1, at[0] + 3 * GAP, at[1] + 1],
                [at[0] + GAP, at[1] - 4, at[0] + 2 * GAP, at[1] + 4],
            ];
            canvas.fill(mark[usize::from(self.curves[*i].mark == Mark::Dots)], colour(*i));
            canvas.text([at[0] + 4 * GAP, at[1]], name, Face::Small, Align::Start, INK);
        }
        Ok(canvas)
    }

    fn curves(&self, canvas: &mut Canvas, frame: Area, x: &Ruler, y: &Ruler) {
        let [left, top, right, bottom] = frame;
        for (i, curve) in self.curves.iter().enumerate() {
            let points: Vec<[f64; 2]> = curve
                .points
                .iter()
                .map(|[u, v]| match (x.spacing.place(*u), y.spacing.place(*v)) {
                    (Some(u), Some(v)) => [
                        left as f64 + x.share(u) * (right - left) as f64,
                        bottom as f64 - y.share(v) * (bottom - top) as f64,
                    ],
                    _ => [f64::NAN; 2],
                })
                .collect();
            if curve.mark != Mark::Dots {
                canvas.line(&points, 1.8, frame, colour(i));
            }
            if curve.mark != Mark::Line {
                for point in &points {
                    canvas.disc(*point, 3.0, frame, colour(i));
                }
            }
        }
    }
}

fn rulers(canvas: &mut Canvas, frame: Area, x: &Ruler, y: &Ruler) {
    let [left, top, right, bottom] = frame;
    let line = Face::Small.height();
    for tick in &x.ticks {
        let at = left + (x.share(tick.at) * (right - left) as f64).floor() as i64;
        let at = at.min(right - 1);
        canvas.fill([at, top, at + 1, bottom], FAINT);
        canvas.fill([at, bottom, at + 1, bottom + TICK], INK);
        canvas.text([at, bottom + TICK + line / 2 + 1], &tick.label, Face::Small, Align::Middle, INK);
    }
    for tick in &y.ticks {
        let at = bottom - 1 - (y.share(tick.at) * (bottom - top) as f64).floor() as i64;
        let at = at.max(top);
        canvas.fill([left, at, right, at + 1], FAINT);
        canvas.fill([left - TICK, at, left, at + 1], INK);
        canvas.text([left - TICK - 3, at], &tick.label, Face::Small, Align::End, INK);
    }
    canvas.outline(frame, INK);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PLAIN: PlotAxis<'static> = PlotAxis { label: "x, m", spacing: Spacing::Linear, limits: None };

    fn plot<'a>(curves: &'a [Curve<'a>], x: PlotAxis<'a>, y: PlotAxis<'a>) -> Plot<'a> {
        Plot { title: "Plot", x, y, curves, size_px: [400, 300] }
    }

    /// Whether a pixel is mostly covered by a colour.
    fn near(found: Colour, wanted: Colour) -> bool {
        (0..3).all(|i| found[i].abs_diff(wanted[i]) < 60)
    }

    /// Mean row of a curve's colour in a column of the frame, as a share upward.
    fn height_at(canvas: &Canvas, frame: Area, share: f64, wanted: Colour) -> f64 {
        let x = frame[0] + (share * (frame[2] - frame[0]) as f64) as i64;
        let rows: Vec<f64> = (frame[1]..frame[3])
            .filter(|y| canvas.pixel(x, *y).is_some_and(|c| near(c, wanted)))
            .map(|y| y as f64 + 0.5)
            .collect();
        assert!(!rows.is_empty(), "nothing at {share}");
        (frame[3] as f64 - rows.iter().sum::<f64>() / rows.len() as f64) / (frame[3] - frame[1]) as f64
    }

    /// The frame: the longest lines of ink.
    fn frame(canvas: &Canvas) -> Area {
        let (width, height) = (canvas.width() as i64, canvas.height() as i64);
        let dark = |x, y| canvas.pixel(x, y) == Some(INK);
        let rows: Vec<i64> =
            (0..height).filter(|y| (0..width).filter(|x| dark(*x, *y)).count() >= 400).collect();
        let columns: Vec<i64> =
            (0..width).filter(|x| (0..height).filter(|y| dark(*x, *y)).count() >= 300).collect();
        assert_eq!((rows.len(), columns.len()), (2, 2));
        [columns[0] + 1, rows[0] + 1, columns[1], rows[1]]
    }

    #[test]
    fn curves_are_where_their_numbers_are() {
        // On logarithmic and decibel axes a power law is a straight line: y = x^-2 over 0.1 to 1000.
        let law: Vec<[f64; 2]> =
            (-10..=30).map(|i| 10f64.powf(0.1 * f64::from(i))).map(|x| [x, x.powi(-2)]).collect();
        let curves = [Curve { name: "law", points: &law, mark: Mark::Line }];
        let x = PlotAxis { label: "x", spacing: Spacing::Logarithmic, limits: Some([0.1, 1000.0]) };
        let y = PlotAxis { label: "y, dB", spacing: Spacing::Decibels, limits: Some([1e-8, 1e2]) };
        let canvas = plot(&curves, x, y).draw().unwrap();
        let frame = frame(&canvas);
        assert_eq!((frame[2] - frame[0], frame[3] - frame[1]), (400, 300));
        for share in [0.1, 0.33, 0.5, 0.77, 0.9] {
            // x = 10^(4 share - 1), y = -20 (4 share - 1) dB, on the axis from -80 to 20 dB.
            let expected = (80.0 - 20.0 * (4.0 * share - 1.0)) / 100.0;
            let found = height_at(&canvas, frame, share, CURVES[0]);
            // A pixel of 300, and one of 400 along a line of slope -0.6.
            assert!((found - expected).abs() < 2.0 / 300.0, "{share}: {found} for {expected}");
        }
    }

    #[test]
    fn what_an_axis_cannot_show_breaks_the_curve() {
        let points = [[0.0, 1.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 1.0], [4.0, 1.0], [5.0, -1.0]];
        let curves = [Curve { name: "", points: &points, mark: Mark::Line }];
        let x = PlotAxis { limits: Some([0.0, 5.0]), ..PLAIN };
        let y = PlotAxis { spacing: Spacing::Logarithmic, ..PLAIN };
        let canvas = plot(&curves, x, y).draw().unwrap();
        let frame = frame(&canvas);
        for (share, drawn) in [(0.1, true), (0.3, false), (0.5, false), (0.7, true), (0.9, false)] {
            let x = frame[0] + (share * 400.0) as i64;
            let found = (frame[1]..frame[3]).any(|y| canvas.pixel(x, y).is_some_and(|c| near(c, CURVES[0])));
            assert_eq!(found, drawn, "{share}");
        }
    }

    #[test]
    fn limits_must_fit_the_axis() {
        let bad = |spacing, limits| {
            plot(&[], PlotAxis { spacing, limits: Some(limits), ..PLAIN }, PLAIN).draw().is_err()
        };
        assert!(bad(Spacing::Linear, [1.0, 1.0]) && bad(Spacing::Linear, [f64::NAN, 1.0]));
        assert!(bad(Spacing::Logarithmic, [0.0, 1.0]) && bad(Spacing::Decibels, [-1.0, 1.0]));
        assert!(!bad(Spacing::Linear, [-1.0, 1.0]));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_curves_are_drawn(
            first in prop::collection::vec([any::<f64>(), any::<f64>()], 0..60),
            second in prop::collection::vec([-3.0..3.0f64, -3.0..3.0f64], 0..60),
            name in ".{0,150}",
            which in 0usize..9,
            size in [0usize..500, 0usize..500],
        ) {
            let spacings = [Spacing::Linear, Spacing::Logarithmic, Spacing::Decibels];
            let marks = [Mark::Line, Mark::Dots];
            let curves = [
                Curve { name: &name, points: &first, mark: marks[which % 2] },
                Curve { name: "b", points: &second, mark: marks[which / 3 % 2] },
            ];
            let axis = |spacing| PlotAxis { label: &name, spacing, limits: None };
            let plot = Plot {
                title: &name,
                x: axis(spacings[which % 3]),
                y: axis(spacings[which / 3]),
                curves: &curves,
                size_px: size,
            };
            let canvas = plot.draw().unwrap();
            prop_assert!(canvas.width() < 4000 && canvas.height() < 4000);
        }
    }
}
