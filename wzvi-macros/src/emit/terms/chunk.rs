//! The innermost loop of an element, in chunks. Inputs are sliced or gathered, and the arithmetic runs over
//! slices of one length without conditions, so that it can be vectorised. Results are added at once to one
//! slice of each vector; results for a second slice of the same vector, which may overlap the first, wait in
//! a buffer. A bond of neighbours needs no buffer: its slope at the right end is carried to the next bond,
//! which has its left end there.
//!
//! Terms are added to every place in the order of the placements, wherever chunks begin: the slice with the
//! largest index is written at once, the others after the chunk; a chunk ends before two slices overlap.
//!
//! Tests: `tests/loops/one_by_one.rs`, `tests/loops/tables.rs`.

mod access;
mod chunk_loop;
mod gather;
mod rows;
mod stores;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{ToTokens, format_ident, quote};

use access::Access;
use chunk_loop::{ChunkLoop, WrittenRange};

pub(super) use access::InnerLoop;
pub(super) use gather::{gathers, open_lists};

pub(super) use rows::partners;

use super::kernel::{Arithmetic, Target, written};
use super::{Derivative, collective};
use crate::diagnostics::promised;
use crate::emit::count;
use crate::indices::{Indices, OpenList, variable};
use crate::model::{Element, Half, Index, Local, Slot};
use crate::symbolic::Expr;
use crate::tokens::mentions;

/// The innermost loop.
#[derive(Clone)]
pub(super) struct Chunk<'a> {
    pub(super) indices: Indices<'a>,
    pub(super) element: &'a Element,
    pub(super) inner: InnerLoop,
    /// The start and the end of the innermost loop, if there is one.
    pub(super) range: Option<[TokenStream; 2]>,
    /// The start of the loop, unless it depends on the active noises.
    pub(super) start: Option<Index>,
    pub(super) outputs: &'a [(Expr, Target)],
    pub(super) arithmetic: &'a Arithmetic,
    /// The weight of a placement, where each has its own.
    pub(super) weight: &'a TokenStream,
    /// Whether the loop is restricted to wanted places.
    pub(super) has_tiles: bool,
    pub(super) derivative: Derivative,
    /// The lists that `open_lists` found, if placements that are not adjacent in the state are evaluated in
    /// lanes.
    pub(super) gathered: Option<&'a [OpenList]>,
}

/// The loop during assembly.
#[derive(Default)]
struct LoopCode {
    /// Before the outermost loop.
    buffers: TokenStream,
    /// Before all chunks.
    before: TokenStream,
    /// Ends the chunk early, by `__len`, where an index wraps around.
    limits: TokenStream,
    /// Ends the chunk early where a place would otherwise get its terms in another order.
    ordering: TokenStream,
    /// Indices whose limit has been emitted.
    limited: Vec<Index>,
    /// The first places of the ranges of lists in the loop, named `__first` and a number: for the piece, then
    /// for the chunk.
    firsts: Vec<ListRange>,
    /// Slices of this chunk.
    opening: TokenStream,
    reads: TokenStream,
    stores: TokenStream,
    /// Releases the slices that are written to.
    release: TokenStream,
    /// After the arithmetic of a chunk.
    closing: TokenStream,
    after: TokenStream,
    /// Slices of points: list, base, name.
    points: Vec<(String, Index, Ident)>,
    /// Vectors of which a slice is written to while the arithmetic runs.
    direct: Vec<Ident>,
    has_buffers: bool,
    /// Outputs of slices, in the order in which they are added.
    added: Vec<usize>,
    /// The outputs of a placement.
    values: Vec<TokenStream>,
}

/// A range of a list, from the place `index` on.
struct ListRange {
    index: Index,
    stride: i128,
    name: Ident,
}

/// A loop, with the code before and after the outermost loop around it.
#[derive(Default)]
pub(super) struct EmittedLoop {
    pub(super) buffers: TokenStream,
    pub(super) body: TokenStream,
    pub(super) after: TokenStream,
}

