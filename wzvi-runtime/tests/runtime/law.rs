//! Statistics of many normals at once, each as a number of standard deviations or a probability, for any sample size.

use wzvi_runtime::ensemble::{InstructionSet, Normals};

/// Bins between -8 and 8 whose counts make the chi-square and the Kolmogorov-Smirnov statistic.
const BINS: usize = 1 << 14;
const RANGE: f64 = 8.0;
/// Chi-square bins are joined until this many are expected.
const LEAST_EXPECTED: f64 = 10.0;

/// What was counted.
pub(crate) struct Law {
    pub(crate) count: f64,
    /// Sums of the powers 1, 2, 3, 4 and 6.
    powers: [f64; 5],
    counts: Vec<u64>,
    /// Beyond 3, 4, 5, 6 and 7 deviations.
    beyond: [u64; 5],
    pub(crate) largest: f64,
    /// Sums of products with the neighbour path, the next step, the first step of the last block, another process; and of
    /// their squares less one.
    products: [[f64; 2]; 4],
}

/// The probability below `x`, to all digits in both tails.
fn below(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

/// Of processes 0 and 1 of these paths, `10 blocks` steps each.
pub(crate) fn measure(seed: u64, paths: u64, blocks: u64) -> Law {
    let mut law = Law {
        count: (2 * 10 * paths * blocks) as f64,
        powers: [0.0; 5],
        counts: vec![0; BINS + 2],
        beyond: [0; 5],
        largest: 0.0,
        products: [[0.0; 2]; 4],
    };
    let other = Normals::new(seed, 1, 0.01);
    let first = Normals::new(seed, 0, 0.01);
    let set = InstructionSet::best();
    let mut before = [[0.0; 16]; 10];
    for path in (0..paths).step_by(16) {
        let mut second = Vec::new();
        other.visit(path..path + 16, 0..blocks, set, |drawn| second.push(*drawn));
        let mut partners = second.iter();
        first.visit(path..path + 16, 0..blocks, set, |drawn| {
            let partner = partners.next().unwrap();
            law.add(drawn);
            law.add(partner);
            let mut sums = [[0.0; 2]; 4];
            for k in 0..10 {
                for i in 0..16 {
                    let x = drawn[k][i];
                    let pairs = [drawn[k][i ^ 1], drawn[(k + 1) % 10][i], before[k][i], partner[k][i]];
                    for (sums, y) in sums.iter_mut().zip(pairs) {
                        sums[0] += x * y;
                        sums[1] += (x * x - 1.0) * (y * y - 1.0);
                    }
                }
            }
            for (total, sums) in law.products.iter_mut().flatten().zip(sums.iter().flatten()) {
                *total += sums;
            }
            before = *drawn;
        });
    }
    law
}

impl Law {
    fn add(&mut self, drawn: &[[f64; 16]; 10]) {
        let mut sums = [0.0; 5];
        let mut largest = 0.0_f64;
        for &x in drawn.iter().flatten() {
            let (square, size) = (x * x, x.abs());
            for (sum, power) in
                sums.iter_mut().zip([x, square, square * x, square * square, square * square * square])
            {
                *sum += power;
            }
            largest = largest.max(size);
            // 0 below all bins, BINS + 1 above.
            let place = ((x + RANGE) * (BINS as f64 / (2.0 * RANGE)) + 1.0).max(0.0) as usize;
            self.counts[place.min(BINS + 1)] += 1;
            if size > 3.0 {
                for (beyond, bound) in self.beyond.iter_mut().zip([3.0, 4.0, 5.0, 6.0, 7.0]) {
                    *beyond += u64::from(size > bound);
                }
            }
        }
        for (total, sum) in self.powers.iter_mut().zip(sums) {
            *total += sum;
        }
        self.largest = self.largest.max(largest);
    }

    /// Every statistic that is a standard normal if the numbers are: its name and value.
    pub(crate) fn deviations(&self) -> Vec<(&'static str, f64)> {
        let root = self.count.sqrt();
        // Means and variances of the powers: E x^2k = (2k - 1)!!.
        let exact =
            [("x", 0.0, 1.0), ("x²", 1.0, 2.0), ("x³", 0.0, 15.0), ("x⁴", 3.0, 96.0), ("x⁶", 15.0, 10170.0)];
        let mut all: Vec<_> = exact
            .iter()
            .zip(self.powers)
            .map(|(&(name, mean, variance), sum)| (name, (sum / root - mean * root) / f64::sqrt(variance)))
            .collect();
        // Each path with its neighbour is counted twice.
        let products = self.count / 2.0;
        let names = [
            ["paths", "paths, squares"],
            ["steps", "steps, squares"],
            ["blocks", "blocks, squares"],
            ["processes", "processes, squares"],
        ];
        for (i, (sums, names)) in self.products.iter().zip(names).enumerate() {
            let twice = if i == 0 { 2.0 } else { 1.0 };
            all.push((names[0], sums[0] / (twice * products).sqrt()));
            all.push((names[1], sums[1] / (twice * 4.0 * products).sqrt()));
        }
        let (chi_square, freedom) = self.chi_square();
        // Wilson and Hilferty (1931).
        let ninth = 2.0 / (9.0 * freedom);
        all.push(("chi-square", ((chi_square / freedom).cbrt() - 1.0 + ninth) / ninth.sqrt()));
        all
    }

    /// The statistic and its degrees of freedom.
    pub(crate) fn chi_square(&self) -> (f64, f64) {
        let edge = |bin: usize| -RANGE + bin as f64 * (2.0 * RANGE / BINS as f64);
        let (mut sum, mut freedom) = (0.0, -1.0);
        let (mut expected, mut counted) = (self.count * below(-RANGE), self.counts[0] as f64);
        let mut rest = [0.0; 2];
        for bin in 0..BINS {
            // From the tail that is nearer, where no digits cancel.
            let [a, b] = [edge(bin), edge(bin + 1)];
            let probability = if b <= 0.0 { below(b) - below(a) } else { below(-a) - below(-b) };
            expected += self.count * probability;
            counted += self.counts[bin + 1] as f64;
            if expected >= LEAST_EXPECTED {
                sum += (counted - expected).powi(2) / expected;
                freedom += 1.0;
                (expected, counted) = (0.0, 0.0);
            }
            rest = [expected, counted];
        }
        let [expected, counted] =
            [rest[0] + self.count * below(-RANGE), rest[1] + self.counts[BINS + 1] as f64];
        sum += (counted - expected).powi(2) / expected.max(LEAST_EXPECTED);
        (sum, freedom)
    }

    /// `√n sup |F_n - F|` over the edges of the bins, and the probability of more (Kolmogorov, 1933).
    pub(crate) fn kolmogorov_smirnov(&self) -> (f64, f64) {
        let (mut seen, mut largest) = (0, 0.0_f64);
        for bin in 0..=BINS {
            seen += self.counts[bin];
            let edge = -RANGE + bin as f64 * (2.0 * RANGE / BINS as f64);
            largest = largest.max((seen as f64 / self.count - below(edge)).abs());
        }
        let d = largest * self.count.sqrt();
        let terms = (1..20).map(|k| {
            let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
            sign * (-2.0 * f64::from(k * k) * d * d).exp()
        });
        (d, terms.sum())
    }

    /// Bound, numbers beyond it, expected number.
    pub(crate) fn tails(&self) -> [(f64, u64, f64); 5] {
        let bounds = [3.0, 4.0, 5.0, 6.0, 7.0];
        std::array::from_fn(|i| (bounds[i], self.beyond[i], 2.0 * self.count * below(-bounds[i])))
    }
}
