//! Declared surfaces of solids: the plane, the cylinder or the sphere through the nodes of a side.
//!
//! A pair on a declared surface has its normals, `(x − c)/R` if it is round, and not those of the faces of the mesh.

use super::{Body, BodyError, ConditionList, ConditionPlace, group};
use crate::geometry::diagonal;
use crate::mesh::TetMesh;
use crate::mesh::bisect::TetRefinement;
use crate::mesh::id::FacetId;
use crate::partition::Partition;
use crate::rigid_line::RigidLine;
use crate::space::{Solid, Space};
use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen};
use std::collections::BTreeMap;

type Vector = <Solid as Space>::Vector;

/// Nodes may be off their surface by this fraction of the size of the side.
const ON_SURFACE: f64 = 1e-6;
/// Steps of Gauss-Newton, at most. It squares the error with each step if the nodes lie on the surface.
const ROUNDS: usize = 30;
/// A step that moves the surface by less than this fraction of the size of the side is the last one.
const LAST_STEP: f64 = 1e-14;
/// Steps that are not shorter than this fraction of the one before, one after the other, are the last ones: the nodes are on no such surface.
const SHORTER: f64 = 0.5;
const MOST_IDLE: usize = 2;
/// A radius of more than this multiple of the size of the side is that of a plane, but for the rounding of the nodes.
const LARGEST_RADIUS: f64 = 1e4;

/// The kind of a declared surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// A plane.
    Plane,
    /// A cylinder.
    Cylinder,
    /// A sphere.
    Sphere,
}

impl SurfaceKind {
    /// Returns its name.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Cylinder => "cylinder",
            Self::Sphere => "sphere",
        }
    }

    /// Returns the kind of a surface.
    pub fn of(line: &RigidLine<Solid>) -> Self {
        match line {
            RigidLine::Plane { .. } => Self::Plane,
            RigidLine::Circle { .. } => Self::Sphere,
            RigidLine::Cylinder { .. } => Self::Cylinder,
        }
    }

    /// Finds the surface through the nodes of faces; `None` if they do not lie on one to 1e-6 of their size, or lie on a plane.
    ///
    /// * `faces`: their corners, such that the normal of [`Space::facet_normal`] points out of the body, m.
    pub fn through(self, faces: &[[Vector; 3]]) -> Option<RigidLine<Solid>> {
        let (line, off, size) = self.nearest(faces)?;
        (off.largest <= ON_SURFACE * size).then_some(line)
    }

    /// Finds the surface of least squares, the node that is farthest off it, and the size of the side, m; `None` if no such surface is near.
    fn nearest(self, faces: &[[Vector; 3]]) -> Option<(RigidLine<Solid>, Off, f64)> {
        let points = faces.as_flattened();
        let size = diagonal(points);
        let middle = points.iter().sum::<Vector>() / points.len() as f64;
        let found = match self {
            Self::Plane => plane(faces, middle),
            Self::Sphere => refined(sphere(points, middle, size)?, points, size)?,
            Self::Cylinder => refined(cylinder(faces, middle, size)?, points, size)?,
        };
        let line = seen_from_outside(found, faces);
        let distance = |x: &Vector| line.distance(*x).0.abs();
        let at = points.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some((line, Off { at, largest: distance(&at) }, size))
    }
}

/// The node that is farthest off a surface.
struct Off {
    at: Vector,
    /// Its distance, m.
    largest: f64,
}

/// A side that is declared as a plane, a cylinder or a sphere: each connected part has its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeclaredSurface {
    /// The face group.
    pub on: String,
    /// The kind of the surface.
    pub kind: SurfaceKind,
}

impl Body<Solid> {
    /// Declares sides as planes, cylinders and spheres.
    ///
    /// # Errors
    /// Groups without faces or with faces inside the body, nodes that are not on one such surface, faces of two surfaces.
    pub fn with_surfaces(mut self, declared: &[DeclaredSurface]) -> Result<Self, BodyError> {
        let mut surfaces = BTreeMap::new();
        for (index, of) in declared.iter().enumerate() {
            let place = ConditionPlace { list: ConditionList::Surface, index };
            let faces = group(&self.mesh, &of.on, place)?;
            let kind = of.kind.word();
            // The parts of a side may lie on one surface.
            let whole = of.kind.through(&self.outward_faces(faces));
            for part in if whole.is_some() { vec![faces.to_vec()] } else { parts(&self.mesh, faces) } {
                let corners = self.outward_faces(&part);
                let (line, off, size) = of.kind.nearest(&corners).ok_or_else(|| {
                    let point = self.mesh.facet_middle(part[0]).into();
                    BodyError::NoSurface { place, kind, point }
                })?;
                if !(off.largest <= ON_SURFACE * size) {
                    return Err(BodyError::OffSurface {
                        place,
                        kind,
                        point: off.at.into(),
                        distance: off.largest,
                    });
                }
                for face in part {
                    if surfaces.insert(face, line).is_some() {
                        let point = self.mesh.facet_middle(face).into();
                        return Err(BodyError::CurvedTwice { place, point, words: Solid::WORDS });
                    }
                }
            }
        }
        self.surfaces = surfaces;
        Ok(self)
    }

