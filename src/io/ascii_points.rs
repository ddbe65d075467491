//! Points as plain text: three numbers a line.

use std::path::Path;

use super::marker::Marker;
use super::text::{data_lines, decode};
use crate::error::Result;

/// Reads three numbers a line, separated by blanks, commas or semicolons; further columns are left
/// out, as is all after a `#`.
pub fn parse_xyz(bytes: &[u8], path: &Path) -> Result<Vec<Marker>> {
    data_lines(&decode(bytes), path)
        .map(|(place, line)| {
            let mut tokens = line
                .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|t| !t.is_empty());
            Ok(Marker::at(place.position(&mut tokens)?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn blanks_and_commas_separate_and_errors_name_the_line() {
        let parse = |text: &str| parse_xyz(text.as_bytes(), Path::new("a.xyz"));
        let markers = parse("# x y z\n1 2 3 255 0 0\r\n\n4,5;6 # last\n").unwrap();
        assert_eq!(markers.len(), 2);
        assert_eq!(markers[1].position, Vec3::new(4.0, 5.0, 6.0));
        let error = parse("1 2 3\n1 2\n").unwrap_err().to_string();
        assert_eq!(error, "a.xyz, line 2: the line ends before z");
        let error = parse("point 2 3\n").unwrap_err().to_string();
        assert!(error.contains("x is 'point', not a number"), "{error}");
    }
}
