//! Render pipelines, made when first needed and kept across scenes.

use super::content::{Content, DEPTH_FORMAT, TARGET_FORMAT};
use super::shaders::{EXITS, EntryPoints};
use crate::render::RenderError;
use relievo_bitwise::{Device, Module};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// The pipelines of one module on one device. Objects with the same entry points
/// share one.
pub struct Pipelines {
    device: Device,
    module: Module,
    vertices: BTreeMap<&'static str, wgpu::ShaderModule>,
    bindings: wgpu::BindGroupLayout,
    exit_bindings: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    /// The layout of shaders that ask for exits.
    layout_with_exits: wgpu::PipelineLayout,
    made: BTreeMap<&'static str, wgpu::RenderPipeline>,
}

impl Pipelines {
    /// Creates an empty set of pipelines for `module` on `device`.
    pub fn new(device: &Device, module: &Module) -> Pipelines {
        let bindings = bind_group_layout(device.wgpu());
        let exit_bindings = exit_bind_group_layout(device.wgpu());
        let layout = |groups: &[Option<&wgpu::BindGroupLayout>]| {
            device
                .wgpu()
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("relievo"),
                    bind_group_layouts: groups,
                    immediate_size: 0,
                })
        };
        Pipelines {
            device: device.clone(),
            module: module.clone(),
            vertices: BTreeMap::new(),
            layout: layout(&[Some(&bindings)]),
            layout_with_exits: layout(&[Some(&bindings), Some(&exit_bindings)]),
            bindings,
            exit_bindings,
            made: BTreeMap::new(),
        }
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the layout of an object's bindings.
    pub(super) fn bindings(&self) -> &wgpu::BindGroupLayout {
        &self.bindings
    }

    /// Returns the layout of the picture of exits.
    pub(super) fn exit_bindings(&self) -> &wgpu::BindGroupLayout {
        &self.exit_bindings
    }

    /// Makes the pipeline that writes exits, if it is missing.
    pub(super) fn make_exits(&mut self) -> Result<(), RenderError> {
        self.make_pair(EXITS, 1, false)
    }

    /// Returns the pipeline that [`Self::make_exits`] has made.
    pub(super) fn exits(&self) -> &wgpu::RenderPipeline {
        &self.made[EXITS[1]]
    }

    /// Makes the pipeline that draws `content` of objects with these entry points,
    /// if it is missing.
    pub(super) fn make(&mut self, of: &EntryPoints, content: Content) -> Result<(), RenderError> {
        let pair = [of.vertex, content.fragment(of)];
        self.make_pair(pair, content.targets(), of.asks_for_exits)
    }

    /// Makes the pipeline of a vertex and a fragment shader, if it is missing.
    fn make_pair(
        &mut self,
        [vertex, fragment]: [&'static str; 2],
        targets: usize,
        asks_for_exits: bool,
    ) -> Result<(), RenderError> {
        let device = &self.device;
        if self.made.contains_key(fragment) {
            return Ok(());
        }
        let placed = match self.vertices.entry(vertex) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(self.module.load(device, vertex)?),
        };
        let modules = [
            (&*placed, vertex),
            (&self.module.load(device, fragment)?, fragment),
        ];
        let layout = if asks_for_exits {
            &self.layout_with_exits
        } else {
            &self.layout
        };
        let pipeline = device.attempt(|| {
            let pipeline = make_pipeline(device.wgpu(), layout, modules, targets);
            Ok::<_, RenderError>(pipeline)
        })?;
        self.made.insert(fragment, pipeline);
        Ok(())
    }

    /// Returns a pipeline that [`Self::make`] has made.
    pub(super) fn get(&self, of: &EntryPoints, content: Content) -> &wgpu::RenderPipeline {
        &self.made[content.fragment(of)]
    }
}

/// Four read-only storage buffers: frame, object, facets, texels.
fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..4)
        .map(|binding| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                // Of one buffer with the frames or the parameters of many objects.
                has_dynamic_offset: binding < 2,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("relievo"),
        entries: &entries,
    })
}

/// The picture of exits.
fn exit_bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("exits"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        }],
    })
}

fn make_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [(&wgpu::ShaderModule, &str); 2],
    targets: usize,
) -> wgpu::RenderPipeline {
    let target = Some(wgpu::ColorTargetState {
        format: TARGET_FORMAT,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment.1),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: vertex.0,
            entry_point: Some(vertex.1),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: fragment.0,
            entry_point: Some(fragment.1),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &vec![target; targets],
        }),
        multiview_mask: None,
        cache: None,
    })
}
