//! Systems whose sites are not coupled: the step of a small system, taken at each of them.

use std::fmt::Debug;

use super::Elements;
use crate::carry::{Carry, Plain};
use crate::error::{ConfigError, StepFailure};
use crate::lanes::Lanes;
use crate::memory::StepMemory;
use crate::numbers::{Numbers, Tape};
use crate::scalar::Scalar;
use crate::solve::Effort;
use crate::system::Solution;

/// A system of elements whose sites have `D` degrees of freedom each, of which none reads another one's, with `K` noises at
/// each, as the embedding `E` discretises it.
pub trait Sites<E, const D: usize, const K: usize>: Elements {
    /// Whether what is prepared is the same for all sites.
    const IS_UNIFORM: bool;

    /// Whether the step of a site is arithmetic alone, and keeps nothing for the next: numbers beside each other then go
    /// bit for bit as each goes alone.
    const IS_EXACT_IN_LANES: bool;

    /// What depends on the system, the site and the step size only.
    type SitePrepared: Clone + Debug;

    /// What one step leaves for the starting value of the next.
    type SiteMemory<S: Scalar>: StepMemory;

    /// Computes what does not change from step to step at one of `sites` sites.
    ///
    /// # Errors
    /// As [`Discretized::prepare`](crate::system::Discretized::prepare).
    fn prepare_site(&self, h: f64, site: usize, sites: usize) -> Result<Self::SitePrepared, ConfigError>;

    /// The numbers of the increments that act at one of `sites` sites; none for a noise that does not act there.
    fn increments(&self, site: usize, sites: usize) -> [Option<usize>; K];

    /// One step of one site.
    ///
    /// # Errors
    /// As [`Discretized::advance_carrying`](crate::system::Discretized::advance_carrying); `memory` is then as it was.
    #[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
    fn solve_site<S: Scalar, C: Carry<S>, const CAREFUL: bool>(
        prepared: &Self::SitePrepared,
        t: f64,
        h: f64,
        q: [S; D],
        p: [S; D],
        dw: [S; K],
        memory: &mut Self::SiteMemory<S>,
        carry: &C,
    ) -> Result<Solution<S, D>, StepFailure>;
}

/// What is prepared for each site, or once for all of them; nothing where only the state knows how many there are.
#[derive(Clone, Debug)]
pub struct Prepared<P>(Vec<P>);

/// What a stepper allocates, once.
#[derive(Clone, Debug)]
pub struct Memory<S, M, P> {
    /// The new nodes, and what their rounding took: four lists in one.
    next: Vec<S>,
    /// What the steps before left at each site, and the same before this step.
    sites: Vec<M>,
    saved: Vec<M>,
    /// What is prepared for each site, where the making of the stepper could not, and for which step size and how many
    /// sites.
    prepared: Vec<P>,
    prepared_for: Option<(f64, usize)>,
}

impl<S, M, P> Default for Memory<S, M, P> {
    fn default() -> Self {
        Self {
            next: Vec::new(),
            sites: Vec::new(),
            saved: Vec::new(),
            prepared: Vec::new(),
            prepared_for: None,
        }
    }
}

impl<S: Scalar, M: Numbers + Default, P> Numbers for Memory<S, M, P> {
    fn pass(&mut self, tape: &mut Tape) {
        let length = tape.length(if size_of::<M>() == 0 { 0 } else { self.sites.len() });
        if length != 0 {
            self.sites.resize_with(length, M::default);
            self.sites.iter_mut().for_each(|site| site.pass(tape));
        }
    }
}

/// Prepares every site that is known.
///
/// # Errors
/// [`ConfigError`] of a site, or where an index is out of range.
pub fn prepare<H, E, const D: usize, const K: usize>(
    system: &H,
    h: f64,
) -> Result<Prepared<H::SitePrepared>, ConfigError>
where
    H: Sites<E, D, K>,
{
    super::prepare(system)?;
    let sites = system.degrees() / D;
    let prepared = if H::IS_UNIFORM { 1 } else { sites };
    (0..prepared).map(|site| system.prepare_site(h, site, sites)).collect::<Result<_, _>>().map(Prepared)
}

