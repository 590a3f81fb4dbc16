//! Descriptions of progressions (`.nmp`) and hierarchies of clusters (`.nmc`) for `info`.

use std::path::Path;

use neural_mesh::clusters::{ClusterFigures, Clusters};
use neural_mesh::simplify::Progression;
use serde_json::{Value, json};

use crate::escapes::escape_controls_in_json;
use crate::failure::{Failure, display_path};
use crate::files;
use crate::messages::group_digits;
use crate::names::is_progression_name;

/// Describes a file with levels, by the ending of its name; `None` for other files.
pub fn describe_levels(path: &Path, as_json: bool) -> Result<Option<Vec<String>>, Failure> {
    let is_hierarchy = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("nmc"));
    let (figures, lines) = match (is_progression_name(path), is_hierarchy) {
        (true, _) => describe_progression(path)?,
        (_, true) => describe_hierarchy(path)?,
        _ => return Ok(None),
    };
    Ok(Some(if as_json { vec![escape_controls_in_json(&figures.to_string())] } else { lines }))
}

fn describe_progression(path: &Path) -> Result<(Value, Vec<String>), Failure> {
    let progression = Progression::from_bytes(&files::read(path)?).map_err(|error| Failure::in_file(path, error))?;
    let (n_vertices, n_faces) = (progression.n_vertices(), progression.n_faces());
    let proved = progression.proved_levels();
    let source = progression.files.first().map(|(name, _)| name.as_str());
    let figures = json!({
        "file": display_path(path), "holds": "progression", "source": source, "vertices": n_vertices, "faces": n_faces,
        "proved_levels": proved.len(),
    });
    let [vertices, faces] = [n_vertices, n_faces].map(group_digits);
    let of_source = source.map_or(String::new(), |name| format!(" of {name}"));
    let name = display_path(path);
    let lines = vec![
        format!("{name}: progression{of_source}: levels of any size up to {vertices} vertices, {faces} faces"),
        match proved {
            [] => "proved      no level".into(),
            [first, .., last] => format!(
                "proved      {} levels, with distances from {:.3e} to {:.3e}",
                proved.len(),
                first.distance,
                last.distance
            ),
            [only] => format!("proved      1 level, with distance {:.3e}", only.distance),
        },
    ];
    Ok((figures, lines))
}

fn describe_hierarchy(path: &Path) -> Result<(Value, Vec<String>), Failure> {
    let clusters = Clusters::from_bytes(&files::read(path)?).map_err(|error| Failure::in_file(path, error))?;
    let finest = clusters.clusters.iter().filter(|cluster| cluster.level == 0);
    let n_faces: usize = finest.map(|cluster| cluster.n_faces as usize).sum();
    let ClusterFigures { n_clusters, n_groups, n_levels, n_root_faces, root_error, .. } = clusters.figures();
    let figures = json!({
        "file": display_path(path), "holds": "clusters", "faces": n_faces, "clusters": n_clusters, "groups": n_groups,
        "levels": n_levels, "root_faces": n_root_faces, "root_error": root_error,
    });
    let [faces, clusters, groups] = [n_faces, n_clusters, n_groups].map(group_digits);
    let name = display_path(path);
    let lines = vec![
        format!(
            "{name}: hierarchy of {clusters} clusters in {groups} groups: {n_levels} levels, the finest of {faces} faces"
        ),
        format!("coarsest    {} faces, within {root_error:.4} of the original (proved)", group_digits(n_root_faces)),
    ];
    Ok((figures, lines))
}
