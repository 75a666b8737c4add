//! Lists of functions that must give the same words on GPU and CPU, compiled for both.
//!
//! A project lists its functions once, in a macro that takes another macro:
//!
//! ```
//! use relievo_kernel::{Domain, Kernel, Kind, table};
//! const NUMBER: Domain = Domain::new("number", Kind::Magnitude { low: 1e-18, high: 1e18 });
//!
//! fn half(x: f32) -> f32 {
//!     0.5 * x
//! }
//!
//! macro_rules! for_each_kernel {
//!     ($with:ident) => {
//!         $with! {
//!             half(f32: NUMBER) -> f32 = half;
//!         }
//!     };
//! }
//! const TABLE: &[Kernel] = for_each_kernel!(table);
//! assert_eq!(TABLE[0].name, "half");
//! ```
//!
//! An argument has a type that implements [`FromWords`] and the [`Domain`] of its values;
//! a result implements [`ToWords`].
//!
//! In the shader crate, `for_each_kernel!(entry_points);` makes a compute shader of each
//! function (feature `spirv`). In tests, `for_each_kernel!(table)` is the list of the same functions for
//! the CPU, with their arguments. `relievo-bitwise` generates arguments, runs both and
//! counts the words that differ. Arguments and results are u32 words in storage buffers,
//! so that nothing is rounded, filtered or interpolated on the way.
#![no_std]
// Only buffers of shaders are read without a check.
#![cfg_attr(not(feature = "spirv"), forbid(unsafe_code))]

#[cfg(feature = "spirv")]
pub mod buffers;

use glam::{IVec2, IVec3, IVec4, Mat2, Mat3, Mat4, UVec2, UVec3, UVec4, Vec2, Vec3, Vec4};

/// Invocations in a compute shader's workgroup; the number of inputs is a multiple of it.
pub const WORKGROUP: u32 = 64;

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

/// Types of arguments.
pub trait FromWords: Sized {
    /// Number of words.
    const WORDS: u32;
    /// Reads the value from a source.
    fn read<S: Source>(source: &mut S) -> Self;
}

/// Types of results.
pub trait ToWords {
    /// Number of words.
    const WORDS: u32;
    /// Writes the value to a sink.
    fn write<S: Sink>(self, sink: &mut S);
}

