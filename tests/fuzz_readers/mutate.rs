//! Ways in which a file goes wrong: on the wire, in a careless program, by ill will.

use asperity::math::random::CounterRng;
use rand::Rng;

/// A valid file in a form whose parts can be changed behind its checksums.
pub enum Seed {
    /// Bytes that are changed as they are.
    Plain(Vec<u8>),
    /// A PNG: checksums are made right again after every other change.
    Chunks(Vec<u8>),
    /// Members of a ZIP archive, changed before they are packed.
    Members(Vec<(String, Vec<u8>)>),
}

pub fn below(rng: &mut CounterRng, n: usize) -> usize {
    (rng.uniform() * n as f64) as usize
}

impl Seed {
    /// Bytes in all.
    pub fn size(&self) -> usize {
        match self {
            Seed::Plain(bytes) | Seed::Chunks(bytes) => bytes.len(),
            Seed::Members(members) => members.iter().map(|m| m.1.len()).sum(),
        }
    }

    /// The file with one to six changes.
    pub fn mutant(&self, rng: &mut CounterRng) -> Vec<u8> {
        match self {
            Seed::Plain(bytes) => mutate(bytes, rng),
            Seed::Chunks(bytes) => {
                let mut mutant = mutate(bytes, rng);
                if below(rng, 2) == 0 {
                    right_checksums(&mut mutant);
                }
                mutant
            }
            Seed::Members(members) => {
                let chosen = below(rng, members.len());
                let changed = mutate(&members[chosen].1, rng);
                let content = |k: usize| if k == chosen { changed.as_slice() } else { &members[k].1 };
                let list: Vec<(&str, &[u8])> =
                    members.iter().enumerate().map(|(k, (name, _))| (name.as_str(), content(k))).collect();
                asperity::archive::pack(&list).unwrap()
            }
        }
    }
}

/// Most files are misread where their header lies, so half of the changes go there.
fn place(rng: &mut CounterRng, length: usize) -> usize {
    let near = if below(rng, 2) == 0 { length.min(2048) } else { length };
    below(rng, near)
}

fn mutate(file: &[u8], rng: &mut CounterRng) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=below(rng, 6) {
        if bytes.is_empty() {
            break;
        }
        let at = place(rng, bytes.len());
        let length = 1 + below(rng, 8.min(bytes.len() - at));
        match below(rng, 10) {
            0 => bytes[at] ^= 1 << below(rng, 8),
            1 => bytes[at] = rng.next_u32() as u8,
            2 => bytes[at..at + length].fill([0, 0xff, 0x7f, 0x80, b'9', b'-'][below(rng, 6)]),
            3 => drop(bytes.drain(at..at + length)),
            4 => {
                let piece = bytes[at..at + length].to_vec();
                let to = place(rng, bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => bytes.truncate(at),
            6 | 7 => overwrite(&mut bytes, at, &extreme(rng)),
            8 => swell_number(&mut bytes, at, rng),
            _ => {
                // A long stretch copied over another.
                let length = below(rng, 4096.min(bytes.len() - at)) + 1;
                let from = below(rng, bytes.len() - length + 1);
                bytes.copy_within(from..from + length, at);
            }
        }
    }
    bytes
}

/// A count or a float at which arithmetic goes wrong, in either byte order.
fn extreme(rng: &mut CounterRng) -> Vec<u8> {
    let whole = [0, 1, 2, 0x7f, 0x80, 0xff, 0x7fff, 0x8000, 0xffff, 0x10000, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];
    let value: u64 = match below(rng, 4) {
        0 => u64::MAX - below(rng, 3) as u64,
        1 => 1 << below(rng, 64),
        2 => [f64::NAN, f64::INFINITY, -0.0, f64::MAX, 5e-324][below(rng, 5)].to_bits(),
        _ => whole[below(rng, whole.len())],
    };
    let width = [1, 2, 4, 8][below(rng, 4)];
    if below(rng, 2) == 0 { value.to_le_bytes()[..width].to_vec() } else { value.to_be_bytes()[8 - width..].to_vec() }
}

fn overwrite(bytes: &mut [u8], at: usize, with: &[u8]) {
    let end = bytes.len().min(at + with.len());
    bytes[at..end].copy_from_slice(&with[..end - at]);
}

/// Replaces the next decimal number by one that is hard to hold.
fn swell_number(bytes: &mut Vec<u8>, at: usize, rng: &mut CounterRng) {
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else { return };
    let end = bytes[start..].iter().position(|b| !b.is_ascii_digit()).map_or(bytes.len(), |k| start + k);
    let numbers: [&[u8]; 8] =
        [b"0", b"-1", b"4294967296", b"18446744073709551615", b"1e308", b"nan", b"", b"99999999999999999999999"];
    bytes.splice(start..end, numbers[below(rng, numbers.len())].iter().copied());
}

/// Recomputes the CRC of every PNG chunk that is still whole.
fn right_checksums(png: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = png.get(at..at + 4) {
        let length = head.iter().fold(0usize, |n, b| n << 8 | usize::from(*b));
        let Some(end) = at.checked_add(8).and_then(|n| n.checked_add(length)).filter(|n| n + 4 <= png.len()) else {
            return;
        };
        let mut crc = flate2::Crc::new();
        crc.update(&png[at + 4..end]);
        png[end..end + 4].copy_from_slice(&crc.sum().to_be_bytes());
        at = end + 4;
    }
}
