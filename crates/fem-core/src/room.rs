//! Room for large arrays, asked for before they are made, so that a lack of memory is an error and no abort.

/// Says whether this many bytes can be allocated at this moment. They are given back at once.
///
/// If the system promises more memory than it has, the answer is yes.
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
