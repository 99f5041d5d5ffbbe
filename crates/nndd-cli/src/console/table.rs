//! The table of the iterations, which leaves out columns where the terminal is narrow.

use super::scientific;
use certified_contact::Row;

/// Columns with their heads, in their order: the larger the rank, the sooner one is left out.
const COLUMNS: [(&str, usize, usize); 9] = [
    ("it", 4, 0),
    ("theta", 9, 4),
    ("precision", 10, 3),
    ("eta_nndd", 10, 0),
    ("eta_dis", 10, 1),
    ("e_cre", 10, 0),
    ("contact", 8, 2),
    ("force", 12, 2),
    ("qp", 17, 5),
];

/// The largest rank of the columns that fit.
fn rank(width: Option<usize>) -> usize {
    let fits = |rank: usize| {
        let needed: usize = COLUMNS.iter().filter(|c| c.2 <= rank).map(|c| c.1 + 1).sum();
        width.is_none_or(|width| needed <= width)
    };
    (0..=5).rev().find(|rank| fits(*rank)).unwrap_or(0)
}

fn joined(cells: &[String; 9], width: Option<usize>) -> String {
    let rank = rank(width);
    let mut text = String::new();
    for (cell, (_, width, _)) in cells.iter().zip(COLUMNS).filter(|(_, c)| c.2 <= rank) {
        if !text.is_empty() {
            text.push(' ');
        }
        // The last column begins at its left edge.
        text += &if width == 17 { format!(" {cell}") } else { format!("{cell:>width$}") };
    }
    text + "\n"
}

/// The head of the table, for a terminal of this width.
pub(crate) fn head(width: Option<usize>) -> String {
    format!("\n{}", joined(&COLUMNS.map(|c| c.0.to_owned()), width))
}

/// One row of the table.
pub(crate) fn row(row: &Row, width: Option<usize>) -> String {
    let it = &row.iteration;
    let optional = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| scientific(x, 10, 3));
    let cells = [
        it.iteration.to_string(),
        if it.theta < 1e4 { format!("{:.4}", it.theta) } else { scientific(it.theta, 9, 1) },
        scientific(it.precision, 10, 3),
        scientific(it.eta_nndd, 10, 3),
        optional(row.eta_dis),
        optional(row.e_cre),
        it.contact_nodes.to_string(),
        scientific(it.contact_force, 12, 5),
        format!("{} {}", it.qp_path, it.qp_iterations),
    ];
    joined(&cells, width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_terminals_get_fewer_columns() {
        assert_eq!(
            head(None),
            "\n  it     theta  precision   eta_nndd    eta_dis      e_cre  contact        force  qp\n"
        );
        for width in 27..120 {
            assert!(head(Some(width)).trim_start_matches('\n').len() <= width + 1, "{width}");
        }
        for width in [0, 20, 40] {
            let text = head(Some(width));
            assert!(["it", "eta_nndd", "e_cre"].iter().all(|c| text.contains(c)), "{text}");
        }
        assert!(!head(Some(60)).contains("theta") && head(Some(60)).contains("force"));
    }
}