impl Chunk<'_> {
    pub(super) fn emit(&self) -> EmittedLoop {
        let Some([start, end]) = &self.range else {
            return EmittedLoop { body: self.single(), ..EmittedLoop::default() };
        };
        let (name, Arithmetic { inside, values, .. }) = (variable(self.inner.variable), self.arithmetic);
        let mut code = LoopCode::default();
        for (k, local) in self.read_locals() {
            self.open(&mut code, k, local);
        }
        let block = self.gathered.map(|lists| self.gather(lists));
        code.values.clone_from(block.as_ref().map_or(values, |block| &block.values));
        self.store(&mut code);
        let place_in = |body: &TokenStream| {
            mentions(body, &name.to_string()).then(|| quote!(let #name = #name + __place as __wzvi::isize;))
        };
        let LoopCode { reads, stores, opening, closing, .. } = &code;
        let each = match &block {
            Some(block) => block.over_chunk(&place_in, reads, stores),
            None => {
                let weight = self.weight;
                let body = quote!(#reads #weight #inside #stores);
                let place = place_in(&body);
                quote! {
                    for __place in 0..__len {
                        #place
                        #body
                    }
                }
            }
        };
        let (items, lists) = block.map(|block| (block.items, block.opening)).unzip();
        let release = (!closing.is_empty()).then_some(&code.release);
        let chunk = quote! {
            #opening
            #lists
            #each
            #release
            #closing
        };
        let buffers = &code.buffers;
        let buffers = quote!(#items #buffers);
        let (places, sums) = (self.written_range(), written(self.outputs));
        let nest = ChunkLoop { indices: self.indices, name, start, end, code: &code, chunk, places, sums };
        EmittedLoop { buffers, body: nest.emit(), ..EmittedLoop::default() }
    }

    fn written_range(&self) -> Option<WrittenRange> {
        if self.derivative != Derivative::Gradient {
            return None;
        }
        let (mut strides, mut bases): (Vec<i128>, Vec<Index>) = (Vec::new(), Vec::new());
        for (_, target) in self.outputs {
            let Target::Gradient { index, .. } = target else { return None };
            let (stride, base) = self.inner.range(index)?;
            if !bases.contains(&base) {
                bases.push(base);
            }
            strides.push(stride);
        }
        let stride = *strides.first()?;
        if strides.iter().any(|other| *other != stride) {
            return None;
        }
        let all = |bases: &[Index]| {
            let positions = bases.iter().map(|base| self.indices.position(base));
            quote!([#(#positions),*])
        };
        let is_safe = bases.iter().all(Index::is_affine);
        let start = self.start.as_ref().filter(|_| is_safe);
        let at_start =
            start.and_then(|start| bases.iter().map(|base| base.with(self.inner.variable, start)).collect());
        Some(WrittenRange {
            stride: Literal::i128_unsuffixed(stride),
            at: all(&bases),
            at_start: at_start.map(|bases: Vec<Index>| all(&bases)),
            is_safe,
        })
    }

    /// The local variables that the arithmetic reads, with their numbers.
    fn read_locals(&self) -> Vec<(usize, &Local)> {
        let Arithmetic { inside, values, locals, .. } = self.arithmetic;
        let is_read = |name: &Ident| {
            let name = name.to_string();
            mentions(inside, &name) || values.iter().any(|value| mentions(value, &name))
        };
        self.element.locals.iter().enumerate().filter(|(k, _)| is_read(&locals[*k])).collect()
    }

    /// An element without loops, skipped if it adds to nothing.
    fn single(&self) -> TokenStream {
        let mut statements = TokenStream::new();
        let Arithmetic { inside, values, locals, .. } = self.arithmetic;
        for (k, local) in self.read_locals() {
            let (own, value) = (&locals[k], self.read(self.indices, &local.slot));
            statements.extend(quote!(let #own = #value;));
        }
        statements.extend([self.weight, inside].map(TokenStream::clone));
        for ((_, target), value) in self.outputs.iter().zip(values) {
            statements.extend(self.add(self.indices, target, value));
        }
        let place = |target: &Target| match target {
            Target::Gradient { index, .. } => Some(self.indices.position(index)),
            _ => None,
        };
        match self.outputs.iter().map(|(_, target)| place(target)).collect::<Option<Vec<_>>>() {
            Some(places)
                if self.has_tiles && self.derivative == Derivative::Gradient && !places.is_empty() =>
            {
                let sums = written(self.outputs);
                quote! {
                    if #sums.clip::<1, _>(1, [#(#places),*]).1 > 0 {
                        #statements
                    }
                }
            }
            _ => statements,
        }
    }

    /// The read of a local variable.
    fn open(&self, code: &mut LoopCode, k: usize, local: &Local) {
        let own = &self.arithmetic.locals[k];
        let list = self.list(&local.slot);
        match self.access(&local.slot) {
            Access::Invariant => {
                let value = self.read(self.indices, &local.slot);
                code.before.extend(quote!(let #own = #value;));
            }
            Access::Unit => {
                let (slice, index) = (format_ident!("__s{k}"), slot_index(&local.slot));
                let first = self.first(code, &index, 1);
                self.limit(code, &index);
                code.opening.extend(quote!(let #slice = &#list[#first..#first + __len];));
                let entry = quote!(#slice[__place]);
                let value = match &local.slot {
                    Slot::State(..) => self.derivative.lifted(entry),
                    Slot::Entry(..) | Slot::Number(_) | Slot::Collective(_) => {
                        self.derivative.constant(&entry)
                    }
                };
                code.reads.extend(quote!(let #own = #value;));
            }
            Access::Strided { base, part } => {
                let (points, part) = (self.points(code, &list, &base, false), count(part));
                let value = self.derivative.lifted(quote!(#points[__place][#part]));
                code.reads.extend(quote!(let #own = #value;));
            }
            Access::Gather => {
                let value = self.read(self.in_loop(), &local.slot);
                code.reads.extend(quote!(let #own = #value;));
            }
        }
    }

    /// The name of the points of `list` from `base` on.
    fn points(&self, code: &mut LoopCode, list: &TokenStream, base: &Index, is_written: bool) -> Ident {
        let key = list.to_string();
        if let Some((.., name)) = code.points.iter().find(|(known, at, _)| *known == key && at == base) {
            return name.clone();
        }
        self.limit(code, base);
        let name = format_ident!("__points{}", code.points.len());
        let (at, components) =
            (self.first(code, base, self.inner.components), Literal::i128_unsuffixed(self.inner.components));
        code.opening.extend(match is_written {
            false => quote! {
                let #name = &#list[#at..#at + #components * __len].as_chunks::<#components>().0[..__len];
            },
            true => quote!(let mut #name = #list.points::<#components>(#at, __len);),
        });
        if is_written {
            code.release.extend(quote!(__wzvi::drop(#name);));
        }
        code.points.push((key, base.clone(), name.clone()));
        name
    }

    /// The name of the first place of a range.
    fn first(&self, code: &mut LoopCode, index: &Index, stride: i128) -> Ident {
        if let Some(known) = code.firsts.iter().find(|known| known.index == *index && known.stride == stride)
        {
            return known.name.clone();
        }
        let name = format_ident!("__first{}", code.firsts.len());
        code.firsts.push(ListRange { index: index.clone(), stride, name: name.clone() });
        name
    }

    /// A chunk ends where an index wraps around.
    fn limit(&self, code: &mut LoopCode, index: &Index) {
        let Some(both) = self.inner.wraps(index).filter(|_| !code.limited.contains(index)) else { return };
        code.limited.push(index.clone());
        let (at, size) = (self.indices.value(&both.0), self.indices.value(&both.1));
        code.limits.extend(quote! {
            __len = __wzvi::Ord::min(__len, (#size - #at % #size) as __wzvi::usize);
        });
    }

    fn access(&self, slot: &Slot) -> Access {
        // Parts of lists are open if placements are evaluated in lanes.
        let is_open = |index: &Index| self.gathered.is_some() && index.slope(self.inner.variable) == Some(1);
        match (self.inner.slot_access(slot), slot) {
            (Access::Unit, Slot::Entry(table, indices))
                if indices.iter().any(is_open) || !self.indices.is_plain(*table) =>
            {
                Access::Gather
            }
            (motion, _) => motion,
        }
    }

    fn zero(&self) -> TokenStream {
        self.derivative.constant(&quote!(0.0))
    }

    fn list(&self, slot: &Slot) -> TokenStream {
        match slot {
            Slot::State(Half::Coordinates, _) => quote!(__at.q),
            Slot::State(Half::Momenta, _) => quote!(__at.p),
            Slot::Entry(table, _) => self.indices.entry(*table, &[]),
            // Derivatives do not read displacements.
            Slot::Number(_) | Slot::Collective(_) | Slot::State(Half::Displacements, _) => TokenStream::new(),
        }
    }

    /// The indices in the loop over placements.
    fn in_loop(&self) -> Indices<'_> {
        Indices { lists: self.gathered.unwrap_or_default(), ..self.indices }
    }

    fn read(&self, indices: Indices<'_>, slot: &Slot) -> TokenStream {
        match slot {
            Slot::State(Half::Coordinates | Half::Momenta, index) => {
                let (list, position) = (self.list(slot), indices.position(index));
                self.derivative.lifted(quote!(#list[#position]))
            }
            Slot::Entry(table, at) => self.derivative.constant(&indices.entry(*table, at)),
            Slot::Collective(slot) => collective::name(*slot).to_token_stream(),
            Slot::Number(index) | Slot::State(Half::Displacements, index) => {
                let value = indices.value(index);
                self.derivative.constant(&quote!(#value as __wzvi::f64))
            }
        }
    }

    fn add(&self, indices: Indices<'_>, target: &Target, value: &TokenStream) -> TokenStream {
        match target {
            Target::Value { factor: None } => value.clone(),
            Target::Value { factor: Some(factor) } => quote!(#value * #factor),
            Target::Total { sum } => quote!(#sum = #sum + #value;),
            Target::Gradient { vector, index } => {
                let position = indices.position(index);
                quote!(#vector.add(#position, #value);)
            }
            Target::Hessian { by, row, column, is_alone } => {
                let (row, column) = (indices.position(row), indices.position(column));
                quote!(__into(__wzvi::elements::HessianBlock::#by, [#row, #column], #is_alone, #value);)
            }
            Target::Constraint { method, constraint } => {
                let constraint = indices.position(constraint);
                quote!(__into.#method(#constraint, #value);)
            }
            Target::Slope { constraint, coordinate } => {
                let (constraint, coordinate) = (indices.position(constraint), indices.position(coordinate));
                quote!(__into.slope(#constraint, #coordinate, #value);)
            }
        }
    }
}

fn slot_index(slot: &Slot) -> Index {
    match slot {
        Slot::State(_, index) | Slot::Number(index) => index.clone(),
        Slot::Entry(_, indices) => promised(indices.first().cloned(), "entries of tables have an index"),
        Slot::Collective(_) => Index::default(),
    }
}
