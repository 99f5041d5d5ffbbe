//! The method on one page: each formula with the function that computes it.
//!
//! Numbers (1) to (12) are those of Choi, Gallimard and Sassi; the other numbers continue from there, in the order of
//! a run. Misprints of the paper are corrected: `t·σn` in (7); in (10), (11) the corrections vanish where
//! displacements are imposed.
//!
//! # The problem
//! Two bodies Ω₁, Ω₂, the unit normal `n` out of the first on the contact line Γ_C, the initial gap `g ≥ 0`. For α = 1, 2:
//! ```math
//! \begin{aligned}
//! σ^α &= \mathbb{E}^α ε(u^α)                                     && \text{in } Ω_α   && (1) \\
//! \operatorname{div} σ^α + b^α &= 0                              && \text{in } Ω_α   && (2) \\
//! σ^α n^α &= F^α                                                 && \text{on } Γ_N^α && (3) \\
//! u^α &= u_D^α                                                   && \text{on } Γ_D^α && (4) \\
//! o = g - (u^1 - u^2)·n ≥ 0, \quad p &≥ 0, \quad p\,o = 0        && \text{on } Γ_C   && (5) \\
//! n·σ^α n &= -p, \quad t·σ^α n = 0                               && \text{on } Γ_C   && (6), (7)
//! \end{aligned}
//! ```
//! | formula | where |
//! |---|---|
//! | (1) | [`LinearElastic::stress`](fem_core::material::LinearElastic::stress), [`field::stresses`](fem_core::field::stresses) |
//! | (2), (3), (4) | [`BoundaryConditions`](fem_core::boundary::BoundaryConditions), evaluated in [`Body::new`](fem_core::body::Body::new); their weak form in [`System::assemble`](fem_core::assembly::System::assemble) |
//! | (5)-(7) | the nodal law in step 1, (9); its pairs, normals and gaps in [`ContactInterface`](fem_core::interface::ContactInterface) |
//!
//! # The iteration
//! Given the normal trace λ on Γ_C, nodal forces `r` and the Steklov-Poincaré operators S₁, S₂:
//! ```math
//! \begin{aligned}
//! \text{step 1:} && v^1 &= λ, \quad r^1 = S_1 λ - \tilde g^1                                              && (8) \\
//!                && v^2 &= \operatorname{argmin}_{v ≥ λ - g} \; ½ v·S_2 v - \tilde g^2·v, \quad r^2 = S_2 v^2 - \tilde g^2 ≥ 0  && (9) \\
//! \text{step 2:} && S_1 w^1 &= -½ (r^1 + r^2)                                                             && (10) \\
//!                && S_2 w^2 &= +½ (r^1 + r^2)                                                             && (11) \\
//! \text{update:} && λ &← λ + θ (w^1 - w^2)                                                                &&
//! \end{aligned}
//! ```
//! | formula | where |
//! |---|---|
//! | (8) | [`CondensedBody::reaction`](fem_core::condensation::CondensedBody::reaction) |
//! | (9) | [`contact_qp::solve_with`] |
//! | (10), (11) | [`CondensedBody::trace_from_force`](fem_core::condensation::CondensedBody::trace_from_force) |
//! | the loop | [`nndd::solve`]; weights other than ½ and other updates: [`nndd::Weights`], [`nndd::Acceleration`] |
//!
//! `S` is a by-product of the factorisation `K = L Lᵀ` with the interface last. The displacement is recovered only on
//! request:
//! ```math
//! S = L_{CC} L_{CC}^T, \qquad \tilde g = L_{CC} (L^{-1} f)_C, \qquad a(w, w) = w·S w                          \qquad (13)
//! ```
//! in [`CondensedBody::factorise`](fem_core::condensation::CondensedBody::factorise),
//! [`displacement_from_trace`](fem_core::condensation::CondensedBody::displacement_from_trace).
//!
//! With `μ` the eigenvalues of `½(S₁⁻¹ + S₂⁻¹)(S₁ + S₂)` (full contact) the iteration converges for θ below the
//! first value, and is fastest at the second:
//! ```math
//! θ < \frac{2}{μ_{max}}, \qquad θ = \frac{2}{μ_{min} + μ_{max}}                                               \qquad (14)
//! ```
//! in [`Spectrum::theta_limit`](nndd::Spectrum::theta_limit), [`Spectrum::best_theta`](nndd::Spectrum::best_theta).
//!
//! # The bound
//! `v` satisfies (4) and `o ≥ 0`; `τ` satisfies (2), (3) and (6), (7) with a pressure `p ≥ 0`. The potentials of the contact law
//! (De Saxcé 1992) then vanish, and only the work of the pressure on the opening remains of the
//! paper's (12):
//! ```math
//! φ(-[v]) + φ^*(t_c) + [v]·t_c + p\,g = p\,o ≥ 0, \text{ and } = 0 \text{ for the solution}                             \qquad (12)
//! ```
//! ```math
//! e_{CRE}^2 = \sum_α ‖τ^α - σ(v^α)‖^2 + 2 ∫_{Γ_C} p\,o, \qquad ‖τ‖^2 = ∫ τ : \mathbb{E}^{-1} τ                 \qquad (15)
//! ```
//! ```math
//! e_{CRE}^2 = ‖u - v‖^2 + ‖σ - τ‖^2 + 2 ∫ p\,o_{ex} + 2 ∫ p_{ex}\,o \; ≥ \; ‖u - v‖^2                           \qquad (16)
//! ```
//! (16): write `τ − σ(v) = (τ − σ) + (σ − σ(v))`; by equilibrium the cross term is `2∫ (p − p_ex)(o_ex − o)`, and `p_ex o_ex = 0`. It
//! splits without a cross term, `σ̂` being the FE stress in equilibrium with `p`, since `τ − σ̂` is orthogonal to FE strains:
//! ```math
//! e_{CRE}^2 = \underbrace{\sum ‖τ - \hat σ‖^2}_{\text{mesh}}
//!           + \underbrace{\sum ‖\hat σ - σ(v)‖^2 + 2 ∫ p\,o}_{\text{iteration}}                                \qquad (17)
//! ```
//! If the normal changes along an edge, the computed displacements may penetrate between the nodes; at the nodes they may by
//! rounding, if stiffnesses are many orders of magnitude apart. The lift `l`
//! removes the penetration; `l_n ≥ 0` is the opening that it adds. The bound holds for the computed displacements,
//! without the lift:
//! ```math
//! e_{CRE}^2 = \sum_α ‖τ^α - σ(v^α)‖^2 + 2 ∫ p\,(o + l_n) + ‖l‖^2 \; ≥ \; ‖u - v‖^2                            \qquad (26)
//! ```
//! (26): the identity (16) holds for openings of any sign; `−2∫ p_ex o ≤ 2∫ p_ex l_n = 2∫ p l_n + 2∫ (σ − τ) : ε(l)`, and
//! `2 ‖σ − τ‖ ‖l‖ ≤ ‖σ − τ‖² + ‖l‖²`. With a lift the bound covers the displacements alone.
//!
//! | formula | where |
//! |---|---|
//! | (26) | [`Lift`](cre_estimator::Lift): it moves the body whose lift costs less energy |
//! | (12) | [`pressure::contact_terms`](cre_estimator::pressure::contact_terms), with the consistent mass |
//! | (15), (17) | [`cre::constitutive_relation_error`](cre_estimator::cre::constitutive_relation_error); [`Cre::split_defect`](cre_estimator::Cre::split_defect) |
//! | (16) | its consequences: [`Bounds`](crate::Bounds); its conditions, as residuals: [`check()`](cre_estimator::check()) |
//!
//! # A stress in exact equilibrium
//! ```math
//! p_i = r^2_i / ℓ_i, \qquad \int \hat σ^α : ε(v) = ℓ^α(v) ∓ ∫_{Γ_C} p\,n·v \quad \text{for all FE } v           \qquad (18)
//! ```
//! ```math
//! \sum_{Γ ∋ i} ± b_Γ = ∫_E \hat σ ∇φ_i - ∫_E b\,φ_i, \qquad b_Γ = ∫_Γ F_Γ φ_i, \qquad \sum \frac{|b_Γ - \bar b_Γ|^2}{|Γ|} \text{ least} \qquad (19)
//! ```
//! ```math
//! τ|_E: \; \text{linear on the three parts of } E, \text{ symmetric}, \; \operatorname{div} τ + b = 0, \; τ n = F_Γ, \qquad
//! τ = \frac{1}{J} F \hat τ F^T                                                                              \qquad (20)
//! ```
//! ```math
//! \min_{φ} ‖τ_{EET} + R ∇^2 φ R^T - \hat σ‖^2, \qquad φ \text{ of Hsieh, Clough and Tocher}                    \qquad (21)
//! ```
//! | formula | where |
//! |---|---|
//! | (18) | [`pressure::nodal_pressure`](cre_estimator::pressure::nodal_pressure), [`admissible_pair`](cre_estimator::admissible_pair()) |
//! | (19) | [`eet::edge_moments`](cre_estimator::eet::edge_moments) |
//! | (20) | [`johnson_mercier::cell_stress`](cre_estimator::johnson_mercier::cell_stress) |
//! | (21) | [`star_relaxation::relax`](cre_estimator::star_relaxation::relax): every step gives a bound |
//!
//! # The indicators, and when to stop
//! ```math
//! η_{NNDD} = ‖\bar w‖, \quad S_1 \bar w = r^1 + r^2, \qquad ‖u_h - u_p‖ ≤ η_{NNDD}                              \qquad (22)
//! ```
//! ```math
//! η_{dis}^2 = ‖τ^1_λ - σ(u^1_p)‖^2 + ‖τ^2 - σ(u^2_p)‖^2 + 2 ∫ p\,o \quad \text{(the bound (15) of (8), (9) for frozen λ)} \qquad (23)
//! ```
//! ```math
//! ε_t = \frac{2 \max |t^1 + t^2|}{\max |t^1| + \max |t^2|}, \quad t_i = r_i / ℓ_i, \qquad
//! \text{stop:} \; η_{NNDD} ≤ γ\,η_{dis}, \; |F_1 - F_2| ≤ β \max |F_α|                                          \qquad (24)
//! ```
//! with the contact forces `F₁ = −Σ r¹_i`, `F₂ = Σ r²_i` of the two bodies, which are equal at the discrete solution.
//! | formula | where |
//! |---|---|
//! | (22), `ε_t` | [`Iterate::eta_nndd`](nndd::Iterate::eta_nndd), [`Iterate::precision`](nndd::Iterate::precision) |
//! | (23) | [`Indicators::eta_dis`](cre_estimator::Indicators::eta_dis) |
//! | (24) | [`Criterion`](crate::Criterion); γ = 0.01 and β = 1e-3 by default |
//! | where to refine | [`marking`](cre_estimator::marking), [`solve_adaptively`](crate::solve_adaptively) |
//!
//! # Round-off
//! The terms of (15) are computed with rounding. Proven: the displacements are those that the program prints, so (16)
//! bounds exactly their error. The computed stress `τ̃` violates equilibrium by a residual `R`, and there is a stress
//! in exact equilibrium at a distance of at most the dual norm of `R`. The part of this norm on the FE space is
//! measured:
//! ```math
//! R_i = ∫ \tilde τ : ε(φ_i) - f(φ_i), \qquad e_{CRE} ≤ e_{CRE}(\tilde τ) + 2 \sqrt{R · K^{-1} R}                 \qquad (27)
//! ```
//! A margin, not proven: the factor 2 covers the remainder of the dual norm (jumps between the nodes that are
//! orthogonal to all FE functions) and the rounding of the factorised `K`. A model of the rounding of each triangle
//! is used instead if it is larger. `R` is evaluated from the computed stress, first in double precision, whose own
//! rounding makes it larger. If the round-off is more than 0.1 % of the bound, the solves are refined, and `R` is
//! evaluated in double-double arithmetic.
//!
//! If rounding is more than 0.1 % of the bound, the solution is improved by defect correction: the forces of the
//! current fields `u_0`, two numbers per component, are evaluated without rounding, and the contact problem is solved
//! for increments:
//! ```math
//! r^α = r^α_0 + S_α x^α, \qquad r_0^α = K u_0^α - f, \qquad o = (g - [v_0]) - (x^1 - x^2)                           \qquad (28)
//! ```
//! `η_NNDD` with its round-off is the constitutive relation error of the discrete problem, with `R` the residual of the printed
//! displacements under the contact forces `r`; in exact arithmetic it is (22):
//! ```math
//! η_{NNDD}^2 = \sum_α R^α · K_α^{-1} R^α + 2 \sum_i r_i o_i                                                     \qquad (29)
//! ```
//! | formula | where |
//! |---|---|
//! | (27) | [`Estimate`](cre_estimator::Estimate), `round_off`; [`residual::of_stress`](fem_core::residual::of_stress), [`CondensedBody::residual_energy`](fem_core::condensation::CondensedBody::residual_energy), [`CondensedBody::refine`](fem_core::condensation::CondensedBody::refine) |
//! | (28) | [`solve`](crate::solve()), after the iteration |
//! | (29) | [`Indicators::eta_nndd`](cre_estimator::Indicators::eta_nndd) |
//!
//! # The parts
//! With `K z = −R` of (29) and `K a` the difference between the consistent loads of `p` and the nodal forces, `û − v = z + a`:
//! ```math
//! (e_{CRE} - \text{round-off})^2 = \underbrace{\sum ‖τ - \hat σ‖^2}_{\text{mesh}} + \underbrace{s\,‖\hat σ - σ(v)‖^2}_{\text{iteration}}
//!     + \underbrace{(1 - s)\,‖\hat σ - σ(v)‖^2 + 2 ∫ p\,o}_{\text{contact}} + \underbrace{‖l‖^2 + 2 ∫ p\,l_n}_{\text{lift}}, \quad
//!     s = \frac{‖z‖^2}{‖z‖^2 + ‖a‖^2}                                                                       \qquad (30)
//! ```
//! in [`Parts`](cre_estimator::Parts); the part of the iteration is at most `η_NNDD²`.
//!
//! # Friction
//! With the tangent `t = (−n_y, n_x)` the slip is `w = (u^1 − u^2)·t`, and the tractions are `−p n − q t` on the first body, `+p n + q t` on the
//! second. In place of (7), with a limit `s` that is given (Tresca) or `μ p` (Coulomb):
//! ```math
//! |q| ≤ s, \qquad q\,w = s\,|w| \quad \text{on } Γ_C
//! ```
//! For Tresca, let `v` satisfy (4) and `o ≥ 0`, and `τ` (2), (3) with tractions `p ≥ 0`, `|q| ≤ s` common to both bodies. Then
//! ```math
//! e_{CRE}^2 = \sum_α ‖τ^α - σ(v^α)‖^2 + 2 ∫ p\,o + 2 ∫ (s|w| - q\,w)                                              \qquad (32)
//! ```
//! ```math
//! e_{CRE}^2 = ‖u - v‖^2 + ‖σ - τ‖^2 + 2 ∫ (p\,o_{ex} + p_{ex}\,o) + 2 ∫ \bigl[ (s|w_{ex}| - q\,w_{ex}) + (s|w| - q_{ex}\,w) \bigr] \; ≥ \; ‖u - v‖^2 + ‖σ - τ‖^2 \qquad (33)
//! ```
//! (33): as for (16), the cross term is now `2∫ [(p − p_ex)(o_ex − o) − (q − q_ex)(w_ex − w)]`; use `p_ex o_ex = 0` and `q_ex w_ex = s|w_ex|`. All
//! brackets are ≥ 0, since `|q|, |q_ex| ≤ s`. On straight lines `p`, `q` and `s` are linear between the nodes, `p_i = P_i/ℓ_i`, `q_i = Q_i/ℓ_i`,
//! so that `|q| ≤ s` holds between them as well; other limits are interpolated, and the certified problem is the interpolated one. (17) holds,
//! with (32) in its second part. Bounds of the potential energy gain `∫ s|w|`, see [`Bounds`](crate::Bounds).
//!
//! If the normal changes along an edge, `p` and `q` are constant there, `|q|` at most the smaller limit of its ends, so that the traction is
//! linear, and the slip is a quadratic. (33) does not use the length of `n` and `t`, and holds for openings of any sign of `v`; the limit along
//! `t` is `s/|n|` at the nodes, so that the traction there is at most `s`, and linear between. A lift `l` adds
//! the opening `l_n` and the slip `l_t`, and the bound for the displacements is
//! ```math
//! ‖u - v‖^2 \; ≤ \; e_{CRE}^2 = \sum_α ‖τ^α - σ(v^α)‖^2 + 2 ∫ p\,(o + l_n) + ‖l‖^2 + 2 ∫ (s|w| - q\,w) + 2 ∫ (s|l_t| - q\,l_t)  \qquad (36)
//! ```
//! (36): in (33) `−2∫ p_ex o ≤ 2∫ p_ex l_n = 2∫ p l_n + 2∫ (p_ex − p) l_n`. The virtual work of `σ − τ` on `l` is
//! `∫ (σ − τ) : ε(l) = ∫ (p_ex − p) l_n − ∫ (q_ex − q) l_t`, whichever body is lifted. So the last term is
//! `2∫ (σ − τ) : ε(l) + 2∫ (q_ex − q) l_t ≤ ‖σ − τ‖² + ‖l‖² + 2∫ (s|l_t| − q l_t)`, since `q_ex l_t ≤ s|l_t|`.
//!
//! In load step `k` the law holds for the slip since the step before, with the computed `w_{k−1}` as a datum:
//! ```math
//! |q| ≤ s, \qquad q\,(w - w_{k-1}) = s\,|w - w_{k-1}|                                                                  \qquad (37)
//! ```
//! (32) to (36) hold with `w − w_{k−1}` in place of `w`, since the datum cancels in every difference of slips. The certificate is that of the
//! increment: the error of `w_{k−1}` itself, which the steps accumulate, has no bound.
//!
//! For Coulomb `s` is `μ p` of the stress itself, and the same number `e_b` is zero only for an exact solution. With any exact solution
//! ```math
//! e_b^2 = ‖u - v‖^2 + ‖σ - τ‖^2 + 2 ∫ (p\,o_{ex} + p_{ex}\,o)
//!   + 2 ∫ \bigl[ (μ p|w_{ex}| - q\,w_{ex}) + (μ p_{ex}|w| - q_{ex}\,w) \bigr] + 2 μ ∫ (p - p_{ex})(|w| - |w_{ex}|)      \qquad (34)
//! ```
//! The last term has no sign, so that `e_b` is **no bound** of the error, only of the distance to the problem with the limit `μ p`. If the slips
//! `w` and `w_ex` have one common sign on each pair, open parts included, the last term is at least `−2 c ‖σ − τ‖ ‖u − v‖`, and for `c < 1`
//! ```math
//! ‖u - v‖ ≤ \frac{e_b}{\sqrt{1 - c^2}}, \qquad c = \sup_{π, ω} \frac{∫ μ\,π\,ω}{|||π|||\;|||ω|||}                        \qquad (35)
//! ```
//! by `A² + B² − 2 c A B ≥ (1 − c²) A²`. The `c` at hand is that of the mesh, so that this is an estimate.
//! | formula | where |
//! |---|---|
//! | the nodal law | [`Friction`](fem_core::interface::Friction), [`nndd::solve_exactly`]; Coulomb: [`nndd::solve_coulomb`] |
//! | (32), (36) | [`friction`](cre_estimator::friction), [`Cre::friction_squared`](cre_estimator::Cre::friction_squared) |
//! | (33) | its conditions: `friction_cone` of [`check()`](cre_estimator::check()) |
//! | (37) | [`LoadSteps`](crate::LoadSteps), [`SlipBefore`](fem_core::interface::SlipBefore) |
//! | (34), (35) | [`CoulombResult`](crate::CoulombResult); `c`: [`nndd::coulomb_coupling`] |
//!
//! # The percentage
//! The percentage that the program prints is relative to the norm of the computed displacements. A guaranteed bound
//! of the error over the norm of the *exact* ones follows, because `‖u‖ ≥ ‖v‖ − e_CRE`:
//! ```math
//! ε = \frac{e_{CRE}}{‖v‖}, \qquad \frac{‖u - v‖}{‖u‖} ≤ \frac{e_{CRE}}{‖v‖ - e_{CRE}} = \frac{ε}{1 - ε}            \qquad (25)
//! ```
//! in [`CertifiedSolution::relative`](crate::CertifiedSolution::relative),
//! [`relative_guaranteed`](crate::CertifiedSolution::relative_guaranteed).
//!
//! Sources: Ladevèze and Leguillon 1983 for (19), Johnson and Mercier 1978 for (20), Clough and Tocher 1965 for (21).
