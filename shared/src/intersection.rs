//! What a ray hits, and the surface there: what the G-buffer stores, and the function that exports
//! call `relievo_hit`.

use crate::camera::on_plane;
use crate::exit::NoExits;
use crate::layout::{Frame, UPRIGHT_AXES};
use crate::model::{Model, Normals, Ray, Traced};
use crate::normals::{CLASS_MISS, HitSurface};
use crate::shape_map::Texels;
use crate::tangent::TangentFrame;
use crate::trace::{normals_on, trace};
use crate::{Real, Vec2, Vec3};

/// Least cosine between the surface and the ray, of what a pixel covers.
const LEAST_COSINE: Real = 0.02;

/// What a ray hits, in the space of the object. All but `class` is 0 for a miss.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Intersection {
    /// Surface class, one of the `CLASS_` constants of [`normals`](crate::normals).
    pub class: u32,
    /// Distance from the ray's origin, object units.
    pub t: Real,
    /// Unit normal of the carved surface.
    pub normal: Vec3,
    /// Unit normal of the mesh's smooth surface.
    pub mesh_normal: Vec3,
    /// Unit tangent: the direction of growing u on caps and floors; along the outline on walls and
    /// bevels.
    pub tangent: Vec3,
    /// +1 or −1: the bitangent is handedness · (normal × tangent).
    pub handedness: Real,
    /// Texture coordinates of the mesh, repeats, less a whole number per facet.
    pub uv: Vec2,
    /// Change of `uv` to the pixel on the right.
    pub uv_right: Vec2,
    /// Change of `uv` to the pixel below.
    pub uv_down: Vec2,
    /// δ: 0 on the mesh's surface, 1 on the floor.
    pub depth_fraction: Real,
    /// [`Object::finish`](crate::layout::Object::finish) of the object: engines write its number there.
    pub object: u32,
    /// Index of the layer of a [stack](crate::stack); 0 is the object's own pattern.
    pub layer: u32,
}

/// The surface at a hit, in the space of the object.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceAt {
    /// Normals of the carved and of the mesh's smooth surface.
    pub normals: Normals,
    /// ∇u and ∇v, repeats per object unit.
    pub gradients: (Vec3, Vec3),
    /// The tangent.
    pub frame: TangentFrame,
}

/// Returns the surface at a hit.
#[inline]
pub fn surface_at<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
    entry: &M::Entry,
    traced: &Traced<M::Place>,
) -> SurfaceAt {
    let surface = M::surface(ray, over, entry, &traced.place);
    let normals = normals_on(ray, texels, &traced.hit, &surface);
    let gradients = surface.gradients();
    SurfaceAt {
        normals,
        gradients,
        frame: TangentFrame::new(traced.hit.class, &normals, gradients),
    }
}

/// A camera as far as one of its rays needs it, in the space of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Unit view axis; for a ray without a camera its direction.
    pub forward: Vec3,
    /// Change of the direction whose part along `forward` is 1 from one pixel to the next on its
    /// right.
    pub right: Vec3,
    /// Change of that direction from one pixel to the next below.
    pub down: Vec3,
    /// Distance of the near plane along `forward`, object units, > 0: nearer hits do not count.
    pub near: Real,
}

impl Camera {
    /// Returns the frame for a ray from `origin`.
    #[inline]
    pub fn frame(&self, origin: Vec3) -> Frame {
        Frame {
            eye: origin.to_array(),
            near: self.near,
            forward: self.forward.to_array(),
            ray_right: self.right.to_array(),
            ray_down: self.down.to_array(),
            unit: 1.0,
            axes: UPRIGHT_AXES,
            ..Frame::default()
        }
    }
}

