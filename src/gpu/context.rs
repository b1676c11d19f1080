//! A device of our own, or a host's, and everything that lives as long as it does.
//!
//! All other GPU objects hold a clone of the [`Context`]. What they free goes to its graveyard first and is destroyed
//! when the GPU is known to be done with it: the context counts *frames*, an object dropped during frame n is destroyed
//! once [`Context::advance`] says that frame n is safe.

use super::allocation::{HostMemory, Memory};
use super::caps::{describe, offers_integer_dot_product, Caps, DeviceChoice, DeviceInfo};
use super::host_device::HostDevice;
use super::loader::{queue_family, Loader};
use super::memory::Garbage;
use super::pipeline::PipelineCacheFile;
use super::requirements::requirements;
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// How grave a message to the log is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogLevel {
    /// Something is wrong.
    Error,
    /// Something looks wrong.
    Warning,
}

/// Where messages go: what could not be answered with an error, as from a destructor, and that a device was lost. The
/// library itself prints nothing. May be called from any thread, also while another call of it has not returned, and
/// from within any call of the library; it must not panic, nor call the library.
pub type LogCallback = Arc<dyn Fn(LogLevel, &str) + Send + Sync>;

/// How to make a [`Context`] with a device of its own.
#[derive(Clone, Default)]
pub struct ContextOptions {
    /// Which device.
    pub device: DeviceChoice,
    /// Turn on the Khronos validation layer with synchronisation validation; its messages go to `log`.
    pub validation: bool,
    /// Where messages go; `None`: nowhere.
    pub log: Option<LogCallback>,
    /// A folder in which the pipeline cache is kept from one start to the next; `None`: it is not kept.
    pub pipeline_cache_dir: Option<PathBuf>,
    /// Bytes of GPU memory that the context may take; `None`: 4 GiB.
    pub memory_budget: Option<u64>,
}

/// Turns a Vulkan result into our error, naming the call. Where there is a context it has to know: `Context::failed`.
pub(crate) fn vulkan(call: &'static str) -> impl Fn(vk::Result) -> Error {
    move |result| match result {
        vk::Result::ERROR_DEVICE_LOST => Error::DeviceLost,
        result => Error::Vulkan { call, result },
    }
}

/// A device to work with; cheap to clone, all clones are the same context.
///
/// A context and what is made from it may move between threads. One thread at a time records with it, and calls
/// [`Context::advance`]; others may make and drop objects meanwhile, as the preparing thread of an
/// [`Effect`](crate::embed::Effect) does.
#[derive(Clone)]
pub struct Context {
    inner: Arc<Inner>,
}

pub(crate) struct Inner {
    loader: Option<Loader>,
    pub instance: ash::Instance,
    pub device: ash::Device,
    /// The context that this one measures for.
    measured: Option<Context>,
    physical_device: vk::PhysicalDevice,
    pub queue_family: u32,
    /// Null on a borrowed device: there the host submits.
    pub queue: vk::Queue,
    pub info: DeviceInfo,
    pub caps: Caps,
    pub enabled_features: vk::PhysicalDeviceFeatures,
    pub pipeline_cache: vk::PipelineCache,
    cache_file: Option<PipelineCacheFile>,
    pub debug_utils: Option<ash::ext::debug_utils::Device>,
    pub memory: Memory,
    pub budget: u64,
    compiling_ns: AtomicU64,
    graveyard: Mutex<Vec<(u64, Garbage)>>,
    frame: AtomicU64,
    safe_frame: AtomicU64,
    next_id: AtomicU64,
    log: Option<LogCallback>,
    /// The device is lost; nothing is asked of it any more.
    lost: AtomicBool,
    /// Held by a runner from recording to the end of its wait: the queue may be used by one thread at a time.
    pub running: Mutex<()>,
}

const DEFAULT_BUDGET: u64 = 4 << 30;

