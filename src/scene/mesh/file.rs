//! Meshes from files: Wavefront OBJ and STL (text or binary), by the crates `tobj` and `stl_io`.
//!
//! Metres, x forward of midship, y to port, z up from the design waterline; triangles counter-clockwise as
//! seen from outside. Materials, colours and normals of the file are not used. All faults are reported at
//! once.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::{MOST_BYTES, MOST_M, MOST_TRIANGLES, MeshError, MeshFault, Triangle, orientation};
use crate::inputs;

/// Twice the area of a triangle over the square of its longest edge, at least.
const LEAST_SHAPE: f64 = 1e-6;

/// Reads a mesh.
///
/// # Errors
/// A file that cannot be read, and all that is wrong with it.
pub fn load(path: &Path) -> Result<Vec<Triangle>, MeshError> {
    let faulty = |faults| MeshError::Faulty { path: path.to_owned(), faults };
    let ends = path.extension().map(|ends| ends.to_string_lossy().to_ascii_lowercase());
    let read = match ends.as_deref() {
        Some("obj") => obj,
        Some("stl") => stl,
        _ => return Err(faulty(vec![MeshFault::Format])),
    };
    let bytes = inputs::read(path, MOST_BYTES)
        .map_err(|error| MeshError::Read { path: path.to_owned(), kind: error.kind() })?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(faulty(vec![MeshFault::Long]));
    }
    let mut faults = Vec::new();
    let triangles = read(&bytes, &mut faults);
    if faults.is_empty() {
        faults = checked(&triangles);
    }
    if faults.is_empty() { Ok(triangles) } else { Err(faulty(faults)) }
}

/// Lines with those that a backslash at their end continues.
fn continued(bytes: &[u8]) -> Cow<'_, [u8]> {
    if !bytes.contains(&b'\\') {
        return Cow::Borrowed(bytes);
    }
    let mut joined = Vec::with_capacity(bytes.len());
    for line in bytes.split_inclusive(|byte| *byte == b'\n') {
        match line.trim_ascii_end().strip_suffix(b"\\") {
            Some(begun) => {
                joined.extend_from_slice(begun);
                joined.push(b' ');
            }
            None => joined.extend_from_slice(line),
        }
    }
    Cow::Owned(joined)
}

/// The corners and faces of an OBJ file; `None` of too many faces. Its reader multiplies indices of normals
/// without a check, and keeps all that it reads.
fn shape(bytes: &[u8]) -> Option<Vec<u8>> {
    let (mut kept, mut faces) = (Vec::new(), 0);
    let joined = continued(bytes);
    for line in joined.split(|byte| *byte == b'\n') {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => kept.extend_from_slice(line),
            Some(b"f") => {
                faces += 1;
                if faces > MOST_TRIANGLES {
                    return None;
                }
                kept.push(b'f');
                // A fourth corner is a fault already.
                for word in words.take(4) {
                    kept.push(b' ');
                    kept.extend(word.iter().take_while(|byte| **byte != b'/'));
                }
            }
            _ => continue,
        }
        kept.push(b'\n');
    }
    Some(kept)
}

fn obj(bytes: &[u8], faults: &mut Vec<MeshFault>) -> Vec<Triangle> {
    let Some(kept) = shape(bytes) else {
        faults.push(MeshFault::Many { count: MOST_TRIANGLES + 1 });
        return Vec::new();
    };
    // Materials lie in files of their own, which are not opened.
    let read =
        tobj::load_obj_buf(&mut Cursor::new(kept), &tobj::LoadOptions::default(), |_| Ok(Default::default()));
    let models = match read {
        Ok((models, _)) => models,
        Err(error) => {
            faults.push(MeshFault::Reader { text: format!("no OBJ file: {error}") });
            return Vec::new();
        }
    };
    let (mut triangles, mut others, mut first, mut faces) = (Vec::new(), 0, None, 0);
    for model in &models {
        let mesh = &model.mesh;
        let corner = |index: &u32| {
            let at = 3 * *index as usize;
            let of = |i: usize| mesh.positions.get(at + i).map_or(f64::NAN, |x| f64::from(*x));
            DVec3::new(of(0), of(1), of(2))
        };
        // Of triangles alone there are no numbers of corners.
        for arity in mesh.face_arities.iter().filter(|_| !mesh.face_arities.is_empty()) {
            faces += 1;
            if *arity != 3 {
                others += 1;
                first = first.or(Some(faces));
            }
        }
        if mesh.face_arities.is_empty() {
            faces += mesh.indices.len() / 3;
        }
        let (whole, _) = mesh.indices.as_chunks::<3>();
        triangles.extend(whole.iter().map(|indices| indices.each_ref().map(corner)));
    }
    if let Some(first) = first {
        faults.push(MeshFault::NotTriangles { count: others, first });
    }
    triangles
}

