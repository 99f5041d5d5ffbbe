#![no_main]

#[path = "../exercise.rs"]
mod exercise;

#[global_allocator]
static MEMORY: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| exercise::bounded(&MEMORY, exercise::exo, bytes));
