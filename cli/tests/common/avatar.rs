//! A small skinned and animated glTF.

use neural_mesh::mesh::shapes;
use neural_mesh::picture::{Image, encode_png};
use serde_json::{Value, json};

pub struct Avatar {
    pub document: Value,
    pub buffer: Vec<u8>,
}

impl Avatar {
    pub fn new(side: usize) -> Self {
        let document = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
            "nodes": [
                {"mesh": 0, "skin": 0, "name": "body"}, {"mesh": 1, "translation": [3, 0, 0]},
                {"name": "hips", "children": [3]}, {"name": "spine", "translation": [0, 0.5, 0]},
            ],
            "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
            "textures": [{"source": 0}], "accessors": [], "bufferViews": [],
        });
        let mut it = Self { document, buffer: Vec::new() };
        let image = Image { width: side, height: side, rgba: noise(4 * side * side) };
        let view = it.view(&encode_png(&image));
        it.document["images"] = json!([{"name": "face", "bufferView": view, "mimeType": "image/png"}]);
        let ball = it.primitive(true);
        let plain = it.primitive(false);
        it.document["meshes"] =
            json!([{"name": "ball", "primitives": [ball]}, {"name": "plain", "primitives": [plain]}]);
        let bind = it.floats(
            &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(2),
            "MAT4",
        );
        it.document["skins"] = json!([{"joints": [2, 3], "inverseBindMatrices": bind}]);
        let (times, turns) = (it.floats(&[0.0, 1.5], "SCALAR"), it.floats(&[0.0, 0.5, 0.0, 0.0, 1.0, 0.0], "VEC3"));
        (it.document["accessors"][times]["min"], it.document["accessors"][times]["max"]) = (json!([0.0]), json!([1.5]));
        let channel = json!({"sampler": 0, "target": {"node": 3, "path": "translation"}});
        it.document["animations"] =
            json!([{"name": "nod", "samplers": [{"input": times, "output": turns}], "channels": [channel]}]);
        it
    }

    fn primitive(&mut self, is_bent: bool) -> Value {
        let (positions, faces) = shapes::wavy_sphere(3, 5.0).into_parts();
        let n = positions.len();
        let position = self.floats(positions.as_flattened(), "VEC3");
        let extreme =
            |fold: fn(f32, f32) -> f32| [0, 1, 2].map(|axis| positions.iter().map(|p| p[axis]).reduce(fold).unwrap());
        let [low, high] = [extreme(f32::min), extreme(f32::max)];
        (self.document["accessors"][position]["min"], self.document["accessors"][position]["max"]) =
            (json!(low), json!(high));
        let uv: Vec<f32> = positions.iter().flat_map(|p| [0.5 + 0.3 * p[0], 0.5 + 0.3 * p[1]]).collect();
        let uv = self.floats(&uv, "VEC2");
        let indices: Vec<u8> = faces.as_flattened().iter().flat_map(|i| (*i as u16).to_le_bytes()).collect();
        let indices = self.accessor(&indices, 5123, "SCALAR", 3 * faces.len());
        let mut primitive =
            json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv}, "indices": indices, "material": 0});
        if is_bent {
            let joints = self.accessor(&[0u8, 1, 0, 0].repeat(n), 5121, "VEC4", n);
            let weights: Vec<f32> =
                positions.iter().flat_map(|p| [0.5 - 0.4 * p[1], 0.5 + 0.4 * p[1], 0.0, 0.0]).collect();
            let moved: Vec<f32> = positions.iter().flat_map(|p| [0.0, 0.1 * p[0].max(0.0), 0.0]).collect();
            let (weights, moved) = (self.floats(&weights, "VEC4"), self.floats(&moved, "VEC3"));
            (self.document["accessors"][moved]["min"], self.document["accessors"][moved]["max"]) =
                (json!([0.0, 0.0, 0.0]), json!([0.0, 0.2, 0.0]));
            primitive["attributes"]["JOINTS_0"] = joints.into();
            primitive["attributes"]["WEIGHTS_0"] = weights.into();
            primitive["targets"] = json!([{"POSITION": moved}]);
        }
        primitive
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()});
        self.buffer.extend(bytes);
        let views = self.document["bufferViews"].as_array_mut().unwrap();
        views.push(view);
        views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize) -> usize {
        let accessor =
            json!({"bufferView": self.view(bytes), "componentType": component, "count": count, "type": shape});
        let accessors = self.document["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], shape: &str) -> usize {
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, shape, values.len() / width)
    }

    pub fn vrm_0(mut self) -> Self {
        self.document["extensionsUsed"] = json!(["VRM"]);
        self.document["extensions"]["VRM"] = json!({
            "specVersion": "0.0", "humanoid": {"humanBones": [{"bone": "hips", "node": 2}, {"bone": "spine", "node": 3}]},
            "meta": {"title": "ball", "texture": 0},
            "firstPerson": {"firstPersonBone": 3, "meshAnnotations": [{"mesh": 0, "firstPersonFlag": "Both"}]},
            "blendShapeMaster": {"blendShapeGroups": [
                {"name": "joy", "presetName": "joy", "binds": [{"mesh": 0, "index": 0, "weight": 100}], "materialValues": []},
            ]},
            "secondaryAnimation": {"boneGroups": [{"bones": [3], "colliderGroups": [0]}], "colliderGroups": [
                {"node": 2, "colliders": [{"offset": {"x": 0, "y": 0, "z": 0}, "radius": 0.1}]},
            ]},
            "materialProperties": [{"name": "skin", "shader": "VRM/MToon", "textureProperties": {"_MainTex": 0}}],
        });
        self
    }

    pub fn vrm_1(mut self) -> Self {
        self.document["extensionsUsed"] =
            json!(["VRMC_vrm", "VRMC_springBone", "VRMC_node_constraint", "VRMC_materials_mtoon"]);
        let binds = json!([{"node": 0, "index": 0, "weight": 1.0}, {"node": 1, "index": 0, "weight": 1.0}]);
        self.document["extensions"] = json!({
            "VRMC_vrm": {
                "specVersion": "1.0", "meta": {"name": "ball", "thumbnailImage": 0},
                "humanoid": {"humanBones": {"hips": {"node": 2}, "spine": {"node": 3}}},
                "firstPerson": {"meshAnnotations": [{"node": 0, "type": "both"}, {"node": 1, "type": "auto"}]},
                "expressions": {"preset": {"happy": {"morphTargetBinds": binds}}},
            },
            "VRMC_springBone": {
                "specVersion": "1.0", "colliders": [{"node": 2, "shape": {"sphere": {"radius": 0.1}}}],
                "springs": [{"joints": [{"node": 2}, {"node": 3}]}],
            },
        });
        let constraint = json!({"specVersion": "1.0", "constraint": {"rotation": {"source": 2}}});
        self.document["nodes"][3]["extensions"]["VRMC_node_constraint"] = constraint;
        self.document["materials"][0]["extensions"]["VRMC_materials_mtoon"] =
            json!({"specVersion": "1.0", "shadeMultiplyTexture": {"index": 0}});
        self
    }

    pub fn glb(mut self) -> Vec<u8> {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.document["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        let mut json = serde_json::to_vec(&self.document).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunk = |kind: &[u8], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), kind, bytes].concat();
        let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &self.buffer)].concat();
        [&b"glTF\x02\0\0\0"[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
    }
}

pub fn document(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(*glb[12..].first_chunk().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

fn noise(n: usize) -> Vec<u8> {
    let mut state = 1u32;
    let mut next = |at: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if at % 4 == 3 { u8::MAX } else { (state >> 24) as u8 }
    };
    (0..n).map(&mut next).collect()
}
