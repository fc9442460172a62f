//! The target `fuzz_targets::ccd`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::ccd(bytes));
