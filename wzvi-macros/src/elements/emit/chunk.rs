//! The innermost loop of an element, in chunks: what it reads is sliced or gathered, the arithmetic goes over slices of
//! one length without conditions, so that it can be vectorised. What it computes is added where it belongs at once, to a
//! slice of each vector; what belongs to a second slice of the same vector, which may overlap the first, waits in a
//! buffer. A bond of neighbours needs none: what it adds to the right end is carried to the next bond, whose left end
//! that is.
//!
//! Every place gets its terms in the order of the placements, wherever chunks begin: the slice that is furthest ahead is added to
//! at once, those behind it after the chunk, which ends before it would reach a slice that is further ahead than an earlier one.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::Wanted;
use super::indices::{Indices, variable};
use super::kernel::{Target, written};
use crate::diagnostics::internal::Promised;
use crate::emit::count;
use crate::emit::step::mentions;
use crate::model::index::{Atom, Index};
use crate::model::{Element, Local, Slot};
use crate::symbolic::Expr;

/// Placements in one chunk, if there are buffers.
const CHUNK: usize = 256;

/// The innermost loop.
pub(super) struct Chunk<'a> {
    pub(super) indices: &'a Indices<'a>,
    pub(super) element: &'a Element,
    /// The variable of the innermost loop, its start and its end.
    pub(super) inner: Option<(u32, [TokenStream; 2])>,
    pub(super) outputs: &'a [(Expr, Target)],
    /// What the local variables are called.
    pub(super) locals: &'a [Ident],
    /// Components of a point.
    pub(super) components: i128,
    pub(super) wanted: Wanted,
}

/// How an index moves with the innermost loop.
enum Motion {
    Fixed,
    /// By one, perhaps wrapping around.
    Run,
    /// By a point: to the component `part` of points from the index `base` on.
    Points {
        base: Index,
        part: usize,
    },
    Free,
}

/// The loop as it is put together.
#[derive(Default)]
struct Code {
    /// Before the outermost loop.
    buffers: TokenStream,
    /// Before all chunks.
    before: TokenStream,
    /// Ends the chunk early, by `__len`.
    limits: TokenStream,
    /// Indices that have their limit.
    limited: Vec<Index>,
    /// Slices of this chunk.
    opening: TokenStream,
    reads: TokenStream,
    stores: TokenStream,
    /// Gives back the slices that are written to.
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
}

/// A loop, and what stands before the outermost one around it.
pub(super) struct Emitted {
    pub(super) buffers: TokenStream,
    pub(super) body: TokenStream,
}

