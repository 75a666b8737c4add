//! Exported GLSL, drawn with OpenGL 4.5 offscreen, through EGL.

use super::cases::{Difference, cases, exported, file};
use super::webgpu::map_size;
use glow::HasContext;
use khronos_egl as egl;
use relievo::export::{ExportedFile, Output, Target};
use relievo::prepare::PreparedScene;
use relievo_tests::lacking;

/// EGL's surfaceless platform (EGL_MESA_platform_surfaceless).
const SURFACELESS: egl::Enum = 0x31dd;

/// OpenGL, current on this thread.
pub fn open() -> Result<glow::Context, String> {
    let explain = |error: &dyn std::fmt::Display| error.to_string();
    // SAFETY: the system's EGL library is trusted.
    let egl = unsafe { egl::DynamicInstance::<egl::EGL1_5>::load_required() }
        .map_err(|error| explain(&error))?;
    // SAFETY: this platform has no native display.
    let display =
        unsafe { egl.get_platform_display(SURFACELESS, egl::DEFAULT_DISPLAY, &[egl::ATTRIB_NONE]) }
            .map_err(|error| explain(&error))?;
    egl.initialize(display).map_err(|error| explain(&error))?;
    egl.bind_api(egl::OPENGL_API)
        .map_err(|error| explain(&error))?;
    let attributes = [
        egl::RENDERABLE_TYPE,
        egl::OPENGL_BIT,
        egl::SURFACE_TYPE,
        0,
        egl::NONE,
    ];
    let config = egl
        .choose_first_config(display, &attributes)
        .map_err(|error| explain(&error))?
        .ok_or("EGL has no configuration for OpenGL")?;
    let version = [
        egl::CONTEXT_MAJOR_VERSION,
        4,
        egl::CONTEXT_MINOR_VERSION,
        5,
        egl::CONTEXT_OPENGL_PROFILE_MASK,
        egl::CONTEXT_OPENGL_CORE_PROFILE_BIT,
        egl::NONE,
    ];
    let context = egl
        .create_context(display, config, None, &version)
        .map_err(|error| explain(&error))?;
    egl.make_current(display, None, None, Some(context))
        .map_err(|error| explain(&error))?;
    let address = |name: &str| {
        egl.get_proc_address(name)
            .map_or(std::ptr::null(), |function| function as *const _)
    };
    // SAFETY: a context is current.
    Ok(unsafe { glow::Context::from_loader_function(address) })
}

