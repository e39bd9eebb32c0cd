#[hamiltonian(
    drift = |q, p| {
        let a = match q {
            _ => 1.0,
        };
        let b = loop {
            break 1.0;
        };
        let c = dbg!(q);
        let d = kinetic(p);
        let e = "text";
        let f = if let Some(x) = Some(q) { x } else { 0.0 };
        let g = unsafe { q };
        let h = return q;
        let Some(i) = Some(q) else { return 0.0 };
        let j: f64;
        let k = q % p;
        let l = |x: &mut f64| *x;
        let m = l(&mut q);
        let n = q.max(p) as i32;
        let o = Some(q)?;
        let r = Point { x: q };
        let s = self.energy();
        while q > 0.0 {}
        fn local() {}
        println!("{q}");
        a + b + c + d + e + f + g + h + i + j + k + m + n + o + r + s
    },
    embedding = Midpoint,
)]
struct System;

fn kinetic(p: f64) -> f64 {
    0.5 * p * p
}
