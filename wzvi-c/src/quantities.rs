//! Starts, observables and sections of a run, from settings.

use wzvi::error::UnknownName;
use wzvi::section::Direction;
use wzvi::state::{State, Vector};
use wzvi::system::{Hamiltonian, Quantity};
use wzvi::variables::Variables;

use crate::error::TaskError;
use crate::settings::{RealArray, Settings};

/// The starts of the paths of a run, in order: one, or one for each path.
///
/// # Errors
/// If coordinates or momenta are missing, or of another shape.
pub fn starts<H: Hamiltonian>(settings: &Settings, system: &H) -> Result<Vec<State<H::Vector>>, TaskError> {
    let missing = |name: &str| TaskError::setting(format!("the start is missing: set `{name}`"));
    let q = settings.reals("q")?.ok_or_else(|| missing("q"))?;
    let p = settings.reals("p")?.ok_or_else(|| missing("p"))?;
    let t = settings.real("t")?.unwrap_or(0.0);
    let (q, p) = (rows("q", &q, system.degrees())?, rows("p", &p, system.degrees())?);
    if q.len() != p.len() {
        return Err(TaskError::setting(format!(
            "`q` has {} starts and `p` has {}: give as many of both",
            q.len(),
            p.len()
        )));
    }
    let pairs = q.into_iter().zip(p);
    pairs
        .enumerate()
        .map(|(path, (q, p))| Ok(State { q: vector("q", path, &q)?, p: vector("p", path, &p)?, t }))
        .collect()
}

/// The coordinates of each start. All numbers are those of one start if there are as many as degrees of
/// freedom; else each start has a row along the first axis.
fn rows(name: &str, given: &RealArray, degrees: usize) -> Result<Vec<Vec<f64>>, TaskError> {
    if degrees > 0 && given.values.len() == degrees {
        return Ok(vec![given.values.clone()]);
    }
    let rows = given.rows();
    let length = rows.first().map_or(0, Vec::len);
    if length == 0 || degrees > 0 && length != degrees {
        let expected =
            if degrees == 0 { "at least one number".to_owned() } else { format!("{degrees} numbers") };
        return Err(TaskError::setting(format!(
            "`{name}` has the shape {:?}: a start has {expected}, one for each degree of freedom, and several starts have a row each",
            given.shape
        )));
    }
    Ok(rows)
}

fn vector<V: Vector>(name: &str, path: usize, numbers: &[f64]) -> Result<V, TaskError> {
    let mut vector = V::zeros(numbers.len());
    let room = vector.components_mut();
    if room.len() != numbers.len() {
        return Err(TaskError::setting(format!(
            "start {path} has {} numbers in `{name}`: the system has {} degrees of freedom",
            numbers.len(),
            room.len()
        )));
    }
    room.copy_from_slice(numbers);
    Ok(vector)
}

/// The value of a quantity, as a function of the state.
pub fn value_of<H: Hamiltonian + Sync>(
    system: &H,
    quantity: Quantity,
) -> impl Fn(&State<H::Vector>) -> f64 + Send + Sync + use<'_, H> {
    move |state| quantity.value(system, state)
}

/// The names of the time, the coordinates and the momenta, as the closure of the drift has them.
pub fn variable_names<H: Hamiltonian>(system: &H, degrees: usize) -> Vec<String> {
    let Variables { q, p, t, .. } = system.variables();
    let coordinates = (0..degrees).map(|index| q.name(index));
    [t.to_owned()].into_iter().chain(coordinates).chain((0..degrees).map(|index| p.name(index))).collect()
}

/// A section: the quantity that is zero on it, and the direction of the crossings, if only one counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Section {
    /// The quantity.
    pub quantity: Quantity,
    /// The direction.
    pub direction: Option<Direction>,
}

/// A section by its name: `+q` for crossings with rising `q`, `-q` for falling ones, `q` for both.
///
/// # Errors
/// [`UnknownName`] with the names of the quantities.
pub fn section<H: Hamiltonian>(system: &H, degrees: usize, name: &str) -> Result<Section, UnknownName> {
    let (direction, name) = match (name.strip_prefix('+'), name.strip_prefix('-')) {
        (Some(rest), _) => (Some(Direction::Rising), rest),
        (_, Some(rest)) => (Some(Direction::Falling), rest),
        _ => (None, name),
    };
    Ok(Section { quantity: Quantity::named(system, degrees, name.trim())?, direction })
}

/// A direction as a number: 1 for rising, -1 for falling.
pub fn sign(direction: Direction) -> f64 {
    match direction {
        Direction::Rising => 1.0,
        Direction::Falling => -1.0,
    }
}
