//! Lists of functions that must give the same words on GPU and CPU, compiled for both.
//!
//! The attribute [`kernel`] (feature `macros`) turns a function into a compute shader, a
//! [`Kernel`] for the CPU and a test that compares both (see `relievo-test`):
//!
//! ```
//! # #[cfg(feature = "macros")]
//! # mod reflection {
//! use relievo_kernel::{domain::UNIT, glam::Vec3, kernel};
//!
//! /// Reflects a direction.
//! #[kernel(direction in UNIT, normal in UNIT)]
//! pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
//!     direction - normal * (2.0 * direction.dot(normal))
//! }
//!
//! const KERNEL: relievo_kernel::Kernel = reflect::KERNEL;
//! # }
//! # fn main() {}
//! ```
//!
//! Projects whose functions and shaders lie in different crates list them once, in a macro
//! that takes another macro:
//!
//! ```
//! use relievo_kernel::{Kernel, domain::NUMBER, table};
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
//! In the shader crate, `for_each_kernel!(entry_points);` makes a compute shader of each.
//!
//! An argument has a type that implements [`FromWords`] and a [`Domain`] of values that are
//! tried; a result implements [`ToWords`]. `relievo-bitwise` generates arguments, runs both
//! sides and counts the words that differ. Arguments and results are u32 words in storage
//! buffers, so that nothing is rounded, filtered or interpolated on the way.
#![no_std]
// Only buffers of shaders are read without a check.
#![cfg_attr(not(target_arch = "spirv"), forbid(unsafe_code))]

#[cfg(target_arch = "spirv")]
pub mod buffers;
pub mod canary;
pub mod domain;
pub mod screen;
mod words;

pub use domain::{Domain, Kind};
pub use glam;
#[cfg(feature = "macros")]
pub use relievo_kernel_macros::{FromWords, ToWords, kernel};
pub use words::{FromWords, Reader, Sink, Source, ToWords, Writer};

/// Invocations in a compute shader's workgroup; the number of inputs is a multiple of it.
pub const WORKGROUP: u32 = 64;

/// One argument of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Argument {
    /// Number of its words.
    pub words: u32,
    /// Its values, if it has no parts.
    pub domain: Domain,
    /// Its fields or elements, if they have domains of their own.
    pub parts: &'static [Argument],
}

impl Argument {
    /// Returns an argument without parts.
    pub const fn new(words: u32, domain: Domain) -> Argument {
        Argument {
            words,
            domain,
            parts: &[],
        }
    }

    /// Returns an argument like `default`, with values of `domain`.
    ///
    /// # Panics
    /// At compile time, where it is a constant: if the domain is of integers and the argument
    /// has floats, or the other way round; if it is empty; if it is of unit vectors and the
    /// argument is none.
    pub const fn given(default: Argument, domain: Domain) -> Argument {
        let fits = match domain.kind {
            Kind::Bits => true,
            Kind::Integer { low, high } => {
                assert!(
                    low <= high,
                    "the domain is empty: its low end is above the high one"
                );
                default.is_of(true)
            }
            Kind::Range { low, high } => {
                assert!(
                    low <= high,
                    "the domain is empty: its low end is above the high one"
                );
                default.is_of(false)
            }
            Kind::UnitVector => {
                assert!(
                    default.words.is_multiple_of(3),
                    "unit vectors have three components"
                );
                default.is_of(false)
            }
            Kind::Magnitude { .. } | Kind::NonZero { .. } => default.is_of(false),
        };
        assert!(
            fits,
            "the values are not of the argument's type: write 0.0..=1.0 for f32, 0..=9 for integers, and #[domain(..)] at the fields of a struct that has both"
        );
        Argument::new(default.words, domain)
    }

