// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) + g * y, constraint = [|[x, y]| 0.5 * (x * x + y * y - l * l)], embedding = Rattle)]
// pub struct Rod { pub g: f64, pub l: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Rattle

Hamiltonians
  H0 = g y + (px² + py²)/2

Constraints
  0 = g1 = (x² - l² + y²)/2

Discrete Lagrangian of the step from t_i to t_i + h, with F = h H0
  L_d = P · (q_{i+1} - q_i) - F(q_i, P, t_i)/2 - F(q_{i+1}, P, t_{i+1})/2
        - h/2 λ · g(q_i, t_i) - h/2 μ · g(q_{i+1}, t_{i+1})

Discrete Euler-Lagrange equations, with G = ∂g/∂q
  p_i = -D1 L_d:      P = p_i - 1/2 ∂F/∂q(q_i, t_i) - h/2 G(q_i, t_i)ᵀ λ
  ∂L_d/∂P = 0:        q_{i+1} = q_i + h ∂H0/∂p(P)
  ∂L_d/∂λ of the next step = 0:  g(q_{i+1}, t_{i+1}) = 0
  p_{i+1} = D2 L_d:   p_{i+1} = P - 1/2 ∂F/∂q(q_{i+1}, t_{i+1}) - h/2 G(q_{i+1}, t_{i+1})ᵀ μ
  0 = dg/dt:          0 = G(q_{i+1}, t_{i+1}) ∂H0/∂p(p_{i+1})
  G1, x = x
  G1, y = y

Step
  solve for λ: Newton, matrix h²/2 G(q_{i+1}) W G(q_i)ᵀ with W = ∂²H0/∂p²
  solve for μ: linear, matrix h/2 G W Gᵀ at q_{i+1}; degrees of freedom left: 1 of 2, if no constraint follows from others

Facts
  H0 is a first integral: kept by the step up to its order

```
*/
pub struct Rod {
    pub g: f64,
    pub l: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, Discretized, Facts, Labels, Number, Option, SVector, Scalar,
        Scheme, Sized, Some, Variables, bool, f64, str, usize,
        compose::{Nystrom, WholeOf},
        constraints::{Constrained, ConstraintRows, DenseConstraints, Manifold},
        elements::{ElementInput, Elements, EvaluationPoint, Partials, Role, Sums},
        embedding::Rattle, gauss::Fixed,
    };
    #[automatically_derived]
    impl Elements for Rod {
        const FACTS: Facts = Facts::autonomous(2);
        type Shape = Fixed<2>;
        type Structure = Nystrom;
        type Vector = SVector<f64, 2>;
        fn manifold(&self) -> Option<&dyn Manifold> {
            Some(self)
        }
        fn variables(&self) -> Variables {
            Variables {
                q: Labels::Each(&["x", "y"]),
                p: Labels::Each(&["px", "py"]),
                t: "t",
                invariants: &[],
                observables: &[],
            }
        }
        fn parameter(&self, index: usize) -> Option<(&'static str, f64)> {
            [("g", self.g), ("l", self.l)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let g = at.parameter(0, self.g);
            match role {
                Role::Drift => {
                    let g = S::of_constant(g);
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    (y * g + (px * px + py * py) * 0.5) * S::of_constant(at.h)
                }
                _ => S::from_f64(0.0),
            }
        }
        type CommonRange = f64;
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn gradient<S: Scalar, T: Number<S>>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S, impl ElementInput<S> + ?Sized>,
            partials: Partials,
            by_q: &mut (impl Sums<S> + ?Sized),
            by_p: &mut (impl Sums<S> + ?Sized),
        ) {
            let g = at.parameter(0, self.g);
            match role {
                Role::Drift => {
                    if partials.by_q {
                        let g = T::of_constant(g);
                        let factor = T::of_constant(at.h);
                        by_q.add(1, factor * g);
                    }
                    if partials.by_p {
                        let factor = T::of_constant(at.h);
                        let px = T::of(at.p[0]);
                        let py = T::of(at.p[1]);
                        by_p.add(0, px * factor);
                        by_p.add(1, py * factor);
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Constrained for Rod {
        type Layout = DenseConstraints<2, 1>;
        const READ_TIME: bool = false;
        const HAS_SQUARES: bool = true;
        const CONSTRAINTS: usize = 1;
        fn constraints(&self) -> usize {
            1
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn constrain<S: Scalar>(
            &self,
            at: &EvaluationPoint<'_, S>,
            into: &mut impl ConstraintRows<S>,
        ) {
            let l = at.parameter(1, self.l);
            let l_squared = S::of_constant(l * l);
            let x = at.q[0];
            let y = at.q[1];
            into.value(0, (x * x + y * y - l_squared) * 0.5);
            into.slope(0, 0, x);
            into.slope(0, 1, y);
        }
    }
    #[automatically_derived]
    impl Discretized<Rattle> for Rod {
        type Scheme = WholeOf<Self, Rattle>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Rattle\n\nHamiltonians\n  H0 = g y + (px² + py²)/2\n\nConstraints\n  0 = g1 = (x² - l² + y²)/2\n\nDiscrete Lagrangian of the step from t_i to t_i + h, with F = h H0\n  L_d = P · (q_{i+1} - q_i) - F(q_i, P, t_i)/2 - F(q_{i+1}, P, t_{i+1})/2\n        - h/2 λ · g(q_i, t_i) - h/2 μ · g(q_{i+1}, t_{i+1})\n\nDiscrete Euler-Lagrange equations, with G = ∂g/∂q\n  p_i = -D1 L_d:      P = p_i - 1/2 ∂F/∂q(q_i, t_i) - h/2 G(q_i, t_i)ᵀ λ\n  ∂L_d/∂P = 0:        q_{i+1} = q_i + h ∂H0/∂p(P)\n  ∂L_d/∂λ of the next step = 0:  g(q_{i+1}, t_{i+1}) = 0\n  p_{i+1} = D2 L_d:   p_{i+1} = P - 1/2 ∂F/∂q(q_{i+1}, t_{i+1}) - h/2 G(q_{i+1}, t_{i+1})ᵀ μ\n  0 = dg/dt:          0 = G(q_{i+1}, t_{i+1}) ∂H0/∂p(p_{i+1})\n  G1, x = x\n  G1, y = y\n\nStep\n  solve for λ: Newton, matrix h²/2 G(q_{i+1}) W G(q_i)ᵀ with W = ∂²H0/∂p²\n  solve for μ: linear, matrix h/2 G W Gᵀ at q_{i+1}; degrees of freedom left: 1 of 2, if no constraint follows from others\n\nFacts\n  H0 is a first integral: kept by the step up to its order\n";
    }
    wzvi::bindings! {
        at by_p by_q factor g index into l l_squared partials px py role weight x y
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Rod {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<::wzvi::embedding::Rattle>(checks::PhantomData::<Rattle>);
            {
                let g = self.g;
                checks::of_state::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y], [px, py]| 0.5 * (px * px + py * py) + g * y);
            }
            {
                let l = self.l;
                checks::of_coordinates::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y]| 0.5 * (x * x + y * y - l * l));
            }
        }
    }
};
