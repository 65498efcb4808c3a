//! The waves of ships.
//!
//! [`kochin`]: from a hull and its speed to the amplitudes of the waves it makes, and what they cost it.

pub mod kochin;
