//! The patch of sea that is modelled, in facets with global keys.
//!
//! Facet `(ix, iy)` is the square of side `facet_m` centred on `(ix facet_m, iy facet_m)` of the scene
//! frame, for any integers: the same key is the same water, whatever patch it is seen through.
//!
//! ```
//! use nereus::scene::Patch;
//! let patch = Patch::new([512.0, 256.0], 1.0, [0.0, 0.0])?;
//! assert_eq!((patch.facets, patch.first), ([512, 256], [-256, -128]));
//! assert!(Patch::new([10.0, 10.0], 3.0, [0.0, 0.0]).is_err());
//! # Ok::<(), nereus::scene::patch::PatchError>(())
//! ```

/// Most facets of a patch along one side.
pub const MAX_SIDE: usize = 1 << 20;

/// A rectangle of facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Facets along x and y.
    pub facets: [usize; 2],
    /// Side of a facet, m.
    pub facet_m: f64,
    /// Global key of the facet with the smallest x and y.
    pub first: [i64; 2],
}

/// What is wrong with a patch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// Not a length.
    #[error("facet of {facet_m} m: it must be a finite length above 0")]
    Facet {
        /// The facet given, m.
        facet_m: f64,
    },
    /// Not a length.
    #[error("patch of {size_m} m along {axis}: it must be a finite length above 0")]
    Size {
        /// `x` or `y`.
        axis: char,
        /// The length given, m.
        size_m: f64,
    },
    /// A facet does not fit.
    #[error("facet of {facet_m} m is larger than the patch of {size_m} m along {axis}")]
    FacetLargerThanPatch {
        /// `x` or `y`.
        axis: char,
        /// The facet given, m.
        facet_m: f64,
        /// The length given, m.
        size_m: f64,
    },
    /// A piece of a facet is left over.
    #[error("patch of {size_m} m along {axis} is not a multiple of the facet of {facet_m} m")]
    NotAMultiple {
        /// `x` or `y`.
        axis: char,
        /// The facet given, m.
        facet_m: f64,
        /// The length given, m.
        size_m: f64,
    },
    /// More facets than the keys of one patch may hold.
    #[error("patch of {facets} facets along {axis}: at most {MAX_SIDE} are allowed")]
    TooMany {
        /// `x` or `y`.
        axis: char,
        /// Facets asked (rounded).
        facets: f64,
    },
    /// The centre is not a point.
    #[error("patch centre {centre_m} m along {axis}: it must be finite and within 2^40 facets of the origin")]
    Centre {
        /// `x` or `y`.
        axis: char,
        /// The coordinate given, m.
        centre_m: f64,
    },
}

impl Patch {
    /// The patch of the given size whose middle facet is the one nearest to the centre.
    ///
    /// # Errors
    /// Sizes or facets that are not positive and finite; sides that are no multiple of the facet, shorter
    /// than one, or of too many; a centre too far away.
    pub fn new(size_m: [f64; 2], facet_m: f64, centre_m: [f64; 2]) -> Result<Self, PatchError> {
        if !(facet_m.is_finite() && facet_m > 0.0) {
            return Err(PatchError::Facet { facet_m });
        }
        let mut facets = [0; 2];
        let mut first = [0; 2];
        for (i, axis) in ['x', 'y'].into_iter().enumerate() {
            let size_m = size_m[i];
            if !(size_m.is_finite() && size_m > 0.0) {
                return Err(PatchError::Size { axis, size_m });
            }
            let count = size_m / facet_m;
            // 1e-6 of a facet: decimal lengths (0.3 / 0.1) are not exact multiples in binary.
            if count < 1.0 - 1e-6 {
                return Err(PatchError::FacetLargerThanPatch { axis, facet_m, size_m });
            }
            if count.round() > MAX_SIDE as f64 {
                return Err(PatchError::TooMany { axis, facets: count.round() });
            }
            if (count - count.round()).abs() > 1e-6 {
                return Err(PatchError::NotAMultiple { axis, facet_m, size_m });
            }
            let middle = (centre_m[i] / facet_m).round();
            if !middle.is_finite() || middle.abs() > (1u64 << 40) as f64 {
                return Err(PatchError::Centre { axis, centre_m: centre_m[i] });
            }
            facets[i] = count.round() as usize;
            first[i] = middle as i64 - (facets[i] / 2) as i64;
        }
        Ok(Self { facets, facet_m, first })
    }

    /// The patch of the same size and facets whose middle facet is the one nearest to another centre.
    pub fn centred_at(&self, centre_m: [f64; 2]) -> Self {
        let first = [0, 1].map(|i| {
            // Casts saturate: a centre that is not finite moves the patch, and nothing overflows.
            let middle = (centre_m[i] / self.facet_m).round().clamp(-(2f64.powi(40)), 2f64.powi(40)) as i64;
            middle - (self.facets[i] / 2) as i64
        });
        Self { first, ..*self }
    }

    /// The patch with `rows` more facets on each side.
    pub fn grown(&self, rows: usize) -> Self {
        Self {
            facets: self.facets.map(|n| n + 2 * rows),
            first: self.first.map(|i| i - rows as i64),
            ..*self
        }
    }

    /// Place of the facet with a global key in arrays `[iy][ix]` over the patch; of a facet outside, the
    /// place of the nearest one inside.
    pub fn nearest_index(&self, key: [i64; 2]) -> usize {
        let [ix, iy] = [0, 1].map(|i| (key[i] - self.first[i]).clamp(0, self.facets[i] as i64 - 1) as usize);
        iy * self.facets[0] + ix
    }

    /// Global key of the facet at a place in arrays `[iy][ix]` over the patch.
    pub fn key(&self, index: usize) -> [i64; 2] {
        let [nx, _] = self.facets;
        [self.first[0] + (index % nx) as i64, self.first[1] + (index / nx) as i64]
    }

    /// Facets in all.
    pub fn len(&self) -> usize {
        self.facets[0] * self.facets[1]
    }

    /// Whether there are none (never, for a patch from [`Patch::new`]).
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Length along x and y, m.
    pub fn size_m(&self) -> [f64; 2] {
        self.facets.map(|n| n as f64 * self.facet_m)
    }

    /// Centre of the facet with a global key, m.
    pub fn centre_m(&self, key: [i64; 2]) -> [f64; 2] {
        [key[0] as f64 * self.facet_m, key[1] as f64 * self.facet_m]
    }
}
