//! How a carved object is drawn: Bevy's standard material, extended by the hit.

use crate::CarvedMaterial;
use crate::hull::{BALL, FACET, FACING, OUTWARD, WHOLE};
use bevy::asset::uuid::Uuid;
use bevy::asset::{Asset, Handle};
use bevy::material::AlphaMode;
use bevy::mesh::{Mesh, MeshVertexBufferLayoutRef};
use bevy::pbr::{
    ExtendedMaterial, MATERIAL_BIND_GROUP_INDEX, MaterialExtension, MaterialExtensionKey,
    MaterialExtensionPipeline, MeshPipelineKey,
};
use bevy::prelude::*;
use bevy::render::render_resource::{
    AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
};
use bevy::render::storage::ShaderBuffer;
use bevy::shader::{Shader, ShaderDefVal};
use relievo::export::{EngineHit, ExportError, Interface};
use relievo::scene::MOST_LAYERS;
use std::marker::PhantomData;

/// Binding of the uniform in carved.wgsl. Those of the object's buffers follow.
const FIRST_BINDING: u32 = 100;

/// The extension of [`StandardMaterial`] that carves.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
#[bind_group_data(CarvingKey)]
#[uniform(100, CarvingUniform)]
pub struct Carving {
    pub(crate) key: CarvingKey,
    pub(crate) uniform: CarvingUniform,
    #[storage(101, read_only)]
    pub(crate) object: Handle<ShaderBuffer>,
    #[storage(102, read_only)]
    pub(crate) facets: Handle<ShaderBuffer>,
    #[storage(103, read_only)]
    pub(crate) map: Handle<ShaderBuffer>,
}

/// Number of finishes: of cap, wall, bevel and floor, and three for each further layer.
const FINISHES: usize = 4 + 3 * MOST_LAYERS;

/// The material of carved entities.
pub(crate) type CarvingMaterial = ExtendedMaterial<StandardMaterial, Carving>;

/// What objects with the same pipelines have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(C)]
pub struct CarvingKey {
    /// Number of the shader.
    shader: u64,
}

impl From<&Carving> for CarvingKey {
    fn from(carving: &Carving) -> CarvingKey {
        carving.key
    }
}

impl CarvingKey {
    /// Returns the key of the objects that are drawn with the compiled shader `name`.
    pub(crate) fn of(name: &str) -> CarvingKey {
        // FNV-1a: the same in every run.
        let shader = name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        CarvingKey { shader }
    }

    /// Returns the handle of the shader for all passes.
    pub(crate) fn handle(self) -> Handle<Shader> {
        const RELIEVO: u64 = 0x7e11_e000_0000_4000;
        Handle::Uuid(Uuid::from_u64_pair(RELIEVO, self.shader), PhantomData)
    }
}

/// The uniform of carved.wgsl.
#[derive(ShaderType, Clone, Copy, Debug, Default)]
pub(crate) struct CarvingUniform {
    pub ball: Vec4,
    pub repeat: Vec2,
    pub colors: [Vec4; FINISHES],
    pub finishes: [Vec4; FINISHES],
}

impl From<&Carving> for CarvingUniform {
    fn from(carving: &Carving) -> CarvingUniform {
        carving.uniform
    }
}

impl CarvingUniform {
    /// Sets colours and finishes.
    pub(crate) fn set(&mut self, material: &CarvedMaterial) {
        let own = [material.cap, material.wall, material.bevel, material.floor];
        let layers = (0..MOST_LAYERS).flat_map(|index| match material.layers.get(index) {
            Some(layer) => [layer.cap, layer.wall, layer.bevel],
            None => [material.cap, material.wall, material.bevel],
        });
        for (index, finish) in own.into_iter().chain(layers).enumerate() {
            let color = finish.base_color.map(LinearRgba::from);
            self.colors[index] = color.map_or(Vec4::ZERO, |color| color.with_alpha(1.0).to_vec4());
            let part = |value: Option<f32>| value.unwrap_or(-1.0);
            self.finishes[index] =
                Vec4::new(part(finish.roughness), part(finish.metallic), 0.0, 0.0);
        }
    }
}

