//! Parsers of levels of detail.

use super::choices::LodsBy;
use super::error::JobError;
use super::parse::{bound, count, share};
use super::size::{Bound, Count, Goal, LevelSize};

/// Parses `--lods`.
///
/// # Errors
/// [`JobError::Options`] if a level is invalid or finer than the one before.
pub(super) fn levels(lods: &[String], by: Option<LodsBy>) -> Result<Goal, JobError> {
    if by == Some(LodsBy::Error) {
        return checked_errors(parse_each(lods, bound)?).map(Goal::ErrorLevels);
    }
    let sizes: Vec<LevelSize> = parse_each(lods, |text| size(text, by))?;
    let grows = |pair: &[LevelSize]| match (pair[0].count(), pair[1].count()) {
        (Count::Share(before), Count::Share(next)) => next > before,
        (Count::Number(before), Count::Number(next)) => next > before,
        // A share and a number can be compared only when the mesh is known.
        _ => false,
    };
    if sizes.windows(2).any(grows) {
        let kind = if by.is_some() { "sizes, like 20k,5k,1k or" } else { "shares, like" };
        return Err(JobError::Options(format!("--lods: give falling {kind} 50%,25%,10% or 0.5,0.25,0.1")));
    }
    Ok(Goal::Levels(sizes))
}

fn parse_each<T>(lods: &[String], parse: impl Fn(&str) -> Result<T, String>) -> Result<Vec<T>, JobError> {
    let parse = |text: &String| parse(text).map_err(|why| JobError::Options(format!("--lods {text}: {why}")));
    lods.iter().map(parse).collect()
}

fn checked_errors(bounds: Vec<Bound>) -> Result<Vec<Bound>, JobError> {
    let rises = |pair: &[Bound]| match (pair[0], pair[1]) {
        (Bound::Percent(before), Bound::Percent(next)) | (Bound::Absolute(before), Bound::Absolute(next)) => {
            before <= next
        }
        _ => false,
    };
    if bounds.windows(2).all(rises) {
        return Ok(bounds);
    }
    let what = "--lods: give rising distances, like 0.1%,0.5%,2%, all in percent or all in the unit of the mesh";
    Err(JobError::Options(what.into()))
}

// Without `by`, a level is a share of the vertices.
fn size(text: &str, by: Option<LodsBy>) -> Result<LevelSize, String> {
    let number = || count(text).or_else(|why| share(text).map(Count::Share).map_err(|_| why));
    match by {
        Some(LodsBy::Faces) => number().map(LevelSize::Faces),
        Some(_) => number().map(LevelSize::Vertices),
        None => share(text).map(|ratio| LevelSize::Vertices(Count::Share(ratio))).map_err(|why| match count(text) {
            Ok(Count::Number(n)) if n > 100 => "is a number: add --lods-by faces or --lods-by vertices".into(),
            _ => why,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let vertices = |counts: &[Count]| Ok(Goal::Levels(counts.iter().map(|&it| LevelSize::Vertices(it)).collect()));
        let faces = |counts: &[Count]| Ok(Goal::Levels(counts.iter().map(|&it| LevelSize::Faces(it)).collect()));
        let [half, tenth] = [0.5, 0.1].map(Count::Share);
        assert_eq!(parse_words(&["50%,0.1"]), vertices(&[half, tenth]));
        assert_eq!(
            parse_words(&["20k,1k", "--lods-by", "faces"]),
            faces(&[Count::Number(20_000), Count::Number(1000)])
        );
        assert_eq!(parse_words(&["0.5,10%,7", "--lods-by", "faces"]), faces(&[half, tenth, Count::Number(7)]));
        assert_eq!(parse_words(&["900,10%", "--lods-by", "vertices"]), vertices(&[Count::Number(900), tenth]));
        let errors = parse_words(&["0.1%,2%", "--lods-by", "error"]);
        assert_eq!(errors, Ok(Goal::ErrorLevels(vec![Bound::Percent(0.1), Bound::Percent(2.0)])));
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
