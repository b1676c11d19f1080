//! Every Vulkan call of a preparation that can fail does so in turn, as when memory runs out: an error comes back, nothing
//! is left over, and once there is memory again all is as it should be.

mod common;
mod host;
mod prepared;

use ash::vk;
use host::memory::Pieces;
use host::{calls, Host};
use impasto::gpu::{Context, HostDevice, LogCallback};
use impasto::Error;
use prepared::{Prepare, Scene};
use std::sync::{Arc, Mutex};

/// What the library calls to make something, and how that fails where memory is short.
const MAKING: [(&str, vk::Result); 18] = {
    use vk::Result as R;
    [
        ("vkAllocateMemory", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkMapMemory", R::ERROR_MEMORY_MAP_FAILED),
        ("vkBindBufferMemory", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkBindImageMemory", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkCreateBuffer", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkCreateImage", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkCreateImageView", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreateSampler", R::ERROR_TOO_MANY_OBJECTS),
        ("vkCreateShaderModule", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreatePipelineLayout", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreateComputePipelines", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkCreateGraphicsPipelines", R::ERROR_OUT_OF_DEVICE_MEMORY),
        ("vkCreateRenderPass", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreateFramebuffer", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreateDescriptorSetLayout", R::ERROR_OUT_OF_HOST_MEMORY),
        ("vkCreateDescriptorPool", R::ERROR_FRAGMENTATION_EXT),
        ("vkAllocateDescriptorSets", R::ERROR_OUT_OF_POOL_MEMORY),
        ("vkCreateQueryPool", R::ERROR_OUT_OF_HOST_MEMORY),
    ]
};

/// After which of these a picture is drawn, to show that all is well again; the others would only take longer.
const DRAWN_AFTER: [&str; 2] = ["vkAllocateMemory", "vkAllocateDescriptorSets"];

/// A context on the host's device.
fn borrow(lent: HostDevice) -> Context {
    // SAFETY: the tests drop the context before the host's device, when all work is done.
    unsafe { Context::from_host(lent) }.expect("a context")
}

/// Lets each function fail from its first, second, ... call on, until the preparation calls it no more often than that.
fn every_call_of_it_may_fail(name: &'static str, prepare: Prepare) {
    let host = Host::new();
    let scene = Scene::new();
    let context = borrow(host.lent());
    let expected = prepare(&scene, &context, &host).expect(name).draw(&context, &host);
    drop(context);
    let mut points = 0;
    for (call, with) in MAKING {
        // A context of its own, since memory is kept in blocks.
        let context = borrow(host.lent());
        for after in 0_u32.. {
            calls::fail(call, after, with);
            let mut prepared = prepare(&scene, &context, &host);
            let failed = calls::heal();
            let succeeded = match &mut prepared {
                Ok(prepared) => {
                    let drawn = DRAWN_AFTER.contains(&call);
                    assert!(
                        !drawn || prepared.draw(&context, &host) == expected,
                        "{name} with {call}: another picture"
                    );
                    true
                }
                Err(Error::Vulkan { call: named, result }) => {
                    assert_eq!((*named, *result), (call, with), "{name}");
                    false
                }
                Err(other) => panic!("{name} with {call}: {other:?}"),
            };
            assert_eq!(succeeded, failed == 0, "{name} with {call} {after}: an error got lost, or came from nowhere");
            // Nothing is in flight: the host has waited for all that was recorded.
            drop(prepared);
            context.advance(2 + u64::from(after), 1 + u64::from(after));
            assert_eq!(context.allocated_bytes(), 0, "{name} with {call} {after} leaves memory behind");
            assert_eq!(host.take_messages(), [""; 0], "{name} with {call} {after}");
            if succeeded {
                break;
            }
            points += 1;
        }
    }
    eprintln!("{name}: {points} calls");
    assert!(points > 0);
    assert_eq!(host.destroy(), [""; 0]);
}

macro_rules! each {
    ($($test:ident: $place:literal;)*) => { $(
        #[test]
        fn $test() {
            let (name, prepare) = Scene::all()[$place];
            every_call_of_it_may_fail(name, prepare);
        }
    )* };
}

each! {
    every_call_of_a_timer_may_fail: 0;
    every_call_of_a_quilting_may_fail: 1;
    every_call_of_guides_and_motion_may_fail: 2;
    every_call_of_object_based_painting_may_fail: 3;
    every_call_of_image_based_painting_may_fail: 4;
    every_call_of_carried_painting_may_fail: 5;
    every_call_of_view_aligned_projection_may_fail: 6;
    every_call_of_the_views_may_fail: 7;
    every_call_of_view_dependent_interpolation_may_fail: 8;
}

/// All memory is the host's, where it wants that, and comes back to it.
#[test]
fn a_host_may_bring_its_own_memory() {
    let host = Host::new();
    let scene = Scene::new();
    for (name, prepare) in Scene::all() {
        let context = borrow(host.lent());
        let expected = prepare(&scene, &context, &host).expect(name).draw(&context, &host);
        drop(context);

        let pieces = Arc::new(Pieces::new(&host));
        let messages = Arc::new(Mutex::new(Vec::new()));
        let sink = messages.clone();
        let log: LogCallback = Arc::new(move |_, text| sink.lock().expect("no panic").push(text.to_owned()));
        let lent = HostDevice { memory: Some(pieces.clone()), log: Some(log), ..host.lent() };
        let context = borrow(lent);
        calls::take();
        let mut prepared = prepare(&scene, &context, &host).expect(name);
        let called = calls::take();
        for call in ["vkAllocateMemory", "vkMapMemory", "vkFreeMemory"] {
            assert!(!called.contains_key(call), "{name} calls {call}");
        }
        assert_eq!(pieces.now().1, context.allocated_bytes(), "{name}");
        assert!(prepared.draw(&context, &host) == expected, "{name}: another picture");
        drop(prepared);
        context.advance(2, 1);
        assert_eq!((pieces.now(), context.allocated_bytes()), ((0, 0), 0), "{name}: something was not given back");

        // And it may have no more of it.
        let needed: u32 = pieces.counts().values().sum();
        for left in 0..needed {
            pieces.limit(Some(left));
            match prepare(&scene, &context, &host).map(|_| ()) {
                Err(Error::Vulkan { call: "HostMemory::allocate", result: vk::Result::ERROR_OUT_OF_DEVICE_MEMORY }) => {
                }
                other => panic!("{name}, {left} pieces: {other:?}"),
            }
            context.advance(u64::from(left) + 3, u64::from(left) + 2);
            assert_eq!(pieces.now(), (0, 0), "{name}, {left} pieces");
            // The error does not tell what for, and so the log does.
            let said = std::mem::take(&mut *messages.lock().expect("no panic"));
            assert!(said.len() == 1 && said[0].contains("bytes of GPU memory could not be had"), "{said:?}");
        }
        drop(context);
    }
    assert_eq!(host.destroy(), [""; 0]);
}
