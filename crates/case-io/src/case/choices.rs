//! The words that settings choose from.

/// Declares an enumeration whose variants are words of the case file.
macro_rules! choices {
    ($(#[$doc:meta])* $name:ident, default $default:ident { $($(#[$variant_doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)+
        }

        impl $name {
            /// The words of the case file, each with its choice.
            pub const NAMES: &'static [(&'static str, Self)] = &[$(($word, Self::$variant)),+];

            /// Returns the word of the case file.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::$default
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.name())
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

choices! {
    /// `solver.imposed`: which body carries λ, the paper's Ω₁.
    Imposed, default Auto {
        /// The first body of the file.
        First = "first",
        /// The second body of the file.
        Second = "second",
        /// The stiffer of the two.
        Auto = "auto",
    }
}

choices! {
    /// `solver.method`: which algorithm solves the contact problem.
    Method, default Auto {
        /// `nndd` if θ, weights, an acceleration or a number of iterations are given; `exact` with friction, and for assemblies whose bodies
        /// have few pairs of nodes; otherwise `newton-nn`.
        Auto = "auto",
        /// The Neumann-Neumann algorithm of the paper.
        Nndd = "nndd",
        /// Another word for `exact`.
        Newton = "newton",
        /// The exact solution of the condensed problem of all bodies by interface Newton, the reference; it uses only `max_iterations` and
        /// `qp`.
        Exact = "exact",
        /// Two steps of the paper's algorithm, then Newton's method on the set of closed pairs with Neumann-Neumann steps inside; it uses only
        /// `imposed`, `lambda`, `max_iterations`, `stop` and `qp`.
        NewtonNn = "newton-nn",
    }
}

choices! {
    /// `solver.qp`: how the unilateral problem is solved.
    QpChoice, default Auto {
        /// Clarabel first, then the previous active set if its KKT conditions hold.
        Auto = "auto",
        /// Always Clarabel.
        Clarabel = "clarabel",
        /// Always active-set steps.
        ActiveSet = "active-set",
    }
}

choices! {
    /// `solver.weights`: how the two bodies share a correction.
    Weights, default Stiffness {
        /// One half each, the paper's.
        Half = "half",
        /// By stiffness.
        Stiffness = "stiffness",
    }
}

choices! {
    /// `solver.acceleration`: what is done with successive iterates.
    Acceleration, default Anderson {
        /// Nothing, the paper's.
        None = "none",
        /// Aitken's relaxation.
        Aitken = "aitken",
        /// Anderson's mixing.
        Anderson = "anderson",
    }
}

choices! {
    /// `solver.stop.criterion`: when the iteration ends.
    Criterion, default Estimator {
        /// `η_NNDD ≤ ratio · η_dis`.
        Estimator = "estimator",
        /// `ε_t ≤ tolerance`.
        Precision = "precision",
        /// `η_NNDD ≤ tolerance · η_NNDD(1)`.
        EtaNndd = "eta_nndd",
        /// After `max_iterations`.
        Iterations = "iterations",
    }
}
