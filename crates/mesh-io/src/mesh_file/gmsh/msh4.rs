//! Versions 4.0 and 4.1: entities carry the groups; nodes and elements come in blocks, one per entity.

use super::msh2;
use super::values::Values;
use super::{Contents, elements};
use crate::mesh_file::{ElementKind, MeshFileError};

/// Reads `$Entities` or `$PartitionedEntities`, of which only the groups matter.
pub(super) fn entities(file: &mut Contents<'_>, partitioned: bool, old: bool) -> Result<(), MeshFileError> {
    let Contents { v, labels, .. } = file;
    v.enter(if partitioned { "$PartitionedEntities" } else { "$Entities" });
    if partitioned {
        v.size("the number of partitions")?;
        let ghosts = v.size("the number of ghost entities")?;
        for _ in 0..ghosts {
            v.int("the number of a ghost entity")?;
            v.int("its partition")?;
        }
    }
    let what = "the number of entities";
    let counts = [v.size(what)?, v.size(what)?, v.size(what)?, v.size(what)?];
    let mut tags = Vec::new();
    for (dimension, count) in (0u8..).zip(counts) {
        for done in 0..count {
            v.progress(done, count, "entities of one dimension");
            let entity = v.int("the number of an entity")?;
            if partitioned {
                v.int("the dimension of the parent")?;
                v.int("the number of the parent")?;
                let partitions = v.size("the number of partitions")?;
                for _ in 0..partitions {
                    v.int("a partition")?;
                }
            }
            // A point has its coordinates (not in 4.0), everything else the two corners of its bounding box.
            for _ in 0..if dimension == 0 && !old { 3 } else { 6 } {
                v.real("a coordinate")?;
            }
            let groups = v.size("the number of physical groups")?;
            tags.clear();
            for _ in 0..groups {
                tags.push(v.int("the number of a physical group")?);
            }
            labels.set_entity(dimension, entity, &tags);
            if dimension > 0 {
                let bounding = v.size("the number of bounding entities")?;
                for _ in 0..bounding {
                    v.int("the number of a bounding entity")?;
                }
            }
        }
    }
    v.end(if partitioned { "$EndPartitionedEntities" } else { "$EndEntities" })
}

/// The head that `$Nodes` and `$Elements` share: number of blocks and of items.
fn head(
    v: &mut Values<'_>,
    each: [usize; 2],
    what: &'static str,
    old: bool,
) -> Result<(u64, u64, usize), MeshFileError> {
    let line = v.record_begin()?;
    let blocks = v.size("the number of blocks")?;
    let count = v.size("the number of items in all blocks")?;
    if !old {
        v.size("the smallest number")?;
        v.size("the largest number")?;
    }
    v.record_end(line)?;
    Ok((blocks, count, v.capacity(count, each, what)?))
}

/// Refuses a block that goes beyond the number at the head of the section.
fn check_block(v: &Values<'_>, size: u64, done: u64, count: u64, what: &str) -> Result<(), MeshFileError> {
    if size > count - done {
        let found = format!("a block of {size} {what} begins after {done} of {count}");
        return Err(v.fault(found).expected(format!("at most {}", count - done)));
    }
    Ok(())
}

/// Checks that the blocks brought as many items as the head of the section says.
fn check_total(v: &Values<'_>, done: u64, count: u64, what: &str) -> Result<(), MeshFileError> {
    if done == count {
        return Ok(());
    }
    Err(v.fault(format!("the blocks hold {done} {what}, the head of the section says {count}")))
}

/// Reads dimension and number of the entity of a block, which 4.0 has in the other order.
fn entity(v: &mut Values<'_>, old: bool) -> Result<(i32, i32), MeshFileError> {
    let what = ["the dimension of an entity", "the number of an entity"];
    let [a, b] = [v.int(what[usize::from(old)])?, v.int(what[usize::from(!old)])?];
    Ok(if old { (b, a) } else { (a, b) })
}

