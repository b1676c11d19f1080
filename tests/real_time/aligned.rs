//! View-aligned projection (chapter 7).

use super::*;

#[test]
fn levels_equal_the_oracles_exactly() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let textures = [strip("strip_dark_red.png").0, noise_strip(60, 33)];
    let sources = textures.each_ref().map(LevelSource::Strip);
    for tileable in [Tileable::Wrap, Tileable::Mask] {
        let params = LevelParams { tileable, ..LEVELS };
        let volume = levels(&gpu, &mut runner, &sources, &params, 7);
        let got = rgba(&mut runner, volume.image());
        let size = (params.size_px, params.size_px);
        let texels = (size.0 * size.1) as usize;
        for (paint, texture) in textures.iter().enumerate() {
            for level in 0..params.levels {
                let (sample, sample_size) = params.sample(texture, level);
                let wrap = tileable == Tileable::Wrap;
                let quilt = QuiltParams { tileable: wrap, seed: 7 + level, ..params.quilt };
                let quilted = quilt_oracle(&sample, sample_size, size, &quilt, None).expect("oracle").pixels;
                let want = if wrap { quilted } else { tile_oracle(&quilted, size) };
                let at = (paint * params.levels as usize + level as usize) * texels;
                assert!(got[at..at + texels] == want[..], "paint {paint}, level {level}, {tileable:?}");
            }
        }
        // A level's mean is no difference before it is quilted.
        let (sample, _) = params.sample(&textures[0], 1);
        let mean = sample.iter().map(|p| f64::from(p[0])).sum::<f64>() / sample.len() as f64;
        assert!((mean - 127.5).abs() < 0.6, "{mean}");
        // What was prepared is the same when it is taken from a file.
        let (_, trajectory) = strip("strip_dark_red.png");
        let file = volume.read(&mut runner, 1, &trajectory).expect("levels");
        let again = levels(&gpu, &mut runner, &[LevelSource::Prepared(&file)], &params, 0);
        assert!(again.parts(u64::MAX).is_empty());
        assert!(rgba(&mut runner, again.image()) == got[3 * texels..6 * texels]);
    }
}

/// View-aligned projection as it reads in chapter 7, a pixel at a time.
struct Aligned<'a> {
    volume: &'a [[u8; 4]],
    params: LevelParams,
    trajectories: &'a [&'a Trajectory],
    frame: AlignedFrame,
    offsets_px: &'a [[f64; 2]],
}

impl Aligned<'_> {
    fn texel(&self, slice: usize, x: i64, y: i64) -> Vec4 {
        let side = i64::from(self.params.size_px);
        let at = slice as i64 * side * side + y.rem_euclid(side) * side + x.rem_euclid(side);
        let texel = self.volume[at as usize].map(f32::from);
        Vec4::from(texel) / 255.0 * 2.0 - 1.0
    }

    fn bilinear(&self, slice: usize, x: f32, y: f32) -> Vec4 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let row = |y| self.texel(slice, x, y).lerp(self.texel(slice, x + 1, y), fx);
        row(y).lerp(row(y + 1), fy)
    }

    fn pixel(&self, x: u32, y: u32, shade: f32, (object, paint): (usize, usize)) -> [u8; 4] {
        let ShadeRange { low, high } = self.frame.range;
        let tone = ((shade - low) / (high - low)).clamp(0.0, 1.0);
        let place = tone * (self.params.levels - 1) as f32;
        let level = (place as usize).min(self.params.levels as usize - 1);
        let above = (level + 1).min(self.params.levels as usize - 1);
        let f = place - level as f32;
        let offset_px = self.offsets_px.get(object).copied().unwrap_or(self.frame.offset_px.map(f64::from));
        let at = |p: u32, k: usize| {
            ((f64::from(p) + 0.5 + offset_px[k].round()) * f64::from(self.frame.density)
                % f64::from(self.params.size_px)) as f32
        };
        let first = paint * self.params.levels as usize;
        let [a, b] = [level, above].map(|level| self.bilinear(first + level, at(x, 0), at(y, 1)));
        let mut difference = a.lerp(b, f);
        if self.frame.blend == LevelBlend::Contrast {
            difference /= (f * f + (1.0 - f) * (1.0 - f)).sqrt();
        }
        let color = self.trajectories[paint].at(tone);
        let value = |k: usize| match self.frame.show {
            Show::Painted => color[k] + difference[k],
            Show::Color => color[k],
            Show::Texture => 0.5 + 0.5 * difference[k],
        };
        let byte = |k| (value(k).clamp(0.0, 1.0) * 255.0).round() as u8;
        [byte(0), byte(1), byte(2), 255]
    }
}