/// Returns what `ray` hits in the shell over one facet.
///
/// Of the frame only `eye`, `near`, `forward`, `ray_right` and `ray_down` are read.
#[inline]
pub fn intersect<M: Model<Over>, Over, T: Texels + ?Sized>(
    ray: &Ray<'_>,
    over: &Over,
    texels: &T,
) -> Intersection {
    let mut found = Intersection::default();
    let (meets, meeting) = M::meet(ray, over);
    if meets {
        let (enters, entry) = M::enter(ray, over, &meeting, &NoExits);
        if enters {
            let traced = trace::<M, _, _>(ray, over, texels, &entry);
            if traced.hit.class != CLASS_MISS {
                let hit = &traced.hit;
                let SurfaceAt {
                    normals,
                    gradients,
                    frame,
                } = surface_at::<M, _, _>(ray, over, texels, &entry, &traced);
                let [right, down] = on_plane(
                    ray.frame,
                    ray.direction,
                    hit.t,
                    normals.carved,
                    LEAST_COSINE,
                );
                let change = |step: Vec3| Vec2::new(gradients.0.dot(step), gradients.1.dot(step));
                found = Intersection {
                    class: hit.class,
                    t: hit.t,
                    normal: normals.carved,
                    mesh_normal: normals.smooth,
                    tangent: frame.tangent,
                    handedness: if frame.is_mirrored { -1.0 } else { 1.0 },
                    uv: hit.uv + hit.repeat,
                    uv_right: change(right),
                    uv_down: change(down),
                    depth_fraction: hit.depth_fraction,
                    object: ray.object.finish,
                    layer: hit.layer,
                };
            }
        }
    }
    found
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // Never compiled for a device.
mod tests {
    use super::*;
    use crate::layout::{Corner, FORMAT_FLOAT, Object, Triangle};
    use crate::model::Flat;
    use crate::normals::CLASS_CAP;

    /// A square of the plane z = 0 with two repeats of a pattern that is all cap.
    fn plane() -> (Object, Triangle, [u32; 4]) {
        let object = Object {
            map_size: [2.0, 2.0],
            map_reach: 1.0,
            map_format: FORMAT_FLOAT,
            depth: 0.1,
            linear_steps: 8,
            binary_steps: 4,
            ..Object::default()
        };
        let corner = |x: Real, y: Real| Corner {
            position: [x, y, 0.0],
            normal: [0.0, 0.0, 1.0],
            tangent: [1.0, 0.0, 0.0],
            uv: [2.0 * x, -2.0 * y],
            gradient_u: [2.0, 0.0, 0.0],
            gradient_v: [0.0, -2.0, 0.0],
            ..Corner::default()
        };
        let triangle = Triangle {
            corners: [corner(0.0, 0.0), corner(4.0, 0.0), corner(0.0, 4.0)],
            handedness: -1.0,
            ..Triangle::default()
        };
        (object, triangle, [0; 4])
    }

    fn find(origin: Vec3, direction: Vec3, near: Real) -> Intersection {
        let (object, triangle, map) = plane();
        let camera = Camera {
            forward: direction,
            right: Vec3::X * 0.01,
            down: Vec3::NEG_Y * 0.02,
            near,
        };
        let frame = camera.frame(origin);
        let ray = Ray {
            frame: &frame,
            object: &object,
            direction,
        };
        intersect::<Flat, _, _>(&ray, &triangle, &map[..])
    }

    #[test]
    fn a_ray_from_anywhere_hits_the_cap() {
        for origin in [Vec3::new(1.0, 0.75, 3.0), Vec3::new(0.5, 2.25, 3.0)] {
            let found = find(origin, Vec3::NEG_Z, 0.1);
            assert_eq!(found.class, CLASS_CAP);
            assert!((found.t - 3.0).abs() < 1e-5, "{found:?}");
            assert_eq!((found.normal, found.mesh_normal), (Vec3::Z, Vec3::Z));
            // v grows down, so normal × tangent points against it.
            assert_eq!((found.tangent, found.handedness), (Vec3::X, -1.0));
            let uv = Vec2::new(2.0 * origin.x, -2.0 * origin.y);
            assert!((found.uv - uv).length() < 1e-5, "{found:?}");
            // A pixel is 0.03 wide and 0.06 high there.
            assert!((found.uv_right - Vec2::new(0.06, 0.0)).length() < 1e-5);
            assert!((found.uv_down - Vec2::new(0.0, 0.12)).length() < 1e-5);
            assert_eq!(found.depth_fraction, 0.0);
        }
    }

    #[test]
    fn what_is_missed_or_too_near_is_no_hit() {
        let beside = find(Vec3::new(9.0, 9.0, 3.0), Vec3::NEG_Z, 0.1);
        let behind = find(Vec3::new(1.0, 1.0, 3.0), Vec3::Z, 0.1);
        let near = find(Vec3::new(1.0, 1.0, 3.0), Vec3::NEG_Z, 3.5);
        for found in [beside, behind, near] {
            assert_eq!(found, Intersection::default());
        }
    }
}
