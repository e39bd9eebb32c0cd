//! Checks by intervals, before any loop runs, that everything that a system reads exists.

use std::ops::Range;

use super::{Atom, Entries, Index, IntegerRange, Loop, Name, Nest, Places, Position, Slot};
use crate::error::{IndexError, IndexLimit, StepFailure};
use crate::scheme::elements::Elements;

/// An index that is out of range, or may be.
struct Fault {
    error: IndexError,
    /// Whether a state with more degrees of freedom would help.
    needs_degrees: bool,
}

/// The intervals of nested loops, from the innermost fixed one outwards.
#[derive(Clone, Copy)]
struct Bounds<'b> {
    span: IntegerRange,
    depth: usize,
    outer: Option<&'b Self>,
}

/// The check of one system with one state size; of any system, so that it is compiled once.
struct Survey<'s> {
    places: &'static Places,
    entries: Lookup<'s>,
    degrees: usize,
}

/// The method [`Elements::entries`] of a system.
type Lookup<'s> = &'s dyn Fn(usize, &[usize], Range<usize>) -> Entries;

/// Checks that everything that the elements of `system` read exists for a state with `degrees`.
///
/// # Errors
/// [`StepFailure::Dimension`] where loops go beyond the end of the state, [`StepFailure::Index`] where an
/// integer of the system does.
pub(in crate::scheme::elements) fn check<H: Elements>(system: &H, degrees: usize) -> Result<(), StepFailure> {
    let components = H::PLACES.components;
    if !degrees.is_multiple_of(components) {
        let expected = (degrees / components + 1).saturating_mul(components);
        return Err(StepFailure::Dimension { expected, got: degrees });
    }
    // The whole check is compiled only for systems with loops or lists.
    if const { H::PLACES.nests.is_empty() } { Ok(()) } else { of(system, degrees, |survey| survey.check()) }
}

/// The index that is out of range for a state with `degrees`, if one is.
pub(in crate::scheme::elements) fn index_error<H: Elements>(
    system: &H,
    degrees: usize,
) -> Option<IndexError> {
    of(system, degrees, |survey| survey.fault().map(|fault| fault.error))
}

