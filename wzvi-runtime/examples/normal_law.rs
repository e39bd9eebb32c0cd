//! The law of a thousand million normals, as ensembles draw them: `tests/runtime/ensemble_law.rs` with more of them. Takes half a
//! minute; the first argument is another number of paths.
//!
//! `cargo run --release -p wzvi-runtime --example normal_law`

#![allow(clippy::unwrap_used, reason = "an example stops at the first error")]
#![allow(
    clippy::disallowed_methods,
    reason = "laws and errors are measured with the functions of the platform"
)]

#[path = "../tests/runtime/law.rs"]
mod law;

fn main() {
    let paths = std::env::args().nth(1).and_then(|paths| paths.parse().ok()).unwrap_or(50_000_u64);
    let law = law::measure(2026, paths / 16 * 16, 1000);
    println!("{:e} normals; the largest is {:.4}", law.count, law.largest);
    println!("off by how many standard deviations:");
    for (name, deviation) in law.deviations() {
        println!("  {name:20} {deviation:6.2}");
    }
    let (chi_square, freedom) = law.chi_square();
    println!("chi-square {chi_square:.0} with {freedom:.0} degrees of freedom");
    let (distance, probability) = law.kolmogorov_smirnov();
    println!("Kolmogorov-Smirnov: sqrt(n) D = {distance:.4}, more with probability {probability:.3}");
    for (bound, beyond, expected) in law.tails() {
        println!("beyond {bound}: {beyond}, expected {expected:.1}");
    }
}
