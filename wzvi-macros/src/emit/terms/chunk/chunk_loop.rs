//! The loop over the chunks of an innermost loop: runs of placements without wrapping of an index and without
//! change of the order of terms at a place, restricted to those that write to wanted places. Tests:
//! `tests/loops/tiles.rs`.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::quote;

use super::{ListRange, LoopCode};
use crate::emit::count;
use crate::indices::Indices;
use crate::tokens::mentions;

/// The number of placements in one chunk, if there are buffers.
pub(super) const CHUNK: usize = 256;

/// The first place that a loop writes to, if successive placements write to successive places or points.
pub(super) struct WrittenRange {
    /// From one placement to the next.
    pub(super) stride: Literal,
    /// In terms of the loop variable.
    pub(super) at: TokenStream,
    /// In terms of the start of the loop, if that is simple.
    pub(super) at_start: Option<TokenStream>,
    /// Whether it can be evaluated for an empty loop.
    pub(super) is_safe: bool,
}

/// The ingredients of the loop.
pub(super) struct ChunkLoop<'n> {
    pub(super) indices: Indices<'n>,
    /// The loop variable, its start and its end.
    pub(super) name: Ident,
    pub(super) start: &'n TokenStream,
    pub(super) end: &'n TokenStream,
    pub(super) code: &'n LoopCode,
    /// The code of a chunk, whose ranges begin at their `__first`.
    pub(super) chunk: TokenStream,
    /// The places it writes to, and the sums.
    pub(super) places: Option<WrittenRange>,
    pub(super) sums: TokenStream,
}

impl ChunkLoop<'_> {
    pub(super) fn emit(&self) -> TokenStream {
        let LoopCode { limits, ordering, has_buffers, .. } = self.code;
        match &self.places {
            _ if limits.is_empty() && ordering.is_empty() && !has_buffers => self.at_once(),
            Some(WrittenRange { stride, at, .. }) if *has_buffers => self.in_pieces(stride, at),
            _ => self.in_chunks(),
        }
    }

    /// All placements are one chunk.
    fn at_once(&self) -> TokenStream {
        let Self { name, start, end, code: LoopCode { before, after, .. }, sums, .. } = self;
        let pass = self.pass();
        let code = match &self.places {
            None => quote!(if let (#name, __len @ 1..) = __wzvi::elements::stretch(#start, #end) { #pass }),
            Some(WrittenRange { stride, at_start: Some(places), .. }) => quote! {
                if let (#name, __len @ 1..) = #sums.stretch::<#stride, _>(#start, #end, #places) {
                    #pass
                }
            },
            Some(WrittenRange { stride, at, is_safe, .. }) => {
                let found = quote! {
                    if let (#name, __len @ 1..) = #sums.stretch::<#stride, _>(#name, #end, #at) {
                        #pass
                    }
                };
                let found = if *is_safe { found } else { quote!(if #name < #end { #found }) };
                quote!(let #name: __wzvi::isize = #start; #found)
            }
        };
        quote!(#before #code #after)
    }

    /// Pieces without wrapping of an index: unwanted placements are skipped once per piece, and the
    /// beginnings of slices are computed once. Chunks begin at the same placements as otherwise, because they
    /// determine the grouping of sums.
    fn in_pieces(&self, stride: &Literal, places: &TokenStream) -> TokenStream {
        let Self { name, code: LoopCode { limits, ordering, firsts, .. }, chunk, sums, .. } = self;
        let (isize, usize) = (quote!(__wzvi::isize), quote!(__wzvi::usize));
        let (mutable_piece, mutable_chunk, most) = (mutable(limits), mutable(ordering), count(CHUNK));
        let moved = firsts.iter().map(|ListRange { stride, name, .. }| {
            let factor = Some(Literal::i128_unsuffixed(*stride)).filter(|_| *stride != 1);
            let factor = factor.map(|stride| quote!(#stride *));
            quote!(let #name = #name + #factor __skip;)
        });
        let moved: TokenStream = moved.collect();
        let low = mentions(chunk, &name.to_string()).then(|| quote!(let #name = #name + __skip as #isize;));
        let opened = self.opened();
        self.while_placements_remain(&quote! {
            let #mutable_piece __len = (__end - #name) as #usize;
            #limits
            let __next = #name + __len as #isize;
            let (__skipped, __taken) = #sums.clip::<#stride, _>(__len, #places);
            let __until = __skipped + __taken;
            let #mutable_chunk __len: #usize = #most;
            #ordering
            let __most = __len;
            #opened
            let mut __from = if __skipped < __most { 0 } else { __skipped / __most * __most };
            while __from < __until {
                let __skip = __wzvi::Ord::max(__from, __skipped);
                __from += __most;
                let __len = __wzvi::Ord::min(__from, __until) - __skip;
                #low
                #moved
                #chunk
            }
            #name = __next;
        })
    }

    /// The end is determined for each chunk.
    fn in_chunks(&self) -> TokenStream {
        let Self { name, sums, .. } = self;
        let (isize, limited, pass) = (quote!(__wzvi::isize), self.limited(), self.pass());
        let pass = match &self.places {
            None => quote! {
                #pass
                #name += __len as #isize;
            },
            Some(WrittenRange { stride, at, .. }) => quote! {
                let __next = #name + __len as #isize;
                if let (#name, __len @ 1..) = #sums.stretch::<#stride, _>(#name, __next, #at) {
                    #pass
                }
                #name = __next;
            },
        };
        self.while_placements_remain(&quote!(#limited #pass))
    }

    /// Loops while placements remain.
    fn while_placements_remain(&self, body: &TokenStream) -> TokenStream {
        let Self { name, start, end, code: LoopCode { before, after, .. }, .. } = self;
        quote! {
            #before
            let mut #name: __wzvi::isize = #start;
            let __end: __wzvi::isize = #end;
            while #name < __end {
                #body
            }
            #after
        }
    }

    /// The number of placements in the chunk.
    fn limited(&self) -> TokenStream {
        let Self { name, code: LoopCode { limits, ordering, has_buffers, .. }, .. } = self;
        let (usize, is_limited) = (quote!(__wzvi::usize), mutable(&quote!(#limits #ordering)));
        let most = count(CHUNK);
        let most = match has_buffers {
            true => quote!(__wzvi::Ord::min((__end - #name) as #usize, #most)),
            false => quote!((__end - #name) as #usize),
        };
        quote! {
            let #is_limited __len = #most;
            #limits
            #ordering
        }
    }

    /// The first places of ranges.
    fn opened(&self) -> TokenStream {
        let opened = self.code.firsts.iter().map(|ListRange { index, name, .. }| {
            let position = self.indices.position(index);
            quote!(let #name = #position;)
        });
        opened.collect()
    }

    fn pass(&self) -> TokenStream {
        let (opened, chunk) = (self.opened(), &self.chunk);
        quote!(#opened #chunk)
    }
}

/// `mut` for a number that `limits` may reduce.
fn mutable(limits: &TokenStream) -> TokenStream {
    if limits.is_empty() { quote!() } else { quote!(mut) }
}
