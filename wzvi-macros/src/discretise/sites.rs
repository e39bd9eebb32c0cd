//! Sites that are not coupled: a small system, placed once at each of them.
//!
//! If every element stands in one loop over all sites, or, for a noise, over some of them, such as the members of a family
//! of which there is one for each site, and reads the state at the site of that loop only, then
//!
//! ```text
//! H_m = Σ_s H_(m,s)(q_s, p_s),   L_d = Σ_s L_(d,s),
//! ```
//!
//! and the discrete Euler-Lagrange equations fall apart into those of the sites. What the elements read of fields at a
//! site is a parameter of the small system; where a noise does not act its increment is zero.

use std::collections::HashMap;

use proc_macro2::TokenStream;

use crate::diagnostics::Located;
use crate::model::index::{Atom, Index, Loop};
use crate::model::{Element, Half, Model, Parameter, Phase, Slot, System, Term};
use crate::symbolic::{Expr, Graph, Symbol};

/// The small system at the site of a loop variable.
pub(crate) struct Site {
    /// The loop variable that counts the sites.
    pub(crate) variable: u32,
    phase: Phase,
    drift: Expr,
    /// `f · δq` of the force.
    force: Option<Expr>,
    /// Noises that act at a site, whether they are forces, and what drives them.
    noise: Vec<(Expr, bool, Increment)>,
    /// What is read of fields at the site.
    pub(crate) entries: Vec<Entry>,
}

/// The sites from the first to before the second, if these are not all.
pub(crate) type Range = Option<(Index, Index)>;

/// What drives a noise at a site.
#[derive(Clone, PartialEq)]
pub(crate) struct Increment {
    pub(crate) number: Index,
    pub(crate) acts: Range,
}

/// What is read of a field at a site.
pub(crate) struct Entry {
    symbol: Symbol,
    pub(crate) slot: Slot,
    /// Where it is there.
    pub(crate) exists: Range,
}

impl Site {
    /// The small system of which `system` is made; `None` if its sites are coupled, or not all alike.
    pub(crate) fn of(system: &mut System) -> Option<Self> {
        let noise = || system.noise.iter().map(|noise| &noise.term);
        let elements = || {
            let terms = [&system.drift].into_iter().chain(&system.force).chain(noise());
            terms.flat_map(|term| &term.elements)
        };
        let loops = elements().flat_map(|element| &element.loops).map(|known| known.variable);
        let variable = loops.max()?.checked_add(1)?;
        let components = usize::try_from(system.components).ok()?;
        let [q, p] = &system.names;
        let name = |name: &str, c: usize| match components {
            1 => format!("{name}[k]"),
            _ => format!("{name}[k][{c}]"),
        };
        let names = |of: &str| (0..components).map(|c| name(of, c)).collect::<Vec<_>>();
        let (displaced, q, p) = (names(&format!("δ{q}")), names(q), names(p));
        let graph = &mut system.graph;
        let mut symbols = |names: Vec<String>| names.into_iter().map(|name| graph.new_symbol(name)).collect();
        let phase = Phase { q: symbols(q), p: symbols(p), displacements: symbols(displaced), t: system.t };
        let mut places = Places {
            size: system.size.clone(),
            components: system.components,
            variable,
            phase: &phase,
            entries: Vec::new(),
        };
        let (drift, Increment { acts: None, .. }) =
            places.at_site(&mut system.graph, &system.drift, &Index::default())?
        else {
            return None;
        };
        let mut force = None;
        if let Some(declared) = &system.force {
            let (value, Increment { acts: None, .. }) =
                places.at_site(&mut system.graph, declared, &Index::default())?
            else {
                return None;
            };
            force = Some(value);
        }
        let mut noise = Vec::new();
        for (declared, offset) in system.noise.iter().zip(system.noise_offsets()) {
            let number = match &declared.family {
                Some(family) => offset.add(&Index::atom(Atom::Loop(family.variable)))?,
                None => offset,
            };
            let (value, increment) = places.at_site(&mut system.graph, &declared.term, &number)?;
            if !system.graph.is_zero(value) {
                noise.push((value, declared.is_force, increment));
            }
        }
        let entries = places.entries;
        Some(Self { variable, phase, drift, force, noise, entries })
    }

    /// What drives the noises at the site.
    pub(crate) fn increments(&self) -> impl Iterator<Item = &Increment> {
        self.noise.iter().map(|(.., increment)| increment)
    }

