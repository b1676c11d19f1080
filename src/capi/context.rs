//! The context: a host's device, borrowed.

use super::handles::{get, give, take, ImpastoContext};
use super::memory::{not_null, read, switch, value_if, versioned, write};
use super::status::{guard, Failure, Result};
use super::types::*;
use crate::gpu::{Context, HostDevice};
use ash::vk;
use ash::vk::Handle;
use std::ffi::c_void;

// As Vulkan's header has it; the generated one leaves it out.
/// vkGetInstanceProcAddr, of the loader or of a host that stands between.
#[allow(non_camel_case_types)]
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// What the library needs of instance, device and queue.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoRequirements {
    /// sizeof(ImpastoRequirements), set by the caller.
    pub struct_size: u32,
    /// The least Vulkan version of instance and device.
    pub api_version: u32,
    /// What the family of the queue must do.
    pub queue_flags: VkQueueFlags,
    /// Instance extensions: 0.
    pub instance_extension_count: u32,
    /// Device extensions: 0.
    pub device_extension_count: u32,
    /// Device features that must be enabled: 0.
    pub feature_count: u32,
}
versioned!(ImpastoRequirements);

/// A host's device, to be borrowed. All of it must outlive the context.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ImpastoHostDevice {
    /// sizeof(ImpastoHostDevice).
    pub struct_size: u32,
    /// The family of the queue on which the host will submit; it must draw and compute.
    pub queue_family: u32,
    /// Where all functions come from.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// The instance, made for Vulkan 1.1 or later.
    pub instance: VkInstance,
    /// The physical device.
    pub physical_device: VkPhysicalDevice,
    /// The device.
    pub device: VkDevice,
    /// The features that were enabled, for faster paths; null: none.
    pub enabled_features: *const VkPhysicalDeviceFeatures,
    /// The host's pipeline cache, or null.
    pub pipeline_cache: VkPipelineCache,
    /// Bytes of GPU memory that the context may take; 0: 4 GiB.
    pub memory_budget: u64,
    /// 1 if the instance has VK_EXT_debug_utils: objects are named and passes labelled then.
    pub debug_utils: u32,
    /// 0.
    pub reserved: u32,
}
versioned!(ImpastoHostDevice);

/// Tells what the library needs, before there is a device.
#[no_mangle]
pub unsafe extern "C" fn impasto_requirements(requirements: *mut ImpastoRequirements) -> ImpastoStatus {
    guard(|| {
        let needs = ImpastoRequirements {
            struct_size: 0,
            api_version: crate::gpu::API_VERSION,
            queue_flags: vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE,
            instance_extension_count: 0,
            device_extension_count: 0,
            feature_count: 0,
        };
        // SAFETY: the contract of the header.
        unsafe { write(requirements, &needs) }
    })
}

/// Borrows a device.
#[no_mangle]
pub unsafe extern "C" fn impasto_context_create(
    device: *const ImpastoHostDevice,
    context: *mut *mut ImpastoContext,
) -> ImpastoStatus {
    guard(|| {
        not_null("where the context shall go", context)?;
        // SAFETY: the contract of the header.
        unsafe {
            let made = Context::from_host(host_device(device)?)?;
            context.write(give(made));
        }
        Ok(())
    })
}

/// # Safety
/// The contract of the header.
unsafe fn host_device(from: *const ImpastoHostDevice) -> Result<HostDevice> {
    // SAFETY: the caller promises it.
    let from = unsafe { read(from) }?;
    let null = |what: &str| Err(Failure::new(ImpastoStatus::NullPointer, format!("{what} is null")));
    let Some(get) = from.get_instance_proc_addr else { return null("get_instance_proc_addr") };
    if from.instance.is_null() || from.physical_device.is_null() || from.device.is_null() {
        return null("instance, physical device or device");
    }
    // SAFETY: the caller promises live handles.
    let mut host = unsafe {
        check_functions(get, &from)?;
        HostDevice::from_raw(get, from.instance, from.physical_device, from.device, from.queue_family)
    };
    // SAFETY: the caller promises it.
    host.enabled_features = unsafe { value_if(from.enabled_features) }.unwrap_or_default();
    host.pipeline_cache = from.pipeline_cache;
    host.memory_budget = (from.memory_budget > 0).then_some(from.memory_budget);
    host.debug_utils = switch("debug_utils", from.debug_utils)?;
    Ok(host)
}

/// Checks that functions can be had, a few for all: a call of one that is missing would end the program.
///
/// # Safety
/// The handles are live, and `get` is what it says.
unsafe fn check_functions(get: vk::PFN_vkGetInstanceProcAddr, from: &ImpastoHostDevice) -> Result<()> {
    let missing = |name| Failure::new(ImpastoStatus::Parameter, format!("get_instance_proc_addr knows no {name}"));
    // SAFETY: the caller promises it; what is answered for this name is of this type.
    unsafe {
        for name in [c"vkGetPhysicalDeviceProperties", c"vkGetPhysicalDeviceMemoryProperties"] {
            get(from.instance, name.as_ptr()).ok_or_else(|| missing(name.to_string_lossy()))?;
        }
        let name = c"vkGetDeviceProcAddr";
        let of_device = get(from.instance, name.as_ptr()).ok_or_else(|| missing(name.to_string_lossy()))?;
        let of_device = std::mem::transmute::<*const c_void, vk::PFN_vkGetDeviceProcAddr>(of_device as *const c_void);
        for name in [c"vkCreateBuffer", c"vkAllocateMemory", c"vkCmdPipelineBarrier", c"vkCmdDispatch"] {
            of_device(from.device, name.as_ptr()).ok_or_else(|| missing(name.to_string_lossy()))?;
        }
    }
    Ok(())
}

/// Tells where the GPU is: what is recorded from here on belongs to `current_frame`, and everything recorded in frames
/// up to and including `safe_frame` has run. What was destroyed in safe frames is freed now. Once a frame, and before
/// each call of impasto_effect_prepare().
#[no_mangle]
pub unsafe extern "C" fn impasto_context_advance(
    context: *const ImpastoContext,
    current_frame: u64,
    safe_frame: u64,
) -> ImpastoStatus {
    guard(|| {
        let context = get(context)?;
        if safe_frame >= current_frame {
            let allowed = format!("below the current frame, {current_frame}");
            return Err(Failure::parameter("safe_frame", safe_frame, allowed));
        }
        context.advance(current_frame, safe_frame);
        Ok(())
    })
}

/// The bytes of GPU memory that what stands on the context takes now.
#[no_mangle]
pub unsafe extern "C" fn impasto_context_allocated_bytes(
    context: *const ImpastoContext,
    bytes: *mut u64,
) -> ImpastoStatus {
    guard(|| {
        not_null("bytes", bytes)?;
        let allocated = get(context)?.allocated_bytes();
        // SAFETY: the contract of the header.
        unsafe { bytes.write(allocated) };
        Ok(())
    })
}

/// Gives the device back; null is fine. The GPU must be done with all that was recorded. What stands on the context
/// must be destroyed before, else nothing happens and the answer is IMPASTO_STATUS_IN_USE.
#[no_mangle]
pub unsafe extern "C" fn impasto_context_destroy(context: *mut ImpastoContext) -> ImpastoStatus {
    guard(|| take(context))
}
