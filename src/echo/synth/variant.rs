//! One body, several instruction sets: which one is decided once, when a [`Synth`](super::Synth) is built.

use super::scalar::Scalar;
use super::spread::{Job, spread};
use super::{Precision, SynthError};
use crate::cpu::Variant;

/// The variant that was asked for, or the fastest that is available.
pub(super) fn choose(asked: Option<Variant>) -> Result<Variant, SynthError> {
    match asked {
        Some(variant) if variant.is_available() => Ok(variant),
        Some(variant) => Err(SynthError::Variant { variant }),
        None => Ok(Variant::fastest()),
    }
}

/// An inner loop for one width and number of lanes.
pub(super) type Body<T> = fn(&Job<'_, T>, &mut [T]);

fn portable<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    spread::<T, false, W, C>(Variant::Portable, job, grids);
}

fn avx2<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    spread::<T, true, W, C>(Variant::Avx2Fma, job, grids);
}

fn avx512<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    spread::<T, true, W, C>(Variant::Avx512, job, grids);
}

/// The body of a variant that is available. In f64 everything but the portable one is the AVX2 one.
pub(super) fn body<T: Scalar>(variant: Variant, width: usize, lanes: usize) -> Body<T> {
    macro_rules! by_size {
        ($body:ident) => {
            match (width, lanes) {
                (4, 2) => $body::<T, 4, 2>,
                (4, 4) => $body::<T, 4, 4>,
                (4, _) => $body::<T, 4, 8>,
                (5, 2) => $body::<T, 5, 2>,
                (5, 4) => $body::<T, 5, 4>,
                (5, _) => $body::<T, 5, 8>,
                (6, 2) => $body::<T, 6, 2>,
                (6, 4) => $body::<T, 6, 4>,
                (6, _) => $body::<T, 6, 8>,
                (7, 2) => $body::<T, 7, 2>,
                (7, 4) => $body::<T, 7, 4>,
                (7, _) => $body::<T, 7, 8>,
                (_, 2) => $body::<T, 8, 2>,
                (_, 4) => $body::<T, 8, 4>,
                (_, _) => $body::<T, 8, 8>,
            }
        };
    }
    match (variant, T::PRECISION) {
        (Variant::Portable, _) => by_size!(portable),
        (Variant::Avx512, Precision::Single) => by_size!(avx512),
        (Variant::Avx2Fma | Variant::Avx512, _) => by_size!(avx2),
    }
}
