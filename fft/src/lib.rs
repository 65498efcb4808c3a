//! Discrete Fourier transforms by `rustfft`, compiled for `f32` and `f64` here and nowhere else.
//!
//! Neither direction is scaled: `forward` is `X[m] = sum_n x[n] exp(-j 2 pi m n / N)`, `inverse` has `+j`,
//! and one after the other gives `N x`.
//!
//! ```
//! use nereus_fft::num_complex::Complex;
//!
//! let mut x = [Complex::new(1.0f64, 0.0), Complex::new(0.0, 0.0)];
//! nereus_fft::forward(2).process(&mut x);
//! assert_eq!(x, [Complex::new(1.0, 0.0); 2]);
//! ```

use std::sync::Arc;

pub use rustfft::num_complex;
pub use rustfft::{Fft, FftNum};

/// A precision whose transforms are compiled here: `f32` or `f64`.
pub trait Precision: FftNum {
    /// A transform of `len` values with `exp(-j w t)`.
    fn plan_forward(len: usize) -> Arc<dyn Fft<Self>>;
    /// A transform of `len` values with `exp(+j w t)`.
    fn plan_inverse(len: usize) -> Arc<dyn Fft<Self>>;
}

macro_rules! compiled {
    ($($float:ty),*) => {$(
        impl Precision for $float {
            #[inline(never)]
            fn plan_forward(len: usize) -> Arc<dyn Fft<Self>> {
                rustfft::FftPlanner::new().plan_fft_forward(len)
            }

            #[inline(never)]
            fn plan_inverse(len: usize) -> Arc<dyn Fft<Self>> {
                rustfft::FftPlanner::new().plan_fft_inverse(len)
            }
        }
    )*};
}
compiled!(f32, f64);

/// A transform of `len` values with `exp(-j w t)`.
pub fn forward<T: Precision>(len: usize) -> Arc<dyn Fft<T>> {
    T::plan_forward(len)
}

/// A transform of `len` values with `exp(+j w t)`.
pub fn inverse<T: Precision>(len: usize) -> Arc<dyn Fft<T>> {
    T::plan_inverse(len)
}
