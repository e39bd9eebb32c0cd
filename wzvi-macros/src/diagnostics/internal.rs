//! Internal assertions of the compiler. A broken assertion becomes an error of the expansion, which says
//! where and why. No number is invented.

use std::cell::RefCell;
use std::panic::Location;

thread_local! {
    /// The assertions that were broken since the last query. An expansion runs on one thread.
    static BROKEN: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// A value that cannot be absent, because of `reason`. If it is absent, the default takes its place, and the
/// expansion ends with an error.
#[track_caller]
pub(crate) fn promised<T: Default>(value: Option<T>, reason: &str) -> T {
    if value.is_none() {
        broken(reason);
    }
    value.unwrap_or_default()
}

/// Notes that `reason` does not hold.
#[track_caller]
pub(crate) fn broken(reason: &str) {
    let place = Location::caller();
    BROKEN.with_borrow_mut(|broken| broken.push(format!("{}:{}: {reason}", place.file(), place.line())));
}

/// The assertions that were broken since the last call, as one error.
pub(crate) fn error() -> Option<syn::Error> {
    let broken = BROKEN.take();
    (!broken.is_empty()).then(|| {
        let message = format!(
            "this is a bug in wzvi {}, not a mistake of yours; please report it with this struct: an assumption does not \
             hold ({})",
            env!("CARGO_PKG_VERSION"),
            broken.join("; ")
        );
        syn::Error::new(proc_macro2::Span::call_site(), message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbolic::Rational;

    #[test]
    fn what_is_absent_is_an_error_once() {
        assert!(error().is_none());
        assert_eq!(promised(Some(Rational::HALF), "it is there"), Rational::HALF);
        assert!(error().is_none());
        assert_eq!(promised(None::<Rational>, "halves are small"), Rational::ZERO);
        broken("loops are closed");
        let text = error().map(|error| error.to_string()).unwrap_or_default();
        for part in ["please report", "internal.rs:", "halves are small", "loops are closed"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(error().is_none());
    }
}