impl Context {
    /// Makes an instance and a device of our own, without any window.
    ///
    /// # Errors
    /// [`Error::Device`] when there is no Vulkan, no such device, or no validation layer though asked for;
    /// [`Error::Vulkan`] when a call fails.
    pub fn new(options: &ContextOptions) -> Result<Self> {
        let loader = Loader::new(options.validation, options.log.clone())?;
        let made = Self::on_loader(&loader, options);
        match made {
            Ok((device, physical, family, info)) => {
                // SAFETY: the family was asked for with one queue.
                let queue = unsafe { device.get_device_queue(family, 0) };
                let made =
                    Inner::new(&loader.instance, physical, device.clone(), family, info, options.memory_budget, None);
                let mut inner = match made {
                    Ok(inner) => inner,
                    Err(error) => {
                        // SAFETY: nothing was made from the device.
                        unsafe { device.destroy_device(None) };
                        loader.destroy();
                        return Err(error);
                    }
                };
                inner.queue = queue;
                inner.log = options.log.clone();
                inner.caps.integer_dot_product = offers_integer_dot_product(&loader.instance, physical);
                if loader.debug_utils {
                    inner.debug_utils = Some(ash::ext::debug_utils::Device::new(&inner.instance, &inner.device));
                }
                // From here on dropping `inner` destroys device and instance.
                inner.loader = Some(loader);
                let file = options.pipeline_cache_dir.as_ref().map(|dir| PipelineCacheFile::new(dir, &inner.caps));
                inner.pipeline_cache = PipelineCacheFile::create(file.as_ref(), &inner.device)?;
                inner.cache_file = file;
                Ok(Context { inner: Arc::new(inner) })
            }
            Err(error) => {
                loader.destroy();
                Err(error)
            }
        }
    }

