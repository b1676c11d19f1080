//! Preparation and frames: the bytes that the techniques give by themselves, and nothing but recording.

use super::*;
use common::Validated;
use host::calls;
use impasto::embed::Inputs;
use impasto::gpu::{Runner, Uploads};
use impasto::scene::{GuidePass, HostMotionParams, MotionPass};
use impasto::synthesis::quilt::QuiltStages;
use impasto::technique::aligned::{screen_displacements, AlignedTechnique, LevelSource, LevelVolume};
use impasto::technique::dependent::{Carry, DependentTechnique, ViewCoverage};
use impasto::technique::image::ImageTechnique;
use impasto::technique::object::ObjectTechnique;
use impasto::technique::{Paint, Show};

/// Frames 0, 1 and 2, then 7 after a cut, by the techniques themselves with a runner.
fn by_hand(runner: &mut Runner, mesh: &Mesh, method: &Method) -> Vec<Vec<u8>> {
    let context = runner.context().clone();
    let (mut uploads, stages, paint) = (Uploads::default(), QuiltStages::new(&context), paint());
    let paints = [Paint { texture: &paint.texture, trajectory: &paint.trajectory }];
    let guides = GuidePass::new(&context, &mut uploads, mesh, SIZE).expect("guides");
    let moments = [0, 1, 2, 7].map(|frame| moment(mesh, frame));
    let before = |number: usize| (number == 1 || number == 2).then(|| &moments[number - 1]);
    let mut frames = Vec::new();
    let mut draw = |runner: &mut Runner, image: &Image, record: &mut dyn FnMut(&mut Recorder<'_>, usize)| {
        for number in 0..moments.len() {
            let run = runner.run(|recorder| {
                record(recorder, number);
                Ok(())
            });
            run.expect("run");
            frames.push(runner.read_image(image).expect("a frame"));
        }
    };
    let upload = |runner: &mut Runner, uploads: &mut Uploads| {
        let run = runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        });
        run.expect("uploads");
    };
    match method {
        Method::Object { params, range } => {
            let object = ObjectTechnique::new(&context, &mut uploads, mesh, SIZE, &paints, &[0], params).expect("new");
            upload(runner, &mut uploads);
            draw(runner, object.frame(), &mut |recorder, number| {
                object.record(recorder, &moments[number], *range, Show::Painted).expect("a frame");
            });
        }
        Method::Image { params, carry } => {
            let mut image =
                ImageTechnique::new(&context, &mut uploads, &stages, &guides, &paints, &[0], params).expect("new");
            let motion = MotionPass::new(&context, &guides).expect("motion");
            if let Some(repair) = carry {
                image.carry(&context, &mut uploads, &guides, &paints, motion.motion(), repair).expect("carry");
            }
            upload(runner, &mut uploads);
            draw(runner, image.frame(), &mut |recorder, number| {
                guides.record(recorder, &moments[number]).expect("guides");
                if carry.is_none() {
                    return image.record(recorder, 9, 0);
                }
                motion.record(recorder, before(number), &moments[number]).expect("motion");
                match before(number) {
                    Some(_) => image.record_next(recorder, 9, number as u32),
                    None => image.record(recorder, 9, number as u32),
                }
            });
        }
        Method::Aligned { levels, frame, .. } => {
            let sources = [LevelSource::Strip(&paint.texture)];
            let volume = LevelVolume::new(&context, &mut uploads, &stages, &sources, levels).expect("levels");
            let colors = [&paint.trajectory];
            let aligned = AlignedTechnique::new(&context, &mut uploads, &guides, volume, &colors, &[0]).expect("new");
            upload(runner, &mut uploads);
            let run = runner.run(|recorder| {
                aligned.levels().parts(u64::MAX).iter().for_each(|p| aligned.levels().record_part(recorder, p, 3));
                Ok(())
            });
            run.expect("levels");
            let mut offset = [0.0; 2];
            draw(runner, aligned.frame(), &mut |recorder, number| {
                let ways = before(number).map(|before| screen_displacements(mesh, [before, &moments[number]], SIZE));
                offset = match ways {
                    None => [0.0; 2],
                    Some(ways) => {
                        let way = ways.expect("ways")[0];
                        [offset[0] - f64::from(way[0]), offset[1] - f64::from(way[1])]
                    }
                };
                guides.record(recorder, &moments[number]).expect("guides");
                aligned.record(recorder, frame, &[offset]).expect("a frame");
            });
        }
        Method::Dependent { views, view_px, lights, params } => {
            let covered = ViewCoverage::run(&context, runner, mesh, views, *view_px).expect("views");
            let dependent = DependentTechnique::new(
                &context,
                &mut uploads,
                &stages,
                mesh,
                lights,
                &covered,
                *view_px,
                SIZE,
                &paints,
                &[0],
                params,
            );
            let dependent = dependent.expect("new");
            upload(runner, &mut uploads);
            let run = runner.run(|recorder| {
                let parts = dependent.preparation_parts(u64::MAX);
                parts.iter().try_for_each(|part| dependent.record_preparation(recorder, part, 3))
            });
            run.expect("views");
            draw(runner, dependent.frame(), &mut |recorder, number| {
                let carry = if before(number).is_some() { Carry::Next } else { Carry::Cut };
                dependent.record_carry(recorder, &moments[number], carry);
                dependent.record_picture(recorder, &moments[number], Show::Painted).expect("a picture");
            });
        }
    }
    frames
}

