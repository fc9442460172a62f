//! The target `fuzz_targets::scene`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::scene(bytes));
