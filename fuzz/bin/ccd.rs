//! The target `targets::ccd`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::ccd(bytes);
});
