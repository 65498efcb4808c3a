//! Where everything is at an instant.