/// A text STL in lower case, as its reader has it; a binary one as it is, known by its length, since its
/// header may begin like a text.
fn lower_case(bytes: &[u8]) -> Cow<'_, [u8]> {
    let count =
        bytes.get(80..84).map(|count| count.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte)));
    let is_binary = count.is_some_and(|count| bytes.len() == 84 + 50 * count);
    let text = bytes.trim_ascii_start();
    match text.get(..5) {
        Some(word) if !is_binary && word.eq_ignore_ascii_case(b"solid") => {
            Cow::Owned(text.to_ascii_lowercase())
        }
        _ => Cow::Borrowed(bytes),
    }
}

fn stl(bytes: &[u8], faults: &mut Vec<MeshFault>) -> Vec<Triangle> {
    let bytes = lower_case(bytes);
    let read = || -> std::io::Result<Vec<Triangle>> {
        let mut cursor = Cursor::new(&bytes);
        let triangles = stl_io::create_stl_reader(&mut cursor)?;
        triangles
            .take(MOST_TRIANGLES + 1)
            .map(|triangle| {
                triangle.map(|triangle| {
                    triangle.vertices.map(|corner| DVec3::from_array(corner.0.map(f64::from)))
                })
            })
            .collect()
    };
    read().unwrap_or_else(|error| {
        faults.push(MeshFault::Reader { text: format!("no STL file: {error}") });
        Vec::new()
    })
}

