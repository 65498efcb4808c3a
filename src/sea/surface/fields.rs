//! What a surface is at an instant, facet by facet.
//!
//! Structure of arrays, `[iy][ix]` (see [`Grid::index`]), in f32 or f64. Fields that a scene does not need
//! stay empty and cost nothing.
//!
//! ```
//! use nereus::sea::surface::{Fields, Grid, Selection};
//! let grid = Grid::new(8, 8, 1.0)?;
//! let fields = Fields::<f32>::new(&grid, Selection { slopes: true, ..Selection::HEIGHT });
//! assert_eq!((fields.height_m.len(), fields.slope[1].len(), fields.velocity_mps[0].len()), (64, 64, 0));
//! # Ok::<(), nereus::sea::surface::SurfaceError>(())
//! ```

use std::fmt::Debug;

use num_complex::Complex;

use super::Grid;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Number format of fields: f32 or f64.
pub trait Real: nereus_fft::Precision + Default + Debug + sealed::Sealed {
    /// Rounded from f64.
    fn round_from(value: f64) -> Self;
    /// Exact in f64.
    fn widen(self) -> f64;
    /// Cosine and sine of a phase in turns.
    fn cos_sin_of_turns(turns: f64) -> (Self, Self);
}

impl Real for f32 {
    #[inline(always)]
    fn round_from(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn cos_sin_of_turns(turns: f64) -> (Self, Self) {
        crate::units::cos_sin_of_turns(turns)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn round_from(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn widen(self) -> f64 {
        self
    }
    #[inline(always)]
    fn cos_sin_of_turns(turns: f64) -> (Self, Self) {
        let (sin, cos) = (std::f64::consts::TAU * (turns - turns.round())).sin_cos();
        (cos, sin)
    }
}

/// A complex number rounded from f64.
pub(super) fn round_complex<T: Real>(value: Complex<f64>) -> Complex<T> {
    Complex::new(T::round_from(value.re), T::round_from(value.im))
}

/// Which fields are wanted in addition to the height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Slopes along x and y.
    pub slopes: bool,
    /// Orbital velocity.
    pub velocity: bool,
    /// Vertical acceleration; costs nothing once the height is made.
    pub vertical_acceleration: bool,
    /// Horizontal orbital acceleration.
    pub horizontal_acceleration: bool,
    /// Horizontal displacement.
    pub displacement: bool,
    /// Time derivative of the slopes.
    pub slope_rate: bool,
    /// Modulation of short waves ([`modulation`](super::modulation)).
    pub modulation: bool,
    /// Gradient of the horizontal displacement, and the area that choppy waves leave of facets.
    pub stretch: bool,
}

impl Selection {
    /// The height, and the vertical acceleration that comes with it.
    pub const HEIGHT: Self = Self {
        slopes: false,
        velocity: false,
        vertical_acceleration: true,
        horizontal_acceleration: false,
        displacement: false,
        slope_rate: false,
        modulation: false,
        stretch: false,
    };
    /// Everything that moves.
    pub const ALL: Self = Self {
        slopes: true,
        velocity: true,
        vertical_acceleration: true,
        horizontal_acceleration: true,
        displacement: true,
        slope_rate: true,
        modulation: false,
        stretch: false,
    };
}

impl Selection {
    /// The same with what choppy waves are made of ([`choppy`](super::choppy)).
    pub fn choppy(self) -> Self {
        Self { slopes: true, velocity: true, displacement: true, stretch: true, ..self }
    }
}

/// Fields of a surface at an instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields<T> {
    /// Height above the mean surface, m.
    pub height_m: Vec<T>,
    /// Slopes dz/dx, dz/dy.
    pub slope: [Vec<T>; 2],
    /// Orbital velocity along x, y, up, m/s.
    pub velocity_mps: [Vec<T>; 3],
    /// Its time derivative, m/s^2.
    pub acceleration_mps2: [Vec<T>; 3],
    /// Horizontal displacement D along x and y, m.
    pub displacement_m: [Vec<T>; 2],
    /// Time derivative of the slopes, 1/s.
    pub slope_rate_per_s: [Vec<T>; 2],
    /// Modulation of short waves, the tensor's entries xx, yy, xy ([`modulation`](super::modulation)).
    pub modulation: [Vec<T>; 3],
    /// Gradient of the horizontal displacement of linear waves, xx, yy, xy.
    pub stretch: [Vec<T>; 3],
    /// Horizontal area of a facet over that of the grid; zero where nobody has found it
    /// ([`choppy`](super::choppy)).
    pub area: Vec<T>,
}

/// Every field of [`Fields`], borrowed as they are.
macro_rules! all_columns {
    ($fields:expr, $slice:path) => {{
        let Fields {
            height_m: z,
            slope: [zx, zy],
            velocity_mps: [u, v, w],
            acceleration_mps2: [ax, ay, az],
            displacement_m: [dx, dy],
            slope_rate_per_s: [rx, ry],
            modulation: [mxx, myy, mxy],
            stretch: [sxx, syy, sxy],
            area,
        } = $fields;
        [z, zx, zy, u, v, w, ax, ay, az, dx, dy, rx, ry, mxx, myy, mxy, sxx, syy, sxy, area].map($slice)
    }};
}

impl<T: Real> Fields<T> {
    /// Room for the selected fields of a grid, all zero: still water.
    pub fn new(grid: &Grid, selection: Selection) -> Self {
        Self::sized(grid.len(), selection)
    }

