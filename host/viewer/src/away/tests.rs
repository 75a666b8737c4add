use super::super::display;
use super::*;
use proptest::prelude::*;
use relievo::prepare::PreparedScene;
use relievo::render::{CpuRenderer, Renderer};
use relievo::scene::Shape;
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::mpsc;

/// A worker on a thread, which gets nothing but bytes.
struct Thread {
    orders: mpsc::Sender<Vec<u8>>,
    news: mpsc::Receiver<News>,
    /// Bytes of each order.
    sent: Rc<RefCell<Vec<usize>>>,
}

impl Thread {
    /// Starts one that stops at the order number `last`, from 0.
    fn start(sent: Rc<RefCell<Vec<usize>>>, last: usize) -> Thread {
        let (orders, to_do) = mpsc::channel::<Vec<u8>>();
        let (tell, news) = mpsc::channel();
        std::thread::spawn(move || {
            let mut station = Station::default();
            // Nobody listens at the end of a test.
            let _ = tell.send(News::Ready);
            for (number, order) in to_do.iter().enumerate() {
                let reply = match station.work(&order) {
                    Ok(reply) if number < last => News::Reply(reply),
                    _ => News::Stopped("it was told to".to_string()),
                };
                let _ = tell.send(reply);
            }
        });
        Thread { orders, news, sent }
    }
}

impl Worker for Thread {
    fn send(&mut self, order: Vec<u8>) {
        self.sent.borrow_mut().push(order.len());
        self.orders.send(order).unwrap();
    }

    fn news(&mut self) -> Option<News> {
        self.news.try_recv().ok()
    }
}

/// Returns an end whose workers run on threads, and the bytes of each order.
fn away() -> (Away, Rc<RefCell<Vec<usize>>>) {
    let sent = Rc::new(RefCell::default());
    let told = Rc::clone(&sent);
    let start = move |_| Ok(Box::new(Thread::start(told.clone(), 1000)) as Box<dyn Worker>);
    (Away::new(Box::new(start), Arc::new(|| ())), sent)
}

fn wait(away: &mut Away) -> Delivery {
    loop {
        if let Some(delivery) = away.delivery() {
            return delivery;
        }
        std::thread::yield_now();
    }
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

/// A quad with a letter.
fn scene(rest: &str) -> Scene {
    let files = Files::memory([("meshes/quad.obj".into(), QUAD.as_bytes().into())]);
    let text = format!(
        "image.size = [40, 30]\n[[object]]\nmesh = '../meshes/quad.obj'\nprojection = 'planar-z'\nshape = {{ text = 'A' }}\n{rest}\n"
    );
    let path = Path::new("scenes/letter.toml");
    Scene::parse_with(&text, path, &Limits::default(), files).unwrap()
}

fn prepare(number: u64, scene: &Scene) -> Order {
    Order::Prepare {
        number,
        scenes: vec![scene.clone()],
        anew: false,
    }
}

fn analyse(number: u64, scene: &PreparedScene) -> Order {
    Order::Analyse {
        analysis: Analysis::Errors,
        number,
        camera: scene.camera,
        frame: Box::new(scene.frame),
    }
}

fn colors(scene: &PreparedScene) -> Vec<u8> {
    let words = CpuRenderer::new(scene).color(&scene.frame).unwrap();
    display::color_bytes(&words, &scene.development)
}

fn ready(delivery: Delivery) -> (u64, Ready) {
    match delivery {
        Delivery::Prepared(number, Ok(mut scenes)) => (number, scenes.remove(0)),
        Delivery::Prepared(_, Err(problem)) => panic!("{problem}"),
        Delivery::Analysed(..) => panic!("it is an analysis"),
    }
}

#[test]
fn a_worker_delivers_what_the_bench_does() {
    let (mut away, _) = away();
    let mut bench = Bench::default();
    for rest in ["depth = 0.1", "error_px = 2", "tier = 'accurate'"] {
        let scene = scene(rest);
        away.order(prepare(7, &scene));
        let (number, far) = ready(wait(&mut away));
        let (_, near) = ready(bench.work(prepare(7, &scene)));
        assert_eq!((number, &far.plans), (7, &near.plans));
        assert_eq!(far.plans.len(), usize::from(rest.contains("error_px")));
        assert!(colors(&far.scene) == colors(&near.scene), "{rest}");

        away.order(analyse(3, &far.scene));
        let far = wait(&mut away);
        match (far, bench.work(analyse(3, &near.scene))) {
            (Delivery::Analysed(3, Ok(far)), Delivery::Analysed(3, Ok(near))) => {
                assert_eq!((far.picture, far.text), (near.picture, near.text));
            }
            _ => panic!("no analysis"),
        }
    }
    // Both scenes of a comparison arrive.
    let scenes = vec![scene("depth = 0.1"), scene("tier = 'planar'")];
    away.order(Order::Prepare {
        number: 8,
        scenes: scenes.clone(),
        anew: true,
    });
    let Delivery::Prepared(8, Ok(pair)) = wait(&mut away) else {
        panic!("no pair");
    };
    let tiers = pair
        .iter()
        .map(|ready| ready.scene.objects[0].parameters.tier);
    let wanted = scenes.iter().map(|scene| scene.objects[0].tier.code());
    assert!(tiers.eq(wanted));
}

#[test]
fn files_are_sent_once() {
    let (mut away, sent) = away();
    let mut scene = scene("depth = 0.1");
    let pattern: Vec<u8> = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut encoder = png::Encoder::new(&mut bytes, 64, 64);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().unwrap();
        let pixels: Vec<u8> = (0..64 * 64).map(|i| (i * i % 251) as u8).collect();
        writer.write_image_data(&pixels).unwrap();
        writer.finish().unwrap();
        bytes.into_inner()
    };
    let name = PathBuf::from("dropped/noise.png");
    let Files::Memory(files) = &mut scene.files else {
        panic!("they are in memory");
    };
    Arc::make_mut(files).insert(name.clone(), pattern.as_slice().into());
    scene.objects[0].shape = Shape::File(name);
    let mut bytes = |scene: &Scene| {
        away.order(prepare(1, scene));
        ready(wait(&mut away));
        *sent.borrow().last().unwrap()
    };
    let first = bytes(&scene);
    assert!(first > pattern.len(), "{first}");
    scene.objects[0].depth = Some(0.2);
    let second = bytes(&scene);
    println!("{first} bytes, then {second}");
    assert!(second < 500, "{second} of {first} bytes");
    // What is gone is gone.
    let mut without = self::scene("depth = 0.1");
    bytes(&without);
    without.objects[0].shape = scene.objects[0].shape.clone();
    away.order(prepare(2, &without));
    let Delivery::Prepared(2, Err(problem)) = wait(&mut away) else {
        panic!("there is no such file");
    };
    assert!(problem.contains("noise.png"), "{problem}");
}

