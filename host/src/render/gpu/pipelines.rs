//! Pipelines, made when first needed and kept across scenes.

use super::content::{DEPTH_FORMAT, Drawing, Pass, TARGET_FORMAT};
use super::shaders::{EXITS, HAS_COPIES, PLACE, SCREEN};
use crate::render::RenderError;
use crate::shaders::EntryPoints;
use relievo_bitwise::{Device, Module};
use std::collections::BTreeMap;

/// The pipelines of one module on one device. Objects with the same entry points
/// share one.
pub struct Pipelines {
    device: Device,
    module: Module,
    /// The module for copies that are drawn at once.
    module_of_copies: Module,
    /// The vertex shader.
    place: Option<wgpu::ShaderModule>,
    bindings: wgpu::BindGroupLayout,
    exit_bindings: wgpu::BindGroupLayout,
    /// Outlines to write, and to read.
    outline_bindings: [wgpu::BindGroupLayout; 2],
    /// The layout of shaders that find outlines.
    compute_layout: wgpu::PipelineLayout,
    layout: wgpu::PipelineLayout,
    /// The layout of shaders that ask for exits.
    layout_with_exits: wgpu::PipelineLayout,
    /// By fragment shader, number of targets, and whether copies are drawn.
    made: BTreeMap<(&'static str, usize, bool), wgpu::RenderPipeline>,
    /// The pipelines that shade the G-buffer; made when first needed.
    shade: Option<ShadePipelines>,
    /// By compute shader, and whether copies are drawn.
    made_outlines: BTreeMap<(&'static str, bool), wgpu::ComputePipeline>,
}

impl Pipelines {
    /// Creates an empty set of pipelines for `module` on `device`.
    pub fn new(device: &Device, module: &Module) -> Pipelines {
        let bindings = bind_group_layout(device.wgpu());
        let exit_bindings = exit_bind_group_layout(device.wgpu());
        let outline_bindings = [true, false].map(|is_written| {
            let visibility = if is_written {
                wgpu::ShaderStages::COMPUTE
            } else {
                wgpu::ShaderStages::VERTEX
            };
            device
                .wgpu()
                .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                    label: Some("outlines"),
                    entries: &[buffer_entry(0, visibility, !is_written, true)],
                })
        });
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
            module_of_copies: module.with_constant(HAS_COPIES, 1),
            place: None,
            compute_layout: layout(&[Some(&bindings), Some(&outline_bindings[0])]),
            layout: layout(&[Some(&bindings), None, Some(&outline_bindings[1])]),
            layout_with_exits: layout(&[
                Some(&bindings),
                Some(&exit_bindings),
                Some(&outline_bindings[1]),
            ]),
            bindings,
            exit_bindings,
            outline_bindings,
            made: BTreeMap::new(),
            shade: None,
            made_outlines: BTreeMap::new(),
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

    /// Returns the layout of the outlines, to write or to read.
    pub(super) fn outline_bindings(&self, is_written: bool) -> &wgpu::BindGroupLayout {
        &self.outline_bindings[usize::from(!is_written)]
    }

    /// Makes the pipelines that write exits, if they are missing.
    pub(super) fn make_exits(&mut self, has_copies: bool) -> Result<(), RenderError> {
        let [exits, outlines] = EXITS;
        self.make_drawing(exits, 1, false, has_copies)?;
        self.make_outlines(outlines, has_copies)
    }

    /// Returns the pipeline that [`Self::make_exits`] has made.
    pub(super) fn exits(&self, has_copies: bool) -> &wgpu::RenderPipeline {
        &self.made[&(EXITS[0], 1, has_copies)]
    }

    /// Returns the module for objects, or for copies that are drawn at once.
    fn module(&self, has_copies: bool) -> &Module {
        match has_copies {
            true => &self.module_of_copies,
            false => &self.module,
        }
    }

    /// Returns the pipeline that finds the outlines of facets of objects with these entry
    /// points, or of their exits.
    pub(super) fn outlines(
        &self,
        of: &EntryPoints,
        of_exits: bool,
        has_copies: bool,
    ) -> &wgpu::ComputePipeline {
        let name = if of_exits { EXITS[1] } else { of.outlines };
        &self.made_outlines[&(name, has_copies)]
    }

    /// Makes the pipeline that finds outlines, if it is missing.
    fn make_outlines(&mut self, name: &'static str, has_copies: bool) -> Result<(), RenderError> {
        if self.made_outlines.contains_key(&(name, has_copies)) {
            return Ok(());
        }
        let device = &self.device;
        let module = self.module(has_copies).load(device, name)?;
        let pipeline = device.attempt(|| {
            let descriptor = wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(&self.compute_layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            };
            Ok::<_, RenderError>(device.wgpu().create_compute_pipeline(&descriptor))
        })?;
        self.made_outlines.insert((name, has_copies), pipeline);
        Ok(())
    }

    /// Makes the pipelines for `drawing` of objects with these entry points, if they are
    /// missing.
    pub(super) fn make(
        &mut self,
        of: &EntryPoints,
        drawing: Drawing,
        has_copies: bool,
    ) -> Result<(), RenderError> {
        let targets = drawing.targets().len();
        self.make_drawing(drawing.fragment(of), targets, of.asks_for_exits, has_copies)?;
        self.make_outlines(of.outlines, has_copies)
    }

    /// Makes the pipeline of a fragment shader, if it is missing.
    fn make_drawing(
        &mut self,
        fragment: &'static str,
        targets: usize,
        asks_for_exits: bool,
        has_copies: bool,
    ) -> Result<(), RenderError> {
        let device = &self.device;
        if self.made.contains_key(&(fragment, targets, has_copies)) {
            return Ok(());
        }
        let found = self.module(has_copies).load(device, fragment)?;
        let place = match &mut self.place {
            Some(place) => place,
            none => none.insert(self.module.load(device, PLACE)?),
        };
        let modules = [(&*place, PLACE), (&found, fragment)];
        let layout = if asks_for_exits {
            &self.layout_with_exits
        } else {
            &self.layout
        };
        let pipeline = device.attempt(|| {
            let pipeline = make_pipeline(device.wgpu(), layout, modules, targets, true);
            Ok::<_, RenderError>(pipeline)
        })?;
        self.made.insert((fragment, targets, has_copies), pipeline);
        Ok(())
    }

    /// Returns a pipeline that [`Self::make`] has made.
    pub(super) fn get(
        &self,
        of: &EntryPoints,
        drawing: Drawing,
        has_copies: bool,
    ) -> &wgpu::RenderPipeline {
        &self.made[&(drawing.fragment(of), drawing.targets().len(), has_copies)]
    }

    /// Makes the pipelines of `passes`, if they are missing, and returns the layout of materials and
    /// lights.
    pub(super) fn make_shade(
        &mut self,
        passes: &[Pass],
    ) -> Result<&wgpu::BindGroupLayout, RenderError> {
        let device = &self.device;
        let made = match self.shade.take() {
            Some(made) => made,
            None => {
                device.attempt(|| -> Result<_, RenderError> { Ok(ShadePipelines::new(device)) })?
            }
        };
        let shade = self.shade.insert(made);
        for pass in passes {
            shade.make(&self.device, &self.module, *pass)?;
        }
        Ok(&shade.tables)
    }

    /// Returns the pipelines that [`Self::make_shade`] has made.
    pub(super) fn shade(&self) -> &ShadePipelines {
        self.shade.as_ref().expect("one was made")
    }
}

/// The pipelines that shade the G-buffer.
pub(super) struct ShadePipelines {
    /// The layout of materials and lights.
    tables: wgpu::BindGroupLayout,
    /// The layouts of what passes read beside it, and of both.
    layouts: BTreeMap<Pass, (wgpu::BindGroupLayout, wgpu::PipelineLayout)>,
    made: BTreeMap<Pass, wgpu::RenderPipeline>,
}

impl ShadePipelines {
    fn new(device: &Device) -> ShadePipelines {
        let stage = wgpu::ShaderStages::FRAGMENT;
        let entries: Vec<_> = (0..SHADE_TABLES)
            .map(|binding| buffer_entry(binding, stage, true, false))
            .collect();
        let device = device.wgpu();
        let tables = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("materials and lights"),
            entries: &entries,
        });
        let layouts = Pass::ALL.map(|pass| {
            let count = pass.reads().len() as u32;
            let entries: Vec<_> = (0..count).map(picture_entry).collect();
            let pictures = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("G-buffer"),
                entries: &entries,
            });
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(pass.fragment()),
                bind_group_layouts: &[Some(&tables), Some(&pictures)],
                immediate_size: 0,
            });
            (pass, (pictures, layout))
        });
        ShadePipelines {
            layouts: layouts.into(),
            tables,
            made: BTreeMap::new(),
        }
    }

    fn make(&mut self, device: &Device, module: &Module, pass: Pass) -> Result<(), RenderError> {
        if self.made.contains_key(&pass) {
            return Ok(());
        }
        let fragment = pass.fragment();
        let modules = [
            (&module.load(device, SCREEN)?, SCREEN),
            (&module.load(device, fragment)?, fragment),
        ];
        let (_, layout) = &self.layouts[&pass];
        let made = device.attempt(|| -> Result<_, RenderError> {
            Ok(make_pipeline(device.wgpu(), layout, modules, 1, false))
        })?;
        self.made.insert(pass, made);
        Ok(())
    }

    /// Returns the layout of the pictures that `pass` reads.
    pub(super) fn pictures(&self, pass: Pass) -> &wgpu::BindGroupLayout {
        &self.layouts[&pass].0
    }

    /// Returns a pipeline that was made.
    pub(super) fn pipeline(&self, pass: Pass) -> &wgpu::RenderPipeline {
        &self.made[&pass]
    }
}

/// Number of buffers that shading reads.
const SHADE_TABLES: u32 = 7;

/// Four read-only storage buffers: frame, object, facets, texels.
fn bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let stages = wgpu::ShaderStages::COMPUTE | wgpu::ShaderStages::FRAGMENT;
    // One buffer has the frames of many objects.
    let entries = [0, 1, 2, 3].map(|binding| buffer_entry(binding, stages, true, binding == 0));
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("relievo"),
        entries: &entries,
    })
}

/// A storage buffer.
fn buffer_entry(
    binding: u32,
    visibility: wgpu::ShaderStages,
    read_only: bool,
    has_dynamic_offset: bool,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset,
            min_binding_size: None,
        },
        count: None,
    }
}

/// The picture of exits.
fn exit_bind_group_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("exits"),
        entries: &[picture_entry(0)],
    })
}

/// A picture of words.
fn picture_entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn make_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    [vertex, fragment]: [(&wgpu::ShaderModule, &str); 2],
    targets: usize,
    has_depth: bool,
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
        depth_stencil: has_depth.then(|| wgpu::DepthStencilState {
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
