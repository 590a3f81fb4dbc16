//! Contents of an asset by name.

use std::collections::BTreeSet;

use serde_json::Value;

use super::asset::Asset;
use super::references::{index, list};

/// Contents of an asset; unnamed items are called like `material 2`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct AssetContents {
    /// Program that wrote the asset.
    pub generator: Option<String>,
    /// Number of scenes.
    pub n_scenes: usize,
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of cameras.
    pub n_cameras: usize,
    /// Names of the nodes that show each of [`Asset::parts`].
    pub nodes_of_parts: Vec<Vec<String>>,
    /// Name of each node, and whether it or a descendant shows one of the [`Asset::parts`].
    pub nodes: Vec<(String, bool)>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// Names of images.
    pub images: Vec<String>,
    /// Names of skins, and their numbers of joints.
    pub skins: Vec<(String, usize)>,
    /// Names of animations, and their durations in seconds.
    pub animations: Vec<(String, f64)>,
    /// Names of used extensions.
    pub extensions_used: Vec<String>,
    /// Names of required extensions.
    pub extensions_required: Vec<String>,
}

impl Asset {
    /// Lists the contents of the asset.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let text = br#"{"asset": {"version": "2.0"}, "materials": [{"name": "red"}, {}], "extensionsUsed": ["KHR_materials_unlit"]}"#;
    /// let contents = Asset::from_stream(text).unwrap().contents();
    /// assert_eq!(contents.materials, ["red", "material 1"]);
    /// assert_eq!(contents.extensions_used, ["KHR_materials_unlit"]);
    /// ```
    pub fn contents(&self) -> AssetContents {
        let all = |name: &str| list(&self.document, name);
        let texts = |name: &str| all(name).iter().filter_map(Value::as_str).map(String::from).collect();
        // The raw document has all items, unlike the parsed one.
        let nodes = item_names(all("nodes"), "node");
        let mut nodes_of_parts = vec![Vec::new(); self.meshes.len()];
        for (part, name) in all("nodes").iter().map(|node| self.part_of_node(node)).zip(&nodes) {
            part.into_iter().for_each(|part| nodes_of_parts[part].push(name.clone()));
        }
        let joints = all("skins").iter().map(|skin| list(skin, "joints").len());
        let seconds = all("animations").iter().map(|animation| self.duration(animation));
        AssetContents {
            generator: self.document["asset"]["generator"].as_str().map(String::from),
            n_scenes: all("scenes").len(),
            n_nodes: nodes.len(),
            n_cameras: all("cameras").len(),
            nodes_of_parts,
            nodes: nodes.into_iter().zip(self.nodes_with_parts(all("nodes"))).collect(),
            materials: item_names(all("materials"), "material"),
            images: item_names(all("images"), "image"),
            skins: item_names(all("skins"), "skin").into_iter().zip(joints).collect(),
            animations: item_names(all("animations"), "animation").into_iter().zip(seconds).collect(),
            extensions_used: texts("extensionsUsed"),
            extensions_required: texts("extensionsRequired"),
        }
    }

    /// Returns the bytes of an image, or `None` if they are missing.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let text = br#"{"asset": {"version": "2.0"}, "images": [{"uri": "data:image/png;base64,AQID"}]}"#;
    /// assert_eq!(Asset::from_stream(text).unwrap().image(0), Some(vec![1, 2, 3]));
    /// ```
    pub fn image(&self, at: usize) -> Option<Vec<u8>> {
        self.bytes_of_image(at)
    }

    /// Returns the indices of the [`Asset::parts`] that the nodes called `name` and their descendants show.
    ///
    /// ```
    /// # use neural_mesh_io as neural_mesh;
    /// use neural_mesh::io::Asset;
    /// let asset = Asset::read_path("../../tests/meshes/tiny/tetrahedron.glb".as_ref()).unwrap();
    /// let (name, has_parts) = &asset.contents().nodes[0];
    /// assert_eq!((*has_parts, asset.parts_below(name)), (true, vec![0]));
    /// ```
    pub fn parts_below(&self, name: &str) -> Vec<usize> {
        let nodes = list(&self.document, "nodes");
        let names = item_names(nodes, "node");
        let mut open: Vec<usize> = (0..nodes.len()).filter(|&node| names[node] == name).collect();
        let (mut visited, mut parts) = (vec![false; nodes.len()], BTreeSet::new());
        while let Some(node) = open.pop() {
            // A broken file may contain cycles and nodes that do not exist.
            if visited.get(node) == Some(&false) {
                visited[node] = true;
                parts.extend(self.part_of_node(&nodes[node]));
                open.extend(children(&nodes[node]));
            }
        }
        parts.into_iter().collect()
    }

    /// Returns whether each node or a descendant shows a part.
    fn nodes_with_parts(&self, nodes: &[Value]) -> Vec<bool> {
        let mut parents = vec![Vec::new(); nodes.len()];
        for (at, node) in nodes.iter().enumerate() {
            for child in children(node) {
                parents.get_mut(child).into_iter().for_each(|parents: &mut Vec<usize>| parents.push(at));
            }
        }
        let mut has_parts = vec![false; nodes.len()];
        let mut open: Vec<usize> = (0..nodes.len()).filter(|&at| self.part_of_node(&nodes[at]).is_some()).collect();
        while let Some(node) = open.pop() {
            if !std::mem::replace(&mut has_parts[node], true) {
                open.extend(&parents[node]);
            }
        }
        has_parts
    }

    fn part_of_node(&self, node: &Value) -> Option<usize> {
        // Mesh indices of the parts are ascending.
        self.meshes.binary_search(&node.get("mesh").and_then(index)?).ok()
    }

    fn duration(&self, animation: &Value) -> f64 {
        let inputs = list(animation, "samplers").iter();
        let ends = inputs.filter_map(|sampler| {
            let accessor = self.document.get("accessors")?.get(sampler.get("input").and_then(index)?)?;
            accessor["max"].get(0)?.as_f64()
        });
        ends.fold(0.0, f64::max)
    }
}

fn children(node: &Value) -> impl Iterator<Item = usize> {
    list(node, "children").iter().filter_map(index)
}

fn item_names(list: &[Value], kind: &str) -> Vec<String> {
    let of_file = |it: &Value| it["uri"].as_str().filter(|uri| !uri.starts_with("data:")).map(String::from);
    let named = |it: &Value| it["name"].as_str().filter(|name| !name.is_empty()).map(String::from);
    list.iter()
        .zip(0..)
        .map(|(it, at)| named(it).or_else(|| of_file(it)).unwrap_or_else(|| format!("{kind} {at}")))
        .collect()
}
