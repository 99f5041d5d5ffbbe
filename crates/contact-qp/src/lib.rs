//! Convex quadratic programmes with lower bounds: Clarabel, an exact active-set polish, and verified warm starts.
//!
//! ```math
//! min_x ½ xᵀ P x + qᵀ x   subject to   x_i ≥ l_i, i ∈ B
//! ```
//! | symbol | what | size |
//! |---|---|---|
//! | P | symmetric, positive definite | `n × n` |
//! | q | linear term | `n` |
//! | B, l | sorted indices of the bounded unknowns, their bounds | `m ≤ n` |
//!
//! The solution is the only pair of `x` (n) and multipliers `r` (m) that satisfies the KKT conditions
//!
//! ```math
//! P x + q = ∑_{i ∈ B} r_i e_i,   x_i ≥ l_i,   r_i ≥ 0,   r_i (x_i − l_i) = 0
//! ```
//!
//! In unilateral contact `P` is a stiffness, `−q` the loads, `l` the gaps and `r` the contact forces, but this
//! crate does not depend on contact: it has no meshes and no normals.
//!
//! An interior-point solution satisfies bounds and signs only to its tolerance. Here Clarabel only *identifies* the
//! bounds that hold with equality, the active set `A`. The solution itself comes from the linear system on the
//! other unknowns `I`,
//!
//! ```math
//! x_A = l_A,   P_II x_I = −q_I − P_IA l_A,   r_A = (P x + q)_A
//! ```
//!
//! with primal-dual active-set steps if a sign is wrong. So `x ≥ l`, `r ≥ 0` and `r (x − l) = 0` hold *exactly*
//! in the returned numbers, the balance of forces holds to round-off, and four residuals measure it. If the active
//! set of a similar problem is known, it is tried first, and Clarabel is not called if it is correct.
//!
//! # Types, in the order one meets them
//! - [`MatrixView`] and [`BoundQp`] borrow `P`, `q`, `B` and `l`, dense or sparse, and check them;
//! - [`QpSettings`] and [`QpMethod`] say how to solve;
//! - [`ActiveSet`] is a warm start, and part of the answer;
//! - [`solve`] returns a [`QpSolution`], with its [`QpStatus`], the method used ([`QpPath`]) and its
//!   accuracy ([`KktResiduals`]); [`kkt_residuals`] measures any other pair;
//! - [`CheckedMatrix`] and [`solve_with`] check a matrix once for many programmes;
//! - [`QpError`] says why a programme is invalid.
//!
//! `examples/` solves an obstacle problem whose contact zone is known, and a regression with bounds.
//!
//! # Example
//! Two masses on springs, the first above a floor at 0.5; without it the loads would move them to (0, 1).
//! ```
//! use contact_qp::{BoundQp, MatrixView, QpPath, QpSettings, QpStatus, solve};
//!
//! let p = [4.0, -2.0, -2.0, 4.0];
//! let q = [2.0, -4.0];
//! let qp = BoundQp {
//!     matrix: MatrixView::Dense { n: 2, values: &p },
//!     linear: &q,
//!     bounded: &[0],
//!     lower: &[0.5],
//! };
//! let first = solve(&qp, None, &QpSettings::default())?;
//! assert_eq!(first.status, QpStatus::Solved);
//! assert_eq!(first.x, [0.5, 1.25]);
//! assert_eq!(first.multipliers, [1.5]); // 4·0.5 − 2·1.25 + 2
//! assert_eq!(first.path, QpPath::Clarabel);
//!
//! // A slightly different load: the same bound is active, so no interior point is needed.
//! let heavier = BoundQp { linear: &[2.0, -4.2], ..qp };
//! let second = solve(&heavier, Some(&first.active), &QpSettings::default())?;
//! assert_eq!((second.path, second.clarabel_calls), (QpPath::WarmStart, 0));
//! # Ok::<(), contact_qp::QpError>(())
//! ```

mod active_set;
mod balance;
mod box_qp;
mod cholesky;
mod dense;
mod error;
mod independent;
mod interior_point;
mod kkt;
mod least_squares;
mod matrix;
mod place;
mod polish;
mod primal_dual;
mod problem;
mod programme;
mod reduce;
mod selection;
mod settings;
mod solution;
mod solve;
mod sparse;

pub use active_set::ActiveSet;
pub use balance::{Balanced, nearest_balanced, unbalanced_load};
pub use box_qp::{BoxResiduals, BoxSolution, box_residuals, solve_box};
pub use error::QpError;
pub use independent::IndependentRows;
pub use kkt::{CheckedMatrix, KktResiduals, kkt_residuals};
pub use least_squares::{bounded_least_squares, nonnegative_least_squares};
pub use place::Place;
pub use problem::{BoundQp, MatrixView};
pub use programme::BoxQp;
pub use selection::{Combination, RowSelection};
pub use settings::{QpMethod, QpSettings};
pub use solution::{QpPath, QpSolution, QpStatus};
pub use solve::{solve, solve_with};
pub use sparse::SparseRows;

/// The examples of README.md, run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
