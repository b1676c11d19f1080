//! Object-based texture mapping (chapter 5).

use super::*;

/// The technique, its frame and whatever else a test looks at.
fn object_frame(
    gpu: &Validated,
    runner: &mut Runner,
    mesh: &Mesh,
    paints: &[Paint<'_>],
    of_object: &[u32],
    params: &ObjectParams,
    shots: &[(Lights, Show)],
) -> Vec<Vec<[u8; 4]>> {
    let camera = Camera::framing(mesh, &Framing::default(), 1.0).expect("a camera");
    let mut uploads = Uploads::default();
    let technique =
        ObjectTechnique::new(&gpu.context, &mut uploads, mesh, (200, 200), paints, of_object, params).expect("new");
    shots
        .iter()
        .map(|(lights, show)| {
            runner
                .run(|recorder| {
                    uploads.record(recorder);
                    technique.record(recorder, &Moment::at_rest(camera, lights.clone()), ShadeRange::default(), *show)
                })
                .expect("run");
            rgba(runner, technique.frame())
        })
        .collect()
}

#[test]
fn object_colour_follows_light_and_texture_stays_on_its_lines() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("head.obj");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let (_, trajectory) = strip("strip_green_yellow.png");
    // A texture that depends on the row alone does not see the light.
    let rows = (0..64 * 32).map(|i| [((i / 64) as f32 * std::f32::consts::TAU / 32.0).sin() * 0.4; 3]).collect();
    let striped = TextureDifference::from_pixels(64, 32, rows).expect("a difference");
    let lights = [Lights::default(), DirectionalLight::new(Vec3::new(0.7, 0.2, 0.6), 1.0).expect("a light").into()];
    let paints = [Paint { texture: &striped, trajectory: &trajectory }];
    let params = ObjectParams { keep_paint: false, repeat: StripRepeat::Mirror, ..Default::default() };
    let shots: Vec<_> = lights.iter().flat_map(|l| [(l.clone(), Show::Color), (l.clone(), Show::Texture)]).collect();
    let frames = object_frame(&gpu, &mut runner, &mesh, &paints, &[0], &params, &shots);
    for (lights, frame) in lights.iter().zip([&frames[0], &frames[2]]) {
        let (_, shade, id) = guide(&gpu, &mut runner, &mesh, &camera, lights, (200, 200));
        let want = coloured(&trajectory, &shade, &id);
        let off = share_off(frame, &want, 2);
        assert!(off < 0.003, "{off} of the colours are off");
    }
    assert!(share_off(&frames[0], &frames[2], 20) > 0.2, "the light has moved");
    assert!(share_off(&frames[1], &frames[3], 2) < 0.003, "t has not");
    let texture = |frame: &[[u8; 4]]| deviation(frame.iter().filter(|p| p[3] == 255).map(|p| f64::from(p[0])));
    assert!(texture(&frames[1]) > 20.0, "there are stripes");
    assert_golden_object(&gpu, &mut runner, &mesh);
}

fn assert_golden_object(gpu: &Validated, runner: &mut Runner, mesh: &Mesh) {
    let (texture, trajectory) = strip("strip_red_yellow.png");
    let paints = [Paint { texture: &texture, trajectory: &trajectory }];
    let shots = [(Lights::default(), Show::Painted)];
    let frame = &object_frame(gpu, runner, mesh, &paints, &[0], &ObjectParams::default(), &shots)[0];
    assert_golden("object_head", frame, (200, 200), 0.03);
    let mut planted = frame.clone();
    planted.iter_mut().for_each(|pixel| pixel[0] = 255 - pixel[0]);
    if std::env::var_os("IMPASTO_BLESS").is_none() {
        assert!(std::panic::catch_unwind(|| assert_golden("object_head", &planted, (200, 200), 0.03)).is_err());
    }
}

#[test]
fn object_paint_is_lost_on_the_table_unless_it_is_kept() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mesh = model("teapot_on_table.obj");
    let camera = Camera::framing(&mesh, &Framing::default(), 1.0).expect("a camera");
    let (_, _, id) = guide(&gpu, &mut runner, &mesh, &camera, &Lights::default(), (200, 200));
    let table = mesh.object_index("table").expect("a table") as u32 + 1;
    let strips = [strip("strip_green_yellow.png"), strip("strip_dark_red.png")];
    let paints = strips.each_ref().map(|(texture, trajectory)| Paint { texture, trajectory });
    let spread = |frame: &[[u8; 4]]| {
        deviation(frame.iter().zip(&id).filter(|(p, id)| **id == table && p[3] == 255).map(|(p, _)| f64::from(p[1])))
    };
    let shots = [(Lights::default(), Show::Texture)];
    let mut draw = |keep_paint| {
        // A little of variation must not save it.
        let coordinates = CoordinateParams { variation: 0.0, ..Default::default() };
        let params = ObjectParams { keep_paint, coordinates, ..Default::default() };
        object_frame(&gpu, &mut runner, &mesh, &paints, &[0, 1], &params, &shots).remove(0)
    };
    let (lost, kept) = (spread(&draw(false)), spread(&draw(true)));
    eprintln!("texture on the table: {lost:.2} lost, {kept:.2} kept");
    assert!(lost < 0.5, "one texel spreads over the table, but its texture has {lost}");
    assert!(kept > 3.0, "the table keeps some texture, but it is {kept}");
}
