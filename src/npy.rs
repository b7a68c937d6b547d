//! NumPy `.npy` arrays: header and little-endian bytes, for any shape.
//!
//! Layout from the NumPy enhancement proposal NEP 1: magic `\x93NUMPY`, version (1.0: 2-byte, 2.0 and 3.0: 4-byte header
//! length), a Python dictionary with `descr`, `fortran_order` and `shape`, then the elements.

use crate::error::Fault;

/// Name of the format in messages.
pub const NAME: &str = "npy";
const MAGIC: &[u8] = b"\x93NUMPY";

/// Whether the bytes begin like an `.npy` file.
pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// A number that an array can hold without loss.
pub trait Element: Copy {
    /// NumPy's name of the little-endian type.
    const DESCR: &'static str;
    /// Appends the little-endian bytes.
    fn append_to(self, bytes: &mut Vec<u8>);
    /// The element in `bytes`, which hold exactly one in little-endian order.
    fn from_little_endian(bytes: &[u8]) -> Self;
}

macro_rules! element {
    ($($type:ty => $descr:literal),*) => {$(
        impl Element for $type {
            const DESCR: &'static str = $descr;
            fn append_to(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
            fn from_little_endian(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$type>()];
                own.copy_from_slice(bytes);
                <$type>::from_le_bytes(own)
            }
        }
    )*};
}
element!(f32 => "<f4", f64 => "<f8", i8 => "|i1", i16 => "<i2", i32 => "<i4", i64 => "<i8");
element!(u8 => "|u1", u16 => "<u2", u32 => "<u4", u64 => "<u8");

/// The whole file for `values` in C order (last index fastest).
///
/// # Panics
/// If the number of values is not the product of `shape`.
pub fn encode<T: Element>(shape: &[usize], values: impl IntoIterator<Item = T>) -> Vec<u8> {
    let mut extents = String::new();
    for n in shape {
        extents.push_str(&format!("{n}, "));
    }
    // Python writes (3,) for one extent but (2, 3) for two.
    let extents = if shape.len() == 1 { extents.trim_end() } else { extents.trim_end_matches(", ") };
    let mut header = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({extents}), }}", T::DESCR);
    // The data start at a multiple of 64 bytes; the header ends with a line feed.
    let unpadded = MAGIC.len() + 4 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let count: usize = shape.iter().product();
    let mut bytes = Vec::with_capacity(MAGIC.len() + 4 + header.len() + count * size_of::<T>());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&[1, 0]);
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    let start = bytes.len();
    for value in values {
        value.append_to(&mut bytes);
    }
    assert_eq!(bytes.len() - start, count * size_of::<T>(), "as many values as the shape {shape:?} needs");
    bytes
}

/// An array as the file holds it.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<'a> {
    /// Extents, slowest index first in C order.
    pub shape: Vec<usize>,
    /// NumPy's type name without the byte order, for example `f8`.
    pub kind: String,
    big_endian: bool,
    fortran: bool,
    bytes: &'a [u8],
}

/// Reads the header and finds the elements; bytes behind them are ignored, as NumPy does.
///
/// # Errors
/// `NotThisFormat`, `Unsupported` (objects, records, text, complex numbers, a version after 3) or `Corrupt`.
pub fn decode(bytes: &[u8]) -> Result<Array<'_>, Fault> {
    let corrupt = |what: &str| Fault::Corrupt { format: NAME, what: what.to_owned() };
    let rest = bytes.strip_prefix(MAGIC).ok_or(Fault::NotThisFormat(NAME))?;
    let [major, _minor, rest @ ..] = rest else { return Err(corrupt("the file ends inside the header")) };
    let (length, rest) = match (major, rest) {
        (1, [a, b, rest @ ..]) => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        (2 | 3, [a, b, c, d, rest @ ..]) => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        (1..=3, _) => return Err(corrupt("the file ends inside the header")),
        _ => return Err(unsupported(format!("header version {major}"), "save the array again with numpy.save")),
    };
    let header = rest.get(..length).ok_or_else(|| corrupt("the file ends inside the header"))?;
    let header = String::from_utf8_lossy(header);
    let (big_endian, kind) = element_type(entry(&header, "descr").ok_or_else(|| corrupt("the header has no descr"))?)?;
    let fortran = match entry(&header, "fortran_order") {
        Some(v) if v.starts_with("True") => true,
        Some(v) if v.starts_with("False") => false,
        _ => return Err(corrupt("fortran_order is neither True nor False")),
    };
    let shape = entry(&header, "shape").and_then(extents).ok_or_else(|| corrupt("the shape cannot be read"))?;
    let data = &rest[length..];
    let needed = shape.iter().try_fold(element_size(&kind), |product, &n| product.checked_mul(n));
    let data = needed.and_then(|n| data.get(..n)).ok_or_else(|| Fault::Corrupt {
        format: NAME,
        what: format!("the header announces {shape:?} elements of type {kind}, {} bytes follow", data.len()),
    })?;
    Ok(Array { shape, kind, big_endian, fortran, bytes: data })
}

