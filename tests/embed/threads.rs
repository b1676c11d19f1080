//! Effects that prepare on threads of their own while their host records, and what frames are called.

use super::*;
use impasto::embed::{Composite, HostDepth, Inputs, Target, TargetColor};
use impasto::gpu::{Buffer, BufferKind, Uploads};
use impasto::scene::GuidePass;

/// A command buffer of which two are in flight.
struct Slot {
    commands: vk::CommandBuffer,
    fence: vk::Fence,
}

impl Slot {
    fn new(host: &Host) -> Self {
        let commands = host.begin();
        host.end(commands);
        let info = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: a plain creation on a live device.
        let fence = unsafe { host.device.create_fence(&info, None) }.expect("a fence");
        Slot { commands, fence }
    }

    fn wait(&self, host: &Host) {
        // SAFETY: the fence is live.
        unsafe { host.device.wait_for_fences(&[self.fence], true, 60_000_000_000) }.expect("wait");
    }

    fn submit(&self, host: &Host) {
        let commands = [self.commands];
        let info = [vk::SubmitInfo::default().command_buffers(&commands)];
        // SAFETY: the commands are ended, and the fence was waited for.
        unsafe {
            host.device.reset_fences(&[self.fence]).expect("reset");
            host.device.queue_submit(host.queue, &info, self.fence).expect("submit");
        }
    }
}

/// Several effects prepare at once, come, paint a frame and go, while another paints every frame, two of which are in
/// flight. Validation would tell of anything that is destroyed too early, or touched by two threads at a time.
#[test]
fn effects_come_and_go_while_frames_are_in_flight() {
    const AT_ONCE: usize = 3;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let all = methods();
    let (_, aligned) = &all[3];
    let mut frame = 0;
    let mut painting = ready(&host, &context, desc(&mesh, aligned), &mut frame);
    let first = moment(&mesh, 0);
    let expected = picture(&host, &context, &mut painting, &EffectFrame::next(&first));

    let slots = [Slot::new(&host), Slot::new(&host)];
    let mut coming: Vec<(usize, Effect)> = Vec::new();
    // How many painted, and how many were given up on the way.
    let (mut started, mut painted, mut given_up) = (0, [0; 5], 0);
    while painted.contains(&0) || given_up < 3 {
        frame += 1;
        let slot = &slots[frame as usize % 2];
        slot.wait(&host);
        context.advance(frame, frame - 2);
        while coming.len() < AT_ONCE {
            // One at a time of the last, which takes longest.
            let number = started % if coming.iter().any(|(number, _)| *number == 4) { 4 } else { 5 };
            let desc = EffectDesc { piece: 100_000_000, ..desc(&mesh, &all[number].1) };
            coming.push((number, Effect::new(&context, desc).expect("an effect")));
            started += 1;
        }
        host.begin_again(slot.commands);
        let mut recorder = recorder(&context, slot.commands);
        painting.record(&mut recorder, &EffectFrame::next(&moment(&mesh, frame as u32))).expect("a frame");
        coming.retain_mut(|(number, effect)| {
            let ready = effect.prepare(&mut recorder).expect("a preparation").ready;
            if ready {
                effect.record(&mut recorder, &EffectFrame::next(&first)).expect("a frame");
                painted[*number] += 1;
            }
            // Recorded a moment ago, and dropped.
            !ready
        });
        if frame % 3 == 0 && !coming.is_empty() && painted[coming[0].0] > 0 {
            coming.remove(0);
            given_up += 1;
        }
        host.end(slot.commands);
        slot.submit(&host);
        assert!(frame < 100_000, "it does not end: {painted:?}");
    }
    slots.iter().for_each(|slot| slot.wait(&host));
    drop(coming);
    let again = EffectFrame { reset: true, ..EffectFrame::next(&first) };
    assert!(
        picture(&host, &context, &mut painting, &again) == expected,
        "the effect beside them paints another picture"
    );
    drop(painting);
    context.advance(frame + 2, frame + 1);
    assert_eq!(context.allocated_bytes(), 0);
    // SAFETY: nothing is in flight.
    slots.iter().for_each(|slot| unsafe { host.device.destroy_fence(slot.fence, None) });
    drop(context);
    assert_silent(&host.destroy());
}

