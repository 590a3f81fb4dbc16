//! Attributes of corners and faces.
//!
//! Corners with equal values share a *wedge* (Hoppe 1999, "New quadric metric for simplifying meshes with appearance
//! attributes"). Faces on both sides of a seam share vertices.

use glam::DVec3;
use rustc_hash::FxHashMap;

/// The meaning of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Unit normals, width 3.
    Normal,
    /// Unit tangents with the sign of the bitangent, width 4.
    Tangent,
    /// Texture coordinates, width 2.
    Uv,
    /// Colours in the file's colour space, width 3 or 4.
    Colour,
    /// Joint indices, then as many weights.
    Skin,
    /// Displacement by a morph target, width 3.
    MorphPosition,
    /// Change of a normal or tangent by a morph target, width 3.
    MorphDirection,
    /// Numbers of any other meaning, which may be interpolated.
    Other,
    /// A whole number, such as an object's number, that is never interpolated.
    Label,
}

/// A named array of values, one row per wedge.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name in the file.
    pub name: String,
    /// Meaning of the values.
    pub role: Role,
    /// Number of values per wedge.
    pub width: usize,
    /// Values, n_wedges x width.
    pub values: Vec<f32>,
}

impl Channel {
    /// Returns the values of a wedge.
    pub fn value(&self, wedge: u32) -> &[f32] {
        &self.values[wedge as usize * self.width..][..self.width]
    }
}

/// Attributes of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Wedge of each corner, n_faces x 3; empty without channels.
    pub wedges: Vec<[u32; 3]>,
    /// Channels, indexed by wedge.
    pub channels: Vec<Channel>,
    /// Material, primitive or group of each face, n_faces; empty if all are 0.
    pub groups: Vec<u32>,
}

impl Attributes {
    /// Attributes of a bare mesh.
    pub const NONE: &'static Self = &Self { wedges: Vec::new(), channels: Vec::new(), groups: Vec::new() };

    /// Returns whether there are no channels and no groups.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty() && self.groups.is_empty()
    }

    /// Keeps the channels whose role `keeps` accepts, and the groups if `with_groups`.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::mesh::{Attributes, Channel, Role};
    /// let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: vec![0.0; 6] };
    /// let attributes = Attributes { wedges: vec![[0, 1, 2]], channels: vec![uv], groups: vec![7] };
    /// assert_eq!(attributes.clone().keep_roles(|role| role == Role::Uv, true), attributes);
    /// assert!(attributes.keep_roles(|role| role != Role::Uv, false).is_empty());
    /// ```
    pub fn keep_roles(mut self, keeps: impl Fn(Role) -> bool, with_groups: bool) -> Self {
        self.channels.retain(|channel| keeps(channel.role));
        if self.channels.is_empty() {
            self.wedges.clear();
        }
        if !with_groups {
            self.groups.clear();
        }
        self
    }

    /// Returns the first channel of a role.
    pub fn channel(&self, role: Role) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.role == role)
    }

    /// Returns the normals of corners, if they have three numbers each.
    pub fn normals(&self) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.role == Role::Normal && channel.width == 3)
    }

    /// Finds the place of the channel called `name`; at once if it is `near`, which a loop over names in order knows.
    #[doc(hidden)]
    pub fn find_channel(&self, name: &str, near: usize) -> Option<usize> {
        let is_named = |channel: &Channel| channel.name == name;
        if self.channels.get(near).is_some_and(is_named) {
            return Some(near);
        }
        self.channels.iter().position(is_named)
    }

    /// Returns the number of wedges.
    pub fn n_wedges(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.values.len() / channel.width.max(1))
    }

    /// Returns the group of a face.
    pub fn group(&self, face: u32) -> u32 {
        self.groups.get(face as usize).copied().unwrap_or(0)
    }

    /// Returns whether the arrays have `n_faces` rows, and values for every wedge.
    pub fn is_valid_for(&self, n_faces: usize) -> bool {
        let n_rows = if self.channels.is_empty() { 0 } else { n_faces };
        self.wedges.len() == n_rows
            && self.has_values_for(&self.wedges)
            && (self.groups.is_empty() || self.groups.len() == n_faces)
    }

    /// Returns the attributes of `faces`, in this order; `None` if a face or wedge is missing.
    pub fn select_faces(self, faces: &[u32]) -> Option<Self> {
        let fit = self.channels.is_empty() == self.wedges.is_empty();
        let wedges = select_rows(&self.wedges, faces).filter(|wedges| fit && self.has_values_for(wedges))?;
        let groups = select_rows(&self.groups, faces)?;
        Some(Self { wedges, channels: self.channels, groups })
    }

    /// Reverses corner normals that oppose the normal of their reversed face, with tangents and morph targets.
    #[doc(hidden)]
    pub fn turn_normals(&mut self, reversed: impl Iterator<Item = (u32, DVec3)>) {
        let Some(normals) = self.channels.iter().find(|channel| channel.role == Role::Normal) else { return };
        let n_wedges = self.n_wedges() as u32;
        let mut opposite = FxHashMap::default();
        let mut sources = Vec::new();
        for (face, normal) in reversed {
            for wedge in self.wedges.iter_mut().skip(face as usize).take(1).flatten() {
                let Some(&[x, y, z]) = normals.value(*wedge).first_chunk() else { continue };
                if normal.dot(DVec3::new(x.into(), y.into(), z.into())) < 0.0 {
                    // One new wedge per old one, since unreversed faces may still use it.
                    *wedge = *opposite.entry(*wedge).or_insert_with(|| {
                        sources.push(*wedge);
                        n_wedges + sources.len() as u32 - 1
                    });
                }
            }
        }
        for channel in &mut self.channels {
            // Every channel gets the new rows. Tangents stay, so the sign of the bitangent changes.
            let turns = |i| match channel.role {
                Role::Normal | Role::MorphDirection => true,
                Role::Tangent => i == 3,
                _ => false,
            };
            let row =
                |&wedge: &u32| channel.value(wedge).iter().enumerate().map(|(i, &x)| if turns(i) { -x } else { x });
            let rows: Vec<f32> = sources.iter().flat_map(row).collect();
            channel.values.extend(rows);
        }
    }

    /// Returns whether every channel has a row for each wedge, and all of `wedges` exist.
    #[doc(hidden)]
    pub fn has_values_for(&self, wedges: &[[u32; 3]]) -> bool {
        let n_wedges = self.n_wedges();
        let is_whole = |channel: &Channel| channel.width > 0 && channel.values.len() == n_wedges * channel.width;
        self.channels.iter().all(is_whole) && wedges.iter().flatten().all(|&wedge| (wedge as usize) < n_wedges)
    }
}