#[test]
fn only_the_latest_of_many_orders_is_executed() {
    let (mut away, sent) = away();
    let scene = scene("depth = 0.1");
    for number in 1..=100 {
        away.order(prepare(number, &scene));
    }
    let numbers = [(); 2].map(|()| ready(wait(&mut away)).0);
    assert_eq!(numbers, [1, 100]);
    assert_eq!(sent.borrow().len(), 2);
}

#[test]
fn a_worker_that_stops_is_replaced() {
    let started = Rc::new(Cell::new(0));
    let count = started.clone();
    let start = move |_| {
        count.set(count.get() + 1);
        Ok(Box::new(Thread::start(Rc::default(), 1)) as Box<dyn Worker>)
    };
    let mut away = Away::new(Box::new(start), Arc::new(|| ()));
    let scene = scene("depth = 0.1");
    away.order(prepare(1, &scene));
    ready(wait(&mut away));
    away.order(prepare(2, &scene));
    let Delivery::Prepared(2, Err(problem)) = wait(&mut away) else {
        panic!("it has stopped");
    };
    assert!(problem.contains("it was told to"), "{problem}");
    assert_eq!((started.get(), away.cannot_start()), (1, None));
    // It has no scene yet.
    let camera = Camera::new([1.0; 3], [0.0; 3]);
    away.order(Order::Analyse {
        analysis: Analysis::Errors,
        number: 3,
        camera,
        frame: Box::default(),
    });
    let Delivery::Analysed(3, Err(problem)) = wait(&mut away) else {
        panic!("there is nothing to analyse");
    };
    assert!(problem.contains("F5"), "{problem}");
    away.order(prepare(4, &scene));
    away.order(prepare(5, &scene));
    // The third one gets everything anew.
    assert!(matches!(wait(&mut away), Delivery::Prepared(4, Err(_))));
    assert_eq!(ready(wait(&mut away)).0, 5);
    assert_eq!(started.get(), 3);
}

#[test]
fn a_scene_that_is_not_valid_is_not_sent() {
    let (mut away, sent) = away();
    let mut scene = scene("depth = 0.1");
    scene.objects[0].depth = Some(-1.0);
    away.order(prepare(1, &scene));
    let Delivery::Prepared(1, Err(problem)) = wait(&mut away) else {
        panic!("it is not valid");
    };
    assert!(problem.contains("depth is -1.0"), "{problem}");
    assert!(sent.borrow().is_empty());
}

proptest! {
    #[test]
    fn other_bytes_are_an_error(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        // A few of them are orders.
        let _ = Station::default().work(&bytes);
        prop_assert!(Station::default().work(&[&[9], &bytes[..]].concat()).is_err());
        let mut line = Line {
            worker: Box::new(Thread::start(Rc::default(), 0)),
            is_ready: true,
            files: Arc::default(),
            receiver: Receiver::default(),
        };
        let _ = line.read(&bytes);
        prop_assert!(line.read(&[&[9], &bytes[..]].concat()).is_err());
        // Scenes that are none: number 1, no plans.
        prop_assert!(line.read(&[&[0, 1, 0, 0], &bytes[..]].concat()).is_err());
        // A picture of 300 × 1 pixels.
        prop_assert!(line.read(&[&[1, 1, 0, 172, 2, 1, 0], &bytes[..]].concat()).is_err());
    }
}