/// The same frames by an effect.
fn by_effect(host: &Host, context: &Context, mesh: &Arc<Mesh>, method: &Method) -> Vec<Vec<u8>> {
    let mut effect = Effect::new(context, desc(mesh, method)).expect("an effect");
    assert!(effect.picture().is_none() && effect.depth().is_none());
    let mut frame = 0;
    prepare(host, context, &mut effect, &mut frame);
    let numbers = [0, 1, 2, 7];
    let frames = numbers.map(|number| {
        let moment = moment(mesh, number);
        let next = EffectFrame { reset: number == 7, seed: 9, ..EffectFrame::next(&moment) };
        picture(host, context, &mut effect, &next)
    });
    frames.into()
}

#[test]
fn an_effect_paints_what_its_technique_does() {
    let (host, gpu, mesh) = (Host::new(), Validated::new(), ball());
    let mut runner = gpu.runner();
    let context = borrow(&host);
    for (name, method) in methods() {
        let expected = by_hand(&mut runner, &mesh, &method);
        let frames = by_effect(&host, &context, &mesh, &method);
        for (number, (frame, expected)) in frames.iter().zip(&expected).enumerate() {
            assert!(expected.chunks(4).filter(|pixel| pixel[3] == 255).count() > 500, "{name}: nothing is painted");
            assert!(frame == expected, "{name}: frame {number} differs");
        }
        assert_ne!(expected[0], expected[3], "{name}: nothing moves");
    }
    drop(context);
    assert_silent(&host.destroy());
}

/// Nothing but commands, for a thousand frames of every technique and the pass that lays it over a host's picture.
#[test]
fn a_thousand_frames_only_record() {
    use impasto::embed::{Composite, HostDepth, Target, TargetColor};
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let color_use = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
    let color = host.image(vk::Format::R8G8B8A8_UNORM, color_use, SIZE);
    host.write_image(&color, &vec![0; (SIZE.0 * SIZE.1 * 4) as usize]);
    let target = Target { color: wrapped(&context, &color), depth: None };
    let mut frame = 0;
    for (name, method) in methods() {
        let mut effect = ready(&host, &context, desc(&mesh, &method), &mut frame);
        let composite =
            Composite::new(&effect, std::slice::from_ref(&target), TargetColor::ByFormat, false).expect("a composite");
        // What only the preparation needed goes here.
        frame += 2;
        context.advance(frame, frame - 1);
        let commands = host.begin();
        host.end(commands);
        for number in 0..1000 {
            let moment = moment(&mesh, number);
            let next = EffectFrame { reset: number % 100 == 0, ..EffectFrame::next(&moment) };
            host.begin_again(commands);
            calls::take();
            frame += 1;
            context.advance(frame, frame - 1);
            let mut recorder = recorder(&context, commands);
            effect.record(&mut recorder, &next).expect("a frame");
            let depth = HostDepth::of_camera(&moment.camera);
            composite.record(&mut recorder, &effect, 0, (0, 0), &depth).expect("a composite");
            recorder.hand_over(effect.picture().expect("a picture"), sampled());
            let called = calls::take();
            host.end(commands);
            host.submit(&[commands]);
            host.wait();
            let only = ["vkCmdDispatch", "vkCmdDrawIndexed"];
            assert!(called.keys().all(|call| only.contains(call)), "{name}, frame {number}: {called:?}");
        }
    }
    drop((target, context));
    host.destroy_image(color);
    assert_silent(&host.destroy());
}

