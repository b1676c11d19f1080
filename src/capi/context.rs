//! The context: a host's device, borrowed.

use super::handles::{get, give, take, ImpastoContext};
use super::memory::{not_null, read, switch, value_if, versioned, write};
use super::status::{c_string, guard, Failure, Result};
use super::types::*;
use crate::gpu::{Context, HostDevice, LogCallback, LogLevel};
use ash::vk;
use ash::vk::Handle;
use std::ffi::{c_char, c_void, CStr};
use std::sync::Arc;

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
    /// Where messages go: what no status can carry, and that the device was lost; null: nowhere.
    pub log: ImpastoLog,
    /// What the log is called with.
    pub log_user: *mut c_void,
    /// 1 if the instance has VK_EXT_debug_utils: objects are named and passes labelled then.
    pub debug_utils: u32,
    /// 0.
    pub reserved: u32,
}
versioned!(ImpastoHostDevice);

/// A host's log. `level` is an ImpastoLogLevel; `text` stays for the time of the call. It may be called from any
/// thread, from several at once, and within any call of the library; it must not call the library.
pub type ImpastoLog = Option<unsafe extern "C" fn(user: *mut c_void, level: u32, text: *const c_char)>;

/// Tells what the library needs, before there is a device.
#[no_mangle]
pub unsafe extern "C" fn impasto_requirements(requirements: *mut ImpastoRequirements) -> ImpastoStatus {
    guard(|| {
        let known = crate::gpu::requirements();
        // SAFETY: the structure is nothing but switches of 32 bits, as Vulkan has it.
        let features: [vk::Bool32; size_of::<vk::PhysicalDeviceFeatures>() / size_of::<vk::Bool32>()] =
            unsafe { std::mem::transmute(known.features) };
        let needs = ImpastoRequirements {
            struct_size: 0,
            api_version: known.api_version,
            queue_flags: known.queue_flags,
            instance_extension_count: known.instance_extensions.len() as u32,
            device_extension_count: known.device_extensions.len() as u32,
            feature_count: features.iter().sum(),
        };
        // SAFETY: the contract of the header.
        unsafe { write(requirements, &needs) }
    })
}

/// Tells whether a device, which need not be made yet, and a family of its queues do: IMPASTO_STATUS_OK, or
/// IMPASTO_STATUS_DEVICE and in words what is missing. impasto_context_create() looks too.
#[no_mangle]
pub unsafe extern "C" fn impasto_device_check(
    get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    instance: VkInstance,
    physical_device: VkPhysicalDevice,
    queue_family: u32,
) -> ImpastoStatus {
    guard(|| {
        let Some(get) = get_instance_proc_addr else { return Err(null("get_instance_proc_addr")) };
        if instance.is_null() || physical_device.is_null() {
            return Err(null("instance or physical device"));
        }
        // SAFETY: the contract of the header.
        unsafe {
            check_functions(get, instance, None)?;
            let instance = ash::Instance::load(&ash::StaticFn { get_instance_proc_addr: get }, instance);
            Ok(crate::gpu::requirements().check(&instance, physical_device, queue_family)?)
        }
    })
}

fn null(what: &str) -> Failure {
    Failure::new(ImpastoStatus::NullPointer, format!("{what} is null"))
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
    let Some(get) = from.get_instance_proc_addr else { return Err(null("get_instance_proc_addr")) };
    if from.instance.is_null() || from.physical_device.is_null() || from.device.is_null() {
        return Err(null("instance, physical device or device"));
    }
    // SAFETY: the caller promises live handles.
    let mut host = unsafe {
        check_functions(get, from.instance, Some(from.device))?;
        HostDevice::from_raw(get, from.instance, from.physical_device, from.device, from.queue_family)
    };
    // SAFETY: the caller promises it.
    host.enabled_features = unsafe { value_if(from.enabled_features) }.unwrap_or_default();
    host.pipeline_cache = from.pipeline_cache;
    host.memory_budget = (from.memory_budget > 0).then_some(from.memory_budget);
    host.debug_utils = switch("debug_utils", from.debug_utils)?;
    host.log = from.log.map(|call| log(Log { call, user: from.log_user }));
    Ok(host)
}

/// A host's log.
struct Log {
    call: unsafe extern "C" fn(*mut c_void, u32, *const c_char),
    user: *mut c_void,
}
// SAFETY: the host takes calls from any thread: the contract of the header.
unsafe impl Send for Log {}
// SAFETY: as above, also at the same time.
unsafe impl Sync for Log {}

impl Log {
    fn tell(&self, level: LogLevel, text: &str) {
        let level = match level {
            LogLevel::Error => ImpastoLogLevel::Error,
            LogLevel::Warning => ImpastoLogLevel::Warning,
        };
        let text = c_string(text);
        // SAFETY: the host's function is called as the header says, with what the host gave for it.
        unsafe { (self.call)(self.user, level as u32, text.as_ptr()) };
    }
}

fn log(log: Log) -> LogCallback {
    Arc::new(move |level, text| log.tell(level, text))
}

/// Checks that functions can be had, a few for all: a call of one that is missing would end the program.
///
/// # Safety
/// The handles are live, and `get` is what it says.
unsafe fn check_functions(
    get: vk::PFN_vkGetInstanceProcAddr,
    instance: VkInstance,
    device: Option<VkDevice>,
) -> Result<()> {
    let missing = |name: &CStr| {
        let text = format!("get_instance_proc_addr knows no {}", name.to_string_lossy());
        Failure::new(ImpastoStatus::Parameter, text)
    };
    let of_instance = c"vkGetDeviceProcAddr";
    // SAFETY: the caller promises it; what is answered for this name is of this type.
    unsafe {
        for name in [c"vkGetPhysicalDeviceProperties", c"vkGetPhysicalDeviceMemoryProperties"] {
            get(instance, name.as_ptr()).ok_or_else(|| missing(name))?;
        }
        let of_device = get(instance, of_instance.as_ptr()).ok_or_else(|| missing(of_instance))?;
        let of_device = std::mem::transmute::<unsafe extern "system" fn(), vk::PFN_vkGetDeviceProcAddr>(of_device);
        let Some(device) = device else { return Ok(()) };
        for name in [c"vkCreateBuffer", c"vkAllocateMemory", c"vkCmdPipelineBarrier", c"vkCmdDispatch"] {
            of_device(device, name.as_ptr()).ok_or_else(|| missing(name))?;
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

/// Tells that the device is lost, as the host has learnt from its own calls; what the library's calls answer it notes
/// itself. From here on calls that would call Vulkan answer with IMPASTO_STATUS_DEVICE_LOST. What was made on the
/// context can be destroyed as always, without a wait.
#[no_mangle]
pub unsafe extern "C" fn impasto_context_device_lost(context: *const ImpastoContext) -> ImpastoStatus {
    guard(|| {
        get(context)?.device_lost();
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