    fn on_loader(
        loader: &Loader,
        options: &ContextOptions,
    ) -> Result<(ash::Device, vk::PhysicalDevice, u32, DeviceInfo)> {
        let devices = loader.physical_devices()?;
        let infos: Vec<DeviceInfo> = devices.iter().map(|(_, info)| info.clone()).collect();
        let picked = options.device.pick(&infos)?.clone();
        let missing = || Error::Device(format!("{} has no queue that draws and computes", picked.name));
        let physical = devices.iter().find(|(_, info)| *info == picked).map(|(p, _)| *p).ok_or_else(missing)?;
        let family = queue_family(&loader.instance, physical).ok_or_else(missing)?;
        // SAFETY: the instance is live and of version 1.1, and the device one of its.
        unsafe { requirements().check(&loader.instance, physical, family) }?;
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&priorities)];
        // The one thing that is turned on where it is offered; no stage needs it.
        let extensions = [ash::khr::shader_integer_dot_product::NAME.as_ptr()];
        let mut dot = vk::PhysicalDeviceShaderIntegerDotProductFeatures::default().shader_integer_dot_product(true);
        let mut info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
        if offers_integer_dot_product(&loader.instance, physical) {
            info = info.enabled_extension_names(&extensions).push_next(&mut dot);
        }
        // SAFETY: `physical` belongs to the live instance; `info` outlives the call.
        let device =
            unsafe { loader.instance.create_device(physical, &info, None) }.map_err(vulkan("vkCreateDevice"))?;
        Ok((device, physical, family, picked))
    }

    /// Borrows a host's device. Nothing of it is destroyed when the context goes.
    ///
    /// # Safety
    /// All handles must be live and belong together, `queue_family` must draw and compute, `enabled_features` must be
    /// what the device was made with, and all of it must outlive the context and everything made from it. When the last
    /// clone of the context is dropped, the GPU must be done with all that was recorded through it.
    ///
    /// # Errors
    /// [`Error::Device`] when the device or the queue family lacks something of [`requirements`].
    pub unsafe fn from_host(host: HostDevice) -> Result<Self> {
        // SAFETY: the caller promises live handles that belong together.
        unsafe { requirements().check(&host.instance, host.physical_device, host.queue_family) }?;
        let info = describe(&host.instance, host.physical_device, 0);
        let debug = host.debug_utils.then(|| ash::ext::debug_utils::Device::new(&host.instance, &host.device));
        let mut inner = Inner::new(
            &host.instance,
            host.physical_device,
            host.device,
            host.queue_family,
            info,
            host.memory_budget,
            host.memory,
        )?;
        inner.enabled_features = host.enabled_features;
        inner.pipeline_cache = host.pipeline_cache;
        inner.debug_utils = debug;
        inner.log = host.log;
        Ok(Context { inner: Arc::new(inner) })
    }

    /// A context to measure with: on the same device by another table of its functions, and with other memory.
    pub(crate) fn on_other_device(&self, device: ash::Device, memory: Arc<dyn HostMemory>) -> Result<Self> {
        let inner = &self.inner;
        let made = Inner::new(
            &inner.instance,
            inner.physical_device,
            device,
            inner.queue_family,
            inner.info.clone(),
            Some(inner.budget),
            Some(memory),
        );
        made.map(|mut inner| {
            inner.measured = Some(self.clone());
            Context { inner: Arc::new(inner) }
        })
    }

    /// Which device this is.
    pub fn device_info(&self) -> &DeviceInfo {
        &self.inner.info
    }

    /// Its limits.
    pub fn caps(&self) -> &Caps {
        &self.inner.caps
    }

    /// The optional features that are enabled, for faster paths; on a device of our own none are.
    pub fn enabled_features(&self) -> &vk::PhysicalDeviceFeatures {
        &self.inner.enabled_features
    }

    /// Bytes of GPU memory that the context's objects take now.
    pub fn allocated_bytes(&self) -> u64 {
        self.inner.memory.allocated_bytes()
    }

    /// How long the driver has taken to make the context's pipelines so far. Some drivers put off part of the compilation
    /// to a pipeline's first use, which is not in it.
    pub fn compile_time(&self) -> Duration {
        Duration::from_nanos(self.inner.compiling_ns.load(Ordering::Relaxed))
    }

    /// Makes a pipeline, and adds its time to [`Context::compile_time`].
    pub(crate) fn compile<T>(&self, make: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let made = make();
        self.inner.compiling_ns.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        made
    }

    /// Tells where the GPU is: from here on objects belong to `current_frame`, and everything recorded in frames up to
    /// and including `safe_frame` has run. Objects dropped in safe frames are destroyed now.
    ///
    /// Numbers may begin anywhere and leave some out, but never go down; the first call stands before the first
    /// recording. A host that counts from 0 may tell 0 as safe as long as nothing is: what is recorded after this call
    /// counts as of a later frame than `safe_frame`, whatever the numbers. A safe frame beyond the current one means
    /// the current one.
    pub fn advance(&self, current_frame: u64, safe_frame: u64) {
        let safe_frame = safe_frame.min(current_frame);
        self.inner.frame.store(current_frame, Ordering::Relaxed);
        self.inner.safe_frame.store(safe_frame, Ordering::Relaxed);
        let mut graveyard = lock(&self.inner.graveyard);
        let (safe, kept) = std::mem::take(&mut *graveyard).into_iter().partition(|(frame, _)| *frame <= safe_frame);
        *graveyard = kept;
        drop(graveyard);
        self.inner.destroy(safe);
    }

    /// Takes note that the device is lost, as a host learns from its own calls (`VK_ERROR_DEVICE_LOST`); what the
    /// library's calls answer it notes itself. From here on whatever would call Vulkan fails with
    /// [`Error::DeviceLost`]. A lost device has nothing in flight: what was dropped before is destroyed now, and what is
    /// dropped later at once, without a wait.
    pub fn device_lost(&self) {
        if !self.inner.lost.swap(true, Ordering::Relaxed) {
            self.log(LogLevel::Error, &format!("{}: {}", self.inner.info.name, Error::DeviceLost));
        }
        let garbage = std::mem::take(&mut *lock(&self.inner.graveyard));
        self.inner.destroy(garbage);
    }

    /// Whether the device is known to be lost.
    pub fn is_device_lost(&self) -> bool {
        self.inner.lost.load(Ordering::Relaxed)
    }

    /// The device for a call that may fail.
    ///
    /// # Errors
    /// [`Error::DeviceLost`] when the device is lost.
    pub(crate) fn usable(&self) -> Result<&ash::Device> {
        match self.is_device_lost() {
            true => Err(Error::DeviceLost),
            false => Ok(self.device()),
        }
    }

    /// Turns what a Vulkan call answered into our error, and takes note when it is that the device is lost.
    pub(crate) fn failed(&self, call: &'static str) -> impl Fn(vk::Result) -> Error + '_ {
        move |result| {
            if result == vk::Result::ERROR_DEVICE_LOST {
                self.device_lost();
            }
            vulkan(call)(result)
        }
    }

    /// Waits until nothing is in flight on a device of our own; on a lost one nothing is. Its errors have no other way
    /// than the log, as it is for destructors.
    pub(crate) fn wait_idle(&self) {
        self.inner.wait_idle();
    }

    /// Tells the host something that no error can carry.
    pub(crate) fn log(&self, level: LogLevel, text: &str) {
        self.inner.log(level, text);
    }

    /// The number that what is recorded or dropped now goes by: the current frame's, but never one that is safe already.
    pub(crate) fn frame(&self) -> u64 {
        self.inner.frame.load(Ordering::Relaxed).max(self.safe_frame().saturating_add(1))
    }

    /// The last frame that is known to have run.
    pub(crate) fn safe_frame(&self) -> u64 {
        self.inner.safe_frame.load(Ordering::Relaxed)
    }

    /// Checks that something else, which a caller brought as `name`, is of this context too.
    ///
    /// # Errors
    /// [`Error::Parameter`] when it is of another, whose handles mean nothing here.
    pub(crate) fn check_same(&self, name: &'static str, other: &Context) -> Result<()> {
        // A host's images are measured as if they were the measuring context's own.
        let own = self.inner.measured.as_ref().unwrap_or(self);
        match Arc::ptr_eq(&own.inner, &other.inner) || Arc::ptr_eq(&self.inner, &other.inner) {
            true => Ok(()),
            false => Err(Error::parameter(name, "of another context", "of the same context")),
        }
    }

    pub(crate) fn inner(&self) -> &Inner {
        &self.inner
    }

    pub(crate) fn device(&self) -> &ash::Device {
        &self.inner.device
    }

    /// Hands over something to be destroyed when the frame that is recorded now is safe: at once on a lost device.
    pub(crate) fn bury(&self, garbage: Garbage) {
        if self.is_device_lost() {
            self.inner.destroy(vec![(self.frame(), garbage)]);
        } else {
            lock(&self.inner.graveyard).push((self.frame(), garbage));
        }
    }

    pub(crate) fn next_id(&self) -> u64 {
        self.inner.next_id.fetch_add(1, Ordering::Relaxed)
    }

    /// Names an object for debuggers and validation messages.
    pub(crate) fn name<H: vk::Handle>(&self, handle: H, name: &str) {
        if let Some(debug) = &self.inner.debug_utils {
            let Ok(text) = std::ffi::CString::new(name) else { return };
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&text);
            // SAFETY: the handle is live and from this device. A failure to name is of no consequence.
            let _ = unsafe { debug.set_debug_utils_object_name(&info) };
        }
    }
}

