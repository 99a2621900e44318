//! Reads the vertices of a Collada file (.dae), at the positions that the scene of the file gives them.
//!
//! A point p of a geometry is placed at meter T_1 .. T_n p. T_k: transforms of the nodes above the geometry, from the root;
//! meter: unit of the file, m. A geometry with two instances occurs twice. If the file has no scene, there are no transforms.
//!
//! The axes of the file are used as the axes of the link, and `up_axis` is ignored: RViz, MoveIt and coal also place URDF meshes
//! in this way. Only points of faces are used, not unused points or points of lines. If a geometry has no faces, all its points
//! are used.
//!
//! Refused: skinned shapes, `lookat`, `skew`, and references to another file. Ignored: faces and materials.

use std::collections::HashMap;

use roxmltree::{Document, Node, ParsingOptions};

use robot::vector::Vector3;
use robot::xml_bounds::{MAX_ATTRIBUTES_PER_ELEMENT, MAX_XML_NODES, crowded};

/// Largest depth of nested nodes and of nested instances of nodes.
const MAX_NODE_DEPTH: usize = 64;
/// Largest number of instances of nodes and geometries. Without it, a chain of nodes with two instances each would give an
/// endless number.
const MAX_INSTANCES: usize = 10_000;
/// Largest number of points of all instances together.
const MAX_POINTS: usize = 20_000_000;

/// A linear map (rotation and scale), and a translation.
type Transform = ([[f64; 3]; 3], Vector3);

const IDENTITY: Transform = ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0; 3]);

/// Reads the vertices of a file (m) in the frame of the link that has the mesh.
///
/// Fails if it is no Collada file, or has elements that are not supported.
pub(crate) fn vertices(bytes: &[u8]) -> Result<Vec<Vector3>, String> {
    let text = std::str::from_utf8(bytes).map_err(|e| format!("no Collada: {e}"))?;
    if let Some((line, _)) = crowded(text) {
        return Err(format!("line {line}: an element has more than {MAX_ATTRIBUTES_PER_ELEMENT} attributes"));
    }
    let options = ParsingOptions { nodes_limit: MAX_XML_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| format!("no Collada: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err("no Collada: its first element is another than <COLLADA>".into());
    }
    // The unit of the file in metres.
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let meter = match unit.and_then(|unit| Some((unit, unit.attribute("meter")?))) {
        Some((unit, text)) => {
            let meter = text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
            meter.ok_or_else(|| at(unit, format!("a unit of `{text}` m; expected is a positive number")))?
        }
        None => 1.0,
    };
    // For each id in the file, the element with this id.
    let mut ids = HashMap::new();
    for node in root.descendants().filter(Node::is_element) {
        if let Some(id) = node.attribute("id") {
            ids.entry(id).or_insert(node);
        }
    }
    let mut found = ColladaTriangles { ids, instances: 0, points: vec![] };
    // If the file has no scene, all its geometries are used.
    match scene(&found, root)? {
        Some(scene) => found.of_node(scene, IDENTITY, 0)?,
        None => {
            let geometries = root.descendants().filter(|n| n.tag_name().name() == "geometry");
            geometries.into_iter().try_for_each(|geometry| found.of_geometry(geometry, IDENTITY))?;
        }
    }
    Ok(found.points.into_iter().map(|p| p.map(|x| meter * x)).collect())
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.tag_name().name() == tag)
}

fn at(node: Node, what: String) -> String {
    format!("line {}: {what}", node.document().text_pos_at(node.range().start).row)
}

/// The scene that the file selects, otherwise its first scene. `None` if the file has no scene.
fn scene<'a, 'i>(found: &ColladaTriangles<'a, 'i>, root: Node<'a, 'i>) -> Result<Option<Node<'a, 'i>>, String> {
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    match shown {
        Some(shown) => found.target(shown, "url").map(Some),
        None => Ok(child(root, "library_visual_scenes").and_then(|library| child(library, "visual_scene"))),
    }
}

struct ColladaTriangles<'a, 'i> {
    ids: HashMap<&'a str, Node<'a, 'i>>,
    instances: usize,
    points: Vec<Vector3>,
}

impl<'a, 'i> ColladaTriangles<'a, 'i> {
    /// The element to which an attribute of the form `#id` refers.
    fn target(&self, node: Node<'a, 'i>, attribute: &str) -> Result<Node<'a, 'i>, String> {
        let tag = node.tag_name().name();
        let url = node.attribute(attribute).unwrap_or("");
        let id = url.strip_prefix('#').ok_or_else(|| {
            at(node, format!("<{tag}> has {attribute}=`{url}`; read is what stands in the same file, as `#ID`"))
        })?;
        self.ids.get(id).copied().ok_or_else(|| at(node, format!("<{tag}>: there is no element with the id `{id}`")))
    }

