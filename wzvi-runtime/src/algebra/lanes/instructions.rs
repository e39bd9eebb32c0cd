//! The instruction set, chosen at run time on the outermost loop.
//!
//! A default build is for the oldest processor of its target. The loops of an ensemble are compiled once for
//! each of the instruction sets here, and the best one of the machine is used. The results do not depend on
//! it: no operation rounds differently, and nothing is fused.

/// A set of vector instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// The instructions of every processor of the target.
    Baseline,
    /// Registers of four numbers (x86-64 since about 2013).
    Avx2,
    /// Registers of eight numbers.
    Avx512,
}

impl InstructionSet {
    /// The best one of this machine.
    pub fn best() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|set| set.is_available()).unwrap_or(Self::Baseline)
    }

    /// Whether this machine has it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Baseline => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => std::arch::is_x86_feature_detected!("avx2"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                std::arch::is_x86_feature_detected!("avx512f")
                    && std::arch::is_x86_feature_detected!("avx512dq")
                    && std::arch::is_x86_feature_detected!("avx512bw")
                    && std::arch::is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            _ => false,
        }
    }

    /// The first set with groups of so many numbers, or this one.
    pub(crate) fn for_numbers(self, numbers: u64) -> Self {
        let widths = [(Self::Baseline, 4), (Self::Avx2, 8)];
        let narrow =
            widths.into_iter().find(|(set, width)| *set < self && numbers <= *width && set.is_available());
        narrow.map_or(self, |(set, _)| set)
    }

    /// This set, or AVX2 where so many numbers fill no more than one of its registers. Given wider registers,
    /// the compiler fills them with numbers of several lists, and moves these more than it computes.
    pub(crate) fn for_list(self, numbers: usize) -> Self {
        if self == Self::Avx512 && numbers <= 4 && Self::Avx2.is_available() { Self::Avx2 } else { self }
    }

    /// This set, or AVX2 where loops over so many numbers would be short: the compiler unrolls them by four
    /// registers, and takes the rest one by one. From 128 on, four turns of such a loop, chains with sines
    /// are faster in the wider registers, and chains without as fast.
    pub(crate) fn for_loop(self, numbers: usize) -> Self {
        if self == Self::Avx512 && numbers < 128 && Self::Avx2.is_available() { Self::Avx2 } else { self }
    }

    /// Runs the kernel with these instructions, or with those of the baseline where the machine does not have
    /// them, and in builds with debug assertions.
    // A function of its own would copy kernels that registers do not hold.
    #[inline]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
        if self.is_available() {
            match self {
                Self::Baseline => {}
                Self::Avx2 => return x86::avx2(kernel),
                Self::Avx512 => return x86::avx512(kernel),
            }
        }
        kernel.run::<4, 2>()
    }
}

/// Work that is compiled for every instruction set: `run` and all functions that it calls on its way are
/// `#[cfg_attr(not(debug_assertions), inline(always))]`. With debug assertions nothing is inlined by that,
/// other instructions would not reach the inner loops, and the work is compiled for the baseline only.
///
/// Closures cannot have that attribute. One that is called in a single place is inlined anyway, and so
/// compiled for the same instructions. This is why each instruction set has a width of its own. Where a
/// closure would be called in several places, a function or a method of a trait takes its place. `map` and
/// `from_fn` of arrays and folds over `a..=b` call theirs in several places. `.ci/instructions` finds those
/// that were left.
pub trait Kernel {
    /// The result.
    type Output;
    /// Does the work with `L` numbers side by side, enough to hide the latency of one operation; or with
    /// `HALF` of them where each needs more registers.
    fn run<const L: usize, const HALF: usize>(self) -> Self::Output;
}

#[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
#[expect(
    unsafe_code,
    reason = "a call of code for other instructions than those of its caller; the only unsafe code of the workspace"
)]
mod x86 {
    use super::Kernel;

    /// Only after `InstructionSet::Avx2.is_available()`.
    pub(super) fn avx2<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx2")]
        fn run<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<8, 4>()
        }
        // SAFETY: the machine has these instructions; its caller has asked.
        unsafe { run(kernel) }
    }

    /// Only after `InstructionSet::Avx512.is_available()`.
    pub(super) fn avx512<K: Kernel>(kernel: K) -> K::Output {
        #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl")]
        fn run<K: Kernel>(kernel: K) -> K::Output {
            kernel.run::<32, 16>()
        }
        // SAFETY: the machine has these instructions; its caller has asked.
        unsafe { run(kernel) }
    }
}
