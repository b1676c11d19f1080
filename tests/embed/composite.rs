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

/// What a channel of a target holds, by its format, as a number that can be compared: its texel, red first.
fn channels(format: vk::Format, texel: &[u8]) -> [f64; 4] {
    use vk::Format as F;
    match format {
        F::B8G8R8A8_UNORM => [2, 1, 0, 3].map(|k| f64::from(texel[k])),
        F::A2B10G10R10_UNORM_PACK32 => {
            let word = u32::from_le_bytes([0, 1, 2, 3].map(|k| texel[k]));
            [word & 1023, word >> 10 & 1023, word >> 20 & 1023, word >> 30].map(f64::from)
        }
        F::R16G16B16A16_SFLOAT => {
            let half = |k: usize| {
                let bits = u16::from_le_bytes([texel[2 * k], texel[2 * k + 1]]);
                let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
                if exponent == 0 {
                    fraction * 2f64.powi(-14)
                } else {
                    (1.0 + fraction) * 2f64.powi(exponent - 15)
                }
            };
            [0, 1, 2, 3].map(half)
        }
        _ => [0, 1, 2, 3].map(|k| f64::from(texel[k])),
    }
}

/// What it must hold where opaque paint lies over it, and how far off that may be.
fn expected(format: vk::Format, paint: &[u8]) -> ([f64; 4], f64) {
    use vk::Format as F;
    let part = [0, 1, 2, 3].map(|k| f64::from(paint[k]) / 255.0);
    match format {
        // Decoded, and encoded by the hardware.
        F::R8G8B8A8_SRGB => (part.map(|c| 255.0 * stored(light(c))), 1.0),
        F::R16G16B16A16_SFLOAT => (part.map(light), 1e-3),
        F::A2B10G10R10_UNORM_PACK32 => ([part[0] * 1023.0, part[1] * 1023.0, part[2] * 1023.0, part[3] * 3.0], 1.0),
        _ => (part.map(|c| 255.0 * c), 1e-9),
    }
}

/// Depths as a format has them in a buffer.
fn stored_depth(format: vk::Format, depths: &[f32]) -> Vec<u8> {
    let whole = |most: f32| depths.iter().map(move |depth| (depth * most).round() as u32);
    match format {
        vk::Format::D16_UNORM => whole(65_535.0).flat_map(|word| (word as u16).to_le_bytes()).collect(),
        vk::Format::D24_UNORM_S8_UINT | vk::Format::X8_D24_UNORM_PACK32 => {
            whole(16_777_215.0).flat_map(u32::to_le_bytes).collect()
        }
        _ => bytemuck::cast_slice(depths).to_vec(),
    }
}