/// Returns the material of `base` as a carved object is drawn with it.
pub(crate) fn opaque(
    base: &Handle<StandardMaterial>,
    materials: &Assets<StandardMaterial>,
) -> StandardMaterial {
    // Bevy has a pink one where none is set.
    let is_set = *base != Handle::default();
    let base = materials.get(base).filter(|_| is_set);
    StandardMaterial {
        alpha_mode: AlphaMode::Opaque,
        opaque_render_method: bevy::material::OpaqueRendererMethod::Forward,
        double_sided: false,
        cull_mode: Some(bevy::render::render_resource::Face::Back),
        ..base.cloned().unwrap_or_default()
    }
}

/// What carved.wgsl takes from Bevy.
const IMPORTS: &str = "
#import bevy_pbr::mesh_functions
#import bevy_pbr::mesh_view_bindings::view
#ifdef PREPASS_PIPELINE
#ifdef MOTION_VECTOR_PREPASS
#import bevy_pbr::prepass_bindings
#endif
#else
#import bevy_pbr::forward_io::VertexOutput
#import bevy_pbr::pbr_fragment::pbr_input_from_standard_material
#import bevy_pbr::pbr_functions::{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing}
#import bevy_pbr::pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT
#import bevy_pbr::decal::clustered::apply_decals
#endif
";

/// Returns the shader that draws objects like that of `hit`.
///
/// # Errors
/// [`ExportError`] if the hit cannot be written.
pub(crate) fn shader(hit: &EngineHit<'_>) -> Result<Shader, ExportError> {
    let interface = Interface {
        group: MATERIAL_BIND_GROUP_INDEX as u32,
        first_binding: FIRST_BINDING,
        ..Interface::default()
    };
    let function = hit.wgsl(&interface)?;
    let rest = include_str!("carved.wgsl").replace("FINISHES", &FINISHES.to_string());
    let text = format!("{IMPORTS}\n{function}\n{rest}");
    let path = format!("relievo/{}.wgsl", hit.shader());
    Ok(Shader::from_wgsl(text, path))
}

impl MaterialExtension for Carving {
    fn alpha_mode() -> Option<AlphaMode> {
        // Shadow passes run a fragment shader only where it may discard.
        Some(AlphaMode::Mask(0.5))
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let shader = key.bind_group_data.handle();
        descriptor.vertex.shader = shader.clone();
        descriptor.vertex.buffers = vec![layout.0.get_layout(&[
            Mesh::ATTRIBUTE_POSITION.at_shader_location(0),
            OUTWARD.at_shader_location(1),
            FACING.at_shader_location(2),
            BALL.at_shader_location(3),
            WHOLE.at_shader_location(4),
            FACET.at_shader_location(5),
        ])?];
        let is_shadow = key
            .mesh_key
            .contains(MeshPipelineKey::UNCLIPPED_DEPTH_ORTHO);
        let is_multisampled = key.mesh_key.msaa_samples() > 1;
        let add = |defs: &mut Vec<ShaderDefVal>| {
            // What the hit gives, whatever the vertices have.
            let given = [
                "VERTEX_UVS",
                "VERTEX_UVS_A",
                "VERTEX_NORMALS",
                "VERTEX_TANGENTS",
            ];
            defs.extend(given.map(ShaderDefVal::from));
            if is_shadow {
                defs.push("RELIEVO_SHADOW".into());
            }
            if is_multisampled {
                defs.push("RELIEVO_MULTISAMPLED".into());
            }
        };
        add(&mut descriptor.vertex.shader_defs);
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader = shader;
            add(&mut fragment.shader_defs);
        }
        Ok(())
    }
}

pub(crate) struct CarvingPlugin;

impl Plugin for CarvingPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<CarvingMaterial>::default());
    }
}
