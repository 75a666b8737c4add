//! Motion vectors: how far the points of a picture moved on it since another one.

use crate::prepare::{Placement, PreparedScene, View};
use crate::render::Hit;
use glam::DVec3;
use relievo_shared::layout::Frame;

/// Where camera and objects of a picture are.
pub struct Moment {
    frame: Frame,
    /// The eye, world units.
    eye: DVec3,
    /// From the space of the mesh file to world space, of each object.
    transforms: Vec<Placement>,
}

impl Moment {
    /// Returns the moment of the picture of `scene` in `view`.
    pub fn new(scene: &PreparedScene, view: &View) -> Moment {
        Moment {
            frame: view.frame,
            eye: DVec3::from(view.camera.eye),
            transforms: transforms(scene),
        }
    }

    /// Returns a function that gives how many pixels to the right and down the point that a
    /// pixel of `scene` hits has moved since this moment; 0 if it was behind the eye.
    ///
    /// Points move with their object as a whole: a depth that changes moves nothing.
    pub fn motion<'a>(&'a self, scene: &PreparedScene) -> impl Fn(Hit<'_, '_>) -> [f32; 2] + 'a {
        let now = transforms(scene);
        // Which object a pixel shows is known only by tracing again.
        let is_moving = self.transforms.len() == now.len() && self.transforms != now;
        move |hit| {
            let object = if is_moving { hit.object() } else { None };
            let position = hit.position();
            let before = match object {
                Some(index) => self.transforms[index].point(now[index].to_object(position)),
                None => position,
            };
            let [x, y] = hit.pixel();
            let now = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            match self.pixel(before) {
                Some(before) => [0, 1].map(|axis| (now[axis] - before[axis]) as f32),
                None => [0.0; 2],
            }
        }
    }

    /// Returns where a point is in the picture, pixels from its top left corner.
    fn pixel(&self, point: DVec3) -> Option<[f64; 2]> {
        let frame = &self.frame;
        let wide = |v: [f32; 3]| DVec3::from(v.map(f64::from));
        let (forward, right, up) = (wide(frame.forward), wide(frame.right), wide(frame.up));
        let ray = point - self.eye;
        let depth = ray.dot(forward);
        // `right` is a unit vector divided by the picture's half width at distance 1.
        let x = ray.dot(right) / depth;
        let y = ray.dot(up) / depth;
        let [width, height] = frame.size.map(f64::from);
        (depth > 0.0).then_some([0.5 * width * (1.0 + x), 0.5 * height * (1.0 - y)])
    }
}

/// Returns where the objects of `scene` are.
fn transforms(scene: &PreparedScene) -> Vec<Placement> {
    let objects = scene.objects.iter();
    objects.map(|object| object.transform).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::prepare;
    use crate::render::{CpuRenderer, Hits, Renderer};
    use crate::scene::Scene;
    use std::path::Path;

    const SCENE: &str = "[image]\nsize = [64, 48]\n[camera]\neye = [0, 0, 4]\nfov = 40\n[[object]]\nname = 'ball'\nmesh = '../meshes/sphere.obj'\nshape = '../patterns/discs.png'\nrepeat = [8, 4]\ndepth = 0.1\n";

    fn scene(animated: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/scenes/a.toml");
        Scene::parse(&format!("{SCENE}{animated}"), &path).unwrap()
    }

    /// Every hit of the scene at 1 s with its motion since 0 s.
    fn motions(animated: &str) -> Vec<(DVec3, [f32; 2])> {
        let scene = scene(animated);
        let [before, now] =
            [0.0, 1.0].map(|time| prepare(&scene.at_time(time).unwrap(), &|_| ()).unwrap());
        let moment = Moment::new(&before, &before.view());
        let words = CpuRenderer::new(&now).geometry(&now.frame).unwrap();
        let motion = moment.motion(&now);
        let hits = Hits::new(&now, &now.frame, &words);
        hits.pixels()
            .flatten()
            .map(|hit| (hit.position(), motion(hit)))
            .collect()
    }

    /// Pixels per world unit at distance 1.
    fn scale() -> f64 {
        24.0 / 20.0f64.to_radians().tan()
    }

    #[test]
    fn what_stands_still_does_not_move() {
        let all = motions("");
        assert!(all.len() > 500);
        for (_, motion) in all {
            assert!(
                motion[0].abs() < 1e-3 && motion[1].abs() < 1e-3,
                "{motion:?}"
            );
        }
    }

    #[test]
    fn points_move_against_the_camera_by_parallax() {
        let all = motions(
            "[[animate]]\nkey = 'camera.eye'\ntimes = [0, 1]\nvalues = [[0, 0, 4], [0.1, 0, 4]]\n[[animate]]\nkey = 'camera.target'\ntimes = [0, 1]\nvalues = [[0, 0, 0], [0.1, 0, 0]]\n",
        );
        for (position, motion) in all {
            let expected = -0.1 * scale() / (4.0 - position.z);
            assert!((f64::from(motion[0]) - expected).abs() < 1e-3 && motion[1].abs() < 1e-3);
        }
    }

    #[test]
    fn points_move_with_their_object() {
        let other = "[[object]]\nmesh = '../meshes/sphere.obj'\nshape = '../patterns/discs.png'\nrepeat = [8, 4]\ndepth = 0.1\ntranslate = [2, 0, 0]\n";
        let all = motions(&format!(
            "{other}[[animate]]\nkey = 'object.ball.translate'\ntimes = [0, 1]\nvalues = [[0, 0.2, 0], [0, 0, 0]]\n",
        ));
        let (mut moved, mut still) = (0, 0);
        for (position, motion) in all {
            let is_ball = position.length() < 1.01;
            let expected = if is_ball {
                0.2 * scale() / (4.0 - position.z)
            } else {
                0.0
            };
            assert!(
                (f64::from(motion[1]) - expected).abs() < 2e-3,
                "{position} {motion:?} {expected}"
            );
            (moved, still) = (moved + u32::from(is_ball), still + u32::from(!is_ball));
        }
        assert!(moved > 400 && still > 50, "{moved} {still}");
    }
}
