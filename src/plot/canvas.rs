//! Pixels, lines and letters; PNG.
//!
//! x to the right and y **downward** in pixels, as in the file; integer pixels have their centres at halves.
//! What lies outside is not drawn. Lines are smoothed by the share of a pixel that they cover (distance of
//! its centre from the line, to a good 0.1). Letters are rastered beforehand (Noto Sans Mono, Latin-1); other
//! characters become `?`.
//!
//! ```
//! use nereus::plot::canvas::{Align, Canvas, Face};
//! use nereus::plot::colours::{INK, WHITE};
//! let mut canvas = Canvas::new(80, 40, WHITE);
//! canvas.text([40, 20], "sea", Face::Small, Align::Middle, INK);
//! let mut png = Vec::new();
//! canvas.write_png(&mut png)?;
//! assert_eq!(canvas.pixel(0, 0), Some(WHITE));
//! # Ok::<(), nereus::plot::canvas::PngError>(())
//! ```

use std::fs::File;
use std::io::{BufWriter, Write};

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

use super::colours::Colour;
use crate::recording::output::{Output, OutputError};

/// Largest side of a canvas, pixels.
pub const MAX_SIDE: usize = 1 << 14;

/// A PNG cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("the picture cannot be written: {0}")]
pub struct PngError(#[from] png::EncodingError);

/// A picture is not made as a file.
#[derive(Debug, thiserror::Error)]
pub enum PictureFileError {
    /// The file may not be made, or cannot.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The picture cannot be written.
    #[error(transparent)]
    Png(#[from] PngError),
}

impl PictureFileError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Output(error) => error.is_wrong_input(),
            Self::Png(_) => false,
        }
    }
}

/// How letters look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Labels: 16 pixels high.
    Small,
    /// Titles: 20 pixels high and bold.
    Large,
}

impl Face {
    fn raster(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Small => (FontWeight::Regular, RasterHeight::Size16),
            Self::Large => (FontWeight::Bold, RasterHeight::Size20),
        }
    }

    /// Pixels from line to line.
    pub fn height(self) -> i64 {
        self.raster().1.val() as i64
    }

    /// Width of a text, pixels.
    pub fn width(self, text: &str) -> i64 {
        let (weight, height) = self.raster();
        (text.chars().count().min(MAX_SIDE) * get_raster_width(weight, height)) as i64
    }
}

/// Which part of a text stands at its place; vertically it is always the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// A rectangle of pixels: left, top, right, bottom; right and bottom are the first outside.
pub type Area = [i64; 4];

