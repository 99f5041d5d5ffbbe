//! How much memory this process may still take: from the limits of its address space and control groups, and what the
//! machine has free. Everything comes from the kernel's tables; what they do not say is not a limit. Nothing here asks: a [`crate::Host`]
//! answers with it.

use crate::host::MemoryLimit;
use crate::memory::mebibytes;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the largest amount of memory that this process has had, bytes, if the system tells it.
pub fn peak() -> Option<u64> {
    size(Path::new("/proc/self/status"), "VmHWM:")
}

/// Returns the name of the machine.
pub fn host() -> String {
    let name = fs::read_to_string("/proc/sys/kernel/hostname");
    name.map_or_else(|_| "unknown".into(), |name| name.trim().into())
}

/// Finds the smallest limit.
///
/// * `threads`: that compute.
pub fn smallest(threads: usize) -> Option<MemoryLimit> {
    let resident = size(Path::new("/proc/self/status"), "VmRSS:").unwrap_or(0) as f64;
    let all = [address_space(threads, resident), control_groups(resident), machine(resident)];
    all.into_iter().flatten().min_by(|a, b| a.bytes.total_cmp(&b.bytes))
}

fn limit_of(bytes: f64, words: impl FnOnce(String) -> String, fix: Option<&'static str>) -> MemoryLimit {
    let bytes = bytes.max(0.0);
    MemoryLimit::new(bytes, words(mebibytes(bytes)), fix)
}

/// Says why the limit of the address space has no room to start threads; `None` if it has. Each takes its stack, and the allocator
/// reserves an arena for it, for a moment two: which thread fails in too little room is a matter of chance.
///
/// * `stack`: of each thread, bytes.
pub fn no_room_for_threads(threads: usize, stack: usize) -> Option<String> {
    let needed = threads as f64 * (stack as f64 + 2.0 * ARENA);
    let room = address_space(0, 0.0).filter(|room| room.bytes < needed)?;
    Some(format!("about {} are needed to start them; {}", mebibytes(needed), room.words))
}

/// The room below `RLIMIT_AS`, which counts what is reserved, used or not.
fn address_space(threads: usize, resident: f64) -> Option<MemoryLimit> {
    let table = fs::read_to_string("/proc/self/limits").ok()?;
    let limit: f64 = soft_limit(&table, "Max address space")? as f64;
    let taken = size(Path::new("/proc/self/status"), "VmSize:")? as f64 - resident;
    let words = |left| format!("the limit of the address space (ulimit -v) leaves {left}");
    let fix = "raise that limit, or use --threads 1: each thread reserves address space";
    Some(limit_of(limit - taken - threads as f64 * reserved_by_thread(), words, Some(fix)))
}

/// What the allocator reserves for the memory of a thread, bytes.
const ARENA: f64 = 64.0 * 1048576.0;

/// Reads a soft limit; `None` if it is unlimited.
fn soft_limit(table: &str, name: &str) -> Option<u64> {
    table.lines().find_map(|line| line.strip_prefix(name))?.split_whitespace().next()?.parse().ok()
}

/// Estimates the address space that a thread will reserve and hardly use, bytes: an arena of the allocator, and the packing buffers of
/// the dense kernels, twice the largest cache.
fn reserved_by_thread() -> f64 {
    const CACHE: f64 = 32.0 * 1048576.0;
    let text = fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size").ok();
    let cache = text.and_then(|text| text.trim().strip_suffix('K')?.parse::<f64>().ok());
    ARENA + 2.0 * cache.map_or(CACHE, |kibibytes| 1024.0 * kibibytes)
}

/// A version of control groups: its mark in `/proc/self/cgroup`, where it is mounted, and its files.
struct Version {
    mark: fn(&str) -> Option<&str>,
    mounts: &'static [&'static str],
    limit: &'static str,
    usage: &'static str,
    /// In `memory.stat`: the file cache, which the kernel gives up when memory is asked for.
    cache: &'static str,
}

