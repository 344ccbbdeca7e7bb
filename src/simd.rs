//! Instruction sets: which the processor has, and kernels compiled for each of them.
//!
//! Every kernel gives the same bits under each set, so that the choice is one of speed alone.

/// An instruction set that kernels are compiled for, the widest last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Simd {
    /// What the target of the build has.
    Portable,
    /// AVX2 with FMA, BMI1, LZCNT and POPCNT.
    Avx2,
    /// The former with AVX-512 F, VL, DQ and BW.
    Avx512,
}

impl Simd {
    /// All that this processor has, the widest last.
    pub fn available() -> Vec<Simd> {
        let all = [Simd::Portable, Simd::Avx2, Simd::Avx512];
        let widest = supported();
        all.into_iter().filter(|simd| *simd <= widest).collect()
    }

    /// The widest that this processor has, or less where a test wants to compare.
    pub(crate) fn widest() -> Simd {
        #[cfg(test)]
        if let Some(forced) = test::forced() {
            return forced.min(supported());
        }
        supported()
    }
}

#[cfg(target_arch = "x86_64")]
fn supported() -> Simd {
    let has_avx2 = is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt");
    let has_avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw");
    match (has_avx2, has_avx512) {
        (true, true) => Simd::Avx512,
        (true, false) => Simd::Avx2,
        (false, _) => Simd::Portable,
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn supported() -> Simd {
    Simd::Portable
}

/// Calls an `#[inline(always)]` kernel of plain arrays, compiled for the widest instruction set.
///
/// `widest!(kernel(a: A, b: B) -> C)` takes the arguments from variables of the same names.
macro_rules! widest {
    ($kernel:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
            fn with_avx512($($argument: $type),*) $(-> $result)? {
                $kernel($($argument),*)
            }
            match $crate::simd::Simd::widest() {
                // SAFETY: `widest` names a set only where the processor has its features.
                $crate::simd::Simd::Avx512 => unsafe { with_avx512($($argument),*) },
                _ => $crate::simd::eight_wide!($kernel($($argument: $type),*) $(-> $result)?),
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        $kernel($($argument),*)
    }};
}
pub(crate) use widest;

/// As [`widest`], of a kernel of eight lanes, which AVX-512 has no use for.
macro_rules! eight_wide {
    ($kernel:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2")]
            fn with_avx2($($argument: $type),*) $(-> $result)? {
                $kernel($($argument),*)
            }
            match $crate::simd::Simd::widest() {
                $crate::simd::Simd::Portable => $kernel($($argument),*),
                // SAFETY: all wider sets have AVX2, too.
                _ => unsafe { with_avx2($($argument),*) },
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        $kernel($($argument),*)
    }};
}
pub(crate) use eight_wide;

#[cfg(test)]
pub(crate) mod test {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::Simd;

    /// Index into [`Simd::available`] and one more; for all threads: other tests may run narrower
    /// for a while, which changes nothing.
    static FORCED: AtomicUsize = AtomicUsize::new(0);

    pub(super) fn forced() -> Option<Simd> {
        match FORCED.load(Ordering::Relaxed) {
            0 => None,
            index => Simd::available().get(index - 1).copied(),
        }
    }

    /// Results of `f` under each instruction set that the processor has.
    pub(crate) fn under_each<T>(f: impl Fn() -> T) -> Vec<T> {
        let sets = 1..=Simd::available().len();
        let results = sets.map(|index| {
            FORCED.store(index, Ordering::Relaxed);
            f()
        });
        let results = results.collect();
        FORCED.store(0, Ordering::Relaxed);
        results
    }
}
