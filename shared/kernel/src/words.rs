//! Values as u32 words: what arguments are read from, and results are written to.

use crate::{Argument, domain};
use glam::{IVec2, IVec3, IVec4, Mat2, Mat3, Mat4, UVec2, UVec3, UVec4, Vec2, Vec3, Vec4};

/// Source of the words of arguments.
pub trait Source {
    /// Returns the next word.
    fn next(&mut self) -> u32;
}

/// Sink of the words of results.
pub trait Sink {
    /// Writes the next word.
    fn put(&mut self, word: u32);
}

/// Types of arguments. Derived for structs and fieldless enums by the feature `macros`.
pub trait FromWords: Sized {
    /// Number of words.
    const WORDS: u32;
    /// The default values to try.
    const ARGUMENT: Argument = Argument::new(Self::WORDS, domain::NUMBER);
    /// Reads the value from a source.
    fn read<S: Source>(source: &mut S) -> Self;
}

/// Types of results. Derived for structs and fieldless enums by the feature `macros`.
pub trait ToWords {
    /// Number of words.
    const WORDS: u32;
    /// Writes the value to a sink.
    fn write<S: Sink>(self, sink: &mut S);
}

/// A number of one word.
macro_rules! number {
    ($type:ty: $domain:ident, $word:ident => $from:expr, $value:ident => $to:expr) => {
        impl FromWords for $type {
            const WORDS: u32 = 1;
            const ARGUMENT: Argument = Argument::new(1, domain::$domain);
            #[inline]
            fn read<S: Source>(source: &mut S) -> $type {
                let $word = source.next();
                $from
            }
        }

        impl ToWords for $type {
            const WORDS: u32 = 1;
            #[inline]
            fn write<S: Sink>(self, sink: &mut S) {
                let $value = self;
                sink.put($to);
            }
        }
    };
}

number!(u32: INTEGER, word => word, value => value);
number!(i32: INTEGER, word => word as i32, value => value as u32);
// The sign of zero may not be observed: −0 is normalised to +0.
number!(f32: NUMBER, word => f32::from_bits(word), value => if value == 0.0 { 0 } else { value.to_bits() });
number!(bool: TRUTH, word => word != 0, value => if value { 1 } else { 0 });

/// A vector or a matrix: its components or columns in turn.
macro_rules! parts {
    ($type:ident of $part:ty: $new:ident($($field:ident),*)) => {
        impl FromWords for $type {
            const WORDS: u32 = 0 $(+ { let _ = stringify!($field); <$part as FromWords>::WORDS })*;
            const ARGUMENT: Argument = Argument {
                words: <$type as FromWords>::WORDS,
                ..<$part as FromWords>::ARGUMENT
            };
            #[inline]
            fn read<S: Source>(source: &mut S) -> $type {
                $(let $field = <$part>::read(source);)*
                $type::$new($($field),*)
            }
        }

        impl ToWords for $type {
            const WORDS: u32 = <$type as FromWords>::WORDS;
            #[inline]
            fn write<S: Sink>(self, sink: &mut S) {
                $(self.$field.write(sink);)*
            }
        }
    };
}

parts!(Vec2 of f32: new(x, y));
parts!(Vec3 of f32: new(x, y, z));
parts!(Vec4 of f32: new(x, y, z, w));
parts!(IVec2 of i32: new(x, y));
parts!(IVec3 of i32: new(x, y, z));
parts!(IVec4 of i32: new(x, y, z, w));
parts!(UVec2 of u32: new(x, y));
parts!(UVec3 of u32: new(x, y, z));
parts!(UVec4 of u32: new(x, y, z, w));
parts!(Mat2 of Vec2: from_cols(x_axis, y_axis));
parts!(Mat3 of Vec3: from_cols(x_axis, y_axis, z_axis));
parts!(Mat4 of Vec4: from_cols(x_axis, y_axis, z_axis, w_axis));

/// An array: its elements in turn.
macro_rules! array {
    ($length:literal: $($element:ident),*) => {
        impl<T: FromWords> FromWords for [T; $length] {
            const WORDS: u32 = $length * T::WORDS;
            const ARGUMENT: Argument = Argument {
                words: $length * T::WORDS,
                parts: &[T::ARGUMENT; $length],
                ..T::ARGUMENT
            };
            #[inline]
            fn read<S: Source>(source: &mut S) -> [T; $length] {
                $(let $element = T::read(source);)*
                [$($element),*]
            }
        }

        impl<T: ToWords> ToWords for [T; $length] {
            const WORDS: u32 = $length * T::WORDS;
            #[inline]
            fn write<S: Sink>(self, sink: &mut S) {
                let [$($element),*] = self;
                $($element.write(sink);)*
            }
        }
    };
}

array!(1: a);
array!(2: a, b);
array!(3: a, b, c);
array!(4: a, b, c, d);
array!(5: a, b, c, d, e);
array!(6: a, b, c, d, e, f);
array!(7: a, b, c, d, e, f, g);
array!(8: a, b, c, d, e, f, g, h);

/// Several values in turn.
macro_rules! tuple {
    ($($name:ident: $field:tt),*) => {
        impl<$($name: FromWords),*> FromWords for ($($name,)*) {
            const WORDS: u32 = 0 $(+ $name::WORDS)*;
            const ARGUMENT: Argument = Argument {
                words: <Self as FromWords>::WORDS,
                domain: domain::NUMBER,
                parts: &[$($name::ARGUMENT),*],
            };
            #[inline]
            fn read<S: Source>(source: &mut S) -> ($($name,)*) {
                ($($name::read(source),)*)
            }
        }

        impl<$($name: ToWords),*> ToWords for ($($name,)*) {
            const WORDS: u32 = 0 $(+ $name::WORDS)*;
            #[inline]
            fn write<S: Sink>(self, sink: &mut S) {
                $(self.$field.write(sink);)*
            }
        }
    };
}

tuple!(A: 0);
tuple!(A: 0, B: 1);
tuple!(A: 0, B: 1, C: 2);
tuple!(A: 0, B: 1, C: 2, D: 3);
tuple!(A: 0, B: 1, C: 2, D: 3, E: 4);
tuple!(A: 0, B: 1, C: 2, D: 3, E: 4, F: 5);
tuple!(A: 0, B: 1, C: 2, D: 3, E: 4, F: 5, G: 6);
tuple!(A: 0, B: 1, C: 2, D: 3, E: 4, F: 5, G: 6, H: 7);

/// Words in memory as a [`Source`].
pub struct Reader<'a>(pub core::slice::Iter<'a, u32>);

impl Source for Reader<'_> {
    fn next(&mut self) -> u32 {
        self.0.next().copied().unwrap_or(0)
    }
}

/// Words in memory as a [`Sink`].
pub struct Writer<'a>(pub core::slice::IterMut<'a, u32>);

impl Sink for Writer<'_> {
    fn put(&mut self, word: u32) {
        if let Some(place) = self.0.next() {
            *place = word;
        }
    }
}