    fn of_node(&mut self, node: Node<'a, 'i>, above: Transform, depth: usize) -> Result<(), String> {
        self.instances += 1;
        if depth > MAX_NODE_DEPTH || self.instances > MAX_INSTANCES {
            let what = format!("more than {MAX_NODE_DEPTH} nodes within each other, or {MAX_INSTANCES} in all");
            return Err(at(node, what));
        }
        let mut here = above;
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "matrix" | "translate" | "rotate" | "scale" => here = composed(here, transform(part)?),
                other @ ("lookat" | "skew") => return Err(at(part, format!("<{other}> is not read"))),
                "node" => self.of_node(part, here, depth + 1)?,
                "instance_node" => self.of_node(self.target(part, "url")?, here, depth + 1)?,
                "instance_geometry" => self.of_geometry(self.target(part, "url")?, here)?,
                "instance_controller" => return Err(at(part, "a shape with a skin is not read".into())),
                _ => {}
            }
        }
        Ok(())
    }

    fn of_geometry(&mut self, geometry: Node<'a, 'i>, here: Transform) -> Result<(), String> {
        self.instances += 1;
        let Some(mesh) = child(geometry, "mesh") else {
            return Err(at(geometry, "a <geometry> without <mesh> is not read".into()));
        };
        let vertices = child(mesh, "vertices").ok_or_else(|| at(mesh, "<mesh> has no <vertices>".into()))?;
        let is_position = |n: &Node| n.tag_name().name() == "input" && n.attribute("semantic") == Some("POSITION");
        let input = vertices.children().find(is_position);
        let input = input.ok_or_else(|| at(vertices, "<vertices> has no input of POSITION".into()))?;
        let points = of_faces(mesh, positions(self.target(input, "source")?)?)?;
        if self.instances > MAX_INSTANCES || self.points.len() + points.len() > MAX_POINTS {
            return Err(at(geometry, format!("more than {MAX_INSTANCES} instances, or {MAX_POINTS} points")));
        }
        self.points.extend(points.into_iter().map(|p| placed(here, p)));
        Ok(())
    }
}

/// Names of the elements of a mesh that contain faces.
const FACE_ELEMENTS: [&str; 5] = ["triangles", "polylist", "polygons", "tristrips", "trifans"];

/// The points that faces use; all points if there are no faces.
fn of_faces(mesh: Node, points: Vec<Vector3>) -> Result<Vec<Vector3>, String> {
    let mut is_used = vec![false; points.len()];
    for faces in mesh.children().filter(|n| FACE_ELEMENTS.contains(&n.tag_name().name())) {
        let (mut of_vertex, mut stride) = (None, 0);
        for input in faces.children().filter(|n| n.tag_name().name() == "input") {
            let offset: usize = match input.attribute("offset").unwrap_or("0").trim().parse() {
                Ok(offset) if offset < MAX_INPUTS => offset,
                _ => return Err(at(input, "the offset of an input is no number below 64".into())),
            };
            stride = stride.max(offset + 1);
            if input.attribute("semantic") == Some("VERTEX") {
                of_vertex = Some(offset);
            }
        }
        let Some(of_vertex) = of_vertex else {
            return Err(at(faces, format!("<{}> has no input of VERTEX", faces.tag_name().name())));
        };
        for corners in faces.descendants().filter(|n| n.tag_name().name() == "p") {
            for word in corners.text().unwrap_or("").split_whitespace().skip(of_vertex).step_by(stride) {
                let used = word.parse().ok().and_then(|index: usize| is_used.get_mut(index));
                *used.ok_or_else(|| at(corners, format!("there is no vertex `{word}`, of {}", points.len())))? = true;
            }
        }
    }
    let has_faces = is_used.contains(&true);
    Ok(points.into_iter().zip(is_used).filter(|(_, is_used)| *is_used || !has_faces).map(|(p, _)| p).collect())
}

/// Largest number of inputs (indices per corner of a face, for example of position and normal).
const MAX_INPUTS: usize = 64;

/// The points of an element <source>. The accessor of the element states which numbers belong to a point.
fn positions(source: Node) -> Result<Vec<Vector3>, String> {
    let array = child(source, "float_array");
    let array = array.ok_or_else(|| at(source, "the <source> of positions has no <float_array>".into()))?;
    let numbers = numbers(array)?;
    let accessor = child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
    let whole = |name: &str, otherwise: usize| match accessor.and_then(|a| a.attribute(name)) {
        Some(text) => text.trim().parse().map_err(|_| at(source, format!("the accessor's {name} is `{text}`"))),
        None => Ok(otherwise),
    };
    let (stride, offset) = (whole("stride", 3)?, whole("offset", 0)?);
    let named = accessor.map_or(0, |a| a.children().filter(|n| n.tag_name().name() == "param").count());
    if stride < 3 || (named > 0 && named < 3) {
        return Err(at(source, format!("its positions have {} numbers each; expected are three", stride.min(named))));
    }
    let rest = numbers.get(offset..).unwrap_or_default();
    let most = rest.len().div_ceil(stride);
    let count = whole("count", most)?;
    // The last point may have fewer numbers than the stride (numbers per point): three are enough.
    let all: Vec<Vector3> = rest.chunks(stride).take(count).map_while(|p| p.first_chunk().copied()).collect();
    if all.len() < count {
        return Err(at(source, format!("{count} points are promised, and {} are there", all.len())));
    }
    Ok(all)
}

