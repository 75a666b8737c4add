//! The paper's figures as data.

use super::{Figure, Method, Model, Show, Subject, Way};
use relievo::scene::Extrusion;

const PLANAR: Way = Way {
    label: "planar",
    method: Method::Planar,
    show: Show::Picture,
};
const PAPER: Way = Way {
    label: "paper",
    method: Method::Paper,
    show: Show::Picture,
};
const FAST: Way = Way {
    label: "fast",
    method: Method::Fast,
    show: Show::Picture,
};
const RELIEF: Way = Way {
    label: "curved relief mapping",
    method: Method::Relief,
    show: Show::Picture,
};

const fn with_mesh(way: Way) -> Way {
    Way {
        show: Show::Mesh,
        ..way
    }
}

const BASIC: Extrusion = Extrusion::UPRIGHT;
/// The paper's parameters (section 6 of it).
const BEVELED: Extrusion = Extrusion {
    bevel: 0.08,
    ..BASIC
};
const CHAMFERED: Extrusion = Extrusion {
    chamfer: 0.6,
    ..BEVELED
};

/// Returns `extrusion` extended outward by `extension`, pattern widths.
const fn outward(extrusion: Extrusion, extension: f64) -> Extrusion {
    Extrusion {
        extension,
        ..extrusion
    }
}

const TORUS: Subject = Subject {
    label: "torus",
    model: Model::Torus,
    pattern: "discs",
    repeat: [14.0, 6.0],
    depth: 0.1,
    extrusion: BASIC,
    eye: [0.0, 2.2, 3.3],
    target: [0.0, -0.08, 0.0],
    field_of_view: 35.0,
};
const SPHERE: Subject = Subject {
    label: "sphere",
    model: Model::Sphere,
    pattern: "discs",
    repeat: [12.0, 6.0],
    depth: 0.1,
    extrusion: BASIC,
    eye: [0.6, 0.9, 3.4],
    target: [0.0, 0.0, 0.0],
    field_of_view: 36.0,
};
/// A deep and dense carving, which shows faults best.
const DENSE_TORUS: Subject = Subject {
    repeat: [24.0, 10.0],
    depth: 0.16,
    ..TORUS
};
/// Close view of the torus's silhouette.
const TORUS_NEAR: Subject = Subject {
    eye: [0.0, 0.5, 2.6],
    target: [0.7, 0.0, 0.6],
    field_of_view: 28.0,
    ..TORUS
};
/// Close view of the sphere's silhouette.
const SPHERE_NEAR: Subject = Subject {
    eye: [0.9, 0.9, 1.9],
    target: [0.5, 0.45, 0.0],
    field_of_view: 36.0,
    ..SPHERE
};
const CYLINDER: Subject = Subject {
    label: "cylinder",
    model: Model::Cylinder,
    pattern: "discs",
    repeat: [12.0, 6.0],
    depth: 0.1,
    extrusion: BASIC,
    eye: [1.1, 1.3, 4.2],
    target: [0.0, 0.4, 0.0],
    field_of_view: 32.0,
};
const PLANE: Subject = Subject {
    label: "plane",
    model: Model::Plane,
    pattern: "discs",
    repeat: [4.0, 4.0],
    depth: 0.22,
    extrusion: BASIC,
    eye: [-0.9, 1.5, 2.1],
    target: [0.0, -0.15, 0.15],
    field_of_view: 47.0,
};

/// Depths of Figure 11.
const SHALLOW: f64 = 0.05;
const DEEP: f64 = 0.12;

/// 0.4 and 0.8 of the largest distance in discs.png, √½ − 0.3 pattern widths.
const EXTENSION_0_4: f64 = 0.1628;
const EXTENSION_0_8: f64 = 0.3257;

