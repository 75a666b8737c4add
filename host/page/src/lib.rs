//! The viewer as a page: WebAssembly, with WebGPU or on the CPU in a worker.
//!
//! `static/page.js` asks the browser which of the two it can have. Files that a
//! person drops stay in the page's memory.
#![cfg(target_arch = "wasm32")]

mod archive;
mod browser;
mod cpu;
mod default;
mod gpu;

pub use cpu::CpuPage;
pub use gpu::GpuPage;
