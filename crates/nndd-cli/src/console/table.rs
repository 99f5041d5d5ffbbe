//! The table of the iterations, which leaves out columns if the terminal is narrow.

use super::{scientific, scientific_up};
use certified_contact::IterationRecord;

/// Columns with their heads, in their order: the larger the rank, the sooner one is left out.
const COLUMNS: [(&str, usize, usize); 11] = [
    ("it", 4, 0),
    ("theta", 9, 4),
    ("precision", 10, 3),
    ("eta_nndd", 10, 0),
    ("eta_dis", 10, 1),
    ("e_cre", 10, 0),
    ("contact", 8, 3),
    ("force_1", 11, 2),
    ("force_2", 11, 2),
    (TIME, 8, 5),
    ("qp", 17, 6),
];

/// Seconds since the program began: the only column that differs from run to run.
const TIME: &str = "time [s]";

/// How the table is shown.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layout {
    /// Of the terminal; `None` if all columns are shown.
    pub(crate) width: Option<usize>,
    /// Set if the column of times is one of them.
    pub(crate) timed: bool,
}

impl Layout {
    fn columns(self) -> impl Iterator<Item = (usize, &'static (&'static str, usize, usize))> {
        COLUMNS.iter().enumerate().filter(move |(_, column)| self.timed || column.0 != TIME)
    }

    /// The largest rank of the columns that fit.
    fn rank(self) -> usize {
        let fits = |rank: usize| {
            let needed: usize = self.columns().filter(|(_, c)| c.2 <= rank).map(|(_, c)| c.1 + 1).sum();
            self.width.is_none_or(|width| needed <= width)
        };
        (0..=6).rev().find(|rank| fits(*rank)).unwrap_or(0)
    }

    fn joined(self, cells: &[String; 11]) -> String {
        let rank = self.rank();
        let mut text = String::new();
        for (k, (_, width, _)) in self.columns().filter(|(_, c)| c.2 <= rank) {
            if !text.is_empty() {
                text.push(' ');
            }
            let cell = &cells[k];
            // The last column begins at its left edge.
            text += &if *width == 17 { format!(" {cell}") } else { format!("{cell:>width$}") };
        }
        text + "\n"
    }

    /// The head of the table.
    pub(crate) fn head(self) -> String {
        format!("\n{}", self.joined(&COLUMNS.map(|c| c.0.to_owned())))
    }

    /// One row of the table.
    ///
    /// * `seconds`: since the program began.
    pub(crate) fn row(self, row: &IterationRecord, seconds: f64) -> String {
        let it = &row.iteration;
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        self.joined(&[
            it.iteration.to_string(),
            theta(it.theta),
            scientific(it.precision, 10, 3),
            scientific(it.eta_nndd, 10, 3),
            or_dash(row.eta_dis.map(|x| scientific(x, 10, 3))),
            or_dash(row.e_cre.map(|x| scientific_up(x, 10, 3))),
            it.contact_nodes.to_string(),
            scientific(row.contact_forces[0], 11, 4),
            scientific(row.contact_forces[1], 11, 4),
            format!("{seconds:.2}"),
            format!("{} {}", it.qp_path, it.qp_iterations),
        ])
    }
}

/// Writes θ; a dash for the Newton method, which has no θ.
fn theta(theta: f64) -> String {
    match theta {
        0.0 => "-".into(),
        _ if (1e-4..1e4).contains(&theta) => format!("{theta:.4}"),
        _ => scientific(theta, 9, 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(width: Option<usize>, timed: bool) -> String {
        Layout { width, timed }.head()
    }

    #[test]
    fn narrow_terminals_get_fewer_columns() {
        assert_eq!(
            head(None, false),
            "\n  it     theta  precision   eta_nndd    eta_dis      e_cre  contact     force_1     force_2  qp\n"
        );
        for (width, timed) in (27..120).flat_map(|width| [(width, false), (width, true)]) {
            assert!(head(Some(width), timed).trim_start_matches('\n').len() <= width + 1, "{width}");
        }
        for width in [0, 20, 40] {
            let text = head(Some(width), true);
            assert!(["it", "eta_nndd", "e_cre"].iter().all(|c| text.contains(c)), "{text}");
        }
        assert!(!head(Some(72), false).contains("theta") && head(Some(72), false).contains("force_2"));
    }

    #[test]
    fn times_stand_before_the_contact_problem_on_wide_terminals() {
        assert!(head(None, true).ends_with("force_2 time [s]  qp\n"));
        assert!(head(Some(102), true).ends_with("force_2 time [s]\n"));
        assert!(!head(Some(80), true).contains("time"));
    }
}
