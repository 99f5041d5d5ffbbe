//! PNG files (W3C Portable Network Graphics, third edition): 8 bits for each of red, green, blue and opacity.

use miniz_oxide::deflate::compress_to_vec_zlib;

/// Each row is written as the difference to the row above it, which compresses well where colours are flat.
const UP: u8 = 2;
/// Of ten levels of compression.
const LEVEL: u8 = 6;

/// Encodes pixels, given row by row from the top.
pub(super) fn encode([width, height]: [usize; 2], pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut rows = Vec::with_capacity(height * (4 * width + 1));
    for (row, line) in pixels.chunks(width.max(1)).enumerate() {
        rows.push(UP);
        let above = row.checked_sub(1).map(|row| &pixels[row * width..]);
        for (column, pixel) in line.iter().enumerate() {
            let above = above.map_or([0; 4], |above| above[column]);
            rows.extend((0..4).map(|c| pixel[c].wrapping_sub(above[c])));
        }
    }
    let mut header: Vec<u8> = [width, height].iter().flat_map(|n| (*n as u32).to_be_bytes()).collect();
    // Bits, colours with opacity, and the only methods there are.
    header.extend([8, 6, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, b"IHDR", &header);
    chunk(&mut file, b"IDAT", &compress_to_vec_zlib(&rows, LEVEL));
    chunk(&mut file, b"IEND", &[]);
    file
}

fn chunk(file: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    file.extend((data.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(name);
    file.extend(data);
    let sum = checksum(&file[start..]);
    file.extend(sum.to_be_bytes());
}

/// The cyclic redundancy check of PNG.
fn checksum(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let mut table = [0u32; 256];
    for (start, entry) in (0u32..).zip(&mut table) {
        *entry = (0..8).fold(start, |x, _| if x & 1 == 1 { POLYNOMIAL ^ (x >> 1) } else { x >> 1 });
    }
    !bytes.iter().fold(!0u32, |sum, byte| table[usize::from(sum as u8 ^ byte)] ^ (sum >> 8))
}

#[cfg(test)]
mod tests {
    use super::checksum;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        // The usual check value, and the last chunk of every PNG file.
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
        assert_eq!(checksum(b"IEND"), 0xAE42_6082);
    }
}
