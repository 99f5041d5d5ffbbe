//! Settings of the iteration.

use contact_qp::QpSettings;

/// Which algorithm solves the discrete contact problem, with its settings.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// The Neumann-Neumann iteration, equations (8)-(11).
    Nndd(NnddSettings),
    /// The exact solution of the discrete problem by interface Newton, the reference: [`crate::solve_exactly`].
    Newton(NewtonSettings),
    /// Two Neumann-Neumann steps, then Newton's method on the set of closed pairs, whose linear problems Neumann-Neumann steps with the set
    /// held solve by conjugate gradients.
    NewtonNn(NewtonSettings),
}

impl Default for Method {
    fn default() -> Self {
        Self::NewtonNn(NewtonSettings::default())
    }
}

impl Method {
    /// Returns the maximum number of iterations.
    pub fn max_iterations(&self) -> usize {
        match self {
            Self::Nndd(settings) => settings.max_iterations,
            Self::Newton(settings) | Self::NewtonNn(settings) => settings.max_iterations,
        }
    }

    /// Sets the maximum number of iterations.
    #[must_use]
    pub fn with_max_iterations(mut self, max_iterations: usize) -> Self {
        match &mut self {
            Self::Nndd(settings) => settings.max_iterations = max_iterations,
            Self::Newton(settings) | Self::NewtonNn(settings) => settings.max_iterations = max_iterations,
        }
        self
    }
}

impl From<NnddSettings> for Method {
    fn from(settings: NnddSettings) -> Self {
        Self::Nndd(settings)
    }
}

impl From<&NnddSettings> for Method {
    fn from(settings: &NnddSettings) -> Self {
        Self::Nndd(settings.clone())
    }
}

impl From<NewtonSettings> for Method {
    fn from(settings: NewtonSettings) -> Self {
        Self::Newton(settings)
    }
}

/// Settings of the exact solution.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonSettings {
    /// Maximum number of active sets that are tried; default 50. At least one is.
    pub max_iterations: usize,
    /// How the quadratic programme is solved.
    pub qp: QpSettings,
}

impl Default for NewtonSettings {
    fn default() -> Self {
        Self { max_iterations: 50, qp: QpSettings::default() }
    }
}

/// How the interface imbalance is shared between the two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// Half each, and the update `w¹ − w²`: the paper's.
    Half,
    /// `d_α = k_α/(k₁+k₂)` with the diagonals of `S_α`, and the update `d₁ w¹ − d₂ w²`.
    #[default]
    Stiffness,
}

/// How the sequence of λ is accelerated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Acceleration {
    /// No acceleration: the paper's fixed θ.
    None,
    /// Aitken's vector Δ² relaxation of θ.
    Aitken,
    /// Anderson's method with a safeguard.
    #[default]
    Anderson,
}

/// Settings of the Neumann-Neumann iteration.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NnddSettings {
    /// The exact solution, to use if the iteration stalls, diverges or uses all its iterations; `None`: no other method. It is not used either if θ is given, or
    /// if the criterion never stops, see [`crate::stopping::StoppingCriterion::can_stop`].
    pub newton: Option<NewtonSettings>,
    /// θ of the update, positive; `None`, the default: `2/(µ_min + µ_max)` from the ends of the spectrum of the
    /// interface operator.
    pub theta: Option<f64>,
    /// The weights; default by stiffness.
    pub weights: Weights,
    /// Whether there is a coarse space of the rigid motions of floating bodies; default yes. Without it the number of
    /// iterations grows with the number of floating bodies.
    pub coarse: bool,
    /// The acceleration; default Anderson.
    pub acceleration: Acceleration,
    /// Maximum number of iterations; default 50. With 0 the first pair is still computed, so that it can be certified.
    pub max_iterations: usize,
    /// How the contact problems of step 1 are solved.
    pub qp: QpSettings,
}

impl Default for NnddSettings {
    fn default() -> Self {
        Self {
            newton: Some(NewtonSettings { max_iterations: usize::MAX, qp: QpSettings::default() }),
            theta: None,
            weights: Weights::default(),
            coarse: true,
            acceleration: Acceleration::default(),
            max_iterations: 50,
            qp: QpSettings::default(),
        }
    }
}

impl NnddSettings {
    /// The paper's own settings: its iteration alone, θ given, half weights, no acceleration.
    pub fn paper(theta: f64) -> Self {
        Self {
            newton: None,
            theta: Some(theta),
            weights: Weights::Half,
            acceleration: Acceleration::None,
            ..Self::default()
        }
    }
}
