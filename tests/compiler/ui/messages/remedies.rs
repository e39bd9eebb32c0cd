#[hamiltonian(
    drift = |q, p| {
        let half = 1/2 * p * p;
        let half2 = p * 1/2 * p;
        let scaled = -3 * q;
        let squared = n * n * q;
        let mixed = (n + 1) / 2 * q;
        let rest = n % 3 * q;
        let root = 2.sqrt() + n.sqrt() + (n + 1).sqrt();
        let less = if n < q { 1.0 } else { 2.0 };
        let power = q.powi(n ^ 2);
        let power2 = !q ^ 2;
        let bits = n & 3;
        let cube = i32::pow(-2, 3) as f64 + usize::max(n, 2) as f64 + std::primitive::u8::pow(n + 1, 2) as f64;
        let either = (q > 0.0) ^ p;
        half
    },
    embedding = Midpoint,
)]
struct Integers { n: i32 }

#[hamiltonian(drift = |q, p| p * p, embedding = [Verlet, Yoshida4, Composed<Verlet, KahanLi8>, Composed, Gauss<N>])]
struct Compositions;

#[hamiltonian(
    drift = |q, p| p * p,
    friction = 1.0,
    temperature = 1.0,
    embedding = [
        Splitting<(B<-1, 2>, A, O, B<3, 2>)>,
        Splitting<(B<0, 2>, A, O, B)>,
        Splitting<(B<1>, A<0.5, 1>, O<1, 2>, B)>,
        Splitting<(B, A, O, C)>,
    ],
)]
struct Letters;

#[hamiltonian(drift = |q, p| p * p, friction = |q, p, t| t, temperature = |q, p, t| 1.0 + t, embedding = Baoab)]
struct Closures;

#[hamiltonian(drift = |q, p| p * p, friction = 1.0 + q, temperature = 1.0 + t, embedding = Baoab)]
struct Names;

#[hamiltonian(drift = |q, p| p * p, damping = [[k * q]], temperature = |q| q, embedding = Baoab)]
struct Matrix { k: f64 }

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| p * p).sum::<f64>(),
    noise = [|q, p| q.iter().sum::<f64>().cos()],
    calculus = Ito,
    embedding = Midpoint,
)]
struct Field;

#[hamiltonian(
    drift = |q: &[f64], p: &[f64]| p.iter().map(|p| p * p).sum::<f64>(),
    noise = [|q, p, k| (k as f64 * q.iter().sum::<f64>()).cos(); 20],
    embedding = Midpoint,
)]
struct Family;

#[hamiltonian(
    drift = |q, p, w| p * p + q * w,
    noise = [|q, p, time| q, |q, p, k| q * k, |q, p, _| q],
    force = |q, p, xi| xi,
    embedding = Midpoint,
)]
struct Noises;

#[hamiltonian(drift = |q, p, phase| p * p + q * phase + missing, noise = [|q, p, k| q * k; 2], embedding = Midpoint)]
struct Families;

#[hamiltonian(drift = |q, p, phase| p * p + q * phase + missing, embedding = Midpoint)]
struct Deterministic;
