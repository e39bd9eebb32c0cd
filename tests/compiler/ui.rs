//! What the macro says of mistakes: `TRYBUILD=overwrite cargo test --workspace --test compiler ui -- --ignored` renews the messages.

#[test]
#[ignore = "calls Cargo, for minutes: part of .ci/run"]
fn mistakes_are_reported_where_they_are() {
    trybuild::TestCases::new().compile_fail("ui/fail/*.rs");
}
