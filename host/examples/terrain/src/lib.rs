//! A landscape whose heights, and whose picture, are the same words on every GPU and CPU.
//!
//! Players of one world may stand on heights that their GPU computed while a server checks
//! them on its CPU, and a replay may run on another device: nothing is stored or sent but
//! coordinates. The mathematics is [`relievo_exact`]'s, and integer hashes.
//!
//! ```
//! use glam::Vec2;
//! use terrain::terrain::{WATER_LEVEL, height};
//!
//! let hill = height(Vec2::new(1200.0, 5600.0));
//! assert!(hill > WATER_LEVEL);
//! // Not about 351 metres: these bits, on every device.
//! assert_eq!(hill.to_bits(), 0x43af_b22c);
//! ```
//!
//! [`noise`] has the hash and the sums of noise, [`terrain`] heights, normals and what
//! grows where, and [`view`] the colour of a pixel, all that a fragment shader calls:
//!
//! ```
//! use glam::{UVec2, Vec3};
//! use terrain::view::{View, color};
//!
//! let view = View::new(Vec3::new(0.0, 900.0, 0.0), Vec3::new(9000.0, 0.0, 9000.0), Vec3::ONE, 0.0);
//! let sky = color(UVec2::new(320, 0), UVec2::new(640, 400), &view);
//! assert!(sky.z > sky.x);
//! ```
//!
//! The functions marked as kernels, and the picture, are compared on GPU and CPU by
//! `cargo test`; `cargo relievo build` compiles them for the GPU.
#![cfg_attr(target_arch = "spirv", no_std)]
#![cfg_attr(not(target_arch = "spirv"), forbid(unsafe_code))]

pub mod noise;
#[cfg(target_arch = "spirv")]
pub mod shaders;
pub mod terrain;
pub mod view;

relievo_kernel::canaries!();
