//! Recognition of a file by its first bytes.

/// Kind of a file by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opening {
    /// Text, after a byte order mark of this many bytes.
    Text(usize),
    /// Another kind of file, by name: `UTF-16`, `gzip`.
    Other(&'static str),
    /// A log in another format: its name, and the extra of the Python package that reads it.
    Log(&'static str, &'static str),
}

/// First bytes of files that are not CSV text. UTF-32 comes before UTF-16, whose mark it begins with.
const MARKS: [(&[u8], &str); 9] = [
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
    (b"\x1f\x8b", "gzip"),
    (b"PK\x03\x04", "zip"),
    (b"\x28\xb5\x2f\xfd", "zstd"),
    (b"\xfd7zXZ\0", "xz"),
    (b"BZh", "bzip2"),
];

/// Number of bytes from the start of a file that [`opening`] should get.
pub const LOOKED_AT: u64 = 1 << 16;

/// First bytes of logs in other formats; the file name does not matter.
const LOGS: [(&[u8], &str, &str); 15] = [
    (b"\xa3\x95", "an ArduPilot DataFlash log", "ardupilot"),
    (b"ULog\x01\x12\x35", "a PX4 ULog", "px4"),
    (b"\x89MCAP0\r\n", "an MCAP log", "ros"),
    (b"#ROSBAG V", "a ROS 1 bag", "ros"),
    (b"SQLite format 3\0", "a ROS 2 bag or another SQLite file", "ros"),
    (b"MATLAB 5.0 MAT-file", "a MAT file", "mat"),
    (b"MATLAB 7.3 MAT-file", "a MAT file of version 7.3", "hdf5"),
    (b"PAR1", "a Parquet file", "parquet"),
    (b"ARROW1", "an Arrow file", "arrow"),
    (b"FEA1", "a Feather file", "arrow"),
    (b"\xff\xff\xff\xff", "an Arrow stream", "arrow"),
    (b"CDF\x01", "a netCDF file", "xarray"),
    (b"CDF\x02", "a netCDF file", "xarray"),
    (b"CDF\x05", "a netCDF file", "xarray"),
    (b"\x93NUMPY", "a NumPy file", "all"),
];

/// Whether this is an HDF5 file: its signature stands at byte 0, or after a user block of 512,
/// 1024, 2048 … bytes.
fn is_hdf5(bytes: &[u8]) -> bool {
    let blocks = std::iter::successors(Some(512_usize), |block| block.checked_mul(2));
    let mut places = std::iter::once(0).chain(blocks.take_while(|block| *block < bytes.len()));
    places.any(|at| bytes[at..].starts_with(b"\x89HDF\r\n\x1a\n"))
}

/// Whether this is a DataFlash log in text form: a line in its first 4096 bytes defines the format
/// of the lines that define formats (`FMT`).
fn is_text_dataflash(bytes: &[u8]) -> bool {
    let begin = &bytes[..bytes.len().min(4096)];
    begin.split(|byte| *byte == b'\n').any(|line| {
        let mut fields = line.split(|byte| *byte == b',');
        let mut next = || fields.next().unwrap_or_default().trim_ascii();
        line.starts_with(b"FMT,")
            && [next(), next()] == [&b"FMT"[..], b"128"]
            && matches!(next(), [_, ..])
            && next() == b"FMT"
    })
}

/// Whether this is a MAVLink telemetry log: each message is preceded by its time, µs since 1970 in
/// eight bytes, big-endian.
fn is_telemetry(bytes: &[u8]) -> bool {
    let Some((head, [0xfe | 0xfd, ..])) = bytes.split_first_chunk::<8>() else { return false };
    // between the years 2000 and 2100
    (946_684_800_000_000..4_102_444_800_000_000).contains(&u64::from_be_bytes(*head))
}

/// Whether this is a zip of NumPy arrays: the name of its first entry ends with `.npy`.
fn is_npz(bytes: &[u8]) -> bool {
    let length = bytes.get(26..28).map_or(0, |two| usize::from(u16::from_le_bytes([two[0], two[1]])));
    bytes.starts_with(b"PK\x03\x04") && bytes.get(30..30 + length).is_some_and(|name| name.ends_with(b".npy"))
}

