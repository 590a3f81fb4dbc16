//! Tables and JSON, made from rows.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::folder::{ROWS, write_whole};
use super::row::columns;
use super::rows_file::read_rows;
use super::summary::{default_reference, methods};
use super::tables::make_page;
use super::{EvaluateError, ResultRow, Table};

/// Writes `tables.md` and `rows.json` next to the rows of an evaluation, and returns the rows.
///
/// # Errors
/// [`EvaluateError`] where the folder or the method `relative_to` has no rows.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let error = neural_mesh_bench::evaluate::write_report(folder.path(), None).unwrap_err();
/// assert!(error.to_string().contains("rows.csv"));
/// ```
pub fn write_report(folder: &Path, relative_to: Option<&str>) -> Result<Table, EvaluateError> {
    let table = read_rows(&folder.join(ROWS))?;
    let methods = methods(&table);
    if let Some(name) = relative_to.filter(|name| !methods.contains(name)) {
        let what = format!(
            "--relative-to {name}: the evaluation has no rows of this method: give one of {}",
            methods.join(", ")
        );
        return Err(EvaluateError::Settings(what));
    }
    let relative_to = relative_to.or_else(|| default_reference(&methods));
    write_whole(&folder.join("tables.md"), &make_page(&table, relative_to))?;
    write_whole(&folder.join("rows.json"), &to_json(&table))?;
    Ok(table)
}

fn to_json(table: &Table) -> String {
    let names = columns(&table.figures);
    let objects: Vec<String> = table.rows.iter().map(|row| to_object(&names, row).to_string()).collect();
    format!("[\n{}\n]\n", objects.join(",\n"))
}

fn to_object(names: &[String], row: &ResultRow) -> Value {
    let texts = ["mesh", "method", "error", "timed", "weights", "version", "cpu"];
    let value = |(name, field): (&String, String)| {
        let value = match field.as_str() {
            _ if texts.contains(&name.as_str()) => json!(field),
            "" => Value::Null,
            number => serde_json::from_str(number).unwrap_or(Value::Null),
        };
        (name.clone(), value)
    };
    Value::Object(names.iter().zip(row.fields()).map(value).collect::<Map<String, Value>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_says_what_the_rows_say() {
        let row = ResultRow { mesh: "1".into(), ratio: 0.1, figures: vec![Some(0.25), None], ..ResultRow::default() };
        let table = Table { figures: vec!["a".into(), "b".into()], rows: vec![row.clone(), row] };
        let json: Value = serde_json::from_str(&to_json(&table)).unwrap();
        let row = &json[1];
        assert_eq!((&row["mesh"], &row["ratio"], &row["a"]), (&json!("1"), &json!(0.1), &json!(0.25)));
        assert!(row["b"].is_null() && row["seconds"].is_null() && row["error"] == "");
    }
}
