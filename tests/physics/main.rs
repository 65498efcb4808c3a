//! Physics against golden values and closed forms.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod scatter_batch;
mod scatter_composite;
mod scatter_extremes;
mod scatter_golden;
mod scatter_laws;
mod scatter_oracle;
