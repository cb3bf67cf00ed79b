//! Large blocks of memory: in huge pages where the system has them, and not given back at once.
//!
//! A reconstruction makes and drops hundreds of planes of the picture. In pages of 4 KiB the system spends up to a fifth of
//! the time giving and clearing them.

#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};

/// Blocks from this size on, in bytes: two huge pages, so that half of what is asked for lies in whole ones.
const LARGE: usize = 4 << 20;

/// Blocks up to this size, in bytes, come from what was freed: the most that can be asked for. Larger ones are given back.
pub const KEPT_BLOCK: usize = 32 << 20;

/// The system's allocator, which asks for huge pages for large blocks.
pub struct HugePages;

// SAFETY: every block is the system allocator's, which gets every layout as it is; advice changes neither addresses nor
// contents.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps to the contract of `GlobalAlloc`, which is the system's, too.
        advise(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        advise(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        advise(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

/// Asks for huge pages for `block` if it is large, and returns it.
#[inline]
fn advise(block: *mut u8, size: usize) -> *mut u8 {
    if size >= LARGE && !block.is_null() {
        ask_for_huge_pages(block, size);
    }
    block
}

#[cfg(target_os = "linux")]
#[cold]
fn ask_for_huge_pages(block: *mut u8, size: usize) {
    /// Smallest page there is; on systems with larger ones, advice for a block that begins within one is refused.
    const PAGE: usize = 4096;
    let within = block.align_offset(PAGE);
    let pages = (size - within) / PAGE * PAGE;
    // SAFETY: the pages lie within the block, which belongs to the caller and which nobody else knows yet. A refusal is
    // no fault: the block is as good in small pages.
    unsafe { libc::madvise(block.add(within).cast(), pages, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_huge_pages(_: *mut u8, _: usize) {}

/// Keeps some of what is freed for what is asked for next, where the system's allocator can be told so.
pub fn keep_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        /// Free memory that may be kept at the end of what is used, in bytes.
        const KEPT: libc::c_int = 64 << 20;
        // SAFETY: the first thing the program does, before there are other threads. A refusal changes nothing.
        unsafe {
            libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
            libc::mallopt(libc::M_MMAP_THRESHOLD, KEPT_BLOCK as libc::c_int);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_blocks_hold_what_blocks_hold() {
        let mut block = vec![0_u8; 2 * LARGE];
        assert!(block.iter().all(|byte| *byte == 0));
        block.iter_mut().enumerate().for_each(|(i, byte)| *byte = i as u8);
        block.resize(5 * LARGE, 7);
        block.truncate(LARGE + 1);
        block.shrink_to_fit();
        assert!(block.iter().enumerate().all(|(i, byte)| *byte == i as u8));
        let aligned = Layout::from_size_align(2 * LARGE, 1 << 16).unwrap();
        // SAFETY: the layout has a size, and the block goes back with the same.
        unsafe {
            let block = HugePages.alloc_zeroed(aligned);
            assert!(block.addr().is_multiple_of(1 << 16) && *block.add(2 * LARGE - 1) == 0);
            HugePages.dealloc(block, aligned);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_system_is_asked_for_huge_pages() {
        if !std::path::Path::new("/sys/kernel/mm/transparent_hugepage").exists() {
            return;
        }
        let block = vec![1_u8; 16 * LARGE];
        assert!(is_asked_for(&block[8 * LARGE]));
    }

    /// Whether the flags of the mapping that `byte` lies in say so.
    #[cfg(target_os = "linux")]
    fn is_asked_for(byte: &u8) -> bool {
        let (address, maps) = (std::ptr::from_ref(byte).addr(), std::fs::read_to_string("/proc/self/smaps").unwrap());
        let range = |line: &str| {
            let (from, to) = line.split_whitespace().next()?.split_once('-')?;
            Some(usize::from_str_radix(from, 16).ok()?..usize::from_str_radix(to, 16).ok()?)
        };
        let mut lines = maps.lines().skip_while(|line| !range(line).is_some_and(|range| range.contains(&address)));
        let flags = lines.find_map(|line| line.strip_prefix("VmFlags:")).unwrap();
        flags.split_whitespace().any(|flag| flag == "hg")
    }
}
