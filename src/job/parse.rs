//! Parsers of sizes and distances in the notation of users: `10%`, `10k`, `1.5M`, `2MB`.

use crate::simplify::{Size, percent};

use super::size::Bound;

/// Largest count; exact in doubles.
const MOST: f64 = 1e15;
/// Least and most texels of a texture's side.
const TEXTURE_SIDES: (u64, u64) = (16, 8192);

const SHARE: &str = "give a share above 0 and at most 1, like 0.1, or in percent, like 10%";
const COUNT: &str = "give a whole number above 0, like 5000, 10k or 1.5M, or a share of the input, like 10%";

/// Parses a share: `0.1`, `10%`.
pub fn share(text: &str) -> Result<f64, String> {
    let value = share_of(text).ok_or(SHARE)?;
    let meant = (1.0 < value && value <= 100.0 && !text.contains('%')).then_some(value);
    if is_share(value) { Ok(value) } else { Err(with_suggestion(SHARE, meant)) }
}

/// Share of all vertices, or of those with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct RatioOf {
    /// Name of the material, group or object; `None` for all vertices.
    pub name: Option<String>,
    /// Share, above 0 and at most 1.
    pub share: f64,
}

impl std::fmt::Display for RatioOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.name {
            Some(name) => write!(f, "{name}={}", self.share),
            None => write!(f, "{}", self.share),
        }
    }
}

/// Parses a share of the whole or of a name: `10%`, `head=50%`.
pub fn ratio_of(text: &str) -> Result<RatioOf, String> {
    match text.rsplit_once('=') {
        Some((name, of)) if !name.is_empty() => Ok(RatioOf { name: Some(name.into()), share: share(of)? }),
        _ => Ok(RatioOf { name: None, share: share(text)? }),
    }
}

/// Parses a number or share of the vertices: `5000`, `10k`, `1.5M`, `10%`.
pub fn vertices(text: &str) -> Result<Size, String> {
    count(text, Size::Vertices, Size::Ratio)
}

/// Parses a number or share of the faces: `5000`, `10k`, `1.5M`, `10%`.
pub fn faces(text: &str) -> Result<Size, String> {
    count(text, Size::Faces, Size::FaceRatio)
}

fn count(text: &str, number: fn(usize) -> Size, ratio: fn(f64) -> Size) -> Result<Size, String> {
    if text.contains('%') {
        return share_of(text).filter(|share| is_share(*share)).map(ratio).ok_or(COUNT.into());
    }
    let (digits, power) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 3),
        None => text.strip_suffix(['m', 'M']).map_or((text, 0), |digits| (digits, 6)),
    };
    let value = parse_scaled(digits, power).ok_or(COUNT)?;
    if value.fract() == 0.0 && (1.0..=MOST).contains(&value) {
        return Ok(number(value as usize));
    }
    Err(with_suggestion(COUNT, (0.0 < value && value < 1.0).then(|| percent(value))))
}

/// Parses a distance: `0.01`, `0.5%`.
pub fn bound(text: &str) -> Result<Bound, String> {
    let (number, make): (&str, fn(f64) -> Bound) = match text.strip_suffix('%') {
        Some(number) => (number, Bound::Percent),
        None => (text, Bound::Absolute),
    };
    let value = number.trim().parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    value.map(make).ok_or_else(|| "give a distance, like 0.01, or like 0.5%".into())
}

/// Parses a size in bytes: `200000`, `500kB`, `2MB`.
pub fn n_bytes(text: &str) -> Result<usize, String> {
    let binary = [("kib", 1024.0), ("mib", 1048576.0), ("gib", 1073741824.0)];
    let decimal = [("kb", 1e3), ("mb", 1e6), ("gb", 1e9), ("k", 1e3), ("m", 1e6), ("g", 1e9), ("b", 1.0)];
    let lower = text.to_ascii_lowercase();
    let found = binary.iter().chain(&decimal).find_map(|(unit, factor)| Some((lower.strip_suffix(unit)?, *factor)));
    let (number, factor) = found.unwrap_or((&lower, 1.0));
    let value = number.trim().parse().ok().map(|x: f64| x * factor).filter(|x| *x >= 1.0 && *x < 1e15);
    value.map(|x| x as usize).ok_or_else(|| "give bytes, like 500kB or 2MB".into())
}

/// Parses an angle in degrees, 0 to 180.
pub fn degrees(text: &str) -> Result<f64, String> {
    number_parser("degrees from 0 to 180", |x| (0.0..=180.0).contains(&x))(text)
}

/// Parses a field of view in degrees, above 0 and below 180.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    number_parser("degrees above 0 and below 180", |x| 0.0 < x && x < 180.0)(text)
}

/// Parses a distance in texels.
pub fn seam_texels(text: &str) -> Result<f64, String> {
    number_parser("texels, 0 or more", |x| x >= 0.0)(text)
}

