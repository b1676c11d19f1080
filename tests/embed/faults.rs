//! What goes wrong at the border: a device that is lost, and memory that runs out on the preparing thread.

use super::*;
use host::memory::Pieces;
use impasto::embed::{Composite, HostDepth, Target, TargetColor};
use impasto::gpu::HostDevice;
use impasto::Error;

/// Prepares until it is ready, or what went wrong.
fn try_to_prepare(host: &Host, context: &Context, effect: &mut Effect, frame: &mut u64) -> impasto::Result<()> {
    let mut result = Ok(());
    while result.is_ok() && !effect.progress().ready {
        *frame += 1;
        context.advance(*frame, *frame - 1);
        host.run(|commands| result = effect.prepare(&mut recorder(context, commands)).map(drop));
    }
    result
}

#[test]
fn memory_may_run_out_at_every_allocation() {
    for (name, method) in methods() {
        let (host, mesh) = (Host::new(), ball());
        let memory = Arc::new(Pieces::new(&host));
        let lent = HostDevice { memory: Some(memory.clone()), ..host.lent() };
        // SAFETY: as in `borrow`.
        let context = unsafe { Context::from_host(lent) }.expect("a context");
        let mut frame = 0;
        for pieces in 0.. {
            memory.limit(Some(pieces));
            let mut effect = Effect::new(&context, desc(&mesh, &method)).expect("an effect");
            let result = try_to_prepare(&host, &context, &mut effect, &mut frame);
            if let Err(error) = &result {
                let short = matches!(error, Error::Vulkan { call: "HostMemory::allocate", result }
                    if *result == vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
                assert!(short, "{name}, {pieces} pieces: {error}");
                let still = moment(&mesh, 0);
                host.run(|commands| {
                    assert!(effect.record(&mut recorder(&context, commands), &EffectFrame::next(&still)).is_err());
                });
            }
            drop(effect);
            frame += 2;
            context.advance(frame, frame - 1);
            assert_eq!(context.allocated_bytes(), 0, "{name}, {pieces} pieces");
            if result.is_ok() {
                assert!(pieces > 5, "{name} takes hardly any memory");
                break;
            }
        }
        drop(context);
        assert_eq!(memory.now(), (0, 0), "{name} keeps memory");
        drop(memory);
        assert_silent(&host.destroy());
    }
}

#[test]
fn a_device_may_be_lost_at_any_time() {
    let (host, mesh) = (Host::new(), ball());
    let use_of = vk::ImageUsageFlags::COLOR_ATTACHMENT;
    let color = host.image(vk::Format::R8G8B8A8_UNORM, use_of, SIZE);
    for (name, method) in methods() {
        for ready in [false, true] {
            let context = borrow(&host);
            let mut effect = Effect::new(&context, desc(&mesh, &method)).expect("an effect");
            let target = Target { color: wrapped(&context, &color), depth: None };
            let composite = ready.then(|| {
                prepare(&host, &context, &mut effect, &mut 0);
                Composite::new(&effect, std::slice::from_ref(&target), TargetColor::Stored, false).expect("a composite")
            });
            context.device_lost();
            let still = moment(&mesh, 0);
            let lost = |result: impasto::Result<()>| assert!(matches!(result, Err(Error::DeviceLost)), "{name}");
            let commands = host.begin();
            let mut recorder = recorder(&context, commands);
            lost(effect.prepare(&mut recorder).map(drop));
            lost(effect.record(&mut recorder, &EffectFrame::next(&still)));
            if let Some(composite) = &composite {
                lost(composite.record(&mut recorder, &effect, 0, (0, 0), &HostDepth::of_camera(&still.camera)));
                lost(Composite::new(&effect, std::slice::from_ref(&target), TargetColor::Stored, false).map(drop));
            }
            host.end(commands);
            lost(Effect::memory(&context, &desc(&mesh, &method)).map(drop));
            drop((effect, composite));
            assert_eq!(context.allocated_bytes(), 0, "{name}");
        }
    }
    host.destroy_image(color);
    assert_silent(&host.destroy());
}