impl Chunk<'_> {
    pub(super) fn emit(&self, inside: &TokenStream, values: &[TokenStream]) -> Emitted {
        let Some((inner, [start, end])) = &self.inner else {
            return Emitted { buffers: TokenStream::new(), body: self.single(inside, values) };
        };
        let (inner, name) = (*inner, variable(*inner));
        let (isize, usize) = (quote!(__wzvi::isize), quote!(__wzvi::usize));
        let mut code = Code::default();
        for (k, local) in self.read_locals(inside, values) {
            self.open(&mut code, inner, k, local);
        }
        self.store(&mut code, inner, values);
        let has_all = code.limits.is_empty() && !code.has_buffers;
        let most = count(CHUNK);
        let most = match code.has_buffers {
            true => quote!(__wzvi::Ord::min((__end - __low) as #usize, #most)),
            false => quote!((__end - __low) as #usize),
        };
        let Code { buffers, before, limits, opening, reads, stores, release, closing, after, .. } = code;
        let release = (!closing.is_empty()).then_some(release);
        let mutable = if limits.is_empty() { quote!() } else { quote!(mut) };
        let body = quote!(#reads #inside #stores);
        let place =
            mentions(&body, &name.to_string()).then(|| quote!(let #name = __low + __place as #isize;));
        let limited = quote! {
            let #mutable __len = #most;
            #limits
        };
        let pass = quote! {
            #opening
            for __place in 0..__len {
                #place
                #body
            }
            #release
            #closing
        };
        let (places, sums) = (self.places(inner), written(self.outputs));
        if has_all {
            let positions = places.as_ref().map(|(_, places)| places);
            let mentioned = quote!(#limited #pass #positions);
            let opens_at_low = mentions(&mentioned, &name.to_string()).then(|| quote!(let #name = __low;));
            let pass = match &places {
                None => pass,
                Some((stride, places)) => {
                    let moves = opens_at_low.as_ref().map(|_| quote!(let #name = __low;));
                    quote! {
                        let (__skipped, __len) = #sums.clip::<#stride, _>(__len, #places);
                        if __len > 0 {
                            let __low = __low + __skipped as #isize;
                            #moves
                            #pass
                        }
                    }
                }
            };
            let body = quote! {
                #before
                let (__low, __end): (#isize, #isize) = (#start, #end);
                if __low < __end {
                    #opens_at_low
                    #limited
                    #pass
                }
                #after
            };
            return Emitted { buffers, body };
        }
        let pass = match places {
            None => quote! {
                #pass
                #name += __len as #isize;
            },
            Some((stride, places)) => quote! {
                let __next = #name + __len as #isize;
                let (__skipped, __len) = #sums.clip::<#stride, _>(__len, #places);
                if __len > 0 {
                    let __low = __low + __skipped as #isize;
                    #name = __low;
                    #pass
                }
                #name = __next;
            },
        };
        let body = quote! {
            #before
            let mut #name: #isize = #start;
            let __end: #isize = #end;
            while #name < __end {
                let __low = #name;
                #limited
                #pass
            }
            #after
        };
        Emitted { buffers, body }
    }

    /// The arguments of `clip`: where the first placement of a chunk writes, if that of each one after it is the place after, or the
    /// point after.
    fn places(&self, inner: u32) -> Option<(Literal, TokenStream)> {
        if self.wanted != Wanted::Slopes {
            return None;
        }
        let (mut strides, mut bases): (Vec<i128>, Vec<Index>) = (Vec::new(), Vec::new());
        for (_, target) in self.outputs {
            let Target::Slope { index, .. } = target else { return None };
            let (stride, base) = stretch(index, inner, self.components)?;
            if !bases.contains(&base) {
                bases.push(base);
            }
            strides.push(stride);
        }
        let stride = *strides.first()?;
        let positions = bases.iter().map(|base| self.indices.position(base));
        let is_same = strides.iter().all(|other| *other == stride);
        is_same.then(|| (Literal::i128_unsuffixed(stride), quote!([#(#positions),*])))
    }

    /// The local variables that the arithmetic reads, with their numbers.
    fn read_locals<'s>(&'s self, inside: &TokenStream, values: &[TokenStream]) -> Vec<(usize, &'s Local)> {
        let is_read = |name: &Ident| {
            let name = name.to_string();
            mentions(inside, &name) || values.iter().any(|value| mentions(value, &name))
        };
        self.element.locals.iter().enumerate().filter(|(k, _)| is_read(&self.locals[*k])).collect()
    }

    /// An element without loops.
    fn single(&self, inside: &TokenStream, values: &[TokenStream]) -> TokenStream {
        let mut statements = TokenStream::new();
        for (k, local) in self.read_locals(inside, values) {
            let (own, value) = (&self.locals[k], self.read(&local.slot));
            statements.extend(quote!(let #own = #value;));
        }
        statements.extend(inside.clone());
        for ((_, target), value) in self.outputs.iter().zip(values) {
            statements.extend(self.add(target, value));
        }
        statements
    }

    /// The read of a local variable.
    fn open(&self, code: &mut Code, inner: u32, k: usize, local: &Local) {
        let own = &self.locals[k];
        let list = self.list(&local.slot);
        match self.motion(&local.slot, inner) {
            Motion::Fixed => {
                let value = self.read(&local.slot);
                code.before.extend(quote!(let #own = #value;));
            }
            Motion::Run => {
                let (slice, index) = (format_ident!("__s{k}"), slot_index(&local.slot));
                let base = self.indices.position(&index);
                self.limit(code, &index, inner);
                code.opening.extend(quote! {
                    let #slice = #base;
                    let #slice = &#list[#slice..#slice + __len];
                });
                let is_state = matches!(local.slot, Slot::Coordinate(_) | Slot::Momentum(_));
                code.reads.extend(match is_state {
                    true => {
                        let value = self.wanted.lifted(quote!(#slice[__place]));
                        quote!(let #own = #value;)
                    }
                    false => {
                        let number = self.wanted.number();
                        quote!(let #own = #number::from_f64(#slice[__place]);)
                    }
                });
            }
            Motion::Points { base, part } => {
                let (points, part) = (self.points(code, inner, &list, &base, false), count(part));
                let value = self.wanted.lifted(quote!(#points[__place][#part]));
                code.reads.extend(quote!(let #own = #value;));
            }
            Motion::Free => {
                let value = self.read(&local.slot);
                code.reads.extend(quote!(let #own = #value;));
            }
        }
    }

    /// The name of the points of `list` from `base` on.
    fn points(
        &self,
        code: &mut Code,
        inner: u32,
        list: &TokenStream,
        base: &Index,
        is_written: bool,
    ) -> Ident {
        let key = list.to_string();
        if let Some((.., name)) = code.points.iter().find(|(known, at, _)| *known == key && at == base) {
            return name.clone();
        }
        self.limit(code, base, inner);
        let name = format_ident!("__points{}", code.points.len());
        let (at, components) = (self.indices.position(base), Literal::i128_unsuffixed(self.components));
        code.opening.extend(match is_written {
            false => quote! {
                let #name = #at;
                let #name = &#list[#name..#name + #components * __len].as_chunks::<#components>().0[..__len];
            },
            true => quote!(let mut #name = #list.points::<#components>(#at, __len);),
        });
        if is_written {
            code.release.extend(quote!(__wzvi::drop(#name);));
        }
        code.points.push((key, base.clone(), name.clone()));
        name
    }

    /// Where the computed values go. Slices first: what is left knows then which vectors are taken.
    fn store(&self, code: &mut Code, inner: u32, values: &[TokenStream]) {
        let mut left: Vec<usize> = Vec::new();
        let order = self.furthest_first(inner);
        // Pairs of neighbours before others, which would take their vector.
        let pairs: Vec<(usize, usize)> =
            order.iter().filter_map(|&j| Some((j, self.neighbour(j, inner)?))).collect();
        let mut carried: Vec<usize> = Vec::new();
        for &(j, next) in &pairs {
            if let Some((_, Target::Slope { vector, .. })) = self.outputs.get(j)
                && !code.direct.contains(vector)
            {
                code.direct.push(vector.clone());
                carried.extend([j, next]);
                self.store_run(code, inner, values, j, Some(next));
            }
        }
        for j in order {
            let Some((_, Target::Slope { vector, index })) = self.outputs.get(j) else {
                left.push(j);
                continue;
            };
            if carried.contains(&j) {
                continue;
            }
            let is_taken = code.direct.contains(vector);
            match motion(index, inner, self.components) {
                Motion::Run if !is_taken => {
                    code.direct.push(vector.clone());
                    self.store_run(code, inner, values, j, None);
                }
                Motion::Points { base, part } => {
                    let list = quote!(#vector);
                    let key = (list.to_string(), &base);
                    let is_open = code.points.iter().any(|(list, at, _)| (list, at) == (&key.0, key.1));
                    if is_taken && !is_open {
                        left.push(j);
                        continue;
                    }
                    code.direct.push(vector.clone());
                    self.keep_order(code, inner, j);
                    let (points, value) = (self.points(code, inner, &list, &base, true), &values[j]);
                    let part = count(part);
                    code.stores.extend(quote!(#points.add_part(__place, #part, #value);));
                }
                _ => left.push(j),
            }
        }
        for j in left {
            self.store_other(code, inner, j, &values[j]);
        }
    }

    /// The outputs, so that of slopes whose places differ by a constant the one furthest ahead comes first.
    fn furthest_first(&self, inner: u32) -> Vec<usize> {
        let place = |j: &usize| -> Option<(&Ident, Index, i128)> {
            let (_, Target::Slope { vector, index }) = self.outputs.get(*j)? else { return None };
            let (place, _) = unwrapped(index, inner)?;
            let constant = place.constant;
            Some((vector, place.shifted(-constant)?, constant))
        };
        let all: Vec<usize> = (0..self.outputs.len()).collect();
        let mut order = all.clone();
        order.sort_by_key(|j| match place(j) {
            None => (*j, 0),
            Some((vector, moving, constant)) => {
                let is_alike = |other: &&usize| {
                    place(other).is_some_and(|(known, place, _)| known == vector && place == moving)
                };
                (all.iter().find(is_alike).copied().unwrap_or(*j), -constant)
            }
        });
        order
    }

    /// A chunk ends before it would reach, with a slice that is added after others, where one of those is: places get their
    /// terms in the order of the placements.
    fn keep_order(&self, code: &mut Code, inner: u32, j: usize) {
        let place = |j: usize| match self.outputs.get(j) {
            Some((_, Target::Slope { vector, index })) => {
                stretch(index, inner, self.components).map(|(stride, base)| (vector, stride, base))
            }
            _ => None,
        };
        let Some((vector, stride, own)) = place(j) else { return };
        let is_own =
            |earlier: &usize| place(*earlier).is_some_and(|(known, _, at)| known == vector && at == own);
        if code.added.iter().any(is_own) {
            return;
        }
        for &earlier in &code.added {
            let Some((_, _, before)) = place(earlier).filter(|(known, ..)| *known == vector) else {
                continue;
            };
            let is_plain = wrap(&own, inner, stride).is_none() && wrap(&before, inner, stride).is_none();
            let ahead = own.subtract(&before).and_then(|distance| distance.as_integer());
            if is_plain && ahead.is_some_and(|ahead| ahead <= 0) {
                continue;
            }
            let [before, own] = [&before, &own].map(|index| {
                let (position, size) = (self.indices.position(index), Literal::i128_unsuffixed(stride));
                if stride == 1 { position } else { quote!(#position / #size) }
            });
            code.limits.extend(quote!(__len = __wzvi::elements::apart(__len, #before, #own);));
        }
        code.added.push(j);
    }

    /// Another slope whose place is that of slope `j` in the next round of the loop.
    fn neighbour(&self, j: usize, inner: u32) -> Option<usize> {
        let place = |j: usize| match &self.outputs.get(j)?.1 {
            Target::Slope { vector, index } => Some((vector, index)),
            _ => None,
        };
        let (vector, own) = place(j)?;
        (0..self.outputs.len()).filter(|&other| other != j).find(|&other| {
            place(other).is_some_and(|(known, index)| known == vector && follows(index, own, inner))
        })
    }

    /// Adds slope `j` to its slice, and with it what the round before left for the same place.
    fn store_run(&self, code: &mut Code, inner: u32, values: &[TokenStream], j: usize, next: Option<usize>) {
        let Some((_, Target::Slope { vector, index })) = self.outputs.get(j) else { return };
        let (slice, at, value) = (format_ident!("__b{j}"), format_ident!("__at{j}"), &values[j]);
        let carried = format_ident!("__carried{j}");
        let base = self.indices.position(index);
        self.limit(code, index, inner);
        self.keep_order(code, inner, j);
        if let Some((next, (_, Target::Slope { index: ahead, .. }))) =
            next.and_then(|next| Some((next, self.outputs.get(next)?)))
        {
            self.limit(code, ahead, inner);
            let (base_ahead, value_ahead) = (self.indices.position(ahead), &values[next]);
            let zero = self.zero();
            // One by one where the next place is another one after all.
            if wrap(index, inner, 1).is_some() || wrap(ahead, inner, 1).is_some() {
                code.limits.extend(quote! {
                    if #base_ahead != #base + 1 {
                        __len = 1;
                    }
                });
            }
            code.opening.extend(quote! {
                let #at = #base_ahead + (__len - 1);
                let mut #carried = #zero;
            });
            // Computed first: only then can the compiler keep what is carried in a vector register.
            code.stores.extend(quote! {
                let __ahead = #value_ahead;
                #slice.add(__place, #value + #carried);
                #carried = __ahead;
            });
            code.closing.extend(quote!(#vector.add(#at, #carried);));
        } else {
            code.stores.extend(quote!(#slice.add(__place, #value);));
        }
        code.opening.extend(quote!(let mut #slice = #vector.run(#base, __len);));
        code.release.extend(quote!(__wzvi::drop(#slice);));
    }

    /// What does not go to a slice of its own: sums, buffers, single places.
    fn store_other(&self, code: &mut Code, inner: u32, j: usize, value: &TokenStream) {
        let Some((_, target)) = self.outputs.get(j) else { return };
        let (buffer, zero, most) = (format_ident!("__b{j}"), self.zero(), count(CHUNK));
        let is_fixed = match target {
            Target::Total => true,
            Target::Slope { index, .. } => !index.loops().contains(&inner),
            Target::Curvature { row, column, .. } => {
                !row.loops().contains(&inner) && !column.loops().contains(&inner)
            }
        };
        let shared = match target {
            Target::Slope { vector, index } if code.direct.contains(vector) => Some((vector, index)),
            _ => None,
        };
        if is_fixed {
            code.before.extend(quote!(let mut #buffer = #zero;));
            code.stores.extend(quote!(#buffer = #buffer + #value;));
            code.after.extend(self.add(target, &quote!(#buffer)));
        } else if let Some((vector, index)) = shared {
            code.has_buffers = true;
            code.buffers.extend(quote!(let mut #buffer = [#zero; #most];));
            code.opening.extend(quote!(let #buffer = &mut #buffer[..__len];));
            code.stores.extend(quote!(#buffer[__place] = #value;));
            if let Some((stride, base)) = stretch(index, inner, self.components) {
                self.limit(code, index, inner);
                self.keep_order(code, inner, j);
                let at = self.indices.position(&base);
                let (run, add) = match motion(index, inner, self.components) {
                    Motion::Points { part, .. } => {
                        let (size, part) = (Literal::i128_unsuffixed(stride), count(part));
                        (quote!(points::<#size>), quote!(add_part(__place, #part, #buffer[__place])))
                    }
                    _ => (quote!(run), quote!(add(__place, #buffer[__place]))),
                };
                code.closing.extend(quote! {{
                    let mut __run = #vector.#run(#at, __len);
                    for __place in 0..__len {
                        __run.#add;
                    }
                }});
            } else {
                let (name, add) = (variable(inner), self.add(target, &quote!(#buffer[__place])));
                code.closing.extend(quote! {
                    for __place in 0..__len {
                        let #name = __low + __place as __wzvi::isize;
                        #add
                    }
                });
            }
        } else {
            code.stores.extend(self.add(target, value));
        }
    }

    /// A chunk ends where an index wraps around.
    fn limit(&self, code: &mut Code, index: &Index, inner: u32) {
        let both = wrap(index, inner, 1).or_else(|| wrap(index, inner, self.components));
        let Some(both) = both.filter(|_| !code.limited.contains(index)) else { return };
        code.limited.push(index.clone());
        let (at, size) = (self.indices.value(&both.0), self.indices.value(&both.1));
        code.limits.extend(quote! {
            __len = __wzvi::Ord::min(__len, (#size - #at % #size) as __wzvi::usize);
        });
    }

    fn motion(&self, slot: &Slot, inner: u32) -> Motion {
        match slot {
            Slot::Coordinate(index) | Slot::Momentum(index) | Slot::Displacement(index) => {
                motion(index, inner, self.components)
            }
            Slot::Number(index) if !index.loops().contains(&inner) => Motion::Fixed,
            Slot::Number(_) => Motion::Free,
            Slot::Entry(_, indices) if !indices.iter().any(|index| index.loops().contains(&inner)) => {
                Motion::Fixed
            }
            Slot::Entry(table, indices) => match indices.as_slice() {
                [index] if runs(index, inner) && self.indices.is_plain(*table) => Motion::Run,
                _ => Motion::Free,
            },
        }
    }

    fn zero(&self) -> TokenStream {
        let number = self.wanted.number();
        quote!(#number::from_f64(0.0))
    }

    fn list(&self, slot: &Slot) -> TokenStream {
        match slot {
            Slot::Coordinate(_) => quote!(__at.q),
            Slot::Momentum(_) => quote!(__at.p),
            Slot::Entry(table, _) => self.indices.entry(*table, &[]),
            // No derivative reads displacements.
            Slot::Number(_) | Slot::Displacement(_) => TokenStream::new(),
        }
    }

    fn read(&self, slot: &Slot) -> TokenStream {
        match slot {
            Slot::Coordinate(index) => {
                let position = self.indices.position(index);
                self.wanted.lifted(quote!(__at.q[#position]))
            }
            Slot::Momentum(index) => {
                let position = self.indices.position(index);
                self.wanted.lifted(quote!(__at.p[#position]))
            }
            Slot::Entry(table, indices) => {
                let (entry, number) = (self.indices.entry(*table, indices), self.wanted.number());
                quote!(#number::from_f64(#entry))
            }
            Slot::Number(index) | Slot::Displacement(index) => {
                let (value, number) = (self.indices.value(index), self.wanted.number());
                quote!(#number::from_f64(#value as __wzvi::f64))
            }
        }
    }

    fn add(&self, target: &Target, value: &TokenStream) -> TokenStream {
        match target {
            Target::Total => quote!(__total = __total + #value;),
            Target::Slope { vector, index } => {
                let position = self.indices.position(index);
                quote!(#vector.add(#position, #value);)
            }
            Target::Curvature { method, row, column, is_diagonal } => {
                let (row, column) = (self.indices.position(row), self.indices.position(column));
                let is_diagonal = is_diagonal.map(|is_diagonal| quote!(#is_diagonal,));
                quote!(__into.#method(#row, #column, #is_diagonal #value);)
            }
        }
    }
}

/// Where the first placement of the loop reads or writes, if each one after it does so `stride` places further on: in the next place,
/// or in the next point. Components of one point have the same.
pub(super) fn stretch(index: &Index, inner: u32, components: i128) -> Option<(i128, Index)> {
    match motion(index, inner, components) {
        Motion::Run => Some((1, index.clone())),
        Motion::Points { base, .. } => Some((components, base)),
        Motion::Fixed | Motion::Free => None,
    }
}

fn slot_index(slot: &Slot) -> Index {
    match slot {
        Slot::Coordinate(index) | Slot::Momentum(index) | Slot::Displacement(index) | Slot::Number(index) => {
            index.clone()
        }
        Slot::Entry(_, indices) => indices.first().cloned().promised("entries of tables have an index"),
    }
}

fn motion(index: &Index, inner: u32, components: i128) -> Motion {
    if !index.loops().contains(&inner) {
        return Motion::Fixed;
    }
    if runs(index, inner) {
        return Motion::Run;
    }
    // All points from the first to the last are in the vector if the index is.
    let moves_on = index.slope(inner) == Some(components) || wrap(index, inner, components).is_some();
    let is_point = components > 1
        && moves_on
        && index.terms.iter().all(|(_, coefficient)| coefficient % components == 0);
    let part = if is_point { index.constant.rem_euclid(components) } else { 0 };
    match (is_point, index.shifted(-part), usize::try_from(part)) {
        (true, Some(base), Ok(part)) => Motion::Points { base, part },
        _ => Motion::Free,
    }
}

/// Whether the index goes up by one with the loop, perhaps wrapping around.
pub(super) fn runs(index: &Index, inner: u32) -> bool {
    index.slope(inner) == Some(1) || wrap(index, inner, 1).is_some()
}

/// `k + r` and `n` of an index `... + stride ((k + r) % n)` with everything else fixed in the loop over `k`.
fn wrap(index: &Index, inner: u32, stride: i128) -> Option<&(Index, Index)> {
    let mut moving =
        index.terms.iter().filter(|(atom, _)| Index::atom(atom.clone()).loops().contains(&inner));
    match (moving.next(), moving.next()) {
        (Some((Atom::Remainder(both), coefficient)), None) if *coefficient == stride => {
            let is_run = both.0.slope(inner) == Some(1) && !both.1.loops().contains(&inner);
            is_run.then_some(&**both)
        }
        _ => None,
    }
}

/// The index without wrapping around, and after how many places it does.
fn unwrapped(index: &Index, inner: u32) -> Option<(Index, Index)> {
    match wrap(index, inner, 1) {
        None => Some((index.clone(), Index::default())),
        Some(both) => {
            let rest = index.subtract(&Index::atom(Atom::Remainder(Box::new(both.clone()))))?;
            Some((rest.add(&both.0)?, both.1.clone()))
        }
    }
}

/// Whether `ahead` is `own + 1` but for wrapping around, which the loop looks for itself.
fn follows(ahead: &Index, own: &Index, inner: u32) -> bool {
    let distance = || -> Option<[Index; 3]> {
        let ((ahead, size), (own, other)) = (unwrapped(ahead, inner)?, unwrapped(own, inner)?);
        let plain = ahead.subtract(&own)?;
        Some([plain.add(&other)?, plain.subtract(&size)?, plain])
    };
    let one = Index::integer(1);
    runs(ahead, inner) && runs(own, inner) && distance().is_some_and(|distances| distances.contains(&one))
}