/// A picture under way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Canvas {
    /// An even area; sides are held between 1 and [`MAX_SIDE`].
    pub fn new(width: usize, height: usize, colour: Colour) -> Self {
        let [width, height] = [width, height].map(|side| side.clamp(1, MAX_SIDE));
        Self { width, height, rgb: colour.repeat(width * height) }
    }

    /// Canvases side by side, `columns` to a row, each in a box as large as the largest; what is left is
    /// filled. At most [`MAX_SIDE`] to a side.
    pub fn tiled(canvases: &[Self], columns: usize, colour: Colour) -> Self {
        let columns = columns.clamp(1, canvases.len().max(1));
        let most = |side: fn(&Self) -> usize| canvases.iter().map(side).max().unwrap_or(1);
        let [width, height] = [most(Self::width), most(Self::height)];
        let rows = canvases.len().div_ceil(columns);
        let mut whole = Self::new(columns * width, rows * height, colour);
        for (place, canvas) in canvases.iter().enumerate() {
            let [left, top] = [(place % columns) * width, (place / columns) * height];
            if left + canvas.width > whole.width {
                continue;
            }
            for (y, row) in canvas.rgb.chunks_exact(3 * canvas.width).enumerate() {
                let at = 3 * ((top + y) * whole.width + left);
                if let Some(target) = whole.rgb.get_mut(at..at + row.len()) {
                    target.copy_from_slice(row);
                }
            }
        }
        whole
    }

    /// Pixels across.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The colour of a pixel; none outside.
    pub fn pixel(&self, x: i64, y: i64) -> Option<Colour> {
        self.place(x, y).map(|at| [self.rgb[at], self.rgb[at + 1], self.rgb[at + 2]])
    }

    fn place(&self, x: i64, y: i64) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.width && y < self.height).then(|| 3 * (y * self.width + x))
    }

    /// Sets a pixel.
    pub fn set(&mut self, x: i64, y: i64, colour: Colour) {
        self.blend(x, y, colour, 1.0);
    }

    /// Lays a colour over a pixel that covers a share of it, 0 to 1.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, share: f32) {
        if let Some(at) = self.place(x, y) {
            for (below, above) in self.rgb[at..at + 3].iter_mut().zip(colour) {
                let mixed =
                    f32::from(*below) + share.clamp(0.0, 1.0) * (f32::from(above) - f32::from(*below));
                *below = mixed.round() as u8;
            }
        }
    }

    /// Fills an area.
    pub fn fill(&mut self, area: Area, colour: Colour) {
        let [left, top, right, bottom] = self.inside(area);
        for y in top..bottom {
            for x in left..right {
                self.set(x, y, colour);
            }
        }
    }

    /// Draws the outline just outside of an area, one pixel wide.
    pub fn outline(&mut self, [left, top, right, bottom]: Area, colour: Colour) {
        self.fill([left - 1, top - 1, right + 1, top], colour);
        self.fill([left - 1, bottom, right + 1, bottom + 1], colour);
        self.fill([left - 1, top, left, bottom], colour);
        self.fill([right, top, right + 1, bottom], colour);
    }

    fn inside(&self, [left, top, right, bottom]: Area) -> Area {
        let (width, height) = (self.width as i64, self.height as i64);
        [left.clamp(0, width), top.clamp(0, height), right.clamp(0, width), bottom.clamp(0, height)]
    }

    /// Draws a line through points, within an area. Points that are no numbers break it.
    pub fn line(&mut self, points: &[[f64; 2]], width: f64, area: Area, colour: Colour) {
        let area = self.inside(area);
        let [left, top, right, bottom] = area;
        let (columns, rows) = ((right - left).max(0) as usize, (bottom - top).max(0) as usize);
        if columns == 0 || rows == 0 {
            return;
        }
        // The largest share over all pieces: pieces that meet do not darken each other.
        let mut shares = vec![0f32; columns * rows];
        let half = 0.5 * width;
        for pair in points.windows(2) {
            let Some([from, to]) = clip([pair[0], pair[1]], area.map(|side| side as f64), half + 1.0) else {
                continue;
            };
            let span = |i: usize, low: i64, high: i64| {
                let reach = [from[i].min(to[i]) - half - 1.0, from[i].max(to[i]) + half + 1.0];
                (reach[0].floor() as i64).clamp(low, high)..(reach[1].ceil() as i64).clamp(low, high)
            };
            for y in span(1, top, bottom) {
                for x in span(0, left, right) {
                    let away = distance([x as f64 + 0.5, y as f64 + 0.5], from, to);
                    let share = (half + 0.5 - away).clamp(0.0, 1.0) as f32;
                    let at = &mut shares[(y - top) as usize * columns + (x - left) as usize];
                    *at = at.max(share);
                }
            }
        }
        for (i, share) in shares.into_iter().enumerate().filter(|(_, share)| *share > 0.0) {
            self.blend(left + (i % columns) as i64, top + (i / columns) as i64, colour, share);
        }
    }

    /// Draws a disc, within an area.
    pub fn disc(&mut self, centre: [f64; 2], radius: f64, area: Area, colour: Colour) {
        if centre.iter().all(|c| c.abs() < MAX_SIDE as f64) {
            // A line without length: the points whose distance is at most half its width.
            self.line(&[centre, centre], 2.0 * radius, around(centre, radius, area), colour);
        }
    }

    /// Writes a text from left to right.
    pub fn text(&mut self, [x, y]: [i64; 2], text: &str, face: Face, align: Align, colour: Colour) {
        let start = x - before(face.width(text), align);
        let top = y - face.height() / 2;
        self.letters(text, face, |along, down| [start + along, top + down], colour);
    }

    /// Writes a text upward.
    pub fn text_up(&mut self, [x, y]: [i64; 2], text: &str, face: Face, align: Align, colour: Colour) {
        let start = y + before(face.width(text), align);
        let left = x - face.height() / 2;
        self.letters(text, face, |along, down| [left + down, start - along], colour);
    }

    fn letters(&mut self, text: &str, face: Face, place: impl Fn(i64, i64) -> [i64; 2], colour: Colour) {
        let mut start = 0;
        for letter in text.chars().take(MAX_SIDE) {
            let Some(glyph) = glyph(letter, face) else { continue };
            for (down, row) in glyph.rows().enumerate() {
                for (along, share) in row.iter().enumerate().filter(|(_, share)| **share > 0) {
                    let [x, y] = place(start + along as i64, down as i64);
                    self.blend(x, y, colour, f32::from(*share) / 255.0);
                }
            }
            start += glyph.width() as i64;
        }
    }

    /// Writes the picture as PNG, 8 bit RGB.
    ///
    /// # Errors
    /// What `out` refuses.
    pub fn write_png(&self, out: impl Write) -> Result<(), PngError> {
        let mut writer = self.encoder(out).write_header()?;
        writer.write_image_data(&self.rgb)?;
        Ok(writer.finish()?)
    }

    /// Writes an animation as APNG that goes on for ever: so many pictures of one size, each shown for so
    /// many s (1 ms to 18 h). `draw` makes them one after the other, and only one is in memory.
    ///
    /// # Errors
    /// What `draw` reports, a file that cannot be made or written, and pictures of different sizes.
    pub fn save_animation<E: From<OutputError> + From<PictureFileError>>(
        output: Output,
        pictures: u32,
        shown_s: f64,
        mut draw: impl FnMut(u32) -> Result<Self, E>,
    ) -> Result<(), E> {
        let (ms, s) = ((shown_s * 1e3).round(), shown_s.round());
        let delay = if ms <= f64::from(u16::MAX) { (ms.max(1.0) as u16, 1000) } else { (s as u16, 1) };
        let failed = |error: png::EncodingError| PictureFileError::from(PngError(error));
        let first = draw(0)?;
        output.write(|partial| {
            let file = File::create_new(partial).map_err(OutputError::io(partial, "making the file"))?;
            let mut encoder = first.encoder(BufWriter::new(file));
            encoder.set_animated(pictures.max(1), 0).map_err(failed)?;
            encoder.set_frame_delay(delay.0, delay.1).map_err(failed)?;
            let mut writer = encoder.write_header().map_err(failed)?;
            writer.write_image_data(&first.rgb).map_err(failed)?;
            for picture in 1..pictures {
                writer.write_image_data(&draw(picture)?.rgb).map_err(failed)?;
            }
            Ok(writer.finish().map_err(failed)?)
        })
    }

    fn encoder<W: Write>(&self, out: W) -> png::Encoder<'static, W> {
        // Sides are at most MAX_SIDE.
        let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        encoder
    }

    /// Writes the picture as a file.
    ///
    /// # Errors
    /// A file that cannot be made or written.
    pub fn save(&self, output: Output) -> Result<(), PictureFileError> {
        output.write(|partial| {
            let file = File::create_new(partial).map_err(OutputError::io(partial, "making the file"))?;
            let mut file = BufWriter::new(file);
            self.write_png(&mut file)?;
            Ok(file.flush().map_err(OutputError::io(partial, "writing"))?)
        })
    }
}

