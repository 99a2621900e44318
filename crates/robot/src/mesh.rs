//! Reads the vertices and triangles of mesh files: binary and text STL, OBJ, and MuJoCo's own .msh.
//!
//! Normals, textures and names are ignored. A face of an OBJ with more than three corners is divided into a fan of triangles.
//!
//! Other packages can register functions that read the vertices of other formats.
//!
//! Not here: the search for mesh files.

use std::path::Path;
use std::sync::OnceLock;

use crate::vector::Vector3;

/// The vertices in the content of a mesh file, with repetitions. `path` determines the format and appears in messages.
///
/// Fails if the content does not have this format.
pub fn vertices(bytes: &[u8], path: &Path) -> Result<Vec<Vector3>, String> {
    let read = match format(path)? {
        Format::Stl => stl(bytes),
        Format::Obj => text_vertices(bytes, "v"),
        Format::Msh => msh(bytes).map(|(vertices, _)| vertices),
        Format::Registered(read) => read(bytes),
    };
    read.map_err(|what| format!("{}: {what}", path.display()))
}

/// The triangles in the content of a mesh file. `path` determines the format and appears in messages.
///
/// Fails if the content does not have this format. Also fails for a format that another package registered, because such a format
/// provides only vertices.
pub fn triangles(bytes: &[u8], path: &Path) -> Result<Vec<[Vector3; 3]>, String> {
    if let (Format::Stl, Some(body)) = (format(path)?, binary(bytes)) {
        return Ok(body.chunks_exact(STL_TRIANGLE_BYTES).map(triangle).collect());
    }
    let corners = vertices(bytes, path)?;
    let fail = |what: String| format!("{}: {what}", path.display());
    match format(path)? {
        Format::Stl => Ok(corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()),
        Format::Obj => faces(bytes, &corners).map_err(fail),
        Format::Msh => msh(bytes).map(|(_, triangles)| triangles).map_err(fail),
        Format::Registered(_) => Err(fail("triangles are read from .stl, .obj and .msh".into())),
    }
}

#[derive(Clone, Copy)]
enum Format {
    Stl,
    Obj,
    Msh,
    Registered(ReadVertices),
}

/// A function that reads the vertices (m) from the bytes of a file.
pub type ReadVertices = fn(&[u8]) -> Result<Vec<Vector3>, String>;

/// A mesh format that another package can read.
#[derive(Clone, Copy)]
pub struct MeshFormat {
    /// File extension of the format, in lower case.
    pub extension: &'static str,
    /// The function that reads the vertices, or a message that says why this format cannot be read.
    pub vertices: Result<ReadVertices, &'static str>,
}

static FORMATS: OnceLock<Vec<MeshFormat>> = OnceLock::new();

/// Registers additional formats. Only the first call has an effect.
pub fn register(formats: Vec<MeshFormat>) {
    FORMATS.get_or_init(|| formats);
}

/// Fails if no known format has the extension of `path`.
pub fn check_format(path: &Path) -> Result<(), String> {
    format(path).map(|_| ())
}

fn format(path: &Path) -> Result<Format, String> {
    let kind = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match kind.as_str() {
        "stl" => Ok(Format::Stl),
        "obj" => Ok(Format::Obj),
        "msh" => Ok(Format::Msh),
        _ => {
            let registered: &[MeshFormat] = FORMATS.get().map_or(&[], Vec::as_slice);
            if let Some(known) = registered.iter().find(|format| format.extension == kind) {
                return known.vertices.map(Format::Registered).map_err(|why| format!("{}: {why}", path.display()));
            }
            let read: String =
                registered.iter().filter(|f| f.vertices.is_ok()).map(|f| format!(", .{}", f.extension)).collect();
            let (path, stem) = (path.display(), path.with_extension("stl"));
            let stem = stem.display();
            Err(format!(
                "{path}: meshes are read from .stl, .obj, .msh{read}: convert it (assimp export {path} {stem}, or MeshLab)"
            ))
        }
    }
}

