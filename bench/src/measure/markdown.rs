//! Markdown tables, CSV and numbers.

pub fn table<H: AsRef<str>>(head: &[H], rows: &[Vec<String>]) -> String {
    let head: Vec<&str> = head.iter().map(AsRef::as_ref).collect();
    let line = |cells: &str| format!("| {cells} |\n");
    let rule = format!("|{}\n", "---|".repeat(head.len()));
    [line(&head.join(" | ")), rule].into_iter().chain(rows.iter().map(|row| line(&row.join(" | ")))).collect()
}

/// Formats rows as CSV, without backticks; cells with a comma are quoted.
pub fn csv<H: AsRef<str>>(head: &[H], rows: &[Vec<String>]) -> String {
    let cell = |cell: &str| {
        let plain = cell.replace('`', "");
        if plain.contains(',') { format!("\"{plain}\"") } else { plain }
    };
    let line = |cells: Vec<&str>| cells.into_iter().map(cell).collect::<Vec<_>>().join(",") + "\n";
    let head = line(head.iter().map(AsRef::as_ref).collect());
    head + &rows.iter().map(|row| line(row.iter().map(String::as_str).collect())).collect::<String>()
}

pub fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.2}") })
}

pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let commas = |(at, digit): (usize, char)| {
        let is_group = at > 0 && (digits.len() - at).is_multiple_of(3);
        is_group.then_some(',').into_iter().chain([digit])
    };
    digits.chars().enumerate().flat_map(commas).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_in_rows_and_numbers_have_few_digits() {
        assert_eq!(table(&["a", "b"], &[vec!["1".into(), "2".into()]]), "| a | b |\n|---|---|\n| 1 | 2 |\n");
        assert_eq!(csv(&["a", "`b`"], &[vec!["1".into(), "2, 3".into()]]), "a,b\n1,\"2, 3\"\n");
        assert_eq!([number(Some(0.456)), number(Some(456.7)), number(None)], ["0.46", "457", "-"]);
        assert_eq!([count(12), count(123_456), count(1_234_567)], ["12", "123,456", "1,234,567"]);
    }
}
