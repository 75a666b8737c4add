//! The viewer in a window and as a page in a browser.

mod browser;
mod page;
mod viewer;
mod window;
