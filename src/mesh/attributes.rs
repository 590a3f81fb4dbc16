//! What the corners of a mesh carry beside their positions: texture coordinates, normals, colours, skins, materials.
//!
//! Corners of faces that carry the same values share a *wedge* (Hoppe 1999, "New quadric metric for simplifying meshes with
//! appearance attributes"). Around most vertices there is one wedge; at a seam there are more. So a seam is no boundary: the
//! faces on both sides share vertices, and differ in their wedges.

/// What a channel means, which decides how its values are blended and when two of them are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// Unit normals, width 3.
    Normal,
    /// Unit tangents and the sign of the bitangent, width 4.
    Tangent,
    /// Texture coordinates, width 2.
    Uv,
    /// Colours, linear or not as the file has them, width 3 or 4.
    Colour,
    /// Joints of a skin and their weights: first all joints (indices), then as many weights.
    Skin,
    /// How far a morph target moves the position, width 3.
    MorphPosition,
    /// By how much a morph target changes the normal or tangent, width 3.
    MorphDirection,
    /// Anything else that is a number and may be blended.
    Other,
    /// A whole number that names something, as the label of a segmentation does: taken from what is nearest, not blended.
    Label,
}

/// One kind of value at all wedges.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name in the file: `TEXCOORD_0`, `confidence`.
    pub name: String,
    /// What it means.
    pub role: Role,
    /// Numbers per wedge.
    pub width: usize,
    /// The values, n_wedges x width.
    pub values: Vec<f32>,
}

impl Channel {
    /// The values of a wedge.
    pub fn of(&self, wedge: u32) -> &[f32] {
        &self.values[wedge as usize * self.width..][..self.width]
    }
}

/// What the corners and faces of a mesh carry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// The wedge of each corner, n_faces x 3; empty where there are no channels.
    pub wedges: Vec<[u32; 3]>,
    /// Values at the wedges.
    pub channels: Vec<Channel>,
    /// The material, primitive or group of each face, n_faces; empty where all faces are of one.
    pub groups: Vec<u32>,
}

impl Attributes {
    /// What a bare mesh carries.
    pub const NONE: &'static Self = &Self { wedges: Vec::new(), channels: Vec::new(), groups: Vec::new() };

    /// Whether nothing is carried.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.groups.is_empty()
    }

    /// What is left with the channels of these roles alone, and with groups or without.
    ///
    /// ```
    /// use neural_mesh::mesh::{Attributes, Channel, Role};
    /// let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: vec![0.0; 6] };
    /// let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![uv], groups: vec![7] };
    /// assert_eq!(attributes.clone().only(|role| role == Role::Uv, true), attributes);
    /// assert!(attributes.only(|role| role != Role::Uv, false).is_empty());
    /// ```
    pub fn only(mut self, keeps: impl Fn(Role) -> bool, with_groups: bool) -> Self {
        self.channels.retain(|channel| keeps(channel.role));
        if self.channels.is_empty() {
            self.wedges.clear();
        }
        if !with_groups {
            self.groups.clear();
        }
        self
    }

    /// Number of wedges that the channels hold.
    pub fn n_wedges(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.values.len() / channel.width.max(1))
    }

    /// The group of a face; 0 where all faces are of one.
    pub fn group(&self, face: u32) -> u32 {
        self.groups.get(face as usize).copied().unwrap_or(0)
    }

    /// Whether there is a row for each of so many faces, and each names values that exist.
    pub fn fit(&self, n_faces: usize) -> bool {
        let n_rows = if self.channels.is_empty() { 0 } else { n_faces };
        self.wedges.len() == n_rows
            && self.holds(&self.wedges)
            && (self.groups.is_empty() || self.groups.len() == n_faces)
    }

    /// What these faces carry, in this order; `None` where there is not a row for each or it names values that are none.
    pub fn of_faces(self, faces: &[u32]) -> Option<Self> {
        let fit = self.channels.is_empty() == self.wedges.is_empty();
        let wedges = selected(&self.wedges, faces).filter(|wedges| fit && self.holds(wedges))?;
        let groups = selected(&self.groups, faces)?;
        Some(Self { wedges, channels: self.channels, groups })
    }

    /// Whether the channels have values of their width for all these wedges, each as many as the others.
    fn holds(&self, wedges: &[[u32; 3]]) -> bool {
        let n_wedges = self.n_wedges();
        let is_whole = |channel: &Channel| channel.width > 0 && channel.values.len() == n_wedges * channel.width;
        self.channels.iter().all(is_whole) && wedges.iter().flatten().all(|&wedge| (wedge as usize) < n_wedges)
    }
}

/// The rows with these numbers, none of none.
fn selected<T: Copy>(rows: &[T], numbers: &[u32]) -> Option<Vec<T>> {
    if rows.is_empty() {
        return Some(Vec::new());
    }
    numbers.iter().map(|&number| rows.get(number as usize).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_selected_with_what_they_carry() {
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: (0..8).map(|i| i as f32).collect() };
        let attributes = Attributes { wedges: vec![[0, 1, 2], [2, 1, 3]], channels: vec![uv], groups: vec![7, 8] };
        assert_eq!((attributes.n_wedges(), attributes.channels[0].of(3)), (4, &[6.0, 7.0][..]));
        assert_eq!(attributes.clone().of_faces(&[2]), None);
        assert!(attributes.fit(2) && !attributes.fit(1) && Attributes::default().fit(3));
        let one = attributes.clone().of_faces(&[1]).unwrap();
        assert_eq!((one.wedges.as_slice(), one.group(0)), (&[[2, 1, 3]][..], 8));
        assert!(!one.is_empty() && Attributes::default().is_empty());
        let beyond = Attributes { wedges: vec![[0, 1, 4]], ..attributes };
        assert!(!beyond.fit(1));
        assert_eq!(beyond.of_faces(&[0]), None);
    }
}
