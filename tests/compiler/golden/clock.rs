// Made by `GOLDEN=overwrite cargo test -p wzvi-macros golden` from
//
// #[hamiltonian(drift = |[x, y], [px, py]| 0.5 * (px * px + py * py) / m - k / (x * x + y * y).sqrt(), clock = curvature, embedding = Clocked<Verlet>)]
// pub struct Kepler { pub m: f64, pub k: f64 }

use wzvi::prelude::*;

/**
# Discrete equations

```text
Clock
  Q = r^(3/2) √|m|/(5^(1/4) √|k|)
  G = -d ln Q/dt = -3 (x px/m + y py/m)/(2 r²)
  r = √(x² + y²)
```

```text
Verlet

Hamiltonians
  H0 = (px² + py²)/(2 m) - k/√(x² + y²)

A step of size h is two of size h/2, with half of the increments each:

DeltaPlus

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}²)/(2 m) - k/√(x_i² + y_i²))
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h k x_i/(x_i² + y_i²)^(3/2)
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = δpx
  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/m
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h k y_i/(x_i² + y_i²)^(3/2)
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = δpy

Step
  assign δpx
  assign Δx
  assign δpy
  assign Δy

DeltaMinus

Discrete Lagrangian of the step from t_i to t_i + h
  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}²)/(2 m) - k/√(x_{i+1}² + y_{i+1}²))
  Δx = x_{i+1} - x_i
  Δy = y_{i+1} - y_i
  x_{i+1} = x_i + Δx
  y_{i+1} = y_i + Δy

Discrete Euler-Lagrange equations
  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m
  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = 0
  px_{i+1} = D2 L_d:  px_{i+1} - px_i = δpx - h k x_{i+1}/(x_{i+1}² + y_{i+1}²)^(3/2)
  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/m
  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = 0
  py_{i+1} = D2 L_d:  py_{i+1} - py_i = δpy - h k y_{i+1}/(x_{i+1}² + y_{i+1}²)^(3/2)

Step
  assign δpx
  assign Δx
  assign δpy
  assign Δy

Step, by the flows of H = T(p) + V(q), which are exact
  kick of h/2 at t:      p <- p - h/2 ∂V/∂q
  drift of h:            q <- q + h ∂T/∂p
  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step
  (in compositions drifts and kicks that meet are one)

Facts
  H0 is a first integral: kept by the step nearly, within O(h²)
  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 + H_qq(H_p,H_p)/12)
    H_pp(H_q,H_q) = k² x²/(m (x² + y²)³) + k² y²/(m (x² + y²)³)
    H_qq(H_p,H_p) = px (k px/(m (x² + y²)^(3/2)) - 3 k x² px/(m (x² + y²)^(5/2)) - 3 k x y py/(m (x² + y²)^(5/2)))/m + py (k py/(m (x² + y²)^(3/2)) - 3 k x y px/(m (x² + y²)^(5/2)) - 3 k y² py/(m (x² + y²)^(5/2)))/m

```
*/
pub struct Kepler {
    pub m: f64,
    pub k: f64,
}
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    use ::wzvi::__private::{
        self as wzvi, ComputesWith, Conservative, Constant, ConstantsIn, Discretized,
        Facts, Labels, LiftParameter, Number, Option, Reals, SVector, Scalar, Scheme,
        Sized, Variables, bool, f64, str, usize, clock::Clock,
        compose::{Nystrom, WholeOf},
        elements::{
            ElementInput, Elements, EvaluationPoint, FieldAt, PairColumns, Partials,
            Role, Sums,
        },
        embedding::Verlet, gauss::{Field, Fixed},
    };
    #[automatically_derived]
    impl Elements for Kepler {
        const FACTS: Facts = Facts::autonomous(2);
        type Shape = Fixed<2>;
        type Structure = Nystrom;
        type Vector = SVector<f64, 2>;
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
            [("m", self.m), ("k", self.k)].get(index).copied()
        }
        fn value<S: Scalar>(
            &self,
            role: Role,
            weight: f64,
            at: &EvaluationPoint<'_, S>,
        ) -> S {
            let m = at.parameter(0, self.m);
            let k = at.parameter(1, self.k);
            match role {
                Role::Drift => {
                    let quotient = S::of_constant(
                        <S::Constant as Scalar>::from_f64(0.5) / m,
                    );
                    let k = S::of_constant(k);
                    let x = at.q[0];
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    let sum = x * x + y * y;
                    ((px * px + py * py) * quotient - k * (sum.recip() * sum.sqrt()))
                        * S::of_constant(at.h)
                }
                Role::Clock => {
                    let abs_k = k.abs();
                    let sqrt = Scalar::sqrt(5f64);
                    let product = S::of_constant(
                        abs_k.sqrt() * abs_k.recip()
                            * (m.abs().sqrt()
                                * (Scalar::sqrt(sqrt) * sqrt * 5f64.recip())),
                    );
                    let x = at.q[0];
                    let y = at.q[1];
                    let sqrt2 = (x * x + y * y).sqrt();
                    product * (sqrt2 * sqrt2.sqrt())
                }
                Role::ClockRate => {
                    let inverse_m = S::of_constant(m.recip());
                    let x = at.q[0];
                    let y = at.q[1];
                    let px = at.p[0];
                    let py = at.p[1];
                    -((inverse_m * (x * px) + inverse_m * (y * py)) / (x * x + y * y)
                        * 1.5)
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
            let m = at.parameter(0, self.m);
            let k = at.parameter(1, self.k);
            match role {
                Role::Drift => {
                    if partials.by_p {
                        let inverse_m = T::of_constant(m.recip());
                        let factor = T::of_constant(at.h);
                        let px = T::of(at.p[0]);
                        let py = T::of(at.p[1]);
                        by_p.add(0, inverse_m * (px * factor));
                        by_p.add(1, inverse_m * (py * factor));
                    }
                    if partials.by_q {
                        let k = T::of_constant(k);
                        let factor = T::of_constant(at.h);
                        let x = T::of(at.q[0]);
                        let y = T::of(at.q[1]);
                        let sum = x * x + y * y;
                        let inverse = sum.recip();
                        let product = inverse * (inverse * sum.sqrt());
                        by_q.add(0, k * (x * factor * product));
                        by_q.add(1, k * (product * (y * factor)));
                    }
                }
                _ => {}
            }
        }
    }
    #[automatically_derived]
    impl Clock for Kepler {
        const CLOCK: &'static str = "Clock\n  Q = r^(3/2) √|m|/(5^(1/4) √|k|)\n  G = -d ln Q/dt = -3 (x px/m + y py/m)/(2 r²)\n  r = √(x² + y²)\n";
    }
    #[automatically_derived]
    impl Field for Kepler {
        const IS_NYSTROM: bool = true;
        const IN_LANES: bool = true;
        type Noises = Fixed<0>;
        type Parameters = Reals<2>;
        fn parameters<K: Constant>(
            &self,
            lift: LiftParameter<'_, K>,
        ) -> ConstantsIn<Self::Parameters, K> {
            [lift(0, self.m), lift(1, self.k)]
        }
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn step_gradient<
            K: Constant,
            S: ComputesWith<K>,
            const BY_Q: bool,
            const BY_P: bool,
        >(
            &self,
            parameters: &ConstantsIn<Self::Parameters, K>,
            ([t, h], [coordinates, momenta], increments): FieldAt<'_, S>,
            [by_q,
            by_p,
            ]: [&mut [S]; 2],
            _: &mut PairColumns,
        ) {
            let [m, k] = *parameters;
            let (&[x, y], &[px, py], &[]) = (coordinates, momenta, increments) else {
                return wzvi::gauss::unfit(by_q, by_p);
            };
            let sum = x * x + y * y;
            let inverse = sum.recip();
            let product = inverse * (inverse * sum.sqrt());
            let inverse_m = m.recip();
            if BY_Q {
                by_q.copy_from_slice(&[x * h * product * k, product * (y * h) * k]);
            }
            if BY_P {
                by_p.copy_from_slice(&[px * h * inverse_m, py * h * inverse_m]);
            }
        }
    }
    #[automatically_derived]
    impl Discretized<Verlet> for Kepler {
        type Scheme = WholeOf<Self, Verlet>;
        type Prepared = <Self::Scheme as Scheme<Self>>::Prepared<f64>;
        const EQUATIONS: &'static str = "Verlet\n\nHamiltonians\n  H0 = (px² + py²)/(2 m) - k/√(x² + y²)\n\nA step of size h is two of size h/2, with half of the increments each:\n\nDeltaPlus\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}²)/(2 m) - k/√(x_i² + y_i²))\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = -h k x_i/(x_i² + y_i²)^(3/2)\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = δpx\n  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/m\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = -h k y_i/(x_i² + y_i²)^(3/2)\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = δpy\n\nStep\n  assign δpx\n  assign Δx\n  assign δpy\n  assign Δy\n\nDeltaMinus\n\nDiscrete Lagrangian of the step from t_i to t_i + h\n  L_d = P_{px} Δx + P_{py} Δy - h ((P_{px}² + P_{py}²)/(2 m) - k/√(x_{i+1}² + y_{i+1}²))\n  Δx = x_{i+1} - x_i\n  Δy = y_{i+1} - y_i\n  x_{i+1} = x_i + Δx\n  y_{i+1} = y_i + Δy\n\nDiscrete Euler-Lagrange equations\n  ∂L_d/∂P_{px} = 0:  Δx = h P_{px}/m\n  px_i = -D1 L_d:  P_{px} = px_i + δpx,  δpx = 0\n  px_{i+1} = D2 L_d:  px_{i+1} - px_i = δpx - h k x_{i+1}/(x_{i+1}² + y_{i+1}²)^(3/2)\n  ∂L_d/∂P_{py} = 0:  Δy = h P_{py}/m\n  py_i = -D1 L_d:  P_{py} = py_i + δpy,  δpy = 0\n  py_{i+1} = D2 L_d:  py_{i+1} - py_i = δpy - h k y_{i+1}/(x_{i+1}² + y_{i+1}²)^(3/2)\n\nStep\n  assign δpx\n  assign Δx\n  assign δpy\n  assign Δy\n\nStep, by the flows of H = T(p) + V(q), which are exact\n  kick of h/2 at t:      p <- p - h/2 ∂V/∂q\n  drift of h:            q <- q + h ∂T/∂p\n  kick of h/2 at t + h:  p <- p - h/2 ∂V/∂q, whose force is that of the first kick of the next step\n  (in compositions drifts and kicks that meet are one)\n\nFacts\n  H0 is a first integral: kept by the step nearly, within O(h²)\n  modified energy, kept within O(h⁴): H0 + h² (-H_pp(H_q,H_q)/24 + H_qq(H_p,H_p)/12)\n    H_pp(H_q,H_q) = k² x²/(m (x² + y²)³) + k² y²/(m (x² + y²)³)\n    H_qq(H_p,H_p) = px (k px/(m (x² + y²)^(3/2)) - 3 k x² px/(m (x² + y²)^(5/2)) - 3 k x y py/(m (x² + y²)^(5/2)))/m + py (k py/(m (x² + y²)^(3/2)) - 3 k x y px/(m (x² + y²)^(5/2)) - 3 k y² py/(m (x² + y²)^(5/2)))/m\n";
    }
    #[automatically_derived]
    impl Conservative for Kepler {}
    wzvi::bindings! {
        abs_k at by_p by_q coordinates factor h increments index inverse inverse_m k lift
        m momenta parameters partials product px py quotient role sqrt sqrt2 sum t weight
        x y
    }
};
#[allow(warnings, clippy::all, clippy::pedantic, clippy::nursery, clippy::restriction)]
const _: () = {
    #[automatically_derived]
    impl Kepler {
        fn __closures(&self) {
            use ::wzvi::__private::checks as checks;
            checks::is_same::<
                ::wzvi::embedding::Clocked<::wzvi::embedding::Verlet>,
            >(checks::PhantomData::<Clocked<Verlet>>);
            {
                let m = self.m;
                let k = self.k;
                checks::of_state::<
                    [::core::primitive::f64; 2usize],
                    _,
                >(|[x, y], [px, py]| {
                    0.5 * (px * px + py * py) / m - k / (x * x + y * y).sqrt()
                });
            }
        }
    }
};