/// Every figure, in the paper's order.
pub const FIGURES: &[Figure] = &[
    Figure {
        number: 2,
        title: "A cylinder without and with the correction of the silhouette",
        caption: "Without it (planar) the outline is that of the polygons. With it, the \
                  outline shows the carving.",
        ways: &[with_mesh(PLANAR), with_mesh(PAPER), with_mesh(FAST)],
        groups: &[&[Subject {
            pattern: "letters",
            repeat: [6.0, 3.0],
            depth: 0.12,
            ..CYLINDER
        }]],
    },
    Figure {
        number: 6,
        title: "The four extrusions on a plane",
        caption: "Basic, beveled (bevel 0.08) and chamfered (chamfer 0.6); below, each combined \
                  with outward extrusion (extension 0.08). A plane has no curvature: the planar \
                  way draws the same pictures as the fast one.",
        ways: &[PAPER, FAST],
        groups: &[
            &[
                Subject {
                    label: "basic",
                    ..PLANE
                },
                Subject {
                    label: "beveled",
                    extrusion: BEVELED,
                    ..PLANE
                },
                Subject {
                    label: "chamfered",
                    extrusion: CHAMFERED,
                    ..PLANE
                },
            ],
            &[
                Subject {
                    label: "outward",
                    extrusion: outward(BASIC, 0.08),
                    ..PLANE
                },
                Subject {
                    label: "outward and beveled",
                    extrusion: outward(BEVELED, 0.08),
                    ..PLANE
                },
                Subject {
                    label: "outward and chamfered",
                    extrusion: outward(CHAMFERED, 0.08),
                    ..PLANE
                },
            ],
        ],
    },
    Figure {
        number: 11,
        title: "Objects without and with the correction, at two depths",
        caption: "The deeper the carving, the more a straight outline betrays the polygons. As \
                  printed, Algorithm 1 takes the curvature along u for that along v as well: of \
                  the torus's outline the paper's way cuts the left and the right only.",
        ways: &[PLANAR, PAPER, FAST],
        groups: &[
            &[
                Subject {
                    label: "torus, depth 0.05",
                    depth: SHALLOW,
                    ..TORUS
                },
                Subject {
                    label: "sphere, depth 0.05",
                    depth: SHALLOW,
                    ..SPHERE
                },
                Subject {
                    label: "cylinder, depth 0.05",
                    depth: SHALLOW,
                    ..CYLINDER
                },
            ],
            &[
                Subject {
                    label: "torus, depth 0.12",
                    depth: DEEP,
                    ..TORUS
                },
                Subject {
                    label: "sphere, depth 0.12",
                    depth: DEEP,
                    ..SPHERE
                },
                Subject {
                    label: "cylinder, depth 0.12",
                    depth: DEEP,
                    ..CYLINDER
                },
            ],
        ],
    },
    Figure {
        number: 12,
        title: "The same with the polygon mesh",
        caption: "The mesh is the one that is drawn; nothing is added to it.",
        ways: &[with_mesh(PLANAR), with_mesh(PAPER), with_mesh(FAST)],
        groups: &[&[
            Subject {
                depth: DEEP,
                ..TORUS
            },
            Subject {
                depth: DEEP,
                ..SPHERE
            },
        ]],
    },
    Figure {
        number: 13,
        title: "Bevel and chamfer without and with the correction",
        caption: "Bevel 0.08, chamfer 0.6.",
        ways: &[PLANAR, PAPER, FAST],
        groups: &[
            &[Subject {
                label: "beveled",
                extrusion: BEVELED,
                ..TORUS
            }],
            &[Subject {
                label: "chamfered",
                extrusion: CHAMFERED,
                ..TORUS
            }],
        ],
    },
    Figure {
        number: 14,
        title: "Outward extrusion",
        caption: "The extension grows: 0, 0.4 and 0.8 of the largest distance in the map.",
        ways: &[PAPER, FAST],
        groups: &[
            &[
                Subject {
                    label: "torus, extension 0",
                    ..TORUS
                },
                Subject {
                    label: "torus, extension 0.4",
                    extrusion: outward(BASIC, EXTENSION_0_4),
                    ..TORUS
                },
                Subject {
                    label: "torus, extension 0.8",
                    extrusion: outward(BASIC, EXTENSION_0_8),
                    ..TORUS
                },
            ],
            &[
                Subject {
                    label: "sphere, extension 0",
                    ..SPHERE
                },
                Subject {
                    label: "sphere, extension 0.4",
                    extrusion: outward(BASIC, EXTENSION_0_4),
                    ..SPHERE
                },
                Subject {
                    label: "sphere, extension 0.8",
                    extrusion: outward(BASIC, EXTENSION_0_8),
                    ..SPHERE
                },
            ],
        ],
    },
    Figure {
        number: 15,
        title: "Curved relief mapping and curved extrusion mapping",
        caption: "Both walk the same bent rays, and share their errors, which are large at such \
                  a depth. Relief mapping takes 25 equal steps and 5 bisections, so that it \
                  breaks up pins and bars that are thinner than a step is long. Steps by the \
                  distance map cannot skip them. (The pins are discs drawn in, which takes a \
                  signed distance; the paper's map has none.)",
        ways: &[RELIEF, FAST],
        groups: &[&[
            Subject {
                label: "sphere, pins",
                repeat: [24.0, 12.0],
                depth: 0.2,
                extrusion: outward(BASIC, -0.2),
                ..SPHERE_NEAR
            },
            Subject {
                label: "torus, pins",
                repeat: [32.0, 13.0],
                depth: 0.2,
                extrusion: outward(BASIC, -0.22),
                ..TORUS_NEAR
            },
            Subject {
                label: "sphere, bars",
                pattern: "lattice",
                repeat: [8.0, 4.0],
                depth: 0.2,
                extrusion: outward(BASIC, -0.012),
                ..SPHERE_NEAR
            },
            Subject {
                label: "torus, bars",
                pattern: "lattice",
                repeat: [10.0, 4.0],
                depth: 0.2,
                extrusion: outward(BASIC, -0.012),
                ..TORUS_NEAR
            },
        ]],
    },
    Figure {
        number: 16,
        title: "Holes and distortions",
        caption: "The truth is drawn from the torus's closed form. In the error pictures red \
                  is a hole, purple one inside the outline, blue is extra, and yellow is another \
                  kind of surface than there is.",
        ways: &[
            PAPER,
            FAST,
            Way {
                label: "truth",
                method: Method::Fast,
                show: Show::Truth,
            },
            Way {
                label: "paper, errors",
                method: Method::Paper,
                show: Show::Errors,
            },
            Way {
                label: "fast, errors",
                method: Method::Fast,
                show: Show::Errors,
            },
        ],
        groups: &[&[
            Subject {
                label: "torus from near",
                eye: [0.0, 1.1, 2.2],
                target: [0.0, -0.1, 0.6],
                field_of_view: 38.0,
                ..DENSE_TORUS
            },
            Subject {
                label: "torus, its rim",
                eye: [1.2, 1.6, 1.9],
                target: [0.9, 0.1, 0.5],
                field_of_view: 35.0,
                ..DENSE_TORUS
            },
        ]],
    },
];
