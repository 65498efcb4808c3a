//! One body, several instruction sets: which one is decided once, when a [`Synth`](super::Synth) is built.
#![allow(unsafe_code)]

use std::fmt;

use super::scalar::Scalar;
use super::spread::{Job, spread};
use super::{Precision, SynthError};

/// Instructions for the inner loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// What every CPU of the target has; no fused products.
    Portable,
    /// AVX2 and FMA.
    Avx2Fma,
    /// AVX-512 F, BW, DQ and VL.
    Avx512,
}

impl Variant {
    /// All there are, slowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2Fma, Self::Avx512];

    /// Whether this CPU has it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2Fma => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2Fma.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The one that was asked for, or the fastest that is available.
    pub(super) fn choose(asked: Option<Self>) -> Result<Self, SynthError> {
        match asked {
            Some(variant) if variant.is_available() => Ok(variant),
            Some(variant) => Err(SynthError::Variant { variant }),
            None => Ok(Self::ALL.into_iter().rev().find(|v| v.is_available()).unwrap_or(Self::Portable)),
        }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2Fma => "avx2+fma",
            Self::Avx512 => "avx-512",
        })
    }
}

/// An inner loop for one width and number of lanes.
pub(super) type Body<T> = fn(&Job<'_, T>, &mut [T]);

fn portable<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
    spread::<T, false, W, C>(job, grids);
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Job, Scalar, spread};

    #[target_feature(enable = "avx2,fma")]
    fn avx2_inner<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
        spread::<T, true, W, C>(job, grids);
    }

    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]
    fn avx512_inner<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
        spread::<T, true, W, C>(job, grids);
    }

    pub(super) fn avx2<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
        // SAFETY: handed out by `body` only, for a variant that `Variant::choose` found on this CPU.
        unsafe { avx2_inner::<T, W, C>(job, grids) }
    }

    pub(super) fn avx512<T: Scalar, const W: usize, const C: usize>(job: &Job<'_, T>, grids: &mut [T]) {
        // SAFETY: as above.
        unsafe { avx512_inner::<T, W, C>(job, grids) }
    }
}

/// The body of a variant that is available. In f64 everything but the portable one is the AVX2 one.
pub(super) fn body<T: Scalar>(variant: Variant, width: usize, lanes: usize) -> Body<T> {
    macro_rules! by_size {
        ($($body:ident)::+) => {
            match (width, lanes) {
                (4, 2) => $($body)::+::<T, 4, 2>,
                (4, 4) => $($body)::+::<T, 4, 4>,
                (4, _) => $($body)::+::<T, 4, 8>,
                (5, 2) => $($body)::+::<T, 5, 2>,
                (5, 4) => $($body)::+::<T, 5, 4>,
                (5, _) => $($body)::+::<T, 5, 8>,
                (6, 2) => $($body)::+::<T, 6, 2>,
                (6, 4) => $($body)::+::<T, 6, 4>,
                (6, _) => $($body)::+::<T, 6, 8>,
                (7, 2) => $($body)::+::<T, 7, 2>,
                (7, 4) => $($body)::+::<T, 7, 4>,
                (7, _) => $($body)::+::<T, 7, 8>,
                (_, 2) => $($body)::+::<T, 8, 2>,
                (_, 4) => $($body)::+::<T, 8, 4>,
                (_, _) => $($body)::+::<T, 8, 8>,
            }
        };
    }
    match (variant, T::PRECISION) {
        (Variant::Portable, _) => by_size!(portable),
        #[cfg(target_arch = "x86_64")]
        (Variant::Avx512, Precision::Single) => by_size!(x86::avx512),
        #[cfg(target_arch = "x86_64")]
        (Variant::Avx2Fma | Variant::Avx512, _) => by_size!(x86::avx2),
        #[cfg(not(target_arch = "x86_64"))]
        _ => by_size!(portable),
    }
}
