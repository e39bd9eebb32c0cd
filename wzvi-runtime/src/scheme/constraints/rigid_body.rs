//! Rigid bodies, whose coordinates are rotation matrices.

use std::fmt;

use nalgebra::{Matrix3, Rotation3, SVector, Vector3};

use crate::algebra::state::{State, Vector};

/// A rotation matrix `Q` as coordinates: `|q: Rotation, p|` in a closure of `#[hamiltonian]`.
///
/// `q[i][a]` is the component along axis `i` of space of the unit vector of axis `a` of the body, so that
/// `x = Q X` takes a point `X` of the body to its place `x`. The declaration adds six constraints,
/// `(QᵀQ - 1)/2 = 0` on the diagonal and `QᵀQ = 0` beside it. The momenta are a matrix, too:
/// `p[i][a] = d_a dq[i][a]/dt` with the [masses](RigidBody::masses) `d_a` of the body, if the kinetic energy
/// is `Σ_ia p[i][a]²/(2 d_a)`. The state is that of nine numbers, row by row; [`RigidBody::state`] makes one.
/// `|q: [Rotation; N], p|` declares `N` bodies.
///
/// # Example
///
/// A heavy top with its fixed point at the origin:
///
/// ```ignore
/// use wzvi::constraints::RigidBody;
/// use wzvi::nalgebra::{Rotation3, Vector3};
/// use wzvi::prelude::*;
///
/// #[hamiltonian(
///     drift = |q: Rotation, p| {
///         let kinetic: f64 = (0..3).map(|i| (0..3).map(|a| p[i][a] * p[i][a] / (2.0 * d[a])).sum::<f64>()).sum();
///         kinetic + weight * q[2][2]
///     },
///     embedding = Rattle,
/// )]
/// struct Top {
///     d: [f64; 3],
///     weight: f64,
/// }
///
/// let body = RigidBody::new([1.0, 1.0, 1.5])?;
/// let top = Top { d: body.masses(), weight: 2.0 };
/// let tilted = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.3);
/// let path = top.simulate::<Rattle>(0.01).start(body.state(tilted, Vector3::new(0.0, 0.0, 5.0))).steps(1000).run()?;
/// // The angular momentum about the vertical is conserved.
/// let momenta = path.iter().map(|state| body.angular_momentum_in_space(&state).z);
/// assert!(momenta.into_iter().all(|momentum| (momentum - 7.5 * f64::cos(0.3)).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Rotation = [[f64; 3]; 3];

/// A rigid body that turns about a fixed point, or about its centre of mass, by its principal moments of
/// inertia.
///
/// For a body with masses `m_n` at `X_n`, `I_1 = Σ m_n (X_n2² + X_n3²)` and so on; the masses of its
/// coordinates are `d_a = Σ m_n X_na² = (I_1 + I_2 + I_3)/2 - I_a`. (E. Hairer, C. Lubich, G. Wanner,
/// *Geometric Numerical Integration*, section VII.5.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody {
    inertia: Vector3<f64>,
}

impl RigidBody {
    /// The body with these principal moments of inertia, in units of mass times length squared.
    ///
    /// # Errors
    ///
    /// [`InertiaError`] if no body has these moments, or only one that is flat: the mass `d_a` across its
    /// plane is zero, and so `Σ p²/(2 d_a)` is not finite.
    pub fn new(inertia: [f64; 3]) -> Result<Self, InertiaError> {
        let body = Self { inertia: inertia.into() };
        let masses = body.masses();
        // Each mass is a difference of moments.
        let rounding = 4.0 * f64::EPSILON * body.inertia.amax();
        let first = |has: &dyn Fn(usize) -> bool| (0..3).find(|axis| has(*axis));
        let is_moment = |axis: usize| inertia[axis] > 0.0 && inertia[axis].is_finite();
        if let Some(axis) = first(&|axis| !is_moment(axis)) {
            return Err(InertiaError { axis, fault: InertiaFault::Moment(inertia[axis]) });
        }
        if let Some(axis) = first(&|axis| masses[axis] < -rounding) {
            return Err(InertiaError { axis, fault: InertiaFault::TooLarge(inertia[axis]) });
        }
        match first(&|axis| masses[axis] <= rounding) {
            Some(axis) => Err(InertiaError { axis, fault: InertiaFault::Flat }),
            None => Ok(body),
        }
    }

