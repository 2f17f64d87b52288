//! The elements that a `.mat` file of version 5 consists of: a type, a size, bytes; arrays are elements of elements.

use std::io::Read;

use flate2::read::ZlibDecoder;

/// Bytes before the first element: text, then the version and the order of bytes.
const HEADER: usize = 128;
/// An element that unpacks to more is taken for a corrupt one, bytes.
const MOST_UNPACKED: u64 = 1 << 31;
/// Structures within structures beyond this depth are none that a log has.
const DEEPEST: usize = 16;

// Types of elements.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// A variable, or a field of a structure.
pub(super) struct Array {
    pub(super) dimensions: Vec<usize>,
    pub(super) content: Content,
}

pub(super) enum Content {
    /// Column by column; of complex ones the real part.
    Numbers(Vec<f64>),
    /// The fields of each structure by their names.
    Structures(Vec<Vec<(String, Array)>>),
    /// A table, a timetable, a time series: what only MATLAB reads.
    Object,
    /// Text, cells, sparse matrices.
    Other,
}

/// The variables of a file by their names.
pub(super) fn variables(file: &[u8]) -> Result<Vec<(String, Array)>, String> {
    let (header, mut rest) = file.split_at_checked(HEADER).ok_or_else(cut_short)?;
    if &header[126..] == b"MI" {
        return Err("is a .mat file of a big-endian computer; save it again on another".to_owned());
    }
    // Behind this place MATLAB keeps what its objects consist of.
    let subsystem = u64::from_le_bytes(header[116..124].try_into().unwrap_or([b' '; 8]));
    if let Some(length) = usize::try_from(subsystem).ok().and_then(|place| place.checked_sub(HEADER)) {
        rest = rest.get(..length).unwrap_or(rest);
    }
    let mut variables = Vec::new();
    while !rest.is_empty() {
        let (kind, data) = element(&mut rest)?;
        match kind {
            COMPRESSED => {
                let mut plain = Vec::new();
                let unpacked = ZlibDecoder::new(data).take(MOST_UNPACKED).read_to_end(&mut plain);
                unpacked.map_err(|error| damaged(&error.to_string()))?;
                let (kind, data) = element(&mut plain.as_slice())?;
                if kind == MATRIX {
                    variables.push(array(data, 0)?);
                }
            }
            MATRIX => variables.push(array(data, 0)?),
            _ => return Err(damaged("a variable is no array")),
        }
    }
    Ok(variables)
}

fn damaged(reason: &str) -> String {
    format!("is not a .mat file that can be read, or was cut short: {reason}")
}

fn cut_short() -> String {
    damaged("it ends within a variable")
}

/// Takes the next element off `rest`: its type and its bytes.
fn element<'a>(rest: &mut &'a [u8]) -> Result<(u32, &'a [u8]), String> {
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().unwrap_or_default());
    let (tag, after) = rest.split_at_checked(8).ok_or_else(cut_short)?;
    let first = word(&tag[..4]);
    if first >> 16 != 0 {
        // A small one, its bytes within the tag.
        *rest = after;
        let data =
            tag[4..].get(..(first >> 16) as usize).ok_or_else(|| damaged("an element is larger than its place"))?;
        return Ok((first & 0xffff, data));
    }
    let size = word(&tag[4..]) as usize;
    let data = after.get(..size).ok_or_else(cut_short)?;
    // Padded to eight bytes; packed ones are not.
    let padded = if first == COMPRESSED { size } else { size.next_multiple_of(8) };
    *rest = after.get(padded..).unwrap_or_default();
    Ok((first, data))
}

/// Takes the next element off `rest`, which must be of this type.
fn expected<'a>(rest: &mut &'a [u8], kind: u32, what: &str) -> Result<&'a [u8], String> {
    let (found, data) = element(rest)?;
    if found == kind { Ok(data) } else { Err(damaged(&format!("the {what} of a variable are missing"))) }
}

/// An array with its name.
fn array(mut rest: &[u8], depth: usize) -> Result<(String, Array), String> {
    // An empty field may be an element without any.
    if rest.is_empty() {
        return Ok((String::new(), Array { dimensions: vec![0, 0], content: Content::Other }));
    }
    let flags = expected(&mut rest, UINT32, "flags")?;
    let class = *flags.first().ok_or_else(cut_short)?;
    if class == 17 {
        // An opaque object has its name where others have their dimensions.
        let name = text(expected(&mut rest, INT8, "names")?);
        return Ok((name, Array { dimensions: Vec::new(), content: Content::Object }));
    }
    let dimensions: Vec<usize> = expected(&mut rest, INT32, "dimensions")?
        .chunks_exact(4)
        .map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap_or_default()) as usize)
        .collect();
    let name = text(expected(&mut rest, INT8, "names")?);
    let content = match class {
        2 => structures(rest, &dimensions, depth)?,
        3 => Content::Object,
        6..=15 => {
            let (kind, data) = element(&mut rest)?;
            Content::Numbers(numbers(kind, data)?)
        }
        _ => Content::Other,
    };
    Ok((name, Array { dimensions, content }))
}

fn structures(mut rest: &[u8], dimensions: &[usize], depth: usize) -> Result<Content, String> {
    if depth == DEEPEST {
        return Ok(Content::Other);
    }
    let length = expected(&mut rest, INT32, "lengths of the fields")?;
    let length = u32::from_le_bytes(length.try_into().map_err(|_| cut_short())?) as usize;
    let names = expected(&mut rest, INT8, "fields")?;
    if length == 0 {
        return Ok(Content::Other);
    }
    let names: Vec<String> = names.chunks_exact(length).map(text).collect();
    // Without fields nothing bounds the count that a damaged file claims.
    if names.is_empty() {
        return Ok(Content::Other);
    }
    let count = dimensions.iter().try_fold(1_usize, |count, side| count.checked_mul(*side)).ok_or_else(cut_short)?;
    let mut structures = Vec::new();
    for _ in 0..count {
        let mut fields = Vec::with_capacity(names.len());
        for name in &names {
            let data = expected(&mut rest, MATRIX, "fields")?;
            fields.push((name.clone(), array(data, depth + 1)?.1));
        }
        structures.push(fields);
    }
    Ok(Content::Structures(structures))
}

/// A name, which ends at its first zero.
fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// Numbers of whatever type they are kept in: MATLAB takes the smallest that holds them.
fn numbers(kind: u32, data: &[u8]) -> Result<Vec<f64>, String> {
    macro_rules! of {
        ($type:ty) => {
            data.chunks_exact(size_of::<$type>())
                .map(|bytes| <$type>::from_le_bytes(bytes.try_into().unwrap_or_default()) as f64)
                .collect()
        };
    }
    Ok(match kind {
        1 => of!(i8),
        2 => of!(u8),
        3 => of!(i16),
        4 => of!(u16),
        5 => of!(i32),
        6 => of!(u32),
        7 => of!(f32),
        9 => of!(f64),
        12 => of!(i64),
        13 => of!(u64),
        _ => return Err(damaged("the numbers of a variable are of no known type")),
    })
}