fn sampled() -> ResourceState {
    ResourceState::from_host(
        vk::PipelineStageFlags::FRAGMENT_SHADER,
        vk::AccessFlags::SHADER_READ,
        vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
    )
}

#[test]
fn what_a_preparation_records_is_small() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    for (name, method) in methods() {
        let recorded = |piece, frame: &mut u64| {
            let mut effect = Effect::new(&context, EffectDesc { piece, ..desc(&mesh, &method) }).expect("an effect");
            let mut most = 0;
            while !effect.progress().ready {
                *frame += 1;
                context.advance(*frame, *frame - 1);
                calls::take();
                host.run(|commands| {
                    calls::take();
                    effect.prepare(&mut recorder(&context, commands)).expect("a preparation");
                    let called = calls::take();
                    let forbidden = |call: &&&str| !["vkCmdDispatch", "vkCmdDrawIndexed"].contains(call);
                    let others: Vec<_> = called.keys().filter(forbidden).collect();
                    assert!(others.is_empty(), "{name}: the host's thread calls {others:?}");
                    most = most.max(called.get("vkCmdDispatch").copied().unwrap_or_default());
                });
            }
            most
        };
        let (small, large) = (recorded(1, &mut frame), recorded(u64::MAX, &mut frame));
        let synthesises = matches!(method, Method::Aligned { .. } | Method::Dependent { .. });
        assert_eq!(small < large, synthesises, "{name}: {small} dispatches in a piece, {large} undivided");
    }
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn effects_may_go_at_any_time() {
    let (host, mesh) = (Host::new(), ball());
    for (name, method) in methods() {
        for pieces in [0, 1, 2, 5] {
            let context = borrow(&host);
            let mut effect = Effect::new(&context, desc(&mesh, &method)).expect("an effect");
            for frame in 1..=pieces {
                context.advance(frame, frame - 1);
                host.run(|commands| {
                    effect.prepare(&mut recorder(&context, commands)).expect("a preparation");
                });
            }
            drop(effect);
            context.advance(pieces + 2, pieces + 1);
            assert_eq!(context.allocated_bytes(), 0, "{name} after {pieces} pieces");
        }
    }
    assert_silent(&host.destroy());
}

#[test]
fn a_host_draws_guides_and_vectors_for_it() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut uploads = Uploads::default();
    let pass = GuidePass::new(&context, &mut uploads, &mesh, SIZE).expect("guides");
    host.run(|commands| uploads.record(&mut recorder(&context, commands)));
    let vectors_use = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let vectors = host.image(vk::Format::R32G32_SFLOAT, vectors_use, SIZE);
    // Nothing moves.
    host.write_image(&vectors, &vec![0; (SIZE.0 * SIZE.1 * 8) as usize]);
    let mut frame = 0;
    for (name, method) in methods() {
        let mut own = ready(&host, &context, desc(&mesh, &method), &mut frame);
        let lent = wrapped(&context, &vectors);
        let inputs = Inputs {
            guides: Some((&pass).into()),
            vectors: method.takes_vectors().then(|| (lent.clone(), HostMotionParams::default())),
        };
        let described = EffectDesc { inputs, ..desc(&mesh, &method) };
        if !method.takes_guides() {
            let error = Effect::new(&context, described).err().expect("guides that are not taken").to_string();
            assert!(error.contains("guides"), "{name}: {error}");
            continue;
        }
        let mut led = ready(&host, &context, described, &mut frame);
        if method.takes_vectors() {
            // SAFETY: nothing is recorded with it until it is put right.
            unsafe { lent.set_state(ResourceState::fresh()) };
            host.run(|commands| {
                let still = moment(&mesh, 4);
                let told = led.record(&mut recorder(&context, commands), &EffectFrame::next(&still));
                let told = told.expect_err("no content").to_string();
                assert!(told.contains("vectors") && told.contains("UNDEFINED"), "{told}");
            });
            // SAFETY: so the host has left it.
            unsafe { lent.set_state(written()) };
        }
        for number in 0..3 {
            let still = moment(&mesh, 4);
            let next = EffectFrame::next(&still);
            let expected = picture(&host, &context, &mut own, &next);
            host.run(|commands| pass.record(&mut recorder(&context, commands), &still).expect("guides"));
            assert!(picture(&host, &context, &mut led, &next) == expected, "{name}: frame {number}");
        }
    }
    drop((pass, uploads, context));
    host.destroy_image(vectors);
    assert_silent(&host.destroy());
}

