//! The stores of a chunk.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::motion::{Motion, follows, motion, stretch, unwrapped, wrap};
use super::nest::CHUNK;
use super::{Chunk, Code};
use crate::emit::count;
use crate::emit::terms::indices::variable;
use crate::emit::terms::kernel::Target;
use crate::model::Index;

impl Chunk<'_> {
    /// Stores the computed values. Slices first, which determine the vectors in use for the rest.
    pub(super) fn store(&self, code: &mut Code, inner: u32, values: &[TokenStream]) {
        let mut left: Vec<usize> = Vec::new();
        let order = self.furthest_first(inner);
        // Pairs of neighbours before others, which would occupy their vector.
        let pairs: Vec<(usize, usize)> =
            order.iter().filter_map(|&j| Some((j, self.neighbour(j, inner)?))).collect();
        let mut carried: Vec<usize> = Vec::new();
        for &(j, next) in &pairs {
            if let Some((vector, _)) = self.slope(j)
                && !code.direct.contains(vector)
            {
                code.direct.push(vector.clone());
                carried.extend([j, next]);
                self.store_run(code, inner, values, j, Some(next));
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
        for group in
            left.chunk_by(|a, b| self.point(*a, inner).is_some_and(|a| self.point(*b, inner) == Some(a)))
        {
            match group {
                // Another stretch of the same vector is written during the arithmetic.
                [first, ..]
                    if self.point(*first, inner).is_some_and(|(vector, ..)| code.direct.contains(vector)) =>
                {
                    self.store_waiting(code, inner, group, values)
                }
                _ => group.iter().for_each(|&j| self.store_other(code, inner, j, &values[j])),
            }
        }
    }

    /// The outputs, ordered so that among slopes whose places differ by a constant the one furthest ahead comes first.
    fn furthest_first(&self, inner: u32) -> Vec<usize> {
        let place = |j: &usize| -> Option<(&Ident, Index, i128)> {
            let (vector, index) = self.slope(*j)?;
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

    /// Ends a chunk before a slice that is added later reaches one that is added earlier, so that places get their terms in
    /// the order of the placements.
    fn keep_order(&self, code: &mut Code, inner: u32, j: usize) {
        let place = |j: usize| self.point(j, inner);
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
            code.ordering.extend(quote!(__len = __wzvi::elements::apart(__len, #before, #own);));
        }
        code.added.push(j);
    }

    /// Another slope at the place of slope `j` in the next iteration of the loop.
    fn neighbour(&self, j: usize, inner: u32) -> Option<usize> {
        let (vector, own) = self.slope(j)?;
        let is_next = |(known, index): (&Ident, &Index)| known == vector && follows(index, own, inner);
        (0..self.outputs.len()).find(|&other| other != j && self.slope(other).is_some_and(is_next))
    }

    /// Adds slope `j` to its slice, together with the term carried from the last iteration for the same place.
    fn store_run(&self, code: &mut Code, inner: u32, values: &[TokenStream], j: usize, next: Option<usize>) {
        let Some((vector, index)) = self.slope(j) else { return };
        let (slice, at, value) = (format_ident!("__b{j}"), format_ident!("__at{j}"), &values[j]);
        let carried = format_ident!("__carried{j}");
        let first = self.first(code, index, 1);
        self.limit(code, index, inner);
        self.keep_order(code, inner, j);
        if let Some((next, (_, ahead))) = next.and_then(|next| Some((next, self.slope(next)?))) {
            self.limit(code, ahead, inner);
            let (first_ahead, value_ahead) = (self.first(code, ahead, 1), &values[next]);
            let zero = self.zero();
            // One placement at a time where wrapping makes the next place another one.
            if wrap(index, inner, 1).is_some() || wrap(ahead, inner, 1).is_some() {
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
    fn store_in_buffer(&self, code: &mut Code, buffer: &Ident, value: &TokenStream) {
        let (zero, most) = (self.zero(), count(CHUNK));
        code.has_buffers = true;
        code.buffers.extend(quote!(let mut #buffer = [#zero; #most];));
        code.opening.extend(quote!(let #buffer = &mut #buffer[..__len];));
        code.stores.extend(quote!(#buffer[__place] = #value;));
    }

    /// The vector that output `j` adds to, and where, if it is a slope.
    fn slope(&self, j: usize) -> Option<(&Ident, &Index)> {
        match self.outputs.get(j) {
            Some((_, Target::Slope { vector, index })) => Some((vector, index)),
            _ => None,
        }
    }

    /// The vector that output `j` adds to, and the first place or point of the stretch of it.
    fn point(&self, j: usize, inner: u32) -> Option<(&Ident, i128, Index)> {
        let (vector, index) = self.slope(j)?;
        let (stride, base) = stretch(index, inner, self.components)?;
        Some((vector, stride, base))
    }

    /// Outputs of one stretch, buffered until the arithmetic of the chunk is done.
    fn store_waiting(&self, code: &mut Code, inner: u32, group: &[usize], values: &[TokenStream]) {
        let Some((vector, stride, base)) = group.first().and_then(|&j| self.point(j, inner)) else { return };
        let size = Literal::i128_unsuffixed(stride);
        let run = if stride == 1 { quote!(run) } else { quote!(points::<#size>) };
        let mut adds = TokenStream::new();
        for &j in group {
            let Some((_, index)) = self.slope(j) else { continue };
            let buffer = format_ident!("__b{j}");
            self.limit(code, index, inner);
            self.keep_order(code, inner, j);
            self.store_in_buffer(code, &buffer, &values[j]);
            adds.extend(match motion(index, inner, self.components) {
                Motion::Points { part, .. } => {
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
    fn store_other(&self, code: &mut Code, inner: u32, j: usize, value: &TokenStream) {
        let Some((_, target)) = self.outputs.get(j) else { return };
        let (buffer, zero) = (format_ident!("__b{j}"), self.zero());
        let is_fixed = match target {
            Target::Value { .. } | Target::Total => true,
            Target::Slope { index, .. } => !index.loops().contains(&inner),
            Target::Curvature { row, column, .. } => {
                !row.loops().contains(&inner) && !column.loops().contains(&inner)
            }
        };
        let is_shared = matches!(target, Target::Slope { vector, .. } if code.direct.contains(vector));
        if is_fixed {
            code.before.extend(quote!(let mut #buffer = #zero;));
            code.stores.extend(quote!(#buffer = #buffer + #value;));
            code.after.extend(self.add(self.indices, target, &quote!(#buffer)));
        } else if is_shared {
            self.store_in_buffer(code, &buffer, value);
            let name = variable(inner);
            let add = self.add(self.indices, target, &quote!(#buffer[__place]));
            code.closing.extend(quote! {
                for __place in 0..__len {
                    let #name = #name + __place as __wzvi::isize;
                    #add
                }
            });
        } else {
            code.stores.extend(self.add(self.in_loop(), target, value));
        }
    }
}
