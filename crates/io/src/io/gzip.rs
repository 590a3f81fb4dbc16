//! Gzip-compressed mesh files.

use std::borrow::Cow;

use super::ReadError;

const MAGIC: &[u8] = b"\x1f\x8b";

/// Largest number of unpacked bytes: the first times the compressed bytes, or the second if more. Meshes expand 2 to 20
/// times.
const LIMIT: (usize, usize) = (200, 16 << 20);

pub(super) fn decompress(bytes: &[u8]) -> Result<Cow<'_, [u8]>, ReadError> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Cow::Borrowed(bytes));
    }
    decompress_within(bytes, LIMIT.1.max(bytes.len().saturating_mul(LIMIT.0))).map(Cow::Owned)
}

#[cfg(not(feature = "gzip"))]
fn decompress_within(_: &[u8], _: usize) -> Result<Vec<u8>, ReadError> {
    Err(ReadError::file("this build reads no gzip", "build with the feature gzip or unpack the file"))
}

// Bytes after the last member are padding.
#[cfg(feature = "gzip")]
fn decompress_within(bytes: &[u8], most: usize) -> Result<Vec<u8>, ReadError> {
    use crate::mesh::fallible_allocation::with_fallible_allocation;
    use std::io::Read;
    let (mut out, mut rest) = (Vec::new(), bytes);
    // A file may have several members; their contents are concatenated.
    while rest.starts_with(MAGIC) {
        let mut decoder = flate2::bufread::GzDecoder::new(rest);
        // One byte more than allowed shows that the limit is passed.
        let room = (most - out.len()) as u64 + 1;
        let damaged = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::OutOfMemory => super::memory::io_error(error),
            _ => ReadError::file(format!("the gzip data is cut or damaged ({error})"), "fetch the file again"),
        };
        with_fallible_allocation(|| decoder.by_ref().take(room).read_to_end(&mut out)).map_err(damaged)?;
        // A small file could otherwise fill the memory.
        if out.len() > most {
            let what = format!("the gzip data unpacks to more than {most} bytes");
            return Err(ReadError::file(what, "if you trust the file, unpack it first"));
        }
        rest = decoder.into_inner();
    }
    Ok(out)
}

/// Compresses bytes; equal input gives equal output.
#[cfg(feature = "gzip")]
pub(super) fn compress(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut encoder, bytes)?;
    encoder.finish()
}

#[cfg(not(feature = "gzip"))]
pub(super) fn compress(_: &[u8]) -> std::io::Result<Vec<u8>> {
    Err(std::io::Error::other("this build writes no gzip"))
}

#[cfg(feature = "gzip")]
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_and_padding() {
        let text = b"v 0 0 0\n".repeat(1000);
        let one = compress(&text).unwrap();
        assert!(one.len() < text.len() / 10);
        assert_eq!(*decompress(&one).unwrap(), text);
        let two = [&one[..], &one, &[0; 7]].concat();
        assert_eq!(*decompress(&two).unwrap(), [&text[..], &text].concat());
        assert_eq!(*decompress(&text).unwrap(), text);
    }

    #[test]
    fn cut_damaged_and_boundless_data_is_refused_in_one_line() {
        let bytes = compress(&[0; 100_000]).unwrap();
        assert_eq!(decompress_within(&bytes, 100_000).unwrap().len(), 100_000);
        let mut damaged = bytes.clone();
        damaged[20] ^= 0xff;
        for error in [
            decompress_within(&bytes, 99_999).unwrap_err(),
            decompress(&bytes[..bytes.len() - 1]).unwrap_err(),
            decompress(&bytes[..7]).unwrap_err(),
            decompress(&damaged).unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(text.starts_with("the gzip data ") && !text.contains('\n'), "{text}");
        }
    }

    #[test]
    fn a_bomb_does_not_fill_the_memory() {
        let bomb = compress(&vec![0; LIMIT.1 + 1]).unwrap();
        assert!(bomb.len() * LIMIT.0 < LIMIT.1);
        assert!(decompress(&bomb).unwrap_err().to_string().contains("unpacks to more than"));
    }
}
