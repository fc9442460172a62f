//! The target `fuzz_targets::mesh`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::mesh(bytes));
