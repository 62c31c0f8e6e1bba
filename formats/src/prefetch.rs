//! Asks for memory ahead of its use, where neighbouring items lie far apart.

use crate::length_table::LengthTable;

/// How many items ahead: a miss takes about as long as moving so many.
pub const AHEAD: usize = 32;

/// Asks for the cache line in which a value begins.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    prefetch_line(std::ptr::from_ref(value).cast());
}

/// The same for a value by its index. There need not be such a value.
#[inline(always)]
pub fn prefetch_at<T>(values: &[T], index: usize) {
    prefetch_line(values.as_ptr().wrapping_add(index).cast());
}

/// The same for a value that is written next: its line comes as the only copy, where another core has one. A store
/// would have to ask for that by itself, and keep all later ones waiting.
#[allow(
    clippy::pointers_in_nomem_asm_block,
    reason = "a prefetch neither reads nor writes what it points to"
)]
#[inline(always)]
pub fn prefetch_to_write<T>(values: &[T], index: usize) {
    let address = values.as_ptr().wrapping_add(index);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: this changes nothing that a program can see, whatever the address; x86-64 processors that do not have
    // the instruction pass over it.
    unsafe {
        std::arch::asm!("prefetchw [{}]", in(reg) address, options(nostack, preserves_flags, nomem));
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

/// Asks for all cache lines of a value by its index. There need not be such a value.
#[inline(always)]
pub fn prefetch_whole_at<T>(values: &[T], index: usize) {
    let start: *const u8 = values.as_ptr().wrapping_add(index).cast();
    (0..size_of::<T>()).step_by(64).for_each(|at| prefetch_line(start.wrapping_add(at)));
}

#[inline(always)]
fn prefetch_line(address: *const u8) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch changes nothing that a program can see, whatever the address, and every x86-64 processor
    // has it.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(address.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = address;
}

/// Asks for a cell of a length table.
#[inline(always)]
pub fn prefetch_cell(table: &LengthTable, cell: u32) {
    prefetch(table.cell(cell));
}
