//! What the macro accepts and what it says otherwise: `TRYBUILD=overwrite cargo test --test ui` renews the messages.

#[test]
fn supported_programs_compile_and_run() {
    trybuild::TestCases::new().pass("tests/ui/pass/*.rs");
}

#[test]
fn mistakes_are_reported_where_they_are() {
    trybuild::TestCases::new().compile_fail("tests/ui/fail/*.rs");
}
