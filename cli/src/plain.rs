//! Escapes of characters that could control a terminal, or hide or reorder text.

use std::borrow::Cow;

/// Replaces every character that controls a terminal by its escape, such as `\u{1b}` or `\n`.
///
/// Backslashes stay, so that escaping twice changes nothing.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let escaped = |letter: char| if steers(letter) { letter.escape_default().to_string() } else { letter.to_string() };
    Cow::Owned(text.chars().map(escaped).collect())
}

/// Replaces control characters in JSON by JSON escapes, except line breaks.
pub fn plain_json(json: &str) -> String {
    let escaped = |letter: char| match letter {
        '\n' => "\n".to_string(),
        letter if steers(letter) => format!("\\u{:04x}", u32::from(letter)),
        letter => letter.to_string(),
    };
    json.chars().map(escaped).collect()
}

fn steers(letter: char) -> bool {
    let turns = ['\u{61c}', '\u{200e}', '\u{200f}'].contains(&letter)
        || ('\u{2028}'..='\u{202e}').contains(&letter)
        || ('\u{2066}'..='\u{2069}').contains(&letter);
    letter.is_control() || turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_is_spelled_out_and_nothing_else() {
        assert_eq!(plain("e\u{1b}[2J\u{9b}1m\u{7}\u{7f}"), "e\\u{1b}[2J\\u{9b}1m\\u{7}\\u{7f}");
        assert_eq!(plain("a\nb\rc\td"), "a\\nb\\rc\\td");
        assert_eq!(plain("\u{85}\u{2028}\u{2029}\u{202e}\u{2066}"), "\\u{85}\\u{2028}\\u{2029}\\u{202e}\\u{2066}");
        for harmless in ["spot.ply", "a\\b", "Käse, 木, 🐄, \u{a0}", ""] {
            assert!(matches!(plain(harmless), Cow::Borrowed(same) if same == harmless));
        }
    }

    #[test]
    fn plain_json_is_the_same_json() {
        let name = "e\u{1b}[2J\u{9b}1m\u{7f}\u{2028}\u{202e}\n\\ä";
        let json = serde_json::to_string_pretty(&serde_json::json!({ "file": name })).unwrap();
        let plain = plain_json(&json);
        assert!(!plain.contains(|letter: char| letter != '\n' && steers(letter)), "{plain:?}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&plain).unwrap()["file"], name);
    }

    #[test]
    fn twice_is_as_once() {
        let once = plain("\u{1b}]0;x\u{7}\\").into_owned();
        assert_eq!(plain(&once), once);
    }
}
