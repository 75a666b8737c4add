//! The derives, as a project uses them.
#![cfg(feature = "macros")]

use relievo_kernel::domain::{INTEGER, NUMBER, UNIT};
use relievo_kernel::glam::Vec3;
use relievo_kernel::{Domain, FromWords, Kind, Reader, ToWords, Writer};

/// Returns the words of a value, and 7 for each after them.
macro_rules! words {
    ($value:expr, $length:literal) => {{
        let mut words = [7; $length];
        $value.write(&mut Writer(words.iter_mut()));
        words
    }};
}

#[derive(Clone, Copy, Debug, PartialEq, FromWords, ToWords)]
struct Ball {
    #[domain(-4.0..=4.0)]
    center: Vec3,
    #[domain(0.5..=2.0)]
    radius: f32,
    color: Color,
    marks: [Mark; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, FromWords, ToWords)]
struct Mark(#[domain(UNIT)] Vec3, u32);

#[derive(Clone, Copy, Debug, PartialEq, FromWords, ToWords)]
struct Nothing;

#[derive(Clone, Copy, Debug, PartialEq, FromWords, ToWords)]
enum Color {
    Red,
    Green,
    Blue,
}

#[test]
fn structs_and_enums_return_from_their_words() {
    let ball = Ball {
        center: Vec3::new(1.0, 2.0, 3.0),
        radius: 0.5,
        color: Color::Blue,
        marks: [Mark(Vec3::X, 5), Mark(Vec3::Y, 6)],
    };
    assert_eq!(<Ball as FromWords>::WORDS, 13);
    let words = words!(ball, 13);
    assert_eq!(words[4..6], [2, 1.0_f32.to_bits()]);
    assert_eq!(Ball::read(&mut Reader(words.iter())), ball);
    assert_eq!(<Nothing as ToWords>::WORDS, 0);
    assert_eq!(words!(Nothing, 1), [7]);
    for (number, color) in [
        (0, Color::Red),
        (1, Color::Green),
        (2, Color::Blue),
        (9, Color::Red),
    ] {
        assert_eq!(Color::read(&mut Reader([number].iter())), color);
    }
}

#[test]
fn fields_have_the_domains_of_their_attributes_or_types() {
    let parts = <Ball as FromWords>::ARGUMENT.parts;
    assert_eq!(parts[0].domain, Domain::range("center", -4.0, 4.0));
    assert_eq!((parts[0].words, parts[1].words), (3, 1));
    assert_eq!(parts[1].domain, Domain::range("radius", 0.5, 2.0));
    assert_eq!(parts[2].domain.kind, Kind::Integer { low: 0, high: 2 });
    let marks = parts[3].parts;
    assert_eq!((marks.len(), marks[1].words), (2, 4));
    assert_eq!(marks[1].parts[0].domain, UNIT);
    assert_eq!(marks[1].parts[1].domain, INTEGER);
    assert_eq!(<[f32; 3]>::ARGUMENT.parts[2].domain, NUMBER);
}
