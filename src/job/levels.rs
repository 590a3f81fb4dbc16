//! Parsers of levels of detail.

use super::choices::LodsBy;
use super::error::JobError;
use super::parse::{bound, faces, share, vertices};
use super::size::Goal;
use crate::simplify::Size;

/// Parses `--lods`.
///
/// # Errors
/// [`JobError::Options`] if a level is invalid or finer than the one before.
pub(super) fn levels(lods: &[String], by: Option<LodsBy>) -> Result<Goal, JobError> {
    if by == Some(LodsBy::Error) {
        let what = "rising distances, like 0.1%,0.5%,2%, all in percent or all in the unit of the mesh";
        return ordered(lods, bound, |before, next| before.is_at_most(*next), what).map(Goal::ErrorLevels);
    }
    let is_ordered = |before: &Size, next: &Size| match (*before, *next) {
        (Size::Ratio(before), Size::Ratio(next)) | (Size::FaceRatio(before), Size::FaceRatio(next)) => next <= before,
        (Size::Vertices(before), Size::Vertices(next)) | (Size::Faces(before), Size::Faces(next)) => next <= before,
        // A share and a number can be compared only when the mesh is known.
        _ => true,
    };
    let what = match by {
        None => "falling shares, like 50%,25%,10% or 0.5,0.25,0.1",
        Some(_) => "falling sizes, like 20k,5k,1k or 50%,25%,10% or 0.5,0.25,0.1",
    };
    ordered(lods, |text| size(text, by), is_ordered, what).map(Goal::Levels)
}

/// Parses levels, each of which must follow the one before; `what` they are otherwise is said.
fn ordered<T>(
    lods: &[String],
    parse: impl Fn(&str) -> Result<T, String>,
    is_ordered: impl Fn(&T, &T) -> bool,
    what: &str,
) -> Result<Vec<T>, JobError> {
    let parse = |text: &String| parse(text).map_err(|why| JobError::Options(format!("--lods {text}: {why}")));
    let levels: Vec<T> = lods.iter().map(parse).collect::<Result<_, _>>()?;
    if levels.windows(2).all(|pair| is_ordered(&pair[0], &pair[1])) {
        return Ok(levels);
    }
    Err(JobError::Options(format!("--lods: give {what}")))
}

// Without `by`, a level is a share of the vertices.
fn size(text: &str, by: Option<LodsBy>) -> Result<Size, String> {
    // Shares need no percent sign here.
    let or_share = |number: Result<Size, String>, ratio: fn(f64) -> Size| {
        number.or_else(|why| share(text).map(ratio).map_err(|_| why))
    };
    match by {
        Some(LodsBy::Faces) => or_share(faces(text), Size::FaceRatio),
        Some(_) => or_share(vertices(text), Size::Ratio),
        None => share(text).map(Size::Ratio).map_err(|why| match vertices(text) {
            Ok(Size::Vertices(n)) if n > 100 => "is a number: add --lods-by faces or --lods-by vertices".into(),
            _ => why,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Bound;

    fn parse_words(words: &[&str]) -> Result<Goal, String> {
        let (lods, by) = match words {
            [lods, "--lods-by", by] => (lods, Some(by)),
            lods => (&lods[0], None),
        };
        let by = by.map(|by| match *by {
            "faces" => LodsBy::Faces,
            "vertices" => LodsBy::Vertices,
            _ => LodsBy::Error,
        });
        let lods: Vec<String> = lods.split(',').map(String::from).collect();
        levels(&lods, by).map_err(|error| error.to_string())
    }

    #[test]
    fn levels_are_shares_of_vertices_unless_it_is_said_what_they_are_of() {
        for (words, sizes) in [
            (&["50%,0.1"][..], [Size::Ratio(0.5), Size::Ratio(0.1)]),
            (&["20k,1k", "--lods-by", "faces"], [Size::Faces(20_000), Size::Faces(1000)]),
            (&["10%,7", "--lods-by", "faces"], [Size::FaceRatio(0.1), Size::Faces(7)]),
            (&["0.5,10%", "--lods-by", "faces"], [Size::FaceRatio(0.5), Size::FaceRatio(0.1)]),
            (&["900,10%", "--lods-by", "vertices"], [Size::Vertices(900), Size::Ratio(0.1)]),
        ] {
            assert_eq!(parse_words(words), Ok(Goal::Levels(sizes.to_vec())), "{words:?}");
        }
        let bounds = [0.1, 2.0].map(Bound::Percent).to_vec();
        assert_eq!(parse_words(&["0.1%,2%", "--lods-by", "error"]), Ok(Goal::ErrorLevels(bounds)));
    }

    #[test]
    fn levels_that_are_none_are_refused_in_one_line() {
        for (words, why) in [
            (&["20k,5k"][..], "--lods 20k: is a number: add --lods-by faces or --lods-by vertices"),
            (&["50,20"], "did you mean 50%?"),
            (&["10%,50%"], "--lods: give falling shares"),
            (&["1k,2k", "--lods-by", "faces"], "--lods: give falling sizes"),
            (&["2%,1%", "--lods-by", "error"], "--lods: give rising distances"),
            (&["1%,2", "--lods-by", "error"], "all in percent or all in the unit"),
            (&["20k", "--lods-by", "error"], "--lods 20k: give a distance"),
            (&["many", "--lods-by", "faces"], "--lods many: give a whole number"),
        ] {
            let said = parse_words(words).unwrap_err();
            assert!(said.contains(why), "{words:?}: {said}");
        }
    }
}