    /// Returns whether all its words are integers, or all floats.
    const fn is_of(&self, integers: bool) -> bool {
        if self.parts.is_empty() {
            return matches!(self.domain.kind, Kind::Integer { .. }) == integers;
        }
        let mut i = 0;
        while i < self.parts.len() {
            if !self.parts[i].is_of(integers) {
                return false;
            }
            i += 1;
        }
        true
    }
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

/// Calls a function on every group of `input_words` words, and writes its results.
pub fn for_each_input<R: ToWords>(
    input_words: u32,
    inputs: &[u32],
    outputs: &mut [u32],
    function: impl Fn(&mut Reader) -> R,
) {
    // Chunks must not be empty, even without words.
    let inputs = inputs.chunks_exact(input_words.max(1) as usize);
    let outputs = outputs.chunks_exact_mut(R::WORDS.max(1) as usize);
    for (input, output) in inputs.zip(outputs) {
        let (mut reader, mut writer) = (Reader(input.iter()), Writer(output.iter_mut()));
        function(&mut reader).write(&mut writer);
        // On a GPU, whose buffers are read unchecked, a wrong number would go astray.
        assert!(
            reader.0.len() == 0 && writer.0.len() == 0,
            "an implementation of FromWords or ToWords has another number of words than it says"
        );
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
                arguments: &[$($crate::Argument::new(
                    <$value as $crate::FromWords>::WORDS,
                    $domain,
                )),*],
                input_words: INPUT,
                output_words: OUTPUT,
                run: |inputs, outputs| {
                    $crate::for_each_input(INPUT, inputs, outputs, |reader| -> $result {
                        $function($(<$value as $crate::FromWords>::read(reader)),*)
                    })
                },
            }
        }),*]
    };
}

/// Makes a compute shader of each kernel of a list, where the target is SPIR-V. The crate
/// depends on `spirv-std`.
#[macro_export]
macro_rules! entry_points {
    ($($(#[$doc:meta])* $name:ident($($value:ty: $domain:expr),* $(,)?) -> $result:ty = $function:expr;)*) => {
        $(
            #[cfg(target_arch = "spirv")]
            #[doc = concat!("Runs `", stringify!($function), "` on input number x.")]
            #[spirv_std::spirv(compute(threads(64)))]
            pub fn $name(
                #[spirv(global_invocation_id)] id: spirv_std::glam::UVec3,
                #[spirv(storage_buffer, descriptor_set = 0, binding = 0)] inputs: &[u32],
                #[spirv(storage_buffer, descriptor_set = 0, binding = 1)] outputs: &mut [u32],
            ) {
                const INPUT: u32 = 0 $(+ <$value as $crate::FromWords>::WORDS)*;
                // SAFETY: the runner binds the words of all invocations.
                unsafe {
                    $crate::buffers::run(id.x, INPUT, inputs, outputs, |source| -> $result {
                        $function($(<$value as $crate::FromWords>::read(source)),*)
                    });
                }
            }
        )*
    };
}

/// Calls the macro `$with` with every canary: operations that tell whether a device has the
/// properties that exact modules rely on, and others.
#[macro_export]
macro_rules! for_each_canary {
    ($($with:tt)+) => {
        $($with)+! {
            multiply_add(f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER) -> f32 = $crate::canary::multiply_add;
            dot3($crate::glam::Vec3: $crate::canary::NUMBER, $crate::glam::Vec3: $crate::canary::NUMBER) -> f32 = $crate::canary::dot3;
            factoring(f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER) -> f32 = $crate::canary::factoring;
            cancelling(f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER) -> f32 = $crate::canary::cancelling;
            whole_number(u32: $crate::canary::WHOLE) -> f32 = $crate::canary::whole_number;
            truncation(f32: $crate::canary::TRUNCATED) -> i32 = $crate::canary::truncation;
            fused(f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER) -> $crate::glam::Vec2 = $crate::canary::fused;
            third(f32: $crate::canary::NUMBER) -> f32 = $crate::canary::third;
            native_division(f32: $crate::canary::NUMBER, f32: $crate::canary::NUMBER) -> f32 = $crate::canary::native_division;
            native_root(f32: $crate::canary::NUMBER) -> f32 = $crate::canary::native_root;
            denormal(f32: $crate::canary::TINY) -> f32 = $crate::canary::denormal;
            negative_zero(f32: $crate::canary::NUMBER) -> u32 = $crate::canary::negative_zero;
        }
    };
}

/// Makes a compute shader of each canary, where the target is SPIR-V.
#[macro_export]
macro_rules! canaries {
    () => {
        #[cfg(target_arch = "spirv")]
        #[doc(hidden)]
        pub mod canaries {
            $crate::for_each_canary!($crate::entry_points);
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::domain::ANY;
    use glam::{IVec3, Mat3, Mat4, UVec4, Vec2, Vec3, Vec4};

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
        assert!(returns((Vec3::X, 7_u32, true)));
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