/// And back, with the step between two neighbours.
fn read_depth(format: vk::Format, bytes: &[u8]) -> (Vec<f32>, f32) {
    let count = (SIZE.0 * SIZE.1) as usize;
    match format {
        vk::Format::D16_UNORM => {
            let words: Vec<u16> = bytemuck::pod_collect_to_vec(&bytes[..2 * count]);
            (words.into_iter().map(|word| f32::from(word) / 65_535.0).collect(), 1.0 / 65_535.0)
        }
        vk::Format::D24_UNORM_S8_UINT | vk::Format::X8_D24_UNORM_PACK32 => {
            let words: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes[..4 * count]);
            (words.into_iter().map(|word| (word & 0xff_ffff) as f32 / 16_777_215.0).collect(), 1e-7)
        }
        _ => (floats(&bytes[..4 * count]), 1e-7),
    }
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
    let mut effect = ready(&host, &context, desc(&mesh, &object), &mut frame);
    let moment = moment(&mesh, 0);
    let painted = picture(&host, &context, &mut effect, &EffectFrame::next(&moment));
    let camera = &moment.camera;
    let near = 0.25 * camera.near();
    let infinite = directx::perspective_infinite_reverse(camera.fov_y_deg().to_radians(), 9.0 / 7.0, near);
    let ways = [HostDepth::of_camera(camera), HostDepth::from_projection(&infinite).expect("a perspective")];
    let targets = [
        (F::R8G8B8A8_UNORM, None),
        (F::R8G8B8A8_UNORM, Some(F::D32_SFLOAT)),
        (F::B8G8R8A8_UNORM, Some(F::D32_SFLOAT_S8_UINT)),
        (F::R8G8B8A8_SRGB, Some(F::X8_D24_UNORM_PACK32)),
        (F::A2B10G10R10_UNORM_PACK32, Some(F::D24_UNORM_S8_UINT)),
        (F::R16G16B16A16_SFLOAT, Some(F::D16_UNORM)),
    ];
    let (mut hidden, mut taken) = (0, Vec::new());
    for depth in ways {
        for (format, depth_format) in targets {
            if depth_format.is_some_and(|format| !host.draws_depth(format)) {
                continue;
            }
            taken.extend(depth_format);
            let color = host.image(format, U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST, SIZE);
            let usage = U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST;
            let buffer_format = depth_format.unwrap_or(F::D32_SFLOAT);
            let buffer = host.image(buffer_format, usage, SIZE);
            let before = match format {
                // A half in every channel.
                F::R16G16B16A16_SFLOAT => [0x00, 0x38].repeat(4 * (SIZE.0 * SIZE.1) as usize),
                _ => noise(SIZE.0, SIZE.1, 17).into_flattened(),
            };
            host.write_image(&color, &before);
            let mut depths = stored_depth(buffer_format, &wall(&depth, camera));
            let (wall, step) = read_depth(buffer_format, &depths);
            let stencil: Vec<u8> = match buffer_format {
                F::D24_UNORM_S8_UINT | F::D32_SFLOAT_S8_UINT => (0..SIZE.0 * SIZE.1).map(|i| i as u8).collect(),
                _ => Vec::new(),
            };
            depths.extend(&stencil);
            host.write_image(&buffer, &depths);
            let lent = [wrapped(&context, &color), wrapped(&context, &buffer)];
            let target = Target { color: lent[0].clone(), depth: depth_format.map(|_| lent[1].clone()) };
            let reversed = depth.is_reversed();
            let composite = Composite::new(&effect, &[target], TargetColor::ByFormat, reversed).expect("a composite");
            host.run(|commands| {
                let mut recorder = recorder(&context, commands);
                composite.record(&mut recorder, &effect, 0, (0, 0), &depth).expect("a frame");
                recorder.hand_over(&lent[0], read_by_copy());
                recorder.hand_over(&lent[1], read_by_copy());
            });
            assert_eq!(lent[0].layout(), vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
            let drawn = host.read_own(&color, lent[0].layout());
            let bytes = host.read_own(&buffer, lent[1].layout());
            let (written, _) = read_depth(buffer_format, &bytes);
            assert!(bytes.ends_with(&stencil), "{depth_format:?}: the stencil has changed");
            let texel = drawn.len() / written.len();
            let (mut shown_count, mut doubtful) = (0, 0);
            for (i, z) in depth_of(&host, &effect).into_iter().enumerate() {
                let at = |bytes: &[u8]| channels(format, &bytes[texel * i..][..texel]);
                let paint = &painted[4 * i..][..4];
                let surface = depth.a + depth.b / z;
                if paint[3] == 255 && depth_format.is_some() && (surface - wall[i]).abs() < 2.0 * step {
                    doubtful += 1;
                    continue;
                }
                let nearer = if reversed { surface >= wall[i] } else { surface <= wall[i] };
                let shown = paint[3] == 255 && (nearer || depth_format.is_none());
                hidden += usize::from(paint[3] == 255 && !shown);
                shown_count += usize::from(shown);
                let (now, (expected, tolerance)) = (at(&drawn), expected(format, paint));
                let (expected, tolerance) = if shown { (expected, tolerance) } else { (at(&before), 0.0) };
                for (now, expected) in now.iter().zip(expected) {
                    assert!((now - expected).abs() <= tolerance, "{format:?}, pixel {i}: {now} is not {expected}");
                }
                let depth_now = if shown && depth_format.is_some() { surface } else { wall[i] };
                let off = (written[i] - depth_now).abs();
                assert!(off < step + 2e-6, "{buffer_format:?}, pixel {i}: {} is not {depth_now}", written[i]);
            }
            assert!(shown_count > 500 && doubtful < 100, "{depth_format:?}: {shown_count} shown, {doubtful} doubtful");
            drop((composite, lent));
            frame += 1;
            context.advance(frame + 1, frame);
            host.destroy_image(color);
            host.destroy_image(buffer);
        }
    }
    assert!(hidden > 1000, "hardly anything is hidden by the wall");
    // What Vulkan promises of depth formats, and with a stencil one of two.
    assert!(taken.contains(&F::D16_UNORM) && taken.iter().any(|format| format.as_raw() >= 129), "{taken:?}");
    drop((effect, context));
    assert_silent(&host.destroy());
}

