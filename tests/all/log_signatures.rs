//! Logs in other formats are recognised by their first bytes, and no message advises to remove
//! bytes from them.

use hydrosysid::log::{LogOptions, read_from};

#[test]
fn a_binary_log_is_named_with_what_reads_it() {
    let telemetry = [&1_719_830_400_123_456_u64.to_be_bytes()[..], b"\xfd\x09\0\0\0\x01\x01"].concat();
    for (begin, name, extra) in [
        (&b"\xa3\x95\x80\x80"[..], "an ArduPilot DataFlash log", "ardupilot"),
        (b"ULog\x01\x12\x35\x01", "a PX4 ULog", "px4"),
        (b"\x89MCAP0\r\n", "an MCAP log", "ros"),
        (b"#ROSBAG V2.0\n", "a ROS 1 bag", "ros"),
        (b"MATLAB 7.3 MAT-file, Platform", "a MAT file of version 7.3", "hdf5"),
        (b"\x89HDF\r\n\x1a\n", "an HDF5 file", "hdf5"),
        (b"\xff\xff\xff\xff\x10\x01\0\0", "an Arrow stream", "arrow"),
        (&[&[b' '; 1024][..], b"\x89HDF\r\n\x1a\n"].concat(), "an HDF5 file", "hdf5"),
        (b"FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n", "in its text form", "ardupilot"),
        (b"FMT,128,89,FMT,BBnNZ,Type,Length,Name,Format,Columns\n", "in its text form", "ardupilot"),
        (b"\nFMT, 128, 89, FMT, BBnNZ, Type\n", "in its text form", "ardupilot"),
        (b"\xef\xbb\xbfFMT, 128, 89, FMT, BBnNZ, Type\n", "in its text form", "ardupilot"),
        (&telemetry, "a MAVLink telemetry log", "ardupilot"),
    ] {
        let bytes = [begin, &[0; 64]].concat();
        let error = read_from(&bytes[..], "dive.csv", &LogOptions::default(), &[]).expect_err("it is no CSV");
        let told = error.to_string();
        assert!(told.contains(name) && told.contains(extra) && told.contains("hydrosysid convert"), "{told}");
        assert!(!told.contains("cut these bytes"), "{told}");
    }
}