fn of<H: Elements, R>(system: &H, degrees: usize, ask: fn(Survey<'_>) -> R) -> R {
    let entries = |table, outer: &[usize], range| system.entries(table, outer, range);
    ask(Survey { places: &H::PLACES, entries: &entries, degrees })
}

impl Survey<'_> {
    fn check(&self) -> Result<(), StepFailure> {
        match self.fault() {
            None => Ok(()),
            Some(Fault { needs_degrees: true, .. }) => Err(match self.required() {
                Ok(expected) => StepFailure::Dimension { expected, got: self.degrees },
                Err(Fault { error, .. }) => StepFailure::Index(error),
            }),
            Some(Fault { error, .. }) => Err(StepFailure::Index(error)),
        }
    }

    fn fault(&self) -> Option<Fault> {
        self.places.nests.iter().find_map(|nest| self.prove(nest, None).err())
    }

    /// Proves that all reads in the loops of `nest` inside `fixed` are in range.
    fn prove(&self, nest: &'static Nest, fixed: Option<&Bounds<'_>>) -> Result<(), Fault> {
        let Err(fault) = self.slots(nest, fixed) else { return Ok(()) };
        if let Some(last) = fixed.filter(|last| !last.span.is_single()) {
            return last
                .span
                .halves()
                .into_iter()
                .try_for_each(|span| self.prove(nest, Some(&Bounds { span, ..*last })));
        }
        match self.next_loop(nest, fixed)? {
            Next::Inside(inner) => self.prove(nest, Some(&inner)),
            Next::Nothing => Ok(()),
            // A single placement, out of range.
            Next::Body => Err(fault),
        }
    }

    /// The next loop inwards, with all values that its variable takes.
    fn next_loop<'b>(&self, nest: &'static Nest, fixed: Option<&'b Bounds<'b>>) -> Result<Next<'b>, Fault> {
        let depth = fixed.map_or(0, |last| last.depth + 1);
        let Some(Loop(start, end)) = nest.loops.get(depth) else { return Ok(Next::Body) };
        let (start, end) = (self.span(start, fixed)?, self.span(end, fixed)?);
        let span = IntegerRange { low: start.low, high: end.high - 1 };
        Ok(if span.low > span.high {
            Next::Nothing
        } else {
            Next::Inside(Bounds { span, depth, outer: fixed })
        })
    }

    fn slots(&self, nest: &'static Nest, fixed: Option<&Bounds<'_>>) -> Result<(), Fault> {
        match self.next_loop(nest, fixed)? {
            Next::Inside(inner) => self.slots(nest, Some(&inner)),
            Next::Nothing => Ok(()),
            Next::Body => nest.slots.iter().try_for_each(|slot| match slot {
                Slot::State(index) | Slot::Natural(index) => {
                    let IntegerRange { low, high } = self.span(index, fixed)?;
                    let is_natural = matches!(slot, Slot::Natural(_));
                    let outlier = if low < 0 && !is_natural { low } else { high };
                    let is_inside = outlier >= 0 && high < self.degrees as i128;
                    if is_inside { Ok(()) } else { Err(self.outside(index, outlier, fixed)) }
                }
                Slot::Entry(table, positions) => self.given(*table, positions, fixed).map(drop),
                Slot::Number(index) => self.span(index, fixed).map(drop),
                Slot::Unsigned(index) => match self.span(index, fixed)?.low {
                    0.. => Ok(()),
                    low => {
                        let error = IndexError::new(&index.name, low, IndexLimit::Natural);
                        Err(Fault { error, needs_degrees: false })
                    }
                },
            }),
        }
    }

    /// The reason why `index`, with the possible value `value`, is not a place in the state: an integer of
    /// the system in it that is not a point, or the index as a whole.
    fn outside(&self, index: &'static Index, value: i128, at: Option<&Bounds<'_>>) -> Fault {
        let components = self.places.components;
        let points = self.degrees / components;
        for (atom, coefficient) in index.terms {
            let Atom::Given(table, positions) = atom else { continue };
            let Ok(Some(IntegerRange { low, high })) = self.given(*table, positions, at) else { continue };
            if *coefficient == components as i128
                && !positions.is_empty()
                && !(low >= 0 && high < points as i128)
            {
                let mut error =
                    self.error(*table, if low < 0 { low } else { high }, IndexLimit::Points(points));
                for position in *positions {
                    error.push(self.span(&position.index, at).map_or(0, |span| span.low));
                }
                return Fault { error, needs_degrees: false };
            }
        }
        let error = IndexError::new(&index.name, value, IndexLimit::Points(self.degrees));
        Fault { error, needs_degrees: value >= 0 && !index.reads_lists() }
    }

    fn error(&self, table: usize, value: i128, limit: IndexLimit) -> IndexError {
        let name = self.places.tables.get(table).unwrap_or(&Name { name: "", suffix: "" });
        IndexError::new(name, value, limit)
    }

    /// The interval of an index. All its values and partial sums must be in the range of `isize`.
    fn span(&self, index: &'static Index, at: Option<&Bounds<'_>>) -> Result<IntegerRange, Fault> {
        let mut sum = IntegerRange::at(0);
        let parts =
            index.terms.iter().map(|(atom, coefficient)| Ok((self.atom(atom, index, at)?, *coefficient)));
        for part in parts.chain([Ok((IntegerRange::at(index.constant), 1))]) {
            let (part, coefficient) = part?;
            let part = integers(part.corners(IntegerRange::at(coefficient), i128::saturating_mul), index)?;
            sum = IntegerRange {
                low: sum.low.saturating_add(part.low),
                high: sum.high.saturating_add(part.high),
            };
            sum = integers(sum, index)?;
        }
        Ok(sum)
    }

    fn atom(
        &self,
        atom: &'static Atom,
        whole: &'static Index,
        at: Option<&Bounds<'_>>,
    ) -> Result<IntegerRange, Fault> {
        let both = |[a, b]: &'static [Index; 2]| Ok((self.span(a, at)?, self.span(b, at)?));
        let divisor = |operands: &'static [Index; 2]| {
            let (a, b) = both(operands)?;
            let is_zero = b.low <= 0 && b.high >= 0;
            let error = || IndexError::new(&operands[1].name, 0, IndexLimit::Divisor);
            if is_zero { Err(Fault { error: error(), needs_degrees: false }) } else { Ok((a, b)) }
        };
        let value = match atom {
            Atom::Loop(depth) => Bounds::span_at(at, *depth),
            Atom::Size => IntegerRange::at((self.degrees / self.places.components) as i128),
            Atom::Given(table, positions) => {
                let span = self.given(*table, positions, at)?.unwrap_or(IntegerRange::at(0));
                let limit = |value: i128| Fault {
                    error: self.error(*table, value, IndexLimit::Integers),
                    needs_degrees: false,
                };
                return match outlier(span) {
                    Some(value) => Err(limit(value)),
                    None => Ok(span),
                };
            }
            Atom::Product(operands) => {
                let (a, b) = both(operands)?;
                a.corners(b, i128::saturating_mul)
            }
            Atom::Quotient(operands) => {
                let (a, b) = divisor(operands)?;
                a.corners(b, |a, b| a / b)
            }
            Atom::Remainder(operands) => {
                let (a, b) = divisor(operands)?;
                a.remainder(b)
            }
            Atom::Minimum(operands) => {
                let (a, b) = both(operands)?;
                IntegerRange { low: a.low.min(b.low), high: a.high.min(b.high) }
            }
            Atom::Maximum(operands) => {
                let (a, b) = both(operands)?;
                IntegerRange { low: a.low.max(b.low), high: a.high.max(b.high) }
            }
        };
        integers(value, whole)
    }

    /// The interval of the integers at some positions of a list; `None` for real numbers.
    fn given(
        &self,
        table: usize,
        positions: &'static [Position],
        at: Option<&Bounds<'_>>,
    ) -> Result<Option<IntegerRange>, Fault> {
        let (mut few, mut many) = ([0; 8], Vec::new());
        let outer = if positions.len() <= few.len() {
            &mut few[..]
        } else {
            many.resize(positions.len(), 0);
            &mut many[..]
        };
        self.entries(table, positions, outer, 0, at)
    }

    /// The interval of the integers in the lists at `outer[..level]`.
    fn entries(
        &self,
        table: usize,
        positions: &'static [Position],
        outer: &mut [usize],
        level: usize,
        at: Option<&Bounds<'_>>,
    ) -> Result<Option<IntegerRange>, Fault> {
        let Some(Position { index, is_inside }) = positions.get(level) else {
            return Ok((self.entries)(table, &[], 0..0).span);
        };
        let IntegerRange { low, high } = self.span(index, at)?;
        let is_last = level + 1 == positions.len();
        let range = usize::try_from(low).unwrap_or(0)..usize::try_from(high + 1).unwrap_or(0);
        let wanted = if is_last { range.clone() } else { 0..0 };
        let found = (self.entries)(table, &outer[..level], wanted);
        if low < 0 || (!is_inside && high >= found.length as i128) {
            let value = if low < 0 { low } else { high };
            let mut error = self.error(table, value, IndexLimit::Entries(found.length));
            outer[..level].iter().for_each(|&at| error.push(at as i128));
            return Err(Fault { error, needs_degrees: false });
        }
        if is_last {
            return Ok(found.span);
        }
        let mut all: Option<IntegerRange> = None;
        for entry in range.start..range.end.min(found.length) {
            outer[level] = entry;
            let Some(span) = self.entries(table, positions, outer, level + 1, at)? else { continue };
            all = Some(all.map_or(span, |all| all.union(span)));
        }
        Ok(all)
    }

    /// The degrees of freedom that the loops require.
    #[cold]
    fn required(&self) -> Result<usize, Fault> {
        let mut most = -1;
        for nest in self.places.nests {
            for slot in nest.slots {
                if let Slot::State(index) | Slot::Natural(index) = slot
                    && !index.reads_lists()
                {
                    self.largest(nest, index, None, &mut most)?;
                }
            }
        }
        let degrees = usize::try_from(most.saturating_add(1)).unwrap_or(usize::MAX);
        Ok(degrees.checked_next_multiple_of(self.places.components).unwrap_or(degrees))
    }

    /// Raises `most` to the largest value of `index`, by branch and bound over halved intervals.
    fn largest(
        &self,
        nest: &'static Nest,
        index: &'static Index,
        fixed: Option<&Bounds<'_>>,
        most: &mut i128,
    ) -> Result<(), Fault> {
        let bound = self.bound(nest, index, fixed);
        if bound.as_ref().is_ok_and(|bound| *bound <= *most) {
            return Ok(());
        }
        if let Some(last) = fixed.filter(|last| !last.span.is_single()) {
            let halves = last.span.halves().map(|span| Bounds { span, ..*last });
            let bounds = halves.map(|half| self.bound(nest, index, Some(&half)).unwrap_or(i128::MAX));
            let [first, second] = if bounds[0] > bounds[1] { [0, 1] } else { [1, 0] };
            self.largest(nest, index, Some(&halves[first]), most)?;
            return self.largest(nest, index, Some(&halves[second]), most);
        }
        match self.next_loop(nest, fixed)? {
            Next::Inside(inner) => self.largest(nest, index, Some(&inner), most)?,
            Next::Body => *most = bound?,
            Next::Nothing => {}
        }
        Ok(())
    }

    /// An upper bound of `index` inside `fixed`, at least -1.
    fn bound(
        &self,
        nest: &'static Nest,
        index: &'static Index,
        fixed: Option<&Bounds<'_>>,
    ) -> Result<i128, Fault> {
        match self.next_loop(nest, fixed)? {
            Next::Inside(inner) => self.bound(nest, index, Some(&inner)),
            Next::Body => Ok(self.span(index, fixed)?.high.max(-1)),
            Next::Nothing => Ok(-1),
        }
    }
}

