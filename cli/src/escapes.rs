//! Escapes of characters that could control a terminal, or hide or reorder text.

use std::borrow::Cow;

/// Replaces every character that controls a terminal or reorders text by its escape, such as `\u{1b}` or `\n`.
///
/// Backslashes stay, so that escaping twice changes nothing.
pub fn escape_controls(text: &str) -> Cow<'_, str> {
    if !text.contains(is_control_character) {
        return Cow::Borrowed(text);
    }
    let escaped = |letter: char| {
        if is_control_character(letter) { letter.escape_default().to_string() } else { letter.to_string() }
    };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// Replaces characters that control a terminal or reorder text by JSON escapes, except line breaks.
pub fn escape_controls_in_json(json: &str) -> String {
    let escaped = |letter: char| match letter {
        '\n' => "\n".to_string(),
        letter if is_control_character(letter) => format!("\\u{:04x}", u32::from(letter)),
        letter => letter.to_string(),
    };
    json.chars().map(escaped).collect()
}

fn is_control_character(letter: char) -> bool {
    let changes_direction = ['\u{61c}', '\u{200e}', '\u{200f}'].contains(&letter)
        || ('\u{2028}'..='\u{202e}').contains(&letter)
        || ('\u{2066}'..='\u{2069}').contains(&letter);
    letter.is_control() || changes_direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_nothing_else() {
        assert_eq!(escape_controls("e\u{1b}[2J\u{9b}1m\u{7}\u{7f}"), "e\\u{1b}[2J\\u{9b}1m\\u{7}\\u{7f}");
        assert_eq!(escape_controls("a\nb\rc\td"), "a\\nb\\rc\\td");
        assert_eq!(
            escape_controls("\u{85}\u{2028}\u{2029}\u{202e}\u{2066}"),
            "\\u{85}\\u{2028}\\u{2029}\\u{202e}\\u{2066}"
        );
        for harmless in ["spot.ply", "a\\b", "Käse, 木, 🐄, \u{a0}", ""] {
            assert!(matches!(escape_controls(harmless), Cow::Borrowed(same) if same == harmless));
        }
    }

    #[test]
    fn escaped_json_has_equal_values() {
        let name = "e\u{1b}[2J\u{9b}1m\u{7f}\u{2028}\u{202e}\n\\ä";
        let json = serde_json::to_string_pretty(&serde_json::json!({ "file": name })).unwrap();
        let escaped = escape_controls_in_json(&json);
        assert!(!escaped.contains(|letter: char| letter != '\n' && is_control_character(letter)), "{escaped:?}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&escaped).unwrap()["file"], name);
    }

    #[test]
    fn escaping_twice_changes_nothing() {
        let once = escape_controls("\u{1b}]0;x\u{7}\\").into_owned();
        assert_eq!(escape_controls(&once), once);
    }
}
