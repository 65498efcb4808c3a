//! The only factory: a [`Run`](crate::config::Run) becomes a running stream.
//!
//! This is the one floor that sees both halves of the house: the physics that makes a pulse
//! ([`stages`]) and the transport that releases it ([`crate::transport`]).

pub mod aboard;
pub mod accuracy;
mod block;
pub mod build;
pub mod changing;
pub mod control;
mod dry_run;
pub mod forecast;
pub mod gather;
pub mod knobs;
pub mod live;
pub mod memory;
mod navigation;
pub mod outlook;
pub(crate) mod outputs;
pub mod plausible;
pub mod prices;
mod single;
pub mod speed;
pub mod stages;
pub mod sweep;
mod tracks;
