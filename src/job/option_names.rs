//! Options by name from other languages, and messages in the words of these languages.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::arguments::Arguments;
use super::error::JobError;
use crate::io::shorten_name;

/// Least similarity (Jaro-Winkler) of a name to the one that is suggested for it; that of the crate `clap`.
const SIMILARITY: f64 = 0.7;

/// Options of callers that are on or off, besides those of [`Arguments`].
const FLAGS_OF_CALLERS: [&str; 3] = ["force", "strict", "resume"];

/// Language of a caller, which decides how messages name options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Caller {
    /// Keyword arguments.
    Python,
    /// Properties of an object.
    JavaScript,
}

/// Reads options by name from JSON.
///
/// # Errors
/// [`JobError::Options`] names the option, and for an unknown one the nearest known.
///
/// ```
/// use neural_mesh::job::{Arguments, read_options};
/// let read = |text| read_options::<Arguments>(serde_json::from_str(text).unwrap()).map_err(|error| error.to_string());
/// assert_eq!(read(r#"{"rato": 0.1}"#).unwrap_err(), "no such option: rato; did you mean ratio?");
/// assert_eq!(read(r#"{"keep": "wheel"}"#).unwrap_err(), "--keep wheel: give a list");
/// ```
pub fn read_options<T: DeserializeOwned>(options: Value) -> Result<T, JobError> {
    let by_name = || JobError::Options("options: give values by name".into());
    let Value::Object(options) = options else { return Err(by_name()) };
    let mut given = Map::new();
    // Each option is tried alone, since an error of the whole does not say which one is wrong.
    for (name, value) in options {
        match read_alone::<T>(&name, &value) {
            Ok(_) => drop(given.insert(name, value)),
            // An option that is null is not given.
            Err(error) if error.starts_with("invalid type: null") => {}
            Err(error) => return Err(describe(&name, &value, &error)),
        }
    }
    serde_json::from_value(Value::Object(given)).map_err(|_| by_name())
}

fn read_alone<T: DeserializeOwned>(name: &str, value: &Value) -> Result<T, String> {
    let alone = Value::Object(Map::from_iter([(name.to_string(), value.clone())]));
    serde_json::from_value(alone).map_err(|error| error.to_string())
}

/// Describes a rejected option by the words of serde.
fn describe(name: &str, value: &Value, error: &str) -> JobError {
    if let Some((_, known)) = error.strip_prefix("unknown field").and_then(|rest| rest.split_once("expected")) {
        let known = known.split('`').skip(1).step_by(2);
        let near =
            known.map(|other| (strsim::jaro_winkler(name, other), other)).filter(|(share, _)| *share > SIMILARITY);
        let nearest = near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, other)| format!("; did you mean {other}?"));
        return JobError::Options(format!("no such option: {}{}", shorten_name(name), nearest.unwrap_or_default()));
    }
    let rejected = |text: &str, what: &str| {
        JobError::Options(format!("--{} {}: {what}", name.replace('_', "-"), shorten_name(text)))
    };
    // A parser's reason follows the value in backticks; serde's names of choices are in backticks, too.
    if let Some((text, why)) = error.strip_prefix('`').and_then(|error| error.rsplit_once("`: ")) {
        return rejected(text, why);
    }
    if error.starts_with("unknown variant") {
        let mut quoted = error.split('`').skip(1).step_by(2);
        let (text, names) = (quoted.next().unwrap_or_default(), quoted.collect::<Vec<_>>());
        return rejected(text, &format!("choose from {}", names.join(", ")));
    }
    let text = value.as_str().map_or_else(|| value.to_string(), String::from);
    let expected = error.rsplit("expected ").next().unwrap_or_default();
    rejected(
        &text,
        match expected {
            "a sequence" => "give a list",
            "a boolean" => "give true or false",
            "a string" | "path string" | "string or map" => "give a text",
            "u64" | "usize" => "give a whole number of at least 0",
            "f64" => "give a number",
            "a map" => "give values by name",
            _ => "give a number or a text",
        },
    )
}

