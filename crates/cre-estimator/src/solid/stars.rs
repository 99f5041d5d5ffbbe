//! A cluster of edges and their stars.

use super::energy::EnergyMatrix;
use super::potentials::centroid;
use super::rings::Rings;
use fem_core::mesh::TetMesh;
use fem_core::mesh::id::{FacetId, NodeId};
use nalgebra::{Vector3, Vector6};
use std::ops::Range;

/// Unknowns of a wrench.
pub(super) const WRENCH: usize = 6;

/// A few rows of a column of an inverse.
pub(super) type Rows = [f32; 8];

/// An edge: its unknowns are a wrench and three bars of each face of its ring.
pub(super) struct Star {
    pub(super) nodes: [NodeId; 2],
    /// The first of its faces, cells and rows of its inverse in the cluster.
    first: [u32; 3],
    /// How many there are.
    pub(super) faces: u32,
    cells: u32,
}

/// A face of a ring.
pub(super) struct StarFace {
    pub(super) face: FacetId,
    /// The sense in which wrenches run through it, 1 or -1.
    sign: i8,
    /// From the middle of the edge to its centroid, over the length of the body.
    pub(super) lever: Vector3<f64>,
}

/// A cell of a ring: its place in the cluster, and its two faces that contain the edge, by their places in the cell and in the ring.
pub(super) struct StarCell {
    pub(super) cell: u32,
    places: [u32; 2],
    faces: [u8; 2],
}

impl StarCell {
    /// Returns the places of its two faces in the cell and in the ring.
    #[inline(always)]
    pub(super) fn sides(&self) -> [(u8, u32); 2] {
        [0, 1].map(|k| (self.faces[k], self.places[k]))
    }
}

/// Edges that are swept one after the other, in this order.
#[derive(Default)]
pub(crate) struct Cluster {
    /// The cells around the edges, ascending.
    pub(super) cells: Vec<u32>,
    /// Whether the cell is the first one of the cluster at each of its faces.
    pub(super) first: Vec<[bool; 4]>,
    pub(super) stars: Vec<Star>,
    pub(super) star_faces: Vec<StarFace>,
    pub(super) star_cells: Vec<StarCell>,
    /// Entries of the inverses.
    pub(super) rows: usize,
}

/// Energy matrices over the unit: of all cells of a body, or of those of a cluster.
#[derive(Clone, Copy)]
pub(crate) enum Matrices<'a> {
    OfBody(&'a [EnergyMatrix]),
    OfCells(&'a [EnergyMatrix]),
}

impl<'a> Matrices<'a> {
    /// * `place`: of the cell in the cluster.
    #[inline(always)]
    pub(crate) fn of(self, cell: u32, place: usize) -> &'a EnergyMatrix {
        match self {
            Self::OfBody(all) => &all[cell as usize],
            Self::OfCells(own) => &own[place],
        }
    }
}

impl Star {
    pub(super) fn size(&self) -> usize {
        WRENCH + 3 * self.faces as usize
    }

    pub(super) fn of_faces(&self) -> Range<usize> {
        let first = self.first[0] as usize;
        first..first + self.faces as usize
    }

    pub(super) fn of_cells(&self) -> Range<usize> {
        let first = self.first[1] as usize;
        first..first + self.cells as usize
    }

    pub(super) fn of_inverse(&self) -> Range<usize> {
        let first = self.first[2] as usize;
        first..first + self.size().div_ceil(8) * self.size()
    }
}

impl StarFace {
    /// The force and torque of a wrench.
    #[inline(always)]
    pub(super) fn through(&self, wrench: &Vector6<f64>) -> [f64; WRENCH] {
        let sign = f64::from(self.sign);
        let force = sign * Vector3::new(wrench[0], wrench[1], wrench[2]);
        let torque = sign * Vector3::new(wrench[3], wrench[4], wrench[5]) - self.lever.cross(&force);
        [force[0], force[1], force[2], torque[0], torque[1], torque[2]]
    }

    /// The transpose of [`Self::through`].
    #[inline(always)]
    pub(super) fn gathered(&self, [f0, f1, f2, t0, t1, t2]: [f64; WRENCH]) -> [f64; WRENCH] {
        let d = &self.lever;
        let force =
            [f0 + (d[1] * t2 - d[2] * t1), f1 + (d[2] * t0 - d[0] * t2), f2 + (d[0] * t1 - d[1] * t0)];
        let sign = f64::from(self.sign);
        [sign * force[0], sign * force[1], sign * force[2], sign * t0, sign * t1, sign * t2]
    }
}

impl Cluster {
    /// Collects the stars of some edges.
    ///
    /// * `length`: of the body.
    pub(crate) fn new(mesh: &TetMesh, rings: &Rings, edges: &[u32], length: f64) -> Self {
        let topology = mesh.topology();
        let mut cluster = Self::default();
        let rings_of = || edges.iter().map(|edge| rings.get(*edge as usize));
        cluster.cells = rings_of().flat_map(|ring| ring.cells).map(|around| around.cell).collect();
        cluster.cells.sort_unstable();
        cluster.cells.dedup();
        // Large bodies have many: no room to grow.
        cluster.cells.shrink_to_fit();
        cluster.stars.reserve_exact(edges.len());
        cluster.star_faces.reserve_exact(rings_of().map(|ring| ring.faces.len()).sum());
        cluster.star_cells.reserve_exact(rings_of().map(|ring| ring.cells.len()).sum());
        let mut place = 0;
        for ring in rings_of() {
            let [i, j] = ring.nodes.map(|n| mesh.points()[n]);
            let middle = (i + j) / 2.0;
            let first = [cluster.star_faces.len() as u32, cluster.star_cells.len() as u32, place];
            cluster.star_faces.extend(ring.faces.iter().map(|&face| {
                let corners = mesh.facet_corners(face);
                let third =
                    topology.facets()[face].iter().zip(corners).find(|(n, _)| !ring.nodes.contains(n));
                let across = third.map_or(Vector3::zeros(), |(_, x)| (j - i).cross(&(x - i)));
                let sign = if mesh.facet_normal(face).dot(&across) > 0.0 { 1 } else { -1 };
                StarFace { face, sign, lever: (centroid(&corners) - middle) / length }
            }));
            for around in ring.cells {
                let cell = cluster.cells.binary_search(&around.cell).unwrap_or(0) as u32;
                cluster.star_cells.push(StarCell { cell, places: around.places, faces: around.faces });
            }
            let (faces, cells) = (ring.faces.len() as u32, ring.cells.len() as u32);
            let star = Star { nodes: ring.nodes, first, faces, cells };
            place = star.of_inverse().end as u32;
            cluster.stars.push(star);
        }
        cluster.rows = place as usize;
        let mut faces: Vec<(FacetId, u32)> = Vec::with_capacity(4 * cluster.cells.len());
        for cell in &cluster.cells {
            faces.extend(topology.cell_facets()[*cell as usize].map(|face| (face, *cell)));
        }
        faces.sort_unstable();
        faces.dedup_by_key(|(face, _)| *face);
        let is_first = |face: FacetId, cell: u32| faces.binary_search(&(face, cell)).is_ok();
        let of_cell = |cell: &u32| topology.cell_facets()[*cell as usize].map(|face| is_first(face, *cell));
        cluster.first = cluster.cells.iter().map(of_cell).collect();
        cluster
    }

    /// The cells around the edges.
    pub(crate) fn cells(&self) -> &[u32] {
        &self.cells
    }
}
