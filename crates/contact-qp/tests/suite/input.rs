//! Every kind of bad input has its own error, before anything is solved.

use contact_qp::{BoundState, BoxQp, MatrixView, QpError, QpSettings, SparseRows, solve_box};
use std::sync::LazyLock;

static NONE: LazyLock<SparseRows> = LazyLock::new(|| SparseRows::new(2));

fn error(qp: BoxQp<'_>) -> QpError {
    let found = solve_box(&qp, None, &QpSettings::default()).expect_err("bad input");
    // Compared as text, because NaN differs from itself.
    let checked = qp.check().expect_err("bad input");
    assert_eq!(checked.to_string(), found.to_string(), "`check` and `solve_box` agree");
    found
}

fn good() -> BoxQp<'static> {
    BoxQp {
        matrix: MatrixView::Dense { n: 2, values: &[2.0, -1.0, -1.0, 2.0] },
        linear: &[1.0, -2.0],
        lower: &[0.5, f64::NEG_INFINITY],
        upper: &[f64::INFINITY, 3.0],
        rows: &NONE,
        right_side: &[],
    }
}

fn sparse<'a>(column_starts: &'a [usize], row_indices: &'a [usize], values: &'a [f64]) -> BoxQp<'a> {
    BoxQp { matrix: MatrixView::SparseUpper { n: 2, column_starts, row_indices, values }, ..good() }
}

#[test]
fn the_good_ones_are_good() {
    assert_eq!(good().check(), Ok(()));
    assert_eq!(sparse(&[0, 1, 3], &[0, 0, 1], &[2.0, -1.0, 2.0]).check(), Ok(()));
}

#[test]
fn lengths() {
    let length = |what, expected, found| QpError::Length { what, expected, found };
    assert_eq!(error(BoxQp { linear: &[1.0], ..good() }), length("linear", 2, 1));
    assert_eq!(error(BoxQp { lower: &[1.0], ..good() }), length("lower", 2, 1));
    let short = MatrixView::Dense { n: 2, values: &[1.0, 0.0, 0.0] };
    assert_eq!(error(BoxQp { matrix: short, ..good() }), length("values", 4, 3));
    assert_eq!(error(sparse(&[0, 1], &[0], &[1.0])), length("column_starts", 3, 2));
    assert_eq!(error(sparse(&[0, 1, 2], &[0, 1], &[1.0])), length("values", 2, 1));
    let start = [BoundState::Free; 3];
    assert_eq!(solve_box(&good(), Some(&start), &QpSettings::default()), Err(length("start", 2, 3)));
    let row = SparseRows::from_dense(2, &[1.0, 1.0]);
    assert_eq!(error(BoxQp { rows: &row, ..good() }), length("right_side", 1, 0));
    assert_eq!(error(BoxQp { rows: &SparseRows::new(3), ..good() }), length("rows", 2, 3));
}

#[test]
fn numbers_that_are_not_finite() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (what, place, qp) in [
            ("linear", 1, BoxQp { linear: &[1.0, bad], ..good() }),
            (
                "values",
                3,
                BoxQp { matrix: MatrixView::Dense { n: 2, values: &[1.0, 0.0, 0.0, bad] }, ..good() },
            ),
            ("values", 1, sparse(&[0, 1, 3], &[0, 0, 1], &[2.0, bad, 2.0])),
        ] {
            match error(qp) {
                QpError::NotFinite { what: w, place: p, found } => {
                    assert_eq!((w, p, found.to_bits()), (what, place, bad.to_bits()));
                }
                other => panic!("{other}"),
            }
        }
    }
}

