//! The memory that the system lets this process have, where it runs in a container or a service with a limit.

use std::path::Path;

/// Where control groups of version 2 are.
const GROUPS: &str = "/sys/fs/cgroup";

/// The least limit of the control groups that this process is in, in bytes; none where there is none, or the system has no
/// such groups. `/proc/meminfo` knows nothing of them.
pub fn memory_limit() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    limit_below(Path::new(GROUPS), &groups)
}

/// The least limit of `root` and of what is on the way to the group that `groups` names in its line `0::/NAME/…`. In a
/// container the root is its own group.
fn limit_below(root: &Path, groups: &str) -> Option<u64> {
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default();
    let on_the_way = Path::new(own).ancestors().map(|group| root.join(group).join("memory.max"));
    // Without a limit the file says `max`.
    let limit = |file| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
    on_the_way.filter_map(limit).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_limit_on_the_way_counts() {
        let root = tempfile::tempdir().unwrap();
        let group = root.path().join("system.slice/render.service");
        std::fs::create_dir_all(&group).unwrap();
        let limit = || limit_below(root.path(), "1:name=systemd:/x\n0::/system.slice/render.service\n");
        assert_eq!(limit(), None);
        std::fs::write(group.join("memory.max"), "max\n").unwrap();
        assert_eq!(limit(), None);
        std::fs::write(group.join("memory.max"), "8000\n").unwrap();
        std::fs::write(root.path().join("system.slice/memory.max"), "5000\n").unwrap();
        assert_eq!(limit(), Some(5000));
        std::fs::write(root.path().join("memory.max"), "3000\n").unwrap();
        assert_eq!((limit(), limit_below(root.path(), "")), (Some(3000), Some(3000)));
    }
}
