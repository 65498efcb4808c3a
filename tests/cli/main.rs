//! The built program: exit codes, what goes to which stream, texts.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod inspection;
mod program;
mod readme;
mod running;
#[cfg(unix)]
mod setup_script;
mod table_golden;
mod tables;