/// Whatever numbers a host gives its frames, what belongs to the one that is recorded outlives it.
#[test]
fn frames_may_be_called_by_any_numbers() {
    let host = Host::new();
    let dropped = |context: &Context| {
        drop(Buffer::new(context, "dropped", BufferKind::Storage, 1000).expect("a buffer"));
    };
    // From 0, with two in flight, as by `current.saturating_sub(2)`: frame 0 has run when 2 begins, and may be told so
    // from 3 on.
    let context = borrow(&host);
    for (current, safe, left) in [(0, 0, true), (1, 0, true), (2, 0, true), (3, 1, false)] {
        context.advance(current, safe);
        if current == 0 {
            dropped(&context);
        }
        assert_eq!(context.allocated_bytes() > 0, left, "frame {current}");
    }
    // A host that waits for each frame, and says so at its end.
    context.advance(4, 4);
    dropped(&context);
    context.advance(5, 4);
    assert!(context.allocated_bytes() > 0, "it was dropped after frame 4");
    context.advance(5, 5);
    assert_eq!(context.allocated_bytes(), 0);
    // Numbers that leave some out, and a safe one that is beyond them all: all that was recorded.
    context.advance(1000, 5);
    dropped(&context);
    context.advance(2000, 999);
    assert!(context.allocated_bytes() > 0);
    context.advance(2000, u64::MAX);
    assert_eq!(context.allocated_bytes(), 0);
    dropped(&context);
    context.advance(2001, 1999);
    assert!(context.allocated_bytes() > 0);
    context.advance(2002, 2001);
    assert_eq!(context.allocated_bytes(), 0);
    drop(context);

    // A preparation that waits for the GPU goes on with all of them, and not before the GPU has run.
    let mesh = ball();
    let (_, dependent) = methods().into_iter().last().expect("a method");
    for (first, late) in [(0, 0), (0, 2), (1 << 40, 1)] {
        let context = borrow(&host);
        let mut effect = Effect::new(&context, desc(&mesh, &dependent)).expect("an effect");
        let mut current: u64 = first;
        // Up to where it has looked through its views.
        while effect.progress().done < 0.1 {
            context.advance(current, current.saturating_sub(late));
            host.run(|commands| {
                effect.prepare(&mut recorder(&context, commands)).expect("a preparation");
            });
            current += 1;
            assert!(current < first + 100_000, "the preparation does not end");
        }
    }
    assert_silent(&host.destroy());
}

#[test]
fn what_is_of_another_context_is_refused() {
    let (host, mesh) = (Host::new(), ball());
    let contexts = [borrow(&host), borrow(&host)];
    let [(_, object), (_, image), ..] = methods();
    let still = moment(&mesh, 0);
    let told = |error: Option<impasto::Error>, word: &str| {
        let error = error.expect(word).to_string();
        assert!(error.contains(word), "{error}");
    };
    let mut frame = 0;
    let [mut own, mut other] =
        contexts.each_ref().map(|context| ready(&host, context, desc(&mesh, &object), &mut frame));
    let color = host.image(vk::Format::R8G8B8A8_UNORM, vk::ImageUsageFlags::COLOR_ATTACHMENT, SIZE);
    let [target, stray] = contexts.each_ref().map(|context| Target { color: wrapped(context, &color), depth: None });
    let new = |effect: &Effect, target: &Target| {
        Composite::new(effect, std::slice::from_ref(target), TargetColor::Stored, false)
    };
    told(new(&own, &stray).err(), "another context");
    let composite = new(&own, &target).expect("a composite");
    let depth = HostDepth::of_camera(&still.camera);
    host.run(|commands| {
        let mut recorders = contexts.each_ref().map(|context| recorder(context, commands));
        let next = EffectFrame::next(&still);
        told(own.prepare(&mut recorders[1]).err(), "another context");
        told(own.record(&mut recorders[1], &next).err(), "another context");
        own.record(&mut recorders[0], &next).expect("a frame");
        other.record(&mut recorders[1], &next).expect("a frame");
        told(composite.record(&mut recorders[1], &own, 0, (0, 0), &depth).err(), "another context");
        told(composite.record(&mut recorders[0], &other, 0, (0, 0), &depth).err(), "made for");
    });
    // Guides of another context, and a depth that is read and drawn to.
    let [guides, strays] = contexts.each_ref().map(|context| {
        let mut uploads = Uploads::default();
        let pass = GuidePass::new(context, &mut uploads, &mesh, SIZE).expect("guides");
        host.run(|commands| uploads.record(&mut recorder(context, commands)));
        pass
    });
    let led = |guides: &GuidePass| {
        let inputs = Inputs { guides: Some(guides.into()), vectors: None };
        Effect::new(&contexts[0], EffectDesc { inputs, ..desc(&mesh, &image) })
    };
    told(led(&strays).err(), "another context");
    let mut led = led(&guides).expect("an effect");
    prepare(&host, &contexts[0], &mut led, &mut frame);
    let twice = Target { depth: Some(guides.depth().clone()), ..target.clone() };
    told(new(&led, &twice).err(), "reads");
    drop((own, other, led, composite, target, stray, twice, guides, strays, contexts));
    host.destroy_image(color);
    assert_silent(&host.destroy());
}