impl Array<'_> {
    /// All elements as f64 in C order, whatever the stored type and order. 64-bit integers are rounded to 53 bits.
    pub fn to_f64(&self) -> Vec<f64> {
        match self.kind.as_str() {
            "f2" => self.map(u16::from_little_endian, half_to_f64),
            "f4" => self.map(f32::from_little_endian, f64::from),
            "f8" => self.map(f64::from_little_endian, |v| v),
            "i1" => self.map(i8::from_little_endian, f64::from),
            "i2" => self.map(i16::from_little_endian, f64::from),
            "i4" => self.map(i32::from_little_endian, f64::from),
            "i8" => self.map(i64::from_little_endian, |v| v as f64),
            "u1" => self.map(u8::from_little_endian, f64::from),
            "u2" => self.map(u16::from_little_endian, f64::from),
            "u4" => self.map(u32::from_little_endian, f64::from),
            _ => self.map(u64::from_little_endian, |v| v as f64),
        }
    }

    /// All elements in C order, if they are stored as `T`.
    ///
    /// # Errors
    /// `Fault::Unsupported` naming both types.
    pub fn to_vec<T: Element>(&self) -> Result<Vec<T>, Fault> {
        if self.kind != T::DESCR[1..] {
            let advice = "save the array with that type";
            return Err(unsupported(format!("an array of {} where {} is needed", self.kind, &T::DESCR[1..]), advice));
        }
        Ok(self.map(T::from_little_endian, |v| v))
    }

    fn map<S, T>(&self, decode: impl Fn(&[u8]) -> S, convert: impl Fn(S) -> T) -> Vec<T> {
        let size = element_size(&self.kind);
        let element = |index: usize| {
            let mut own = [0u8; 8];
            own[..size].copy_from_slice(&self.bytes[index * size..][..size]);
            if self.big_endian {
                own[..size].reverse();
            }
            convert(decode(&own[..size]))
        };
        let count = self.bytes.len() / size;
        if !self.fortran {
            return (0..count).map(element).collect();
        }
        // Walk the indices in C order and keep the place in Fortran order, where the first index is fastest.
        let mut strides = vec![1usize; self.shape.len()];
        for d in 1..self.shape.len() {
            strides[d] = strides[d - 1] * self.shape[d - 1];
        }
        let mut index = vec![0usize; self.shape.len()];
        let mut values = Vec::with_capacity(count);
        for _ in 0..count {
            values.push(element(index.iter().zip(&strides).map(|(i, s)| i * s).sum()));
            for d in (0..index.len()).rev() {
                index[d] += 1;
                if index[d] < self.shape[d] {
                    break;
                }
                index[d] = 0;
            }
        }
        values
    }
}

fn unsupported(what: String, advice: &str) -> Fault {
    Fault::Unsupported { format: NAME, what, advice: advice.to_owned() }
}

/// What follows `'key':` in the dictionary.
fn entry<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    ['\'', '"'].iter().find_map(|quote| {
        let (_, after) = header.split_once(&format!("{quote}{key}{quote}"))?;
        Some(after.trim_start().strip_prefix(':')?.trim_start())
    })
}

/// `'<f8', ...` to (big endian, `f8`).
fn element_type(value: &str) -> Result<(bool, String), Fault> {
    let advice = "save a plain array of float32, float64 or integers";
    let quote = value.chars().next().filter(|c| matches!(c, '\'' | '"'));
    let Some(name) = quote.and_then(|q| value[1..].split_once(q)).map(|(name, _)| name) else {
        return Err(unsupported("an array of records".to_owned(), advice));
    };
    let (big_endian, kind) = match name.as_bytes() {
        [b'<' | b'|' | b'=', ..] => (false, &name[1..]),
        [b'>', ..] => (true, &name[1..]),
        _ => (false, name),
    };
    match kind {
        "f2" | "f4" | "f8" | "i1" | "i2" | "i4" | "i8" | "u1" | "u2" | "u4" | "u8" => Ok((big_endian, kind.to_owned())),
        _ => Err(unsupported(format!("an array of type {name:?}"), advice)),
    }
}

