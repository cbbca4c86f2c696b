//! The program `kugelblitz`.

fn main() {}
