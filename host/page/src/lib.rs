//! The viewer as a page: WebAssembly, with WebGPU or on the CPU in a worker.
//!
//! `static/page.js` chooses by what the browser supports. With WebGPU, scenes are prepared in
//! another worker. Dropped files stay in the page's memory.
#![cfg(target_arch = "wasm32")]

mod archive;
mod browser;
mod cpu;
mod default;
mod gpu;
mod station;

pub use cpu::CpuPage;
pub use gpu::GpuPage;
pub use station::Station;
