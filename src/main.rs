//! The command line `moulage`.

fn main() {}
