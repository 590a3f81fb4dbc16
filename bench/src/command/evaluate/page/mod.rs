//! An evaluation as one self-contained HTML file.

mod points;
mod worst;

use std::path::Path;

use crate::evaluate::{Table, overview, points};
use serde_json::json;

use super::chart::colour;
use neural_mesh_cli::shared::page::{data_script, fill_page, json_script};
use worst::WorstCases;

// A page without data, made by `scripts/viewer`.
const REPORT: &str = include_str!("../../../../../cli/viewer/dist/report.html");

const MOST_BYTES: usize = 29_000_000;

// Largest number of failures that a page shows; `tables.md` has all.
const MOST_FAILURES: usize = 500;

pub fn make_page(folder: &Path, table: &Table, relative_to: Option<&str>) -> String {
    let mut overview = overview(table, relative_to);
    let n_failures = overview.failures.len();
    overview.failures.truncate(MOST_FAILURES);
    let points = points(table, &overview);
    let meshes: Vec<_> = points.meshes.iter().map(|(name, vertices, faces)| json!([name, vertices, faces])).collect();
    let packed = points.values.iter().enumerate();
    let mut scripts: Vec<String> =
        packed.map(|(at, values)| data_script(&format!("points-{at}"), &points::pack_values(values))).collect();
    let mut data = json!({
        "overview": overview,
        "colours": (0..overview.methods.len()).map(colour).collect::<Vec<_>>(),
        "meshes": meshes,
        "left_out": points.n_left_out,
        "more_failures": n_failures - overview.failures.len(),
    });
    let taken = REPORT.len() + scripts.iter().map(String::len).sum::<usize>() + data.to_string().len();
    let WorstCases { cases, surfaces, eyes, scripts: mesh_scripts } =
        worst::pack_worst_cases(folder, table, MOST_BYTES.saturating_sub(taken));
    data["worst"] = json!(cases);
    data["surfaces"] = json!(surfaces);
    data["eyes"] = json!(eyes);
    scripts.insert(0, json_script("evaluation", &data));
    scripts.extend(mesh_scripts);
    fill_page(REPORT, &name_of(folder), &scripts.concat())
}

fn name_of(folder: &Path) -> String {
    folder.file_name().map_or_else(|| folder.display().to_string(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_page::check_page_loads_nothing;
    use crate::evaluate::ResultRow;
    use serde_json::Value;

    fn table(name: &str) -> Table {
        let row = |method: &str| ResultRow {
            mesh: name.into(),
            ratio: 0.5,
            method: method.into(),
            vertices_in: 4,
            faces_in: 4,
            figures: vec![Some(0.25)],
            ..ResultRow::default()
        };
        let failed = ResultRow { error: name.into(), figures: vec![None], ..row("x") };
        Table { figures: vec!["distance_mean".into()], rows: vec![row("qem"), failed] }
    }

    fn html(name: &str) -> String {
        make_page(name.as_ref(), &table(name), None)
    }

    #[test]
    fn names_are_escaped() {
        let page = html("<b>x</script><!-- data --><img src=x onerror=alert(1)>&amp;");
        assert!(!page.contains("<img src=x"));
        // Columns are faces, vertices, the share of faces, and the distance.
        let n_columns = 4;
        assert_eq!(page.matches("</script>").count(), REPORT.matches("</script>").count() + 1 + n_columns);
        assert!(page.contains("<title>script&gt;&lt;!-- data"));
    }

    #[test]
    fn the_data_is_valid_json() {
        let page = html("a <b> & \"c\"");
        let start = page.find("id=\"evaluation\">").unwrap() + "id=\"evaluation\">".len();
        let length = page[start..].find("</script>").unwrap();
        let data: Value = serde_json::from_str(&page[start..start + length]).unwrap();
        assert_eq!(data["meshes"][0], json!(["a <b> & \"c\"", 4, 4]));
        assert_eq!(data["overview"]["standings"][0][0]["cells"][3]["median"], 0.25);
        assert_eq!(data["overview"]["failures"][0]["why"], "a <b> & \"c\"");
        assert_eq!(data["colours"].as_array().unwrap().len(), 2);
    }

    #[test]
    fn the_page_loads_nothing() {
        check_page_loads_nothing(&html("run"));
    }
}