#[test]
fn aligned_frames_equal_a_plain_oracle() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let (camera, lights) = (Camera::framing(&mesh, &Framing::default(), 1.2).expect("a camera"), Lights::default());
    let size = (120, 100);
    let (pass, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, &lights, size);
    let strips = [strip("strip_dark_red.png"), strip("strip_green_yellow.png")];
    let sources = strips.each_ref().map(|(texture, _)| LevelSource::Strip(texture));
    let volume = levels(&gpu, &mut runner, &sources, &LEVELS, 3);
    let texels = rgba(&mut runner, volume.image());
    let trajectories = strips.each_ref().map(|(_, trajectory)| trajectory);
    let mut uploads = Uploads::default();
    let technique =
        AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &trajectories, &[1, 0]).expect("new");
    let plain = AlignedFrame::default();
    // The table, and the teapot on it.
    let apart = [[-7.4, 3.6], [1e6 + 0.3, -52.5]];
    let frames: [(AlignedFrame, &[[f64; 2]]); 6] = [
        (plain, &[]),
        (AlignedFrame { density: 0.7, offset_px: [13.25, -40.75], blend: LevelBlend::Linear, ..plain }, &[]),
        (AlignedFrame { offset_px: [5.0, 9.0], ..plain }, &apart[..1]),
        (AlignedFrame { range: ShadeRange { low: 0.2, high: 0.7 }, density: 1.5, ..plain }, &apart),
        (AlignedFrame { show: Show::Color, ..plain }, &apart),
        (AlignedFrame { show: Show::Texture, density: 2.0, ..plain }, &apart),
    ];
    for (frame, offsets_px) in frames {
        runner
            .run(|recorder| {
                uploads.record(recorder);
                technique.record(recorder, &frame, offsets_px)
            })
            .expect("run");
        let got = rgba(&mut runner, technique.frame());
        let oracle = Aligned { volume: &texels, params: LEVELS, trajectories: &trajectories, frame, offsets_px };
        let want: Vec<[u8; 4]> = (0..size.0 * size.1)
            .map(|i| match id[i as usize] {
                0 => [0; 4],
                id => {
                    let object = id as usize - 1;
                    oracle.pixel(i % size.0, i / size.0, shade[i as usize], (object, 1 - object))
                }
            })
            .collect();
        // The hardware's filter has 8 bits for its weights, and trilinear ones of 8-bit texels may be 1.7/255 off,
        // which the differences' range doubles and contrast may raise by the root of 2.
        let off = share_off(&got, &want, 5);
        eprintln!("{frame:?}, {offsets_px:?}: {off:.5} off, {:.5} by more than 2", share_off(&got, &want, 2));
        assert!(off < 0.0005, "{frame:?}, {offsets_px:?}: {off} of the pixels are off");
        let swapped: Vec<[u8; 4]> = want.iter().map(|&[r, g, b, a]| [g, b, r, a]).collect();
        assert!(share_off(&got, &swapped, 5) > 0.05 || frame.show == Show::Texture, "a wrong picture is noticed");
    }
    let frame = AlignedFrame { density: 0.7, ..plain };
    runner.run(|recorder| technique.record(recorder, &frame, &[])).expect("run");
    assert_golden("aligned_teapot", &rgba(&mut runner, technique.frame()), size, 0.01);
    let wrong = AlignedFrame { density: 9.0, ..plain };
    let mut refused = |frame: &AlignedFrame, offsets: &[[f64; 2]]| {
        runner.run(|recorder| technique.record(recorder, frame, offsets)).expect_err("refused").to_string()
    };
    assert!(refused(&wrong, &[]).contains("density is 9"));
    assert!(refused(&plain, &[[0.0, f64::NAN]]).contains("offsets_px is NaN"));
}

/// A flat square that fills the picture, at one shade: what is seen is the texture itself.
fn flat_square() -> (Mesh, Camera) {
    let quad = "v -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";
    let mesh = Mesh::parse(quad.as_bytes(), "quad", &MeshOptions::default()).expect("a mesh").mesh;
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, None, 60.0).expect("a camera");
    let camera = camera.fit_depth(&mesh);
    (mesh, camera)
}

