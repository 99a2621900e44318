//! Finds mesh files and reads their vertices.
//!
//! A convex hull needs only the vertices, also those that no face uses. The faces are read only if the mesh is cut into
//! pieces. A mesh file is searched in these places:
//!
//! | name | place |
//! |---|---|
//! | `package://NAME/REST` | REST in a folder NAME: a folder above the description, or a subfolder of one; nearest first |
//! | `file:///REST`, `/REST` | this path |
//! | `REST` | from the folder of the description |
//!
//! Not here: environment variables with the paths of packages.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use gate::source;

use robot::mesh;
use robot::vector::Vector3;
use robot::{CollisionShape, Robot};

/// Largest size of a mesh file that is read, bytes. Larger files are no collision geometry.
const MAX_MESH_BYTES: u64 = 256 << 20;
/// Largest allowed coordinate of a vertex, m. No robot has a vertex farther away.
const FARTHEST_VERTEX_M: f64 = 1e6;

/// The path of a mesh file that a robot description names. `directory`: folder of the description.
///
/// Fails if the file is in none of the places; the error text names the first place.
pub(crate) fn mesh_path(name: &str, directory: &Path) -> Result<PathBuf, String> {
    let places: Vec<PathBuf> = match (name.split_once("://"), name.strip_prefix("file://")) {
        (_, Some(path)) => vec![PathBuf::from(path)],
        (Some((_, rest)), None) => {
            let (package, rest) = rest.split_once('/').unwrap_or((rest, ""));
            // A relative `directory` does not contain the folders above the working directory. So its absolute path is used.
            let full = std::path::absolute(directory).unwrap_or(directory.to_path_buf());
            let candidates = full.ancestors().flat_map(|above| {
                let own = above.file_name().is_some_and(|n| n == package).then(|| above.join(rest));
                own.into_iter().chain([above.join(package).join(rest)])
            });
            candidates.collect()
        }
        (None, None) => vec![directory.join(name)],
    };
    if let Some(found) = places.iter().find(|path| path.is_file()) {
        return Ok(found.clone());
    }
    let first = places.first().map(PathBuf::as_path).unwrap_or(Path::new(name));
    let there = places.iter().find(|path| path.exists());
    let above = if places.len() > 1 && there.is_none() { " or in the folders above" } else { "" };
    Err(source::no_file(there.map_or(first, PathBuf::as_path)).unwrap_or_default() + above)
}

/// Paths of all mesh files in the collision geometry of a robot. `directory`: folder of the robot description.
pub fn mesh_files(robot: &Robot, directory: &Path) -> Vec<PathBuf> {
    let all = robot.links.iter().flat_map(|link| &link.collisions).chain(&robot.base.collisions);
    let file = |shape: &CollisionShape| match shape {
        CollisionShape::Mesh { file, .. } => mesh_path(file, directory).ok(),
        _ => None,
    };
    all.filter_map(|collision| file(&collision.shape)).collect()
}

/// The distinct vertices of a mesh file, in the unit of the file. The file extension determines the format.
///
/// Fails if the file cannot be read or does not have this format.
pub fn vertices(path: &Path) -> Result<Vec<Vector3>, String> {
    parse_vertices(&content(path)?, path)
}

/// The triangles of a mesh file, in the unit of the file. The file extension determines the format.
///
/// Fails if [`vertices`] fails, or if triangles cannot be read from this format.
pub(crate) fn triangles(path: &Path) -> Result<Vec<[Vector3; 3]>, String> {
    mesh::triangles(&content(path)?, path)
}

fn content(path: &Path) -> Result<Vec<u8>, String> {
    let fail = |what: String| format!("{}: {what}", path.display());
    // The format is checked first, so that a file of an unknown format is not opened.
    mesh::check_format(path)?;
    source::read(path, MAX_MESH_BYTES).map_err(|e| match e.kind() {
        ErrorKind::FileTooLarge => fail("the mesh is larger than 256 MiB".into()),
        _ => fail(format!("the mesh cannot be read: {e}")),
    })
}

