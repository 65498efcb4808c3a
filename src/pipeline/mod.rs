//! The only factory: a [`Run`](crate::config::Run) becomes a running stream.
//!
//! The only module that depends on both the physics that makes a pulse ([`stages`]) and the transport that
//! releases it ([`crate::transport`]).

#[doc(hidden)]
pub mod hull_scatterers;
pub(crate) mod block;
pub mod build;
#[doc(hidden)]
pub mod changing;
mod clock_start;
#[doc(hidden)]
pub mod control;
#[doc(hidden)]
pub mod control_lines;
mod dry_run;
mod engine;
mod engines;
pub mod factory;
pub mod focus;
pub mod fault;
mod joined;
mod kit;
mod mixed;
#[doc(hidden)]
pub mod live;
#[doc(hidden)]
pub mod memory;
mod navigation;
pub mod prepared;
mod refit;
mod relax;
pub mod released;
pub(crate) mod outputs;
mod overheard;
pub(crate) mod playback;
#[doc(hidden)]
pub mod plausible;
pub(crate) mod power;
pub mod scenario;
pub mod sea_map;
mod single;
#[doc(hidden)]
pub mod stages;
mod targets;
pub mod tracks;
mod video;
mod workers;

pub(crate) use workers::yield_to_pacer;
