//! What may be wrong with a mesh, reported all at once.

use std::path::PathBuf;

use thiserror::Error;

use super::{MOST_BYTES, MOST_M, MOST_OF_SCENE, MOST_PANELS, MOST_TRIANGLES};
use crate::inputs::reason;

/// Why there is no mesh.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// A file that cannot be read.
    #[error("mesh {}: cannot be read: {}", path.display(), reason(*kind))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        kind: std::io::ErrorKind,
    },
    /// A file with faults.
    #[error("mesh {}: {}", path.display(), faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Faulty {
        /// The file.
        path: PathBuf,
        /// All of them.
        faults: Vec<MeshFault>,
    },
    /// More panels than a ship may have.
    #[error(
        "more than {MOST_PANELS} panels with panel_m = {panel_m}: allowed are at most {MOST_PANELS} a ship, give a larger panel_m"
    )]
    TooMany {
        /// Longest edge asked, m.
        panel_m: f64,
    },
    /// More panels than all ships together may have.
    #[error(
        "its {own} panels make {together} of all ships: allowed are at most {MOST_OF_SCENE} together, give a larger panel_m, or echo = false to some"
    )]
    Together {
        /// Of this ship.
        own: usize,
        /// Of this one and those before it.
        together: usize,
    },
}

/// One fault of a file.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshFault {
    /// No kind of file that is read.
    #[error("what it ends with is no format that is read; allowed: .obj, .stl")]
    Format,
    /// A file too long.
    #[error("more than {MOST_BYTES} bytes")]
    Long,
    /// The error of the format's reader.
    #[error("{text}")]
    Reader {
        /// Its words.
        text: String,
    },
    /// No triangle at all.
    #[error("no triangles; allowed: 1 to {MOST_TRIANGLES}")]
    Empty,
    /// Too many of them.
    #[error("{count} triangles; allowed: 1 to {MOST_TRIANGLES}")]
    Many {
        /// How many there are.
        count: usize,
    },
    /// Faces of more or fewer corners than three.
    #[error(
        "{count} faces that are no triangles, the first is face {first}; allowed: triangles (export the mesh triangulated)"
    )]
    NotTriangles {
        /// How many.
        count: usize,
        /// The first, from 1.
        first: usize,
    },
    /// Corners that are no places of a ship.
    #[error(
        "{count} triangles with a corner that is not finite or farther than {MOST_M} m from midship, the first is triangle {first}; allowed: metres (not millimetres or inches), x forward, y to port, z up from the waterline"
    )]
    Places {
        /// How many.
        count: usize,
        /// The first, from 1.
        first: usize,
    },
    /// Triangles without area.
    #[error(
        "{count} triangles without area, the first is triangle {first}; allowed: corners that do not lie in a line (remove them, most tools call them degenerate)"
    )]
    Degenerate {
        /// How many.
        count: usize,
        /// The first, from 1.
        first: usize,
    },
    /// Neighbours that disagree on what is outside.
    #[error(
        "{count} edges whose triangles disagree on which side is outside, the first is of triangle {first}; allowed: corners counter-clockwise as seen from outside, throughout"
    )]
    Orientation {
        /// Edges.
        count: usize,
        /// A triangle of the first, from 1.
        first: usize,
    },
    /// A part whose triangles face inwards.
    #[error(
        "{count} parts are inside out, the first has triangle {first}; allowed: corners counter-clockwise as seen from outside (flip the normals of these parts)"
    )]
    InsideOut {
        /// Parts.
        count: usize,
        /// The first triangle of the first of them, from 1.
        first: usize,
    },
}
