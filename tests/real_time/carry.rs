//! Texture that stays on the faces while the view turns (chapter 8).

use super::dependent::{blended, hit};
use super::*;
use glam::{DQuat, DVec3};
use impasto::metric::Motion;
use impasto::scene::GuideOracle;
use impasto::technique::dependent::Carry;

const SIZE: (u32, u32) = (240, 180);

/// A model with its textures ready, and a runner.
struct Shot {
    runner: Runner,
    mesh: Mesh,
    covered: Covered,
    technique: DependentTechnique,
}

impl Shot {
    fn new(model_name: &str, texture: &TextureDifference, follow_deg: f32) -> Self {
        let gpu = Validated::new();
        let mut runner = gpu.runner();
        let mesh = model(model_name);
        let covered = ViewCoverage::run(&gpu.context, &mut runner, &mesh, &default_views(), 512).expect("covered");
        let (_, trajectory) = strip("strip_dark_red.png");
        let paints = [Paint { texture, trajectory: &trajectory }];
        let params = DependentParams { k: Some(0.5), follow_deg, ..Default::default() };
        let of_object = vec![0; mesh.objects().len()];
        let technique = dependent_technique(&gpu, &mut runner, &mesh, &covered, SIZE, &paints, &of_object, &params);
        for part in technique.preparation_parts(400_000_000) {
            runner.run(|recorder| technique.record_preparation(recorder, &part, 1)).expect("run");
        }
        Shot { runner, mesh, covered, technique }
    }

    fn moment(&self, yaw_deg: f32, pitch_deg: f32) -> Moment {
        let framing = Framing { yaw_deg, pitch_deg, ..Default::default() };
        let camera = Camera::framing(&self.mesh, &framing, SIZE.0 as f32 / SIZE.1 as f32).expect("a camera");
        Moment::at_rest(camera, Lights::default())
    }

    fn carry(&mut self, moment: &Moment, carry: Carry) {
        let technique = &self.technique;
        self.runner
            .run(|recorder| {
                technique.record_carry(recorder, moment, carry);
                Ok(())
            })
            .expect("run");
    }

    fn picture(&mut self, moment: &Moment) -> Vec<[u8; 4]> {
        let technique = &self.technique;
        self.runner.run(|recorder| technique.record_picture(recorder, moment, Show::Texture)).expect("run");
        rgba(&mut self.runner, self.technique.frame())
    }

    /// The frame of a moment alone.
    fn alone(&mut self, moment: &Moment) -> Vec<[u8; 4]> {
        let technique = &self.technique;
        self.runner.run(|recorder| technique.record(recorder, moment, Show::Texture)).expect("run");
        rgba(&mut self.runner, self.technique.frame())
    }

    /// Where an object is seen from, as it has it.
    fn from(&self, moment: &Moment, object: usize) -> DVec3 {
        let eye = moment.pose(object).point_to_object(moment.camera.eye());
        (eye - self.mesh.bounding_sphere().center).as_dvec3().normalize()
    }

    /// The object that each vertex belongs to.
    fn objects(&self) -> Vec<usize> {
        let mut of_vertex = vec![0; self.mesh.positions().len()];
        for (number, object) in self.mesh.objects().iter().enumerate() {
            let indices = object.first_index as usize..(object.first_index + object.index_count) as usize;
            self.mesh.indices()[indices].iter().for_each(|vertex| of_vertex[*vertex as usize] = number);
        }
        of_vertex
    }

    /// Normals as they are kept, in steps of a 127th.
    fn normals(&self) -> Vec<DVec3> {
        let kept = |normal: &[f32; 3]| DVec3::from(normal.map(|v| f64::from((v * 127.0).round() / 127.0)));
        self.mesh.normals().iter().map(kept).collect()
    }

    /// The cosine by which each vertex is turned away from the eye.
    fn away(&self, moment: &Moment) -> Vec<f64> {
        let away = |((position, normal), object): ((&[f32; 3], DVec3), usize)| {
            let eye = moment.pose(object).point_to_object(moment.camera.eye());
            -normal.dot((eye - Vec3::from(*position)).as_dvec3().normalize())
        };
        self.mesh.positions().iter().zip(self.normals()).zip(self.objects()).map(away).collect()
    }
}

