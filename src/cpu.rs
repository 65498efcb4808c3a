//! Which instructions inner loops are compiled for.
//!
//! A [`Task`] is written once, in safe code over slices and arrays; [`Variant::run`] runs a copy of it that
//! was compiled for the instructions of the variant. That works as long as everything it calls is inlined
//! into it: functions marked `#[inline(always)]`, and loops. `map` on an array and `array::from_fn` are
//! functions of their own whenever the compiler likes, a different one in every build, and then four times
//! slower: inner loops do without them.
//!
//! ```
//! use nereus::cpu::{Task, Variant};
//! struct Sum<'a>(&'a [f32]);
//! impl Task for Sum<'_> {
//!     type Output = f32;
//!     #[inline(always)]
//!     fn run(self) -> f32 {
//!         self.0.iter().sum()
//!     }
//! }
//! assert_eq!(Variant::fastest().run(Sum(&[1.0, 2.0, 3.0])), 6.0);
//! ```
#![allow(unsafe_code)]

use std::fmt;

/// Instructions for the inner loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Variant {
    /// What every CPU of the target has; no fused products.
    Portable,
    /// AVX2 and FMA.
    Avx2Fma,
    /// AVX-512 F, BW, DQ and VL.
    Avx512,
}

/// What can be run in any variant.
pub trait Task {
    /// What it returns.
    type Output;
    /// Runs it. To be marked `#[inline(always)]`, as all that it calls.
    fn run(self) -> Self::Output;
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

    /// The fastest that this CPU has.
    pub fn fastest() -> Self {
        Self::ALL.into_iter().rev().find(|v| v.is_available()).unwrap_or(Self::Portable)
    }

    /// Runs a task with its instructions; one that this CPU lacks falls back to the portable ones.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the instructions are there.
            Self::Avx512 if self.is_available() => unsafe { x86::avx512(task) },
            #[cfg(target_arch = "x86_64")]
            // SAFETY: the instructions are there.
            Self::Avx2Fma if self.is_available() => unsafe { x86::avx2(task) },
            _ => task.run(),
        }
    }
}

/// Instructions that are there: what is compiled for one set of them alone takes one as an argument.
pub(crate) trait Instructions: Copy {
    /// Where this CPU has them.
    fn find() -> Option<Self>;
    /// Runs a task with them.
    fn run<T: Task>(self, task: T) -> T::Output;
}

/// Those of [`Variant::Portable`].
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Instructions for Portable {
    fn find() -> Option<Self> {
        Some(Self)
    }

    #[inline]
    fn run<T: Task>(self, task: T) -> T::Output {
        task.run()
    }
}

macro_rules! instructions {
    ($name:ident, $function:ident) => {
        #[doc = concat!("Those of [`Variant::", stringify!($name), "`].")]
        #[derive(Clone, Copy)]
        pub(crate) struct $name(());

        impl Instructions for $name {
            fn find() -> Option<Self> {
                Variant::$name.is_available().then_some(Self(()))
            }

            #[inline]
            fn run<T: Task>(self, task: T) -> T::Output {
                #[cfg(target_arch = "x86_64")]
                // SAFETY: `find` alone makes one, where the instructions are there.
                return unsafe { x86::$function(task) };
                #[cfg(not(target_arch = "x86_64"))]
                task.run()
            }
        }
    };
}

instructions!(Avx2Fma, avx2);
instructions!(Avx512, avx512);

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Avx2Fma => "avx2+fma",
            Self::Avx512 => "avx-512",
        })
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::Task;

    #[target_feature(enable = "avx2,fma")]
    pub(super) fn avx2<T: Task>(task: T) -> T::Output {
        task.run()
    }

    #[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma")]
    pub(super) fn avx512<T: Task>(task: T) -> T::Output {
        task.run()
    }
}
