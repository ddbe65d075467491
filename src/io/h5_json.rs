//! HDF5 as JSON (`.h5.json`), as scalismo writes its statistical models: named arrays and strings in
//! groups. Only what those models need is known: hard links, numbers, strings.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Map, Value, json};

use crate::error::{Error, Result};

/// An array of numbers, last index fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct H5Array {
    /// Lengths along each index; empty for a single number.
    pub shape: Vec<usize>,
    /// The numbers.
    pub values: Vec<f64>,
    /// Whole numbers.
    pub integer: bool,
}

/// What a file holds, by path such as `model/mean`; attributes as `representer@name`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct H5Document {
    /// Arrays.
    pub arrays: BTreeMap<String, H5Array>,
    /// Strings.
    pub strings: BTreeMap<String, String>,
    /// String attributes of groups.
    pub attributes: BTreeMap<String, String>,
}

impl H5Document {
    /// Reads a file's text; `path` is for error messages.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let value: Value = serde_json::from_str(text).map_err(|e| {
            Error::parse(path, Some(e.line()).filter(|&l| l > 0), format!("not valid JSON: {e}"))
        })?;
        let fail = |message: String| Error::parse(path, None, message);
        let root = value["root"].as_str().ok_or_else(|| {
            fail("no \"root\"; this is not a file in the form of HDF5 as JSON".into())
        })?;
        let mut found = Self::default();
        // Groups still to be looked into; each is looked into once, so that links in a circle end.
        let mut left = vec![(String::new(), root.to_owned())];
        let mut seen = std::collections::HashSet::new();
        while let Some((at, id)) = left.pop() {
            if !seen.insert(id.clone()) {
                continue;
            }
            let group = &value["groups"][&id];
            for attribute in group["attributes"].as_array().into_iter().flatten() {
                if let (Some(name), Some(text)) =
                    (attribute["name"].as_str(), attribute["value"].as_str())
                {
                    found.attributes.insert(format!("{at}@{name}"), text.to_owned());
                }
            }
            for link in group["links"].as_array().into_iter().flatten() {
                let (Some(title), Some(id)) = (link["title"].as_str(), link["id"].as_str()) else {
                    continue;
                };
                let path = if at.is_empty() { title.into() } else { format!("{at}/{title}") };
                match link["collection"].as_str() {
                    Some("groups") => left.push((path, id.to_owned())),
                    // Many links to one large array would multiply it.
                    Some("datasets") if seen.insert(id.to_owned()) => {
                        found.take(&value["datasets"][id], path).map_err(fail)?;
                    }
                    _ => {}
                }
            }
        }
        Ok(found)
    }

    fn take(&mut self, dataset: &Value, path: String) -> Result<(), String> {
        let value = &dataset["value"];
        if dataset["type"]["class"] == "H5T_STRING" {
            let text = value.as_str().or_else(|| value[0].as_str()).unwrap_or_default();
            self.strings.insert(path, text.to_owned());
            return Ok(());
        }
        let mut values = Vec::new();
        flatten(value, &mut values).ok_or_else(|| format!("{path} is not an array of numbers"))?;
        let shape: Vec<usize> = match &dataset["shape"]["dims"] {
            Value::Array(dims) => dims.iter().map(|d| d.as_u64().map(|d| d as usize)).collect(),
            _ => Some(Vec::new()),
        }
        .ok_or_else(|| format!("the shape of {path} is not a list of sizes"))?;
        let count = shape.iter().try_fold(1_usize, |n, &d| n.checked_mul(d));
        if count != Some(values.len()) {
            return Err(format!("{path} has {} numbers for a shape of {shape:?}", values.len()));
        }
        let integer = dataset["type"]["class"] == "H5T_INTEGER";
        self.arrays.insert(path, H5Array { shape, values, integer });
        Ok(())
    }

    /// The text of a file.
    pub fn to_text(&self) -> String {
        let mut writer = Writer::default();
        writer.group("");
        for (path, text) in &self.attributes {
            if let Some((group, name)) = path.split_once('@') {
                let attribute =
                    json!({"name": name, "type": text_type(), "shape": scalar(), "value": text});
                writer.group(group).0.push(attribute);
            }
        }
        for (path, text) in &self.strings {
            writer.dataset(path, json!({"type": text_type(), "shape": scalar(), "value": text}));
        }
        for (path, array) in &self.arrays {
            writer.dataset(path, array_value(array));
        }
        writer.text()
    }
}

/// All numbers of nested arrays in their order; arrays are at most some levels deep, as the JSON reader
/// allows.
fn flatten(value: &Value, into: &mut Vec<f64>) -> Option<()> {
    if let Value::Array(items) = value {
        return items.iter().try_for_each(|item| flatten(item, into));
    }
    into.push(value.as_f64()?);
    Some(())
}

fn scalar() -> Value {
    json!({"class": "H5S_SCALAR"})
}

