//! What the refinement of a contact problem is in the plane and in space, as an adaptive run sees it.

use super::refinement::{self, RefineError, RefinedPair};
use super::solid_refinement::{count_halved, edge_order, halved};
use fem_core::body::Body;
use fem_core::interface::ContactProblem;
use fem_core::mesh::bisect::EdgeOrder;
use fem_core::mesh::refine::RefinementEdges;
use fem_core::space::{Plane, Solid, Space};
use std::fmt::Debug;

/// A problem on finer meshes, and the origin of its parts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FinerProblem<S: Refinable> {
    /// The problem.
    pub problem: ContactProblem<S>,
    /// What decides the next cuts.
    pub cuts: S::Cuts,
    /// The old cell that each cell of each body lies in.
    pub parent_cells: Vec<Vec<u32>>,
    /// The origin of each pair.
    pub pairs: Vec<RefinedPair>,
}

/// A space in which contact problems are refined: [`Plane`] by the newest vertex, [`Solid`] by the longest edge.
pub trait Refinable: Space {
    /// Where cells are cut next: it begins on the first meshes.
    type Cuts: Clone + Debug + Send + Sync;

    /// How often [`Self::finer`] cuts cells and then their parts, to make them about half as large.
    const PASSES: usize;

    /// Decides the first cuts.
    ///
    /// # Errors
    /// Cells that cannot be cut.
    fn cuts(problem: &ContactProblem<Self>) -> Result<Self::Cuts, RefineError>;

    /// Counts the nodes of all bodies after all passes.
    ///
    /// * `cells`: of each body.
    fn count(problem: &ContactProblem<Self>, cuts: &Self::Cuts, cells: &[Vec<u32>]) -> usize;

    /// Cuts cells, once: the same problem on finer meshes that match.
    ///
    /// * `cells`: of each body.
    ///
    /// # Errors
    /// Meshes that become too large or too small, functions that are not finite at new nodes, a negative gap there.
    fn finer(
        problem: &ContactProblem<Self>,
        cuts: &Self::Cuts,
        cells: &[Vec<u32>],
    ) -> Result<FinerProblem<Self>, RefineError>;

    /// Predicts the contribution of a part of a cell to the squared error of a smooth solution, relative to that of the cell: `part^((d+2)/d)`.
    ///
    /// * `part`: of the measure of the cell.
    fn predicted(part: f64) -> f64;

    /// Computes the root `c^(d/(d+2))` of a contribution, in proportion to which a cell is divided.
    fn root(contribution: f64) -> f64;

    /// Computes `τ = σ^(d/2)`: a cell of root `r` is divided in `r/τ` parts, which together contribute `σ r`.
    fn divisor(sigma: f64) -> f64;
}

/// Marks the edges of cells.
fn edges_of_cells(problem: &ContactProblem, cells: &[Vec<u32>]) -> Vec<Vec<bool>> {
    let of_body = |(body, cells): (&Body, &Vec<u32>)| {
        let topology = body.mesh().topology();
        let mut marked = vec![false; topology.facets().len()];
        for &cell in cells {
            for edge in topology.cell_facets()[cell as usize] {
                marked[edge] = true;
            }
        }
        marked
    };
    problem.bodies.iter().zip(cells).map(of_body).collect()
}

impl Refinable for Plane {
    type Cuts = Vec<RefinementEdges>;

    const PASSES: usize = 1;

    /// The longest edge of every cell.
    fn cuts(problem: &ContactProblem) -> Result<Self::Cuts, RefineError> {
        Ok(problem.bodies.iter().map(|body| RefinementEdges::longest(body.mesh())).collect())
    }

    fn count(problem: &ContactProblem, cuts: &Self::Cuts, cells: &[Vec<u32>]) -> usize {
        refinement::close(problem, cuts, &mut edges_of_cells(problem, cells)).iter().sum()
    }

    fn finer(
        problem: &ContactProblem,
        cuts: &Self::Cuts,
        cells: &[Vec<u32>],
    ) -> Result<FinerProblem<Self>, RefineError> {
        let found = refinement::refined(problem, cuts, &edges_of_cells(problem, cells))?;
        let (cuts, parent_cells) =
            found.refinements.into_iter().map(|of| (of.refinement_edges, of.parent_cell)).unzip();
        Ok(FinerProblem { problem: found.problem, cuts, parent_cells, pairs: found.pairs })
    }

    fn predicted(part: f64) -> f64 {
        part.powi(2)
    }

    fn root(contribution: f64) -> f64 {
        contribution.sqrt()
    }

    fn divisor(sigma: f64) -> f64 {
        sigma
    }
}

impl Refinable for Solid {
    type Cuts = EdgeOrder;

    const PASSES: usize = 2;

    fn cuts(problem: &ContactProblem<Self>) -> Result<Self::Cuts, RefineError> {
        edge_order(problem)
    }

    fn count(problem: &ContactProblem<Self>, cuts: &Self::Cuts, cells: &[Vec<u32>]) -> usize {
        count_halved(problem, cuts, cells, Self::PASSES)
    }

    fn finer(
        problem: &ContactProblem<Self>,
        cuts: &Self::Cuts,
        cells: &[Vec<u32>],
    ) -> Result<FinerProblem<Self>, RefineError> {
        let found = halved(problem, cuts, cells)?;
        let parent_cells = found.refinements.into_iter().map(|of| of.parent_cell).collect();
        Ok(FinerProblem { problem: found.problem, cuts: found.order, parent_cells, pairs: found.pairs })
    }

    fn predicted(part: f64) -> f64 {
        part * part.cbrt().powi(2)
    }

    fn root(contribution: f64) -> f64 {
        contribution.powf(0.6)
    }

    fn divisor(sigma: f64) -> f64 {
        sigma * sigma.sqrt()
    }
}
