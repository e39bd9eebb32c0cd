//! The measure of the compiler's work in tests: nodes of expressions that were visited or requested. The same
//! on every machine.

use std::cell::Cell;

thread_local! {
    static NODES: Cell<u64> = const { Cell::new(0) };
}

pub(crate) fn count() {
    NODES.set(NODES.get() + 1);
}

/// The number of nodes that `f` visits or requests on this thread.
pub(crate) fn of<T>(f: impl FnOnce() -> T) -> (u64, T) {
    let before = NODES.get();
    let value = f();
    (NODES.get() - before, value)
}
