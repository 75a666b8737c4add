//! Two renderers behind one interface: the same shared code on the CPU and in
//! a fragment shader, and the same words of a picture from both.

pub mod cpu;
pub mod fallback;
pub mod gpu;

use crate::prepare::PreparedScene;
use relievo_bitwise::{DeviceError, TIME_LIMIT};
use relievo_shared::layout::Frame;
use relievo_shared::normals::CLASS_MISS;

pub use cpu::{CpuRenderer, Effort};
pub use fallback::FallbackRenderer;
pub use gpu::GpuRenderer;

/// Linear colours, as the bits of f32.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColorWords {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// (red, green, blue, class) of each pixel, rows from the top.
    pub words: Vec<[u32; 4]>,
}

impl ColorWords {
    /// Linear RGB of a pixel.
    pub fn rgb(&self, x: u32, y: u32) -> [f32; 3] {
        let [r, g, b, _] = self.words[y as usize * self.width as usize + x as usize];
        [r, g, b].map(f32::from_bits)
    }
}

/// What was hit, as bits; all 0 where nothing was.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeometryWords {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// (t, u, v, δ) of each pixel, rows from the top.
    pub place: Vec<[u32; 4]>,
    /// (class + 256 · steps, N.x, N.y, N.z) of each pixel.
    pub surface: Vec<[u32; 4]>,
}

impl GeometryWords {
    /// Surface class of pixel number `index`.
    pub fn class(&self, index: usize) -> u32 {
        self.surface[index][0] & 255
    }

    /// Steps of the linear search in pixel number `index`; 0 where nothing was hit.
    pub fn steps(&self, index: usize) -> u32 {
        self.surface[index][0] >> 8
    }

    /// Number of the pixels in which something was hit, and the mean of the
    /// linear steps in those.
    pub fn coverage(&self) -> (usize, f64) {
        let (mut covered, mut steps) = (0, 0_u64);
        for index in (0..self.surface.len()).filter(|&index| self.class(index) != CLASS_MISS) {
            covered += 1;
            steps += u64::from(self.steps(index));
        }
        (covered, steps as f64 / covered.max(1) as f64)
    }
}

/// The machine cannot render this.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// There is no adapter, or none of the wanted name.
    #[error("no GPU adapter {wanted}; {found}; use --backend cpu, or install a Vulkan driver")]
    NoAdapter {
        /// What was looked for.
        wanted: String,
        /// What is there.
        found: String,
    },
    /// The adapter gave no device, or the device failed or was lost.
    #[error("{adapter}: {message}; use --backend cpu or another --adapter")]
    Device {
        /// The adapter.
        adapter: String,
        /// Why.
        message: String,
    },
    /// The device has not the memory for the scene or its picture.
    #[error(
        "{adapter}: {message}; use --backend cpu, a smaller picture (--size), or less in the scene"
    )]
    DeviceMemory {
        /// The adapter.
        adapter: String,
        /// For what.
        message: String,
    },
    /// The longest time to wait for a device is no time.
    #[error(
        "the environment variable {TIME_LIMIT} is {value:?}; make it a number of seconds, such as 60, or leave it out"
    )]
    TimeLimit {
        /// What it was set to.
        value: String,
    },
    /// There is no window to draw on.
    #[error("no window can be opened: {message}; use `relievo render` for pictures without one")]
    Window {
        /// Why.
        message: String,
    },
    /// There is not enough memory for the picture.
    #[error(
        "not enough memory for {what} ({bytes} bytes); make the picture smaller (--size, or supersample = false)"
    )]
    Memory {
        /// What does not fit.
        what: String,
        /// Its size.
        bytes: usize,
    },
    /// The scene is larger than the adapter's limits.
    #[error(
        "{adapter}: {what} needs {needed}, and its limit is {limit}; use --backend cpu, or less of it"
    )]
    Limit {
        /// The adapter.
        adapter: String,
        /// What is too large.
        what: String,
        /// How much it needs.
        needed: u64,
        /// How much there may be.
        limit: u64,
    },
}

impl From<DeviceError> for RenderError {
    fn from(error: DeviceError) -> RenderError {
        match error {
            DeviceError::NoAdapter { wanted, found } => RenderError::NoAdapter { wanted, found },
            DeviceError::Device { adapter, message } => RenderError::Device { adapter, message },
            DeviceError::Memory { adapter, message } => {
                RenderError::DeviceMemory { adapter, message }
            }
            DeviceError::TimeLimit { value } => RenderError::TimeLimit { value },
            DeviceError::Limit {
                adapter,
                what,
                needed,
                limit,
            } => RenderError::Limit {
                adapter,
                what,
                needed,
                limit,
            },
            DeviceError::Untouched { adapter } => RenderError::Device {
                adapter,
                message: "takes no SPIR-V untouched".to_string(),
            },
            error @ (DeviceError::Module { .. }
            | DeviceError::Kernel { .. }
            | DeviceError::Domain(_)) => RenderError::Device {
                adapter: "the shaders built in".to_string(),
                message: error.to_string(),
            },
        }
    }
}

/// Something that makes pictures of one prepared scene.
pub trait Renderer {
    /// What renders, for a person: "CPU (2 threads)", "llvmpipe (Vulkan)".
    fn name(&self) -> String;

    /// Colours of the scene as seen in `frame`.
    ///
    /// # Errors
    /// [`RenderError`] where the machine fails.
    fn color(&mut self, frame: &Frame) -> Result<ColorWords, RenderError>;

    /// What is hit in `frame`.
    ///
    /// # Errors
    /// [`RenderError`] where the machine fails.
    fn geometry(&mut self, frame: &Frame) -> Result<GeometryWords, RenderError>;
}

/// The background of `scene` as a pixel of [`ColorWords`].
fn background_words(scene: &PreparedScene) -> [u32; 4] {
    let [r, g, b] = scene.background.map(f32::to_bits);
    [r, g, b, CLASS_MISS]
}

/// `count` copies of `value`, or an error where the memory does not suffice.
pub(crate) fn allocate<T: Clone>(
    what: &str,
    count: usize,
    value: T,
) -> Result<Vec<T>, RenderError> {
    let mut buffer = Vec::new();
    buffer
        .try_reserve_exact(count)
        .map_err(|_| RenderError::Memory {
            what: what.to_string(),
            bytes: count.saturating_mul(size_of::<T>()),
        })?;
    buffer.resize(count, value);
    Ok(buffer)
}
