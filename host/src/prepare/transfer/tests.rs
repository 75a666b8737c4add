use super::*;
use crate::budget::plan_with;
use crate::prepare::Assets;
use crate::render::{CpuRenderer, Renderer};
use crate::scene::{Environment, Layer, Scene, Tier};
use proptest::prelude::*;
use std::path::Path;
use std::sync::LazyLock;

/// Loads a scene of `assets/scenes`, for a small picture with small shadow maps.
fn load(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes");
    let mut scene = Scene::load(&folder.join(format!("{name}.toml"))).unwrap();
    scene.size = [80, 60];
    scene.supersampling = 1;
    for light in &mut scene.lights {
        light.shadow_size = 64;
    }
    scene
}

fn prepare(scene: &Scene, assets: &mut Assets) -> PreparedScene {
    plan_with(scene, assets, &|_| ()).unwrap().scene
}

fn words(scene: &PreparedScene) -> Vec<[u32; 4]> {
    CpuRenderer::new(scene).color(&scene.frame).unwrap().words
}

/// Returns the addresses of what the objects share.
fn addresses(scene: &PreparedScene) -> Vec<[usize; 5]> {
    fn address<T>(part: &Arc<T>) -> usize {
        Arc::as_ptr(part).addr()
    }
    let objects = scene.objects.iter().map(|object| {
        [
            address(&object.triangles),
            address(&object.prisms),
            address(&object.map),
            address(&object.layers),
            address(&object.mesh),
        ]
    });
    objects.collect()
}

/// Returns which objects share what: for each part of an object the first object that has it.
fn sharing(scene: &PreparedScene) -> Vec<[usize; 5]> {
    let all = addresses(scene);
    let first = |part: usize, address| all.iter().position(|other| other[part] == address);
    let objects = all.iter();
    objects
        .map(|own| std::array::from_fn(|part| first(part, own[part]).unwrap()))
        .collect()
}

/// Returns which parts of the objects of `after` are others than those of `before`. Lists of layers
/// always are.
fn changes(before: &PreparedScene, after: &PreparedScene) -> Vec<[bool; 5]> {
    let (before, after) = (addresses(before), addresses(after));
    let objects = before.iter().zip(&after);
    objects
        .map(|(before, after)| std::array::from_fn(|part| before[part] != after[part]))
        .collect()
}

/// A pair of ends.
#[derive(Default)]
struct Line {
    assets: Assets,
    sender: Sender,
    receiver: Receiver,
}

impl Line {
    /// Prepares and sends a scene; returns it as it arrives, and the number of bytes.
    fn deliver(&mut self, scene: &Scene) -> (PreparedScene, usize) {
        let prepared = prepare(scene, &mut self.assets);
        let bytes = self.sender.send([&prepared]);
        let mut received = self.receiver.receive(&bytes).unwrap();
        assert_eq!(received.len(), 1);
        let received = received.remove(0);
        assert!(words(&received) == words(&prepared), "another picture");
        assert_eq!(sharing(&received), sharing(&prepared));
        assert_eq!(received.preparation, prepared.preparation);
        (received, bytes.len())
    }
}

#[test]
fn scenes_arrive_as_they_were_sent() {
    for name in ["torus", "torus_accurate", "windows", "street", "lamp"] {
        let mut line = Line::default();
        let scene = load(name);
        let (first, all) = line.deliver(&scene);
        let (second, rest) = line.deliver(&scene);
        println!(
            "{name}: {} objects, {all} bytes, then {rest}",
            first.objects.len()
        );
        assert_eq!(addresses(&first)[0][4], addresses(&second)[0][4]);
        assert!(rest < all / 4, "{name}");
    }
}

#[test]
fn what_a_plan_chose_arrives() {
    let mut scene = load("torus");
    scene.objects[0].budget = Some(2.0);
    Line::default().deliver(&scene);
    // The surface of this one has a shell of its own.
    scene.objects[0].budget = None;
    scene.objects[0].tier = Tier::Accurate;
    scene.objects[0].raised = true;
    let (received, _) = Line::default().deliver(&scene);
    assert_eq!(
        received.objects[0].mesh.shell(0.1),
        prepare(&scene, &mut Assets::default()).objects[0]
            .mesh
            .shell(0.1)
    );
}