/// Reads the number of a node or element: an `int` in 4.0, a `size_t` in 4.1.
fn number(v: &mut Values<'_>, what: &str, old: bool) -> Result<u64, MeshFileError> {
    if old { msh2::number(v, what) } else { v.size(what) }
}

/// Reads `$Nodes`.
///
/// * `old`: version 4.0, in which a node's number comes before its coordinates.
pub(super) fn nodes(file: &mut Contents<'_>, old: bool) -> Result<(), MeshFileError> {
    let Contents { v, collector, .. } = file;
    v.enter("$Nodes");
    let (blocks, count, capacity) = head(v, [8, if old { 28 } else { 32 }], "nodes", old)?;
    collector.reserve_nodes(capacity);
    let mut done = 0;
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        v.progress(done, count, "nodes");
        let line = v.record_begin()?;
        let (dimension, _) = entity(v, old)?;
        let parametric = v.int("0 or 1 for parametric coordinates")?;
        let size = v.size("the number of nodes of a block")?;
        v.record_end(line)?;
        check_block(v, size, done, count, "nodes")?;
        if !(0..=3).contains(&dimension) || !(0..=1).contains(&parametric) {
            let found = format!("a block has the dimension {dimension} and the parametric mark {parametric}");
            return Err(v.fault(found).expected("0 to 3, and 0 or 1"));
        }
        numbers.clear();
        numbers.reserve(capacity.min(usize::try_from(size).unwrap_or(capacity)));
        for k in 0..if old { 0 } else { size } {
            v.progress(done + k, count, "nodes");
            numbers.push(v.size("the number of a node")?);
        }
        for k in 0..size {
            v.progress(done, count, "nodes");
            let line = v.record_begin()?;
            let of_node = match numbers.get(k as usize) {
                Some(number) => *number,
                None => number(v, "the number of a node", old)?,
            };
            let what = "a coordinate";
            let point = [v.real(what)?, v.real(what)?, v.real(what)?];
            for _ in 0..dimension * parametric {
                v.real("a parametric coordinate")?;
            }
            v.record_end(line)?;
            collector.node(of_node, point, v.spot())?;
            done += 1;
        }
    }
    check_total(v, done, count, "nodes")?;
    v.end("$EndNodes")
}

/// Reads `$Elements`.
pub(super) fn elements(file: &mut Contents<'_>, old: bool) -> Result<(), MeshFileError> {
    let Contents { v, collector, labels } = file;
    v.enter("$Elements");
    let (blocks, count, capacity) = head(v, [4, if old { 8 } else { 16 }], "elements", old)?;
    collector.reserve_elements(capacity);
    let mut done = 0;
    for _ in 0..blocks {
        v.progress(done, count, "elements");
        let line = v.record_begin()?;
        let (dimension, entity) = entity(v, old)?;
        let code = v.int("the type of the elements")?;
        let size = v.size("the number of elements of a block")?;
        v.record_end(line)?;
        check_block(v, size, done, count, "elements")?;
        let kind = elements::kind(v, code, size, None)?;
        if i32::from(kind.dimension()) != dimension {
            let found = format!("a block of {}s lies on an entity of dimension {dimension}", kind.name());
            return Err(v.fault(found).expected(format!("dimension {}", kind.dimension())));
        }
        let set = labels.set_of_entity(kind.dimension(), entity);
        for _ in 0..size {
            v.progress(done, count, "elements");
            let line = v.record_begin()?;
            let of_element = number(v, "the number of an element", old)?;
            let mut nodes = [0u64; ElementKind::MOST_NODES];
            for node in &mut nodes[..kind.nodes()] {
                *node = number(v, "the number of a node", old)?;
            }
            v.record_end(line)?;
            collector.element(of_element, kind, &nodes[..kind.nodes()], set, v.spot());
            done += 1;
        }
    }
    check_total(v, done, count, "elements")?;
    v.end("$EndElements")
}
