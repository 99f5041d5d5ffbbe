//! Large arrays in large pages.

use super::CholeskyError;
use memmap2::MmapMut;
use std::ops::{Deref, DerefMut};

/// Values in memory of their own. On Linux it is asked for in large pages (2 MiB on most processors): the first access to a page of
/// 4 KiB costs as much time as several thousand operations, and all pages of a factor are new.
#[derive(Debug)]
pub(super) struct Pages {
    map: MmapMut,
    count: usize,
}

impl Pages {
    /// Allocates zeros without touching them.
    pub(super) fn zeros(count: usize, dimension: usize) -> Result<Self, CholeskyError> {
        let refused = CholeskyError::OutOfMemory { dimension };
        let Some(bytes) = count.checked_mul(size_of::<f64>()) else { return Err(refused) };
        let map = MmapMut::map_anon(bytes).map_err(|_| refused)?;
        #[cfg(target_os = "linux")]
        // A system without large pages refuses; its other pages do as well.
        map.advise(memmap2::Advice::HugePage).ok();
        Ok(Self { map, count })
    }
}

impl Deref for Pages {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        bytemuck::cast_slice(&self.map[..self.count * size_of::<f64>()])
    }
}

impl DerefMut for Pages {
    fn deref_mut(&mut self) -> &mut [f64] {
        bytemuck::cast_slice_mut(&mut self.map[..self.count * size_of::<f64>()])
    }
}
