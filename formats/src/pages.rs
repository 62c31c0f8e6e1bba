//! Memory on huge pages, for large arrays that are read in no order: beside the caches such reads miss the
//! translation of addresses, which covers 512 times as much with pages of 2 MiB.

use bytemuck::Zeroable;

/// Bytes of a huge page.
const HUGE_PAGE: usize = 2 << 20;

/// The items in memory of their own, on huge pages where the system gives them to programs that ask (see
/// `huge_pages` in the limits of a recording).
pub fn on_huge_pages<T>(items: impl ExactSizeIterator<Item = T>) -> Vec<T> {
    let mut room = room_on_huge_pages(items.len());
    room.extend(items);
    room
}

/// Room for so many items, likewise.
pub fn room_on_huge_pages<T>(capacity: usize) -> Vec<T> {
    let room = Vec::with_capacity(capacity);
    ask_for_huge_pages(&room);
    room
}

/// Makes and touches room for so many items of any value, likewise.
pub fn make_room<T: Zeroable>(items: &mut Vec<T>, count: usize) {
    if items.capacity() < count {
        *items = room_on_huge_pages(count);
    }
    items.resize_with(count, T::zeroed);
}

/// Must be called before the memory is touched.
#[cfg(target_os = "linux")]
fn ask_for_huge_pages<T>(room: &Vec<T>) {
    use nix::sys::mman::{MmapAdvise, madvise};
    use std::ptr::NonNull;

    let start = room.as_ptr().addr();
    let first = start.next_multiple_of(HUGE_PAGE);
    let end = (start + room.capacity() * size_of::<T>()) / HUGE_PAGE * HUGE_PAGE;
    let Some(pages) = NonNull::new(room.as_ptr().cast_mut()) else { return };
    if first < end {
        // SAFETY: the pages lie between the ends of the vector's own memory, and this advice changes nothing of
        // what is in them. Where it is refused they are small ones.
        unsafe {
            let pages = pages.cast::<u8>().add(first - start).cast();
            let _is_given = madvise(pages, end - first, MmapAdvise::MADV_HUGEPAGE).is_ok();
        }
    }
}

#[cfg(not(target_os = "linux"))]
fn ask_for_huge_pages<T>(_room: &Vec<T>) {}
