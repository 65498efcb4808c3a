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

macro_rules! by_lanes {
    ($body:ident::<$($T:ty),+>, $width:literal, $lanes:expr) => {
        match $lanes {
            2 => $body::<$($T),+, $width, 2>,
            4 => $body::<$($T),+, $width, 4>,
            _ => $body::<$($T),+, $width, 8>,
        }
    };
}

macro_rules! by_size {
    ($body:ident::<$($T:ty),+>, $width:expr, $lanes:expr) => {
        match $width {
            2 => by_lanes!($body::<$($T),+>, 2, $lanes),
            3 => by_lanes!($body::<$($T),+>, 3, $lanes),
            4 => by_lanes!($body::<$($T),+>, 4, $lanes),
            5 => by_lanes!($body::<$($T),+>, 5, $lanes),
            6 => by_lanes!($body::<$($T),+>, 6, $lanes),
            7 => by_lanes!($body::<$($T),+>, 7, $lanes),
            _ => by_lanes!($body::<$($T),+>, 8, $lanes),
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