/// A number of one word.
macro_rules! number {
    ($type:ty, $word:ident => $from:expr, $value:ident => $to:expr) => {
        impl FromWords for $type {
            const WORDS: u32 = 1;
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

number!(u32, word => word, value => value);
number!(i32, word => word as i32, value => value as u32);
// The sign of zero may not be observed: −0 is normalised to +0.
number!(f32, word => f32::from_bits(word), value => if value == 0.0 { 0 } else { value.to_bits() });
number!(bool, word => word != 0, value => if value { 1 } else { 0 });

/// A vector or a matrix: its components or columns in turn.
macro_rules! parts {
    ($type:ident of $part:ty: $new:ident($($field:ident),*)) => {
        impl FromWords for $type {
            const WORDS: u32 = 0 $(+ { let _ = stringify!($field); <$part as FromWords>::WORDS })*;
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

/// Several results of one function.
macro_rules! tuple {
    ($($name:ident: $field:tt),*) => {
        impl<$($name: ToWords),*> ToWords for ($($name,)*) {
            const WORDS: u32 = 0 $(+ $name::WORDS)*;
            #[inline]
            fn write<S: Sink>(self, sink: &mut S) {
                $(self.$field.write(sink);)*
            }
        }
    };
}

tuple!(A: 0, B: 1);
tuple!(A: 0, B: 1, C: 2);
tuple!(A: 0, B: 1, C: 2, D: 3);

/// Values of an argument: of each of its scalars, unless the kind says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Meaning of the number; values recorded under this name are tried, too.
    pub name: &'static str,
    /// The values.
    pub kind: Kind,
}

/// A set of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Zero, or of either sign and of a magnitude in `low..=high`, 0 < low.
    Magnitude {
        /// Smallest magnitude that is not zero.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// Of either sign and of a magnitude in `low..=high`, never zero.
    NonZero {
        /// The smallest magnitude.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// From `low` to `high`, both included; no magnitudes below 2⁻²⁰ but
    /// zero, so that products of several are normal numbers.
    Range {
        /// The smallest.
        low: f32,
        /// The largest.
        high: f32,
    },
    /// Three scalars: a vector of length 1, but for rounding; no magnitudes
    /// below 2⁻²⁰ but zero.
    UnitVector,
    /// Any bits. Of a function of one word, input i is i times an odd number: 2³² inputs
    /// are every word, once.
    Bits,
    /// A whole number from `low` to `high`, both included, as u32.
    Integer {
        /// The smallest.
        low: u32,
        /// The largest.
        high: u32,
    },
}

impl Domain {
    /// Returns a domain.
    pub const fn new(name: &'static str, kind: Kind) -> Domain {
        Domain { name, kind }
    }
}

/// One argument of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Argument {
    /// Number of its words.
    pub words: u32,
    /// Its values.
    pub domain: Domain,
}

/// A function for the CPU; the compute shader of the same name is the same function.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name, also of the entry point.
    pub name: &'static str,
    /// Its arguments in their order.
    pub arguments: &'static [Argument],
    /// Words of all arguments together.
    pub input_words: u32,
    /// Words of the result.
    pub output_words: u32,
    /// Runs it on every group of `input_words` words of the first slice, and writes
    /// `output_words` words each to the second.
    pub run: fn(&[u32], &mut [u32]),
}

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

/// Makes a `&[Kernel]` of a list of kernels, for the CPU.
#[macro_export]
macro_rules! table {
    ($($(#[$doc:meta])* $name:ident($($value:ty: $domain:expr),* $(,)?) -> $result:ty = $function:expr;)*) => {
        &[$({
            const INPUT: u32 = 0 $(+ <$value as $crate::FromWords>::WORDS)*;
            const OUTPUT: u32 = <$result as $crate::ToWords>::WORDS;
            $crate::Kernel {
                name: stringify!($name),
                arguments: &[$($crate::Argument {
                    words: <$value as $crate::FromWords>::WORDS,
                    domain: $domain,
                }),*],
                input_words: INPUT,
                output_words: OUTPUT,
                run: |inputs, outputs| {
                    let inputs = inputs.chunks_exact(INPUT as usize);
                    let outputs = outputs.chunks_exact_mut(OUTPUT as usize);
                    for (input, output) in inputs.zip(outputs) {
                        let mut reader = $crate::Reader(input.iter());
                        let result: $result =
                            $function($(<$value as $crate::FromWords>::read(&mut reader)),*);
                        $crate::ToWords::write(result, &mut $crate::Writer(output.iter_mut()));
                    }
                },
            }
        }),*]
    };
}

/// Makes a compute shader of each kernel of a list. The crate depends on `spirv-std`, and
/// on this crate with the feature `spirv`.
#[macro_export]
macro_rules! entry_points {
    ($($(#[$doc:meta])* $name:ident($($value:ty: $domain:expr),* $(,)?) -> $result:ty = $function:expr;)*) => {
        $(
            #[doc = concat!("Runs `", stringify!($function), "` on input number x.")]
            #[spirv_std::spirv(compute(threads(64)))]
            pub fn $name(
                #[spirv(global_invocation_id)] id: spirv_std::glam::UVec3,
                #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] inputs: &[u32],
                #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] outputs: &mut [u32],
            ) {
                const INPUT: u32 = 0 $(+ <$value as $crate::FromWords>::WORDS)*;
                const OUTPUT: u32 = <$result as $crate::ToWords>::WORDS;
                // SAFETY: the runner binds the words of all invocations.
                let (mut source, mut sink) = unsafe {
                    (
                        $crate::buffers::Input::new(inputs, id.x * INPUT),
                        $crate::buffers::Output::new(outputs, id.x * OUTPUT),
                    )
                };
                let result: $result =
                    $function($(<$value as $crate::FromWords>::read(&mut source)),*);
                $crate::ToWords::write(result, &mut sink);
            }
        )*
    };
}

/// Calls the macro `$with` with every canary: operations that tell whether a device has the
/// properties that exact modules rely on, and others. Callers have [`canary`] in scope.
#[macro_export]
macro_rules! for_each_canary {
    ($with:ident) => {
        $with! {
            multiply_add(f32: canary::NUMBER, f32: canary::NUMBER, f32: canary::NUMBER) -> f32 = canary::multiply_add;
            dot3(Vec3: canary::NUMBER, Vec3: canary::NUMBER) -> f32 = canary::dot3;
            factoring(f32: canary::NUMBER, f32: canary::NUMBER, f32: canary::NUMBER) -> f32 = canary::factoring;
            cancelling(f32: canary::NUMBER, f32: canary::NUMBER) -> f32 = canary::cancelling;
            whole_number(u32: canary::WHOLE) -> f32 = canary::whole_number;
            truncation(f32: canary::TRUNCATED) -> i32 = canary::truncation;
            third(f32: canary::NUMBER) -> f32 = canary::third;
            native_division(f32: canary::NUMBER, f32: canary::NUMBER) -> f32 = canary::native_division;
            native_root(f32: canary::NUMBER) -> f32 = canary::native_root;
            denormal(f32: canary::TINY) -> f32 = canary::denormal;
            negative_zero(f32: canary::NUMBER) -> u32 = canary::negative_zero;
        }
    };
}

pub mod canary;

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Domain = Domain::new(
        "any",
        Kind::Range {
            low: -8.0,
            high: 8.0,
        },
    );

    fn add(a: Vec3, b: f32) -> (Vec3, bool) {
        (a + Vec3::splat(b), b > 0.0)
    }

    macro_rules! for_each_kernel {
        ($with:ident) => {
            $with! {
                add(Vec3: ANY, f32: ANY) -> (Vec3, bool) = add;
                next(u32: ANY) -> u32 = |x: u32| x + 1;
            }
        };
    }

    const TABLE: &[Kernel] = for_each_kernel!(table);

    /// Returns whether `value` is what its words are read as.
    fn returns<T: FromWords + ToWords + Copy + PartialEq>(value: T) -> bool {
        let mut words = [7; 20];
        value.write(&mut Writer(words.iter_mut()));
        let written = <T as ToWords>::WORDS as usize;
        words[written..].iter().all(|&word| word == 7)
            && T::read(&mut Reader(words.iter())) == value
    }

    #[test]
    fn values_return_from_their_words() {
        assert!(returns(Vec4::new(1.0, 2.0, 3.0, -4.0)) && returns(Vec2::Y));
        assert!(returns(IVec3::new(-1, 2, i32::MIN)) && returns(UVec4::new(1, 2, 3, u32::MAX)));
        assert!(returns(Mat3::from_cols_array(&[
            1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0
        ])));
        assert!(returns(Mat4::from_diagonal(Vec4::new(1.0, 2.0, 3.0, 4.0))));
        assert!(returns([[1_u32, 2], [3, 4]]) && returns([Vec3::X, Vec3::Y]));
    }

    #[test]
    fn the_table_runs_what_it_lists() {
        let [add, next] = TABLE else { panic!() };
        assert_eq!((add.name, add.input_words, add.output_words), ("add", 4, 4));
        assert_eq!(add.arguments.iter().map(|a| a.words).sum::<u32>(), 4);
        let inputs = [1.0f32, 2.0, 3.0, 0.5, 0.0, 0.0, 0.0, -1.0].map(f32::to_bits);
        let mut outputs = [7; 8];
        (add.run)(&inputs, &mut outputs);
        let expected = [1.5f32, 2.5, 3.5].map(f32::to_bits);
        assert_eq!(outputs[..4], [expected[0], expected[1], expected[2], 1]);
        assert_eq!(outputs[7], 0);
        let mut words = [0; 2];
        (next.run)(&[4, 5], &mut words);
        assert_eq!(words, [5, 6]);
    }
}
