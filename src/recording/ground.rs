//! The points of an image: a grid on a plane, or along any two directions.
//!
//! Pixel `(i, j)` is the point `first + i step_x + j step_y`. A map has equal steps to the East and to the
//! North at one height.
//!
//! ```
//! use nereus::recording::ground::Ground;
//! let ground = Ground::map([100.0, -50.0, 0.0], [64.0, 32.0], 0.5)?;
//! assert_eq!(ground.pixels, [128, 64]);
//! assert_eq!(ground.point_m(0.0, 0.0), [68.25, -65.75, 0.0]);
//! assert_eq!(ground.edges_m(0), [68.0, 132.0]);
//! # Ok::<(), nereus::recording::ground::GroundError>(())
//! ```

/// Most pixels along a side.
pub const MOST_PIXELS: usize = 32768;
/// Most pixels in all.
pub const MOST_IN_ALL: usize = 1 << 26;

/// A grid that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "an image of {size_m:?} m about {centre_m:?} m with pixels of {pixel_m} m: finite numbers and 1 to 32768 pixels along each side, 6.7e7 in all, are needed"
)]
pub struct GroundError {
    centre_m: [f64; 3],
    size_m: [f64; 2],
    pixel_m: f64,
}

/// The points of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Middle of pixel (0, 0), ENU, m.
    pub first_m: [f64; 3],
    /// From pixel (i, j) to (i + 1, j), m.
    pub step_x_m: [f64; 3],
    /// From pixel (i, j) to (i, j + 1), m.
    pub step_y_m: [f64; 3],
    /// Pixels along x and y.
    pub pixels: [usize; 2],
}

impl Ground {
    /// A map about a centre (ENU, m): x to the East, y to the North. Sides are rounded to whole pixels.
    ///
    /// # Errors
    /// Sizes that are not finite, or too many pixels.
    pub fn map(centre_m: [f64; 3], size_m: [f64; 2], pixel_m: f64) -> Result<Self, GroundError> {
        let fault = GroundError { centre_m, size_m, pixel_m };
        let counts = size_m.map(|side| (side / pixel_m).round());
        let legal = pixel_m > 0.0
            && pixel_m.is_finite()
            && centre_m.iter().all(|x| x.is_finite())
            && counts.iter().all(|n| (1.0..=MOST_PIXELS as f64).contains(n))
            && counts[0] * counts[1] <= MOST_IN_ALL as f64;
        if !legal {
            return Err(fault);
        }
        let [columns, rows] = counts;
        Ok(Self {
            first_m: [
                centre_m[0] - 0.5 * (columns - 1.0) * pixel_m,
                centre_m[1] - 0.5 * (rows - 1.0) * pixel_m,
                centre_m[2],
            ],
            step_x_m: [pixel_m, 0.0, 0.0],
            step_y_m: [0.0, pixel_m, 0.0],
            pixels: counts.map(|n| n as usize),
        })
    }

    /// `count` points on a line about a centre.
    pub fn line(centre_m: [f64; 3], step_m: [f64; 3], count: usize) -> Self {
        let back = 0.5 * (count as f64 - 1.0);
        Self {
            first_m: std::array::from_fn(|i| centre_m[i] - back * step_m[i]),
            step_x_m: step_m,
            step_y_m: [0.0; 3],
            pixels: [count, 1],
        }
    }

    /// The point of a pixel, or between pixels, m.
    pub fn point_m(&self, i: f64, j: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.first_m[k] + i * self.step_x_m[k] + j * self.step_y_m[k])
    }

    /// The middle of the image, m.
    pub fn centre_m(&self) -> [f64; 3] {
        let [columns, rows] = self.pixels.map(|n| 0.5 * (n as f64 - 1.0));
        self.point_m(columns, rows)
    }

    /// Outer edges of a map along axis 0 (East) or 1 (North), m.
    pub fn edges_m(&self, axis: usize) -> [f64; 2] {
        let step = [self.step_x_m, self.step_y_m][axis][axis];
        let low = self.first_m[axis] - 0.5 * step;
        [low, low + self.pixels[axis] as f64 * step]
    }

    /// Pixels in all.
    pub fn len(&self) -> usize {
        self.pixels[0] * self.pixels[1]
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