/// Draws `objects` and reads the target: four words per pixel, rows from the
/// top. `fragment` returns the fragment shader of an object's files.
pub fn draw(
    gl: &glow::Context,
    scene: &PreparedScene,
    objects: &[Vec<ExportedFile>],
    output: Output,
    fragment: impl Fn(&[ExportedFile]) -> String,
) -> Vec<[u32; 4]> {
    let [width, height] = scene.size.map(|side| side as i32);
    let mut bytes = vec![0; 16 * (width * height) as usize];
    // SAFETY: the context is current, its objects live to the end of it, and
    // the shaders stay within the buffers, which are bound whole.
    unsafe {
        let texture = |format| {
            let texture = gl.create_texture().unwrap();
            gl.bind_texture(glow::TEXTURE_2D, Some(texture));
            gl.tex_storage_2d(glow::TEXTURE_2D, 1, format, width, height);
            texture
        };
        let (format, read_format, kind) = match output {
            Output::Color | Output::Hit => (glow::RGBA32F, glow::RGBA, glow::FLOAT),
            Output::Words => (glow::RGBA32UI, glow::RGBA_INTEGER, glow::UNSIGNED_INT),
        };
        let framebuffer = gl.create_framebuffer().unwrap();
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
        for (attachment, format) in [
            (glow::COLOR_ATTACHMENT0, format),
            (glow::DEPTH_ATTACHMENT, glow::DEPTH_COMPONENT32F),
        ] {
            let texture = texture(format);
            let target = glow::FRAMEBUFFER;
            gl.framebuffer_texture_2d(target, attachment, glow::TEXTURE_2D, Some(texture), 0);
        }
        let status = gl.check_framebuffer_status(glow::FRAMEBUFFER);
        assert_eq!(status, glow::FRAMEBUFFER_COMPLETE);
        gl.viewport(0, 0, width, height);
        match output {
            Output::Color | Output::Hit => {
                let [r, g, b] = scene.background;
                gl.clear_buffer_f32_slice(glow::COLOR, 0, &[r, g, b, 1.0]);
            }
            Output::Words => gl.clear_buffer_u32_slice(glow::COLOR, 0, &[0; 4]),
        }
        gl.clear_buffer_f32_slice(glow::DEPTH, 0, &[0.0]);
        gl.enable(glow::DEPTH_TEST);
        gl.depth_func(glow::GREATER);
        let nothing = gl.create_vertex_array().unwrap();
        gl.bind_vertex_array(Some(nothing));
        for files in objects {
            let program = gl.create_program().unwrap();
            for (source, stage) in [
                (text(files, "vertex.vert"), glow::VERTEX_SHADER),
                (fragment(files), glow::FRAGMENT_SHADER),
            ] {
                let shader = gl.create_shader(stage).unwrap();
                gl.shader_source(shader, &source);
                gl.compile_shader(shader);
                let is_right = gl.get_shader_compile_status(shader);
                assert!(is_right, "{}", gl.get_shader_info_log(shader));
                gl.attach_shader(program, shader);
            }
            gl.link_program(program);
            let is_right = gl.get_program_link_status(program);
            assert!(is_right, "{}", gl.get_program_info_log(program));
            gl.use_program(Some(program));
            let names = ["frame.bin", "object.bin", "facets.bin", "map.bin"];
            for (binding, name) in (0..).zip(names) {
                if let Some([width, height]) = map_size(files).filter(|_| binding == 3) {
                    gl.active_texture(glow::TEXTURE0 + binding);
                    let texture = gl.create_texture().unwrap();
                    gl.bind_texture(glow::TEXTURE_2D, Some(texture));
                    let [width, height] = [width as i32, height as i32];
                    gl.tex_storage_2d(glow::TEXTURE_2D, 1, glow::R32UI, width, height);
                    let texels = glow::PixelUnpackData::Slice(Some(file(files, name)));
                    let (target, format) = (glow::TEXTURE_2D, glow::RED_INTEGER);
                    gl.tex_sub_image_2d(
                        target,
                        0,
                        0,
                        0,
                        width,
                        height,
                        format,
                        glow::UNSIGNED_INT,
                        texels,
                    );
                    for filter in [glow::TEXTURE_MIN_FILTER, glow::TEXTURE_MAG_FILTER] {
                        gl.tex_parameter_i32(glow::TEXTURE_2D, filter, glow::NEAREST as i32);
                    }
                    continue;
                }
                let buffer = gl.create_buffer().unwrap();
                let target = glow::SHADER_STORAGE_BUFFER;
                gl.bind_buffer(target, Some(buffer));
                gl.buffer_data_u8_slice(target, file(files, name), glow::STATIC_DRAW);
                gl.bind_buffer_base(target, binding, Some(buffer));
            }
            let [vertices, ..]: [u32; 4] = bytemuck::pod_read_unaligned(file(files, "draw.bin"));
            gl.draw_arrays(glow::TRIANGLES, 0, vertices as i32);
        }
        let pixels = glow::PixelPackData::Slice(Some(&mut bytes));
        gl.read_pixels(0, 0, width, height, read_format, kind, pixels);
        assert_eq!(gl.get_error(), glow::NO_ERROR);
    }
    // OpenGL's first row is the lowest.
    bytes
        .rchunks(16 * width as usize)
        .flat_map(bytemuck::pod_collect_to_vec::<u8, [u32; 4]>)
        .collect()
}

/// A file of text.
pub fn text(files: &[ExportedFile], name: &str) -> String {
    String::from_utf8(file(files, name).to_vec()).unwrap()
}

/// Every shader, and several objects with one depth buffer, match the CPU's
/// picture.
#[test]
fn glsl_draws_our_picture() {
    let gl = match open() {
        Ok(gl) => gl,
        Err(reason) => return lacking(&format!("OpenGL 4.5 by way of EGL ({reason})")),
    };
    // SAFETY: the context is current.
    let name = unsafe { [glow::RENDERER, glow::VERSION].map(|what| gl.get_parameter_string(what)) };
    eprintln!("GLSL on {}", name.join(", OpenGL "));
    let is_software = name[0].contains("llvmpipe");
    for case in cases() {
        let [colors, words] = [Output::Color, Output::Words].map(|output| {
            let objects = exported(&case.scene, Target::Glsl, output);
            draw(&gl, &case.scene, &objects, output, |files| {
                text(files, "fragment.frag")
            })
        });
        let difference = Difference::of(&case.scene, &colors, &words);
        eprintln!("{}: {difference:?}", case.name);
        difference.check(&case, is_software);
    }
}
