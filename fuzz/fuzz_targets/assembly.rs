#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nailnoise_fuzz::assembly(bytes));