#[test]
fn what_stays_the_same_is_not_sent_again() {
    let mut line = Line::default();
    let mut scene = load("torus");
    let (first, all) = line.deliver(&scene);
    scene.objects[0].extrusion.bevel = 0.1;
    scene.objects[0].depth = Some(0.09);
    let (second, changed) = line.deliver(&scene);
    assert!(changed < 1000, "{changed} of {all} bytes");
    assert_eq!(
        changes(&first, &second),
        [[false, false, false, true, false]]
    );

    // The triangles hold the texture coordinates.
    scene.objects[0].repeat = [12.0, 5.0];
    let triangles = size_of_val(&first.objects[0].triangles[..]);
    let (third, changed) = line.deliver(&scene);
    assert!(
        (triangles..triangles + 1000).contains(&changed),
        "{changed} of {all} bytes, {triangles} of triangles"
    );
    assert_eq!(
        changes(&second, &third),
        [[true, false, false, true, false]]
    );

    // Layers and lights are made anew with each change, but not their maps and pictures.
    let mut line = Line::default();
    let mut scene = load("windows");
    let (_, all) = line.deliver(&scene);
    scene.materials[0].roughness = 0.5;
    let (received, changed) = line.deliver(&scene);
    let facets = size_of_val(&received.lighting.unwrap().facets[..]);
    assert!(
        changed < facets + 10_000,
        "{changed} of {all} bytes, {facets} of facets"
    );
}

#[test]
fn parts_that_are_equal_but_two_stay_two() {
    let mut scene = load("torus");
    scene.objects.push(scene.objects[0].clone());
    scene.objects[1].material.cap = scene.objects[0].material.wall;
    let mut line = Line::default();
    let (first, _) = line.deliver(&scene);
    assert_ne!(addresses(&first)[0][0], addresses(&first)[1][0]);
    // Both are equal to both of the delivery before.
    let (second, _) = line.deliver(&scene);
    assert_eq!(
        changes(&first, &second),
        [[false, false, false, true, false]; 2]
    );
    // One more than there was.
    scene.objects.push(scene.objects[1].clone());
    scene.objects[2].material.cap = scene.objects[0].material.floor;
    line.deliver(&scene);
}

/// A delivery with layers and lights.
static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut scene = load("plane");
    scene.environment = Some(Environment::default());
    let object = &mut scene.objects[0];
    object.tier = Tier::Accurate;
    object.layers.push(Layer {
        shape: object.shape.clone(),
        top: 0.5,
        ..Layer::default()
    });
    Sender::default().send([&prepare(&scene, &mut Assets::default())])
});

/// Returns the bytes with the checksum that they should have.
fn checked(bytes: &[u8]) -> Vec<u8> {
    [bytes, &crc32fast::hash(bytes).to_le_bytes()].concat()
}

#[test]
fn a_delivery_out_of_order_is_an_error() {
    let scene = load("torus");
    let prepared = prepare(&scene, &mut Assets::default());
    let mut sender = Sender::default();
    sender.send([&prepared]);
    let second = sender.send([&prepared]);
    let Err(error) = Receiver::default().receive(&second) else {
        panic!("there is nothing before it");
    };
    assert!(error.to_string().contains("prepare it again"), "{error}");
    assert!(Receiver::default().receive(&checked(&[])).is_err());
    let twice = [&*BYTES, &[0][..]].concat();
    assert!(Receiver::default().receive(&checked(&twice)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn damaged_bytes_are_an_error(
        place in any::<prop::sample::Index>(),
        near in 0..2000_usize,
        bit in 0..8_u32,
    ) {
        for place in [place.index(BYTES.len()), near % BYTES.len()] {
            prop_assert!(Receiver::default().receive(&BYTES[..place]).is_err());
            let mut damaged = BYTES.clone();
            damaged[place] ^= 1_u8 << bit;
            prop_assert!(Receiver::default().receive(&damaged).is_err());
            // Not even with a checksum that fits is there a panic.
            let end = damaged.len() - CHECKSUM;
            let _ = Receiver::default().receive(&checked(&damaged[..end]));
            prop_assert!(Receiver::default().receive(&checked(&BYTES[..place.min(end - 1)])).is_err());
        }
    }
}
