//! Numbers as people type them: `10%`, `10k`, `1.5M`. What is refused says what is taken.
//!
//! The functions here are clap's value parsers: a number that passed one is in range.

use neural_mesh::job::{Count, percent};

/// More threads than any machine has, fewer than a system refuses to start.
pub const MOST_THREADS: u64 = 1024;
/// More samples than any comparison needs, fewer than fill the memory.
pub const MOST_SAMPLES: u64 = 10_000_000;
/// Texels a side of a texture, as `bake` has them.
pub const TEXELS: (u64, u64) = (16, 8192);
/// Counts that a double holds, and larger than any mesh.
const MOST: f64 = 1e15;

/// Views with names, y up: degrees around from +z, and above.
const VIEWS: [(&str, [f32; 2]); 6] = [
    ("front", [0.0, 0.0]),
    ("right", [90.0, 0.0]),
    ("back", [180.0, 0.0]),
    ("left", [-90.0, 0.0]),
    ("top", [0.0, 90.0]),
    ("bottom", [0.0, -90.0]),
];

const VIEW: &str = "give front, back, left, right, top, bottom, or degrees around and above, like 30,20";
const SHARE: &str = "give a share above 0 and at most 1, like 0.1, or in percent, like 10%";
const COUNT: &str = "give a whole number above 0, like 5000, 10k or 1.5M, or a share of the input, like 10%";

/// Where an eye is, as degrees around and above: `front`, `30,20`.
pub fn view(text: &str) -> Result<[f32; 2], String> {
    if let Some((_, view)) = VIEWS.iter().find(|(name, _)| name.eq_ignore_ascii_case(text.trim())) {
        return Ok(*view);
    }
    let degrees = |word: &str| word.trim().parse().ok().filter(|number: &f32| (-360.0..=360.0).contains(number));
    let view = text.split_once(',').and_then(|(around, above)| Some([degrees(around)?, degrees(above)?]));
    view.ok_or(VIEW.into())
}

/// A share: `0.1`, `10%`.
pub fn share(text: &str) -> Result<f64, String> {
    let value = share_of(text).ok_or(SHARE)?;
    let meant = (1.0 < value && value <= 100.0 && !text.contains('%')).then_some(value);
    if is_share(value) { Ok(value) } else { Err(with_suggestion(SHARE, meant)) }
}

/// A share of the whole, or of what has a name.
#[derive(Clone, Debug, PartialEq)]
pub struct RatioOf {
    /// The name; none for the whole.
    pub name: Option<String>,
    /// The share, above 0 and at most 1.
    pub share: f64,
}

/// A share of the whole, or of what has a name: `10%`, `head=50%`.
pub fn ratio_of(text: &str) -> Result<RatioOf, String> {
    match text.rsplit_once('=') {
        Some((name, of)) if !name.is_empty() => Ok(RatioOf { name: Some(name.into()), share: share(of)? }),
        _ => Ok(RatioOf { name: None, share: share(text)? }),
    }
}

/// A number of vertices or faces: `5000`, `10k`, `1.5M`, `10%`.
pub fn count(text: &str) -> Result<Count, String> {
    if text.contains('%') {
        return share_of(text).filter(|share| is_share(*share)).map(Count::Share).ok_or(COUNT.into());
    }
    let (number, power) = match text.strip_suffix(['k', 'K']) {
        Some(number) => (number, 3),
        None => text.strip_suffix(['m', 'M']).map_or((text, 0), |number| (number, 6)),
    };
    let value = scaled(number, power).ok_or(COUNT)?;
    if value.fract() == 0.0 && (1.0..=MOST).contains(&value) {
        return Ok(Count::Number(value as usize));
    }
    Err(with_suggestion(COUNT, (0.0 < value && value < 1.0).then(|| percent(value))))
}

/// A whole number from `least` to `most`.
pub fn whole<N: TryFrom<u64>>(least: u64, most: u64) -> impl Fn(&str) -> Result<N, String> + Clone {
    move |text| {
        let value = text.trim().parse().ok().filter(|value| (least..=most).contains(value));
        value.and_then(|value| N::try_from(value).ok()).ok_or_else(|| match most {
            u64::MAX => format!("give a whole number of at least {least}"),
            most => format!("give a whole number from {least} to {most}"),
        })
    }
}

/// A number of threads.
pub fn n_threads(text: &str) -> Result<usize, String> {
    whole(1, MOST_THREADS)(text)
}