/// The numbers in the text of an element.
fn numbers(node: Node) -> Result<Vec<f64>, String> {
    let text = node.text().unwrap_or("");
    let one = |word: &str| {
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| at(node, format!("<{}>: `{word}` is no number", node.tag_name().name())))
    };
    text.split_whitespace().map(one).collect()
}

fn transform(node: Node) -> Result<Transform, String> {
    let x = numbers(node)?;
    let expected = |count: usize| {
        let tag = node.tag_name().name();
        at(node, format!("<{tag}> has {} numbers; expected are {count}", x.len()))
    };
    match (node.tag_name().name(), &x[..]) {
        ("translate", &[a, b, c]) => Ok((IDENTITY.0, [a, b, c])),
        ("scale", &[a, b, c]) => Ok(([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]], [0.0; 3])),
        ("rotate", &[a, b, c, degrees]) => {
            let length = (a * a + b * b + c * c).sqrt();
            if length == 0.0 {
                return if degrees == 0.0 { Ok(IDENTITY) } else { Err(at(node, "<rotate> has no axis".into())) };
            }
            let (u, (sine, cosine)) = ([a, b, c].map(|x| x / length), degrees.to_radians().sin_cos());
            // Rodrigues' rotation formula.
            let skew = [[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]];
            let entry = |i: usize, j: usize| {
                let one = if i == j { cosine } else { 0.0 };
                one + (1.0 - cosine) * u[i] * u[j] + sine * skew[i][j]
            };
            Ok((std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))), [0.0; 3]))
        }
        ("matrix", x) if x.len() == 16 => {
            if x[12..] != [0.0, 0.0, 0.0, 1.0] {
                return Err(at(node, "the last row of a <matrix> is another than 0 0 0 1".into()));
            }
            let turn = std::array::from_fn(|i| std::array::from_fn(|j| x[4 * i + j]));
            Ok((turn, std::array::from_fn(|i| x[4 * i + 3])))
        }
        ("matrix", _) => Err(expected(16)),
        ("rotate", _) => Err(expected(4)),
        _ => Err(expected(3)),
    }
}

fn placed((turn, shift): Transform, p: Vector3) -> Vector3 {
    std::array::from_fn(|i| shift[i] + (0..3).map(|j| turn[i][j] * p[j]).sum::<f64>())
}

fn composed(a: Transform, b: Transform) -> Transform {
    let entry = |i: usize, j: usize| (0..3).map(|k| a.0[i][k] * b.0[k][j]).sum();
    (std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))), placed(a, b.1))
}

#[cfg(test)]
mod tests {
    use super::vertices;

    /// A triangle in cm, rotated, shifted and with two instances; and a line, which is ignored. `up_axis` is y.
    const FILE: &str = r##"<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="centimeter" meter="0.01"/><up_axis>Y_UP</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="12">1 0 0  0 1 0  0 0 1  9 9 9</float_array>
      <technique_common><accessor source="#a" count="4" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="1"><input semantic="NORMAL" source="#p" offset="0"/><input semantic="VERTEX" source="#v" offset="1"/>
      <p>9 0 9 1 9 2</p></triangles>
    <lines count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 3</p></lines>
  </mesh></geometry></library_geometries>
  <library_nodes><node id="twice"><translate>0 0 10</translate><instance_geometry url="#g"/></node></library_nodes>
  <library_visual_scenes><visual_scene id="s">
    <node><matrix>1 0 0 100  0 1 0 0  0 0 1 0  0 0 0 1</matrix><rotate>0 0 2 90</rotate><scale>2 2 2</scale>
      <instance_geometry url="#g"/><node><instance_node url="#twice"/></node></node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>"##;

