//! View-dependent interpolation (chapter 8).

use super::*;

/// Distance to the next texel without a face, among all that are near enough.
fn feather(guide: &[u32], side: i32, x: i32, y: i32) -> u8 {
    let radius = side / 42;
    let mut nearest = radius * radius;
    for (dx, dy) in (-radius..=radius).flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy))) {
        let (x, y) = (x + dx, y + dy);
        let inside = (0..side).contains(&x) && (0..side).contains(&y);
        if !inside || guide[(y * side + x) as usize] == 0 {
            nearest = nearest.min(dx * dx + dy * dy);
        }
    }
    (nearest * 255 / (radius * radius)) as u8
}

#[test]
fn textures_of_views_equal_the_oracle_exactly() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &VIEWS, 512).expect("covered");
    let textures = [noise_strip(180, 90), noise_strip(150, 80)];
    let (_, trajectory) = strip("strip_dark_red.png");
    let paints = textures.each_ref().map(|texture| Paint { texture, trajectory: &trajectory });
    let quilt = QuiltParams { block_px: 64, overlap_px: 8, ..Default::default() };
    let params = DependentParams { quilt, k: Some(0.5), ..Default::default() };
    let technique = dependent_technique(&gpu, &mut runner, &mesh, &covered, (64, 64), &paints, &[0, 1], &params);
    let texels = 512 * 512;
    let mut guides: Vec<Vec<u32>> = Vec::new();
    let per_slice = technique.preparation_parts(u64::MAX).len() / covered.slices.len();
    for (i, part) in technique.preparation_parts(u64::MAX).into_iter().enumerate() {
        if i / per_slice > 1 && i / per_slice + 1 < covered.slices.len() {
            continue; // The first two and the last one will do.
        }
        runner.run(|recorder| technique.record_preparation(recorder, &part, 11)).expect("run");
        if i % per_slice + 1 == per_slice {
            let guide = runner.read_image(technique.guide().expect("a guide")).expect("guide");
            guides.push(bytemuck::pod_collect_to_vec(&guide));
        }
    }
    let got = rgba(&mut runner, technique.slices());
    let window = ImageParams { quilt, k: Some(0.5), ..ImageParams::default() };
    for (guide, slice) in guides.iter().zip([0, 1, covered.slices.len() - 1]) {
        let mut want = vec![[128, 128, 128, 255]; texels];
        for (number, texture) in (1..).zip(&textures) {
            let size = (texture.width(), texture.height());
            let shade: Vec<u8> = guide.iter().map(|texel| *texel as u8).collect();
            let ours: Vec<bool> = guide.iter().map(|texel| texel >> 16 == number).collect();
            let window_px = window.window_px(size.0).expect("a window");
            let oracle_guide = OracleGuide { shade: &shade, covered: &ours, window_px };
            let quilt = QuiltParams { seed: 11 + slice as u32, ..quilt };
            let quilted =
                quilt_oracle(&texture.to_unorm8(), size, (512, 512), &quilt, Some(&oracle_guide)).expect("oracle");
            for ((to, from), texel) in want.iter_mut().zip(&quilted.pixels).zip(guide) {
                if from[3] != 0 && (texel >> 16 == number || texel >> 16 == 0) {
                    *to = *from;
                }
            }
        }
        for (i, to) in want.iter_mut().enumerate() {
            to[3] = feather(guide, 512, i as i32 % 512, i as i32 / 512);
        }
        assert!(guide.iter().filter(|texel| **texel != 0).count() > 500, "slice {slice} shows something");
        assert!(got[slice * texels..(slice + 1) * texels] == want[..], "slice {slice}");
    }
}

