//! Version 2: `$Nodes` and `$Elements`; the element carries its group.

use super::values::Values;
use super::{Contents, elements};
use crate::mesh_file::{ElementKind, MeshFileError};

/// The shortest node and element: in text with one digit per number, in binary.
const NODE: [usize; 2] = [8, 28];
const ELEMENT: [usize; 2] = [8, 8];

/// Reads the number of a node, element or tag list: an `int` that is not negative.
pub(super) fn number(v: &mut Values<'_>, what: &str) -> Result<u64, MeshFileError> {
    if !v.is_binary() {
        return v.size(what);
    }
    let found = v.int(what)?;
    u64::try_from(found).map_err(|_| v.fault(format!("found {found}")).expected(what.to_owned()))
}

/// Reads `$Nodes`, or `$NOD` of version 1.
pub(super) fn nodes(file: &mut Contents<'_>, end: &'static str) -> Result<(), MeshFileError> {
    let Contents { v, collector, .. } = file;
    v.enter("$Nodes");
    let count = v.text_count("the number of nodes")?;
    collector.reserve_nodes(v.capacity(count, NODE, "nodes")?);
    if v.is_binary() {
        v.rest_of_line();
    }
    for done in 0..count {
        v.progress(done, count, "nodes");
        let line = v.record_begin()?;
        let number = number(v, "the number of a node")?;
        let what = "a coordinate";
        let point = [v.real(what)?, v.real(what)?, v.real(what)?];
        v.record_end(line)?;
        collector.node(number, point, v.spot())?;
    }
    v.end(end)
}

/// Reads `$Elements`.
pub(super) fn elements(file: &mut Contents<'_>) -> Result<(), MeshFileError> {
    file.v.enter("$Elements");
    let count = file.v.text_count("the number of elements")?;
    file.collector.reserve_elements(file.v.capacity(count, ELEMENT, "elements")?);
    if file.v.is_binary() {
        file.v.rest_of_line();
        binary(file, count)?;
    } else {
        for done in 0..count {
            file.v.progress(done, count, "elements");
            let line = file.v.record_begin()?;
            let number = file.v.size("the number of an element")?;
            let code = file.v.int("the type of an element")?;
            let tags = file.v.size("the number of tags")?;
            let kind = elements::kind(&file.v, code, 1, Some(number))?;
            element(file, number, kind, tags)?;
            file.v.record_end(line)?;
        }
    }
    file.v.end("$EndElements")
}

/// Reads the binary blocks of elements of one type and number of tags.
fn binary(file: &mut Contents<'_>, count: u64) -> Result<(), MeshFileError> {
    let mut done = 0;
    while done < count {
        file.v.progress(done, count, "elements");
        let code = file.v.int("the type of the elements")?;
        let follow = number(&mut file.v, "how many elements follow")?;
        let tags = number(&mut file.v, "the number of tags")?;
        if follow == 0 || follow > count - done {
            let found = format!("{follow} elements follow, of {} that are left", count - done);
            return Err(file.v.fault(found).expected("at least one, and no more than are left"));
        }
        let kind = elements::kind(&file.v, code, follow, None)?;
        for _ in 0..follow {
            file.v.progress(done, count, "elements");
            let number = number(&mut file.v, "the number of an element")?;
            element(file, number, kind, tags)?;
            done += 1;
        }
    }
    Ok(())
}

/// Reads tags and nodes of an element; its first two tags are its physical group and its elementary entity.
fn element(
    file: &mut Contents<'_>,
    number_of_element: u64,
    kind: ElementKind,
    tags: u64,
) -> Result<(), MeshFileError> {
    let Contents { v, collector, labels } = file;
    let mut first = [0; 2];
    for k in 0..tags {
        let tag = v.int("a tag")?;
        if k < 2 {
            first[k as usize] = tag;
        }
    }
    let mut nodes = [0u64; ElementKind::MOST_NODES];
    for node in &mut nodes[..kind.nodes()] {
        *node = number(v, "the number of a node")?;
    }
    let set = labels.set_of_element(kind.dimension(), first);
    collector.element(number_of_element, kind, &nodes[..kind.nodes()], set, v.spot());
    Ok(())
}