/// Texels a side of a texture.
pub fn texels(text: &str) -> Result<usize, String> {
    whole(TEXELS.0, TEXELS.1)(text)
}

/// A seed.
pub fn seed(text: &str) -> Result<u64, String> {
    whole(0, u64::MAX)(text)
}

/// What is taken for an amount of memory.
pub const GIB: &str = "a number of GiB above 0, like 4";

/// A number in range; `taken` says in words which.
pub fn number(taken: &'static str, is_in_range: fn(f64) -> bool) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| scaled(text, 0).filter(|value| is_in_range(*value)).ok_or_else(|| format!("give {taken}"))
}

fn is_share(value: f64) -> bool {
    value > 0.0 && value <= 1.0
}

/// The number before a `%` as its hundredth, any other as it is.
fn share_of(text: &str) -> Option<f64> {
    match text.trim().strip_suffix('%') {
        Some(percent) => scaled(percent, -2),
        None => scaled(text, 0),
    }
}

/// A number times a power of ten, rounded once: 0.7 % is 0.007, and no hundredth of what 0.7 is in doubles.
fn scaled(text: &str, power: i32) -> Option<f64> {
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
    fn a_view_is_a_name_or_two_numbers_of_degrees() {
        assert_eq!([view("Top"), view("-30, 12.5")], [Ok([0.0, 90.0]), Ok([-30.0, 12.5])]);
        for bad in ["", "up", "30", "30,", "1,2,3", "nan,0", "400,0"] {
            assert_eq!(view(bad), Err(VIEW.to_string()), "{bad}");
        }
    }

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
        let of = |name: &str, share| Ok(RatioOf { name: Some(name.into()), share });
        assert_eq!(ratio_of("10%"), Ok(RatioOf { name: None, share: 0.1 }));
        assert_eq!([ratio_of("head=50%"), ratio_of("a=b=0.2")], [of("head", 0.5), of("a=b", 0.2)]);
        assert!(ratio_of("head=").is_err() && ratio_of("=0.5").is_err() && ratio_of("head").is_err());
        assert!(ratio_of("head=50").unwrap_err().ends_with("did you mean 50%?"));
    }

    #[test]
    fn a_ratio_that_was_meant_in_percent_is_suggested() {
        assert!(share("50").unwrap_err().ends_with("; did you mean 50%?"));
        assert!(share("1.5").unwrap_err().ends_with("; did you mean 1.5%?"));
        assert!(count("0.07").unwrap_err().ends_with("; did you mean 7%?"));
    }

    #[test]
    fn counts_are_whole_numbers_with_suffixes_or_shares() {
        for (text, expected) in
            [("5000", 5000), ("10k", 10_000), ("10K", 10_000), ("1.5M", 1_500_000), ("2m", 2_000_000), ("1e3", 1000)]
        {
            assert_eq!(count(text), Ok(Count::Number(expected)), "{text}");
        }
        assert_eq!(count("10%"), Ok(Count::Share(0.1)));
        for text in ["", "k", "0", "-5", "1.0001k", "many", "10kk", "5 thousand", "0%", "200%", "nan", "1e99"] {
            assert!(count(text).unwrap_err().starts_with(COUNT), "{text}");
        }
    }

    #[test]
    fn a_share_of_so_many_is_whole_and_at_least_one() {
        for (text, n, expected) in [("29%", 100, 29), ("10%", 5856, 585), ("1%", 7, 1), ("100%", 7, 7), ("12", 7, 12)] {
            assert_eq!(count(text).unwrap().of(n), expected, "{text} of {n}");
        }
    }

    #[test]
    fn counts_are_told_as_typed() {
        for text in ["7%", "12.5%", "0.1%", "4000"] {
            assert_eq!(count(text).unwrap().to_string(), text);
        }
    }

    #[test]
    fn numbers_out_of_range_say_the_range() {
        assert_eq!(whole::<usize>(1, 8)("8"), Ok(8));
        assert_eq!(whole::<usize>(1, 8)("9"), Err("give a whole number from 1 to 8".into()));
        assert_eq!(whole::<u64>(0, u64::MAX)("18446744073709551615"), Ok(u64::MAX));
        assert_eq!(whole::<u64>(0, u64::MAX)("-1"), Err("give a whole number of at least 0".into()));
        let degrees = number("degrees from 0 to 180", |x| (0.0..=180.0).contains(&x));
        assert_eq!((degrees("30"), degrees("nan")), (Ok(30.0), Err("give degrees from 0 to 180".into())));
    }
}
