//! Version 1: `$NOD` as `$Nodes` of version 2, and `$ELM`, always text.

use super::{Contents, elements};
use crate::mesh_file::{ElementKind, MeshFileError};

/// The shortest element: in text with one digit per number; there is no binary one.
const ELEMENT: [usize; 2] = [12, 12];

/// Reads `$ELM`: number, type, physical group, elementary entity, number of nodes, nodes.
pub(super) fn elements(file: &mut Contents<'_>) -> Result<(), MeshFileError> {
    let Contents { v, collector, labels } = file;
    v.enter("$ELM");
    let count = v.size("the number of elements")?;
    collector.reserve_elements(v.capacity(count, ELEMENT, "elements")?);
    for done in 0..count {
        v.progress(done, count, "elements");
        let line = v.record_begin()?;
        let number = v.size("the number of an element")?;
        let code = v.int("the type of an element")?;
        let group = v.int("a physical group")?;
        let entity = v.int("an elementary entity")?;
        let given = v.size("the number of nodes")?;
        let kind = elements::kind(v, code, 1, Some(number))?;
        if given != kind.nodes() as u64 {
            let found = format!("element {number} ({}) has {given} nodes", kind.name());
            return Err(v.fault(found).expected(kind.nodes().to_string()));
        }
        let mut nodes = [0u64; ElementKind::MOST_NODES];
        for node in &mut nodes[..kind.nodes()] {
            *node = v.size("the number of a node")?;
        }
        v.record_end(line)?;
        let set = labels.set_of_element(kind.dimension(), [group, entity]);
        collector.element(number, kind, &nodes[..kind.nodes()], set, v.spot());
    }
    v.end("$ENDELM")
}
