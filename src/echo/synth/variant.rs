//! One body, several instruction sets: which one is decided once, when a [`Synth`](super::Synth) is built.

use super::SynthError;
use super::scalar::Scalar;
use super::spread::{Job, spread};
use crate::cpu::{Avx2Fma, Avx512, Instructions, Portable, Variant};

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

// What a loop is compiled for is known here, so that none is compiled for instructions that it never has.

fn portable<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    spread::<T, Portable, false, W, C>(Portable, job, grids);
}

fn fused<T: Scalar, I: Instructions, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    match I::find() {
        Some(found) => spread::<T, I, true, W, C>(found, job, grids),
        None => portable::<T, W, C>(job, grids),
    }
}

macro_rules! by_size {
    ($body:ident::<$($T:ty),+>, $width:expr, $lanes:expr) => {
        match ($width, $lanes) {
            (2, 2) => $body::<$($T),+, 2, 2>,
            (2, 4) => $body::<$($T),+, 2, 4>,
            (2, _) => $body::<$($T),+, 2, 8>,
            (3, 2) => $body::<$($T),+, 3, 2>,
            (3, 4) => $body::<$($T),+, 3, 4>,
            (3, _) => $body::<$($T),+, 3, 8>,
            (4, 2) => $body::<$($T),+, 4, 2>,
            (4, 4) => $body::<$($T),+, 4, 4>,
            (4, _) => $body::<$($T),+, 4, 8>,
            (5, 2) => $body::<$($T),+, 5, 2>,
            (5, 4) => $body::<$($T),+, 5, 4>,
            (5, _) => $body::<$($T),+, 5, 8>,
            (6, 2) => $body::<$($T),+, 6, 2>,
            (6, 4) => $body::<$($T),+, 6, 4>,
            (6, _) => $body::<$($T),+, 6, 8>,
            (7, 2) => $body::<$($T),+, 7, 2>,
            (7, 4) => $body::<$($T),+, 7, 4>,
            (7, _) => $body::<$($T),+, 7, 8>,
            (_, 2) => $body::<$($T),+, 8, 2>,
            (_, 4) => $body::<$($T),+, 8, 4>,
            (_, _) => $body::<$($T),+, 8, 8>,
        }
    };
}

/// The body of a variant that is available, in f32. Not generic, as below: compiled once, not for every
/// program that makes a `Synth`.
pub(super) fn body_f32(variant: Variant, width: usize, lanes: usize) -> Body<f32> {
    match variant {
        Variant::Portable => by_size!(portable::<f32>, width, lanes),
        Variant::Avx2Fma => by_size!(fused::<f32, Avx2Fma>, width, lanes),
        Variant::Avx512 => by_size!(fused::<f32, Avx512>, width, lanes),
    }
}

/// The same in f64, where everything but the portable one is the AVX2 one.
pub(super) fn body_f64(variant: Variant, width: usize, lanes: usize) -> Body<f64> {
    match variant {
        Variant::Portable => by_size!(portable::<f64>, width, lanes),
        Variant::Avx2Fma | Variant::Avx512 => by_size!(fused::<f64, Avx2Fma>, width, lanes),
    }
}