/// The direction that is carried to the next frame, in angles: `away` is that of the frame before.
fn carried(from: DVec3, to: DVec3, normal: DVec3, away: f64, follow_deg: f64) -> DVec3 {
    let hidden = (2.5 * away - 0.25).clamp(0.0, 1.0);
    let straighter = (normal.dot(to) - normal.dot(from) - 0.25).max(0.0);
    let faster = hidden.powi(2) / (1.0 - hidden.powi(2)) + 0.3 * straighter.powi(2);
    let most = 2.0 * ((follow_deg.to_radians() / 2.0).tan() + faster).atan();
    let axis = from.cross(to);
    let apart = axis.length().atan2(from.dot(to));
    if hidden == 1.0 || apart <= most {
        return to;
    }
    DQuat::from_axis_angle(axis.normalize(), most) * from
}

#[test]
fn carried_texture_equals_a_ray_at_a_time() {
    let follow_deg = 0.5;
    let mut shot = Shot::new("teapot_on_table.obj", &noise_strip(180, 90), follow_deg);
    let texels = rgba(&mut shot.runner, shot.technique.slices());
    // Around the model, faster than faces can follow, over the top, and a jump to the other side; at the end its two
    // objects turn against each other, at last before a camera at rest.
    let path = [
        (20.0, 25.0, 0.0),
        (26.0, 25.0, 0.0),
        (40.0, 30.0, 0.0),
        (60.0, 20.0, 0.0),
        (64.0, 70.0, 0.0),
        (-110.0, 20.0, 0.0),
        (-80.0, 20.0, 10.0),
        (-80.0, 20.0, 30.0),
        (-80.0, 20.0, 50.0),
    ];
    let (normals, objects) = (shot.normals(), shot.objects());
    let center = shot.mesh.bounding_sphere().center;
    let mut directions: Vec<DVec3> = Vec::new();
    let mut away: Vec<f64> = Vec::new();
    let mut stale = 0;
    for (number, (yaw_deg, pitch_deg, turn_deg)) in path.into_iter().enumerate() {
        let mut moment = shot.moment(yaw_deg, pitch_deg);
        moment.poses = [turn_deg, -turn_deg]
            .map(|turn_deg| Pose::new(turn_deg, Vec3::Y, center, 0.01 * turn_deg * Vec3::X).expect("a pose"))
            .to_vec();
        let moment = moment.fit_depth(&shot.mesh);
        let camera = moment.camera;
        let from = [0, 1].map(|object| shot.from(&moment, object));
        shot.carry(&moment, if number == 0 { Carry::Cut } else { Carry::Next });
        if number == 0 {
            directions = objects.iter().map(|object| from[*object]).collect();
        } else {
            for (vertex, direction) in directions.iter_mut().enumerate() {
                let to = from[objects[vertex]];
                *direction = carried(*direction, to, normals[vertex], away[vertex], f64::from(follow_deg));
            }
        }
        away = shot.away(&moment);

        let frame = shot.picture(&moment);
        let aspect = SIZE.0 as f32 / SIZE.1 as f32;
        let inverse = camera.view_projection(aspect).expect("a projection").inverse();
        let (mut compared, mut off) = (0, 0);
        for (x, y) in (0..SIZE.1).step_by(5).flat_map(|y| (0..SIZE.0).step_by(5).map(move |x| (x, y))) {
            let ndc = Vec3::new((x as f32 + 0.5) / SIZE.0 as f32, (y as f32 + 0.5) / SIZE.1 as f32, 0.5);
            let beyond = inverse.project_point3(2.0 * ndc - Vec3::new(1.0, 1.0, 0.5));
            let Some((object, face, point)) = hit(&shot.mesh, &moment, beyond - camera.eye()) else { continue };
            let pixel = frame[(y * SIZE.0 + x) as usize];
            let is = |from: DVec3| {
                let value = blended(&shot.covered, &texels, 512, from.as_vec3(), face, point);
                let want = [value.x, value.y, value.z].map(|v| ((0.5 + 0.5 * v).clamp(0.0, 1.0) * 255.0).round() as u8);
                want.iter().zip(&pixel).all(|(a, b)| a.abs_diff(*b) <= 4)
            };
            // Any of the three corners may be the one that counts.
            let corners = &shot.mesh.indices()[3 * face..3 * face + 3];
            compared += 1;
            off += u32::from(!corners.iter().any(|corner| is(directions[*corner as usize])));
            stale += u32::from(!is(from[object]));
        }
        eprintln!("frame {number}: {off} of {compared} off");
        assert!(compared > 150 && off * 50 < compared, "frame {number}: {off} of {compared} are off");
    }
    assert!(stale > 500, "only {stale} pixels have another texture than their frame alone would have");
}

