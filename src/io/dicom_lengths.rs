//! Lengths in DICOM files, checked before a file is handed to the DICOM crates: these reserve
//! memory for whatever length an element claims.

use dicom_object::{DefaultDicomObject, Tag};

const UNDEFINED: u32 = u32::MAX;
const PREAMBLE: usize = 128;
const ITEM: (u16, u16) = (0xfffe, 0xe000);
const SEQUENCE_END: (u16, u16) = (0xfffe, 0xe0dd);
const PIXELS: (u16, u16) = (0x7fe0, 0x0010);
const TRANSFER_SYNTAX: (u16, u16) = (0x0002, 0x0010);
const IMPLICIT: &str = "1.2.840.10008.1.2";
const BIG_ENDIAN: &str = "1.2.840.10008.1.2.2";
const DEFLATED: &str = "1.2.840.10008.1.2.1.99";
/// Value representations with a length of four bytes.
const LONG: [&[u8; 2]; 13] =
    [b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"];

/// Value representations with a length of two bytes. All others are read as unknown, with four.
const SHORT: [&[u8; 2]; 21] = [
    b"AE", b"AS", b"AT", b"CS", b"DA", b"DS", b"DT", b"FD", b"FL", b"IS", b"LO", b"LT", b"PN",
    b"SH", b"SL", b"SS", b"ST", b"TM", b"UI", b"UL", b"US",
];

/// Whether the mark of a DICOM file is there.
pub(super) fn looks_like_dicom(bytes: &[u8]) -> bool {
    bytes.get(PREAMBLE..PREAMBLE + 4) == Some(b"DICM")
}

/// How the elements of a part are written.
#[derive(Clone, Copy)]
struct Syntax {
    implicit: bool,
    big_endian: bool,
}

/// One element's head.
struct Head {
    tag: (u16, u16),
    length: u32,
    unknown: bool,
    sequence: bool,
    /// Where its value begins.
    value: usize,
}

/// Fails if an element, at any depth, claims more bytes than the file has.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    if !looks_like_dicom(bytes) {
        return Err("no DICOM file: the mark 'DICM' is missing".to_owned());
    }
    let mut syntax = Syntax { implicit: false, big_endian: false };
    let mut name = String::new();
    let mut at = PREAMBLE + 4;
    while at + 8 <= bytes.len() && bytes[at..at + 2] == [2, 0] {
        let head = head(bytes, at, syntax).ok_or_else(|| cut(at))?;
        let end = end_of(&head, bytes.len())?;
        if head.tag == TRANSFER_SYNTAX {
            let text = String::from_utf8_lossy(&bytes[head.value..end]);
            text.trim_end_matches(['\0', ' ']).clone_into(&mut name);
        }
        at = end;
    }
    match name.as_str() {
        IMPLICIT => syntax.implicit = true,
        BIG_ENDIAN => syntax.big_endian = true,
        DEFLATED => {
            return Err("the file is deflated as a whole; save it uncompressed".to_owned());
        }
        _ => {}
    }
    walk(bytes, at, syntax)
}

/// All elements one after the other; sequences are entered, not skipped.
fn walk(bytes: &[u8], mut at: usize, syntax: Syntax) -> Result<(), String> {
    // How the sequences of undefined length around this place are written.
    let mut around = vec![syntax];
    let mut in_fragments = false;
    while at + 8 <= bytes.len() {
        let syntax = around.last().copied().unwrap_or(syntax);
        let head = head(bytes, at, syntax).ok_or_else(|| cut(at))?;
        let defined = head.length != UNDEFINED;
        let end = if defined { end_of(&head, bytes.len())? } else { head.value };
        at = match head.tag {
            SEQUENCE_END => {
                in_fragments = false;
                if around.len() > 1 {
                    around.pop();
                }
                head.value
            }
            ITEM if in_fragments => end,
            (0xfffe, _) => head.value,
            tag if !defined => {
                in_fragments = tag == PIXELS;
                // Unknown elements of undefined length are sequences in implicit form.
                around.push(Syntax { implicit: syntax.implicit || head.unknown, ..syntax });
                head.value
            }
            tag if tag != PIXELS && (head.sequence || begins_with_item(bytes, head.value)) => {
                head.value
            }
            _ => end,
        };
    }
    Ok(())
}

