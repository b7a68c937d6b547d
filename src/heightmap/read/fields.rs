//! Numbers and text at known places of a binary file; every access is checked against its end.

use crate::error::Fault;
use ndarray::Array2;

/// How one number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sample {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl Sample {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Sample::U8 | Sample::I8 => 1,
            Sample::U16 | Sample::I16 => 2,
            Sample::U32 | Sample::I32 | Sample::F32 => 4,
            Sample::F64 => 8,
        }
    }

    /// Decodes `bytes`, a whole number of samples; every type but f64 is exact in f64.
    pub fn decode_all(self, bytes: &[u8], big_endian: bool) -> Vec<f64> {
        macro_rules! decode {
            ($type:ty) => {
                bytes
                    .chunks_exact(size_of::<$type>())
                    .map(|chunk| {
                        let mut own = [0; size_of::<$type>()];
                        own.copy_from_slice(chunk);
                        f64::from(if big_endian { <$type>::from_be_bytes(own) } else { <$type>::from_le_bytes(own) })
                    })
                    .collect()
            };
        }
        match self {
            Sample::U8 => decode!(u8),
            Sample::I8 => decode!(i8),
            Sample::U16 => decode!(u16),
            Sample::I16 => decode!(i16),
            Sample::U32 => decode!(u32),
            Sample::I32 => decode!(i32),
            Sample::F32 => decode!(f32),
            Sample::F64 => decode!(f64),
        }
    }
}

/// A binary file with one byte order.
#[derive(Debug, Clone, Copy)]
pub struct Fields<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// Format named in messages.
    pub format: &'static str,
    /// Whether the most significant byte comes first.
    pub big_endian: bool,
}

impl<'a> Fields<'a> {
    /// `length` bytes from offset `at`.
    pub fn slice(&self, at: usize, length: usize) -> Result<&'a [u8], Fault> {
        at.checked_add(length).and_then(|end| self.bytes.get(at..end)).ok_or_else(|| Fault::Corrupt {
            format: self.format,
            what: format!("{length} bytes are needed at offset {at}, the file has {}", self.bytes.len()),
        })
    }

    /// One number as f64.
    pub fn number(&self, at: usize, sample: Sample) -> Result<f64, Fault> {
        Ok(sample.decode_all(self.slice(at, sample.size())?, self.big_endian)[0])
    }

    /// An unsigned 16-bit size.
    pub fn u16(&self, at: usize) -> Result<usize, Fault> {
        Ok(self.number(at, Sample::U16)? as usize)
    }

    /// An unsigned 32-bit size.
    pub fn u32(&self, at: usize) -> Result<usize, Fault> {
        Ok(self.number(at, Sample::U32)? as usize)
    }

    /// Text of at most `length` bytes up to the first NUL, blanks trimmed, foreign bytes replaced.
    pub fn text(&self, at: usize, length: usize) -> Result<String, Fault> {
        let bytes = self.slice(at, length)?;
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(length);
        Ok(String::from_utf8_lossy(&bytes[..end]).trim().to_owned())
    }

    /// `rows` x `columns` numbers from offset `at` in file order. Nothing is allocated before the file is known to
    /// hold them; the result takes at most 8 bytes per stored byte.
    pub fn plane(&self, at: usize, rows: usize, columns: usize, sample: Sample) -> Result<Vec<f64>, Fault> {
        let length = plane_bytes(rows, columns, sample.size(), self.format)?;
        Ok(sample.decode_all(self.slice(at, length)?, self.big_endian))
    }
}

/// `rows * columns * size`, unless that overflows or is nothing.
pub fn plane_bytes(rows: usize, columns: usize, size: usize, format: &'static str) -> Result<usize, Fault> {
    let product = rows.checked_mul(columns).and_then(|n| n.checked_mul(size)).filter(|&n| n > 0);
    product.ok_or_else(|| Fault::Corrupt { format, what: format!("a grid of {columns} x {rows} points is impossible") })
}

/// Rows of `columns` heights as a matrix.
pub fn into_grid(rows: usize, columns: usize, heights: Vec<f64>, format: &'static str) -> Result<Array2<f64>, Fault> {
    let count = heights.len();
    Array2::from_shape_vec((rows, columns), heights).map_err(|_| Fault::Corrupt {
        format,
        what: format!("{count} heights do not fill a grid of {columns} x {rows} points"),
    })
}
