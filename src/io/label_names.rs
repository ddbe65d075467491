//! The names that segmentations keep for their labels: in a NIfTI file's extension, where TotalSegmentator and
//! Connectome Workbench write a Caret label table; in an NRRD file's segments, as 3D Slicer writes them.

use std::collections::BTreeMap;

/// Names by the number of the label.
pub type LabelNames = BTreeMap<u32, String>;

/// The labels of the first table in a text: `<Label Key="5"><![CDATA[liver]]></Label>`.
pub(super) fn caret_names(text: &str) -> Option<LabelNames> {
    const END: &str = "</LabelTable>";
    let begin = text.find("<LabelTable")?;
    let end = begin + text[begin..].find(END)? + END.len();
    let xml = roxmltree::Document::parse(&text[begin..end]).ok()?;
    let label = |node: roxmltree::Node| {
        let number = node.attribute("Key")?.trim().parse().ok()?;
        named(number, node.text()?)
    };
    let labels = xml.root_element().children().filter(|n| n.has_tag_name("Label"));
    Some(labels.filter_map(label).collect())
}

/// The names among the free texts of an NRRD header: `Segment0_Name:=liver` and `Segment0_LabelValue:=5`.
pub(super) fn segment_names(texts: &[(String, String)]) -> LabelNames {
    let mut segments: BTreeMap<&str, (Option<u32>, &str)> = BTreeMap::new();
    for (key, value) in texts {
        let Some((segment, field)) = key.split_once('_') else { continue };
        if !segment.starts_with("Segment") {
            continue;
        }
        let known = segments.entry(segment).or_default();
        match field {
            "Name" => known.1 = value,
            "LabelValue" => known.0 = value.trim().parse().ok(),
            _ => {}
        }
    }
    segments.into_values().filter_map(|(number, name)| named(number?, name)).collect()
}

/// Not the background, and not without a name.
fn named(number: u32, name: &str) -> Option<(u32, String)> {
    let name = name.trim();
    (number > 0 && !name.is_empty()).then(|| (number, name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_caret_table_names_labels() {
        let table = "<?xml version='1.0'?> <CaretExtension><LabelTable>\n<Label Key='0'>???</Label>\
                     <Label Key='5' Red='1'><![CDATA[liver]]></Label> <Label Key='x'>odd</Label><Label Key='6'/>\
                     </LabelTable></CaretExtension>\n   ";
        assert_eq!(caret_names(table), Some(LabelNames::from([(5, "liver".to_owned())])));
        for broken in
            ["", "<LabelTable><Label", "<LabelTable><Label Key='1'>a</LabelTable>", "</LabelTable>"]
        {
            assert_eq!(caret_names(broken), None, "{broken}");
        }
    }

    #[test]
    fn segments_of_slicer_name_labels() {
        let texts = [
            ("Segment0_Name", "liver"),
            ("Segment0_LabelValue", "5"),
            ("Segment1_Name", "kidney"),
            ("Segment12_LabelValue", "3"),
            ("Segment12_Name", " left kidney "),
            ("Note", "a"),
        ];
        let names = segment_names(&texts.map(|(key, value)| (key.to_owned(), value.to_owned())));
        assert_eq!(
            names,
            LabelNames::from([(3, "left kidney".to_owned()), (5, "liver".to_owned())])
        );
    }
}