#[test]
fn dependent_frames_have_no_gaps_and_move_without_a_jump() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("head.obj");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &default_views(), 512).expect("covered");
    assert_eq!(covered.report.covered + covered.report.forced, mesh.indices().len() / 3);
    let (texture, trajectory) = strip("strip_dark_red.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let params = DependentParams { k: Some(0.25), ..Default::default() };
    let technique = dependent_technique(&gpu, &mut runner, &mesh, &covered, (160, 160), &paints, &[0], &params);
    for part in technique.preparation_parts(400_000_000) {
        runner.run(|recorder| technique.record_preparation(recorder, &part, 1)).expect("run");
    }
    let lights = Lights::default();
    for (yaw_deg, pitch_deg) in [(25.0, 12.0), (100.0, -70.0), (200.0, 40.0), (0.0, 0.0)] {
        let camera =
            Camera::framing(&mesh, &Framing { yaw_deg, pitch_deg, ..Default::default() }, 1.0).expect("a camera");
        let (_, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, &lights, (160, 160));
        let moment = Moment::at_rest(camera, lights.clone());
        runner.run(|recorder| technique.record(recorder, &moment, Show::Color)).expect("run");
        let want = coloured(&trajectory, &shade, &id);
        let off = share_off(&rgba(&mut runner, technique.frame()), &want, 2);
        assert!(off < 0.003, "{yaw_deg}, {pitch_deg}: {off} of the pixels are off, or missing");
        runner.run(|recorder| technique.record(recorder, &moment, Show::Texture)).expect("run");
        let frame = rgba(&mut runner, technique.frame());
        let spread = deviation(frame.iter().filter(|p| p[3] == 255).map(|p| f64::from(p[1])));
        // From below most of it is dark, where the strip is quiet.
        assert!(spread > 2.0, "{yaw_deg}, {pitch_deg}: the texture has {spread}");
    }
    // From step to step the texture changes about alike: nothing enters or leaves at once.
    let mut before: Option<Vec<[u8; 4]>> = None;
    let mut changes = Vec::new();
    for step in 0..120 {
        let framing = Framing { yaw_deg: step as f32 * 0.5, distance: Some(4.5), ..Default::default() };
        let camera = Camera::framing(&mesh, &framing, 1.0).expect("a camera");
        let moment = Moment::at_rest(camera, lights.clone());
        runner.run(|recorder| technique.record(recorder, &moment, Show::Texture)).expect("run");
        let frame = rgba(&mut runner, technique.frame());
        if let Some(before) = before.replace(frame.clone()) {
            let both = before.iter().zip(&frame).filter(|(a, b)| a[3] == 255 && b[3] == 255);
            let sum: f64 = both.clone().map(|(a, b)| f64::from(a[1].abs_diff(b[1]))).sum();
            changes.push(sum / both.count() as f64);
        }
    }
    changes.sort_by(f64::total_cmp);
    let (median, most) = (changes[changes.len() / 2], changes[changes.len() - 1]);
    eprintln!("mean change of a step: median {median:.2}, most {most:.2}");
    assert!(most < 2.0 * median, "a step of {most} among steps of {median}");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let moment = Moment::at_rest(camera, lights.clone());
    runner.run(|recorder| technique.record(recorder, &moment, Show::Painted)).expect("run");
    assert_golden("dependent_head", &rgba(&mut runner, technique.frame()), (160, 160), 0.1);
    // Where one slice has nearly all, as from its own direction, blending is nearly that slice alone.
    let directions: Vec<Vec3> = covered.slices.iter().map(|slice| slice.direction).collect();
    let set = covered.sets.iter().find(|set| set.contains(&0)).expect("a set");
    assert!(blend_weights(&directions, set, directions[0])[0].1 > 0.99);
}

/// What a ray from the eye hits first (Moeller and Trumbore 1997): the object, the face, and where, as the object has
/// it.
pub fn hit(mesh: &Mesh, moment: &Moment, ray: Vec3) -> Option<(usize, usize, Vec3)> {
    let corner = |vertex: u32| Vec3::from(mesh.positions()[vertex as usize]).as_dvec3();
    let mut nearest = None;
    for (number, object) in mesh.objects().iter().enumerate() {
        let pose = moment.pose(number);
        let (eye, ray) = (pose.point_to_object(moment.camera.eye()).as_dvec3(), pose.to_object(ray).as_dvec3());
        let first = object.first_index as usize / 3;
        for face in first..first + object.index_count as usize / 3 {
            let triangle = &mesh.indices()[3 * face..3 * face + 3];
            let a = corner(triangle[0]);
            let (ab, ac) = (corner(triangle[1]) - a, corner(triangle[2]) - a);
            let across = ray.cross(ac);
            let det = ab.dot(across);
            let from = eye - a;
            let (u, turned) = (from.dot(across) / det, from.cross(ab));
            let (v, t) = (ray.dot(turned) / det, ac.dot(turned) / det);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && nearest.is_none_or(|(_, _, _, other)| t < other) {
                nearest = Some((number, face, (eye + t * ray).as_vec3(), t));
            }
        }
    }
    nearest.map(|(number, face, point, _)| (number, face, point))
}

