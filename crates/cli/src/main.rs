//! The program `musculo-collide`.

fn main() {}
