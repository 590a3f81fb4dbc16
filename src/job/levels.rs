//! Parsers of levels of detail.

use super::choices::LodsBy;
use super::error::JobError;
use super::parse::{bound, faces, share, vertices};
use super::size::Size;

/// Parses `--lods`.
///
/// # Errors
/// [`JobError::Options`] if a level is invalid or finer than the one before.
pub(super) fn levels(lods: &[String], by: Option<LodsBy>) -> Result<Vec<Size>, JobError> {
    let parse = |text: &String| size(text, by).map_err(|why| JobError::Options(format!("--lods {text}: {why}")));
    let sizes: Vec<Size> = lods.iter().map(parse).collect::<Result<_, _>>()?;
    let is_ordered = |pair: &[Size]| match (pair[0], pair[1]) {
        (Size::Ratio(before), Size::Ratio(next)) | (Size::FaceRatio(before), Size::FaceRatio(next)) => next <= before,
        (Size::Vertices(before), Size::Vertices(next)) | (Size::Faces(before), Size::Faces(next)) => next <= before,
        (Size::Error(before), Size::Error(next)) => before.is_at_most(next),
        // A share and a number can be compared only when the mesh is known.
        _ => true,
    };
    if sizes.windows(2).all(is_ordered) {
        return Ok(sizes);
    }
    Err(JobError::Options(match by {
        None => "--lods: give falling shares, like 50%,25%,10% or 0.5,0.25,0.1".into(),
        Some(LodsBy::Error) => {
            "--lods: give rising distances, like 0.1%,0.5%,2%, all in percent or all in the unit of the mesh".into()
        }
        Some(_) => "--lods: give falling sizes, like 20k,5k,1k or 50%,25%,10% or 0.5,0.25,0.1".into(),
    }))
}

// Without `by`, a level is a share of the vertices.
fn size(text: &str, by: Option<LodsBy>) -> Result<Size, String> {
    // Shares need no percent sign here.
    let or_share = |number: Result<Size, String>, ratio: fn(f64) -> Size| {
        number.or_else(|why| share(text).map(ratio).map_err(|_| why))
    };
    match by {
        Some(LodsBy::Error) => bound(text).map(Size::Error),
        Some(LodsBy::Faces) => or_share(faces(text), Size::FaceRatio),
        Some(LodsBy::Vertices) => or_share(vertices(text), Size::Ratio),
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

    fn parse_words(words: &[&str]) -> Result<Vec<Size>, String> {
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
            (&["0.1%,2%", "--lods-by", "error"], [0.1, 2.0].map(|percent| Size::Error(Bound::Percent(percent)))),
        ] {
            assert_eq!(parse_words(words), Ok(sizes.to_vec()), "{words:?}");
        }
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