/// The frame as it reads in chapter 8, a ray at a time: the texture at a point of a face.
pub fn blended(covered: &Covered, texels: &[[u8; 4]], side: usize, from: Vec3, face: usize, point: Vec3) -> Vec4 {
    let directions: Vec<Vec3> = covered.slices.iter().map(|slice| slice.direction).collect();
    let weights = blend_weights(&directions, &covered.sets[covered.set_of_face[face] as usize], from);
    let (mut sum, mut total, mut squares) = (Vec4::ZERO, 0.0, 0.0);
    for (slice, weight) in weights.into_iter().filter(|(_, weight)| *weight > 0.0) {
        let slice = usize::from(slice);
        let clip = covered.slices[slice].camera.view_projection(1.0).expect("a projection") * point.extend(1.0);
        let place = [clip.x, clip.y].map(|v| (0.5 + 0.5 * v / clip.w) * side as f32 - 0.5);
        let at = |x: f32, y: f32| {
            let [x, y] = [x, y].map(|v| v.clamp(0.0, side as f32 - 1.0) as usize);
            Vec4::from(texels[(slice * side + y) * side + x].map(f32::from)) / 127.5 - 1.0
        };
        let [(x, fx), (y, fy)] = place.map(|v| (v.floor(), v - v.floor()));
        let row = |y| at(x, y).lerp(at(x + 1.0, y), fx);
        let texel = row(y).lerp(row(y + 1.0), fy);
        let counts = weight * (0.5 + 0.5 * texel.w).max(1.0 / 255.0);
        sum += counts * texel;
        total += counts;
        squares += counts * counts;
    }
    sum / total / (squares / (total * total)).sqrt()
}

#[test]
fn dependent_texture_equals_a_ray_at_a_time() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &default_views(), 512).expect("covered");
    let textures = [noise_strip(180, 90), noise_strip(150, 80)];
    let (_, trajectory) = strip("strip_dark_red.png");
    let paints = textures.each_ref().map(|texture| Paint { texture, trajectory: &trajectory });
    let params = DependentParams { k: Some(0.5), ..Default::default() };
    let (width, height) = (150, 110);
    let technique = dependent_technique(&gpu, &mut runner, &mesh, &covered, (width, height), &paints, &[1, 0], &params);
    for part in technique.preparation_parts(400_000_000) {
        runner.run(|recorder| technique.record_preparation(recorder, &part, 1)).expect("run");
    }
    let texels = rgba(&mut runner, technique.slices());
    let lights = Lights::default();
    for (yaw_deg, pitch_deg) in [(20.0, 25.0), (0.0, 0.0), (-140.0, 60.0)] {
        let framing = Framing { yaw_deg, pitch_deg, ..Default::default() };
        let aspect = width as f32 / height as f32;
        let camera = Camera::framing(&mesh, &framing, aspect).expect("a camera");
        let moment = Moment::at_rest(camera, lights.clone());
        runner.run(|recorder| technique.record(recorder, &moment, Show::Texture)).expect("run");
        let frame = rgba(&mut runner, technique.frame());
        let from = (camera.eye() - mesh.bounding_sphere().center).normalize();
        let inverse = camera.view_projection(aspect).expect("a projection").inverse();
        let (mut compared, mut off, mut flat) = (0, 0, 0);
        for (x, y) in (0..height).step_by(3).flat_map(|y| (0..width).step_by(3).map(move |x| (x, y))) {
            let ndc = Vec3::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32, 0.5);
            let beyond = inverse.project_point3(2.0 * ndc - Vec3::new(1.0, 1.0, 0.5));
            let pixel = frame[(y * width + x) as usize];
            let Some((_, face, point)) = hit(&mesh, &moment, beyond - camera.eye()) else {
                assert_eq!(pixel, [0; 4], "nothing is at {x}, {y}");
                continue;
            };
            let value = blended(&covered, &texels, 512, from, face, point);
            let want = [value.x, value.y, value.z].map(|v| ((0.5 + 0.5 * v).clamp(0.0, 1.0) * 255.0).round() as u8);
            compared += 1;
            off += u32::from(want.iter().zip(&pixel).any(|(a, b)| a.abs_diff(*b) > 4));
            flat += u32::from(want.iter().all(|v| v.abs_diff(128) < 8));
        }
        eprintln!("{yaw_deg}, {pitch_deg}: {off} of {compared} off, {flat} without texture");
        // Where two faces meet, the ray and the rasteriser may choose differently. From the side there is least to see.
        assert!(compared > 150 && off * 100 < compared, "{off} of {compared} are off");
        assert!(flat * 4 < compared, "the texture is worth comparing");
    }
}
