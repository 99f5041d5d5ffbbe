//! Notes about pairs: those that differ in the pair's name only are one.

use super::{Case, Dimension};

/// Pairs that are named in one note.
const MOST_NAMED: usize = 3;

/// A note about one pair.
pub(super) struct PairNote {
    /// The number of the pair.
    pub(super) contact: usize,
    /// The note if no other pair has the same.
    pub(super) alone: String,
    /// The note without the names of the pair and its bodies.
    pub(super) shared: String,
}

impl<S: Dimension> Case<S> {
    /// Joins notes of pairs that say the same, in the order of the first of each.
    pub(super) fn joined(&self, notes: Vec<PairNote>) -> Vec<String> {
        let mut groups: Vec<Vec<PairNote>> = Vec::new();
        for note in notes {
            match groups.iter_mut().find(|group| group.iter().all(|other| other.shared == note.shared)) {
                Some(group) => group.push(note),
                None => groups.push(vec![note]),
            }
        }
        groups.into_iter().filter_map(|group| self.one(group)).collect()
    }

    fn one(&self, mut group: Vec<PairNote>) -> Option<String> {
        if group.len() > 1 {
            let name = |note: &PairNote| format!("\"{}\"", self.contacts[note.contact].name);
            let names: Vec<String> = group.iter().take(MOST_NAMED).map(name).collect();
            let (more, shared) = (group.len() - names.len(), &group[0].shared);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            return Some(format!("pairs {}{more}: {shared}", names.join(", ")));
        }
        Some(group.pop()?.alone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_words_about_many_pairs_are_one_note() {
        let text = "schema = 1\n[materials.m]\nyoung = 1.0\npoisson = 0.3\n".to_owned()
            + &(0..6).map(body).collect::<String>()
            + &(1..6).map(pair).collect::<String>();
        let case = Case::parse(&text, "case.toml", &[]).unwrap();
        let note = |contact: usize| PairNote {
            contact,
            alone: format!("{contact} alone"),
            shared: ["even", "odd"][contact % 2].to_owned(),
        };
        let joined = case.joined((0..5).map(note).collect());
        assert_eq!(joined, ["pairs \"0-1\", \"2-3\", \"4-5\": even", "pairs \"1-2\", \"3-4\": odd"]);
        let joined = case.joined((0..5).map(|k| PairNote { shared: "all".into(), ..note(k) }).collect());
        assert_eq!(joined, ["pairs \"0-1\", \"1-2\", \"2-3\" and 2 more: all"]);
        assert_eq!(case.joined(vec![note(3)]), ["3 alone"]);
    }

    fn body(k: usize) -> String {
        format!(
            "[[body]]\nname = \"{k}\"\nmaterial = \"m\"\n\
             generator = {{ kind = \"block\", origin = [0.0, {k}.0], size = [1.0, 1.0], cells = [2, 2] }}\n"
        )
    }

    fn pair(k: usize) -> String {
        format!("[[contact]]\nbodies = [\"{}\", \"{k}\"]\nsurfaces = [\"top\", \"bottom\"]\n", k - 1)
    }
}
