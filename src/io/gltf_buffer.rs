//! The binary part of a glTF file and the accessors that describe it.

use serde_json::{Value, json};

/// Component types and targets of glTF.
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Target of attributes of vertices.
pub(super) const VERTEX: u32 = 34962;

/// Bytes with their views; the functions return the number of the new accessor.
#[derive(Default)]
pub(super) struct Buffer {
    pub bytes: Vec<u8>,
    pub views: Vec<Value>,
    pub accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view =
            json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Rows of `WIDTH` floats with their bounds.
    pub fn floats<const WIDTH: usize>(
        &mut self,
        rows: &[[f32; WIDTH]],
        kind: &str,
        target: Option<u32>,
    ) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..WIDTH).map(|k| rows.iter().map(|r| r[k]).reduce(pick).unwrap_or(0.0)).collect()
        };
        self.accessors.push(json!({
            "bufferView": view, "componentType": FLOAT, "count": rows.len(), "type": kind,
            "min": bound(f32::min), "max": bound(f32::max)
        }));
        self.accessors.len() - 1
    }

    /// Rows of small numbers of vertices.
    pub fn shorts<const WIDTH: usize>(&mut self, rows: &[[u16; WIDTH]], kind: &str) -> usize {
        let bytes: Vec<u8> = rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(VERTEX));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "count": rows.len(), "type": kind
        }));
        self.accessors.len() - 1
    }

    /// Corners of triangles.
    pub fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT,
            "count": 3 * triangles.len(), "type": "SCALAR"
        }));
        self.accessors.len() - 1
    }
}
