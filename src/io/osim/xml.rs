//! Small questions to the nodes of a model.

use roxmltree::{Document, Node};

use crate::math::Vec3;

/// Whether a node is an object of a set: `names` are its grandparent's and its parent's.
pub fn parent_named(node: &Node, names: [&str; 2]) -> bool {
    let named = |n: Option<Node>, name: &str| n.is_some_and(|n| n.has_tag_name(name));
    node.is_element()
        && named(node.parent(), names[1])
        && named(node.parent().and_then(|p| p.parent()), names[0])
}

/// The objects of a set of the model, such as its joints.
pub fn objects<'a>(xml: &'a Document<'a>, set: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    xml.descendants().filter(move |n| parent_named(n, [set, "objects"]))
}

/// The line of the file a node begins in.
pub fn row(node: &Node) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

/// The value of a node's `name`.
pub fn name<'a>(node: &Node<'a, '_>) -> &'a str {
    node.attribute("name").unwrap_or_default()
}

/// The text of a child element.
pub fn child_text(node: &Node, name: &str) -> Option<String> {
    let child = node.children().find(|n| n.has_tag_name(name))?;
    Some(child.text().unwrap_or_default().trim().to_string())
}

/// The numbers of a child element.
pub fn child_numbers(node: &Node, name: &str) -> Option<Vec<f64>> {
    numbers(&child_text(node, name)?)
}

/// The one number of a child element.
pub fn child_number(node: &Node, name: &str) -> Option<f64> {
    let [number] = child_numbers(node, name)?.try_into().ok()?;
    Some(number)
}

/// The three numbers of a child element.
pub fn child_three(node: &Node, name: &str) -> Option<Vec3> {
    three(&child_text(node, name)?)
}

/// Finite numbers with spaces between them.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect()
}

/// Three finite numbers.
pub fn three(text: &str) -> Option<Vec3> {
    let three: [f64; 3] = numbers(text)?.try_into().ok()?;
    Some(three.into())
}

/// The last name of a path such as `/bodyset/femur_r`.
pub fn last_name(path: &str) -> String {
    path.rsplit('/').next().unwrap_or(path).to_string()
}