    /// Creates the same body on a finer mesh: the parts of a face inherit its conditions and its surface, the selections are not evaluated again,
    /// and functions are evaluated at the new nodes.
    ///
    /// * `refinement`: of this body's mesh.
    ///
    /// # Errors
    /// Functions whose values at new nodes are not finite, or contradict each other, see [`BodyError`].
    pub fn refined(&self, refinement: &TetRefinement) -> Result<Self, BodyError> {
        let parts = parts_of_facets(refinement, self.mesh.topology().facets().len());
        let of = |facet: FacetId| parts[facet.index()].clone();
        let finer = self.on_finer(&refinement.mesh, &refinement.parent_cell, of)?;
        let inherited = |(face, line): (&FacetId, &RigidLine<Solid>)| {
            parts[face.index()].iter().map(|part| (*part, *line)).collect::<Vec<_>>()
        };
        Ok(Self { surfaces: self.surfaces.iter().flat_map(inherited).collect(), ..finer })
    }

    /// Returns the declared surfaces of all faces that have one.
    pub fn surfaces(&self) -> &BTreeMap<FacetId, RigidLine<Solid>> {
        &self.surfaces
    }

    /// Lists the corners of faces such that their normals point out of the body, m.
    pub fn outward_faces(&self, faces: &[FacetId]) -> Vec<[Vector; 3]> {
        let (mesh, topology) = (&self.mesh, self.mesh.topology());
        let corners =
            |face: &FacetId| topology.oriented_facet(*face, mesh.cells()).map(|node| mesh.points()[node]);
        faces.iter().map(corners).collect()
    }
}

/// Lists the parts of each old face in a finer mesh.
fn parts_of_facets(refinement: &TetRefinement, old: usize) -> Vec<Vec<FacetId>> {
    let mut parts = vec![Vec::new(); old];
    for (facet, parent) in refinement.parent_facet.iter().enumerate() {
        if *parent != FacetId::NONE {
            parts[parent.index()].push(FacetId::new(facet));
        }
    }
    parts
}

/// Lists the parts of a side that have no node in common.
fn parts(mesh: &TetMesh, faces: &[FacetId]) -> Vec<Vec<FacetId>> {
    let corners = |face: FacetId| mesh.topology().facets()[face].map(|node| node.index());
    let mut joined = Partition::new(mesh.points().len());
    for [a, b, c] in faces.iter().map(|face| corners(*face)) {
        joined.join(a, b);
        joined.join(b, c);
    }
    let mut parts: BTreeMap<usize, Vec<FacetId>> = BTreeMap::new();
    for &face in faces {
        parts.entry(joined.first(corners(face)[0])).or_default().push(face);
    }
    parts.into_values().collect()
}

/// Chooses the side of a surface on which the body is.
fn seen_from_outside(line: RigidLine<Solid>, faces: &[[Vector; 3]]) -> RigidLine<Solid> {
    let outward = |corners: &[Vector; 3]| Solid::facet_normal(corners) * Solid::facet_measure(corners);
    let along: f64 = faces.iter().map(|c| outward(c).dot(&line.frozen_normal(c[0]))).sum();
    let turn = along < 0.0;
    match line {
        RigidLine::Plane { point, normal } => {
            RigidLine::Plane { point, normal: if turn { -normal } else { normal } }
        }
        RigidLine::Circle { centre, radius, inside } => {
            RigidLine::Circle { centre, radius, inside: inside ^ turn }
        }
        RigidLine::Cylinder { point, axis, radius, inside } => {
            RigidLine::Cylinder { point, axis, radius, inside: inside ^ turn }
        }
    }
}

