//! Parsers for typed numbers such as `10%`, `10k`, `1.5M`.

use neural_mesh::job::{number_parser, whole_number_parser};

/// Upper bound on the number of threads, above the number of cores of common machines.
pub const MAX_THREADS: u64 = 1024;
/// Upper bound on the number of samples, so that they fit into memory.
pub const MAX_SAMPLES: u64 = 10_000_000;

/// Named views as degrees around the y axis and above the horizon; +z is the front, y is up.
const VIEWS: [(&str, [f32; 2]); 6] = [
    ("front", [0.0, 0.0]),
    ("right", [90.0, 0.0]),
    ("back", [180.0, 0.0]),
    ("left", [-90.0, 0.0]),
    ("top", [0.0, 90.0]),
    ("bottom", [0.0, -90.0]),
];

const VIEW_ADVICE: &str = "give front, back, left, right, top, bottom, or degrees around and above, like 30,20";

/// Parses a view such as `front` or `30,20`, in degrees as in `VIEWS`.
pub fn parse_view(text: &str) -> Result<[f32; 2], String> {
    if let Some((_, view)) = VIEWS.iter().find(|(name, _)| name.eq_ignore_ascii_case(text.trim())) {
        return Ok(*view);
    }
    let degrees = |word: &str| word.trim().parse().ok().filter(|number: &f32| (-360.0..=360.0).contains(number));
    let view = text.split_once(',').and_then(|(around, above)| Some([degrees(around)?, degrees(above)?]));
    view.ok_or(VIEW_ADVICE.into())
}

/// Parses a number of threads.
pub fn parse_thread_count(text: &str) -> Result<usize, String> {
    whole_number_parser(1, MAX_THREADS)(text)
}

/// Parses a number of GiB.
pub fn parse_gib(text: &str) -> Result<f64, String> {
    number_parser("a number of GiB above 0, like 4", |gib| gib > 0.0)(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_is_a_name_or_two_numbers_of_degrees() {
        assert_eq!([parse_view("Top"), parse_view("-30, 12.5")], [Ok([0.0, 90.0]), Ok([-30.0, 12.5])]);
        for bad in ["", "up", "30", "30,", "1,2,3", "nan,0", "400,0"] {
            assert_eq!(parse_view(bad), Err(VIEW_ADVICE.to_string()), "{bad}");
        }
    }
}
