//! The method on one page: each formula with the function that computes it.
//!
//! Numbers (1) to (12) are from Choi, Gallimard and Sassi; the other numbers continue from there, in the order of
//! a run. Misprints of the paper are corrected: `t·σn` in (7); in (10), (11) the corrections vanish where
//! displacements are imposed.
//!
//! # The problem
//! Two bodies Ω₁, Ω₂, the unit normal `n` out of the first on the contact line Γ_C, the initial gap `g`, negative for a press fit. For α = 1, 2:
//! ```math
//! σ^α = 𝔼^α ε(u^α)                             in Ω_α      (1)
//! div σ^α + b^α = 0                            in Ω_α      (2)
//! σ^α n^α = F^α                                on Γ_N^α    (3)
//! u^α = u_D^α                                  on Γ_D^α    (4)
//! o = g − (u^1 − u^2)·n ≥ 0, p ≥ 0, p o = 0    on Γ_C      (5)
//! n·σ^α n = −p, t·σ^α n = 0                    on Γ_C      (6), (7)
//! ```
//! | formula | where |
//! |---|---|
//! | (1) | [`LinearElastic::stress`](fem_core::material::LinearElastic::stress), [`field::stresses`](fem_core::field::stresses) |
//! | (2), (3), (4) | [`BoundaryConditions`](fem_core::boundary::BoundaryConditions), evaluated in [`Body::new`](fem_core::body::Body::new); their weak form in [`System::assemble`](fem_core::assembly::System::assemble) |
//! | (5)-(7) | the nodal law in step 1, (9); the sign of `p`: [`ContactSystem`](fem_core::contact_system::ContactSystem); its pairs, normals and gaps in [`ContactInterface`](fem_core::interface::ContactInterface) |
//!
//! # The iteration
//! Given the normal trace λ on Γ_C, nodal forces `r` and the Steklov-Poincaré operators S₁, S₂:
//! ```math
//! step 1   v^1 = λ                                        r^1 = S₁ λ − g̃^1          (8)
//!          v^2 = argmin ½ v·S₂ v − g̃^2·v over v ≥ λ − g   r^2 = S₂ v^2 − g̃^2 ≥ 0    (9)
//! step 2   S₁ w^1 = −½ (r^1 + r^2)                                                  (10)
//!          S₂ w^2 = +½ (r^1 + r^2)                                                  (11)
//! update   λ ← λ + θ (w^1 − w^2)
//! ```
//! | formula | where |
//! |---|---|
//! | (8) | [`InterfaceOperator::reaction`](fem_core::condensation::InterfaceOperator::reaction) |
//! | (9) | [`contact_qp::solve_box`] |
//! | (10), (11) | [`InterfaceOperator::trace_from_force`](fem_core::condensation::InterfaceOperator::trace_from_force) |
//! | the loop, a line per step | `iterate` in `crates/nndd/src/iteration.rs`, called by [`nndd::solve`]; weights other than ½ and other updates: [`nndd::Weights`], [`nndd::Acceleration`] |
//!
//! `S` is a by-product of the factorisation `K = L Lᵀ` with the interface last. The displacement is recovered only on
//! request:
//! ```math
//! S = L_CC L_CCᵀ,   g̃ = L_CC (L⁻¹ f)_C,   a(w, w) = w·S w     (13)
//! ```
//! in [`CondensedBody::factorise`](fem_core::condensation::CondensedBody::factorise),
//! [`displacement_from_trace`](fem_core::condensation::CondensedBody::displacement_from_trace).
//!
//! With `μ` the eigenvalues of `½(S₁⁻¹ + S₂⁻¹)(S₁ + S₂)` (full contact) the iteration converges for θ below the
//! first value, and is fastest at the second:
//! ```math
//! θ < 2/μ_max,   θ = 2/(μ_min + μ_max)     (14)
//! ```
//! in [`Spectrum::theta_limit`](nndd::Spectrum::theta_limit), [`Spectrum::best_theta`](nndd::Spectrum::best_theta).
//!
//! # The bound
//! `v` satisfies (4) and `o ≥ 0`; `τ` satisfies (2), (3) and (6), (7) with a pressure `p ≥ 0`. The potentials of the contact law
//! (De Saxcé 1992) then vanish, and only the work of the pressure on the opening remains of the
//! paper's (12):
//! ```math
//! φ(−[v]) + φ^*(t_c) + [v]·t_c + p g = p o ≥ 0,   and = 0 for the solution     (12)
//! ```
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫_Γ_C p o,   ‖τ‖² = ∫ τ : 𝔼⁻¹ τ     (15)
//! ```
//! ```math
//! e_CRE² = ‖u − v‖² + ‖σ − τ‖² + 2 ∫ p o_ex + 2 ∫ p_ex o ≥ ‖u − v‖²     (16)
//! ```
//! (16): write `τ − σ(v) = (τ − σ) + (σ − σ(v))`; by equilibrium the cross term is `2∫ (p − p_ex)(o_ex − o)`, and `p_ex o_ex = 0`. It
//! splits without a cross term, `σ̂` being the FE stress in equilibrium with `p`, since `τ − σ̂` is orthogonal to FE strains:
//! ```math
//! e_CRE²     = mesh + iteration     (17)
//! mesh       = ∑ ‖τ − σ̂‖²
//! iteration  = ∑ ‖σ̂ − σ(v)‖² + 2 ∫ p o
//! ```
//! If the normal changes along an edge, the computed displacements may penetrate between the nodes; at the nodes they may by
//! rounding, if stiffnesses are many orders of magnitude apart. The lift `l`
//! removes the penetration; `l_n ≥ 0` is the opening that it adds. The bound holds for the computed displacements,
//! without the lift:
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫ p (o + l_n) + ‖l‖² ≥ ‖u − v‖²     (26)
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
//! p_i = r^2_i/ℓ_i,   ∫ σ̂^α : ε(v) = ℓ^α(v) ∓ ∫_Γ_C p n·v   for all FE v     (18)
//! ```
//! ```math
//! ∑_{Γ ∋ i} ± b_Γ = ∫_E σ̂ ∇φ_i − ∫_E b φ_i,   b_Γ = ∫_Γ F_Γ φ_i,   ∑ |b_Γ − b̄_Γ|²/|Γ| least     (19)
//! ```
//! ```math
//! τ linear on the three parts of E, symmetric,   div τ + b = 0,   τ n = F_Γ,   τ = (1/J) F τ̂ Fᵀ     (20)
//! ```
//! ```math
//! min_φ ‖τ_EET + R ∇²φ Rᵀ − σ̂‖²,   φ of Hsieh, Clough and Tocher     (21)
//! ```
//! | formula | where |
//! |---|---|
//! | (18) | [`pressure::nodal_pressure`](cre_estimator::pressure::nodal_pressure), [`admissible_pair`](cre_estimator::admissible_pair()) |
//! | (19) | [`eet::facet_moments`](cre_estimator::eet::facet_moments) |
//! | (20) | [`johnson_mercier::cell_stress`](cre_estimator::johnson_mercier::cell_stress) |
//! | (21) | [`relax`](cre_estimator::relax): every step gives a bound |
//!
//! # The indicators, and when to stop
//! ```math
//! η_NNDD = ‖w̄‖,   S₁ w̄ = r^1 + r^2,   ‖u_h − u_p‖ ≤ η_NNDD     (22)
//! ```
//! ```math
//! η_dis² = ‖τ^1_λ − σ(u^1_p)‖² + ‖τ^2 − σ(u^2_p)‖² + 2 ∫ p o     (23)
//! ```
//! (23): the bound (15) of (8), (9) for frozen λ.
//! ```math
//! ε_t = 2 max |t^1 + t^2| / (max |t^1| + max |t^2|), t_i = r_i/ℓ_i
//! stop if η_NNDD ≤ γ η_dis and |F₁ − F₂| ≤ β max |F_α|     (24)
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
//! The terms of (15) are computed with rounding. Proven: (16) bounds the error of exactly the displacements that the
//! program prints. The computed stress `τ̃` violates equilibrium by a residual `R`, and there is a stress
//! in exact equilibrium at a distance of at most the dual norm of `R`. The part of this norm on the FE space is
//! measured:
//! ```math
//! R_i = ∫ τ̃ : ε(φ_i) − f(φ_i),   e_CRE ≤ e_CRE(τ̃) + 2 √(R·K⁻¹ R)     (27)
//! ```
//! A margin, not proven: the factor 2 covers the remainder of the dual norm (jumps between the nodes that are
//! orthogonal to all FE functions) and the rounding of the factorised `K`. A model of the rounding of each triangle
//! is used instead if it is larger. `R` is evaluated from the computed stress, first in double precision, whose own
//! rounding makes it larger. If the round-off is more than 0.1 % of the bound, the solves are refined, and `R` is
//! evaluated in double-double arithmetic.
//!
//! If rounding is more than 0.1 % of the bound, the solution is improved by defect correction: the forces of the
//! current fields `u₀`, two numbers per component, are evaluated without rounding, and the contact problem is solved
//! for increments:
//! ```math
//! r^α = r₀^α + S_α x^α,   r₀^α = K u₀^α − f,   o = (g − [v₀]) − (x^1 − x^2)     (28)
//! ```
//! `η_NNDD` with its round-off is the constitutive relation error of the discrete problem, with `R` the residual of the printed
//! displacements under the contact forces `r`; in exact arithmetic it is (22):
//! ```math
//! η_NNDD² = ∑_α R^α·K_α⁻¹ R^α + 2 ∑_i r_i o_i     (29)
//! ```
//! | formula | where |
//! |---|---|
//! | (27) | [`Estimate`](cre_estimator::Estimate), `round_off`; [`residual::of_stress`](fem_core::residual::of_stress), [`CondensedBody::residual_energies`](fem_core::condensation::CondensedBody::residual_energies), [`CondensedBody::refine`](fem_core::condensation::CondensedBody::refine) |
//! | (28) | [`solve`](crate::solve()), after the iteration |
//! | (29) | [`Indicators::eta_nndd`](cre_estimator::Indicators::eta_nndd) |
//!
//! # The parts
//! With `K z = −R` of (29) and `K a` the difference between the consistent loads of `p` and the nodal forces, `û − v = z + a`:
//! ```math
//! (e_CRE − round-off)²  = mesh + iteration + contact + lift     (30)
//! mesh                  = ∑ ‖τ − σ̂‖²
//! iteration             = s ‖σ̂ − σ(v)‖²
//! contact               = (1 − s) ‖σ̂ − σ(v)‖² + 2 ∫ p o
//! lift                  = ‖l‖² + 2 ∫ p l_n
//! s                     = ‖z‖²/(‖z‖² + ‖a‖²)
//! ```
//! in [`Parts`](cre_estimator::Parts); the part of the iteration is at most `η_NNDD²`.
//!
//! # Friction
//! With the tangent `t = (−n_y, n_x)` the slip is `w = (u^1 − u^2)·t`, and the tractions are `−p n − q t` on the first body, `+p n + q t` on the
//! second. In place of (7), with a limit `s` that is given (Tresca) or `μ p` (Coulomb):
//! ```math
//! |q| ≤ s,   q w = s|w|   on Γ_C
//! ```
//! For Tresca, let `v` satisfy (4) and `o ≥ 0`, and `τ` (2), (3) with tractions `p ≥ 0`, `|q| ≤ s` common to both bodies. Then
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫ p o + 2 ∫ (s|w| − q w)     (32)
//! ```
//! ```math
//! e_CRE²  = ‖u − v‖² + ‖σ − τ‖² + 2 ∫ (p o_ex + p_ex o) + 2 ∫ [(s|w_ex| − q w_ex) + (s|w| − q_ex w)]
//!         ≥ ‖u − v‖² + ‖σ − τ‖²     (33)
//! ```
//! (33): as for (16), the cross term is now `2∫ [(p − p_ex)(o_ex − o) − (q − q_ex)(w_ex − w)]`; use `p_ex o_ex = 0` and `q_ex w_ex = s|w_ex|`. All
//! brackets are ≥ 0, since `|q|, |q_ex| ≤ s`. On straight lines `p`, `q` and `s` are linear between the nodes, `p_i = P_i/ℓ_i`, `q_i = Q_i/ℓ_i`,
//! so that `|q| ≤ s` holds between them as well; other limits are interpolated, and the certified problem is the interpolated one. (17) holds,
//! with (32) in its second part. Bounds of the potential energy gain `∫ s|w|`, see [`Bounds`](crate::Bounds).
//! Where supports of both bodies impose the slip of a node, any `|Q| ≤ S` solves the discrete problem; it is `S` against the slip there, and `q` in (32) continues that
//! of the neighbours, since a limit far above the stresses would load the mesh beside the node.
//!
//! If the normal changes along an edge, `p` and `q` are constant there, `|q|` at most the smaller limit of its ends, so that the traction is
//! linear, and the slip is a quadratic. (33) does not use the length of `n` and `t`, and holds for openings of any sign of `v`; the limit along
//! `t` is `s/|n|` at the nodes, so that the traction there is at most `s`, and linear between. A lift `l` adds
//! the opening `l_n` and the slip `l_t`, and the bound for the displacements is
//! ```math
//! ‖u − v‖²  ≤ e_CRE²
//!           = ∑_α ‖τ^α − σ(v^α)‖² + 2 ∫ p (o + l_n) + ‖l‖² + 2 ∫ (s|w| − q w) + 2 ∫ (s|l_t| − q l_t)     (36)
//! ```
//! (36): in (33) `−2∫ p_ex o ≤ 2∫ p_ex l_n = 2∫ p l_n + 2∫ (p_ex − p) l_n`. The virtual work of `σ − τ` on `l` is
//! `∫ (σ − τ) : ε(l) = ∫ (p_ex − p) l_n − ∫ (q_ex − q) l_t`, whichever body is lifted. So the last term is
//! `2∫ (σ − τ) : ε(l) + 2∫ (q_ex − q) l_t ≤ ‖σ − τ‖² + ‖l‖² + 2∫ (s|l_t| − q l_t)`, since `q_ex l_t ≤ s|l_t|`.
//!
//! In space `q` and `w` are vectors along two tangents, and all of this holds with `|q|` as a length and `q·w` as a product. On flat faces `w`, `q` and `s`
//! are linear, and `|w|` is convex: with the mass matrix `M` of a face
//! ```math
//! ∫ (s|w| − q·w) ≤ Σ_ij M_ij (s_i |w_j| − q_i·w_j)
//! ```
//! without a negative term. (32) takes the right side, and so does `∫ s|w|` in the potential energy: the lower bound is the same as with integrals.
//!
//! In load step `k` the law holds for the slip since the step before, with the computed `w_{k−1}` as a datum:
//! ```math
//! |q| ≤ s,   q (w − w_{k−1}) = s|w − w_{k−1}|     (37)
//! ```
//! (32) to (36) hold with `w − w_{k−1}` in place of `w`, since the datum cancels in every difference of slips. The certificate is for the
//! increment: the error of `w_{k−1}` itself, which the steps accumulate, has no bound.
//!
//! For Coulomb `s` is `μ p` of the stress itself, and the same number `e_b` is zero only for an exact solution. With any exact solution
//! ```math
//! e_b²  = ‖u − v‖² + ‖σ − τ‖² + 2 ∫ (p o_ex + p_ex o)
//!       + 2 ∫ [(μ p|w_ex| − q w_ex) + (μ p_ex|w| − q_ex w)] + 2 μ ∫ (p − p_ex)(|w| − |w_ex|)     (34)
//! ```
//! The last term has no sign, so that `e_b` is **no bound** of the error, only of the distance to the problem with the limit `μ p`. If the slips
//! `w` and `w_ex` have one common sign on each pair, open parts included, the last term is at least `−2 c ‖σ − τ‖ ‖u − v‖`, and for `c < 1`
//! ```math
//! ‖u − v‖ ≤ e_b/√(1 − c²),   c = sup (∫ μ π ω)/(|||π||| |||ω|||) over π, ω     (35)
//! ```
//! by `A² + B² − 2 c A B ≥ (1 − c²) A²`. The `c` at hand is computed on the mesh, so that this is an estimate.
//! | formula | where |
//! |---|---|
//! | the nodal law | [`Friction`](fem_core::interface::Friction), [`nndd::solve_exactly`]; Coulomb: [`nndd::solve_coulomb`] |
//! | (32), (36) | [`friction`](cre_estimator::friction), [`Cre::friction_squared`](cre_estimator::Cre::friction_squared) |
//! | (33) | its conditions: `friction_cone` of [`check()`](cre_estimator::check()) |
//! | (37) | [`LoadSteps`](crate::LoadSteps), [`SlipBefore`](fem_core::interface::SlipBefore) |
//! | (34), (35) | [`CoulombResult`](crate::CoulombResult); `c`: [`nndd::coulomb_coupling`] |
//!
//! # Springs
//! On a side `Γ_S` on springs the traction along them is `−k (u − u₀)`. With `‖w‖² = a(w, w) + ∫ k w²` and `t = τ n` there,
//! ```math
//! e_CRE² = ∑_α ‖τ^α − σ(v^α)‖² + ∫_Γ_S (1/k) |t + k (v − u₀)|² + 2 ∫ p o
//!        = ‖u − v‖² + ‖σ − τ‖² + ∫_Γ_S (1/k) |t − t_ex|² + 2 ∫ (p o_ex + p_ex o)     (41)
//! ```
//! (41): the cross term of (16) gains `2∫ (t − t_ex)·(u − v)`, and `(1/k)|t + k(v − u₀)|²` is
//! `(1/k)|t − t_ex|² + k|u − v|² − 2(t − t_ex)·(u − v)`. The split (17) holds with `∫ (1/k)|t + k(û − u₀)|²` in its first part and `∫ k|û − v|²`
//! in its second. `k` is constant and `u₀` linear on each facet: the posed problem has the value of `k` in the middle of a facet. EET chooses the traction
//! closest to that of `û`, with the weight `(1 + E/(k h))/|Γ|`; soft springs keep it.
//! | formula | where |
//! |---|---|
//! | springs | [`FacetSprings`](fem_core::body::FacetSprings), [`SpringForce`](crate::SpringForce) |
//! | (41) | [`constitutive_relation_error`](cre_estimator::constitutive_relation_error) |
//!
//! # Cuts
//! Across a cut through a bolt `u^a − u^b = δ e`, with the axis `e` out of a, and the traction `t` on a is the opposite of that on b. If the force
//! `F` is given, `δ` is an unknown with the work `F δ`. The cross term of (16) gains
//! ```math
//! 2 ∫ (t − t_ex)·([u] − [v]) = 2 (∫ t·e − F) (δ_ex − δ)     (42)
//! ```
//! which is zero if `δ` is given, and if the stress of the bound has the force exactly. The tractions of EET add up to the FE force, and steps of the
//! relaxation do not change it. Columns are combined so that they do not, and the pressure of the bound does the same work as `r²` along the
//! displacements of a unit shortening, which by reciprocity leaves the force as it is. The nodal displacements are those of a; the jump is an
//! initial strain of the cells of b at the cut.
//! | formula | where |
//! |---|---|
//! | cuts | [`Cut`](fem_core::body::Cut), [`CutResults`](crate::CutResults) |
//! | (42) | its condition: `rigid_balance` of [`check()`](cre_estimator::check()) |
//!
//! # The percentage
//! The percentage that the program prints is relative to the norm of the computed displacements. A guaranteed bound
//! of the error over the norm of the *exact* ones follows, because `‖u‖ ≥ ‖v‖ − e_CRE`:
//! ```math
//! ε = e_CRE/‖v‖,   ‖u − v‖/‖u‖ ≤ e_CRE/(‖v‖ − e_CRE) = ε/(1 − ε)     (25)
//! ```
//! in [`CertifiedSolution::relative`](crate::CertifiedSolution::relative),
//! [`relative_guaranteed`](crate::CertifiedSolution::relative_guaranteed).
//!
//! Sources: Ladevèze and Leguillon 1983 for (19), Johnson and Mercier 1978 for (20), Clough and Tocher 1965 for (21).