    /// Room for the selected fields of so many facets.
    pub fn sized(facets: usize, selection: Selection) -> Self {
        let make = |wanted: bool| vec![T::default(); if wanted { facets } else { 0 }];
        let pair = |wanted: bool| [make(wanted), make(wanted)];
        let Selection {
            slopes,
            velocity,
            vertical_acceleration,
            horizontal_acceleration,
            displacement,
            slope_rate,
            modulation,
            stretch,
        } = selection;
        Self {
            height_m: make(true),
            slope: pair(slopes),
            velocity_mps: [make(velocity), make(velocity), make(velocity)],
            acceleration_mps2: [
                make(horizontal_acceleration),
                make(horizontal_acceleration),
                make(vertical_acceleration),
            ],
            displacement_m: pair(displacement),
            slope_rate_per_s: pair(slope_rate),
            modulation: [make(modulation), make(modulation), make(modulation)],
            stretch: [make(stretch), make(stretch), make(stretch)],
            area: make(stretch),
        }
    }

    /// Still water.
    pub(crate) fn clear(&mut self) {
        self.columns_mut().into_iter().for_each(|column| column.fill(T::default()));
    }

    /// All fields, one after the other.
    pub(in crate::sea) fn columns(&self) -> [&[T]; 20] {
        all_columns!(self, Vec::as_slice)
    }

    /// The same, to be written.
    pub(in crate::sea) fn columns_mut(&mut self) -> [&mut [T]; 20] {
        all_columns!(self, Vec::as_mut_slice)
    }
}

impl Fields<f32> {
    /// Takes over fields of double precision, those that there are, each rounded once.
    pub(crate) fn round_from(&mut self, fine: &Fields<f64>) {
        for (own, fine) in self.columns_mut().into_iter().zip(fine.columns()) {
            own.iter_mut().zip(fine).for_each(|(own, fine)| *own = *fine as f32);
        }
    }

    /// Adds fields of double precision, rounding each sum once.
    pub(crate) fn add_rounded(&mut self, fine: &Fields<f64>) {
        for (own, fine) in self.columns_mut().into_iter().zip(fine.columns()) {
            own.iter_mut().zip(fine).for_each(|(own, fine)| *own = (f64::from(*own) + fine) as f32);
        }
    }
}

/// All fields at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Height above the mean surface, m.
    pub height_m: f64,
    /// Slopes dz/dx, dz/dy.
    pub slope: [f64; 2],
    /// Orbital velocity along x, y, up, m/s.
    pub velocity_mps: [f64; 3],
    /// Its time derivative, m/s^2.
    pub acceleration_mps2: [f64; 3],
    /// Horizontal displacement D along x and y, m.
    pub displacement_m: [f64; 2],
    /// Time derivative of the slopes, 1/s.
    pub slope_rate_per_s: [f64; 2],
}
