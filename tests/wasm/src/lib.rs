//! The rows of `fixtures/portable.rs`, as bytes in the memory of the module.

#[path = "../../fixtures/portable.rs"]
mod portable;

use std::cell::RefCell;

thread_local! {
    static ROWS: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Computes the rows and returns the number of their bytes.
#[unsafe(no_mangle)]
pub extern "C" fn compute() -> usize {
    ROWS.set(portable::rows().join("\n"));
    ROWS.with_borrow(String::len)
}

/// Where the bytes are.
#[unsafe(no_mangle)]
pub extern "C" fn rows() -> *const u8 {
    ROWS.with_borrow(|rows| rows.as_ptr())
}
