//! The stores of a chunk. Tests: `tests/loops/one_by_one.rs`.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::access::Access;
use super::chunk_loop::CHUNK;
use super::{Chunk, LoopCode};
use crate::emit::count;
use crate::emit::terms::kernel::Target;
use crate::indices::variable;
use crate::model::Index;

impl Chunk<'_> {
    /// Stores the computed values. Slices first, which determine the vectors in use for the rest.
    pub(super) fn store(&self, code: &mut LoopCode) {
        let mut left: Vec<usize> = Vec::new();
        let order = self.furthest_first();
        // Pairs of neighbours before others, which would occupy their vector.
        let pairs: Vec<(usize, usize)> =
            order.iter().filter_map(|&j| Some((j, self.neighbour(j)?))).collect();
        let mut carried: Vec<usize> = Vec::new();
        for &(j, next) in &pairs {
            if let Some((vector, _)) = self.slope(j)
                && !code.direct.contains(vector)
            {
                code.direct.push(vector.clone());
                carried.extend([j, next]);
                self.store_unit(code, j, Some(next));
            }
        }
        for j in order {
            if carried.contains(&j) {
                continue;
            }
            let Some((vector, index)) = self.slope(j) else {
                left.push(j);
                continue;
            };
            let is_taken = code.direct.contains(vector);
            match self.inner.access(index) {
                Access::Unit if !is_taken => {
                    code.direct.push(vector.clone());
                    self.store_unit(code, j, None);
                }
                Access::Strided { base, part } => {
                    let list = quote!(#vector);
                    let key = (list.to_string(), &base);
                    let is_open = code.points.iter().any(|(list, at, _)| (list, at) == (&key.0, key.1));
                    if is_taken && !is_open {
                        left.push(j);
                        continue;
                    }
                    code.direct.push(vector.clone());
                    self.keep_order(code, j);
                    let (points, value) = (self.points(code, &list, &base, true), &code.values[j]);
                    let part = count(part);
                    code.stores.extend(quote!(#points.add_part(__place, #part, #value);));
                }
                _ => left.push(j),
            }
        }
        for group in left.chunk_by(|a, b| self.point(*a).is_some_and(|a| self.point(*b) == Some(a))) {
            match group {
                // Another range of the vector is written during the arithmetic.
                [first, ..]
                    if self.point(*first).is_some_and(|(vector, ..)| code.direct.contains(vector)) =>
                {
                    self.store_waiting(code, group)
                }
                _ => group.iter().for_each(|&j| self.store_other(code, j)),
            }
        }
    }

    /// The outputs, ordered so that among slopes whose places differ by a constant the one furthest ahead
    /// comes first.
    fn furthest_first(&self) -> Vec<usize> {
        let place = |j: &usize| -> Option<(&Ident, Index, i128)> {
            let (vector, index) = self.slope(*j)?;
            let (place, _) = self.inner.unwrapped(index)?;
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

    /// Ends a chunk before a slice that is added later reaches one that is added earlier, so that places get
    /// their terms in the order of the placements.
    fn keep_order(&self, code: &mut LoopCode, j: usize) {
        let place = |j: usize| self.point(j);
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
            let is_plain =
                self.inner.wrap(&own, stride).is_none() && self.inner.wrap(&before, stride).is_none();
            let ahead = own.subtract(&before).and_then(|distance| distance.as_integer());
            if is_plain && ahead.is_some_and(|ahead| ahead <= 0) {
                continue;
            }
            let [before, own] = [&before, &own].map(|index| {
                let (position, size) = (self.indices.position(index), Literal::i128_unsuffixed(stride));
                if stride == 1 { position } else { quote!(#position / #size) }
            });
            code.ordering
                .extend(quote!(__len = __wzvi::elements::disjoint_placements(__len, #before, #own);));
        }
        code.added.push(j);
    }

    /// Another slope at the place of slope `j` in the next iteration of the loop.
    fn neighbour(&self, j: usize) -> Option<usize> {
        let (vector, own) = self.slope(j)?;
        let is_next = |(known, index): (&Ident, &Index)| known == vector && self.inner.follows(index, own);
        (0..self.outputs.len()).find(|&other| other != j && self.slope(other).is_some_and(is_next))
    }

    /// Adds slope `j` to its slice, together with the term carried from the last iteration for the same
    /// place.
    fn store_unit(&self, code: &mut LoopCode, j: usize, next: Option<usize>) {
        let Some((vector, index)) = self.slope(j) else { return };
        let (slice, at, value) = (format_ident!("__b{j}"), format_ident!("__at{j}"), code.values[j].clone());
        let carried = format_ident!("__carried{j}");
        let first = self.first(code, index, 1);
        self.limit(code, index);
        self.keep_order(code, j);
        if let Some((next, (_, ahead))) = next.and_then(|next| Some((next, self.slope(next)?))) {
            self.limit(code, ahead);
            let (first_ahead, value_ahead) = (self.first(code, ahead, 1), code.values[next].clone());
            let zero = self.zero();
            // One placement at a time where wrapping makes the next place another one.
            if self.inner.wrap(index, 1).is_some() || self.inner.wrap(ahead, 1).is_some() {
                let [base, base_ahead] = [index, ahead].map(|index| self.indices.position(index));
                code.limits.extend(quote! {
                    if #base_ahead != #base + 1 {
                        __len = 1;
                    }
                });
            }
            code.opening.extend(quote! {
                let #at = #first_ahead + (__len - 1);
                let mut #carried = #zero;
            });
            // Computed first, so that the compiler can keep the carried term in a vector register.
            code.stores.extend(quote! {
                let __ahead = #value_ahead;
                #slice.add(__place, #value + #carried);
                #carried = __ahead;
            });
            code.closing.extend(quote!(#vector.add(#at, #carried);));
        } else {
            code.stores.extend(quote!(#slice.add(__place, #value);));
        }
        code.opening.extend(quote!(let mut #slice = #vector.run(#first, __len);));
        code.release.extend(quote!(__wzvi::drop(#slice);));
    }

    /// Buffers a value of each placement of a chunk.
    fn store_in_buffer(&self, code: &mut LoopCode, buffer: &Ident, j: usize) {
        let (zero, most, value) = (self.zero(), count(CHUNK), &code.values[j]);
        code.has_buffers = true;
        code.buffers.extend(quote!(let mut #buffer = [#zero; #most];));
        code.opening.extend(quote!(let #buffer = &mut #buffer[..__len];));
        code.stores.extend(quote!(#buffer[__place] = #value;));
    }

    /// The vector that output `j` adds to, and where, if it is a slope.
    fn slope(&self, j: usize) -> Option<(&Ident, &Index)> {
        match self.outputs.get(j) {
            Some((_, Target::Gradient { vector, index })) => Some((vector, index)),
            _ => None,
        }
    }

    /// The vector that output `j` adds to, and the first place or point of its range.
    fn point(&self, j: usize) -> Option<(&Ident, i128, Index)> {
        let (vector, index) = self.slope(j)?;
        let (stride, base) = self.inner.range(index)?;
        Some((vector, stride, base))
    }

    /// Outputs of one range, buffered until the arithmetic of the chunk is done.
    fn store_waiting(&self, code: &mut LoopCode, group: &[usize]) {
        let Some((vector, stride, base)) = group.first().and_then(|&j| self.point(j)) else { return };
        let size = Literal::i128_unsuffixed(stride);
        let run = if stride == 1 { quote!(run) } else { quote!(points::<#size>) };
        let mut adds = TokenStream::new();
        for &j in group {
            let Some((_, index)) = self.slope(j) else { continue };
            let buffer = format_ident!("__b{j}");
            self.limit(code, index);
            self.keep_order(code, j);
            self.store_in_buffer(code, &buffer, j);
            adds.extend(match self.inner.access(index) {
                Access::Strided { part, .. } => {
                    let part = count(part);
                    quote!(__run.add_part(__place, #part, #buffer[__place]);)
                }
                _ => quote!(__run.add(__place, #buffer[__place]);),
            });
        }
        let at = self.first(code, &base, stride);
        code.closing.extend(quote! {{
            let mut __run = #vector.#run(#at, __len);
            for __place in 0..__len {
                #adds
            }
        }});
    }

    /// Outputs without a slice of their own: sums, buffers, single places.
    fn store_other(&self, code: &mut LoopCode, j: usize) {
        let Some((_, target)) = self.outputs.get(j) else { return };
        let (buffer, zero, value) = (format_ident!("__b{j}"), self.zero(), code.values[j].clone());
        let is_moving = |index: &Index| index.loops().contains(&self.inner.variable);
        let is_fixed = match target {
            Target::Value { .. } | Target::Total { .. } => true,
            Target::Gradient { index, .. } => !is_moving(index),
            Target::Hessian { row, column, .. } => !is_moving(row) && !is_moving(column),
            Target::Constraint { constraint, .. } => !is_moving(constraint),
            Target::Slope { constraint, coordinate } => !is_moving(constraint) && !is_moving(coordinate),
        };
        let is_shared = matches!(target, Target::Gradient { vector, .. } if code.direct.contains(vector));
        if is_fixed {
            code.before.extend(quote!(let mut #buffer = #zero;));
            code.stores.extend(quote!(#buffer = #buffer + #value;));
            code.after.extend(self.add(self.indices, target, &quote!(#buffer)));
        } else if is_shared {
            self.store_in_buffer(code, &buffer, j);
            let name = variable(self.inner.variable);
            let add = self.add(self.indices, target, &quote!(#buffer[__place]));
            code.closing.extend(quote! {
                for __place in 0..__len {
                    let #name = #name + __place as __wzvi::isize;
                    #add
                }
            });
        } else {
            code.stores.extend(self.add(self.in_loop(), target, &value));
        }
    }
}