fn glyph(letter: char, face: Face) -> Option<RasterizedChar> {
    let (weight, height) = face.raster();
    get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height))
}

fn before(width: i64, align: Align) -> i64 {
    match align {
        Align::Start => 0,
        Align::Middle => width / 2,
        Align::End => width,
    }
}

/// The part of an area around a disc.
fn around(centre: [f64; 2], radius: f64, [left, top, right, bottom]: Area) -> Area {
    let reach = radius + 2.0;
    let low = centre.map(|c| (c - reach).floor() as i64);
    let high = centre.map(|c| (c + reach).ceil() as i64);
    [left.max(low[0]), top.max(low[1]), right.min(high[0]), bottom.min(high[1])]
}

/// The part of a line within an area grown by a margin (Liang and Barsky); none outside, or for what is no
/// number.
fn clip(
    [from, to]: [[f64; 2]; 2],
    [left, top, right, bottom]: [f64; 4],
    margin: f64,
) -> Option<[[f64; 2]; 2]> {
    if from.iter().chain(&to).any(|c| c.is_nan() || c.abs() > 1e9) {
        return None;
    }
    let way = [to[0] - from[0], to[1] - from[1]];
    let (mut enter, mut leave) = (0f64, 1f64);
    for (axis, low, high) in [(0, left - margin, right + margin), (1, top - margin, bottom + margin)] {
        if way[axis] == 0.0 {
            if from[axis] < low || from[axis] > high {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / way[axis], (high - from[axis]) / way[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    let at = |share: f64| [from[0] + share * way[0], from[1] + share * way[1]];
    (enter <= leave).then(|| [at(enter), at(leave)])
}

/// Distance of a point from a piece of a line.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let off = [point[0] - from[0], point[1] - from[1]];
    let length2 = way[0] * way[0] + way[1] * way[1];
    let share =
        if length2 > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (off[0] - share * way[0]).hypot(off[1] - share * way[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_lie_side_by_side() {
        let (red, blue) = ([255, 0, 0], [0, 0, 255]);
        let canvases = [Canvas::new(3, 2, red), Canvas::new(2, 4, blue), Canvas::new(3, 4, red)];
        let whole = Canvas::tiled(&canvases, 2, [9, 9, 9]);
        assert_eq!((whole.width(), whole.height()), (6, 8));
        let at = |x, y| whole.pixel(x, y).unwrap();
        assert_eq!((at(2, 1), at(2, 2), at(3, 3), at(5, 0)), (red, [9; 3], blue, [9; 3]));
        assert_eq!((at(0, 4), at(2, 7), at(3, 4)), (red, red, [9; 3]));
        assert_eq!(Canvas::tiled(&[], 2, red), Canvas::new(1, 1, red));
        // More than a canvas may have: what does not fit is left out.
        let wide = Canvas::tiled(&vec![Canvas::new(MAX_SIDE / 2 + 1, 1, red); 3], 3, blue);
        assert_eq!((wide.width(), wide.pixel(0, 0)), (MAX_SIDE, Some(red)));
    }
    use crate::plot::colours::{INK, WHITE};

    const BLACK: Colour = [0; 3];

    /// Ink on a canvas, in pixels.
    fn ink(canvas: &Canvas) -> f64 {
        canvas.rgb.iter().map(|c| 1.0 - f64::from(*c) / 255.0).sum::<f64>() / 3.0
    }

    #[test]
    fn a_line_has_its_length_times_its_width_of_ink() {
        for (from, to) in
            [([10.0, 50.0], [90.0, 50.0]), ([12.0, 8.0], [80.0, 77.3]), ([50.0, 5.0], [61.0, 90.0])]
        {
            let mut canvas = Canvas::new(100, 100, WHITE);
            canvas.line(&[from, to], 3.0, [0, 0, 100, 100], BLACK);
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            // The round ends add a disc of the width; a share by distance is within 0.1 of the area on the
            // rims, where its sign alternates along a slanting line.
            let area = 3.0 * length + std::f64::consts::PI * 1.5 * 1.5;
            assert!((ink(&canvas) / area - 1.0).abs() < 0.03, "{} for {area}", ink(&canvas));
        }
    }

    #[test]
    fn nothing_is_drawn_outside() {
        let mut canvas = Canvas::new(40, 40, WHITE);
        canvas.line(&[[-1e8, -1e8], [1e8, 1e8]], 1.0, [10, 10, 20, 20], BLACK);
        canvas.line(&[[f64::NAN, 0.0], [1.0, 1.0], [f64::INFINITY, 2.0]], 1.0, [0, 0, 40, 40], BLACK);
        canvas.fill([-5, -5, 0, 90], BLACK);
        canvas.disc([f64::NAN, 3.0], 5.0, [0, 0, 40, 40], BLACK);
        for y in 0..40 {
            for x in 0..40 {
                let inside = (10..20).contains(&x) && (10..20).contains(&y);
                let dark = canvas.pixel(x, y) != Some(WHITE);
                assert!(!dark || inside && (x - y).abs() <= 1, "{x} {y}");
                assert!(dark || !inside || x != y, "{x} {y}");
            }
        }
    }

    #[test]
    fn upward_text_is_text_turned() {
        let text = "Up, m 30\u{b0} \u{3c3}";
        let mut across = Canvas::new(120, 120, WHITE);
        across.text([60, 60], text, Face::Small, Align::Middle, INK);
        let mut up = Canvas::new(120, 120, WHITE);
        up.text_up([60, 60], text, Face::Small, Align::Middle, INK);
        assert!(ink(&across) > 50.0);
        for y in 0..120 {
            for x in 0..120 {
                assert_eq!(across.pixel(x, y), up.pixel(y, 120 - x).or(Some(WHITE)), "{x} {y}");
            }
        }
    }

    #[test]
    fn a_png_reads_back() {
        let mut canvas = Canvas::new(33, 7, [1, 2, 3]);
        canvas.disc([10.0, 3.0], 2.5, [0, 0, 33, 7], [200, 100, 0]);
        let mut file = Vec::new();
        canvas.write_png(&mut file).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height, &pixels), (33, 7, &canvas.rgb));
    }

    #[test]
    fn an_animation_reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let picture = |n: u32| Canvas::new(5, 3, [n as u8, 0, 7]);
        let plan =
            || crate::recording::output::Output::plan(&path, crate::recording::output::FileKind::Png, true);
        Canvas::save_animation(plan().unwrap(), 3, 2.5, |n| Ok::<_, PictureFileError>(picture(n))).unwrap();
        let file = std::io::Cursor::new(std::fs::read(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control().map(|all| all.num_frames), Some(3));
        for n in 0..3 {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let shown = reader.info().frame_control().unwrap();
            assert_eq!((shown.delay_num, shown.delay_den, &pixels), (2500, 1000, &picture(n).rgb));
        }
        let grows = |n: u32| Ok::<_, PictureFileError>(Canvas::new(5 + n as usize, 3, WHITE));
        assert!(Canvas::save_animation(plan().unwrap(), 2, 1.0, grows).is_err());
    }
}
