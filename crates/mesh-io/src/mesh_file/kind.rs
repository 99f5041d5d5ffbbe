//! The kinds of elements that are read.

/// The shape and order of an element; every kind's corners are its first nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ElementKind {
    /// A single node; it is not used.
    Point,
    /// A straight edge.
    Edge2,
    /// A quadratic edge.
    Edge3,
    /// A linear triangle.
    Triangle3,
    /// A quadratic triangle.
    Triangle6,
    /// A bilinear quadrilateral.
    Quad4,
    /// A quadratic quadrilateral without a node in its middle.
    Quad8,
    /// A quadratic quadrilateral with a node in its middle.
    Quad9,
    /// A linear tetrahedron.
    Tetra4,
    /// A quadratic tetrahedron.
    Tetra10,
    /// A linear pyramid: the base, then the apex.
    Pyramid5,
    /// A quadratic pyramid without a node in the middle of its base.
    Pyramid13,
    /// A quadratic pyramid with a node in the middle of its base.
    Pyramid14,
    /// A linear prism: a triangle, then the one above it.
    Prism6,
    /// A quadratic prism without nodes in the middle of its faces.
    Prism15,
    /// A quadratic prism with nodes in the middle of its quadrilaterals.
    Prism18,
    /// A linear hexahedron: a quadrilateral, then the one above it.
    Hexa8,
    /// A quadratic hexahedron without nodes in the middle of its faces.
    Hexa20,
    /// A quadratic hexahedron with nodes in the middle of its faces, and one inside.
    Hexa27,
}

impl ElementKind {
    /// The largest number of nodes of any kind.
    pub(crate) const MOST_NODES: usize = 27;
    /// The largest number of corners of any kind.
    pub(crate) const MOST_CORNERS: usize = 8;

    /// Nodes, corners, dimension and name.
    fn properties(self) -> (usize, usize, u8, &'static str) {
        match self {
            Self::Point => (1, 1, 0, "point"),
            Self::Edge2 => (2, 2, 1, "2-node edge"),
            Self::Edge3 => (3, 2, 1, "3-node edge"),
            Self::Triangle3 => (3, 3, 2, "3-node triangle"),
            Self::Triangle6 => (6, 3, 2, "6-node triangle"),
            Self::Quad4 => (4, 4, 2, "4-node quadrilateral"),
            Self::Quad8 => (8, 4, 2, "8-node quadrilateral"),
            Self::Quad9 => (9, 4, 2, "9-node quadrilateral"),
            Self::Tetra4 => (4, 4, 3, "4-node tetrahedron"),
            Self::Tetra10 => (10, 4, 3, "10-node tetrahedron"),
            Self::Pyramid5 => (5, 5, 3, "5-node pyramid"),
            Self::Pyramid13 => (13, 5, 3, "13-node pyramid"),
            Self::Pyramid14 => (14, 5, 3, "14-node pyramid"),
            Self::Prism6 => (6, 6, 3, "6-node prism"),
            Self::Prism15 => (15, 6, 3, "15-node prism"),
            Self::Prism18 => (18, 6, 3, "18-node prism"),
            Self::Hexa8 => (8, 8, 3, "8-node hexahedron"),
            Self::Hexa20 => (20, 8, 3, "20-node hexahedron"),
            Self::Hexa27 => (27, 8, 3, "27-node hexahedron"),
        }
    }

    /// Returns the number of nodes.
    pub fn nodes(self) -> usize {
        self.properties().0
    }

    /// Returns the number of corners.
    pub fn corners(self) -> usize {
        self.properties().1
    }

    /// Returns 0 for points, 1 for edges, 2 for surfaces, 3 for volumes.
    pub fn dimension(self) -> u8 {
        self.properties().2
    }

    /// Says whether there are nodes besides the corners.
    pub(crate) fn is_quadratic(self) -> bool {
        self.nodes() > self.corners()
    }

    /// Returns what people call it.
    pub fn name(self) -> &'static str {
        self.properties().3
    }
}
