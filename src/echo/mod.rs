//! Contacts to samples.
