//! Joins the shards of a run.
