use super::*;
use proptest::prelude::*;
use relievo_kernel::Argument as KernelArgument;

/// A kernel with one argument of `words` words of that kind.
fn kernel(words: u32, kind: Kind) -> Kernel {
    let argument = KernelArgument::new(words, Domain::new("tested", kind));
    Kernel {
        name: "tested",
        arguments: Vec::leak(vec![argument]),
        input_words: words,
        output_words: 1,
        run: |_, _| {},
    }
}

fn inputs(words: u32, kind: Kind, recorded: &Recorded, count: usize) -> Vec<u32> {
    let generator = Generator::new(&kernel(words, kind), recorded, 7).expect("a domain");
    let mut inputs = vec![u32::MAX; count * words as usize];
    generator.fill(0, &mut inputs);
    inputs
}

/// Draws inputs of one distribution, one word each.
fn of(distribution: Distribution, kind: Kind, count: usize) -> Vec<f32> {
    (0..)
        .zip(inputs(1, kind, &Recorded::new(), 4 * count))
        .filter(|&(index, _)| Distribution::of(index) == distribution)
        .map(|(_, word)| f32::from_bits(word))
        .collect()
}

fn normal() -> impl Strategy<Value = f32> {
    (0x0080_0000_u32..=0x7f7f_ffff).prop_map(f32::from_bits)
}

fn sorted<T: PartialOrd>(a: T, b: T) -> (T, T) {
    if a <= b { (a, b) } else { (b, a) }
}

fn any_kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        (normal(), normal()).prop_map(|(a, b)| {
            let (low, high) = sorted(a, b);
            Kind::Magnitude { low, high }
        }),
        (normal(), normal()).prop_map(|(a, b)| {
            let (low, high) = sorted(a, b);
            Kind::NonZero { low, high }
        }),
        // Ends like those of real domains: of either sign, zero or close together.
        (-64..64_i32, 0..64_i32, 0..90_i32).prop_map(|(low, width, scale)| {
            let unit = 2.0_f32.powi(30 - scale);
            let low = low as f32 * unit;
            let high = low + width as f32 * unit;
            Kind::Range { low, high }
        }),
        Just(Kind::UnitVector),
        Just(Kind::Bits),
        (any::<u32>(), any::<u32>()).prop_map(|(a, b)| {
            let (low, high) = sorted(a, b);
            Kind::Integer { low, high }
        }),
    ]
}

/// Restates the documentation of [`Kind`].
fn is_allowed(kind: Kind, words: &[u32]) -> bool {
    let numbers = || words.iter().map(|&word| f32::from_bits(word));
    let is_number = |x: f32| x.is_normal() || x.to_bits() == 0;
    match kind {
        Kind::Bits => true,
        Kind::Magnitude { low, high } => {
            numbers().all(|x| is_number(x) && (x == 0.0 || low <= x.abs() && x.abs() <= high))
        }
        Kind::NonZero { low, high } => {
            numbers().all(|x| x.is_normal() && low <= x.abs() && x.abs() <= high)
        }
        Kind::Range { low, high } => numbers().all(|x| {
            is_number(x) && low <= x && x <= high && (x == 0.0 || x.abs() >= 2.0_f32.powi(-20))
        }),
        Kind::Integer { low, high } => words.iter().all(|&x| low <= x && x <= high),
        Kind::UnitVector => words.chunks(3).all(|vector| {
            let squares = vector
                .iter()
                .map(|&x| f64::from(f32::from_bits(x)).powi(2))
                .sum::<f64>();
            (squares.sqrt() - 1.0).abs() < 1e-6
                && vector.iter().all(|&x| is_number(f32::from_bits(x)))
        }),
    }
}

proptest! {
    #[test]
    fn inputs_are_in_their_domain(kind in any_kind(), seed in any::<u64>(), pool in proptest::collection::vec(any::<u32>(), 0..40)) {
        let recorded = Recorded::from([("tested".to_string(), pool)]);
        if let Ok(generator) = Generator::new(&kernel(6, kind), &recorded, seed) {
            let mut inputs = vec![0x7fc0_0000; 6 * 400];
            generator.fill(seed % 1000, &mut inputs);
            for input in inputs.chunks(6) {
                prop_assert!(is_allowed(kind, input), "{kind:?} {input:x?}");
                prop_assert!(contains(kind, input), "{kind:?} {input:x?}");
            }
        } else {
            // Only a range may be empty.
            let Kind::Range { low, high } = kind else { panic!("{kind:?}") };
            let smallest = 2.0_f32.powi(-20);
            prop_assert!(low > 0.0 && high < smallest || high < 0.0 && -low < smallest, "{kind:?}");
        }
    }
}

