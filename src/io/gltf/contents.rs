//! What an asset holds beside the shapes of its meshes, by name: for lists.

use std::collections::BTreeSet;

use serde_json::Value;

use super::asset::Asset;
use super::references::index;

/// What an asset lists; what has no name is called after its kind and number, as `material 2`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AssetContents {
    /// The program that wrote it, where it says so.
    pub generator: Option<String>,
    /// Number of scenes.
    pub n_scenes: usize,
    /// Number of nodes, and so of places.
    pub n_nodes: usize,
    /// Number of cameras.
    pub n_cameras: usize,
    /// For each of [`Asset::parts`] the names of the nodes that hold it.
    pub nodes_of_parts: Vec<Vec<String>>,
    /// For each node its name and which of [`Asset::parts`] it and the nodes below it hold, ascending.
    pub parts_of_nodes: Vec<(String, Vec<usize>)>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// Names of images, whose bytes [`Asset::image`] gives.
    pub images: Vec<String>,
    /// Names of skins, and how many joints they have.
    pub skins: Vec<(String, usize)>,
    /// Names of animations, and how many seconds they take.
    pub animations: Vec<(String, f64)>,
    /// Names of extensions that it uses.
    pub extensions_used: Vec<String>,
    /// Those among them without which it is not what it is.
    pub extensions_required: Vec<String>,
}

impl Asset {
    /// Lists what the asset holds.
    ///
    /// ```
    /// use neural_mesh::io::Asset;
    /// let text = br#"{"asset": {"version": "2.0"}, "materials": [{"name": "red"}, {}], "extensionsUsed": ["KHR_materials_unlit"]}"#;
    /// let contents = Asset::from_stream(text).unwrap().contents();
    /// assert_eq!(contents.materials, ["red", "material 1"]);
    /// assert_eq!(contents.extensions_used, ["KHR_materials_unlit"]);
    /// ```
    pub fn contents(&self) -> AssetContents {
        let list = |name: &str| self.document.get(name).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let texts = |name: &str| list(name).iter().filter_map(Value::as_str).map(String::from).collect();
        let nodes = names(list("nodes"), "node");
        let holders = |mesh: &usize| {
            let all = list("nodes").iter().zip(&nodes);
            let holds = |node: &Value| node.get("mesh").and_then(index) == Some(*mesh);
            all.filter(|(node, _)| holds(node)).map(|(_, name)| name.clone()).collect()
        };
        let joints = list("skins").iter().map(|skin| skin["joints"].as_array().map_or(0, Vec::len));
        let seconds = list("animations").iter().map(|animation| self.seconds(animation));
        AssetContents {
            generator: self.document["asset"]["generator"].as_str().map(String::from),
            n_scenes: list("scenes").len(),
            n_nodes: nodes.len(),
            n_cameras: list("cameras").len(),
            nodes_of_parts: self.meshes.iter().map(holders).collect(),
            parts_of_nodes: nodes.into_iter().zip(self.parts_below(list("nodes"))).collect(),
            materials: names(list("materials"), "material"),
            images: names(list("images"), "image"),
            skins: names(list("skins"), "skin").into_iter().zip(joints).collect(),
            animations: names(list("animations"), "animation").into_iter().zip(seconds).collect(),
            extensions_used: texts("extensionsUsed"),
            extensions_required: texts("extensionsRequired"),
        }
    }

    /// The bytes of an image's file, wherever they are; `None` where they cannot be had.
    ///
    /// ```
    /// use neural_mesh::io::Asset;
    /// let text = br#"{"asset": {"version": "2.0"}, "images": [{"uri": "data:image/png;base64,AQID"}]}"#;
    /// assert_eq!(Asset::from_stream(text).unwrap().image(0), Some(vec![1, 2, 3]));
    /// ```
    pub fn image(&self, at: usize) -> Option<Vec<u8>> {
        self.bytes_of_image(at)
    }

    /// Returns which parts each node and the nodes below it hold, ascending, n_nodes.
    fn parts_below(&self, nodes: &[Value]) -> Vec<Vec<usize>> {
        let part = |node: &Value| {
            let mesh = node.get("mesh").and_then(index)?;
            self.meshes.iter().position(|&of_part| of_part == mesh)
        };
        let below = |node: usize| {
            let (mut open, mut visited, mut parts) = (vec![node], BTreeSet::new(), BTreeSet::new());
            while let Some(node) = open.pop() {
                // A file may say that a node is below itself.
                let Some(value) = nodes.get(node).filter(|_| visited.insert(node)) else { continue };
                parts.extend(part(value));
                open.extend(value["children"].as_array().into_iter().flatten().filter_map(index));
            }
            parts.into_iter().collect()
        };
        (0..nodes.len()).map(below).collect()
    }

    /// The last moment that an animation names.
    fn seconds(&self, animation: &Value) -> f64 {
        let inputs = animation["samplers"].as_array().into_iter().flatten();
        let ends = inputs.filter_map(|sampler| {
            let accessor = self.document.get("accessors")?.get(sampler.get("input").and_then(index)?)?;
            accessor["max"].get(0)?.as_f64()
        });
        ends.fold(0.0, f64::max)
    }
}

/// The name of each, or its kind and number; of an image without a name its file.
fn names(list: &[Value], kind: &str) -> Vec<String> {
    let of_file = |it: &Value| it["uri"].as_str().filter(|uri| !uri.starts_with("data:")).map(String::from);
    let named = |it: &Value| it["name"].as_str().filter(|name| !name.is_empty()).map(String::from);
    list.iter()
        .zip(0..)
        .map(|(it, at)| named(it).or_else(|| of_file(it)).unwrap_or_else(|| format!("{kind} {at}")))
        .collect()
}
