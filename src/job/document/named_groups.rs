//! Names in a file and their faces.

use std::collections::{BTreeSet, HashSet};

use crate::io::{Group, shorten_name};

use crate::job::error::JobError;

use super::{Document, Kind, PartPiece};

const MOST_LISTED: usize = 40;

/// A name and the indices of its groups of faces.
type Named = (String, Vec<u32>);

impl Document {
    /// Returns whether each face belongs to one of `names`; empty without names.
    ///
    /// # Errors
    /// [`JobError::Options`] with `option` and the existing names if a name does not exist.
    pub fn faces_named(&self, option: &str, names: &[String]) -> Result<Vec<bool>, JobError> {
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let mut groups = HashSet::new();
        for name in names {
            let refused = |why: String| JobError::Options(format!("{option} {name}: {why}"));
            groups.extend(self.groups_named(name).map_err(refused)?);
        }
        let attributes = self.attributes();
        Ok((0..self.mesh().faces().len() as u32).map(|face| groups.contains(&attributes.group(face))).collect())
    }

    /// Returns the groups of faces with a name; the error lists the existing names.
    pub fn groups_named(&self, name: &str) -> Result<Vec<u32>, String> {
        let named = self.named_groups();
        let mut groups: Vec<u32> =
            named.iter().filter(|(other, _)| other == name).flat_map(|(_, groups)| groups).copied().collect();
        groups.extend(self.groups_of_nodes(name));
        if !groups.is_empty() {
            return Ok(groups);
        }
        let kinds = if self.is_scene() { "node, mesh or material" } else { "material, group or object" };
        let nodes = if let Kind::Scene { asset, .. } = &self.kind { asset.contents().nodes } else { Vec::new() };
        let nodes = nodes.iter().filter(|(_, has_parts)| *has_parts).map(|(name, _)| name.as_str());
        let names: BTreeSet<&str> = named.iter().map(|(name, _)| name.as_str()).chain(nodes).collect();
        Err(format!("the mesh has no such {kinds}; it has: {}", list_names(names)))
    }

    /// Returns the groups of the parts that the nodes of a name show.
    fn groups_of_nodes(&self, name: &str) -> Vec<u32> {
        let Kind::Scene { asset, united, pieces } = &self.kind else { return Vec::new() };
        let pieces = asset.parts_below(name).into_iter().filter_map(|part| pieces[part]);
        pieces.flat_map(|piece| united.first_group(piece.number)..united.first_group(piece.number + 1)).collect()
    }

    /// Lists the names of meshes, materials, groups and objects.
    fn named_groups(&self) -> Vec<Named> {
        let (asset, united, pieces) = match &self.kind {
            Kind::Scene { asset, united, pieces } => (asset, united, pieces),
            Kind::Mesh { extra, .. } => {
                let names = |group: &Group| [&group.material, &group.name, &group.object].map(Option::clone);
                let named = extra.groups.iter().zip(0..).flat_map(|(group, i)| names(group).map(|name| (name, i)));
                return named.filter_map(|(name, i)| Some((name?, vec![i]))).collect();
            }
        };
        let of_piece = |piece: PartPiece| united.first_group(piece.number)..united.first_group(piece.number + 1);
        let of_part = |&part: &usize| pieces[part].into_iter().flat_map(of_piece).collect::<Vec<u32>>();
        let parts = || asset.parts().iter().enumerate();
        let meshes = parts().map(|(at, part)| (part.name.clone(), of_part(&at)));
        let materials = parts().flat_map(|(at, part)| {
            let groups = of_part(&at).into_iter();
            part.materials.iter().zip(groups).map(|(name, group)| (name.clone(), vec![group]))
        });
        let named = meshes.chain(materials);
        named.filter(|(_, groups): &Named| !groups.is_empty()).collect()
    }
}

/// Joins names by commas; shortens long lists.
pub fn list_names<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.into_iter().map(shorten_name).collect();
    match names.len() {
        0 => "none".into(),
        n if n > MOST_LISTED => format!("{}, and {} more", names[..MOST_LISTED].join(", "), n - MOST_LISTED),
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_names_the_first_are_listed() {
        assert_eq!((list_names([]), list_names(["a", "b"])), ("none".into(), "a, b".into()));
        let many: Vec<String> = (0..50).map(|i| format!("n{i}")).collect();
        assert!(list_names(many.iter().map(String::as_str)).ends_with("n38, n39, and 10 more"));
    }
}