#[test]
fn parts_of_an_argument_have_their_own_domains() {
    const PARTS: [KernelArgument; 2] = [
        KernelArgument::new(1, Domain::integer("number", 3, 5)),
        KernelArgument::new(2, Domain::range("fraction", 0.5, 1.0)),
    ];
    const WHOLE: [KernelArgument; 1] = [KernelArgument {
        words: 3,
        domain: Domain::integer("nothing", 0, 0),
        parts: &PARTS,
    }];
    let kernel = Kernel {
        arguments: &WHOLE,
        ..kernel(3, Kind::Bits)
    };
    let generator = Generator::new(&kernel, &Recorded::new(), 7).expect("domains");
    let mut inputs = [0; 3 * 100];
    generator.fill(0, &mut inputs);
    for input in inputs.chunks(3) {
        assert!((3..=5).contains(&input[0]));
        assert!(contains(PARTS[1].domain.kind, &input[1..]), "{input:x?}");
    }
}

#[test]
fn the_check_of_domains_can_fail() {
    let kind = Kind::Range {
        low: -1.0,
        high: 1.0,
    };
    for value in [1.1, f32::NAN, 1e-20, 1e-40, f32::INFINITY] {
        assert!(!contains(kind, &[0, value.to_bits()]), "{value}");
        assert!(!is_allowed(kind, &[0, value.to_bits()]), "{value}");
    }
    let long = [1.0_f32, 0.01, 0.0].map(f32::to_bits);
    assert!(!contains(Kind::UnitVector, &long));
    assert!(!contains(Kind::UnitVector, &long[..2]));
    assert!(!contains(Kind::Integer { low: 1, high: 2 }, &[3]));
}

#[test]
fn threads_and_batches_change_nothing() {
    let kind = Kind::Magnitude {
        low: 1e-18,
        high: 1e18,
    };
    let generator = Generator::new(&kernel(3, kind), &Recorded::new(), 1).expect("a domain");
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut inputs = vec![0; 3 * 10_000];
        pool.install(|| generator.fill(0, &mut inputs));
        inputs
    };
    let whole = with_threads(1);
    assert_eq!(whole, with_threads(3));
    let mut second = vec![0; 3 * 3000];
    generator.fill(7000, &mut second);
    assert_eq!(whole[3 * 7000..], second);
    let other = Generator::new(&kernel(3, kind), &Recorded::new(), 2).expect("a domain");
    other.fill(7000, &mut second);
    let equal = whole[3 * 7000..].iter().zip(&second);
    assert!(equal.filter(|(a, b)| a == b).count() < 1000);
}

#[test]
fn bits_reach_every_exponent_and_values_are_spread_evenly() {
    let kind = Kind::Magnitude {
        low: 2.0_f32.powi(-60),
        high: 2.0_f32.powi(60),
    };
    let mut exponents = [[0; 2]; 120];
    for x in of(Distribution::Bits, kind, 40_000) {
        let exponent = (x.to_bits() >> 23 & 255) as usize - 67;
        if exponent < 120 {
            exponents[exponent][usize::from(x < 0.0)] += 1;
        }
    }
    assert!(exponents.as_flattened().iter().all(|&count| count > 80));

    let kind = Kind::Range {
        low: -3.0,
        high: 5.0,
    };
    let mut eighths = [0; 8];
    for x in of(Distribution::Value, kind, 40_000) {
        eighths[(x + 3.0).min(7.5) as usize] += 1;
    }
    assert!(eighths.iter().all(|count| (4500..5500).contains(count)));
}

#[test]
fn edges_are_reached() {
    let kind = Kind::Range {
        low: -100.0,
        high: 7.5,
    };
    let edges = of(Distribution::Edges, kind, 40_000);
    let third = 1.0 / 3.0;
    for wanted in [
        0.0,
        1.0,
        -1.0,
        third,
        -100.0,
        7.5,
        f32::next_down(7.5),
        f32::next_up(-100.0),
        f32::next_up(1.0),
        f32::next_down(1.0),
        f32::next_down(2.0_f32.powi(-10)),
        2.0_f32.powi(-20),
        -7.0,
    ] {
        assert!(edges.contains(&wanted), "{wanted}");
    }
    let pairs = inputs(2, kind, &Recorded::new(), 40_000);
    let mut related = [0; 3];
    for pair in pairs.chunks(2) {
        let [a, b] = [pair[0], pair[1]].map(f32::from_bits);
        related[0] += usize::from(a == b && a != 0.0);
        related[1] += usize::from(a == -b && a != 0.0);
        related[2] += usize::from(b == a.next_up() || b == a.next_down());
    }
    assert!(related.iter().all(|&count| count > 50), "{related:?}");

    let words = inputs(
        1,
        Kind::Integer {
            low: 3,
            high: u32::MAX,
        },
        &Recorded::new(),
        40_000,
    );
    for wanted in [3, 4, 255, 256, 1 << 24, (1 << 24) + 1, 1 << 31, u32::MAX] {
        assert!(words.contains(&wanted), "{wanted}");
    }
}

