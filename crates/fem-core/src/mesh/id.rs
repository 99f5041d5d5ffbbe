//! The numbers of nodes and of edges, each a type of its own, so that none is used in the place of another.
//!
//! Lists with one entry per node are indexed by [`NodeId`], those with one entry per edge by [`FacetId`]:
//!
//! ```
//! use fem_core::mesh::generate::block;
//! let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2])?;
//! let edge = mesh.group("right").unwrap()[0];
//! for node in mesh.topology().facets()[edge] {
//!     assert_eq!(mesh.points()[node][0], 2.0);
//! }
//! # Ok::<(), fem_core::mesh::MeshError>(())
//! ```

use std::fmt;
use std::ops::{Index, IndexMut};

macro_rules! number {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(u32);

        impl $name {
            /// Means "no number". An [`Option`] would take twice the memory.
            pub const NONE: Self = Self(u32::MAX);

            /// Creates a number. Meshes have fewer than 2³² of each.
            #[inline]
            pub const fn new(index: usize) -> Self {
                Self(index as u32)
            }

            /// Returns the place in a list with one entry for each.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<u32> for $name {
            #[inline]
            fn from(number: u32) -> Self {
                Self(number)
            }
        }

        impl From<$name> for u32 {
            #[inline]
            fn from(id: $name) -> Self {
                id.0
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Debug::fmt(&self.0, f)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)
            }
        }

        impl<T> Index<$name> for [T] {
            type Output = T;

            #[inline]
            fn index(&self, id: $name) -> &T {
                &self[id.index()]
            }
        }

        impl<T> IndexMut<$name> for [T] {
            #[inline]
            fn index_mut(&mut self, id: $name) -> &mut T {
                &mut self[id.index()]
            }
        }

        impl<T> Index<$name> for Vec<T> {
            type Output = T;

            #[inline]
            fn index(&self, id: $name) -> &T {
                &self[id.index()]
            }
        }

        impl<T> IndexMut<$name> for Vec<T> {
            #[inline]
            fn index_mut(&mut self, id: $name) -> &mut T {
                &mut self[id.index()]
            }
        }
    };
}

number! {
    /// The number of an edge of a mesh, from 0.
    FacetId
}

number! {
    /// The number of a node of a mesh, from 0.
    NodeId
}
