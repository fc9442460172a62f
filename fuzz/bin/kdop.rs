//! The target `targets::kdop`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = targets::kdop(bytes);
});