/// What counts is how camera and objects lie to each other, then and now.
#[test]
fn the_origin_may_be_shifted_between_frames() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let still = Moment { poses: Vec::new(), ..moment(&mesh, 0) };
    let way = Vec3::new(64.0, -32.0, 128.0);
    let camera = &still.camera;
    let seen = Camera::look_at(camera.eye() + way, camera.target() + way, Some(camera.up()), camera.fov_y_deg());
    let seen = seen.expect("a camera").with_planes(camera.near(), camera.far()).expect("planes");
    let pose = Pose::new(0.0, Vec3::Y, Vec3::ZERO, way).expect("a pose");
    let shifted = Moment { camera: seen, poses: vec![pose], ..still.clone() };
    let nudge = Pose::new(0.0, Vec3::Y, Vec3::ZERO, Vec3::X * 0.03).expect("a pose");
    let nudged = Moment { poses: vec![nudge], ..still.clone() };
    let (_, carried) = methods().into_iter().find(|(name, _)| *name == "image, carried").expect("it is there");
    let mut changed = |second: &Moment| {
        let mut effect = ready(&host, &context, desc(&mesh, &carried), &mut frame);
        let frames = [&still, second].map(|moment| picture(&host, &context, &mut effect, &EffectFrame::next(moment)));
        frames[0].chunks(4).zip(frames[1].chunks(4)).filter(|(a, b)| a != b).count()
    };
    let (by_shift, by_nudge) = (changed(&shifted), changed(&nudged));
    assert!(by_shift < 100 && by_nudge > 1000, "{by_shift} pixels change by a shift, {by_nudge} by a nudge");
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn contexts_of_several_hosts_run_side_by_side() {
    let mesh = ball();
    let paint = |method: Method| {
        let mesh = mesh.clone();
        move || {
            let host = Host::new();
            let context = borrow(&host);
            let frames = by_effect(&host, &context, &mesh, &method);
            drop(context);
            assert_silent(&host.destroy());
            frames
        }
    };
    for (name, method) in methods().into_iter().skip(2) {
        let side_by_side = [(); 2].map(|()| std::thread::spawn(paint(method.clone())));
        let frames = side_by_side.map(|thread| thread.join().expect("no panic"));
        assert!(frames[0] == frames[1], "{name}: two contexts differ");
    }
    // Two contexts on one device, in turn.
    let host = Host::new();
    let contexts = [borrow(&host), borrow(&host)];
    let (_, method) = methods().into_iter().last().expect("a method");
    let frames = contexts.each_ref().map(|context| by_effect(&host, context, &mesh, &method));
    assert!(frames[0] == frames[1]);
    drop(contexts);
    assert_silent(&host.destroy());
}

