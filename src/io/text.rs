//! Lines and numbers of text files, with errors that name the line.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, Result};
use crate::math::Vec3;

/// The text without a byte order mark, with lines that end in `\n` alone: by others `csv` counts one too few.
/// Bytes that are not UTF-8 (old material names) are replaced.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    if text.contains("\r\n") { Cow::Owned(text.replace("\r\n", "\n")) } else { text }
}

/// A place in a file, for errors.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub path: &'a Path,
    /// 1-based.
    pub line: usize,
}

impl Place<'_> {
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::parse(self.path, self.line, message)
    }

    /// A finite number.
    pub fn number(&self, token: &str, what: &str) -> Result<f64> {
        match token.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(self.error(format!("{what} is {token}, not a finite number"))),
            Err(_) => Err(self.error(format!("{what} is '{}', not a number", shorten(token)))),
        }
    }

    /// A whole number, zero or above.
    pub fn index(&self, token: &str, what: &str) -> Result<usize> {
        token
            .parse()
            .map_err(|_| self.error(format!("{what} is '{}', not a whole number", shorten(token))))
    }

    /// The next token, which must be there.
    pub fn next<'t>(
        &self,
        tokens: &mut impl Iterator<Item = &'t str>,
        what: &str,
    ) -> Result<&'t str> {
        tokens.next().ok_or_else(|| self.error(format!("the line ends before {what}")))
    }

    /// The next three tokens as a position.
    pub fn position<'t>(&self, tokens: &mut impl Iterator<Item = &'t str>) -> Result<Vec3> {
        let mut coordinate = |what: &str| self.number(self.next(tokens, what)?, what);
        Ok(Vec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?))
    }
}

/// Non-empty lines with their 1-based numbers; what follows a `#` is left out.
pub(super) fn data_lines<'a>(
    text: &'a str,
    path: &'a Path,
) -> impl Iterator<Item = (Place<'a>, &'a str)> {
    text.lines().enumerate().filter_map(move |(i, line)| {
        let line = line.split('#').next().unwrap_or_default().trim();
        (!line.is_empty()).then_some((Place { path, line: i + 1 }, line))
    })
}

/// The first characters of a text that may be long, for error sentences.
pub(super) fn shorten(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(40) {
        Some((end, _)) => Cow::Owned(format!("{}...", &text[..end])),
        None => Cow::Borrowed(text),
    }
}
