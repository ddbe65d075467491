//! The names that segmentations keep for their labels: in a NIfTI file's extension, where TotalSegmentator and
//! Connectome Workbench write a Caret label table; in an NRRD file's segments, as 3D Slicer writes them.

use std::collections::BTreeMap;
use std::io::Read;

use super::text;
use super::voxels::{self, Packing};

/// A header with its extensions is not longer; a broken one may say it is.
const MOST_BYTES: u64 = 1 << 24;
/// The extensions of a NIfTI-1 file begin after the header and four bytes.
const NIFTI_EXTENSIONS: usize = 352;

/// The names in a NIfTI file; none where it has no table that can be read.
pub fn nifti_label_names(bytes: &[u8]) -> BTreeMap<u32, String> {
    let packed = bytes.starts_with(&[0x1f, 0x8b]);
    let mut stream = voxels::unpack(bytes, if packed { Packing::Gzip } else { Packing::None });
    let Ok(head) = voxels::take(&mut stream, NIFTI_EXTENSIONS) else { return BTreeMap::new() };
    let offset = |bytes: [u8; 4]| [f32::from_le_bytes(bytes), f32::from_be_bytes(bytes)];
    let [little, big] = offset([head[108], head[109], head[110], head[111]]);
    let end = if (352.0..1e9).contains(&little) { little } else { big };
    let length = (end as u64).saturating_sub(NIFTI_EXTENSIONS as u64).min(MOST_BYTES);
    let mut extensions = Vec::new();
    if stream.take(length).read_to_end(&mut extensions).is_err() {
        return BTreeMap::new();
    }
    caret_names(&text::decode(&extensions)).unwrap_or_default()
}

/// The labels of the first table in a text: `<Label Key="5"><![CDATA[liver]]></Label>`.
fn caret_names(text: &str) -> Option<BTreeMap<u32, String>> {
    const END: &str = "</LabelTable>";
    let begin = text.find("<LabelTable")?;
    let end = begin + text[begin..].find(END)? + END.len();
    let xml = roxmltree::Document::parse(&text[begin..end]).ok()?;
    let label = |node: roxmltree::Node| {
        let number = node.attribute("Key")?.trim().parse().ok()?;
        named(number, node.text()?)
    };
    Some(
        xml.root_element()
            .children()
            .filter(|n| n.has_tag_name("Label"))
            .filter_map(label)
            .collect(),
    )
}

/// The names in an NRRD file's header: `Segment0_Name:=liver` and `Segment0_LabelValue:=5`.
pub fn nrrd_label_names(bytes: &[u8]) -> BTreeMap<u32, String> {
    let mut segments: BTreeMap<String, (Option<u32>, String)> = BTreeMap::new();
    let header = &bytes[..bytes.len().min(MOST_BYTES as usize)];
    let lines = header.split(|b| *b == b'\n').map(|line| text::decode(line).trim_end().to_owned());
    for line in lines.take_while(|line| !line.is_empty()) {
        let Some((key, value)) = line.split_once(":=") else { continue };
        let Some((segment, field)) = key.split_once('_') else { continue };
        if !segment.starts_with("Segment") {
            continue;
        }
        let known = segments.entry(segment.to_owned()).or_default();
        match field {
            "Name" => value.trim().clone_into(&mut known.1),
            "LabelValue" => known.0 = value.trim().parse().ok(),
            _ => {}
        }
    }
    segments.into_values().filter_map(|(number, name)| named(number?, &name)).collect()
}

/// Not the background, and not without a name.
fn named(number: u32, name: &str) -> Option<(u32, String)> {
    let name = name.trim();
    (number > 0 && !name.is_empty()).then(|| (number, name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nifti(extension: &str) -> Vec<u8> {
        let mut bytes = vec![0; NIFTI_EXTENSIONS];
        let end = (NIFTI_EXTENSIONS + 8 + extension.len()) as f32;
        bytes[108..112].copy_from_slice(&end.to_le_bytes());
        bytes.extend([0; 8]);
        bytes.extend(extension.as_bytes());
        bytes.extend(b"voxels <LabelTable><Label Key='9'>no</Label></LabelTable>");
        bytes
    }

    #[test]
    fn a_caret_table_names_labels() {
        let table = "<?xml version='1.0'?> <CaretExtension><LabelTable>\n<Label Key='0'>???</Label>\
                     <Label Key='5' Red='1'><![CDATA[liver]]></Label> <Label Key='x'>odd</Label><Label Key='6'/>\
                     </LabelTable></CaretExtension>\n   ";
        assert_eq!(nifti_label_names(&nifti(table)), BTreeMap::from([(5, "liver".to_owned())]));
        for broken in
            ["", "<LabelTable><Label", "<LabelTable><Label Key='1'>a</LabelTable>", "</LabelTable>"]
        {
            assert!(nifti_label_names(&nifti(broken)).is_empty(), "{broken}");
        }
        assert!(nifti_label_names(b"short").is_empty());
    }

    #[test]
    fn segments_of_slicer_name_labels() {
        let header = "NRRD0004\ntype: short\nSegment0_Name:=liver\r\nSegment0_LabelValue:=5\nSegment1_Name:=kidney\n\
                      Segment12_LabelValue:=3\nSegment12_Name:= left kidney \nNote:=a\n\nSegment3_Name:=no\n";
        let names = nrrd_label_names(header.as_bytes());
        assert_eq!(names, BTreeMap::from([(3, "left kidney".to_owned()), (5, "liver".to_owned())]));
    }
}