#[test]
fn what_is_wrong_is_told_before_anything_is_prepared() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let [(_, object), (_, image), _, (_, aligned), (_, dependent)] = methods();
    let refused = |desc: EffectDesc, word: &str| {
        let error = Effect::new(&context, desc).err().expect(word).to_string();
        assert!(error.contains(word), "{error}");
    };
    refused(EffectDesc { paints: Vec::new(), ..desc(&mesh, &object) }, "paints");
    refused(EffectDesc { paint_of_object: vec![1], ..desc(&mesh, &object) }, "paint of object");
    refused(EffectDesc { size_px: (0, 4), ..desc(&mesh, &object) }, "0x4");
    refused(EffectDesc { size_px: (1 << 20, 1 << 20), ..desc(&mesh, &object) }, "1048576x1048576");
    refused(EffectDesc { size_px: (404, 4), ..desc(&mesh, &object) }, "404x4");
    refused(EffectDesc { piece: 0, ..desc(&mesh, &aligned) }, "piece");
    let tileable = QuiltParams { tileable: true, ..QUILT };
    let Method::Dependent { views, view_px, lights, .. } = dependent else { panic!("it is the last") };
    let params = DependentParams { quilt: tileable, ..DependentParams::default() };
    refused(desc(&mesh, &Method::Dependent { views, view_px, lights, params }), "tileable");
    let block = QuiltParams { block_px: 128, ..QUILT };
    let params = ImageParams { quilt: block, ..ImageParams::default() };
    refused(desc(&mesh, &Method::Image { params, carry: None }), "block");

    let mut effect = Effect::new(&context, desc(&mesh, &image)).expect("an effect");
    let still = moment(&mesh, 0);
    host.run(|commands| {
        let early = effect.record(&mut recorder(&context, commands), &EffectFrame::next(&still));
        let early = early.expect_err("too early");
        assert!(matches!(early, impasto::Error::NotReady(_)) && early.to_string().contains("not ready"), "{early}");
    });
    drop(effect);
    // What only shows on the way is told by `prepare`: no budget for it.
    let mut lent = host.lent();
    lent.memory_budget = Some(100_000);
    // SAFETY: as in `borrow`.
    let poor = unsafe { Context::from_host(lent) }.expect("a context");
    let mut effect = Effect::new(&poor, desc(&mesh, &image)).expect("an effect");
    let mut told = Vec::new();
    while told.len() < 2 {
        host.run(|commands| told.extend(effect.prepare(&mut recorder(&poor, commands)).err()));
    }
    assert!(matches!(told[0], impasto::Error::Memory { .. }), "{}", told[0]);
    assert!(told[1].to_string().contains(&told[0].to_string()), "{}", told[1]);
    drop((effect, poor, context));
    assert_silent(&host.destroy());
}

/// A part of a picture is the picture of an effect that is no larger.
#[test]
fn a_host_may_change_its_resolution_from_frame_to_frame() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let part = (61, 47);
    for (name, method) in methods() {
        let mut whole = ready(&host, &context, desc(&mesh, &method), &mut frame);
        let mut told = |size_px| {
            let still = moment(&mesh, 0);
            let next = EffectFrame { size_px: Some(size_px), ..EffectFrame::next(&still) };
            let mut result = Ok(());
            host.run(|commands| result = whole.record(&mut recorder(&context, commands), &next));
            result.expect_err("a size that is none").to_string()
        };
        for stray in [(0, 10), (10, 0), (SIZE.0 + 1, 10), (10, SIZE.1 + 1)] {
            assert!(told(stray).contains("90x70"), "{name}: {}", told(stray));
        }
        if matches!(method, Method::Image { .. }) {
            assert!(told(part).contains("must be 90x70"), "{name}: {}", told(part));
            continue;
        }
        let small = EffectDesc { size_px: part, ..desc(&mesh, &method) };
        let mut small = ready(&host, &context, small, &mut frame);
        for number in 0..3 {
            let now = moment(&mesh, number);
            let next = EffectFrame { reset: number == 0, ..EffectFrame::next(&now) };
            let of_whole = EffectFrame { size_px: Some(part), ..next };
            let drawn = picture(&host, &context, &mut whole, &of_whole);
            host.run(|commands| small.record(&mut recorder(&context, commands), &next).expect("a frame"));
            let own = small.picture().expect("a picture");
            let expected = host.read_image(own.handle(), own.layout(), part);
            let row =
                |bytes: &[u8], width: u32, y: u32| bytes[(4 * width * y) as usize..][..4 * part.0 as usize].to_vec();
            assert!(expected.chunks(4).filter(|pixel| pixel[3] == 255).count() > 500, "{name}: nothing is painted");
            for y in 0..part.1 {
                assert!(row(&drawn, SIZE.0, y) == row(&expected, part.0, y), "{name}: frame {number}, row {y}");
            }
        }
        // And back to all of it.
        let now = moment(&mesh, 3);
        let reset = EffectFrame { reset: true, ..EffectFrame::next(&now) };
        let all = picture(&host, &context, &mut whole, &reset);
        assert!(all.chunks(4).filter(|pixel| pixel[3] == 255).count() > 1500, "{name}: less than all");
    }
    drop(context);
    assert_silent(&host.destroy());
}