/// Spells the options in a message as a caller writes them: `--keep-features` becomes `keep_features=True` in Python.
///
/// ```
/// use neural_mesh::job::{Caller, respell_options};
/// let text = "--ratio 10: give a share, or leave --no-weld out";
/// assert_eq!(respell_options(text, Caller::Python), "ratio=10: give a share, or leave weld=False out");
/// assert_eq!(respell_options(text, Caller::JavaScript), "ratio 10: give a share, or leave no_weld out");
/// ```
pub fn respell_options(text: &str, caller: Caller) -> String {
    let mut parts = text.split("--");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |said, part| {
        let end = part.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-').unwrap_or(part.len());
        let (name, rest) = part.split_at(end);
        // Anything but a name was no option.
        if name.is_empty() { said + "--" + part } else { said + &respell(&name.replace('-', "_"), rest, caller) }
    })
}

/// Returns whether an option is on or off.
fn is_flag(name: &str) -> bool {
    let is_of_job = || read_alone::<Arguments>(name, &Value::from(0)).is_err_and(|error| error.ends_with("a boolean"));
    FLAGS_OF_CALLERS.contains(&name) || is_of_job()
}

fn respell(name: &str, rest: &str, caller: Caller) -> String {
    if let ("ratio", Some(rest)) = (name, rest.strip_prefix(" NAME=R")) {
        return format!("ratio_of{rest}");
    }
    // Where a colon follows, the next word is the value.
    let value = rest.strip_prefix(' ').filter(|_| caller == Caller::Python);
    let value = value.filter(|value| value.split_once(':').is_some_and(|(value, _)| !value.contains(' ')));
    match (caller, name.strip_prefix("no_")) {
        (Caller::Python, Some(positive)) => return format!("{positive}=False{rest}"),
        (Caller::Python, None) if value.is_none() && is_flag(name) => return format!("{name}=True{rest}"),
        (Caller::Python, None) if name == "for" => return format!("for_{rest}"),
        _ => {}
    }
    value.map_or_else(|| format!("{name}{rest}"), |value| format!("{name}={value}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_named_as_the_caller_writes_them() {
        for (text, python) in [
            ("a.ply: exists already: choose another name, or replace it with --force", "or replace it with force=True"),
            ("--keep-features: not available", "keep_features=True: not available"),
            ("--keep-features yes: give true or false", "keep_features=yes: give true or false"),
            (
                "--ratio NAME=R cannot be used with --for: leave one out",
                "ratio_of cannot be used with for_: leave one out",
            ),
            ("--bake 5 6: a", "bake 5 6: a"),
            ("a -- b --", "a -- b --"),
        ] {
            let said = respell_options(text, Caller::Python);
            assert!(said.ends_with(python), "{said}");
        }
        assert_eq!(respell_options("leave --keep-features out", Caller::JavaScript), "leave keep_features out");
    }

    #[test]
    fn rejected_options_say_what_to_give() {
        let refused = |json| read_options::<Arguments>(serde_json::from_str(json).unwrap()).unwrap_err().to_string();
        assert_eq!(
            refused(r#"{"ratio": 0.1, "keep_feature": true}"#),
            "no such option: keep_feature; did you mean keep_features?"
        );
        assert_eq!(refused(r#"{"xyzzy": 1}"#), "no such option: xyzzy");
        assert_eq!(refused(r#"{"effort": 3}"#), "--effort 3: give a text");
        assert!(read_options::<Arguments>(serde_json::json!({"ratio": 0.5, "effort": null})).is_ok());
        assert_eq!(refused(r#"{"seed": -1}"#), "--seed -1: give a whole number of at least 0");
        assert_eq!(refused(r#"{"lock_boundaries": "yes"}"#), "--lock-boundaries yes: give true or false");
        assert_eq!(refused("[]"), "options: give values by name");
    }
}
