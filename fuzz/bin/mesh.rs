//! The target `targets::mesh`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::mesh(bytes);
});
