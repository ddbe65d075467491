//! Biovision motions (`.bvh`): a tree of joints with offsets, and channels over time.

use std::fmt::Write as _;
use std::path::Path;

use super::{read_bytes, write_beside};
use crate::error::{Error, Result};

/// Nodes at most in a hierarchy.
const MAX_NODES: usize = 10_000;

/// What one number of a frame moves; the axis is 0, 1 or 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhChannel {
    /// Position along an axis, the file's unit.
    Position(usize),
    /// Rotation about an axis, degrees.
    Rotation(usize),
}

/// A joint with the segment that hangs on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhNode {
    /// Name.
    pub name: String,
    /// Index of the node it hangs on, lower than its own; none for a root.
    pub parent: Option<usize>,
    /// Where it lies, seen from its parent's node, the file's unit.
    pub offset: [f64; 3],
    /// Its numbers in every frame; rotations are multiplied in their order.
    pub channels: Vec<BvhChannel>,
    /// Ends of the segment, seen from the node.
    pub ends: Vec<[f64; 3]>,
}

/// A file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhDocument {
    /// The hierarchy, parents first.
    pub nodes: Vec<BvhNode>,
    /// Seconds between frames.
    pub frame_seconds: f64,
    /// Numbers of every frame: the channels of all nodes in their order.
    pub frames: Vec<Vec<f64>>,
}

/// Reads a motion.
pub fn read_bvh(path: &Path) -> Result<BvhDocument> {
    parse_bvh(&read_bytes(path)?, path)
}

/// Words with the line they stand in.
struct Words<'a> {
    words: std::iter::Peekable<Box<dyn Iterator<Item = (usize, &'a str)> + 'a>>,
    line: usize,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        let words = text
            .lines()
            .enumerate()
            .flat_map(|(k, line)| line.split_whitespace().map(move |word| (k + 1, word)));
        let words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a> = Box::new(words);
        Self { words: words.peekable(), line: 0 }
    }

    fn next(&mut self) -> Result<&'a str, String> {
        let (line, word) = self.words.next().ok_or("the file ends too early")?;
        self.line = line;
        Ok(word)
    }

    fn expect(&mut self, wanted: &str) -> Result<(), String> {
        let word = self.next()?;
        if word.eq_ignore_ascii_case(wanted) {
            return Ok(());
        }
        Err(format!("\"{wanted}\" is expected, not \"{word}\""))
    }

    fn number(&mut self) -> Result<f64, String> {
        let word = self.next()?;
        let number = word.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| format!("\"{word}\" is not a finite number"))
    }

    fn three(&mut self) -> Result<[f64; 3], String> {
        Ok([self.number()?, self.number()?, self.number()?])
    }

    fn count(&mut self) -> Result<usize, String> {
        let word = self.next()?;
        word.parse().map_err(|_| format!("\"{word}\" is not a count"))
    }
}

/// Reads a motion from bytes; `path` is for error messages.
pub fn parse_bvh(bytes: &[u8], path: &Path) -> Result<BvhDocument> {
    let text = String::from_utf8_lossy(bytes);
    let mut words = Words::new(&text);
    document(&mut words)
        .map_err(|message| Error::parse(path, Some(words.line).filter(|&line| line > 0), message))
}

fn document(words: &mut Words) -> Result<BvhDocument, String> {
    words.expect("HIERARCHY").map_err(|e| format!("{e}; this is not a BVH file"))?;
    let mut found = BvhDocument { nodes: hierarchy(words)?, ..BvhDocument::default() };
    words.expect("Frames:")?;
    let frames = words.count()?;
    words.expect("Frame")?;
    words.expect("Time:")?;
    found.frame_seconds = words.number()?;
    if found.frame_seconds < 0.0 {
        return Err("the time of a frame is below 0".into());
    }
    let width: usize = found.nodes.iter().map(|n| n.channels.len()).sum();
    if width == 0 && frames > 0 {
        return Err("there are frames, but no node has a channel".into());
    }
    for _ in 0..frames {
        found.frames.push((0..width).map(|_| words.number()).collect::<Result<_, _>>()?);
    }
    match words.words.next() {
        Some((line, word)) => {
            words.line = line;
            Err(format!("\"{word}\" stands behind the last of {frames} frames"))
        }
        None => Ok(found),
    }
}

/// All nodes up to the word MOTION.
fn hierarchy(words: &mut Words) -> Result<Vec<BvhNode>, String> {
    let mut nodes: Vec<BvhNode> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    loop {
        let word = words.next()?.to_ascii_uppercase();
        match (word.as_str(), open.last().copied()) {
            ("MOTION", None) => break,
            ("ROOT", None) | ("JOINT", Some(_)) => {
                if nodes.len() >= MAX_NODES {
                    return Err(format!("more than {MAX_NODES} joints"));
                }
                let name = words.next()?.to_owned();
                words.expect("{")?;
                let parent = open.last().copied();
                open.push(nodes.len());
                nodes.push(BvhNode { name, parent, ..BvhNode::default() });
            }
            ("END", Some(node)) => {
                words.expect("Site")?;
                words.expect("{")?;
                words.expect("OFFSET")?;
                nodes[node].ends.push(words.three()?);
                words.expect("}")?;
            }
            ("OFFSET", Some(node)) => nodes[node].offset = words.three()?,
            ("CHANNELS", Some(node)) => {
                if !nodes[node].channels.is_empty() {
                    return Err(format!("joint {} has CHANNELS twice", nodes[node].name));
                }
                let count = words.count()?;
                if count > 6 {
                    return Err(format!("{count} channels; a joint has six at most"));
                }
                for _ in 0..count {
                    nodes[node].channels.push(channel(words.next()?)?);
                }
            }
            ("}", Some(_)) => drop(open.pop()),
            _ => return Err(format!("\"{word}\" is not expected here")),
        }
    }
    if nodes.is_empty() {
        return Err("there is no ROOT".into());
    }
    Ok(nodes)
}

