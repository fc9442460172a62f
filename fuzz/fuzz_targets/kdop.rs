//! The target `fuzz_targets::kdop`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz_targets::kdop(bytes));
