//! A trait object.

use crate::Words;
use spirv_std::spirv;

trait Shape {
    fn area(&self) -> f32;
}

struct Square;
struct Disc;

impl Shape for Square {
    fn area(&self) -> f32 {
        1.0
    }
}

impl Shape for Disc {
    fn area(&self) -> f32 {
        3.1
    }
}

#[spirv(compute(threads(1)))]
pub fn object(#[spirv(storage_buffer, descriptor_set = 0, binding = 0)] words: &mut Words) {
    let shape: &dyn Shape = if words[0] > 0.0 { &Square } else { &Disc };
    words[3] = shape.area();
}
