//! The target `fuzz_targets::volume`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::volume(bytes));
