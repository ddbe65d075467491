//! Bodies that touch each other, directly or through others, are solved together; what shares no
//! contact is solved apart from them, and what no longer overlaps stays as it is.

use super::contacts::{Contact, Found};

/// Bodies that are solved together, and their contacts.
pub(super) struct Island<'a> {
    pub bodies: Vec<usize>,
    pub contacts: Vec<&'a Contact>,
}

/// The islands in which something overlaps; `first_vertex` of each body in the whole scene.
pub(super) fn overlapping_islands<'a>(found: &'a Found, first_vertex: &[u32]) -> Vec<Island<'a>> {
    let body_of = |v: u32| first_vertex.partition_point(|&first| first <= v) - 1;
    // The smallest number of a body in each one's island.
    let mut island: Vec<usize> = (0..first_vertex.len()).collect();
    for contact in &found.contacts {
        let mut labels = contact.weights.iter().map(|&(v, _)| island[body_of(v)]);
        let Some(one) = labels.next() else { continue };
        if let Some(other) = labels.find(|&label| label != one) {
            island.iter_mut().filter(|i| **i == one.max(other)).for_each(|i| *i = one.min(other));
        }
    }
    let members =
        |label: usize| (0..island.len()).filter(|&b| island[b] == label).collect::<Vec<_>>();
    (0..island.len())
        .map(|label| (label, members(label)))
        .filter(|(_, bodies)| bodies.iter().any(|&b| !found.seeds[b].is_empty()))
        .map(|(label, bodies)| {
            let is_ours =
                |c: &&Contact| c.weights.first().is_some_and(|&(v, _)| island[body_of(v)] == label);
            let contacts = found.contacts.iter().filter(is_ours).collect();
            Island { bodies, contacts }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn bodies_are_joined_through_others_and_what_is_clear_rests() {
        let contact = |vertices: [u32; 2]| Contact {
            weights: vertices.map(|v| (v, 1.0)).to_vec(),
            normal: Vec3::z(),
            constant: 0.0,
            distance: 0.1,
        };
        // Five bodies of ten vertices; 0 touches 4, which touches 2; 1 touches 3, and both are clear.
        let contacts = vec![contact([5, 41]), contact([15, 35]), contact([49, 20])];
        let seeds = vec![vec![], vec![], vec![20], vec![], vec![]];
        let found = Found { contacts, seeds };
        let islands = overlapping_islands(&found, &[0, 10, 20, 30, 40]);
        assert_eq!(islands.len(), 1);
        assert_eq!(islands[0].bodies, [0, 2, 4]);
        assert_eq!(islands[0].contacts.len(), 2);
    }
}