fn plane(faces: &[[Vector; 3]], middle: Vector) -> RigidLine<Solid> {
    let arms = faces.as_flattened().iter().map(|x| x - middle);
    let spread: Matrix3<f64> = arms.map(|arm| arm * arm.transpose()).sum();
    RigidLine::Plane { point: middle, normal: least(spread) }
}

/// Returns the eigenvector of the least eigenvalue.
fn least(matrix: Matrix3<f64>) -> Vector {
    let eigen = SymmetricEigen::new(matrix);
    eigen.eigenvectors.column(eigen.eigenvalues.imin()).into()
}

/// Solves the least squares `2 y·c + k = y·y` for the centre of a sphere or, with columns across an axis, of a circle.
///
/// * `axes`: the directions in which the centre is sought.
fn centre(points: &[Vector], (middle, size): (Vector, f64), axes: &[Vector]) -> Option<(Vector, f64)> {
    let n = axes.len();
    let (mut matrix, mut right) = (DMatrix::zeros(n + 1, n + 1), DVector::zeros(n + 1));
    for point in points {
        let arm = (point - middle) / size;
        let along = DVector::from_fn(n + 1, |k, _| axes.get(k).map_or(1.0, |axis| 2.0 * arm.dot(axis)));
        let squared: f64 = axes.iter().map(|axis| arm.dot(axis).powi(2)).sum();
        matrix.ger(1.0, &along, &along, 1.0);
        right.axpy(squared, &along, 1.0);
    }
    let solution = matrix.lu().solve(&right)?;
    let moved: Vector = axes.iter().zip(&solution).map(|(axis, c)| *axis * *c).sum();
    let radius = (solution[n] + moved.norm_squared()).sqrt() * size;
    (radius <= LARGEST_RADIUS * size).then(|| (middle + moved * size, radius))
}

fn sphere(points: &[Vector], middle: Vector, size: f64) -> Option<RigidLine<Solid>> {
    let (centre, radius) = centre(points, (middle, size), &Solid::AXES)?;
    Some(RigidLine::Circle { centre, radius, inside: true })
}

/// Finds a cylinder: its axis is across the normals of the faces, as well as that is possible.
fn cylinder(faces: &[[Vector; 3]], middle: Vector, size: f64) -> Option<RigidLine<Solid>> {
    let of_face = |corners: &[Vector; 3]| {
        let normal = Solid::facet_normal(corners);
        normal * normal.transpose() * Solid::facet_measure(corners)
    };
    let axis = least(faces.iter().map(of_face).sum());
    let across = Solid::complement(&[axis]);
    let (point, radius) = centre(faces.as_flattened(), (middle, size), &across[..2])?;
    Some(RigidLine::Cylinder { point, axis, radius, inside: true })
}