/// Recognises a file by its first bytes.
pub fn opening(bytes: &[u8]) -> Opening {
    let mark = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    if is_text_dataflash(&bytes[mark..]) {
        return Opening::Log("an ArduPilot DataFlash log in its text form", "ardupilot");
    }
    if mark > 0 {
        return Opening::Text(mark);
    }
    if is_npz(bytes) {
        return Opening::Log("a NumPy archive", "all");
    }
    if let Some((_, name)) = MARKS.iter().find(|(mark, _)| bytes.starts_with(mark)) {
        return Opening::Other(name);
    }
    if let Some((_, name, extra)) = LOGS.iter().find(|(mark, ..)| bytes.starts_with(mark)) {
        return Opening::Log(name, extra);
    }
    // after those: a MAT file of version 7.3 is an HDF5 file with a user block
    if is_hdf5(bytes) {
        return Opening::Log("an HDF5 file", "hdf5");
    }
    if is_telemetry(bytes) {
        return Opening::Log("a MAVLink telemetry log", "ardupilot");
    }
    // ASCII in UTF-16 without a mark: every other byte is NUL.
    match bytes {
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] if *a != 0 && *b != 0 => Opening::Other("UTF-16"),
        _ => Opening::Text(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_first_bytes() {
        assert_eq!(opening(b"\xef\xbb\xbft,u"), Opening::Text(3));
        assert_eq!(opening(b"t,u"), Opening::Text(0));
        assert_eq!(opening(b""), Opening::Text(0));
        assert_eq!(opening(b"t\0,\0u\0"), Opening::Other("UTF-16"));
        assert_eq!(opening(b"\0t\0,"), Opening::Other("UTF-16"));
        assert_eq!(opening(b"\x1f\x8b\x08"), Opening::Other("gzip"));
        assert_eq!(opening(b"\xa3\x95\x80\x80"), Opening::Log("an ArduPilot DataFlash log", "ardupilot"));
        for text in [
            "FMT, 128, 89, FMT, BBnNZ, Type",
            "FMT,128,89,FMT,BBnNZ,Type",
            "\nFMT, 128, 89, FMT, BBnNZ",
            "\u{feff}FMT, 128, 89, FMT, BBnNZ",
            "\u{feff}\r\nArduSub V4.1\r\nFMT,128,89,FMT,BBnNZ\r\n",
        ] {
            let told = Opening::Log("an ArduPilot DataFlash log in its text form", "ardupilot");
            assert_eq!(opening(text.as_bytes()), told, "{text:?}");
        }
        assert_eq!(opening(b"FMT,t,u\n128,1,2\n"), Opening::Text(0), "a channel of that name");
        for block in [0, 512, 2048, 32768] {
            let file = [&vec![b' '; block][..], b"\x89HDF\r\n\x1a\n", &[0; 40]].concat();
            assert_eq!(opening(&file), Opening::Log("an HDF5 file", "hdf5"), "behind {block} bytes");
        }
        assert!(matches!(opening(b"\xff\xff\xff\xff\x10\x01"), Opening::Log("an Arrow stream", "arrow")));
        // 2024-07-01 in µs, then MAVLink 2
        let telemetry = [&1_719_830_400_123_456_u64.to_be_bytes()[..], b"\xfd\x09\0\0"].concat();
        assert_eq!(opening(&telemetry), Opening::Log("a MAVLink telemetry log", "ardupilot"));
        assert_eq!(opening(b"\0\0\0\0\0\0\0\x01\xfd"), Opening::Text(0), "an hour after 1970");
        assert_eq!(opening(b"\xff\xfe\0\0t\0\0\0"), Opening::Other("UTF-32"));
        let zipped = |name: &[u8]| {
            [b"PK\x03\x04", &[0; 22][..], &[u8::try_from(name.len()).unwrap(), 0, 0, 0], name, b"..."].concat()
        };
        assert_eq!(opening(&zipped(b"u.npy")), Opening::Log("a NumPy archive", "all"));
        assert_eq!(opening(&zipped(b"notes.txt")), Opening::Other("zip"));
    }
}
