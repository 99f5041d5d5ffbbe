//! Physical groups: their names, and which of them elements and entities belong to. In a file without any the elementary entities are the groups.

use super::values::{Mode, Values};
use crate::mesh_file::{Collected, Group, MeshFileError};
use crate::words::counted;
use std::collections::HashMap;

/// Dimension and number of a group.
type Key = (u8, u32);

/// A group.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum GroupKey {
    Physical(Key),
    Elementary(Key),
}

/// Groups, and the sets of groups that elements carry.
#[derive(Default)]
pub(super) struct Labels {
    names: HashMap<Key, String>,
    /// Names without a dimension, by number.
    bare: HashMap<u32, String>,
    /// All groups that were named or used, in the order of their appearance.
    groups: Vec<GroupKey>,
    index: HashMap<GroupKey, u32>,
    /// Sets of groups; the number 0 is the empty one, `k` for `sets[k - 1]`.
    sets: Vec<Vec<u32>>,
    single: HashMap<GroupKey, u32>,
    /// The set of each entity of version 4, by dimension and number.
    entities: HashMap<(i32, i32), u32>,
}

impl Labels {
    /// Reads `$PhysicalNames`, which is text in binary files as well.
    pub(super) fn read_names(&mut self, v: &mut Values<'_>) -> Result<(), MeshFileError> {
        v.enter("$PhysicalNames");
        let mode = std::mem::replace(&mut v.mode, Mode::Ascii);
        let count = v.size("the number of names")?;
        for done in 0..count {
            v.progress(done, count, "names");
            let line = v.record_begin()?;
            let first = v.int("a dimension from 0 to 3")?;
            // Old files have no dimension in front of the number of the group.
            let bare = v.next_is(b'"');
            let (dimension, tag) =
                if bare { (0, first) } else { (first, v.int("the number of a physical group")?) };
            v.record_end(line)?;
            let name = quoted(v.rest_of_line());
            let Ok(dimension @ 0..=3) = u8::try_from(dimension) else {
                return Err(v.fault(format!("the dimension of a group is {dimension}")).expected("0 to 3"));
            };
            let Some(name) = name.filter(|n| !n.is_empty()) else {
                return Err(v
                    .fault(format!("group {tag} of dimension {dimension} has no name in quotes"))
                    .expected("a line such as `1 10 \"bottom\"`"));
            };
            let key = (dimension, tag.unsigned_abs());
            let other = if bare { self.bare.insert(key.1, name) } else { self.names.insert(key, name) };
            if let Some(other) = other {
                let found = format!("group {tag} of dimension {dimension} is named twice, first \"{other}\"");
                return Err(v.fault(found).expected("one name"));
            }
            if !bare {
                self.group(GroupKey::Physical(key));
            }
        }
        v.end("$EndPhysicalNames")?;
        v.mode = mode;
        Ok(())
    }

    fn name(&self, key: &Key) -> Option<&String> {
        self.names.get(key).or_else(|| self.bare.get(&key.1))
    }

    fn group(&mut self, key: GroupKey) -> u32 {
        *self.index.entry(key).or_insert_with(|| {
            self.groups.push(key);
            self.groups.len() as u32 - 1
        })
    }

    /// Returns the set of an element that carries one physical group or none (0), and its elementary entity.
    pub(super) fn set_of_element(&mut self, dimension: u8, [physical, elementary]: [i32; 2]) -> u32 {
        let number = |tag: i32| (dimension, tag.unsigned_abs());
        let key = match [physical, elementary] {
            [0, 0] => return 0,
            [0, entity] => GroupKey::Elementary(number(entity)),
            [group, _] => GroupKey::Physical(number(group)),
        };
        if let Some(set) = self.single.get(&key) {
            return *set;
        }
        let group = self.group(key);
        self.sets.push(vec![group]);
        let set = self.sets.len() as u32;
        self.single.insert(key, set);
        set
    }

    /// Records the groups of an entity of version 4.
    pub(super) fn set_entity(&mut self, dimension: u8, entity: i32, tags: &[i32]) {
        if tags.is_empty() {
            return;
        }
        let mut groups: Vec<u32> =
            tags.iter().map(|tag| self.group(GroupKey::Physical((dimension, tag.unsigned_abs())))).collect();
        groups.sort_unstable();
        groups.dedup();
        self.sets.push(groups);
        self.entities.insert((i32::from(dimension), entity), self.sets.len() as u32);
    }

    /// Returns the set of an entity of version 4.
    pub(super) fn set_of_entity(&mut self, dimension: u8, entity: i32) -> u32 {
        match self.entities.get(&(i32::from(dimension), entity)) {
            Some(set) => *set,
            None => self.set_of_element(dimension, [0, entity]),
        }
    }

    /// Gives the mesh its groups of edges, cells and volumes, and notes which have no name.
    pub(super) fn apply(self, collected: &mut Collected) -> Result<(), MeshFileError> {
        let elementary = !self.groups.iter().any(|group| matches!(group, GroupKey::Physical(_)));
        let mut members = vec![Vec::new(); self.groups.len()];
        for sets in [&collected.edge_sets, &collected.cell_sets, &collected.volume_sets] {
            for (place, set) in sets.iter().enumerate() {
                let groups = (*set as usize).checked_sub(1).and_then(|k| self.sets.get(k));
                for group in groups.into_iter().flatten() {
                    members[*group as usize].push(place as u32);
                }
            }
        }
        let mut taken: HashMap<(u8, String), u32> = HashMap::new();
        let mut unnamed = 0;
        // Those with a name come first, so that a number never takes the place of a name.
        let of_kind = |(key, members): (&GroupKey, Vec<u32>)| match *key {
            GroupKey::Physical(key) => Some((key, members)),
            GroupKey::Elementary(key) => elementary.then_some((key, members)),
        };
        let (named, numbered): (Vec<_>, Vec<_>) = self
            .groups
            .iter()
            .zip(members)
            .filter_map(of_kind)
            .partition(|(key, _)| self.name(key).is_some());
        for (key, members) in named.into_iter().chain(numbered) {
            let (dimension, tag) = key;
            if !(1..=3).contains(&dimension) {
                continue;
            }
            let name = match self.name(&key) {
                Some(name) => name.clone(),
                None => {
                    unnamed += 1;
                    tag.to_string()
                }
            };
            if let Some(other) = taken.insert((dimension, name.clone()), tag) {
                let found = format!(
                    "two physical groups of dimension {dimension} are called \"{name}\", numbers {other} and {tag}"
                );
                return Err(collected.fault(found).expected("names that differ within a dimension"));
            }
            collected.mesh.push_group(Group { dimension, name, members });
        }
        if elementary && unnamed > 0 {
            collected.mesh.note_elementary_groups();
        } else if unnamed > 0 {
            let groups = counted(unnamed, "physical group");
            collected.mesh.push_note(format!("{groups} without a name: called by number"));
        }
        Ok(())
    }
}

/// Takes the text between the first and the last quote, or all of it without quotes; names that are not UTF-8 keep what can be read.
fn quoted(line: &[u8]) -> Option<String> {
    let Some(first) = line.iter().position(|b| *b == b'"') else {
        return Some(String::from_utf8_lossy(line).trim().to_owned());
    };
    let last = line.iter().rposition(|b| *b == b'"')?;
    Some(String::from_utf8_lossy(line.get(first + 1..last)?).trim().to_owned())
}