/// The next level inside some loops.
enum Next<'b> {
    Inside(Bounds<'b>),
    /// No loop.
    Body,
    /// An empty loop.
    Nothing,
}

impl Bounds<'_> {
    fn span_at(inner: Option<&Self>, depth: usize) -> IntegerRange {
        let mut known = inner;
        while let Some(Bounds { span, depth: own, outer }) = known {
            if *own == depth {
                return *span;
            }
            known = *outer;
        }
        IntegerRange::at(0)
    }
}

impl Index {
    /// Whether the index reads an entry of a list.
    fn reads_lists(&self) -> bool {
        self.terms.iter().any(|(atom, _)| match atom {
            Atom::Loop(_) | Atom::Size => false,
            Atom::Given(_, positions) => !positions.is_empty(),
            Atom::Product(both)
            | Atom::Quotient(both)
            | Atom::Remainder(both)
            | Atom::Minimum(both)
            | Atom::Maximum(both) => both.iter().any(Self::reads_lists),
        })
    }
}

/// An end of `span` outside the range of `isize`, if there is one.
fn outlier(span: IntegerRange) -> Option<i128> {
    [span.high, span.low].into_iter().find(|&value| isize::try_from(value).is_err())
}

fn integers(span: IntegerRange, index: &'static Index) -> Result<IntegerRange, Fault> {
    match outlier(span) {
        None => Ok(span),
        Some(value) => {
            let error = IndexError::new(&index.name, value, IndexLimit::Integers);
            Err(Fault { error, needs_degrees: false })
        }
    }
}
