//! Elements with the weight of their part and the increments of their noises.

use proc_macro2::TokenStream;
use quote::quote;

use super::kernel::Target;
use super::{Indices, Wanted, element_code, value_code};
use crate::discretise::sums::Weighted;
use crate::elements::parts::{PartElements, family_of};
use crate::model::{Reads, System};

/// All elements of a part: its value, or what adds their derivatives; and where there is something to do, if that is asked at once.
pub(super) fn part_code(
    model: &mut System,
    part: &PartElements,
    wanted: Wanted,
) -> (Option<TokenStream>, TokenStream) {
    let sum = if wanted == Wanted::Value { &part.values } else { &part.elements };
    let mut code = Vec::new();
    // Elements with the same increments stand together.
    for group in sum.chunk_by(|a, b| a.increments == b.increments) {
        let Some(first) = group.first() else { continue };
        let (weight, condition) = (weight(model, part, first, wanted), condition(model, first, wanted));
        let body: TokenStream = match wanted {
            Wanted::Value => values(model, group, Some(&weight)),
            Wanted::Slopes | Wanted::Curvature => {
                group.iter().map(|weighted| derivatives(model, weighted, wanted, &weight)).collect()
            }
        };
        if !body.is_empty() {
            code.push((condition, body));
        }
    }
    if code.len() == 1 {
        return code.remove(0);
    }
    let is_value = wanted == Wanted::Value;
    let groups = code.into_iter().map(|(condition, body)| {
        let body = if is_value { quote!(__value = __value + { #body };) } else { body };
        match condition {
            Some(condition) => quote!(if #condition { #body }),
            None => body,
        }
    });
    let groups: TokenStream = groups.collect();
    (None, if is_value { quote!(let mut __value = __S::from_f64(0.0); #groups __value) } else { groups })
}

/// The sum of elements with one weight, which is taken out of it unless it changes in their loops.
pub(super) fn values(model: &mut System, group: &[Weighted], weight: Option<&TokenStream>) -> TokenStream {
    let is_fixed = group.iter().flat_map(|weighted| &weighted.increments).all(|k| k.loops().is_empty());
    let (inside, outside) = if is_fixed { (None, weight) } else { (weight, None) };
    if let [only] = group
        && only.element.loops.len() < 2
    {
        return value_code(model, only, inside, Target::Value { factor: outside.cloned() });
    }
    let added: Vec<TokenStream> =
        group.iter().map(|weighted| value_code(model, weighted, inside, Target::Total)).collect();
    let factor = outside.map(|weight| quote!(* #weight));
    quote! {
        let mut __total = __S::from_f64(0.0);
        #({ #added })*
        __total #factor
    }
}

/// The derivatives of one element, if those by what it reads are wanted.
pub(super) fn derivatives(
    model: &mut System,
    weighted: &Weighted,
    wanted: Wanted,
    weight: &TokenStream,
) -> TokenStream {
    let condition = match weighted.element.reads() {
        _ if weighted.element.displacements().next().is_some() => quote!(__wanted.by_q),
        Reads::Nothing => return TokenStream::new(),
        Reads::Coordinates => quote!(__wanted.by_q),
        Reads::Momenta => quote!(__wanted.by_p),
        Reads::Both => quote!((__wanted.by_q || __wanted.by_p)),
    };
    let body = element_code(model, weighted, wanted, weight);
    if body.is_empty() { body } else { quote!(if #condition { #body }) }
}

/// The product of the increments of an element of a part, and the weight of the part.
fn weight(
    model: &System,
    part: &PartElements,
    Weighted { increments, .. }: &Weighted,
    wanted: Wanted,
) -> TokenStream {
    let indices = Indices::unchecked(&model.tables);
    let factor = part.is_weighted.then(|| quote!(*__weight));
    let increments = increments.iter().map(|number| {
        let position = indices.position(number);
        wanted.lifted(quote!(__at.increment(#position)))
    });
    match increments.reduce(|product, increment| quote!(#product * #increment)) {
        Some(product) => quote!(#product #factor),
        None => {
            let number = wanted.number();
            quote!(#number::from_f64(__at.h #factor))
        }
    }
}

/// Whether a noise acts that is no member of a family, whose loop knows.
fn condition(model: &System, weighted: &Weighted, wanted: Wanted) -> Option<TokenStream> {
    let [number] = weighted.increments.as_slice() else { return None };
    if wanted == Wanted::Curvature || family_of(weighted).is_some() {
        return None;
    }
    let position = Indices::unchecked(&model.tables).position(number);
    Some(quote!(__at.acting.contains(&#position)))
}