/// Parses the texels of a texture's side.
pub fn texture_side(text: &str) -> Result<usize, String> {
    whole_number_parser(TEXTURE_SIDES.0, TEXTURE_SIDES.1)(text)
}

/// Parses a number of edges.
pub fn n_edges(text: &str) -> Result<usize, String> {
    whole_number_parser(0, u64::MAX)(text)
}

/// Parses a seed.
pub fn seed(text: &str) -> Result<u64, String> {
    whole_number_parser(0, u64::MAX)(text)
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

/// Returns a parser for numbers in a range that `range` describes.
pub fn number_parser(
    range: &'static str,
    is_in_range: fn(f64) -> bool,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| parse_scaled(text, 0).filter(|value| is_in_range(*value)).ok_or_else(|| format!("give {range}"))
}

fn is_share(value: f64) -> bool {
    value > 0.0 && value <= 1.0
}

fn share_of(text: &str) -> Option<f64> {
    match text.trim().strip_suffix('%') {
        Some(percent) => parse_scaled(percent, -2),
        None => parse_scaled(text, 0),
    }
}

/// Parses a number times a power of ten, rounded once: 0.7 % is exactly 0.007.
pub fn parse_scaled(text: &str, power: i32) -> Option<f64> {
    let text = text.trim();
    let value: f64 = match text.contains(['e', 'E']) {
        true => text.parse::<f64>().ok()? * 10f64.powi(power),
        false => format!("{text}e{power}").parse().ok()?,
    };
    value.is_finite().then_some(value)
}

fn with_suggestion(taken: &str, percent: Option<f64>) -> String {
    percent.map_or(taken.into(), |percent| format!("{taken}; did you mean {percent}%?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_fractions_or_percent() {
        for (text, expected) in [("0.1", 0.1), ("10%", 0.1), ("1", 1.0), ("100%", 1.0), ("0.7%", 0.007), ("1e1 %", 0.1)]
        {
            assert_eq!(share(text), Ok(expected), "{text}");
        }
        for text in ["", "%", "0", "0%", "-0.1", "101%", "nan", "inf", "half", "10%%", "1e400"] {
            assert_eq!(share(text), Err(SHARE.into()), "{text}");
        }
    }

    #[test]
    fn a_share_may_be_of_what_has_a_name() {
        let name_share = |name: &str, share| Ok(RatioOf { name: Some(name.into()), share });
        assert_eq!(ratio_of("10%"), Ok(RatioOf { name: None, share: 0.1 }));
        assert_eq!([ratio_of("head=50%"), ratio_of("a=b=0.2")], [name_share("head", 0.5), name_share("a=b", 0.2)]);
        assert!(ratio_of("head=").is_err() && ratio_of("=0.5").is_err() && ratio_of("head").is_err());
        assert!(ratio_of("head=50").unwrap_err().ends_with("did you mean 50%?"));
    }

    #[test]
    fn a_ratio_that_was_meant_in_percent_is_suggested() {
        assert!(share("50").unwrap_err().ends_with("; did you mean 50%?"));
        assert!(share("1.5").unwrap_err().ends_with("; did you mean 1.5%?"));
        assert!(vertices("0.07").unwrap_err().ends_with("; did you mean 7%?"));
    }

    #[test]
    fn counts_are_whole_numbers_with_suffixes_or_shares() {
        for (text, expected) in
            [("5000", 5000), ("10k", 10_000), ("10K", 10_000), ("1.5M", 1_500_000), ("2m", 2_000_000), ("1e3", 1000)]
        {
            assert_eq!(
                [vertices(text), faces(text)],
                [Ok(Size::Vertices(expected)), Ok(Size::Faces(expected))],
                "{text}"
            );
        }
        assert_eq!([vertices("10%"), faces("10%")], [Ok(Size::Ratio(0.1)), Ok(Size::FaceRatio(0.1))]);
        for text in ["", "k", "0", "-5", "1.0001k", "many", "10kk", "5 thousand", "0%", "200%", "nan", "1e99"] {
            assert!(faces(text).unwrap_err().starts_with(COUNT), "{text}");
        }
    }

    #[test]
    fn numbers_out_of_range_say_the_range() {
        assert_eq!(whole_number_parser::<usize>(1, 8)("8"), Ok(8));
        assert_eq!(whole_number_parser::<usize>(1, 8)("9"), Err("give a whole number from 1 to 8".into()));
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        assert_eq!(seed("-1"), Err("give a whole number of at least 0".into()));
        assert_eq!((degrees("30"), degrees("nan")), (Ok(30.0), Err("give degrees from 0 to 180".into())));
    }

    #[test]
    fn counts_are_printed_as_typed() {
        for text in ["7%", "12.5%", "0.1%", "4000"] {
            assert_eq!(faces(text).unwrap().to_string(), text);
        }
    }
}
