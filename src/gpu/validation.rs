//! The Khronos validation layer with synchronisation validation, its messages handed to the context's log.

use super::context::{LogCallback, LogLevel};
use ash::vk;
use std::ffi::{c_void, CStr};

pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// What the layer is asked to check beyond its default.
pub(crate) const ENABLED: [vk::ValidationFeatureEnableEXT; 1] =
    [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// The messenger's description; `log` must stay where it is for as long as the messenger lives.
pub(crate) fn messenger_info(log: &LogCallback) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    use vk::{DebugUtilsMessageSeverityFlagsEXT as S, DebugUtilsMessageTypeFlagsEXT as T};
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(S::ERROR | S::WARNING)
        .message_type(T::GENERAL | T::VALIDATION | T::PERFORMANCE)
        .pfn_user_callback(Some(callback))
        .user_data(std::ptr::from_ref(log).cast::<c_void>().cast_mut())
}

unsafe extern "system" fn callback(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes a valid structure and our own user pointer, which outlives the messenger
    // (`messenger_info`).
    let (log, message) = unsafe {
        let message = (*data).message_as_c_str().map(CStr::to_string_lossy).unwrap_or_default();
        (&*user.cast::<LogCallback>(), message)
    };
    let error = severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR);
    let level = if error { LogLevel::Error } else { LogLevel::Warning };
    // A panic must not cross into the driver.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| log(level, &message)));
    vk::FALSE
}