fn checked(triangles: &[Triangle]) -> Vec<MeshFault> {
    if triangles.is_empty() {
        return vec![MeshFault::Empty];
    }
    if triangles.len() > MOST_TRIANGLES {
        return vec![MeshFault::Many { count: triangles.len() }];
    }
    let which = |wrong: fn(&Triangle) -> bool| {
        let found: Vec<usize> = (0..triangles.len()).filter(|n| wrong(&triangles[*n])).collect();
        found.first().map(|first| (found.len(), first + 1))
    };
    let mut faults = Vec::new();
    if let Some((count, first)) =
        which(|t| !t.iter().all(|corner| corner.to_array().iter().all(|x| x.abs() <= MOST_M)))
    {
        faults.push(MeshFault::Places { count, first });
    }
    if let Some((count, first)) = which(|[a, b, c]| {
        let edges = [*b - *a, *c - *a, *c - *b].map(|edge| edge.length_squared());
        let longest = edges.into_iter().fold(0.0, f64::max);
        (*b - *a).cross(*c - *a).length() <= LEAST_SHAPE * longest
    }) {
        faults.push(MeshFault::Degenerate { count, first });
    }
    if faults.is_empty() {
        faults = orientation::faults(triangles);
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 4 m x 3 m x 2 m as an OBJ, its faces turned round where asked.
    fn cube(turned: impl Fn(usize) -> bool) -> String {
        let mut text = String::from("o house\n");
        for n in 0..8 {
            let at = |bit: usize, wide: f64| if n >> bit & 1 == 1 { wide } else { 0.0 };
            text += &format!("v {} {} {}\n", at(0, 4.0), at(1, 3.0), at(2, 2.0));
        }
        let faces = [
            [1, 3, 4],
            [1, 4, 2],
            [5, 6, 8],
            [5, 8, 7],
            [1, 2, 6],
            [1, 6, 5],
            [3, 7, 8],
            [3, 8, 4],
            [1, 5, 7],
            [1, 7, 3],
            [2, 4, 8],
            [2, 8, 6],
        ];
        for (n, [a, b, c]) in faces.into_iter().enumerate() {
            let [b, c] = if turned(n) { [c, b] } else { [b, c] };
            text += &format!("f {a} {b} {c}\n");
        }
        text
    }

    fn loaded(name: &str, bytes: &[u8]) -> Result<Vec<Triangle>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        load(&path).map_err(|error| error.to_string().replace(&path.display().to_string(), name))
    }

    #[test]
    fn a_box_is_read_from_either_format() {
        let of_obj = loaded("house.obj", cube(|_| false).as_bytes()).unwrap();
        assert_eq!(of_obj.len(), 12);
        let mut bytes = Vec::new();
        let triangles = of_obj.iter().map(|corners| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: corners.map(|corner| stl_io::Vertex::new(corner.to_array().map(|x| x as f32))),
        });
        stl_io::write_stl(&mut bytes, triangles.collect::<Vec<_>>().iter()).unwrap();
        assert_eq!(loaded("house.stl", &bytes).unwrap(), of_obj);
    }

    /// Lines continued by a backslash, with both ends of lines; text in capitals; a binary file that says
    /// solid.
    #[test]
    fn variants_of_both_formats_are_read() {
        let text = cube(|_| false);
        let of_obj = loaded("house.obj", text.as_bytes()).unwrap();
        for end in ["\n", "\r\n"] {
            let continued =
                text.replace("f ", &format!("f \\{end} ")).replace("v 0", &format!("v \\ {end}0"));
            assert_eq!(loaded("house.obj", continued.as_bytes()).unwrap(), of_obj);
        }
        let mut facets = String::from("Solid house\n");
        let mut bytes = [&b"solid house"[..], &[b' '; 69], &12u32.to_le_bytes()].concat();
        for corners in &of_obj {
            facets += " FACET NORMAL 0 0 0\n  Outer Loop\n";
            bytes.extend([0; 12]);
            for corner in corners {
                facets += &format!("   VERTEX {:E} {:E} {:E}\n", corner.x, corner.y, corner.z);
                bytes.extend(corner.to_array().iter().flat_map(|x| (*x as f32).to_le_bytes()));
            }
            facets += "  EndLoop\n ENDFACET\n";
            bytes.extend([0; 2]);
        }
        facets += "ENDSOLID house\n";
        assert_eq!(loaded("house.STL", facets.as_bytes()).unwrap(), of_obj);
        assert_eq!(loaded("house.stl", &bytes).unwrap(), of_obj);
    }

    #[test]
    fn meshes_inside_out_are_named() {
        let text = loaded("in.obj", cube(|_| true).as_bytes()).unwrap_err();
        assert!(
            text.contains("in.obj")
                && text.contains("1 parts are inside out, the first has triangle 1; allowed"),
            "{text}"
        );
        let text = loaded("odd.obj", cube(|n| n == 4).as_bytes()).unwrap_err();
        assert!(text.contains("3 edges whose triangles disagree"), "{text}");
        // Without its bottom, too; and a sheet faces where it likes.
        let open = |turned| {
            cube(move |_| turned)
                .lines()
                .filter(|l| {
                    !l.ends_with("1 3 4")
                        && !l.ends_with("1 4 3")
                        && !l.ends_with("1 4 2")
                        && !l.ends_with("1 2 4")
                })
                .collect::<Vec<_>>()
                .join("\n")
        };
        assert!(loaded("open.obj", open(true).as_bytes()).unwrap_err().contains("inside out"));
        assert_eq!(loaded("open.obj", open(false).as_bytes()).unwrap().len(), 10);
        for sheet in ["v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 3 2\n"] {
            assert_eq!(loaded("sheet.obj", sheet.as_bytes()).unwrap().len(), 1);
        }
    }

    #[test]
    fn hostile_files_are_named() {
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (name, text, wanted) in [
            ("a.obj", String::new(), "no triangles"),
            ("a.obj", format!("{triangle}f 1 2 9\n"), "no OBJ file"),
            ("a.obj", format!("{triangle}f 1 2 3 1\n"), "1 faces that are no triangles, the first is face 1"),
            ("a.obj", format!("{triangle}l 1 2\n"), "no triangles"),
            ("a.obj", format!("{triangle}f 1 2 2\n"), "1 triangles without area"),
            ("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(), "not finite"),
            ("a.obj", "v 1e9 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(), "farther than 1000 m"),
            ("a.obj", format!("{triangle}vn 0 0 1\nf 1//6148914691236517206 2//1 9//1\n"), "no OBJ file"),
            ("a.obj", "f 1\n".repeat(MOST_BYTES as usize / 4), "100001 triangles; allowed"),
            ("a.obj", format!("{triangle}f{}\n", " 1".repeat(1 << 20)), "1 faces that are no triangles"),
            ("a.stl", "solid a\nfacet normal 0 0".to_owned(), "no STL file"),
            ("a.stl", "\u{1}".repeat(84), "no STL file"),
            ("a.stl", String::new(), "no STL file"),
            ("a.ply", String::new(), "allowed: .obj, .stl"),
        ] {
            let found = loaded(name, text.as_bytes()).expect_err(wanted);
            assert!(found.contains(wanted), "{found}");
        }
        let text = format!("{triangle}vn 0 0 1\nf 1//6148914691236517206 2//1 3//1\n");
        assert_eq!(loaded("a.obj", text.as_bytes()).unwrap().len(), 1);
        let missing = load(Path::new("/nowhere/ship.obj")).unwrap_err().to_string();
        assert!(missing.contains("cannot be read"), "{missing}");
    }
}
