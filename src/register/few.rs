//! Lists in sentences.

/// The first `most` of the words, and how many more there are: `a, b and 3 more`.
pub fn few(words: &[impl AsRef<str>], most: usize) -> String {
    let first: Vec<&str> = words.iter().take(most).map(AsRef::as_ref).collect();
    match words.len().saturating_sub(most) {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}