#[test]
fn unit_vectors_reach_axes_and_all_sides() {
    let words = inputs(3, Kind::UnitVector, &Recorded::new(), 40_000);
    let vectors: Vec<[f32; 3]> = words
        .as_chunks()
        .0
        .iter()
        .map(|v: &[u32; 3]| v.map(f32::from_bits))
        .collect();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut wanted = [0.0; 3];
            wanted[axis] = sign;
            assert!(vectors.contains(&wanted), "{wanted:?}");
        }
    }
    // Uniform in value: by Archimedes each coordinate is uniform.
    let mut tenths = [[0; 10]; 3];
    for vector in vectors.iter().skip(1).step_by(4) {
        for (tenths, x) in tenths.iter_mut().zip(vector) {
            tenths[((x + 1.0) * 5.0).min(9.5) as usize] += 1;
        }
    }
    let even = tenths.as_flattened().iter();
    assert!(even.clone().all(|n| (850..1150).contains(n)), "{tenths:?}");
    let smallest = vectors.iter().flatten().filter(|x| **x != 0.0);
    assert!(smallest.map(|x| x.abs()).fold(1.0, f32::min) < 4e-6);
}

#[test]
fn recorded_values_are_used_where_the_domain_has_them() {
    let kind = Kind::Range {
        low: 0.0,
        high: 9.0,
    };
    let pool: Vec<u32> = [1.25_f32, -0.0, 77.0, f32::NAN].map(f32::to_bits).to_vec();
    let recorded = Recorded::from([("tested".to_string(), pool)]);
    let words = inputs(1, kind, &recorded, 4000);
    for word in words.iter().skip(3).step_by(4) {
        assert!([1.25_f32.to_bits(), 0].contains(word), "{word:x}");
    }
    let vectors: Vec<u32> = [0.0_f32, 0.6, 0.8, 1.0, 1.0, 1.0]
        .map(f32::to_bits)
        .to_vec();
    let recorded = Recorded::from([("tested".to_string(), vectors.clone())]);
    let words = inputs(3, Kind::UnitVector, &recorded, 4000);
    for vector in words.chunks(3).skip(3).step_by(4) {
        assert_eq!(vector, &vectors[..3]);
    }
    // The highest bit of an integer is not a sign.
    let recorded = Recorded::from([("tested".to_string(), vec![1 << 31])]);
    let kind = Kind::Integer {
        low: 0,
        high: u32::MAX,
    };
    assert_eq!(inputs(1, kind, &recorded, 4)[3], 1 << 31);
}

#[test]
fn invalid_domains_are_rejected_by_name() {
    let refused = |words, kind| {
        let error = Generator::new(&kernel(words, kind), &Recorded::new(), 0).err();
        error.expect("refused").to_string()
    };
    let (low, high) = (2.0, 1.0);
    assert!(refused(1, Kind::Range { low, high }).contains("\"tested\""));
    assert!(refused(1, Kind::Magnitude { low, high }).contains("low"));
    let (low, high) = (0.0, f32::NAN);
    assert!(refused(1, Kind::NonZero { low, high }).contains("low"));
    assert!(refused(1, Kind::Range { low, high }).contains("finite"));
    let (low, high) = (1e-30, 1e-29);
    assert!(refused(1, Kind::Range { low, high }).contains("empty"));
    assert!(refused(1, Kind::Integer { low: 2, high: 1 }).contains("low"));
    assert!(refused(4, Kind::UnitVector).contains("three"));
}

#[test]
fn bits_of_one_word_are_all_words() {
    let any = Generator::new(&kernel(1, Kind::Bits), &Recorded::new(), 3).expect("a domain");
    let mut words = vec![0; 1 << 20];
    any.fill(0, &mut words);
    // Spread: the words of a 2²⁰th of all inputs have 2²⁰ different upper digits, but for
    // the gaps of a sequence whose steps are the golden ratio.
    words.sort_unstable();
    let gaps = words.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(gaps.clone().min() > Some(1000) && gaps.max() < Some(10_000));
    // Later inputs are others.
    let mut later = [0; 1000];
    any.fill(1 << 30, &mut later);
    assert!(later.iter().all(|word| words.binary_search(word).is_err()));
}
