//! The viewer in a browser.

use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use relievo_bitwise::descriptor;
use std::sync::Arc;

/// Returns options that draw on a canvas with WebGPU.
pub fn options() -> eframe::WebOptions {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
    setup.device_descriptor = Arc::new(descriptor);
    eframe::WebOptions {
        renderer: eframe::Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..Default::default()
        },
        dithering: false,
        ..Default::default()
    }
}
