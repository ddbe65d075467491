//! Job files: TOML, with errors that name the line.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// What the text of a job file says; `path` serves the error sentences.
pub(super) fn parse_job_file<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T> {
    if let Some(line) = text.lines().position(has_a_plain_backslash) {
        let message =
            "in \"...\" a backslash must be doubled: write the path in '...', or with / instead";
        return Err(Error::parse(path, line + 1, message));
    }
    toml::from_str(text).map_err(|e| {
        let line = e.span().map(|span| text[..span.start].matches('\n').count() + 1);
        let message = e.message().split_whitespace().collect::<Vec<_>>().join(" ");
        Error::parse(path, line, message)
    })
}

/// Whether a string in "..." has a backslash before anything but a backslash, a quote or the number of a letter.
/// Windows' paths have them, and TOML would read "C:\temp\new.obj" with a tab and a line end in it.
fn has_a_plain_backslash(line: &str) -> bool {
    let mut open = None;
    let mut letters = line.chars();
    while let Some(letter) = letters.next() {
        match (open, letter) {
            (None, '#') => return false,
            (None, '"' | '\'') => open = Some(letter),
            (Some('"'), '\\') => match letters.next() {
                Some('\\' | '"') => {}
                Some('u' | 'U')
                    if letters.clone().next().is_some_and(|c| c.is_ascii_hexdigit()) => {}
                _ => return true,
            },
            (Some(quote), _) if quote == letter => open = None,
            _ => {}
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn out_of(line: &str) -> Result<toml::Table> {
        parse_job_file(&format!("tolerance = 0.3\n{line}\n"), Path::new("case/job.toml"))
    }

    #[test]
    fn a_path_of_windows_is_read_or_refused_in_words() {
        for line in [
            r#"out = "C:\data\x.obj""#,
            r#"out = "C:\temp\new.obj""#,
            r#"out = "C:\users\anna\x.obj""#,
            r#"markers = ['a\b.csv', "a\b.csv"] # both"#,
        ] {
            let error = out_of(line).unwrap_err().to_string();
            assert!(error.starts_with("case/job.toml, line 2: in \"...\" a backslash"), "{error}");
        }
        for (line, path) in [
            (r"out = 'C:\data\x.obj'", r"C:\data\x.obj"),
            (r#"out = "C:\\data\\x.obj" # as in "C:\data""#, r"C:\data\x.obj"),
            (r#"out = "C:/data/x.obj""#, "C:/data/x.obj"),
            (r#"out = "L\u00e4nge \"1\".obj""#, "Länge \"1\".obj"),
        ] {
            assert_eq!(out_of(line).unwrap()["out"].as_str(), Some(path));
        }
    }
}
