//! Reads the free memory of the machine from files of Linux. On other systems the free memory is unknown.
//!
//! A process may use the available memory of the machine (`MemAvailable` of /proc/meminfo), but at most the free memory of its
//! control group, version 2: `memory.max` - `memory.current` + `inactive_file` of memory.stat (the kernel drops these files
//! first). The free memory changes no result. It is used only to refuse a request that would run out of memory.

use std::path::Path;

use gate::source;

/// Largest number of bytes that is read of a system file.
const LARGEST_FILE_BYTES: usize = 1 << 16;

/// Memory that the process may still use, bytes; `None` if this number is unknown.
pub(crate) fn free_bytes() -> Option<f64> {
    let text = |path: &str| String::from_utf8(source::system_file_head(Path::new(path), LARGEST_FILE_BYTES).ok()?).ok();
    let of_machine = text("/proc/meminfo").and_then(|content| available(&content));
    let group = |name: &str| text(&format!("/sys/fs/cgroup/{name}"))?.trim().parse::<f64>().ok();
    let files = text("/sys/fs/cgroup/memory.stat").and_then(|content| inactive_files(&content)).unwrap_or(0.0);
    let of_group =
        group("memory.max").zip(group("memory.current")).map(|(most, taken)| (most - taken + files).max(0.0));
    [of_machine, of_group].into_iter().flatten().reduce(f64::min)
}

/// The available memory by the text of /proc/meminfo, bytes.
fn available(meminfo: &str) -> Option<f64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// The memory of inactive files by the text of memory.stat, bytes.
fn inactive_files(stat: &str) -> Option<f64> {
    stat.lines().find_map(|line| line.strip_prefix("inactive_file "))?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_available_is_read() {
        let content =
            "MemTotal:       16384000 kB\nMemFree:          203040 kB\nMemAvailable:    8000000 kB\nBuffers: 1 kB\n";
        assert_eq!(available(content), Some(8.192e9));
        assert_eq!(available("MemTotal: 1 kB\n"), None);
        assert_eq!(available("MemAvailable: much kB\n"), None);
        assert_eq!(inactive_files("anon 5\nfile 7\ninactive_file 4096\n"), Some(4096.0));
        assert_eq!(inactive_files("file 7\n"), None);
        // On Linux the free memory must be known.
        let free = free_bytes();
        assert!(free.map_or(!cfg!(target_os = "linux"), |free| free > 1e6 && free < 1e15), "{free:?}");
    }
}
