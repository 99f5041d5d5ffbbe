//! Checks for memory before large arrays are allocated, so that a lack of memory is an error and not an abort.

/// Tells whether this many bytes can be allocated now. They are released at once.
///
/// If the system overcommits memory, the result is `true`.
pub fn has_room_for(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
}

#[cfg(test)]
mod tests {
    use super::has_room_for;

    #[test]
    fn more_than_can_be_addressed_has_no_room() {
        assert!(has_room_for(0) && has_room_for(1 << 10));
        assert!(!has_room_for(usize::MAX) && !has_room_for(isize::MAX as usize));
    }
}
