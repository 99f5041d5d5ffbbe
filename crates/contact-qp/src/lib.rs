//! Convex quadratic programmes with bounds and equality rows: verified starts, Clarabel, and an exact active-set polish.
//!
//! ```math
//! min_x ½ xᵀ P x + qᵀ x   subject to   l ≤ x ≤ u,   G x = e
//! ```
//! | symbol | what | size |
//! |---|---|---|
//! | P | symmetric, positive semi-definite, dense or sparse | `n × n` |
//! | q | linear term | `n` |
//! | l, u | bounds, infinite for none | `n` |
//! | G, e | equality rows, which may depend on each other | `m × n`, `m` |
//!
//! The solution satisfies the KKT conditions with multipliers `a` of the rows and `y` of the bounds,
//!
//! ```math
//! P x + q − Gᵀ a = y,   y_i ≥ 0 if x_i = l_i,   y_i ≤ 0 if x_i = u_i,   y_i = 0 between
//! ```
//!
//! In unilateral contact `P` is a stiffness, `−q` the loads, `l` the gaps and `y` the contact forces; or `P` is a flexibility, `x ≥ 0`
//! the contact forces, `y` the openings, and `G` the rigid motions. But this crate does not depend on contact: it has no meshes and no
//! normals.
//!
//! An interior-point solution satisfies bounds and signs only to its tolerance. Here Clarabel only *identifies* the unknowns that are at
//! their bounds. The solution itself comes from the linear system of the others and the rows, on a set whose signs are right. So `x` is
//! within its bounds and the signs hold *exactly* in the returned numbers, the balance of forces holds to round-off, and five residuals
//! measure it. If the set of a similar programme is known, it is tried first, and Clarabel is not called if it leads to the solution.
//!
//! # Types, in the order one meets them
//! - [`MatrixView`], [`SparseRows`] and [`BoxQp`] are the data, [`SymmetricMatrix`] a matrix that has its own;
//! - [`QpSettings`] and [`QpMethod`] say how to solve;
//! - [`BoundState`] says where an unknown is: a start, and part of the answer;
//! - [`solve_discs`] takes pairs of unknowns in a [`Disc`] as well, such as friction along two tangents;
//! - [`solve_box`] returns a [`BoxSolution`], with its [`QpStatus`], the method used ([`QpPath`]), how often each way to a solution was
//!   taken ([`QpCounts`]), and its accuracy ([`KktResiduals`]); [`kkt_residuals`] measures any other point;
//! - [`QpError`] says why a programme is invalid;
//! - [`RowSelection`] and [`IndependentRows`] choose among rows that depend on each other; [`nearest_balanced`], [`unbalanced_load`],
//!   both for several questions by [`BalanceRows`], and [`nonnegative_least_squares`] answer related questions about rows and bounds.
//!
//! `examples/` solves an obstacle problem whose contact zone is known, and a regression with bounds.
//!
//! # Example
//! Two masses on springs, the first above a floor at 0.5; without it the loads would move them to (0, 1).
//! ```
//! use contact_qp::{BoxQp, MatrixView, BoundState, QpPath, QpSettings, QpStatus, SparseRows, solve_box};
//!
//! let (p, rows) = ([4.0, -2.0, -2.0, 4.0], SparseRows::new(2));
//! let qp = BoxQp {
//!     matrix: MatrixView::Dense { n: 2, values: &p },
//!     linear: &[2.0, -4.0],
//!     lower: &[0.5, f64::NEG_INFINITY],
//!     upper: &[f64::INFINITY; 2],
//!     rows: &rows,
//!     right_side: &[],
//! };
//! let first = solve_box(&qp, None, &QpSettings::default())?;
//! assert_eq!((first.status, first.path), (QpStatus::Solved, QpPath::Clarabel));
//! assert_eq!(first.x, [0.5, 1.25]);
//! assert_eq!(first.multipliers, [1.5, 0.0]); // 4·0.5 − 2·1.25 + 2
//! assert_eq!(first.states, [BoundState::Lower, BoundState::Free]);
//!
//! // A slightly different load: the same bound is reached, so no interior point is needed.
//! let heavier = BoxQp { linear: &[2.0, -4.2], ..qp };
//! let second = solve_box(&heavier, Some(&first.states), &QpSettings::default())?;
//! assert_eq!((second.path, second.counts.clarabel_calls()), (QpPath::WarmStart, 0));
//! # Ok::<(), contact_qp::QpError>(())
//! ```

mod balance;
mod balanced_discs;
mod bound_state;
mod box_qp;
mod cholesky;
mod dense;
mod disc;
mod discs;
mod error;
mod independent;
mod interior_point;
mod least_squares;
mod matrix;
mod problem;
mod programme;
#[cfg(test)]
mod random;
mod reduce;
mod residuals;
mod selection;
mod settings;
mod solution;
mod sparse;
mod symmetric_matrix;

pub use balance::{BalanceRows, Balanced};
pub use balanced_discs::{nearest_balanced, unbalanced_load};
pub use bound_state::BoundState;
pub use box_qp::solve_box;
pub use disc::Disc;
pub use discs::{DiscStart, solve_discs};
pub use error::QpError;
pub use independent::IndependentRows;
pub use least_squares::nonnegative_least_squares;
pub use problem::MatrixView;
pub use programme::BoxQp;
pub use residuals::{KktResiduals, kkt_residuals};
pub use selection::{Combination, RowSelection};
pub use settings::{QpMethod, QpSettings};
pub use solution::{BoxSolution, QpCounts, QpPath, QpStatus};
pub use sparse::{SparseFactor, SparseRows};
pub use symmetric_matrix::SymmetricMatrix;

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
