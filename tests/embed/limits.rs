//! Sizes at the ends of what may be asked for: an answer in words, or a picture.

use super::*;

/// A mesh of many objects: a triangle each, in a grid.
fn crowd(objects: usize) -> Arc<Mesh> {
    use std::fmt::Write;
    let (mut text, across) = (String::new(), 256);
    for number in 0..objects {
        let (x, y, first) = (number % across, number / across, 3 * number);
        write!(text, "o {number}\nv {x} {y} 0\nv {} {y} 0\nv {x} {} 0\n", x + 1, y + 1).expect("text");
        writeln!(text, "f {} {} {}", first + 1, first + 2, first + 3).expect("text");
    }
    Arc::new(Mesh::parse(text.as_bytes(), "crowd.obj", &MeshOptions::default()).expect("a mesh").mesh)
}

#[test]
fn as_many_objects_as_may_be_move_each_by_itself() {
    let (host, mesh) = (Host::new(), crowd(65_535));
    let context = borrow(&host);
    let mut frame = 0;
    let pose = |object: usize| Pose::new(0.0, Vec3::Y, Vec3::ZERO, Vec3::Z * (object % 7) as f32).expect("a pose");
    let moment = Moment { poses: (0..65_535).map(pose).collect(), ..moment(&mesh, 0) };
    // All but the last: looking through views takes longer than a test may.
    for (name, method) in methods().into_iter().take(4) {
        let desc = desc(&mesh, &method);
        let told = Effect::memory(&context, &desc).expect("needs");
        let mut effect = ready(&host, &context, desc, &mut frame);
        let painted = picture(&host, &context, &mut effect, &EffectFrame::next(&moment));
        assert!(painted.chunks(4).filter(|pixel| pixel[3] == 255).count() > 500, "{name}");
        frame += 2;
        context.advance(frame, frame - 1);
        let kept = context.allocated_bytes();
        assert_eq!(kept, told.persistent_bytes, "{name}");
        drop(effect);
        frame += 2;
        context.advance(frame, frame - 1);
    }
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn what_is_too_large_is_told_in_words() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let most = context.caps().max_image_2d_px;
    let told = |desc: EffectDesc| match Effect::memory(&context, &desc) {
        Ok(needs) => format!("{needs:?}"),
        Err(error) => error.to_string(),
    };
    let says = |desc: EffectDesc, words: &[&str]| {
        let told = told(desc);
        assert!(words.iter().any(|word| told.contains(word)), "{told}");
    };
    let grey = TextureDifference::from_pixels(16, 16, vec![[0.0; 3]; 256]).expect("a difference");
    let small = EffectPaint { texture: grey, trajectory: paint().trajectory };
    let many = most as usize + 1;
    for (name, method) in methods() {
        let of = |size_px| EffectDesc { size_px, ..desc(&mesh, &method) };
        // Too much memory, too many blocks, or as much as a device may have; too wide and too high for any camera.
        says(of((most, most)), &["bytes", "number of blocks"]);
        says(of((most, 1)), &["100 times"]);
        says(of((1, most)), &["100 times"]);
        says(of((1, 1)), &["persistent_bytes"]);
        says(of((u32::MAX, u32::MAX)), &["size_px", "output width"]);
        says(of((most + 1, most)), &["size_px", "output width"]);
        says(EffectDesc { paints: vec![small.clone(); 65_536], ..desc(&mesh, &method) }, &["paints"]);
        if name == "object" {
            says(EffectDesc { paints: vec![small.clone(); many], ..desc(&mesh, &method) }, &["at most"]);
        }
        if let Method::Dependent { views, lights, params, .. } = &method {
            let of = |views: Vec<View>, view_px| {
                desc(&mesh, &Method::Dependent { views, view_px, lights: lights.clone(), params: *params })
            };
            says(of(views.clone(), 4096), &["bytes"]);
            let early = |views: Vec<View>, view_px, word: &str| {
                let error = of(views, view_px).check().expect_err(word).to_string();
                assert!(error.contains(word), "{error}");
            };
            early(views.clone(), 4097, "view_px");
            early(views.clone(), 0, "view_px");
            early(Vec::new(), 512, "views");
            early(vec![views[0]; 65], 512, "views");
        }
    }
    drop(context);
    assert_silent(&host.destroy());
}
