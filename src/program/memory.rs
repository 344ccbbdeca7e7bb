//! What the process uses, and what it may use.

/// Largest resident memory so far, MB of 10⁶ bytes; `None` where the system has no `/proc`.
pub fn peak_mb() -> Option<f64> {
    Some(bytes_of("/proc/self/status", "VmHWM:")? as f64 * 1e-6)
}

/// Resident memory now, bytes; `None` where the system has no `/proc`.
pub fn resident() -> Option<usize> {
    bytes_of("/proc/self/status", "VmRSS:")
}

/// What the program may use unless its user says otherwise: three quarters of the machine's memory,
/// or 4 GB where the system does not tell.
pub fn default_limit() -> usize {
    limit_of(bytes_of("/proc/meminfo", "MemTotal:"))
}

fn limit_of(machine: Option<usize>) -> usize {
    machine.map_or(4_000_000_000, |bytes| bytes / 4 * 3)
}

/// Bytes as people read them.
pub fn in_words(bytes: usize) -> String {
    format!("{:.1} GB", bytes as f64 * 1e-9)
}

fn bytes_of(file: &str, name: &str) -> Option<usize> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kib: usize = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_the_machine_is_left_to_others() {
        assert_eq!(limit_of(Some(16 << 30)), 12 << 30);
        assert_eq!(limit_of(None), 4_000_000_000);
        if cfg!(target_os = "linux") {
            let machine = bytes_of("/proc/meminfo", "MemTotal:").unwrap();
            assert_eq!(default_limit(), limit_of(Some(machine)));
        }
    }
}
