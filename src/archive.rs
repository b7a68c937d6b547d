//! ZIP containers: bounded reading of files from strangers, reproducible writing of our own.

use crate::error::Fault;
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipArchive, ZipWriter};

/// Content may unpack to this many times the size of its file ...
pub const EXPANSION: u64 = 64;
/// ... or to this many bytes if that is more: a flat 4096 x 4096 map of f64 compresses 1000 to 1 and fits.
const FLOOR_BYTES: u64 = 256 << 20;

/// ... but never to more than Deflate can: a code of at least two bits stands for at most 258 bytes.
const DEFLATE: u64 = 1032;

/// Largest plausible content, in bytes, of a compressed file of `packed` bytes, whatever it announces:
/// `min(1032 packed, max(64 packed, 256 MiB))`.
pub fn unpack_limit(packed: usize) -> u64 {
    let packed = packed as u64;
    FLOOR_BYTES.max(EXPANSION.saturating_mul(packed)).min(DEFLATE.saturating_mul(packed))
}

/// An opened archive. Names are compared without regard to case, and `\` counts as `/`.
pub struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    names: Vec<String>,
    format: &'static str,
    /// Bytes that may still be unpacked, over all members.
    left: u64,
}

impl<'a> Archive<'a> {
    /// Reads the directory of the archive; `format` is named in messages.
    ///
    /// # Errors
    /// `Fault::Corrupt` if there is no complete ZIP directory.
    pub fn open(bytes: &'a [u8], format: &'static str) -> Result<Self, Fault> {
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|e| Fault::Corrupt { format, what: format!("the ZIP directory cannot be read ({e})") })?;
        let names = zip.file_names_raw().map(|n| String::from_utf8_lossy(n).replace('\\', "/")).collect();
        Ok(Archive { zip, names, format, left: unpack_limit(bytes.len()) })
    }

    /// Names of all members, in the order of the directory.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Unpacks one member, which may be `at_most` bytes long; memory grows with what is really there.
    ///
    /// # Errors
    /// `Corrupt` if the member is absent, longer, or fails its checksum; `Unsupported` for other compressions than
    /// Deflate and for encryption.
    pub fn read(&mut self, name: &str, at_most: u64) -> Result<Vec<u8>, Fault> {
        let format = self.format;
        let corrupt = |what: String| Fault::Corrupt { format, what };
        let index = self
            .names
            .iter()
            .position(|n| n.eq_ignore_ascii_case(name))
            .ok_or_else(|| corrupt(format!("the archive has no member {name:?}")))?;
        let member = self.zip.by_index(index).map_err(|e| match e {
            zip::result::ZipError::UnsupportedArchive(why) => Fault::Unsupported {
                format,
                what: format!("member {name:?} ({why})"),
                advice: "pack the archive again with Deflate and without a password".to_owned(),
            },
            e => corrupt(format!("member {name:?} cannot be opened ({e})")),
        })?;
        let at_most = at_most.min(self.left);
        let mut bytes = Vec::new();
        member
            .take(at_most.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|e| corrupt(format!("member {name:?} cannot be unpacked ({e})")))?;
        if bytes.len() as u64 > at_most {
            return Err(corrupt(format!("member {name:?} unpacks to more than the {at_most} bytes it may have")));
        }
        self.left -= bytes.len() as u64;
        Ok(bytes)
    }
}

/// An archive of `members` (name, content), deflated. Same members, same bytes: the time is 1980-01-01, the system Unix.
///
/// # Errors
/// As the ZIP writer: names that are too long or given twice.
pub fn pack(members: &[(&str, &[u8])]) -> std::io::Result<Vec<u8>> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(6))
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(0o644);
    for (name, content) in members {
        // The 32-bit size fields end at 4 GiB; leave room for a block that Deflate could not shrink.
        let options = options.large_file(content.len() as u64 > 0xf000_0000);
        writer.start_file(*name, options)?;
        writer.write_all(content)?;
    }
    Ok(writer.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_can_be_read() {
        let long = vec![7u8; 100_000];
        let bytes = pack(&[("a/b.txt", b"hello"), ("long", &long)]).unwrap();
        assert_eq!(bytes, pack(&[("a/b.txt", b"hello"), ("long", &long)]).unwrap());
        let mut archive = Archive::open(&bytes, "test").unwrap();
        assert_eq!(archive.names(), ["a/b.txt", "long"]);
        assert_eq!(archive.read("A/B.TXT", 5).unwrap(), b"hello");
        assert_eq!(archive.read("long", 100_000).unwrap(), long);
        assert!(archive.read("missing", 5).unwrap_err().to_string().contains("no member \"missing\""));
    }

    #[test]
    fn a_member_longer_than_announced_is_refused() {
        let bytes = pack(&[("bomb", &vec![0u8; 1 << 20])]).unwrap();
        let mut archive = Archive::open(&bytes, "test").unwrap();
        let fault = archive.read("bomb", (1 << 20) - 1).unwrap_err();
        assert!(fault.to_string().contains("more than the 1048575 bytes"), "{fault}");
    }

    #[test]
    fn a_changed_byte_is_noticed() {
        let content: Vec<u8> = (0..=255).collect();
        let mut bytes = pack(&[("m", &content)]).unwrap();
        let place = bytes.windows(4).position(|w| w == [100, 101, 102, 103]).unwrap();
        bytes[place] ^= 1;
        assert!(Archive::open(&bytes, "test").unwrap().read("m", 256).is_err());
    }
}
