//! A writer of MAT files, level 5, for matrices and texts only.
//!
//! ```text
//! header: 116 bytes of text, 8 of offset, version 0x0100, "IM"     element: type u32, bytes u32, data to 8
//! miMATRIX 14 { flags miUINT32 6, dimensions miINT32 5, name miINT8 1, data miDOUBLE 9 or miUINT16 4 }
//! ```
//!
//! Little-endian, by columns. Source: MathWorks, MAT-File Format (level 5), ch. 1.

use super::linear::Linear;

const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;
/// Classes of arrays.
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;

/// The file of a linear model, with `comment` as a variable of that name.
pub(super) fn write(comment: &str, model: &Linear) -> Vec<u8> {
    let [x0, tau0] = [&model.x0, &model.tau0].map(|x| x.iter().map(|x| vec![*x]).collect::<Vec<_>>());
    let columns = [model.states.len(), model.inputs.len()];
    let matrices = [
        ("A", &model.a, columns[0]),
        ("B", &model.b, columns[1]),
        ("C", &model.c, columns[0]),
        ("D", &model.d, columns[1]),
        ("x0", &x0, 1),
        ("tau0", &tau0, 1),
    ];
    let comment = [comment.to_string()];
    let texts = [
        ("states", model.states.as_slice()),
        ("inputs", &model.inputs),
        ("outputs", &model.outputs),
        ("comment", &comment),
    ];
    variables(&matrices, &texts)
}

/// The file of these matrices, each with name, rows and number of columns, and of these lists of
/// texts.
pub(super) fn variables(matrices: &[(&str, &Vec<Vec<f64>>, usize)], lists: &[(&str, &[String])]) -> Vec<u8> {
    let text = format!("MATLAB 5.0 MAT-file, written by hydrosysid {}", env!("CARGO_PKG_VERSION"));
    let mut bytes: Vec<u8> = text.bytes().chain(std::iter::repeat(b' ')).take(116).collect();
    bytes.extend([0; 8]);
    bytes.extend(0x0100_u16.to_le_bytes());
    bytes.extend(b"IM");
    for (name, rows, width) in matrices {
        let data: Vec<f64> = (0..*width).flat_map(|j| rows.iter().map(move |row| row[j])).collect();
        bytes.extend(array(name, DOUBLE_CLASS, rows.len(), *width, DOUBLE, &doubles(&data)));
    }
    for (name, list) in lists {
        bytes.extend(texts(name, list));
    }
    bytes
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A character matrix with one row per text, padded with blanks.
fn texts(name: &str, list: &[String]) -> Vec<u8> {
    let rows: Vec<Vec<u16>> = list.iter().map(|text| text.encode_utf16().collect()).collect();
    let width = rows.iter().map(Vec::len).max().unwrap_or(0);
    let cell = |j: usize, row: &Vec<u16>| row.get(j).copied().unwrap_or(u16::from(b' ')).to_le_bytes();
    let data: Vec<u8> = (0..width).flat_map(|j| rows.iter().flat_map(move |row| cell(j, row))).collect();
    array(name, CHAR_CLASS, rows.len(), width, UINT16, &data)
}

fn array(name: &str, class: u32, rows: usize, columns: usize, kind: u32, data: &[u8]) -> Vec<u8> {
    let words = |values: [u32; 2]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut body = element(UINT32, &words([class, 0]));
    // matrices of this crate have a few dozen rows
    let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    body.extend(element(INT32, &words([size(rows), size(columns)])));
    body.extend(element(INT8, name.as_bytes()));
    body.extend(element(kind, data));
    element(MATRIX, &body)
}

fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let length = u32::try_from(data.len()).unwrap_or(u32::MAX);
    let mut bytes: Vec<u8> =
        kind.to_le_bytes().into_iter().chain(length.to_le_bytes()).chain(data.iter().copied()).collect();
    bytes.resize(bytes.len().div_ceil(8) * 8, 0);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_ends_on_eight_bytes_and_says_its_length() {
        let model = Linear {
            states: vec!["u".into(), "psi".into()],
            inputs: vec!["tau_u".into()],
            outputs: vec!["u".into()],
            a: vec![vec![1.0, 2.0], vec![3.0, 4.0]],
            b: vec![vec![5.0], vec![6.0]],
            c: vec![vec![1.0, 0.0]],
            d: vec![vec![0.0]],
            x0: vec![0.5, 0.0],
            tau0: vec![40.0],
            rate0: vec![0.0, 0.0],
        };
        let bytes = write("a comment", &model);
        assert_eq!(&bytes[124..128], [0x00, 0x01, b'I', b'M']);
        let mut at = 128;
        let mut names = Vec::new();
        while at < bytes.len() {
            let word = |k: usize| u32::from_le_bytes(bytes[k..k + 4].try_into().unwrap());
            assert_eq!(word(at), MATRIX);
            let length = word(at + 4) as usize;
            assert_eq!(length % 8, 0);
            // flags 16 bytes, dimensions 16 bytes, then the name
            let name = word(at + 8 + 32 + 4) as usize;
            names.push(String::from_utf8(bytes[at + 48..at + 48 + name].to_vec()).unwrap());
            if names.len() == 1 {
                // A by columns: 1 3 2 4
                let data: Vec<f64> =
                    bytes[at + 64..at + 96].chunks(8).map(|c| f64::from_le_bytes(c.try_into().unwrap())).collect();
                assert_eq!(data, [1.0, 3.0, 2.0, 4.0]);
            }
            at += 8 + length;
        }
        assert_eq!(names, ["A", "B", "C", "D", "x0", "tau0", "states", "inputs", "outputs", "comment"]);
    }
}