#[test]
fn matrices_that_are_not_symmetric() {
    // Triangles alone, which Clarabel would read as a full matrix.
    for values in [[2.0, -1.0, 0.0, 2.0], [2.0, 0.0, -1.0, 2.0]] {
        let matrix = MatrixView::Dense { n: 2, values: &values };
        assert!(matches!(error(BoxQp { matrix, ..good() }), QpError::NotSymmetric { row: 1, column: 0, .. }));
    }
    // Round-off is accepted, a relative 1e-7 is not; beyond one tile of the sweep.
    let n = 70;
    for (perturbation, good) in [(1e-14, true), (1e-7, false)] {
        let mut values = vec![0.5; n * n];
        (0..n).for_each(|i| values[i * n + i] = 100.0);
        values[40 * n + 66] += 100.0 * perturbation;
        let (linear, none) = (vec![1.0; n], SparseRows::new(n));
        let (lower, upper) = (vec![0.0; n], vec![1.0; n]);
        let qp = BoxQp {
            matrix: MatrixView::Dense { n, values: &values },
            linear: &linear,
            lower: &lower,
            upper: &upper,
            rows: &none,
            right_side: &[],
        };
        match qp.check() {
            Ok(()) => assert!(good),
            Err(QpError::NotSymmetric { row, column, .. }) => {
                assert_eq!((row, column, good), (66, 40, false))
            }
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn sparse_patterns() {
    let starts = |place, found, least, most| QpError::ColumnStarts { place, found, least, most };
    assert_eq!(error(sparse(&[1, 1, 2], &[0, 1], &[1.0, 1.0])), starts(0, 1, 0, 0));
    assert_eq!(error(sparse(&[0, 2, 1], &[0, 1], &[1.0, 1.0])), starts(2, 1, 2, 2));
    assert_eq!(error(sparse(&[0, 1, 1], &[0, 1], &[1.0, 1.0])), starts(2, 1, 2, 2));
    assert_eq!(error(sparse(&[0, 5, 2], &[0, 1], &[1.0, 1.0])), starts(1, 5, 0, 2));
    // The lower triangle: column 0 holds row 1.
    let lower = sparse(&[0, 2, 3], &[0, 1, 1], &[2.0, -1.0, 2.0]);
    assert_eq!(error(lower), QpError::BelowDiagonal { column: 0, found: 1 });
    let unsorted = sparse(&[0, 1, 3], &[0, 1, 0], &[2.0, 2.0, -1.0]);
    assert_eq!(error(unsorted), QpError::RowOrder { column: 1, previous: 1, found: 0 });
    let repeated = sparse(&[0, 1, 4], &[0, 0, 0, 1], &[2.0, -0.5, -0.5, 2.0]);
    assert_eq!(error(repeated), QpError::RowOrder { column: 1, previous: 0, found: 0 });
    let outside = sparse(&[0, 1, 2], &[0, 9], &[2.0, 2.0]);
    assert_eq!(error(outside), QpError::BelowDiagonal { column: 1, found: 9 });
    let negative = sparse(&[0, 1, 3], &[0, 0, 1], &[2.0, -1.0, -2.0]);
    assert_eq!(error(negative), QpError::NotPositiveDefinite { index: 1 });
}

#[test]
fn bounds_that_leave_no_room() {
    for (lower, upper) in [(2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::NAN), (f64::INFINITY, f64::INFINITY)] {
        let found = error(BoxQp { lower: &[0.0, lower], upper: &[0.0, upper], ..good() });
        assert!(matches!(found, QpError::Bounds { place: 1, .. }), "{found}");
    }
}

#[test]
fn settings_out_of_range() {
    let settings = QpSettings::default().with_tolerance(f64::NAN);
    assert!(matches!(solve_box(&good(), None, &settings), Err(QpError::Setting { what: "tolerance", .. })));
}

#[test]
fn messages_give_place_found_and_expected() {
    let message = error(BoxQp { linear: &[1.0], ..good() }).to_string();
    assert_eq!(message, "`linear` has 1 entries, expected 2");
    let message = error(sparse(&[0, 2, 3], &[0, 1, 1], &[2.0, -1.0, 2.0])).to_string();
    assert_eq!(message, "row 1 is stored in column 0, expected rows 0 to 0: upper triangle only");
}