fn select_rows<T: Copy>(rows: &[T], numbers: &[u32]) -> Option<Vec<T>> {
    if rows.is_empty() {
        return Some(Vec::new());
    }
    numbers.iter().map(|&number| rows.get(number as usize).copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_reversed_faces_turn_with_the_sign_of_the_bitangent() {
        let up = [0.0, 0.0, 1.0];
        let normals = [up, up, up, [0.0, 0.0, -1.0]].concat();
        let normal = Channel { name: "normal".into(), role: Role::Normal, width: 3, values: normals };
        let tangents = [1.0, 0.0, 0.0, 1.0].repeat(4);
        let tangent = Channel { name: "tangent".into(), role: Role::Tangent, width: 4, values: tangents };
        let wedges = vec![[0, 1, 2], [2, 1, 3]];
        let mut attributes = Attributes { wedges, channels: vec![normal, tangent], groups: Vec::new() };
        // Of the second face, now seen from below, corners 2 and 1 turn; 3 agrees already.
        attributes.turn_normals([(1, DVec3::NEG_Z)].into_iter());
        assert_eq!(attributes.wedges, [[0, 1, 2], [4, 5, 3]]);
        assert!(attributes.is_valid_for(2) && attributes.n_wedges() == 6);
        for wedge in [4, 5] {
            assert_eq!(attributes.channels[0].value(wedge), [0.0, 0.0, -1.0]);
            assert_eq!(attributes.channels[1].value(wedge), [1.0, 0.0, 0.0, -1.0]);
        }
        assert_eq!(attributes.channels[0].value(1), up);
    }

    #[test]
    fn faces_are_selected_with_what_they_carry() {
        let uv = Channel { name: "uv".into(), role: Role::Uv, width: 2, values: (0..8).map(|i| i as f32).collect() };
        let attributes = Attributes { wedges: vec![[0, 1, 2], [2, 1, 3]], channels: vec![uv], groups: vec![7, 8] };
        assert_eq!((attributes.n_wedges(), attributes.channels[0].value(3)), (4, &[6.0, 7.0][..]));
        assert_eq!(attributes.clone().select_faces(&[2]), None);
        assert!(attributes.is_valid_for(2) && !attributes.is_valid_for(1) && Attributes::default().is_valid_for(3));
        let one = attributes.clone().select_faces(&[1]).unwrap();
        assert_eq!((one.wedges.as_slice(), one.group(0)), (&[[2, 1, 3]][..], 8));
        assert!(!one.is_empty() && Attributes::default().is_empty());
        let beyond = Attributes { wedges: vec![[0, 1, 4]], ..attributes };
        assert!(!beyond.is_valid_for(1));
        assert_eq!(beyond.select_faces(&[0]), None);
    }
}
