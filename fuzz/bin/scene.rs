//! The target `targets::scene`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::scene(bytes);
});
