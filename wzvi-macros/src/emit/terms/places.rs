//! The places read by elements that the compiler cannot prove to exist, as constants for the run time, which
//! checks them by interval arithmetic. Tests: `tests/loops/ranges.rs`.

use std::collections::BTreeMap;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::diagnostics::promised;
use crate::emit::count;
use crate::emit::plan::degrees;
use crate::model::{Atom, Bounds, Element, Index, IndexOperation, Loop, Slot, System, Table, Term};

/// The largest `isize` on the smallest machine, and the most numbers of a state there.
const LARGEST: i128 = i32::MAX as i128;
const MOST_DEGREES: i128 = LARGEST / size_of::<f64>() as i128;

/// `Elements::PLACES` and `Elements::entries`; empty if all places are proven, unless states of points may
/// have a component too many.
pub(super) fn emit(system: &System) -> TokenStream {
    let mut places = Places { system, arms: BTreeMap::new() };
    let mut nests = TokenStream::new();
    let of_collectives = system.collectives.all().iter().flat_map(|known| &known.elements);
    let terms = system.terms().chain(&system.observables);
    for element in terms.flat_map(|term: &Term| &term.values).chain(of_collectives) {
        nests.extend(places.nest(element));
    }
    // Places have better names in errors.
    for (loops, index) in &system.naturals {
        let index = places.index(index, loops);
        nests.extend(places.in_loops(loops, &quote!(__wzvi::elements::places::Slot::Unsigned(#index),)));
    }
    if nests.is_empty() && (system.components == 1 || degrees(system).is_some()) {
        return nests;
    }
    let components = count(usize::try_from(system.components).unwrap_or(1));
    // Only tables to be checked have a name.
    let tables = system.tables.iter().enumerate().map(|(id, table)| {
        let is_read = places.arms.keys().any(|(known, _)| *known == id);
        let (name, suffix) = if is_read { names(table) } else { Default::default() };
        quote!(__wzvi::elements::places::Name::new(#name, #suffix),)
    });
    let (usize, arms) = (quote!(__wzvi::usize), places.arms.values());
    let entries = (!places.arms.is_empty()).then(|| {
        quote! {
            fn entries(
                &self,
                __table: #usize,
                __outer: &[#usize],
                __range: __wzvi::Range<#usize>,
            ) -> __wzvi::elements::places::Entries {
                match (__table, __outer) {
                    #(#arms)*
                    _ => __wzvi::elements::places::Entries::of_length(0),
                }
            }
        }
    });
    quote! {
        const PLACES: __wzvi::elements::places::Places =
            __wzvi::elements::places::Places { components: #components, tables: &[#(#tables)*], nests: &[#nests] };

        #entries
    }
}

/// The name of a table, and the suffix after its indices.
fn names(table: &Table) -> (String, String) {
    let suffix = table.suffix.to_string().replace(' ', "");
    let name = table.name.strip_suffix(&suffix).unwrap_or(&table.name);
    (name.to_owned(), suffix)
}

struct Places<'s> {
    system: &'s System,
    /// The tables to be checked, by number and outer indices, with the code that reads them.
    arms: BTreeMap<(usize, usize), TokenStream>,
}

impl Places<'_> {
    /// The unproven places of one element; empty if all are proven.
    fn nest(&mut self, element: &Element) -> TokenStream {
        let bounds = Bounds { loops: &element.loops, tables: &self.system.tables };
        let sizes = Sizes { system: self.system, loops: &element.loops };
        let total = promised(
            self.system.size.multiply(&Index::integer(self.system.components)),
            "sizes are integers",
        );
        let is_proven = |slot: &Slot| match slot {
            Slot::State(_, index) => sizes.is_integer(index) && bounds.is_below(index, &total),
            Slot::Entry(table, indices) => (0..indices.len()).all(|level| {
                sizes.is_integer(&indices[level]) && self.is_inside(&bounds, *table, indices, level)
            }),
            Slot::Number(index) => sizes.is_integer(index),
            Slot::Collective(_) => true,
        };
        let slots: Vec<&Slot> =
            element.locals.iter().map(|local| &local.slot).filter(|slot| !is_proven(slot)).collect();
        let ends = element.loops.iter().flat_map(|known| [&known.start, &known.end]);
        if slots.is_empty() && ends.into_iter().all(|end| sizes.is_integer(end)) {
            return TokenStream::new();
        }
        let slots = slots.into_iter().map(|slot| match slot {
            Slot::State(_, index) => {
                let kind = if bounds.is_nonnegative(index) { quote!(Natural) } else { quote!(State) };
                let index = self.index(index, &element.loops);
                quote!(__wzvi::elements::places::Slot::#kind(#index),)
            }
            Slot::Entry(table, indices) => {
                let positions = self.positions(*table, indices, &element.loops, None);
                let table = count(*table as usize);
                quote!(__wzvi::elements::places::Slot::Entry(#table, #positions),)
            }
            Slot::Number(index) => {
                let index = self.index(index, &element.loops);
                quote!(__wzvi::elements::places::Slot::Number(#index),)
            }
            Slot::Collective(_) => TokenStream::new(),
        });
        let slots: TokenStream = slots.collect();
        self.in_loops(&element.loops, &slots)
    }

    fn in_loops(&mut self, loops: &[Loop], slots: &TokenStream) -> TokenStream {
        let ranges = loops.iter().map(|known| {
            let (start, end) = (self.index(&known.start, loops), self.index(&known.end, loops));
            quote!(__wzvi::elements::places::Loop(#start, #end),)
        });
        let ranges: TokenStream = ranges.collect();
        quote!(__wzvi::elements::places::Nest::new(&[#ranges], &[#slots]),)
    }

    fn index(&mut self, index: &Index, loops: &[Loop]) -> TokenStream {
        let terms = index.terms.iter().map(|(atom, coefficient)| {
            let (atom, coefficient) = (self.atom(atom, loops), Literal::i128_unsuffixed(*coefficient));
            quote!((#atom, #coefficient),)
        });
        let terms: TokenStream = terms.collect();
        let (constant, text) = (Literal::i128_unsuffixed(index.constant), self.system.index_in(loops, index));
        quote!(__wzvi::elements::places::Index::new(&[#terms], #constant, #text))
    }

    fn atom(&mut self, atom: &Atom, loops: &[Loop]) -> TokenStream {
        let (name, both) = match atom {
            Atom::Loop(variable) => {
                let depth = loops.iter().position(|known| known.variable == *variable);
                let depth = count(depth.unwrap_or(usize::MAX));
                return quote!(__wzvi::elements::places::Atom::Loop(#depth));
            }
            Atom::Size => return quote!(__wzvi::elements::places::Atom::Size),
            Atom::Given(table, indices) => {
                let read = quote!(|__integer| __integer as __wzvi::i128);
                let positions = self.positions(*table, indices, loops, Some(read));
                let table = count(*table as usize);
                return quote!(__wzvi::elements::places::Atom::Given(#table, #positions));
            }
            Atom::Of(operation, both) => (quote::format_ident!("{}", format!("{operation:?}")), both),
        };
        let (a, b) = (self.index(&both.0, loops), self.index(&both.1, loops));
        quote!(__wzvi::elements::places::Atom::#name(&[#a, #b]))
    }

    /// The indices of a list, whose reading code is recorded. `wide` converts integer entries to `i128`.
    fn positions(
        &mut self,
        table: u32,
        indices: &[Index],
        loops: &[Loop],
        wide: Option<TokenStream>,
    ) -> TokenStream {
        let Some(Table { tokens, suffix, .. }) = self.system.tables.get(table as usize) else {
            return quote!(&[]);
        };
        let number = table as usize;
        let (tokens, suffix) = (tokens.clone(), suffix.clone());
        // The list itself, then the lists inside.
        let mut list = quote!(&#tokens[..]);
        if wide.is_some() && indices.is_empty() {
            let arm = quote! {
                (#number, []) => __wzvi::elements::places::Entries::of_integer((#tokens) as __wzvi::i128),
            };
            self.arms.insert((number, 0), arm);
        }
        for level in 0..indices.len() {
            let found = match &wide {
                Some(wide) if level + 1 == indices.len() => {
                    quote!(__wzvi::elements::places::Entries::of_list(__list, __range, |__entry| (*__entry)#suffix, #wide))
                }
                _ => quote!(__wzvi::elements::places::Entries::of_length(__list.len())),
            };
            let outer = (0..level).map(|k| quote::format_ident!("__o{k}"));
            let arm = quote! {
                (#number, &[#(#outer),*]) => {
                    let __list = #list;
                    #found
                }
            };
            // A list recorded for its length only may be needed for its entries as well.
            self.arms.insert((number, level), arm);
            let at = quote::format_ident!("__o{level}");
            list = quote! {
                match (#list).get(#at) {
                    __wzvi::Some(__inner) => &__inner[..],
                    __wzvi::None => return __wzvi::elements::places::Entries::of_length(0),
                }
            };
        }
        let bounds = Bounds { loops, tables: &self.system.tables };
        let inside: Vec<bool> =
            (0..indices.len()).map(|level| self.is_inside(&bounds, table, indices, level)).collect();
        let positions = indices.iter().zip(inside).map(|(index, is_inside)| {
            let index = self.index(index, loops);
            quote!(__wzvi::elements::places::Position::new(#index, #is_inside),)
        });
        let positions: TokenStream = positions.collect();
        quote!(&[#positions])
    }

    /// Whether the list at `indices[..level]` is certainly longer than `indices[level]`.
    fn is_inside(&self, bounds: &Bounds<'_>, table: u32, indices: &[Index], level: usize) -> bool {
        let tables = &self.system.tables;
        let Some(own) = tables.get(table as usize) else { return false };
        let list = own.tokens.to_string();
        let length = tables.iter().position(|known| {
            let (tokens, suffix) = (known.tokens.to_string(), known.suffix.to_string());
            match level {
                0 => suffix.is_empty() && tokens == format!("{list} . len ()"),
                _ => suffix == ". len ()" && tokens == list,
            }
        });
        let Some(length) = length.and_then(|id| u32::try_from(id).ok()) else { return false };
        let length = Index::atom(Atom::Given(length, indices[..level].to_vec()));
        bounds.is_below(&indices[level], &length)
    }
}

/// Bounds of integers.
struct Sizes<'a> {
    system: &'a System,
    loops: &'a [Loop],
}

impl Sizes<'_> {
    /// Whether the index and all intermediate sums fit an `isize` on any machine.
    fn is_integer(&self, index: &Index) -> bool {
        self.most(index).is_some()
    }

    /// A bound of all intermediate magnitudes of the index, if it fits an `isize`.
    fn most(&self, index: &Index) -> Option<i128> {
        let mut sum = index.constant.checked_abs()?;
        for (atom, coefficient) in &index.terms {
            sum = sum.checked_add(self.most_of(atom)?.checked_mul(coefficient.checked_abs()?)?)?;
        }
        (sum <= LARGEST).then_some(sum)
    }

    fn most_of(&self, atom: &Atom) -> Option<i128> {
        let is_size = self.system.size == Index::atom(atom.clone());
        match atom {
            _ if is_size => Some(MOST_DEGREES),
            Atom::Loop(variable) => {
                let known = self.loops.iter().find(|known| known.variable == *variable)?;
                Some(self.most(&known.start)?.max(self.most(&known.end)?))
            }
            Atom::Size => Some(MOST_DEGREES),
            Atom::Given(table, indices) => {
                let table = self.system.tables.get(*table as usize)?;
                let is_length =
                    table.tokens.to_string().ends_with(". len ()") || table.suffix.to_string() == ". len ()";
                let are_integers = indices.iter().all(|index| self.is_integer(index));
                (is_length && are_integers).then_some(LARGEST)
            }
            Atom::Of(IndexOperation::Product, both) => self.most(&both.0)?.checked_mul(self.most(&both.1)?),
            // A divisor may be zero.
            Atom::Of(IndexOperation::Quotient | IndexOperation::Remainder, both) => {
                let divisor = both.1.as_integer().filter(|&divisor| divisor > 0);
                let is_size = both.1 == self.system.size || both.1 == Index::atom(Atom::Size);
                let most = self.most(&both.0)?;
                (divisor.is_some() || is_size).then_some(most)
            }
            Atom::Of(IndexOperation::Minimum | IndexOperation::Maximum, both) => {
                Some(self.most(&both.0)?.max(self.most(&both.1)?))
            }
        }
    }
}