#[test]
fn aligned_texture_repeats_without_a_seam_and_keeps_its_contrast_between_levels() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let (mesh, camera) = flat_square();
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let volume = levels(&gpu, &mut runner, &[LevelSource::Strip(&texture)], &LevelParams { levels: 8, ..LEVELS }, 2);
    let lit = |shade: f32| {
        let cos = 2.0 * shade - 1.0;
        Lights::from(DirectionalLight::new(Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos), 1.0).expect("a light"))
    };
    let (pass, ..) = guide(&gpu, &mut runner, &mesh, &camera, &lit(0.5), (128, 128));
    let mut uploads = Uploads::default();
    let technique =
        AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &[&trajectory], &[0]).expect("new");
    let mut texture_at = |shade: f32, blend| {
        let frame = AlignedFrame { show: Show::Texture, blend, ..Default::default() };
        runner
            .run(|recorder| {
                uploads.record(recorder);
                pass.record(recorder, &Moment::at_rest(camera, lit(shade)))?;
                technique.record(recorder, &frame, &[])
            })
            .expect("run");
        rgba(&mut runner, technique.frame())
    };
    let on = texture_at(4.0 / 7.0, LevelBlend::Linear);
    assert!(on.iter().all(|pixel| pixel[3] == 255), "the square fills the picture");
    let change =
        |a: usize, b: usize| (0..128).map(|y| f64::from(on[y * 128 + a][0].abs_diff(on[y * 128 + b][0]))).sum::<f64>();
    let inside = (8..56).map(|x| change(x, x + 1)).sum::<f64>() / 48.0;
    assert!(change(63, 64) < 1.6 * inside, "{} at the repeat, {inside} inside", change(63, 64));
    assert!((0..64).all(|x| change(x, x + 64) < 128.0), "it does repeat");
    let spread = |pixels: &[[u8; 4]]| deviation(pixels.iter().map(|p| f64::from(p[0])));
    let next = texture_at(5.0 / 7.0, LevelBlend::Linear);
    let level = (spread(&on) + spread(&next)) / 2.0;
    let linear = spread(&texture_at(4.5 / 7.0, LevelBlend::Linear)) / level;
    let kept = spread(&texture_at(4.5 / 7.0, LevelBlend::Contrast)) / level;
    eprintln!("between levels: {linear:.3} of the contrast, {kept:.3} kept");
    assert!(linear < 0.85 && (0.9..1.12).contains(&kept), "{linear} {kept}");
}

#[test]
fn aligned_texture_moves_as_the_picture_that_it_is_at_every_density() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let (mesh, camera) = flat_square();
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let volume = levels(&gpu, &mut runner, &[LevelSource::Strip(&texture)], &LEVELS, 2);
    let (side, moved) = (128, 37);
    let (pass, ..) = guide(&gpu, &mut runner, &mesh, &camera, &Lights::default(), (side, side));
    let mut uploads = Uploads::default();
    let technique =
        AlignedTechnique::new(&gpu.context, &mut uploads, &pass, volume, &[&trajectory], &[0]).expect("new");
    for density in [0.3, 1.0, 1.7] {
        let frame = AlignedFrame { show: Show::Texture, density, ..Default::default() };
        let mut at = |offset: f64| {
            runner
                .run(|recorder| {
                    uploads.record(recorder);
                    technique.record(recorder, &frame, &[[offset, 0.0]])
                })
                .expect("run");
            rgba(&mut runner, technique.frame())
        };
        let (before, after) = (at(0.0), at(f64::from(moved) + 0.4));
        let columns = |pixels: &[[u8; 4]], range: std::ops::Range<u32>| -> Vec<[u8; 4]> {
            let rows = 0..side;
            rows.flat_map(|y| range.clone().map(move |x| y * side + x)).map(|i| pixels[i as usize]).collect()
        };
        // The filter's weights may be rounded the other way.
        let off = share_off(&columns(&before, moved..side), &columns(&after, 0..side - moved), 2);
        assert!(off < 0.001, "density {density}: {off} of the pixels differ");
        assert!(share_off(&before, &after, 2) > 0.5, "density {density}: it did move");
    }
}
