//! Vulkan drivers beside the one that is found first, and the validation layer: how a child process gets them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Says past the test harness, which hides what passing tests print, what was not tested and why.
///
/// # Panics
/// If standard error is closed.
pub fn skipped(what: &str, why: &str) {
    std::io::stderr().write_all(format!("skipped: {what}: {why}\n").as_bytes()).unwrap();
}

/// The manifest of a second Vulkan driver, which `tests/run` finds.
pub fn second_driver() -> Option<PathBuf> {
    std::env::var_os("RAYSCOPE_SECOND_DRIVER").filter(|path| !path.is_empty()).map(PathBuf::from)
}

/// Lets a program run on the driver of this manifest alone.
pub fn on_driver(command: &mut Command, manifest: &Path) {
    command.env("VK_DRIVER_FILES", manifest);
}

/// Whether `tests/run` has seen the validation layer, so that its absence is a fault.
pub fn is_validation_expected() -> bool {
    std::env::var_os("RAYSCOPE_VALIDATION").is_some()
}

/// Lets a program run under Khronos's validation layer with synchronisation checks; what that has to
/// say goes to `log`.
///
/// # Panics
/// If its settings cannot be written beside the log.
pub fn validate(command: &mut Command, log: &Path) {
    let settings = log.with_extension("settings");
    // Information, too: without it the layer does not say that it is there.
    let text = format!(
        "khronos_validation.enables = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT\n\
         khronos_validation.report_flags = error,perf,warn,info\n\
         khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n\
         khronos_validation.log_filename = {}\n",
        log.display()
    );
    std::fs::write(&settings, text).unwrap();
    command.env("VK_INSTANCE_LAYERS", "VK_LAYER_KHRONOS_validation").env("VK_LAYER_SETTINGS_PATH", settings);
    // wgpu would listen itself, and name WGSL in debug information, which older layers take for a fault.
    command.env("WGPU_VALIDATION", "0").env("WGPU_DEBUG", "0");
}
