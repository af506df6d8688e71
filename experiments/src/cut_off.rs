//! Whether a text that is not valid JSON is the beginning of one: its writer was stopped.

/// Whether an error is at the end of the text. Within a number the parser does not say so itself.
pub(crate) fn is_cut_off(json: &[u8], error: &serde_json::Error) -> bool {
    let mut lines = json.split(|&byte| byte == b'\n');
    let before: usize = lines.by_ref().take(error.line().saturating_sub(1)).map(|line| line.len() + 1).sum();
    let is_number = json.last().is_some_and(|byte| b"0123456789.eE+-".contains(byte));
    error.is_eof() || (is_number && before + error.column() >= json.len())
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    #[test]
    fn a_text_is_cut_off_wherever_it_ends_before_its_time() {
        let whole = "{\"a\": [1.25e-3, -7, null],\n \"b\": {\"c\": true, \"d\": \"x\\n\"}}";
        assert!(serde_json::from_str::<Value>(whole).is_ok());
        for end in 0..whole.len() {
            let json = &whole.as_bytes()[..end];
            let error = serde_json::from_slice::<Value>(json).unwrap_err();
            assert!(is_cut_off(json, &error), "{end}: {error}");
        }
        for wrong in ["name = 'small'\n", "{\"a\": 1e, \"b\": 2}", "[1, 2]]", "x", "{\"a\": tru, \"b\": 2}"] {
            let error = serde_json::from_str::<Value>(wrong).unwrap_err();
            assert!(!is_cut_off(wrong.as_bytes(), &error), "{wrong}: {error}");
        }
    }
}