/// One step from `(q, p)` at `t` in place; on `Err` nothing but scratch is changed.
///
/// # Errors
/// [`StepFailure`] of the first site that has one, or where sizes do not fit.
///
/// Inlined, so that the step of a site is compiled for the vector instructions of whoever runs paths in lanes.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
#[inline(always)]
pub fn advance<H, E, S, C, const CAREFUL: bool, const D: usize, const K: usize>(
    system: &H,
    prepared: &Prepared<H::SitePrepared>,
    t: f64,
    h: f64,
    q: &mut [S],
    p: &mut [S],
    dw: &[S],
    memory: &mut Memory<S, H::SiteMemory<S>, H::SitePrepared>,
    carry: &mut C,
) -> Result<Effort, StepFailure>
where
    H: Sites<E, D, K>,
    S: Scalar,
    C: Carry<S>,
{
    if !super::is_sized(system, memory.next.len() / 4, q.len()) {
        super::check(system, q.len())?;
        memory.allocate(q.len(), q.len() / D);
    }
    let [q, p] = super::sized_mut(system, [q, p])?;
    let dw = super::increments(system, dw)?;
    if prepared.0.is_empty() && memory.prepared_for != Some((h, memory.sites.len())) {
        prepare_by_state::<H, E, _, _, D, K>(system, h, memory)?;
    }
    // Where increments decide, the steps before are a guide only to a solution that is followed along its step.
    let remembers = size_of::<H::SiteMemory<S>>() != 0 && (K == 0 || CAREFUL);
    if remembers {
        memory.saved.clone_from(&memory.sites);
    }
    let solved = solve::<H, E, S, C, CAREFUL, D, K>(system, prepared, t, h, q, p, dw, memory, carry);
    if solved.is_ok() {
        let [next_q, next_p, lost_q, lost_p] = quarters(&mut memory.next, q.len());
        q.copy_from_slice(next_q);
        p.copy_from_slice(next_p);
        if C::CARRIES {
            carry.keep(lost_q, lost_p);
        }
    } else if remembers {
        std::mem::swap(&mut memory.saved, &mut memory.sites);
    }
    // Lanes that one site stops are stopped at all of them, and none has moved.
    solved
        .map_err(|cause| if matches!(cause, StepFailure::Lanes(_)) { StepFailure::NonFinite } else { cause })
}

/// [`prepare`], where only the state knows how many sites there are.
#[cold]
#[inline(never)]
fn prepare_by_state<H, E, S, M, const D: usize, const K: usize>(
    system: &H,
    h: f64,
    memory: &mut Memory<S, M, H::SitePrepared>,
) -> Result<(), StepFailure>
where
    H: Sites<E, D, K>,
{
    let sites = memory.sites.len();
    let prepared = if H::IS_UNIFORM { sites.min(1) } else { sites };
    let fresh = (0..prepared).map(|site| system.prepare_site(h, site, sites)).collect::<Result<_, _>>();
    memory.prepared = fresh.map_err(|error| match error {
        ConfigError::Singular { pivot, scale, .. } => StepFailure::Singular { pivot, scale },
        _ => StepFailure::NonFinite,
    })?;
    memory.prepared_for = Some((h, sites));
    Ok(())
}

/// The lists of so many numbers that one of four times as many is.
#[inline(always)]
fn quarters<S>(list: &mut [S], length: usize) -> [&mut [S]; 4] {
    let (half, other) = list[..4 * length].split_at_mut(2 * length);
    let ((first, second), (third, fourth)) = (half.split_at_mut(length), other.split_at_mut(length));
    [first, second, third, fourth]
}

/// Sites that are solved beside each other: two registers of the oldest vector instructions.
const BESIDE: usize = 4;

