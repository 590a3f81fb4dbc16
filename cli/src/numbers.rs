//! Parsers for typed numbers such as `10%`, `10k`, `1.5M`.

use neural_mesh::job::parse_scaled;

/// Upper bound on the number of threads, above the number of cores of common machines.
pub const MAX_THREADS: u64 = 1024;
/// Upper bound on the number of samples, so that they fit into memory.
pub const MAX_SAMPLES: u64 = 10_000_000;
pub const TEXEL_RANGE: (u64, u64) = (16, 8192);

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

/// Returns a parser for whole numbers from `least` to `most`.
pub fn whole_number_parser<N: TryFrom<u64>>(least: u64, most: u64) -> impl Fn(&str) -> Result<N, String> + Clone {
    move |text| {
        let value = text.trim().parse().ok().filter(|value| (least..=most).contains(value));
        value.and_then(|value| N::try_from(value).ok()).ok_or_else(|| match most {
            u64::MAX => format!("give a whole number of at least {least}"),
            most => format!("give a whole number from {least} to {most}"),
        })
    }
}

/// Parses a number of threads.
pub fn parse_thread_count(text: &str) -> Result<usize, String> {
    whole_number_parser(1, MAX_THREADS)(text)
}

pub fn parse_texels(text: &str) -> Result<usize, String> {
    whole_number_parser(TEXEL_RANGE.0, TEXEL_RANGE.1)(text)
}

/// Parses a seed.
pub fn parse_seed(text: &str) -> Result<u64, String> {
    whole_number_parser(0, u64::MAX)(text)
}

pub const GIB_RANGE: &str = "a number of GiB above 0, like 4";

/// Returns a parser for numbers in a range that `range` describes.
pub fn number_parser(
    range: &'static str,
    is_in_range: fn(f64) -> bool,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| parse_scaled(text, 0).filter(|value| is_in_range(*value)).ok_or_else(|| format!("give {range}"))
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

    #[test]
    fn numbers_out_of_range_say_the_range() {
        assert_eq!(whole_number_parser::<usize>(1, 8)("8"), Ok(8));
        assert_eq!(whole_number_parser::<usize>(1, 8)("9"), Err("give a whole number from 1 to 8".into()));
        assert_eq!(whole_number_parser::<u64>(0, u64::MAX)("18446744073709551615"), Ok(u64::MAX));
        assert_eq!(whole_number_parser::<u64>(0, u64::MAX)("-1"), Err("give a whole number of at least 0".into()));
        let degrees = number_parser("degrees from 0 to 180", |x| (0.0..=180.0).contains(&x));
        assert_eq!((degrees("30"), degrees("nan")), (Ok(30.0), Err("give degrees from 0 to 180".into())));
    }
}
