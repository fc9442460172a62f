//! Tasks that verify, chart and count.

fn main() {}