fn begins_with_item(bytes: &[u8], at: usize) -> bool {
    matches!(bytes.get(at..at + 4), Some([0xfe, 0xff, 0x00, 0xe0] | [0xff, 0xfe, 0xe0, 0x00]))
}

fn head(bytes: &[u8], at: usize, syntax: Syntax) -> Option<Head> {
    let two = |at: usize| {
        let pair = [*bytes.get(at)?, *bytes.get(at + 1)?];
        Some(if syntax.big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) })
    };
    let four = |at: usize| {
        let (a, b) = (u32::from(two(at)?), u32::from(two(at + 2)?));
        Some(if syntax.big_endian { a << 16 | b } else { b << 16 | a })
    };
    let tag = (two(at)?, two(at + 2)?);
    if syntax.implicit || tag.0 == 0xfffe {
        let (unknown, sequence) = (false, false);
        return Some(Head { tag, length: four(at + 4)?, unknown, sequence, value: at + 8 });
    }
    let kind = bytes.get(at + 4..at + 6)?;
    let short = SHORT.iter().any(|known| kind == *known);
    let known = short || LONG.iter().any(|long| kind == *long);
    let (unknown, sequence) = (kind == b"UN" || !known, kind == b"SQ");
    if !short {
        return Some(Head { tag, length: four(at + 8)?, unknown, sequence, value: at + 12 });
    }
    Some(Head { tag, length: u32::from(two(at + 6)?), unknown, sequence, value: at + 8 })
}

fn end_of(head: &Head, length: usize) -> Result<usize, String> {
    let end = head.value.checked_add(head.length as usize).filter(|end| *end <= length);
    end.ok_or_else(|| {
        format!(
            "element ({:04x},{:04x}) claims {} bytes, but the file ends before; it is cut short",
            head.tag.0, head.tag.1, head.length
        )
    })
}

fn cut(at: usize) -> String {
    format!("the file ends within the element at byte {at}; it is cut short")
}

/// Fails if a JPEG inside claims another size than the slice: its decoder reserves what it claims.
pub(super) fn check_jpeg(
    object: &DefaultDicomObject,
    pixels: Tag,
    rows: usize,
    columns: usize,
) -> Result<(), String> {
    let Some(fragments) = object.get(pixels).and_then(|e| e.value().fragments()) else {
        return Ok(());
    };
    for fragment in fragments {
        let Some(size) = jpeg_size(fragment) else { continue };
        if size != [rows, columns] {
            return Err(format!(
                "the JPEG inside has {} x {} pixels, the slice {columns} x {rows}",
                size[1], size[0]
            ));
        }
    }
    Ok(())
}

/// Rows and columns in the frame header of a JPEG.
fn jpeg_size(bytes: &[u8]) -> Option<[usize; 2]> {
    let mut at = 2;
    if bytes.get(..2)? != [0xff, 0xd8] {
        return None;
    }
    loop {
        let (mark, kind) = (*bytes.get(at)?, *bytes.get(at + 1)?);
        if mark != 0xff {
            return None;
        }
        // Fill bytes and marks without content.
        if kind == 0xff || kind == 0x01 || (0xd0..=0xd8).contains(&kind) {
            at += if kind == 0xff { 1 } else { 2 };
            continue;
        }
        let two =
            |at: usize| Some(usize::from(*bytes.get(at)?) << 8 | usize::from(*bytes.get(at + 1)?));
        if (0xc0..=0xcf).contains(&kind) && ![0xc4, 0xc8, 0xcc].contains(&kind) {
            return Some([two(at + 5)?, two(at + 7)?]);
        }
        at += 2 + two(at + 2)?;
    }
}
