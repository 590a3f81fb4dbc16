//! An external program as a method.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::baselines::TargetCounts;

// Extensions allowed in placeholders such as `{in.obj}`; `{in}` means `ply`.
const ENDINGS: [&str; 4] = ["ply", "obj", "stl", "off"];

/// An external program with mesh files as input and output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tool {
    /// Name: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// Command line, split as in a shell.
    pub command: String,
}

pub(super) struct Placeholders<'a> {
    // Paths are without extensions.
    pub input: &'a Path,
    pub output: &'a Path,
    pub ratio: f64,
    pub size: TargetCounts,
}

impl Tool {
    /// Parses `NAME=command {in} {out} {ratio}`.
    ///
    /// # Errors
    /// One line for an invalid name, open quotes, or a missing `{in}` or `{out}`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let refusal = |what: &str| format!("tool {text}: {what}");
        let (name, command) = text.split_once('=').ok_or_else(|| refusal("give NAME='command {in} {out}'"))?;
        let is_name = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || !name.chars().all(is_name) {
            return Err(refusal("a name consists of letters, digits, - _ and ."));
        }
        if shlex::split(command).is_none_or(|words| words.is_empty()) {
            return Err(refusal("the command is empty or its quotes do not close: check it"));
        }
        let tool = Self { name: name.into(), command: command.into() };
        for place in ["in", "out"] {
            tool.ending(place).ok_or_else(|| refusal(&format!("it has no {{{place}}}: say where the file goes")))?;
        }
        Ok(tool)
    }

    pub(super) fn ending(&self, name: &str) -> Option<&'static str> {
        let asks = |ending: &&str| self.command.contains(&format!("{{{name}.{ending}}}"));
        let plain = self.command.contains(&format!("{{{name}}}")).then_some("ply");
        plain.or_else(|| ENDINGS.into_iter().find(asks))
    }

    pub(super) fn words(&self, given: &Placeholders) -> Vec<String> {
        let words = shlex::split(&self.command).unwrap_or_default();
        words.into_iter().map(|word| fill_placeholders(word, given)).collect()
    }
}

fn fill_placeholders(word: String, given: &Placeholders) -> String {
    let Placeholders { input, output, ratio, size } = given;
    let mut word = word.replace("{ratio}", &ratio.to_string());
    word = word.replace("{faces}", &size.faces.to_string()).replace("{vertices}", &size.vertices.to_string());
    for (name, path) in [("in", input), ("out", output)] {
        for ending in ENDINGS {
            let file = path.with_extension(ending).display().to_string();
            word = word.replace(&format!("{{{name}.{ending}}}"), &file);
        }
        word = word.replace(&format!("{{{name}}}"), &path.with_extension("ply").display().to_string());
    }
    word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_filled_and_words_kept_together() {
        let tool = Tool::parse("mine='a b' -r {ratio} {in.obj} --out={out} -n{faces}:{vertices}").unwrap();
        assert_eq!((tool.ending("in"), tool.ending("out")), (Some("obj"), Some("ply")));
        let size = TargetCounts { vertices: 12, faces: 20 };
        let given = Placeholders { input: "/x y/in".as_ref(), output: "out".as_ref(), ratio: 0.5, size };
        assert_eq!(tool.words(&given), ["a b", "-r", "0.5", "/x y/in.obj", "--out=out.ply", "-n20:12"]);
    }

    #[test]
    fn malformed_tools_are_refused() {
        for text in ["cmd {in} {out}", "=cmd {in} {out}", "a b=cmd {in} {out}", "a=", "a=cmd {in}", "a='cmd {in} {out}"]
        {
            assert!(Tool::parse(text).is_err(), "{text}");
        }
    }
}