    /// The principal moments of inertia.
    pub fn inertia(&self) -> [f64; 3] {
        self.inertia.into()
    }

    /// The masses of the coordinates, `d_a = (I_1 + I_2 + I_3)/2 - I_a`: one for each column of `q`.
    pub fn masses(&self) -> [f64; 3] {
        let [x, y, z] = self.inertia();
        [0.5 * (y + z - x), 0.5 * (x + z - y), 0.5 * (x + y - z)]
    }

    /// The state at time 0 with this attitude and this angular velocity, by its components along the axes of
    /// the body, in radians per time: `q = Q`, `p_ia = d_a (Q ω̂)_ia`.
    pub fn state(
        &self,
        attitude: Rotation3<f64>,
        angular_velocity_in_body: Vector3<f64>,
    ) -> State<SVector<f64, 9>> {
        let rate = attitude.matrix() * angular_velocity_in_body.cross_matrix();
        let momenta = rate * Matrix3::from_diagonal(&self.masses().into());
        State::new(rows(attitude.matrix()), rows(&momenta))
    }

    /// The attitude `Q` of a state, as an orthogonal matrix to the rounding of the state.
    pub fn attitude(&self, state: &State<SVector<f64, 9>>) -> Rotation3<f64> {
        Rotation3::from_matrix_unchecked(matrix(&state.q))
    }

    /// The angular momentum by its components along the axes of space, `L = Σ_a c_a × p_a` for the columns
    /// `c_a` of `q` and `p_a` of `p`.
    pub fn angular_momentum_in_space(&self, state: &State<SVector<f64, 9>>) -> Vector3<f64> {
        let (q, p) = (matrix(&state.q), matrix(&state.p));
        (0..3).map(|a| q.column(a).cross(&p.column(a))).sum()
    }

    /// The angular momentum by its components along the axes of the body, `Qᵀ L`.
    pub fn angular_momentum_in_body(&self, state: &State<SVector<f64, 9>>) -> Vector3<f64> {
        matrix(&state.q).tr_mul(&self.angular_momentum_in_space(state))
    }

    /// The angular velocity by its components along the axes of the body, `ω_a = (Qᵀ L)_a / I_a`, in radians
    /// per time, for a kinetic energy `Σ p_ia²/(2 d_a)`.
    pub fn angular_velocity_in_body(&self, state: &State<SVector<f64, 9>>) -> Vector3<f64> {
        self.angular_momentum_in_body(state).component_div(&self.inertia)
    }

    /// The angular velocity by its components along the axes of space.
    pub fn angular_velocity_in_space(&self, state: &State<SVector<f64, 9>>) -> Vector3<f64> {
        matrix(&state.q) * self.angular_velocity_in_body(state)
    }

    /// The state of body `index`, from 0, of `q: [Rotation; N]`; `None` if there are fewer.
    pub fn of_several<V: Vector>(state: &State<V>, index: usize) -> Option<State<SVector<f64, 9>>> {
        let part = |all: &V| Some(SVector::from_column_slice(all.components().chunks_exact(9).nth(index)?));
        Some(State { q: part(&state.q)?, p: part(&state.p)?, t: state.t })
    }
}

fn matrix(components: &SVector<f64, 9>) -> Matrix3<f64> {
    Matrix3::from_row_slice(components.as_slice())
}

fn rows(matrix: &Matrix3<f64>) -> SVector<f64, 9> {
    SVector::from_column_slice(matrix.transpose().as_slice())
}

/// Principal moments of inertia that no rigid body with three masses has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaError {
    axis: usize,
    fault: InertiaFault,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum InertiaFault {
    Moment(f64),
    TooLarge(f64),
    Flat,
}

impl fmt::Display for InertiaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = self.axis + 1;
        match self.fault {
            InertiaFault::Moment(moment) => {
                write!(f, "the moment of inertia I_{axis} is {moment}: moments are positive and finite")
            }
            InertiaFault::TooLarge(moment) => write!(
                f,
                "no body has these moments of inertia: I_{axis} = {moment} exceeds the sum of the other two; \
                 check their order and their units"
            ),
            InertiaFault::Flat => write!(
                f,
                "the body is flat: I_{axis} is the sum of the other two, and there is no mass along axis {axis}, \
                 by which its momenta are divided; give the body a thickness, or two points of its plane as \
                 coordinates with their distances as constraints"
            ),
        }
    }
}

impl std::error::Error for InertiaError {}