const VERSIONS: [Version; 2] = [
    Version {
        mark: |line| line.strip_prefix("0::"),
        mounts: &["/sys/fs/cgroup", "/sys/fs/cgroup/unified"],
        limit: "memory.max",
        usage: "memory.current",
        cache: "file",
    },
    Version {
        mark: |line| {
            let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
            controllers.split(',').any(|name| name == "memory").then_some(path)
        },
        mounts: &["/sys/fs/cgroup/memory"],
        limit: "memory.limit_in_bytes",
        usage: "memory.usage_in_bytes",
        cache: "total_cache",
    },
];

fn control_groups(resident: f64) -> Option<MemoryLimit> {
    let table = fs::read_to_string("/proc/self/cgroup").ok()?;
    let left = |version: &Version| {
        let path = table.lines().find_map(version.mark)?;
        let mounts = version.mounts.iter().map(Path::new);
        mounts.filter_map(|mount| left_in_groups(version, mount, path, resident)).reduce(f64::min)
    };
    let bytes = VERSIONS.iter().filter_map(left).reduce(f64::min)?;
    Some(limit_of(bytes, |left| format!("the limit of the control group leaves {left}"), None))
}

/// Returns the least memory that the limits of a group and of the groups above it leave for this process, bytes.
///
/// * `path`: of the group below its mount. In a container the mount may be the group itself: then the parts of the path that
///   do not exist there are skipped.
fn left_in_groups(version: &Version, mount: &Path, path: &str, resident: f64) -> Option<f64> {
    let own: PathBuf = mount.join(path.trim_start_matches('/'));
    let groups = own.ancestors().take_while(|group| group.starts_with(mount));
    let left = groups.filter_map(|group| {
        let number = |file| fs::read_to_string(group.join(file)).ok()?.trim().parse::<f64>().ok();
        let limit = number(version.limit)?;
        let usage = number(version.usage).unwrap_or(0.0);
        let table = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
        let cache = table
            .lines()
            .find_map(|line| line.strip_prefix(version.cache)?.strip_prefix(' ')?.trim().parse::<f64>().ok());
        let others = (usage - cache.unwrap_or(0.0) - resident).max(0.0);
        Some(limit - others)
    });
    left.reduce(f64::min)
}

/// Returns the memory that this process has or can get, file caches included: beyond it a run would only swap.
fn machine(resident: f64) -> Option<MemoryLimit> {
    let free = size(Path::new("/proc/meminfo"), "MemAvailable:")? as f64;
    Some(limit_of(free + resident, |left| format!("this machine has {left} free"), None))
}

/// Reads a size, which the kernel gives in kibibytes, from one of its tables; in bytes.
fn size(table: &Path, head: &str) -> Option<u64> {
    let text = fs::read_to_string(table).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(head))?;
    let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_groups_above_count_and_caches_do_not() {
        let [two, one] = &VERSIONS;
        assert_eq!(["9:name=systemd:/", "0::/a/b"].iter().find_map(|l| (two.mark)(l)), Some("/a/b"));
        let lines = ["0::/", "7:blkio:/x", "4:cpu,memory:/job/step"];
        assert_eq!(lines.iter().find_map(|l| (one.mark)(l)), Some("/job/step"));
        let temp = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let path = temp.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        put("job/step/memory.max", "max\n");
        put("job/memory.max", "1000\n");
        put("job/memory.current", "700\n");
        put("job/memory.stat", "anon 200\nfile 500\nfile_dirty 9\n");
        assert_eq!(left_in_groups(two, temp.path(), "/job/step", 50.0), Some(850.0));
        // The path of the host, seen from inside a container.
        put("memory.max", "300\n");
        assert_eq!(left_in_groups(two, temp.path(), "/machine/elsewhere", 50.0), Some(300.0));
        assert_eq!(left_in_groups(one, temp.path(), "/job/step", 50.0), None);
    }

    #[test]
    fn an_unlimited_address_space_is_no_limit() {
        let table = "Limit  Soft Limit  Hard Limit  Units\nMax cpu time    unlimited  unlimited  seconds\n\
                     Max address space  409600000  unlimited  bytes\n";
        assert_eq!(soft_limit(table, "Max address space"), Some(409_600_000));
        assert_eq!(soft_limit(table, "Max cpu time"), None);
    }
}