/// A part of a picture in a part of a larger target, as of a split screen.
#[test]
fn a_picture_lies_where_the_host_says() {
    use vk::ImageUsageFlags as U;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let (_, object) = methods().into_iter().next().expect("a method");
    let mut effect = ready(&host, &context, desc(&mesh, &object), &mut frame);
    let (moment, part, at, size) = (moment(&mesh, 0), (61, 47), (53, 8), (120, 60));
    let next = EffectFrame { size_px: Some(part), ..EffectFrame::next(&moment) };
    let painted = picture(&host, &context, &mut effect, &next);
    let color = host.image(vk::Format::R8G8B8A8_UNORM, U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST, size);
    let before = noise(size.0, size.1, 5).into_flattened();
    host.write_image(&color, &before);
    let lent = wrapped(&context, &color);
    let target = Target { color: lent.clone(), depth: None };
    let composite = Composite::new(&effect, &[target], TargetColor::Stored, false).expect("a composite");
    let depth = HostDepth::of_camera(effect.camera().expect("a frame"));
    host.run(|commands| {
        let mut recorder = recorder(&context, commands);
        for stray in [(60, 8), (53, 14), (u32::MAX, 0), (0, u32::MAX)] {
            let told = composite.record(&mut recorder, &effect, 0, stray, &depth).expect_err("no room").to_string();
            assert!(told.contains("at_px") && told.contains("61x47"), "{told}");
        }
        composite.record(&mut recorder, &effect, 0, at, &depth).expect("a frame");
    });
    let drawn = host.read_own(&color, lent.layout());
    let mut shown = 0;
    for (i, (was, now)) in before.chunks(4).zip(drawn.chunks(4)).enumerate() {
        let (x, y) = (i as u32 % size.0, i as u32 / size.0);
        let inside = (at.0..at.0 + part.0).contains(&x) && (at.1..at.1 + part.1).contains(&y);
        let paint = inside.then(|| &painted[4 * ((y - at.1) * SIZE.0 + x - at.0) as usize..][..4]);
        let expected = paint.filter(|paint| paint[3] == 255);
        shown += u32::from(expected.is_some());
        assert_eq!(now, expected.unwrap_or(was), "({x}, {y})");
    }
    assert!(shown > 500, "{shown}");
    drop((composite, effect, lent, context));
    host.destroy_image(color);
    assert_silent(&host.destroy());
}

/// A host that draws the mesh too has depths that are off by rounding.
#[test]
fn a_bias_lets_paint_lie_over_the_hosts_own_drawing_of_the_mesh() {
    use vk::ImageUsageFlags as U;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let (_, object) = methods().into_iter().next().expect("a method");
    let mut effect = ready(&host, &context, desc(&mesh, &object), &mut frame);
    let moment = moment(&mesh, 0);
    let painted = picture(&host, &context, &mut effect, &EffectFrame::next(&moment));
    let near = 0.01;
    for (reversed, depth) in [(true, HostDepth { a: 0.0, b: near }), (false, HostDepth { a: 1.0, b: -near })] {
        let off = |i: usize| 1.0 + [-2e-4, 2e-4][i % 2];
        let drawn: Vec<f32> =
            depth_of(&host, &effect).iter().enumerate().map(|(i, z)| depth.a + depth.b / (z * off(i))).collect();
        let color =
            host.image(vk::Format::R8G8B8A8_UNORM, U::COLOR_ATTACHMENT | U::TRANSFER_SRC | U::TRANSFER_DST, SIZE);
        let buffer = host.image(vk::Format::D32_SFLOAT, U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_DST, SIZE);
        let mut missing = |depth: HostDepth| {
            host.write_image(&color, &vec![0; painted.len()]);
            host.write_image(&buffer, bytemuck::cast_slice(&drawn));
            let lent = [wrapped(&context, &color), wrapped(&context, &buffer)];
            let target = Target { color: lent[0].clone(), depth: Some(lent[1].clone()) };
            let composite = Composite::new(&effect, &[target], TargetColor::Stored, reversed).expect("a composite");
            host.run(|commands| {
                composite.record(&mut recorder(&context, commands), &effect, 0, (0, 0), &depth).expect("a frame");
            });
            let shown = host.read_own(&color, lent[0].layout());
            frame += 1;
            context.advance(frame + 1, frame);
            painted.chunks(4).zip(shown.chunks(4)).filter(|(paint, shown)| paint[3] > shown[3]).count()
        };
        assert!(missing(depth) > 500, "there is nothing to be repaired");
        assert_eq!(missing(depth.nearer_by(0.001)), 0);
        host.destroy_image(color);
        host.destroy_image(buffer);
    }
    drop((effect, context));
    assert_silent(&host.destroy());
}

