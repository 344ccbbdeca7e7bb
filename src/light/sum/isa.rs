//! Which of the compiled kernels the processor can run.

/// Instruction sets that kernels are compiled for; all give the same bits.
#[cfg(target_arch = "x86_64")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Isa {
    Plain,
    Avx2,
    Avx512,
}

/// The widest that this processor has, or less where a test wants to compare.
#[cfg(target_arch = "x86_64")]
pub(crate) fn detected() -> Isa {
    #[cfg(test)]
    if let Some(forced) = test::forced() {
        return forced.min(supported());
    }
    supported()
}

#[cfg(target_arch = "x86_64")]
fn supported() -> Isa {
    let has_avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw");
    if has_avx512 {
        Isa::Avx512
    } else if is_x86_feature_detected!("avx2") {
        Isa::Avx2
    } else {
        Isa::Plain
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
pub(crate) mod test {
    use std::sync::atomic::{AtomicU8, Ordering};

    use super::Isa;

    /// For all threads: other tests may run narrower for a while, which changes nothing.
    static FORCED: AtomicU8 = AtomicU8::new(0);
    const ALL: [Isa; 3] = [Isa::Plain, Isa::Avx2, Isa::Avx512];

    pub(super) fn forced() -> Option<Isa> {
        let index = FORCED.load(Ordering::Relaxed);
        ALL.get(usize::from(index).wrapping_sub(1)).copied()
    }

    /// Results of `f` under each instruction set that the processor has.
    pub(crate) fn under_each<T>(f: impl Fn() -> T) -> Vec<T> {
        let results = (1..=3u8).map(|index| {
            FORCED.store(index, Ordering::Relaxed);
            f()
        });
        let results = results.collect();
        FORCED.store(0, Ordering::Relaxed);
        results
    }
}