fn text_type() -> Value {
    json!({"class": "H5T_STRING", "charSet": "H5T_CSET_UTF8", "strPad": "H5T_STR_NULLTERM",
        "length": "H5T_VARIABLE"})
}

fn array_value(array: &H5Array) -> Value {
    let kind = if array.integer {
        json!({"class": "H5T_INTEGER", "base": "H5T_STD_I32LE"})
    } else {
        json!({"class": "H5T_FLOAT", "base": "H5T_IEEE_F32LE"})
    };
    let number = |x: &f64| if array.integer { json!(*x as i64) } else { json!(*x as f32) };
    let numbers: Vec<Value> = array.values.iter().map(number).collect();
    let (shape, value) = match array.shape.as_slice() {
        [] => (scalar(), numbers.into_iter().next().unwrap_or(Value::Null)),
        dims => {
            let width = dims.last().copied().unwrap_or(1).max(1);
            let value = if dims.len() == 2 {
                numbers.chunks(width).map(|row| Value::from(row.to_vec())).collect()
            } else {
                Value::from(numbers)
            };
            (json!({"class": "H5S_SIMPLE", "dims": dims}), value)
        }
    };
    json!({"type": kind, "shape": shape, "value": value})
}

/// Attributes and links of a group.
type Group = (Vec<Value>, Vec<Value>);

#[derive(Default)]
struct Writer {
    ids: BTreeMap<String, String>,
    groups: BTreeMap<String, Group>,
    datasets: Map<String, Value>,
}

impl Writer {
    fn next_id(&self) -> String {
        format!("00000000-0000-4000-8000-{:012x}", self.groups.len() + self.datasets.len())
    }

    /// The group of this path, made with all groups above it.
    fn group(&mut self, path: &str) -> &mut Group {
        let id = if let Some(id) = self.ids.get(path) {
            id.clone()
        } else {
            let id = self.next_id();
            self.ids.insert(path.to_owned(), id.clone());
            self.groups.insert(id.clone(), Group::default());
            if !path.is_empty() {
                self.link(path, "groups", &id);
            }
            id
        };
        self.groups.entry(id).or_default()
    }

    fn link(&mut self, path: &str, collection: &str, id: &str) {
        let (above, title) = path.rsplit_once('/').unwrap_or(("", path));
        let link =
            json!({"class": "H5L_TYPE_HARD", "title": title, "collection": collection, "id": id});
        self.group(above).1.push(link);
    }

    fn dataset(&mut self, path: &str, value: Value) {
        let above = path.rsplit_once('/').map_or("", |(above, _)| above);
        self.group(above);
        let id = self.next_id();
        self.datasets.insert(id.clone(), value);
        self.link(path, "datasets", &id);
    }

    fn text(self) -> String {
        let groups: Map<String, Value> = self
            .groups
            .into_iter()
            .map(|(id, (attributes, links))| {
                (id, json!({"attributes": attributes, "links": links}))
            })
            .collect();
        let root = &self.ids[""];
        json!({"apiVersion": "1.0.0", "root": root, "groups": groups, "datasets": self.datasets})
            .to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_survives_the_way_there_and_back() {
        let mut document = H5Document::default();
        let array = |shape: &[usize], integer| {
            let count: usize = shape.iter().product();
            let values = (0..count).map(|k| k as f64 * if integer { 1.0 } else { 0.25 }).collect();
            H5Array { shape: shape.to_vec(), values, integer }
        };
        document.arrays.insert("model/pcaBasis".into(), array(&[6, 2], false));
        document.arrays.insert("model/mean".into(), array(&[6], false));
        document.arrays.insert("version/majorVersion".into(), array(&[], true));
        document.strings.insert("modelinfo/build-time".into(), "today".into());
        document.attributes.insert("representer@name".into(), "itkStandardMeshRepresenter".into());
        let text = document.to_text();
        assert_eq!(H5Document::parse(&text, Path::new("a.h5.json")).unwrap(), document);
    }

    #[test]
    fn mistakes_are_named() {
        let message =
            |text: &str| H5Document::parse(text, Path::new("a.h5.json")).unwrap_err().to_string();
        assert!(message("{").contains("JSON"));
        assert!(message("{}").contains("root"));
        let file = |dims: &str, value: &str| {
            format!(
                r#"{{"root":"r","groups":{{"r":{{"links":[{{"title":"a","collection":"datasets","id":"d"}},
                {{"title":"g","collection":"groups","id":"r"}}]}}}},
                "datasets":{{"d":{{"shape":{{"dims":{dims}}},"type":{{"class":"H5T_FLOAT"}},"value":{value}}}}}}}"#
            )
        };
        assert!(message(&file("[3]", "[1, 2]")).contains("2 numbers"));
        assert!(message(&file("[18446744073709551615, 2]", "[1, 2]")).contains("2 numbers"));
        assert!(message(&file("[2]", "[1, \"x\"]")).contains("not an array"));
        assert!(H5Document::parse(&file("[2]", "[1, 2]"), Path::new("a")).is_ok());
    }
}