#[test]
fn faces_that_stay_in_sight_keep_their_texture() {
    // From near, with large marks: rounding ways to pixels would be most of what is compared otherwise.
    let mut shot = Shot::new("head.obj", &strip("strip_green_yellow.png").0, 0.0);
    let near = |moment: Moment| {
        let camera = moment.camera.moved_away(0.4).expect("a camera").fit_depth(&shot.mesh);
        Moment { camera, ..moment }
    };
    let moments: Vec<Moment> = (0..=20).map(|step| near(shot.moment(1.4 * step as f32, 10.0))).collect();
    let (first, last) = (&moments[0], &moments[20]);
    let before = shot.alone(first);
    moments[1..=10].iter().chain(moments[..10].iter().rev()).for_each(|moment| shot.carry(moment, Carry::Next));
    let back = shot.picture(first);
    moments[1..].iter().for_each(|moment| shot.carry(moment, Carry::Next));
    let carried = shot.picture(last);
    let alone = shot.alone(last);

    // 14 degrees there and back: what was in sight all the time is the same to the bit.
    let painted = before.iter().filter(|pixel| pixel[3] == 255).count();
    let same = before.iter().zip(&back).filter(|(a, b)| a[3] == 255 && a == b).count();
    eprintln!("{same} of {painted} pixels are the same after there and back");
    assert!(same * 100 > painted * 99, "{same} of {painted}");

    let guides = [first, last].map(|moment| GuideOracle::render(&shot.mesh, moment, SIZE.0, SIZE.1).expect("a guide"));
    let motion = Motion::between([first, last], [&guides[0], &guides[1]]).expect("a motion");
    let change = |after: &[[u8; 4]]| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (x, y) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))) {
            let Some((to_x, to_y)) = motion.pixel(x, y) else { continue };
            let (a, b) = (before[(y * SIZE.0 + x) as usize], after[(to_y * SIZE.0 + to_x) as usize]);
            sum += (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>();
            count += 3.0;
        }
        assert!(count > 3000.0, "{count} values in both");
        sum / count
    };
    let (with, without) = (change(&carried), change(&alone));
    eprintln!("on the surface texture changes by {with:.2} carried, {without:.2} chosen anew");
    assert!(with < 0.7 * without, "{with} carried, {without} chosen anew");
}

#[test]
fn a_picture_at_rest_becomes_that_of_its_own_view_and_a_cut_is_at_once() {
    let mut shot = Shot::new("head.obj", &noise_strip(180, 90), 2.0);
    let (here, there) = (shot.moment(0.0, 10.0), shot.moment(37.0, -5.0));
    let own = shot.alone(&there);
    shot.carry(&here, Carry::Cut);
    let mut off = Vec::new();
    for _ in 0..25 {
        shot.carry(&there, Carry::Next);
        let frame = shot.picture(&there);
        off.push(share_off(&frame, &own, 0));
    }
    eprintln!("pixels that are not yet their own view's: {off:.3?}");
    assert!(off[0] > 0.1 && off[17] > 0.0, "it takes its time");
    assert_eq!(off[19..], [0.0; 6], "to the bit");
    shot.carry(&here, Carry::Next);
    assert!(shot.picture(&there) != own);
    shot.carry(&there, Carry::Cut);
    assert!(shot.picture(&there) == own, "a cut");
}

#[test]
fn carrying_needs_no_pictures_in_between_and_repeats_itself() {
    let mut shot = Shot::new("head.obj", &noise_strip(180, 90), 0.25);
    let moments: Vec<Moment> = (0..8).map(|step| shot.moment(11.0 * step as f32, 4.0 * step as f32)).collect();
    // The first frame of all follows nothing, whatever it is called.
    shot.carry(&moments[0], Carry::Next);
    let unbidden = shot.picture(&moments[0]);
    assert!(unbidden == shot.alone(&moments[0]));
    let mut frames = Vec::new();
    for draws in [true, false] {
        for (number, moment) in moments.iter().enumerate() {
            shot.carry(moment, if number == 0 { Carry::Cut } else { Carry::Next });
            if draws {
                shot.picture(moment);
            }
        }
        let last = shot.picture(&moments[7]);
        let state = shot.runner.read_image(shot.technique.carried()).expect("directions");
        frames.push((last, state));
    }
    assert!(frames[0] == frames[1]);
}

#[test]
fn following_by_half_a_turn_is_no_carrying() {
    let mut shot = Shot::new("head.obj", &noise_strip(180, 90), 180.0);
    let (here, there) = (shot.moment(0.0, 10.0), shot.moment(37.0, -5.0));
    shot.carry(&here, Carry::Cut);
    shot.carry(&there, Carry::Next);
    let carried = shot.picture(&there);
    assert!(carried == shot.alone(&there));
}
