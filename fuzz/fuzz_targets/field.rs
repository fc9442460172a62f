//! The target `fuzz_targets::field`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::field(bytes));
