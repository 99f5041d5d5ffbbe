//! Checks for memory before large arrays are allocated, so that a lack of memory is an error and not an abort.

/// Tells whether this many bytes can be allocated now. They are released at once.
///
/// If the system overcommits memory, the result is `true`.
pub fn fits_in_memory(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
}

#[cfg(test)]
mod tests {
    use super::fits_in_memory;

    #[test]
    fn more_than_can_be_addressed_does_not_fit() {
        assert!(fits_in_memory(0) && fits_in_memory(1 << 10));
        assert!(!fits_in_memory(usize::MAX) && !fits_in_memory(isize::MAX as usize));
    }
}