fn channel(word: &str) -> Result<BvhChannel, String> {
    let bad = || format!("\"{word}\" is not a channel such as Xrotation or Yposition");
    let mut letters = word.chars();
    let axis = match letters.next().map(|c| c.to_ascii_uppercase()) {
        Some('X') => 0,
        Some('Y') => 1,
        Some('Z') => 2,
        _ => return Err(bad()),
    };
    match letters.as_str().to_ascii_lowercase().as_str() {
        "position" => Ok(BvhChannel::Position(axis)),
        "rotation" => Ok(BvhChannel::Rotation(axis)),
        _ => Err(bad()),
    }
}

/// Writes a motion.
pub fn write_bvh(path: &Path, document: &BvhDocument) -> Result<()> {
    let text = bvh_text(document);
    write_beside(path, |out| out.write_all(text.as_bytes()))
}

/// The text of a motion. Spaces in names become `_`.
pub fn bvh_text(document: &BvhDocument) -> String {
    let mut text = String::from("HIERARCHY\n");
    let roots = (0..document.nodes.len()).filter(|&n| document.nodes[n].parent.is_none());
    // Nodes still to be written, with their depth; the last comes first. `None` closes a bracket.
    let mut left: Vec<(Option<usize>, usize)> = roots.map(|n| (Some(n), 0)).collect();
    left.reverse();
    while let Some((node, depth)) = left.pop() {
        let indent = "  ".repeat(depth);
        let Some(n) = node else {
            let _ = writeln!(text, "{indent}}}");
            continue;
        };
        let node = &document.nodes[n];
        let kind = if node.parent.is_some() { "JOINT" } else { "ROOT" };
        let name = node.name.split_whitespace().collect::<Vec<_>>().join("_");
        let [x, y, z] = node.offset;
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "{indent}{kind} {name}\n{indent}{{\n{indent}  OFFSET {x:?} {y:?} {z:?}");
        let _ = write!(text, "{indent}  CHANNELS {}", node.channels.len());
        for channel in &node.channels {
            let _ = match channel {
                BvhChannel::Position(axis) => write!(text, " {}position", ["X", "Y", "Z"][*axis]),
                BvhChannel::Rotation(axis) => write!(text, " {}rotation", ["X", "Y", "Z"][*axis]),
            };
        }
        text.push('\n');
        for [x, y, z] in &node.ends {
            let _ = writeln!(
                text,
                "{indent}  End Site\n{indent}  {{\n{indent}    OFFSET {x:?} {y:?} {z:?}\n{indent}  }}"
            );
        }
        left.push((None, depth));
        let children = (0..document.nodes.len()).filter(|&c| document.nodes[c].parent == Some(n));
        left.extend(children.map(|c| (Some(c), depth + 1)).collect::<Vec<_>>().into_iter().rev());
    }
    let _ = writeln!(
        text,
        "MOTION\nFrames: {}\nFrame Time: {:?}",
        document.frames.len(),
        document.frame_seconds
    );
    for frame in &document.frames {
        text.push_str(&frame.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" "));
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALK: &str = "HIERARCHY\nROOT hip\n{\n OFFSET 0 1 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n JOINT knee\n {\n  OFFSET 0 -4 0\n  CHANNELS 1 Xrotation\n  End Site\n  {\n   OFFSET 0 -4 0\n  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0 10 20 30 -5\n1 0 0 11 21 31 -6\n";

    #[test]
    fn a_motion_survives_the_way_there_and_back() {
        let walk = parse_bvh(WALK.as_bytes(), Path::new("a.bvh")).unwrap();
        assert_eq!((walk.nodes.len(), walk.nodes[1].parent), (2, Some(0)));
        assert_eq!(walk.nodes[0].channels[3], BvhChannel::Rotation(2));
        assert_eq!(walk.frames[1], [1.0, 0.0, 0.0, 11.0, 21.0, 31.0, -6.0]);
        let again = parse_bvh(bvh_text(&walk).as_bytes(), Path::new("b.bvh")).unwrap();
        assert_eq!(again, walk);
    }

    #[test]
    fn mistakes_name_their_line() {
        let message =
            |text: &str| parse_bvh(text.as_bytes(), Path::new("a.bvh")).unwrap_err().to_string();
        assert!(message("ROOT").contains("not a BVH file"));
        assert!(message(&WALK.replace("Frames: 2", "Frames: 3")).contains("too early"));
        assert!(message(&WALK.replace("Frames: 2", "Frames: 1")).contains("line 20"));
        assert!(message(&WALK.replace("-4 0\n  CHANNELS", "x 0\n  CHANNELS")).contains("line 8"));
        assert!(message(&WALK.replace("1 Xrotation", "1 Wrotation")).contains("Wrotation"));
        assert!(message(&WALK.replace("-5\n", "nan\n")).contains("finite"));
        assert!(message(&WALK.replace("MOTION", "}")).contains("not expected"));
    }
}
