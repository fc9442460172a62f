//! The target `targets::field`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::field(bytes);
});
