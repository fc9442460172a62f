//! The target `targets::volume`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::volume(bytes);
});