    fn near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
        assert_eq!(found.len(), expected.len());
        let off = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        // Tolerance for sums of a few products of numbers below 2.
        assert!(off.fold(0.0, f64::max) < 1e-15, "{found:?}");
    }

    #[test]
    fn meshes_are_read_by_their_extension() {
        rist::wings::register(vec![crate::wing()]);
        let read = |bytes: &[u8]| robot::mesh::vertices(bytes, std::path::Path::new("tool.DAE"));
        assert_eq!(read(FILE.as_bytes()), vertices(FILE.as_bytes()));
        assert!(read(b"").unwrap_err().starts_with("tool.DAE: no Collada"));
    }

    #[test]
    fn points_stand_where_the_scene_puts_them() {
        // The triangle is rotated by a quarter turn (x to y, y to -x), scaled by two, and moved by 1 m. The second instance is 20
        // cm higher.
        let lower = [[1.0, 0.02, 0.0], [0.98, 0.0, 0.0], [1.0, 0.0, 0.02]];
        let upper = lower.map(|[x, y, z]| [x, y, z + 0.2]);
        near(&vertices(FILE.as_bytes()).unwrap(), &[lower, upper].concat());
        // Another `up_axis` does not change the points.
        let other = FILE.replace("Y_UP", "Z_UP");
        assert_eq!(vertices(other.as_bytes()), vertices(FILE.as_bytes()));
        // Without a scene and a unit, the coordinates of the file are used, in m.
        let start = FILE.find("<library_nodes>").unwrap();
        let bare = format!("{}</COLLADA>", &FILE[..start]).replace("<unit name=\"centimeter\" meter=\"0.01\"/>", "");
        near(&vertices(bare.as_bytes()).unwrap(), &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        // The list of numbers may contain other numbers between the points (`stride`) and before them (`offset`).
        let apart = bare.replace("1 0 0  0 1 0  0 0 1  9 9 9", "9 1 0 0 7  0 1 0 7  0 0 1 7 9 9 9");
        let apart = apart.replace("stride=\"3\"", "stride=\"4\" offset=\"1\"");
        near(&vertices(apart.as_bytes()).unwrap(), &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn what_is_not_read_is_said() {
        for (from, to, said) in [
            ("<COLLADA", "<COLLADA <", "no Collada"),
            ("meter=\"0.01\"", "meter=\"-1\"", "line 3: a unit of `-1` m; expected is a positive number"),
            ("9 9 9</float", "9 9 x</float", "line 5: <float_array>: `x` is no number"),
            ("9 9 9</float", "9 9</float", "line 5: 4 points are promised, and 3 are there"),
            ("stride=\"3\"", "stride=\"2\"", "line 5: its positions have 2 numbers each"),
            ("stride=\"3\"", "stride=\"-3\"", "line 5: the accessor's stride is `-3`"),
            ("\"POSITION\"", "\"NORMAL\"", "line 7: <vertices> has no input of POSITION"),
            ("\"VERTEX\"", "\"TANGENT\"", "line 8: <triangles> has no input of VERTEX"),
            ("offset=\"1\"", "offset=\"-1\"", "line 8: the offset of an input is no number below 64"),
            ("9 1 9 2", "9 1 9 4", "line 9: there is no vertex `4`, of 4"),
            ("<scale>2 2 2", "<scale>2 2", "line 14: <scale> has 2 numbers; expected are 3"),
            ("0 0 0 1</matrix>", "0 0 1 1</matrix>", "line 14: the last row of a <matrix>"),
            ("<scale>2 2 2</scale>", "<skew>1 2 3 4 5 6 7</skew>", "line 14: <skew> is not read"),
            ("0 0 2 90", "0 0 0 90", "line 14: <rotate> has no axis"),
            ("instance_geometry url=\"#g\"/><node>", "instance_controller/><node>", "line 15: a shape with a skin"),
            ("url=\"#twice\"", "url=\"other.dae#x\"", "line 15: <instance_node> has url=`other.dae#x`; read is what"),
            ("url=\"#s\"", "url=\"#t\"", "line 17: <instance_visual_scene>: there is no element with the id `t`"),
            // A node that contains an instance of itself.
            ("<translate>0 0 10</translate>", "<instance_node url=\"#twice\"/>", "line 12: more than 64 nodes"),
        ] {
            assert!(FILE.contains(from), "{from}");
            let error = vertices(FILE.replacen(from, to, 1).as_bytes()).unwrap_err();
            assert!(error.contains(said), "{to}: {error}");
        }
    }

    /// If each node has two instances of the next, their number doubles at each level. Such a file is refused early.
    #[test]
    fn instances_do_not_multiply_without_end() {
        let level = |k: usize| {
            let twice = format!("<instance_node url=\"#n{}\"/>", k + 1).repeat(2);
            format!("<node id=\"n{k}\">{twice}</node>")
        };
        let levels: String = (0..40).map(level).collect();
        let text = format!(
            "<COLLADA><library_nodes>{levels}<node id=\"n40\"/></library_nodes><library_visual_scenes><visual_scene>\
             <instance_node url=\"#n0\"/></visual_scene></library_visual_scenes></COLLADA>"
        );
        assert!(vertices(text.as_bytes()).unwrap_err().contains("10000 in all"));
    }
}
