//! The `hydrosysid` command: reads arguments, calls the library, prints.

fn main() {
    println!("hydrosysid {}", env!("CARGO_PKG_VERSION"));
}
