//! The arrays of a `.meshlet_mesh` file.

use std::io::Read;

use lz4_flex::frame::FrameDecoder;

/// Bytes before the LZ4 frame: magic number, version, box, depth of the tree.
pub const HEAD: usize = 44;
/// Most faces of a meshlet, by Bevy's processor.
const MOST_FACES: u8 = 128;

/// Arrays in the order of the file.
#[derive(Clone, Copy)]
pub enum Array {
    Positions,
    Normals,
    Uvs,
    Indices,
    Nodes,
    Meshlets,
    CullData,
}

/// Names and bytes per row.
const ARRAYS: [(&str, usize); 7] = [
    ("positions", 4),
    ("normals", 4),
    ("texture coordinates", 8),
    ("indices", 1),
    ("nodes", 400),
    ("meshlets", 32),
    ("cull data", 48),
];

/// A file after decompression.
pub struct Content {
    head: Vec<u8>,
    arrays: Vec<Vec<u8>>,
}

impl Content {
    /// Decompresses a file, which must end with its last array.
    ///
    /// # Errors
    /// Message about the part that is damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let (head, frame) = bytes.split_at_checked(HEAD).ok_or("shorter than a head")?;
        let mut content = Vec::new();
        FrameDecoder::new(frame).read_to_end(&mut content).map_err(|error| error.to_string())?;
        let mut rest = &content[..];
        let mut arrays = Vec::new();
        for (name, stride) in ARRAYS {
            let (count, after) = rest.split_first_chunk().ok_or_else(|| format!("no number of {name}"))?;
            let size = (u64::from_le_bytes(*count) as usize).checked_mul(stride);
            let array = size.and_then(|size| after.split_at_checked(size)).ok_or_else(|| format!("too few {name}"))?;
            arrays.push(array.0.to_vec());
            rest = array.1;
        }
        if !rest.is_empty() {
            return Err(format!("{} bytes after the last array", rest.len()));
        }
        Ok(Self { head: head.to_vec(), arrays })
    }

    /// Returns the name of the first part in which two files differ.
    pub fn find_difference(&self, other: &Self) -> Option<&'static str> {
        if self.head != other.head {
            return Some("bytes of the head");
        }
        let differs = |k: &usize| self.arrays[*k] != other.arrays[*k];
        (0..ARRAYS.len()).find(differs).map(|k| ARRAYS[k].0)
    }

    /// Returns the box of the mesh: centre and half of its size.
    pub fn bounds(&self) -> [f32; 6] {
        std::array::from_fn(|k| f32_at(&self.head, 16 + 4 * k))
    }

    /// Returns the stored number of levels of nodes.
    pub fn depth(&self) -> u32 {
        u32_at(&self.head, 40)
    }

    pub fn array(&self, array: Array) -> &[u8] {
        &self.arrays[array as usize]
    }

    /// Returns a row of an array.
    pub fn row(&self, array: Array, row: usize) -> &[u8] {
        let stride = ARRAYS[array as usize].1;
        &self.arrays[array as usize][stride * row..][..stride]
    }

    pub fn count(&self, array: Array) -> usize {
        self.arrays[array as usize].len() / ARRAYS[array as usize].1
    }

    pub fn n_meshlets(&self) -> usize {
        self.count(Array::Meshlets)
    }

    /// Checks that each meshlet refers to existing vertices and bits.
    ///
    /// # Errors
    /// Message about the first wrong meshlet.
    pub fn check_meshlets(&self) -> Result<(), String> {
        let n_vertices = self.count(Array::Normals);
        if self.count(Array::Uvs) != n_vertices || self.count(Array::CullData) != self.n_meshlets() {
            return Err("arrays of one kind have different lengths".to_string());
        }
        (0..self.n_meshlets()).try_for_each(|meshlet| {
            let row = Meshlet::new(self, meshlet);
            let n_bits = row.first_bit + row.n_vertices * row.bits.iter().map(|&bits| bits as usize).sum::<usize>();
            let corners = self.array(Array::Indices).get(row.first_corner..row.first_corner + 3 * row.n_faces);
            let corners = corners.ok_or_else(|| format!("meshlet {meshlet}: no corners"))?;
            let is_valid = (1..=usize::from(MOST_FACES)).contains(&row.n_faces)
                && corners.iter().all(|&corner| usize::from(corner) < row.n_vertices)
                && row.first_vertex + row.n_vertices <= n_vertices
                && n_bits <= 32 * self.count(Array::Positions)
                && row.bits.iter().all(|&bits| bits <= 32);
            is_valid.then_some(()).ok_or_else(|| format!("meshlet {meshlet}: beyond the arrays"))
        })
    }
}

/// A row of the array of meshlets.
pub struct Meshlet {
    first_bit: usize,
    first_vertex: usize,
    first_corner: usize,
    n_vertices: usize,
    n_faces: usize,
    /// Bits of each coordinate.
    bits: [u32; 3],
    /// Binary logarithm of the steps per hundredth of a unit.
    factor: u8,
    /// Least number of steps of each coordinate.
    least: [f32; 3],
}

impl Meshlet {
    pub fn new(content: &Content, meshlet: usize) -> Self {
        let row = content.row(Array::Meshlets, meshlet);
        Self {
            first_bit: u32_at(row, 0) as usize,
            first_vertex: u32_at(row, 4) as usize,
            first_corner: u32_at(row, 8) as usize,
            n_vertices: usize::from(row[12]) + 1,
            n_faces: usize::from(row[13]),
            bits: [row[16], row[17], row[18]].map(u32::from),
            factor: row[19],
            least: std::array::from_fn(|k| f32_at(row, 20 + 4 * k)),
        }
    }

    /// Returns the length of a step of the grid.
    pub fn step(&self) -> f32 {
        1.0 / ((1u32 << self.factor) as f32 * 100.0)
    }

    /// Returns the position of each corner of each face, in steps.
    pub fn faces(&self, content: &Content) -> Vec<[[i64; 3]; 3]> {
        let corners = &content.array(Array::Indices)[self.first_corner..][..3 * self.n_faces];
        let position = |corner: u8| self.position(content.array(Array::Positions), usize::from(corner));
        corners.as_chunks().0.iter().map(|face: &[u8; 3]| face.map(position)).collect()
    }

    /// Reads a position as Bevy's shaders do.
    fn position(&self, words: &[u8], vertex: usize) -> [i64; 3] {
        let mut at = self.first_bit + vertex * self.bits.iter().sum::<u32>() as usize;
        std::array::from_fn(|k| {
            let bit = |i: usize| u32_at(words, i / 32 * 4) >> (i % 32) & 1;
            let value = (0..self.bits[k]).map(|i| i64::from(bit(at + i as usize)) << i).sum::<i64>();
            at += self.bits[k] as usize;
            value + self.least[k] as i64
        })
    }
}

pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

pub fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(u32_at(bytes, at))
}
