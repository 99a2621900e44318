//! The meshes of a model. A mesh file is read only if the mass of a body depends on it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gate::source;

use super::compiler::Compiler;
use super::defaults::{Defaults, View};
use super::element::{Folders, MjcfElement};
use super::masses::{Enclosure, Volume, enclosed};
use crate::error::Error;
use crate::format::shown::shown;
use crate::mesh;
use crate::vector::{Vector3, minus, turned_back};

/// Size of the largest mesh file that is read for a mass, bytes.
const MAX_MESH_BYTES: u64 = 64 << 20;

/// The meshes that `<asset>` lists, and their computed volumes.
pub(super) struct Meshes<'a> {
    listed: Vec<(String, View<'a>)>,
    compiler: &'a Compiler,
    /// The folders of the mesh files.
    folders: Folders<'a>,
    /// Volumes that were already computed, by name of the mesh. Visual and collision shapes often share a mesh.
    known: RefCell<BTreeMap<String, Result<Volume, String>>>,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(
        root: &'a MjcfElement,
        defaults: &'a Defaults,
        compiler: &'a Compiler,
        folders: Folders<'a>,
    ) -> Result<Meshes<'a>, Error> {
        let mut listed = Vec::new();
        for element in root.children("asset").flat_map(|asset| asset.children("mesh")) {
            let stem = element.attribute("file").and_then(|file| Path::new(file).file_stem()?.to_str());
            let name = element.attribute("name").or(stem).unwrap_or("").to_string();
            listed.push((name, defaults.view(element, None)?));
        }
        Ok(Meshes { listed, compiler, folders, known: RefCell::default() })
    }

    fn find(&self, name: &str) -> Option<View<'a>> {
        self.listed.iter().find(|mesh| mesh.0 == name).map(|mesh| mesh.1)
    }

    /// The file of a mesh, as named in the description, and the scale of the mesh along x, y, z.
    pub(super) fn file(&self, name: &str) -> Result<(String, Vector3), String> {
        let view = self.find(name).ok_or_else(|| format!("there is no mesh `{}`", shown(name)))?;
        let file = view.get("file").ok_or_else(|| format!("the mesh `{}` has no file", shown(name)))?;
        let file = match Path::new(file).file_name() {
            Some(last) if self.compiler.strips_path => Path::new(last),
            _ => Path::new(file),
        };
        let path: PathBuf = Path::new(&self.compiler.mesh_folder).join(file);
        let scale = view.vector("scale").map_err(|e| e.message)?.unwrap_or([1.0; 3]);
        Ok((path.display().to_string(), scale))
    }

    /// The volume that a mesh encloses, in the axes of the mesh. Fails with the reason if it cannot be computed.
    pub(super) fn volume(&self, name: &str) -> Result<Volume, String> {
        let known = self.known.borrow().get(name).cloned();
        known.unwrap_or_else(|| {
            let found = self.enclosed(name);
            self.known.borrow_mut().insert(name.into(), found.clone());
            found
        })
    }

    fn enclosed(&self, name: &str) -> Result<Volume, String> {
        let view = self.find(name).ok_or_else(|| format!("there is no mesh `{}`", shown(name)))?;
        let how = match view.choice("inertia", &["legacy", "exact", "shell", "convex"]).map_err(|e| e.message)? {
            None | Some(0) => Enclosure::Legacy,
            Some(1) => Enclosure::Exact,
            Some(2) => Enclosure::Shell,
            _ => return Err(format!("the mesh `{}` weighs by its convex hull, which is not formed", shown(name))),
        };
        let triangles = match view.get("vertex") {
            Some(_) => inline(view).map_err(|e| e.message)?,
            None => self.triangles(name)?,
        };
        let place = |name| view.vector::<3>(name).map_err(|e| e.message);
        let (shift, scale) = (place("refpos")?.unwrap_or([0.0; 3]), place("scale")?.unwrap_or([1.0; 3]));
        let turn = match view.vector::<4>("refquat").map_err(|e| e.message)? {
            Some(quaternion) => Some(self.compiler.quaternion(view, quaternion).map_err(|e| e.message)?),
            None => None,
        };
        let moved = |p: Vector3| {
            let p = minus(p, shift);
            let p = turn.as_ref().map_or(p, |turn| turned_back(turn, p));
            [0, 1, 2].map(|i| scale[i] * p[i])
        };
        // A negative product of the scale factors means a reflection. A reflection turns the faces inward, so two corners of
        // each face are exchanged.
        let is_reflected = scale.iter().product::<f64>() < 0.0;
        let outward = |[a, b, c]: [Vector3; 3]| if is_reflected { [a, c, b] } else { [a, b, c] };
        let triangles: Vec<_> = triangles.iter().map(|corners| outward(corners.map(moved))).collect();
        enclosed(&triangles, how).map_err(|what| format!("the mesh `{}`: {what}", shown(name)))
    }

    fn triangles(&self, name: &str) -> Result<Vec<[Vector3; 3]>, String> {
        let (file, _) = self.file(name)?;
        let folder = self.folders.top.ok_or("what comes by standard input has no folder of meshes")?;
        mesh::check_format(Path::new(&file))?;
        let path = self.folders.find(folder, &file)?;
        let bytes = source::read(&path, MAX_MESH_BYTES).map_err(|e| format!("{file}: it cannot be read: {e}"))?;
        mesh::triangles(&bytes, Path::new(&file))
    }
}

/// The triangles of a `<mesh>` whose vertices are listed in the model instead of in a mesh file.
fn inline(view: View) -> Result<Vec<[Vector3; 3]>, Error> {
    const MAX_INLINE_NUMBERS: usize = 1_000_000;
    let flat = view.numbers("vertex", 3, MAX_INLINE_NUMBERS)?.unwrap_or_default();
    let vertices: Vec<Vector3> = flat.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect();
    let Some(faces) = view.numbers("face", 3, MAX_INLINE_NUMBERS)? else {
        return Err(view.element.error("a mesh without faces weighs by its convex hull, which is not formed"));
    };
    let corner = |k: &f64| vertices.get(*k as usize).copied().filter(|_| *k >= 0.0);
    let triangle = |f: &[f64]| Some([corner(&f[0])?, corner(&f[1])?, corner(&f[2])?]);
    let all: Option<Vec<_>> = faces.chunks_exact(3).map(triangle).collect();
    all.ok_or_else(|| view.element.error("a face of the mesh names a vertex that is none"))
}
