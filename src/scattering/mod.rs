//! What each thing that scatters returns, as one flat list of contacts.

pub mod contact;
pub mod target;
