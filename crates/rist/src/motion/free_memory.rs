//! How much memory the machine has free, as Linux says it; elsewhere nobody knows.
//!
//! What a process may take is what the machine has available (`MemAvailable` of /proc/meminfo), and no more than what its group
//! is left (`memory.max` less `memory.current` of a control group, version 2, in which files that the kernel would drop first do
//! not count: `inactive_file` of memory.stat). No result hangs on it: it only tells a choice
//! that would end without memory from one that would not.

use std::path::Path;

use gate::source;

/// Longest of these files, bytes.
const MOST_BYTES: usize = 1 << 16;

/// Bytes that a process may still take; `None` where nothing says so.
pub(crate) fn free_bytes() -> Option<f64> {
    let text = |path: &str| String::from_utf8(source::told_by_system(Path::new(path), MOST_BYTES).ok()?).ok();
    let of_machine = text("/proc/meminfo").and_then(|told| available(&told));
    let group = |name: &str| text(&format!("/sys/fs/cgroup/{name}"))?.trim().parse::<f64>().ok();
    let files = text("/sys/fs/cgroup/memory.stat").and_then(|told| inactive_files(&told)).unwrap_or(0.0);
    let of_group =
        group("memory.max").zip(group("memory.current")).map(|(most, taken)| (most - taken + files).max(0.0));
    [of_machine, of_group].into_iter().flatten().reduce(f64::min)
}

/// What /proc/meminfo says is available, bytes.
fn available(meminfo: &str) -> Option<f64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// What memory.stat says of files that nobody uses, bytes.
fn inactive_files(stat: &str) -> Option<f64> {
    stat.lines().find_map(|line| line.strip_prefix("inactive_file "))?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_available_is_read() {
        let told =
            "MemTotal:       16384000 kB\nMemFree:          203040 kB\nMemAvailable:    8000000 kB\nBuffers: 1 kB\n";
        assert_eq!(available(told), Some(8.192e9));
        assert_eq!(available("MemTotal: 1 kB\n"), None);
        assert_eq!(available("MemAvailable: much kB\n"), None);
        assert_eq!(inactive_files("anon 5\nfile 7\ninactive_file 4096\n"), Some(4096.0));
        assert_eq!(inactive_files("file 7\n"), None);
        // Linux says what there is.
        let free = free_bytes();
        assert!(free.map_or(!cfg!(target_os = "linux"), |free| free > 1e6 && free < 1e15), "{free:?}");
    }
}