/// Improves a sphere or a cylinder by Gauss-Newton: the sum of the squared distances of the nodes becomes least. Nodes that are on no such surface are
/// recognised by steps that do not become shorter, and the surface is then only near the best one.
///
/// * `size`: of the side, m.
fn refined(mut line: RigidLine<Solid>, points: &[Vector], size: f64) -> Option<RigidLine<Solid>> {
    let (mut last, mut idle) = (f64::INFINITY, 0);
    for _ in 0..ROUNDS {
        let (start, axes, axis) = match line {
            RigidLine::Circle { centre, .. } => (centre, Solid::AXES.to_vec(), None),
            RigidLine::Cylinder { point, axis, .. } => {
                (point, Solid::complement(&[axis])[..2].to_vec(), Some(axis))
            }
            RigidLine::Plane { .. } => return Some(line),
        };
        // The centre along the axes, the turn of the axis, the radius.
        let n = axes.len() * if axis.is_some() { 2 } else { 1 } + 1;
        let (mut matrix, mut right) = (DMatrix::zeros(points.len(), n), DVector::zeros(points.len()));
        for (row, point) in points.iter().enumerate() {
            // The distance of the body's side falls outwards: `inside` is true so far.
            let (distance, out) = line.distance(*point);
            let height = axis.map_or(0.0, |axis| (point - start).dot(&axis) / size);
            right[row] = distance;
            for k in 0..n {
                matrix[(row, k)] = match axes.get(k) {
                    Some(axis) => -out.dot(axis),
                    None if k + 1 < n => -out.dot(&axes[k - axes.len()]) * height,
                    None => -1.0,
                };
            }
        }
        // By singular values: nearly flat parts have nearly dependent columns.
        let step = matrix.svd(true, true).solve(&right, f64::EPSILON).ok()?;
        let moved =
            |from: usize| -> Vector { axes.iter().zip(from..).map(|(axis, k)| *axis * step[k]).sum() };
        match &mut line {
            RigidLine::Circle { centre, radius, .. } => {
                *centre += moved(0);
                *radius += step[n - 1];
            }
            RigidLine::Cylinder { point, axis, radius, .. } => {
                *point += moved(0);
                *axis = (*axis + moved(axes.len()) / size).normalize();
                *radius += step[n - 1];
            }
            RigidLine::Plane { .. } => {}
        }
        let length = step.iter().fold(0.0f64, |most, s| most.max(s.abs()));
        idle = if length > SHORTER * last { idle + 1 } else { 0 };
        if length <= LAST_STEP * size || idle == MOST_IDLE {
            break;
        }
        last = length;
    }
    let radius = match line {
        RigidLine::Circle { radius, .. } | RigidLine::Cylinder { radius, .. } => radius,
        RigidLine::Plane { .. } => 0.0,
    };
    (radius > 0.0 && radius <= LARGEST_RADIUS * size).then_some(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    /// The faces of a grid, moved onto a surface.
    fn faces(to: impl Fn(f64, f64) -> Vector) -> Vec<[Vector; 3]> {
        let at = |i: usize, j: usize| to(i as f64 / 5.0, j as f64 / 4.0);
        let cells = (0..5).flat_map(|i| (0..4).map(move |j| (i, j)));
        cells
            .flat_map(|(i, j)| {
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            })
            .collect()
    }

    #[test]
    fn surfaces_through_the_nodes_of_any_part_are_found_to_round_off() {
        let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
        let shift = Vector::new(30.0, -20.0, 5.0);
        for angle in [0.1, 1.0, 6.0] {
            // Skewed, so that no face is along the axis.
            let round = |s: f64, t: f64| {
                let angle = angle * (s + 0.1 * t);
                turn * Vector::new(2.0 * angle.cos(), 2.0 * angle.sin(), 3.0 * t - 0.7 * s) + shift
            };
            let ball = |s: f64, t: f64| {
                let (angle, height) = (angle * s, 0.5 * angle.min(2.0) * (t - 0.4));
                let flat = height.cos() * 2.0;
                turn * Vector::new(flat * angle.cos(), flat * angle.sin(), 2.0 * height.sin()) + shift
            };
            let (cylinder, sphere) = (faces(round), faces(ball));
            let tolerance = 1e-11 / (angle * angle);
            match SurfaceKind::Cylinder.through(&cylinder) {
                Some(RigidLine::Cylinder { point, axis, radius, inside }) => {
                    let along = turn * Vector::z();
                    assert!((radius - 2.0).abs() < tolerance && axis.cross(&along).norm() < tolerance);
                    assert!((point - shift).cross(&along).norm() < tolerance && inside, "{point} {inside}");
                }
                other => panic!("{angle}: {other:?}"),
            }
            match SurfaceKind::Sphere.through(&sphere) {
                Some(RigidLine::Circle { centre, radius, inside: true }) => {
                    assert!((radius - 2.0).abs() < tolerance && (centre - shift).norm() < tolerance);
                }
                other => panic!("{angle}: {other:?}"),
            }
            assert_eq!(SurfaceKind::Plane.through(&cylinder), None);
            assert_eq!(SurfaceKind::Sphere.through(&cylinder), None);
            assert_eq!(SurfaceKind::Cylinder.through(&sphere), None);
            // A bore: the body is around the cylinder.
            let bore: Vec<[Vector; 3]> = cylinder.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
            let found = SurfaceKind::Cylinder.through(&bore);
            assert!(matches!(found, Some(RigidLine::Cylinder { inside: false, .. })), "{found:?}");
        }
        let flat = faces(|s, t| turn * Vector::new(3.0 * s, t, 0.2) + shift);
        match SurfaceKind::Plane.through(&flat) {
            Some(line) => {
                let out = turn * Vector::z();
                assert!((line.frozen_normal(shift) - out).norm() < 1e-14);
                assert!(line.distance(shift + out * 0.2).0.abs() < 1e-14);
            }
            None => panic!("no plane"),
        }
        assert_eq!((SurfaceKind::Sphere.through(&flat), SurfaceKind::Cylinder.through(&flat)), (None, None));
    }
}
