//! The normals of ensembles have the law that they should have: a million at every build, a thousand million once, with
//! `cargo run --release -p wzvi-runtime --example normal_law`.

/// No statistic is more than five of its standard deviations off: once in two million for each of the fifteen, and the
/// numbers are the same at every run.
#[test]
fn a_million_normals() {
    for (seed, paths, blocks) in [(1, 64, 800), (2, 50_000 / 16 * 16, 1)] {
        let law = super::law::measure(seed, paths, blocks);
        assert!(law.count >= 0.99e6);
        for (name, deviation) in law.deviations() {
            assert!(deviation.abs() < 5.0, "seed {seed}: {name} is off by {deviation} standard deviations");
        }
        let (distance, probability) = law.kolmogorov_smirnov();
        assert!(probability > 1e-6, "seed {seed}: Kolmogorov-Smirnov {distance}");
        for (bound, beyond, expected) in law.tails() {
            let allowed = 5.0 * expected.sqrt() + 3.0;
            assert!((beyond as f64 - expected).abs() < allowed, "{beyond} beyond {bound}, not {expected}");
        }
        assert!(law.largest < 8.6);
    }
}
