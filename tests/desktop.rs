//! The viewer in a window and as a page in a browser, and a carved object in a page of three.js.

mod browser;
mod page;
#[path = "three/main.rs"]
mod three;
mod viewer;
mod window;
