//! The pass that lays a picture over a host's, against a plain loop over pixels.

use super::*;
use impasto::embed::{Composite, HostDepth, Target, TargetColor};

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytemuck::pod_collect_to_vec(bytes)
}

/// IEC 61966-2-1, from stored values to light.
fn light(stored: f64) -> f64 {
    if stored <= 0.04045 {
        stored / 12.92
    } else {
        ((stored + 0.055) / 1.055).powf(2.4)
    }
}

/// And back.
fn stored(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// A wall in the host's depth that is nearer than the ball on the left and farther on the right.
fn wall(depth: &HostDepth, camera: &Camera) -> Vec<f32> {
    let (near, far) = (camera.near(), camera.far());
    let at = |i: u32| {
        let z = if i % SIZE.0 < SIZE.0 / 2 { near * 1.001 } else { far * 0.999 };
        depth.a + depth.b / z
    };
    (0..SIZE.0 * SIZE.1).map(at).collect()
}

#[test]
fn a_picture_lies_over_the_hosts_behind_what_is_nearer() {
    use glam::camera::rh::proj::directx;
    use vk::Format as F;
    use vk::ImageUsageFlags as U;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let (_, object) = methods().into_iter().next().expect("a method");
    let mut effect = Effect::new(&context, desc(&mesh, &object)).expect("an effect");
    prepare(&host, &context, &mut effect, &mut frame);
    let moment = moment(&mesh, 0);
    let painted = picture(&host, &context, &mut effect, &EffectFrame::next(&moment));
    let camera = &moment.camera;
    let infinite = directx::perspective_infinite_reverse(camera.fov_y_deg().to_radians(), 9.0 / 7.0, 0.01);
    let ways = [HostDepth::of_camera(camera), HostDepth::from_projection(&infinite).expect("a perspective")];
    // Stored as it is; in another order; as light.
    let formats = [(F::R8G8B8A8_UNORM, 0.0), (F::B8G8R8A8_UNORM, 0.0), (F::R8G8B8A8_SRGB, 1.0)];
    let before = noise(SIZE.0, SIZE.1, 17).into_flattened();
    let mut hidden = 0;
    for depth in ways {
        for (format, tolerance) in formats {
            for with_depth in [true, false] {
                let color = host.image(format, U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST, SIZE);
                let usage = U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST;
                let buffer = host.image(F::D32_SFLOAT, usage, SIZE);
                host.write_image(&color, &before);
                let wall = wall(&depth, camera);
                host.write_image(&buffer, bytemuck::cast_slice(&wall));
                let lent = [wrapped(&context, &color), wrapped(&context, &buffer)];
                let target = Target { color: lent[0].clone(), depth: with_depth.then(|| lent[1].clone()) };
                let reversed = depth.is_reversed();
                let composite =
                    Composite::new(&effect, &[target], TargetColor::ByFormat, reversed).expect("a composite");
                host.run(|commands| {
                    let mut recorder = recorder(&context, commands);
                    composite.record(&mut recorder, &effect, 0, &depth).expect("a frame");
                    recorder.hand_over(&lent[0], read_by_copy());
                    recorder.hand_over(&lent[1], read_by_copy());
                });
                assert_eq!(lent[0].layout(), vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
                let drawn = host.read_own(&color, lent[0].layout());
                let written = floats(&host.read_own(&buffer, lent[1].layout()));
                let own = effect.depth().expect("depth");
                let (to_z, bgra) = (camera, format == F::B8G8R8A8_UNORM);
                let own = depth_of(&host, own, to_z);
                for (i, z) in own.into_iter().enumerate() {
                    let (was, paint, now) = (&before[4 * i..][..4], &painted[4 * i..][..4], &drawn[4 * i..][..4]);
                    let surface = depth.a + depth.b / z;
                    let nearer = if reversed { surface >= wall[i] } else { surface <= wall[i] };
                    let shown = paint[3] == 255 && (nearer || !with_depth);
                    hidden += usize::from(paint[3] == 255 && !shown);
                    let expected: Vec<f64> = match (shown, bgra, format == F::R8G8B8A8_SRGB) {
                        (false, ..) => was.iter().map(|&c| f64::from(c)).collect(),
                        (true, true, _) => [2, 1, 0, 3].map(|k| f64::from(paint[k])).into(),
                        // Decoded, and encoded by the hardware.
                        (true, _, true) => paint.iter().map(|&c| 255.0 * stored(light(f64::from(c) / 255.0))).collect(),
                        (true, ..) => paint.iter().map(|&c| f64::from(c)).collect(),
                    };
                    for (now, expected) in now.iter().zip(&expected) {
                        let off = (f64::from(*now) - expected).abs();
                        assert!(off <= tolerance + 1e-9, "{format:?}, pixel {i}: {now} is not {expected}");
                    }
                    let depth_now = if shown && with_depth { surface } else { wall[i] };
                    assert!((written[i] - depth_now).abs() < 2e-6, "pixel {i}: {} is not {depth_now}", written[i]);
                }
                drop((composite, lent));
                frame += 1;
                context.advance(frame + 1, frame);
                host.destroy_image(color);
                host.destroy_image(buffer);
            }
        }
    }
    assert!(hidden > 1000, "hardly anything is hidden by the wall");
    drop((effect, context));
    assert_silent(&host.destroy());
}

fn read_by_copy() -> ResourceState {
    ResourceState::from_host(
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_READ,
        vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
    )
}

/// The distance of each pixel's surface along the view axis.
fn depth_of(host: &Host, depth: &Image, camera: &Camera) -> Vec<f32> {
    let own = HostDepth::of_camera(camera);
    let aspect = vk::ImageAspectFlags::DEPTH;
    let texels = floats(&host.read(depth.handle(), aspect, depth.layout(), SIZE));
    texels.into_iter().map(|d| own.b / (d - own.a)).collect()
}

#[test]
fn targets_that_do_not_fit_are_refused() {
    use vk::Format as F;
    use vk::ImageUsageFlags as U;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let (_, object) = methods().into_iter().next().expect("a method");
    let mut effect = Effect::new(&context, desc(&mesh, &object)).expect("an effect");
    let image = |format, usage, size| host.image(format, usage, size);
    let good = image(F::R8G8B8A8_UNORM, U::COLOR_ATTACHMENT, SIZE);
    let other = image(F::B8G8R8A8_UNORM, U::COLOR_ATTACHMENT, SIZE);
    let small = image(F::R8G8B8A8_UNORM, U::COLOR_ATTACHMENT, (SIZE.0 - 1, SIZE.1));
    let words = image(F::R32_UINT, U::COLOR_ATTACHMENT, SIZE);
    let sampled = image(F::R8G8B8A8_UNORM, U::SAMPLED, SIZE);
    let depth = image(F::D32_SFLOAT, U::DEPTH_STENCIL_ATTACHMENT, SIZE);
    let plain = |image: &HostImage| Target { color: wrapped(&context, image), depth: None };
    let new = |effect: &Effect, targets: &[Target]| Composite::new(effect, targets, TargetColor::Stored, false);
    let refused = |effect: &Effect, targets: &[Target], word: &str| {
        let error = new(effect, targets).err().expect(word).to_string();
        assert!(error.contains(word), "{error}");
    };
    refused(&effect, &[plain(&good)], "not ready");
    prepare(&host, &context, &mut effect, &mut frame);
    refused(&effect, &[], "targets");
    refused(&effect, &[plain(&small)], "89x70");
    refused(&effect, &[plain(&words)], "R32_UINT");
    refused(&effect, &[plain(&sampled)], "COLOR_ATTACHMENT");
    refused(&effect, &[plain(&good), plain(&other)], "formats");
    let swapped = Target { color: wrapped(&context, &good), depth: Some(wrapped(&context, &good)) };
    refused(&effect, &[swapped], "depth");
    let color = wrapped(&context, &good);
    let both = Target { color: color.clone(), depth: Some(wrapped(&context, &depth)) };
    let composite = new(&effect, &[both]).expect("a composite");
    let moment = moment(&mesh, 0);
    host.run(|commands| {
        let mut recorder = recorder(&context, commands);
        let depth = HostDepth::of_camera(&moment.camera);
        let mut told = |effect: &Effect, target, depth: &HostDepth, word: &str| {
            let error = composite.record(&mut recorder, effect, target, depth).expect_err(word).to_string();
            assert!(error.contains(word), "{error}");
        };
        told(&effect, 0, &depth, "no frame");
        let mut other = super::recorder(&context, commands);
        effect.record(&mut other, &EffectFrame::next(&moment)).expect("a frame");
        told(&effect, 1, &depth, "target");
        told(&effect, 0, &HostDepth { a: 0.0, b: 0.1 }, "nearer is more");
        told(&effect, 0, &HostDepth { a: f32::NAN, b: -0.1 }, "finite");
        // SAFETY: nothing is recorded with it.
        unsafe { color.set_state(ResourceState::fresh()) };
        told(&effect, 0, &depth, "UNDEFINED");
    });
    drop((composite, effect, color, context));
    [good, other, small, words, sampled, depth].into_iter().for_each(|image| host.destroy_image(image));
    assert_silent(&host.destroy());
}