/// Bytes of one element; only called with a type that [`element_type`] accepted.
fn element_size(kind: &str) -> usize {
    kind[1..].parse().unwrap_or(1)
}

/// `(3, 4), ...` to `[3, 4]`; Python 2 wrote `3L`.
fn extents(value: &str) -> Option<Vec<usize>> {
    let (inside, _) = value.strip_prefix('(')?.split_once(')')?;
    inside.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.trim_end_matches('L').parse().ok()).collect()
}

/// IEEE 754 binary16: 1 sign, 5 exponent, 10 fraction bits.
fn half_to_f64(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        e => (1.0 + fraction / 1024.0) * 2f64.powi(e - 15),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file as the NumPy documentation lays it out, put together by hand.
    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn numpy_s_own_bytes() {
        // numpy.save of numpy.arange(3, dtype='<u2'): header of 118 bytes, data at 128.
        let ours = encode(&[3], [0u16, 1, 2]);
        assert_eq!(&ours[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert!(ours[10..].starts_with(b"{'descr': '<u2', 'fortran_order': False, 'shape': (3,), }   "));
        assert_eq!(&ours[127..], b"\n\x00\x00\x01\x00\x02\x00");
    }

    #[test]
    fn every_order_and_version_gives_the_same_array() {
        let c_order: Vec<u8> = [1.5f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let f_order: Vec<u8> = [1.5f32, 4.0, 2.0, 5.0, 3.0, 6.0].iter().flat_map(|v| v.to_be_bytes()).collect();
        let little = file(1, "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n", &c_order);
        let big = file(2, "{\"shape\":(2L,3L),\"fortran_order\":True,\"descr\":\">f4\"}", &f_order);
        for bytes in [little, big] {
            let array = decode(&bytes).unwrap();
            assert_eq!(array.shape, [2, 3]);
            assert_eq!(array.to_f64(), [1.5, 2.0, 3.0, 4.0, 5.0, 6.0]);
            assert_eq!(array.to_vec::<f32>().unwrap(), [1.5, 2.0, 3.0, 4.0, 5.0, 6.0]);
            assert!(matches!(array.to_vec::<f64>(), Err(Fault::Unsupported { .. })));
        }
    }

    #[test]
    fn three_dimensions_and_scalars_survive() {
        let values: Vec<i64> = (-12..12).collect();
        let bytes = encode(&[2, 3, 4], values.iter().copied());
        let array = decode(&bytes).unwrap();
        assert_eq!((array.shape.as_slice(), array.to_vec::<i64>().unwrap()), ([2, 3, 4].as_slice(), values));
        let bytes = encode(&[], [7.25f64]);
        assert_eq!(decode(&bytes).unwrap().to_f64(), [7.25]);
    }

    #[test]
    fn halves_are_exact() {
        for (bits, value) in [(0x3c00, 1.0), (0xc000, -2.0), (0x0001, 2f64.powi(-24)), (0x7bff, 65504.0)] {
            assert_eq!(half_to_f64(bits), value);
        }
        assert!(half_to_f64(0x7e00).is_nan() && half_to_f64(0xfc00) == f64::NEG_INFINITY);
    }

    #[test]
    fn lies_and_strangers_are_refused() {
        let huge = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", usize::MAX, 3);
        let cases: [(Vec<u8>, &str); 6] = [
            (b"P5 2 2".to_vec(), "not a npy file"),
            (file(1, &huge, &[0; 64]), "announces"),
            (file(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", &[0; 23]), "23 bytes follow"),
            (file(1, "{'descr': '|O', 'fortran_order': False, 'shape': (3,), }", &[0; 24]), "\"|O\""),
            (file(1, "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (3,), }", &[0; 24]), "records"),
            (file(9, "", &[]), "version 9"),
        ];
        for (bytes, says) in cases {
            let message = decode(&bytes).unwrap_err().to_string();
            assert!(message.contains(says), "{message}");
        }
        let whole = encode(&[2, 2], [1.0f64, 2.0, 3.0, 4.0]);
        for cut in 6..whole.len() {
            assert!(matches!(decode(&whole[..cut]), Err(Fault::Corrupt { .. })), "cut at {cut}");
        }
    }
}
