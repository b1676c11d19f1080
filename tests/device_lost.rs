//! A device that is lost: nothing is asked of it any more, and all that was on it can be dropped.

mod common;
mod host;
mod prepared;

use ash::vk;
use common::Validated;
use host::{calls, Host};
use impasto::gpu::{Buffer, BufferKind, Context, ContextOptions, HostDevice, LogCallback, LogLevel, Runner};
use impasto::Error;
use prepared::Scene;
use std::sync::{Arc, Mutex};

type Messages = Arc<Mutex<Vec<(LogLevel, String)>>>;

/// A context on the host's device that logs.
fn borrow(host: &Host) -> (Context, Messages) {
    let messages = Messages::default();
    let sink = messages.clone();
    let log: LogCallback = Arc::new(move |level, text| sink.lock().expect("no panic").push((level, text.to_owned())));
    let lent = HostDevice { log: Some(log), ..host.lent() };
    // SAFETY: the tests drop the context before the host's device, when all work is done.
    (unsafe { Context::from_host(lent) }.expect("a context"), messages)
}

fn take(messages: &Messages) -> Vec<(LogLevel, String)> {
    std::mem::take(&mut *messages.lock().expect("no panic"))
}

fn is_lost<T>(result: impasto::Result<T>) -> bool {
    matches!(result, Err(Error::DeviceLost))
}

#[test]
fn what_a_host_reports_lost_is_dropped_without_a_wait_or_a_leak() {
    let host = Host::new();
    let scene = Scene::new();
    let (context, messages) = borrow(&host);
    let prepared: Vec<_> = Scene::all().map(|(name, prepare)| prepare(&scene, &context, &host).expect(name)).into();
    // In the graveyard when it happens: everything that the preparation only needed for a while.
    assert!(context.allocated_bytes() > 0 && !context.is_device_lost());
    calls::take();
    context.device_lost();
    context.device_lost();
    assert!(context.is_device_lost());
    let freed = calls::take();
    assert!(freed.contains_key("vkDestroyBuffer"), "the graveyard is kept: {freed:?}");
    assert!(freed.keys().all(|name| name.starts_with("vkDestroy") || *name == "vkFreeMemory"), "{freed:?}");
    let said = take(&messages);
    assert!(said.len() == 1 && said[0].0 == LogLevel::Error && said[0].1.contains("is lost"), "{said:?}");

    // Nothing is asked of Vulkan any more.
    for (name, prepare) in Scene::all() {
        assert!(is_lost(prepare(&scene, &context, &host)), "{name}");
    }
    assert!(is_lost(Buffer::new(&context, "late", BufferKind::Storage, 64)));
    assert_eq!(calls::take().into_keys().collect::<Vec<_>>(), [""; 0]);

    let before = context.allocated_bytes();
    drop(prepared);
    assert!(before > 0 && context.allocated_bytes() == 0, "something waits for a frame that never ends");
    let freed = calls::take();
    assert!(freed.contains_key("vkDestroyImage") && freed.contains_key("vkDestroyPipeline"), "{freed:?}");
    drop(context);
    let freed = calls::take();
    assert!(freed.keys().all(|name| *name == "vkFreeMemory"), "{freed:?}");
    assert_eq!(take(&messages), []);
    assert_eq!(host.destroy(), [""; 0]);
}

#[test]
fn a_call_that_answers_so_is_enough() {
    let host = Host::new();
    let scene = Scene::new();
    for (what, prepare, call) in [
        ("buffer", Scene::all()[1].1, "vkCreateBuffer"),
        ("pipeline", Scene::all()[1].1, "vkCreateComputePipelines"),
        ("render pass", Scene::all()[2].1, "vkCreateRenderPass"),
        ("pipeline", Scene::all()[2].1, "vkCreateGraphicsPipelines"),
        ("query pool", Scene::all()[0].1, "vkCreateQueryPool"),
    ] {
        let (context, messages) = borrow(&host);
        calls::fail(call, 0, vk::Result::ERROR_DEVICE_LOST);
        assert!(is_lost(prepare(&scene, &context, &host)), "{what}");
        assert_eq!(calls::heal(), 1, "{what}");
        assert!(context.is_device_lost());
        assert_eq!((take(&messages).len(), context.allocated_bytes()), (1, 0), "{what}");
        assert!(is_lost(prepare(&scene, &context, &host)), "{what}");
    }
    assert_eq!(host.destroy(), [""; 0]);
}

/// On a device of our own: a runner says so, and the destructors do not wait.
#[test]
fn a_runner_says_so_too() {
    let messages = Messages::default();
    let sink = messages.clone();
    let log: LogCallback = Arc::new(move |level, text| sink.lock().expect("no panic").push((level, text.to_owned())));
    let folder = tempfile::tempdir().expect("a folder");
    let context = Context::new(&ContextOptions {
        validation: true,
        log: Some(log),
        pipeline_cache_dir: Some(folder.path().to_owned()),
        ..Default::default()
    });
    let context = context.expect("a context");
    let mut runner = Runner::new(&context).expect("a runner");
    let kept = Buffer::new(&context, "kept", BufferKind::Storage, 64).expect("a buffer");
    let ran = runner.run(|recorder| {
        recorder.context().device_lost();
        Ok(())
    });
    assert!(is_lost(ran));
    assert!(is_lost(runner.run(|_| -> impasto::Result<()> { panic!("nothing is recorded") })));
    assert!(is_lost(runner.read_buffer(&kept)) && is_lost(Runner::new(&context)));
    drop((runner, kept));
    assert_eq!(context.allocated_bytes(), 0);
    drop(context);
    let said = take(&messages);
    assert!(said.len() == 1 && said[0].1.contains("is lost"), "{said:?}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 0, "a lost device's cache was written");
    // The next one is as good as ever.
    Validated::new().runner().run(|_| Ok(())).expect("run");
}
