//! The periodic grid of facets and of wave numbers.
//!
//! Row `i` of the wave-number plane holds `Kx = m dKx` with m = i up to the middle, then i - nx; the Nyquist
//! row of an even count belongs to no wave. Facets are stored row by row, `[iy][ix]`.
//!
//! ```
//! use nereus::sea::surface::Grid;
//! let grid = Grid::new(4, 3, 2.0)?;
//! let rows: Vec<_> = (0..4).map(|i| grid.wave_index_x(i)).collect();
//! assert_eq!(rows, [Some(0), Some(1), None, Some(-1)]);
//! assert_eq!(grid.index([-1, 4]), grid.index([3, 1]));
//! # Ok::<(), nereus::sea::surface::SurfaceError>(())
//! ```

use super::SurfaceError;

/// Most facets along one side.
pub const MAX_SIDE: usize = 1 << 16;
/// Most facets in all.
pub const MAX_FACETS: usize = 1 << 26;
/// Sides a facet may have, m.
pub const FACET_RANGE_M: [f64; 2] = [1e-4, 1e5];

/// A periodic grid of square facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    nx: usize,
    ny: usize,
    facet_m: f64,
}

impl Grid {
    /// `nx` by `ny` facets of side `facet_m`, m.
    ///
    /// # Errors
    /// Sizes or a facet out of range.
    pub fn new(nx: usize, ny: usize, facet_m: f64) -> Result<Self, SurfaceError> {
        let side = 1..=MAX_SIDE;
        if !side.contains(&nx) || !side.contains(&ny) || nx * ny > MAX_FACETS {
            return Err(SurfaceError::Facets { nx, ny });
        }
        if !(FACET_RANGE_M[0]..=FACET_RANGE_M[1]).contains(&facet_m) {
            return Err(SurfaceError::FacetSize { facet_m });
        }
        Ok(Self { nx, ny, facet_m })
    }

    /// Facets along x.
    pub fn nx(&self) -> usize {
        self.nx
    }

    /// Facets along y.
    pub fn ny(&self) -> usize {
        self.ny
    }

    /// Side of a facet, m.
    pub fn facet_m(&self) -> f64 {
        self.facet_m
    }

    /// Facets in all.
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// Whether there are none (never).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Length along x and y, m, after which the sea repeats.
    pub fn period_m(&self) -> [f64; 2] {
        [self.nx as f64 * self.facet_m, self.ny as f64 * self.facet_m]
    }

    /// Place in a field of the facet with a global key.
    pub fn index(&self, key: [i64; 2]) -> usize {
        let ix = key[0].rem_euclid(self.nx as i64) as usize;
        let iy = key[1].rem_euclid(self.ny as i64) as usize;
        iy * self.nx + ix
    }

    /// `dKx` and `dKy`, rad/m.
    pub fn wave_number_step_rad_m(&self) -> [f64; 2] {
        self.period_m().map(|length_m| std::f64::consts::TAU / length_m)
    }

    /// `Kx/dKx` of row `i`; `None` for the Nyquist row.
    pub fn wave_index_x(&self, i: usize) -> Option<i64> {
        wave_index(i, self.nx)
    }

    /// `Ky/dKy` of column `j`; `None` for the Nyquist column.
    pub fn wave_index_y(&self, j: usize) -> Option<i64> {
        wave_index(j, self.ny)
    }
}

fn wave_index(i: usize, n: usize) -> Option<i64> {
    match (2 * i).cmp(&n) {
        std::cmp::Ordering::Less => Some(i as i64),
        std::cmp::Ordering::Equal => None,
        std::cmp::Ordering::Greater => Some(i as i64 - n as i64),
    }
}
