//! The only factory: a [`Run`](crate::config::Run) becomes a running stream.
//!
//! This is the one floor that sees both halves of the house: the physics that makes a pulse
//! ([`stages`]) and the transport that releases it ([`crate::transport`]).

pub mod hull_scatterers;
pub(crate) mod block;
pub mod build;
pub mod changing;
pub mod control;
mod dry_run;
pub mod factory;
pub mod fault;
pub mod live;
pub mod memory;
mod navigation;
pub(crate) mod outputs;
pub mod plausible;
pub(crate) mod power;
pub mod scenario;
mod single;
pub mod stages;
pub mod tracks;