/// Locks, also after a panic elsewhere: the data behind our locks is valid at every point.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Blocks of memory that objects are placed in: small at first, for a host that has better use for it.
fn block_sizes() -> gpu_allocator::AllocationSizes {
    gpu_allocator::AllocationSizes::new(16 << 20, 4 << 20)
        .with_max_device_memblock_size(256 << 20)
        .with_max_host_memblock_size(64 << 20)
}

impl Inner {
    fn new(
        instance: &ash::Instance,
        physical: vk::PhysicalDevice,
        device: ash::Device,
        queue_family: u32,
        info: DeviceInfo,
        budget: Option<u64>,
        host_memory: Option<Arc<dyn HostMemory>>,
    ) -> Result<Self> {
        let caps = Caps::query(instance, physical, queue_family);
        let memory = match host_memory {
            Some(memory) => Memory::of_host(memory),
            None => Memory::own(
                Allocator::new(&AllocatorCreateDesc {
                    instance: instance.clone(),
                    device: device.clone(),
                    physical_device: physical,
                    debug_settings: Default::default(),
                    buffer_device_address: false,
                    allocation_sizes: block_sizes(),
                })
                .map_err(|e| Error::Device(format!("{}: no memory allocator: {e}", info.name)))?,
            ),
        };
        Ok(Inner {
            loader: None,
            instance: instance.clone(),
            device,
            measured: None,
            physical_device: physical,
            queue_family,
            queue: vk::Queue::null(),
            info,
            caps,
            enabled_features: vk::PhysicalDeviceFeatures::default(),
            pipeline_cache: vk::PipelineCache::null(),
            cache_file: None,
            debug_utils: None,
            memory,
            compiling_ns: AtomicU64::new(0),
            budget: budget.unwrap_or(DEFAULT_BUDGET),
            graveyard: Mutex::new(Vec::new()),
            frame: AtomicU64::new(1),
            safe_frame: AtomicU64::new(0),
            next_id: AtomicU64::new(1),
            log: None,
            lost: AtomicBool::new(false),
            running: Mutex::new(()),
        })
    }

    fn log(&self, level: LogLevel, text: &str) {
        if let Some(log) = &self.log {
            log(level, text);
        }
    }

    fn wait_idle(&self) {
        if self.lost.load(Ordering::Relaxed) {
            return;
        }
        // SAFETY: the device is ours, and callers keep other threads off its queue.
        if let Err(result) = unsafe { self.device.device_wait_idle() } {
            self.log(LogLevel::Error, &vulkan("vkDeviceWaitIdle")(result).to_string());
        }
    }

    fn destroy(&self, garbage: Vec<(u64, Garbage)>) {
        for (_, item) in garbage {
            item.destroy(&self.device, &self.memory);
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        if self.loader.is_some() {
            self.wait_idle();
        }
        let garbage = std::mem::take(&mut *lock(&self.graveyard));
        self.destroy(garbage);
        self.memory.close();
        if let Some(loader) = self.loader.take() {
            if let Some(file) = self.cache_file.as_ref().filter(|_| !*self.lost.get_mut()) {
                file.save(&self.device, self.pipeline_cache);
            }
            // SAFETY: everything made from the device is gone: the last clone of the context is being dropped, and
            // every object holds one.
            unsafe {
                self.device.destroy_pipeline_cache(self.pipeline_cache, None);
                self.device.destroy_device(None);
            }
            loader.destroy();
        }
    }
}