/// Far surfaces keep their distance also by a camera whose near plane is close and whose far plane is at infinity.
#[test]
fn an_infinite_projection_takes_nothing_from_the_depth() {
    use glam::camera::rh::proj::directx;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut frame = 0;
    let still = moment(&mesh, 0);
    let fov = still.camera.fov_y_deg().to_radians();
    let infinite = directx::perspective_infinite_reverse(fov, SIZE.0 as f32 / SIZE.1 as f32, 0.001);
    let camera = Camera::from_matrices(&still.camera.view(), &infinite).expect("a camera");
    let far_off = Moment { camera, ..still.clone() };
    for (name, method) in methods() {
        let mut seen = |moment: &Moment| {
            let mut effect = ready(&host, &context, desc(&mesh, &method), &mut frame);
            let painted = picture(&host, &context, &mut effect, &EffectFrame::next(moment));
            (painted, depth_of(&host, &effect))
        };
        let ((fitted, expected), (painted, depths)) = (seen(&still), seen(&far_off));
        let mut both = 0;
        for (i, (z, expected)) in depths.iter().zip(expected).enumerate() {
            if fitted[4 * i + 3] == 255 && painted[4 * i + 3] == 255 {
                both += 1;
                assert!((z - expected).abs() < 1e-5 * expected, "{name}, pixel {i}: {z} is not {expected}");
            }
        }
        assert!(both > 1000, "{name}: {both}");
        let alone = fitted.chunks(4).zip(painted.chunks(4)).filter(|(a, b)| a[3] != b[3]).count();
        assert!(alone <= 2, "{name}: {alone} pixels of the outline differ");
    }
    drop(context);
    assert_silent(&host.destroy());
}

fn read_by_copy() -> ResourceState {
    ResourceState::from_host(
        vk::PipelineStageFlags::TRANSFER,
        vk::AccessFlags::TRANSFER_READ,
        vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
    )
}

/// The distance along the view axis of each pixel's surface in the frame that was recorded last.
fn depth_of(host: &Host, effect: &Effect) -> Vec<f32> {
    let (own, depth) = (HostDepth::of_camera(effect.camera().expect("a frame")), effect.depth().expect("depth"));
    let texels = floats(&host.read(depth.handle(), vk::ImageAspectFlags::DEPTH, depth.layout(), SIZE));
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
    let uneven = Target { color: wrapped(&context, &small), depth: Some(wrapped(&context, &depth)) };
    refused(&effect, &[uneven], "89x70");
    refused(&effect, &[plain(&words)], "R32_UINT");
    refused(&effect, &[plain(&sampled)], "COLOR_ATTACHMENT");
    refused(&effect, &[plain(&good), plain(&other)], "formats");
    let swapped = Target { color: wrapped(&context, &good), depth: Some(wrapped(&context, &good)) };
    refused(&effect, &[swapped], "depth");
    let color = wrapped(&context, &good);
    refused(&effect, &[Target { color: effect.picture().expect("a picture").clone(), depth: None }], "reads");
    let both = Target { color: color.clone(), depth: Some(wrapped(&context, &depth)) };
    let composite = new(&effect, &[both]).expect("a composite");
    let moment = moment(&mesh, 0);
    host.run(|commands| {
        let mut recorder = recorder(&context, commands);
        let depth = HostDepth::of_camera(&moment.camera);
        let mut told = |effect: &Effect, target, depth: &HostDepth, word: &str| {
            let error = composite.record(&mut recorder, effect, target, (0, 0), depth).expect_err(word).to_string();
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
