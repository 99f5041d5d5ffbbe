//! Large arrays in large pages.

use super::CholeskyError;
use memmap2::MmapMut;
use std::ops::{Deref, DerefMut};

/// Arrays of fewer bytes come from the allocator, which may have used memory for them.
const LARGE: usize = 4 << 20;

/// Values in memory that is asked for in large pages (Linux; 2 MiB on most processors). The first access to a page of 4 KiB costs as
/// much time as several thousand operations, and all pages of a large array are new.
#[derive(Debug)]
pub(super) enum Pages {
    Small(Vec<f64>),
    Large { map: MmapMut, bytes: usize },
}

impl Pages {
    /// Allocates zeros, without touching them if they are many.
    pub(super) fn zeros(count: usize, dimension: usize) -> Result<Self, CholeskyError> {
        let refused = CholeskyError::OutOfMemory { dimension };
        let Some(bytes) = count.checked_mul(size_of::<f64>()) else { return Err(refused) };
        if bytes < LARGE {
            return Ok(Self::Small(vec![0.0; count]));
        }
        let map = MmapMut::map_anon(bytes).map_err(|_| refused)?;
        // A system without large pages refuses. Its other pages do as well.
        #[cfg(target_os = "linux")]
        map.advise(memmap2::Advice::HugePage).ok();
        Ok(Self::Large { map, bytes })
    }
}

impl Deref for Pages {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            Self::Small(values) => values,
            Self::Large { map, bytes } => bytemuck::cast_slice(&map[..*bytes]),
        }
    }
}

impl DerefMut for Pages {
    fn deref_mut(&mut self) -> &mut [f64] {
        match self {
            Self::Small(values) => values,
            Self::Large { map, bytes } => bytemuck::cast_slice_mut(&mut map[..*bytes]),
        }
    }
}