/// The vertices from the content of a mesh file. `path` determines the format and appears in messages; no file is opened.
pub fn parse_vertices(bytes: &[u8], path: &Path) -> Result<Vec<Vector3>, String> {
    let fail = |what: String| format!("{}: {what}", path.display());
    let mut found = mesh::vertices(bytes, path)?;
    if let Some(far) = found.iter().find(|p| p.iter().any(|x| x.is_nan() || x.abs() > FARTHEST_VERTEX_M)) {
        return Err(fail(format!("a vertex is at {far:?}: no robot reaches there")));
    }
    if found.is_empty() {
        return Err(fail("the mesh has no vertex".into()));
    }
    // Each vertex occurs in many triangles, so duplicates are removed.
    found.sort_by(|a, b| {
        a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    found.dedup();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a test folder with empty folders for a description and for meshes.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rist-mesh-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("arm_description/urdf")).unwrap();
        std::fs::create_dir_all(folder.join("arm_description/meshes")).unwrap();
        folder
    }

    fn binary(vertices: &[[f32; 3]]) -> Vec<u8> {
        let mut bytes = vec![b's'; 80];
        bytes[..5].copy_from_slice(b"solid");
        bytes.extend(u32::try_from(vertices.len() / 3).unwrap().to_le_bytes());
        for triangle in vertices.chunks_exact(3) {
            bytes.extend([0; 12]);
            triangle.iter().flatten().for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn all_formats_have_the_same_vertices() {
        let folder = folder("formats");
        let expected = vec![[0.0, 0.0, 0.5], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        let text = "solid one\n facet normal 0 0 1\n outer loop\n  vertex 1 0 0\n  vertex 0 1 0\r\n  vertex 0 0 5e-1\n \
                    endloop\n endfacet\nendsolid\n";
        let object = "# a triangle\nv 1 0 0\nv 0 1 0 1.0\nvn 0 0 1\nv 0 0 0.5\nf 1 2 3\n";
        for (name, bytes) in [
            ("a.STL", binary(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]])),
            ("b.stl", text.as_bytes().to_vec()),
            ("c.obj", object.as_bytes().to_vec()),
        ] {
            std::fs::write(folder.join(name), bytes).unwrap();
            assert_eq!(vertices(&folder.join(name)).unwrap(), expected, "{name}");
        }
        for (name, bytes, said) in [
            ("short.stl", binary(&[[1.0; 3]; 3])[..100].to_vec(), "three numbers"),
            ("other.stl", vec![7; 200], "neither an STL"),
            ("none.obj", b"f 1 2 3\n".to_vec(), "no vertex"),
            ("far.obj", b"v 1 2 inf\n".to_vec(), "no robot reaches"),
            ("broken.obj", b"v 1 2\n".to_vec(), "line 1: a v has three numbers"),
            ("tool.fbx", vec![], "convert it"),
        ] {
            std::fs::write(folder.join(name), bytes).unwrap();
            let error = vertices(&folder.join(name)).map(|v| v.len());
            // A truncated text file has no vertex, which is an error too.
            let error = error.unwrap_err();
            assert!(error.contains(said) || error.contains("no vertex"), "{name}: {error}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn meshes_are_found_where_people_have_them() {
        let folder = folder("places");
        let (description, mesh) = (folder.join("arm_description/urdf"), folder.join("arm_description/meshes/arm.stl"));
        std::fs::write(&mesh, "solid").unwrap();
        let full = format!("file://{}", mesh.display());
        for name in ["package://arm_description/meshes/arm.stl", "../meshes/arm.stl", &full] {
            let found = mesh_path(name, &description).unwrap();
            assert_eq!(found.canonicalize().unwrap(), mesh.canonicalize().unwrap(), "{name}");
        }
        let error = mesh_path("package://arm_description/meshes/hand.stl", &description).unwrap_err();
        assert!(error.contains("hand.stl or in the folders above"), "{error}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
