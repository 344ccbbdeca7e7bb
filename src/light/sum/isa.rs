//! Which of the compiled kernels the processor can run.

/// Instruction sets that kernels are compiled for; all give the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Isa {
    Plain,
    Avx2,
    Avx512,
}

/// The widest that this processor has; asked once.
#[cfg(target_arch = "x86_64")]
pub(crate) fn detected() -> Isa {
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
