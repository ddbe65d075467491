//! CSV text as a table whose columns are found by name, through the `csv` crate.

use std::path::{Path, PathBuf};

use csv::{ReaderBuilder, StringRecord, Trim};

use super::text::{Place, decode};
use crate::error::{Error, Result};
use crate::math::Vec3;

/// Columns of words for people, which are not read.
const FREE_TEXT: [&str; 6] = ["how", "comment", "description", "desc", "note", "notes"];

/// A table with a header line.
pub(super) struct Table {
    path: PathBuf,
    names: Vec<String>,
    rows: Vec<StringRecord>,
}

/// Where the three coordinates of a point stand.
pub(super) type Columns3 = [usize; 3];

impl Table {
    /// Reads comma, semicolon or tab separated text. Lines beginning with `#` are left out. A
    /// first line of numbers only is no header: its columns are named `x,y,z` if there are three.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let text = decode(bytes);
        let first = text.lines().map(str::trim).find(|l| !l.is_empty() && !l.starts_with('#'));
        let first = first.ok_or_else(|| Error::parse(path, None, "the file is empty"))?;
        let delimiter = [b'\t', b';', b','].into_iter().find(|&d| first.contains(d as char));
        let delimiter = delimiter.unwrap_or(b',');
        let cells: Vec<&str> = first.split(delimiter as char).map(str::trim).collect();
        let bare = cells.iter().all(|cell| cell.parse::<f64>().is_ok());
        if bare && cells.len() != 3 {
            let message = "the first line must name the columns, for example x,y,z";
            return Err(Error::parse(path, None, message));
        }
        let mut reader = ReaderBuilder::new()
            .delimiter(delimiter)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .flexible(true)
            .has_headers(!bare)
            .from_reader(text.as_bytes());
        let wrong = |e: csv::Error| {
            let line = e.position().map(|p| p.line() as usize);
            Error::parse(path, line, e.to_string())
        };
        let names = if bare {
            ["x", "y", "z"].map(str::to_owned).to_vec()
        } else {
            reader.headers().map_err(wrong)?.iter().map(str::to_lowercase).collect()
        };
        let rows = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
        let table = Self { path: path.to_path_buf(), names, rows };
        table.check_lengths()?;
        Ok(table)
    }

    /// Each line needs one cell per column: a comma more or less (a decimal comma, say) would shift
    /// the numbers. Only a last column of free text may hold commas without quotes.
    fn check_lengths(&self) -> Result<()> {
        let expected = self.names.len();
        let free_text = self.names.last().is_some_and(|name| FREE_TEXT.contains(&name.as_str()));
        for row in self.rows() {
            let found = row.record.len();
            if found < expected || (found > expected && !free_text) {
                return Err(row.place().error(format!(
                    "the line has {found} columns, the line with the names {expected}"
                )));
            }
        }
        Ok(())
    }

    /// The first column with one of these names.
    pub fn column(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.names.iter().position(|own| own == name))
    }

    /// The columns `<prefix>x`, `<prefix>y`, `<prefix>z` (or `..._mm`) of the first prefix found.
    pub fn point_columns(&self, prefixes: &[&str]) -> Option<Columns3> {
        prefixes.iter().find_map(|prefix| {
            let column = |axis: &str| {
                self.column(&[&format!("{prefix}{axis}"), &format!("{prefix}{axis}_mm")])
            };
            Some([column("x")?, column("y")?, column("z")?])
        })
    }

    /// An error that lists the columns there are.
    pub fn missing(&self, wanted: &str) -> Error {
        let message =
            format!("columns {wanted} are needed, but the file has {}", self.names.join(", "));
        Error::parse(&self.path, 1, message)
    }

    /// The rows.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|record| Row { table: self, record })
    }
}

/// One row of a [`Table`].
#[derive(Clone, Copy)]
pub(super) struct Row<'a> {
    table: &'a Table,
    record: &'a StringRecord,
}

impl<'a> Row<'a> {
    pub fn place(&self) -> Place<'a> {
        let line = self.record.position().map_or(0, |p| p.line() as usize);
        Place { path: &self.table.path, line }
    }

    /// The text of a cell; none if it is empty.
    pub fn text(&self, column: usize) -> Option<&'a str> {
        self.record.get(column).filter(|cell| !cell.is_empty())
    }

    /// The text of a cell of an optional column.
    pub fn label(&self, column: Option<usize>) -> Option<String> {
        self.text(column?).map(str::to_owned)
    }

    /// A number in an optional column; none if the column or the cell's text is missing.
    pub fn number(&self, column: Option<usize>) -> Result<Option<f64>> {
        let Some((column, cell)) = column.and_then(|c| Some((c, self.text(c)?))) else {
            return Ok(None);
        };
        self.place().number(cell, &self.table.names[column]).map(Some)
    }

    /// A number of zero or more in an optional column.
    pub fn size(&self, column: Option<usize>) -> Result<Option<f64>> {
        let value = self.number(column)?;
        match (value, column) {
            (Some(value), Some(column)) if value < 0.0 => Err(self.place().error(format!(
                "{} is {value}; it must not be negative",
                self.table.names[column]
            ))),
            _ => Ok(value),
        }
    }

    /// A point whose coordinates must be there.
    pub fn point(&self, columns: Columns3) -> Result<Vec3> {
        let coordinate = |column: usize| {
            self.number(Some(column))?
                .ok_or_else(|| self.place().error(format!("{} is empty", self.table.names[column])))
        };
        let [x, y, z] = columns;
        Ok(Vec3::new(coordinate(x)?, coordinate(y)?, coordinate(z)?))
    }

    /// A vertex number counted from 0.
    pub fn vertex(&self, column: usize) -> Result<u32> {
        let cell = self.text(column).unwrap_or_default();
        let value = self.place().index(cell, &self.table.names[column])?;
        u32::try_from(value)
            .map_err(|_| self.place().error(format!("vertex {value} is too large a number")))
    }
}