/// Every site, into `memory.next`.
#[expect(clippy::too_many_arguments, reason = "as `Discretized::advance_carrying`")]
#[inline(always)]
fn solve<H, E, S, C, const CAREFUL: bool, const D: usize, const K: usize>(
    system: &H,
    prepared: &Prepared<H::SitePrepared>,
    t: f64,
    h: f64,
    q: &[S],
    p: &[S],
    dw: &[S],
    memory: &mut Memory<S, H::SiteMemory<S>, H::SitePrepared>,
    carry: &C,
) -> Result<Effort, StepFailure>
where
    H: Sites<E, D, K>,
    S: Scalar,
    C: Carry<S>,
{
    let Memory { next, sites: memories, prepared: own, .. } = memory;
    let count = q.len() / D;
    let prepared = if prepared.0.is_empty() { &own[..] } else { &prepared.0[..] };
    let [next_q, next_p, lost_q, lost_p] = quarters(next, q.len()).map(|list| list.as_chunks_mut::<D>().0);
    let (q, p) = (q.as_chunks::<D>().0, p.as_chunks::<D>().0);
    let (next_q, next_p, memories) = (&mut next_q[..count], &mut next_p[..count], &mut memories[..count]);
    let mut effort = Effort::fast(0);
    let mut site = 0;
    if size_of::<S>() == size_of::<f64>() && H::IS_EXACT_IN_LANES && H::IS_UNIFORM && !C::CARRIES {
        let Some(prepared) = prepared.first() else { return Err(StepFailure::NonFinite) };
        while site + BESIDE <= count {
            let beside = |list: &[[S; D]]| -> [Lanes<BESIDE>; D] {
                let mut lanes = [Lanes::from_f64(0.0); D];
                for (lane, own) in list.iter().enumerate() {
                    for (lanes, number) in lanes.iter_mut().zip(own) {
                        lanes.set(lane, number.lane(0));
                    }
                }
                lanes
            };
            let mut own_dw = [Lanes::from_f64(0.0); K];
            for lane in 0..BESIDE {
                let increments = increments_at::<H, E, S, D, K>(system, site + lane, count, dw)?;
                for k in 0..K {
                    own_dw[k].set(lane, increments[k].lane(0));
                }
            }
            let both = [&q[site..site + BESIDE], &p[site..site + BESIDE]].map(beside);
            let solved = H::solve_site::<Lanes<BESIDE>, Plain, CAREFUL>(
                prepared,
                t,
                h,
                both[0],
                both[1],
                own_dw,
                &mut Default::default(),
                &Plain,
            );
            // Which site it is, and why, is found out by each of them alone.
            let Ok(solved) = solved else { break };
            for lane in 0..BESIDE {
                for i in 0..D {
                    next_q[site + lane][i] = S::from_f64(solved.q[i].0[lane]);
                    next_p[site + lane][i] = S::from_f64(solved.p[i].0[lane]);
                }
            }
            effort = effort.beside(solved.effort);
            site += BESIDE;
        }
    }
    while site < count {
        let prepared = if H::IS_UNIFORM { prepared.first() } else { prepared.get(site) };
        let Some(prepared) = prepared else { return Err(StepFailure::NonFinite) };
        let own_dw = increments_at::<H, E, S, D, K>(system, site, count, dw)?;
        let (own_carry, memory) = (carry.part::<D>(site * D), &mut memories[site]);
        let solved = H::solve_site::<S, C::Part<D>, CAREFUL>(
            prepared, t, h, q[site], p[site], own_dw, memory, &own_carry,
        )?;
        effort = effort.beside(solved.effort);
        for i in 0..D {
            (next_q[site][i], next_p[site][i]) = (solved.q[i].0, solved.p[i].0);
            if C::CARRIES {
                (lost_q[site][i], lost_p[site][i]) = (solved.q[i].1, solved.p[i].1);
            }
        }
        site += 1;
    }
    Ok(effort)
}

/// The increments that act at a site; zero for a noise that does not act there.
#[inline(always)]
fn increments_at<H, E, S, const D: usize, const K: usize>(
    system: &H,
    site: usize,
    sites: usize,
    dw: &[S],
) -> Result<[S; K], StepFailure>
where
    H: Sites<E, D, K>,
    S: Scalar,
{
    let numbers = system.increments(site, sites);
    let mut own = [S::from_f64(0.0); K];
    for k in 0..K {
        if let Some(number) = numbers[k] {
            own[k] = match dw.get(number) {
                Some(&dw) => dw,
                None => return Err(StepFailure::Increments { expected: number + 1, got: dw.len() }),
            };
        }
    }
    Ok(own)
}

impl<S: Scalar, M: Clone + Default, P> Memory<S, M, P> {
    /// The memory of a stepper: allocated at once if the system knows its size, else by the first step.
    pub fn new<H: Elements>(system: &H, components: usize) -> Self {
        let mut memory = Self::default();
        let degrees = system.degrees();
        if degrees != 0 {
            memory.allocate(degrees, degrees / components);
        }
        memory
    }

    fn allocate(&mut self, degrees: usize, sites: usize) {
        self.next.clear();
        self.next.resize(4 * degrees, S::from_f64(0.0));
        // A copy, or what was read from a checkpoint, comes with its past.
        if self.sites.len() != sites {
            self.sites = vec![M::default(); sites];
        }
        self.saved.clone_from(&self.sites);
    }
}

impl<S: Scalar, M: StepMemory, P: Clone + Debug> StepMemory for Memory<S, M, P> {
    fn hold(&mut self) {
        self.sites.iter_mut().for_each(M::hold);
    }

    fn forget(&mut self) {
        self.sites.fill(M::default());
    }

    fn adopt(&mut self, left: Self) {
        if self.next.is_empty() {
            *self = left;
        } else if self.sites.len() == left.sites.len() {
            self.sites = left.sites;
        } else {
            // A solution that was followed along its step leaves nothing.
            self.forget();
        }
    }
}

/// `P` of the step between two states where the change of the momenta is a multiple of it at each site.
pub fn step_momentum<V: crate::state::Vector, const D: usize>(before: &V, after: &V, factors: [f64; D]) -> V {
    let mut momentum = before.clone();
    let ends = before.components().iter().zip(after.components());
    for ((momentum, (start, end)), factor) in
        momentum.components_mut().iter_mut().zip(ends).zip(factors.iter().cycle())
    {
        *momentum = start + (end - start) * factor;
    }
    momentum
}