    /// Calls `f` with the small system. Its parameters are those of the system, then the entries of fields at the site.
    /// `read` is how an entry is read.
    pub(crate) fn with_model<T>(
        &self,
        system: &mut System,
        read: impl Fn(&System, &Self, &Entry) -> TokenStream,
        f: impl FnOnce(&mut Model) -> T,
    ) -> T {
        let located = |value: Expr, term: &Term| Located { value, extent: term.extent };
        let entries = self
            .entries
            .iter()
            .map(|entry| Parameter { symbol: entry.symbol, tokens: read(system, self, entry) });
        let mut parameters: Vec<_> = entries.collect();
        let of_system = system
            .parameters
            .iter()
            .map(|known| Parameter { symbol: known.symbol, tokens: known.tokens.clone() });
        parameters.splice(0..0, of_system);
        let phase = self.phase.clone();
        let mut graph = std::mem::take(&mut system.graph);
        let mut components = |work: Expr| phase.components(&mut graph, work);
        let force = self.force.map(&mut components);
        let noise = self.noise.iter();
        let (forces, noise): (Vec<_>, Vec<_>) = noise.partition(|(_, is_force, _)| *is_force);
        let noise_forces = forces.iter().map(|(value, ..)| components(*value)).collect();
        let mut model = Model {
            graph,
            phase,
            labels: system.labels.clone(),
            parameters,
            drift: located(self.drift, &system.drift),
            parts: Vec::new(),
            noise: noise.iter().map(|(value, ..)| located(*value, &system.drift)).collect(),
            force,
            noise_forces,
            bath: None,
            conformal: system.conformal,
            invariants: Vec::new(),
            invariant_names: Vec::new(),
            embeddings: Vec::new(),
            item: system.item.clone(),
            crate_path: system.crate_path.clone(),
            type_checks: TokenStream::new(),
        };
        let made = f(&mut model);
        system.graph = model.graph;
        made
    }
}

struct Places<'p> {
    size: Index,
    components: i128,
    variable: u32,
    phase: &'p Phase,
    entries: Vec<Entry>,
}

impl Places<'_> {
    /// The part of a Hamiltonian at the site, and its increment, which has this `number` in the loop of the Hamiltonian.
    fn at_site(&mut self, graph: &mut Graph, term: &Term, number: &Index) -> Option<(Expr, Increment)> {
        let (mut values, mut increments) = (Vec::new(), Vec::new());
        for element in term.elements.iter().filter(|element| !element.state().is_empty()) {
            let (known, shift) = self.site_of(element)?;
            let by = Index::atom(Atom::Loop(self.variable)).shifted(-shift)?;
            let (first, end) = (known.start.shifted(shift)?, known.end.shifted(shift)?);
            let is_whole = first == Index::default() && end == self.size;
            let acts = (!is_whole).then_some((first, end));
            let moved = |index: &Index| index.with(known.variable, &by);
            let mut images = HashMap::new();
            for local in &element.locals {
                let symbol = match &local.slot {
                    Slot::State(Half::Coordinates, index) => {
                        *self.phase.q.get(self.component(&moved(index)?)?)?
                    }
                    Slot::State(Half::Momenta, index) => {
                        *self.phase.p.get(self.component(&moved(index)?)?)?
                    }
                    Slot::State(Half::Displacements, index) => {
                        *self.phase.displacements.get(self.component(&moved(index)?)?)?
                    }
                    Slot::Number(index) => {
                        self.entry(graph, local.symbol, Slot::Number(moved(index)?), &acts)
                    }
                    Slot::Entry(table, indices) => {
                        let indices = indices.iter().map(moved).collect::<Option<_>>()?;
                        self.entry(graph, local.symbol, Slot::Entry(*table, indices), &acts)
                    }
                };
                images.insert(local.symbol, graph.symbol(symbol));
            }
            values.push(*graph.substitute(&[element.value], &images).first()?);
            increments.push(Increment { number: moved(number)?, acts });
        }
        let nothing = Increment { number: Index::default(), acts: None };
        let increment = increments.first().cloned().unwrap_or(nothing);
        let is_one = increments.iter().all(|other| *other == increment);
        is_one.then(|| (graph.sum(&values), increment))
    }

    /// The loop of `element`, and by how much the site that it reads is beyond the variable.
    fn site_of<'e>(&self, element: &'e Element) -> Option<(&'e Loop, i128)> {
        let [known] = element.loops.as_slice() else { return None };
        let own = Index::atom(Atom::Loop(known.variable));
        let sites = element.state().into_iter().map(|index| {
            let rest = index.plus(&own, -self.components)?.as_integer()?;
            Some(rest.div_euclid(self.components))
        });
        let sites: Vec<i128> = sites.collect::<Option<_>>()?;
        let shift = *sites.first()?;
        sites.iter().all(|site| *site == shift).then_some((known, shift))
    }

    /// The component of the site that `index` is.
    fn component(&self, index: &Index) -> Option<usize> {
        let site = Index::atom(Atom::Loop(self.variable));
        let component = index.plus(&site, -self.components)?.as_integer()?;
        usize::try_from(component).ok()
    }

    fn entry(&mut self, graph: &mut Graph, like: Symbol, slot: Slot, exists: &Range) -> Symbol {
        let is_known =
            |known: &&Entry| known.slot == slot && (known.exists.is_none() || known.exists == *exists);
        if let Some(known) = self.entries.iter().find(is_known) {
            return known.symbol;
        }
        let name = graph.symbol_name(like).to_owned();
        let symbol = graph.new_symbol(name);
        self.entries.push(Entry { symbol, slot, exists: exists.clone() });
        symbol
    }
}