/// The triangles of the faces of an OBJ. A face refers to a vertex by its index from 1, or by a negative index from the
/// last vertex (-1).
fn faces(bytes: &[u8], corners: &[Vector3]) -> Result<Vec<[Vector3; 3]>, String> {
    let mut found = Vec::new();
    let mut so_far = 0;
    for (k, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        match words.next() {
            Some("v") => so_far += 1,
            Some("f") => {
                let corner = |word: &str| {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number < 0 { so_far + number } else { number - 1 };
                    corners.get(usize::try_from(index).ok()?).copied()
                };
                let face: Option<Vec<Vector3>> = words.map(corner).collect();
                let face = face.filter(|face| face.len() >= 3);
                let face =
                    face.ok_or_else(|| format!("line {}: no face of known vertices: `{}`", k + 1, text.trim()))?;
                found.extend(face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Number of bytes before the triangles of a binary STL: a header of 80 bytes, and the number of triangles.
const STL_HEADER_BYTES: usize = 84;
/// Number of bytes of a triangle in a binary STL: its normal, three vertices, and two more bytes.
const STL_TRIANGLE_BYTES: usize = 50;

/// The bytes of the triangles, if the file is a binary STL. `None` if the length does not fit the number of triangles: then it is
/// a text STL. Only the length is reliable, because the header of a binary STL may also start with `solid`.
fn binary(bytes: &[u8]) -> Option<&[u8]> {
    let body = bytes.get(STL_HEADER_BYTES..)?;
    let is_whole = body.len().is_multiple_of(STL_TRIANGLE_BYTES);
    (is_whole && body.len() / STL_TRIANGLE_BYTES == promised(bytes)).then_some(body)
}

/// The number of triangles that the header of a binary STL states.
fn promised(bytes: &[u8]) -> usize {
    let word = bytes.get(STL_HEADER_BYTES - 4..STL_HEADER_BYTES);
    word.and_then(|b| <[u8; 4]>::try_from(b).ok()).map_or(0, |b| u32::from_le_bytes(b) as usize)
}

/// The corners of a triangle of a binary STL. They follow the normal.
fn triangle(bytes: &[u8]) -> [Vector3; 3] {
    let (words, _) = bytes.as_chunks::<4>();
    let mut corners = [[f64::NAN; 3]; 3];
    for (x, word) in corners.as_flattened_mut().iter_mut().zip(words.iter().skip(3)) {
        *x = f64::from(f32::from_le_bytes(*word));
    }
    corners
}

/// The vertices and triangles of MuJoCo's .msh, which is little-endian. It begins with the numbers of vertices, normals,
/// texture coordinates and faces, as integers of 32 bits. Then come three floats of 32 bits for each vertex, three for each
/// normal, two for each texture coordinate, and three indices from 0 for each face.
fn msh(bytes: &[u8]) -> Result<(Vec<Vector3>, Vec<[Vector3; 3]>), String> {
    const FLOATS_EACH: [usize; 4] = [3, 3, 2, 3];
    let (words, rest) = bytes.as_chunks::<4>();
    let whole = |word: &[u8; 4]| usize::try_from(i32::from_le_bytes(*word)).ok();
    let counts: Option<Vec<usize>> = words.iter().take(4).map(whole).collect();
    let counts = counts.filter(|counts| counts.len() == 4).ok_or("no .msh of MuJoCo")?;
    let sizes = [0, 1, 2, 3].map(|k| counts[k].saturating_mul(FLOATS_EACH[k]));
    let promised = sizes.iter().fold(4usize, |sum, size| sum.saturating_add(*size));
    if promised != words.len() || !rest.is_empty() {
        let found = bytes.len();
        return Err(format!(
            "no .msh of MuJoCo: {found} bytes, where its head promises {}",
            promised.saturating_mul(4)
        ));
    }
    let floats: Vec<f64> = words[4..4 + sizes[0]].iter().map(|word| f64::from(f32::from_le_bytes(*word))).collect();
    let vertices: Vec<Vector3> = floats.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
    let corners: Option<Vec<Vector3>> =
        words[words.len() - sizes[3]..].iter().map(|word| vertices.get(whole(word)?).copied()).collect();
    let corners = corners.ok_or("a face names a vertex that is none")?;
    let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Ok((vertices, triangles))
}

fn stl(bytes: &[u8]) -> Result<Vec<Vector3>, String> {
    if let Some(body) = binary(bytes) {
        return Ok(body.chunks_exact(STL_TRIANGLE_BYTES).flat_map(triangle).collect());
    }
    if bytes.trim_ascii_start().starts_with(b"solid") {
        return text_vertices(bytes, "vertex");
    }
    let of_triangles = promised(bytes).saturating_mul(STL_TRIANGLE_BYTES);
    let (found, said) = (bytes.len(), STL_HEADER_BYTES.saturating_add(of_triangles));
    Err(format!("neither an STL in text nor in binary: {found} bytes, where its head promises {said}"))
}

/// The vertices of a text file: on each line that starts with `word`, the three numbers after it.
fn text_vertices(bytes: &[u8], word: &str) -> Result<Vec<Vector3>, String> {
    let mut found = Vec::new();
    for (k, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        if words.next() != Some(word) {
            continue;
        }
        let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).take(3).collect();
        let vertex = <Vector3>::try_from(numbers)
            .map_err(|_| format!("line {}: a {word} has three numbers, found `{}`", k + 1, text.trim()))?;
        found.push(vertex);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{triangles, vertices};

    #[test]
    fn faces_of_an_obj_are_fans_of_triangles() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2//3 3 -1\n";
        let found = triangles(text.as_bytes(), Path::new("a.obj")).unwrap();
        assert_eq!(found, [[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]]);
        for broken in ["f 1 2 9", "f 1 2", "f a b c", "f 0 1 2", "f -9 1 2"] {
            let text = format!("v 0 0 0\nv 1 0 0\nv 1 1 0\n{broken}\n");
            let error = triangles(text.as_bytes(), Path::new("a.obj")).unwrap_err();
            assert!(error.contains("line 4: no face of known vertices"), "{error}");
        }
    }

    #[test]
    fn a_msh_has_what_its_head_promises() {
        let file = |counts: [i32; 4], floats: &[f32], faces: &[i32]| -> Vec<u8> {
            let counts = counts.iter().flat_map(|x| x.to_le_bytes());
            counts
                .chain(floats.iter().flat_map(|x| x.to_le_bytes()))
                .chain(faces.iter().flat_map(|x| x.to_le_bytes()))
                .collect()
        };
        let floats = [0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 9.0, 9.0, 9.0, 8.0, 8.0];
        let whole = file([3, 1, 1, 1], &floats, &[2, 0, 1]);
        let path = Path::new("a.msh");
        let expected = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(vertices(&whole, path).unwrap(), expected);
        assert_eq!(triangles(&whole, path).unwrap(), [[expected[2], expected[0], expected[1]]]);
        for (bytes, said) in [
            (file([3, 1, 1, 2], &floats, &[2, 0, 1]), "84 bytes, where its head promises 96"),
            (file([i32::MAX; 4], &floats, &[]), "its head promises"),
            (file([-1, 1, 1, 1], &floats, &[]), "no .msh of MuJoCo"),
            (file([3, 1, 1, 1], &floats, &[2, 0, 3]), "a face names a vertex that is none"),
            (whole[..83].to_vec(), "83 bytes"),
            (b"$MeshFormat".to_vec(), "no .msh of MuJoCo"),
        ] {
            let error = triangles(&bytes, path).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
