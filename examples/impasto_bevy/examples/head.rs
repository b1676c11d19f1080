//! A painted head and a painted ball among Bevy's own things, without a window: writes pictures, and checks them.
//!
//! `cargo run --example head -- OUT_DIR [--validate]`. A blue post stands before the head and must hide paint; a red
//! one stands behind it and must be hidden; a ring around it does both. The exit status is 1 when something is not
//! as it must be, or, with `--validate`, when Vulkan's validation layer has said anything.

#[path = "head/checks.rs"]
mod checks;
#[path = "head/messages.rs"]
mod messages;

use bevy::app::ScheduleRunnerPlugin;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::render::settings::{Backends, InstanceFlags, WgpuSettings};
use bevy::window::{ExitCondition, WindowPlugin};
use checks::{Picture, SIZE_PX};
use impasto_bevy::impasto::embed::Method;
use impasto_bevy::impasto::paint::PaintSample;
use impasto_bevy::impasto::scene;
use impasto_bevy::impasto::synthesis::params::QuiltParams;
use impasto_bevy::impasto::technique::ShadeRange;
use impasto_bevy::impasto::technique::aligned::{AlignedFrame, LevelParams};
use impasto_bevy::impasto::technique::object::ObjectParams;
use impasto_bevy::{ImpastoPlugin, Painted};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A preparation that takes longer than this is stuck.
const PATIENCE: Duration = Duration::from_secs(300);
/// From where the scene is seen, degrees around it.
const ANGLES: [f32; 5] = [-16.0, -8.0, 0.0, 8.0, 16.0];
/// Until meshes and pipelines are there.
const FIRST_FRAME: u32 = 5;

fn main() -> AppExit {
    let (flags, folders): (Vec<_>, Vec<_>) = std::env::args_os().skip(1).partition(|word| word == "--validate");
    let out = PathBuf::from(folders.into_iter().next().unwrap_or_else(|| "out".into()));
    if let Err(error) = std::fs::create_dir_all(&out) {
        eprintln!("{}: {error}", out.display());
        return AppExit::error();
    }
    let no_window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let log = LogPlugin { custom_layer: messages::layer, filter: messages::FILTER.to_owned(), ..default() };
    let instance_flags = if flags.is_empty() { InstanceFlags::empty() } else { InstanceFlags::debugging() };
    let settings = WgpuSettings { backends: Some(Backends::VULKAN), instance_flags, ..default() };
    // So that the first frame shows everything.
    let render = RenderPlugin { synchronous_pipeline_compilation: true, render_creation: settings.into(), ..default() };
    let exit = App::new()
        .add_plugins(DefaultPlugins.set(no_window).set(log).set(render))
        .add_plugins(ScheduleRunnerPlugin::run_loop(Duration::ZERO))
        .add_plugins(ImpastoPlugin::default())
        .insert_resource(ClearColor(Color::srgb(0.86, 0.84, 0.80)))
        .insert_resource(Film::new(out))
        .add_systems(Startup, build)
        .add_systems(Update, direct)
        .run();
    // The device is gone now, which is when the layer tells of what is left.
    let messages = messages::taken();
    messages.iter().for_each(|message| eprintln!("{message}"));
    if messages.is_empty() { exit } else { AppExit::error() }
}

/// What takes long to be prepared.
#[derive(Component)]
struct Head;

/// What does not.
#[derive(Component)]
struct Ball;

fn build(
    mut commands: Commands,
    mut film: ResMut<Film>,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) -> Result {
    let assets = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets"));
    let model = scene::Mesh::load(assets.join("head.obj"), &scene::MeshOptions::default())?.mesh;
    let strip = PaintSample::load(assets.join("strip_green_yellow.png"))?;
    let quilt = QuiltParams { block_px: 24, ..QuiltParams::default() };
    let levels = LevelParams { size_px: 256, quilt, ..LevelParams::default() };
    let method = Method::Aligned { levels, frame: AlignedFrame::default(), follow: true };
    // The model is 21 high.
    let place = Transform::from_xyz(0.0, 0.5, 0.0).with_scale(Vec3::splat(0.1));
    commands.spawn((Painted::new(model, &strip, method)?, Head, place));

    // A mesh of Bevy's, with another paint, by the technique that is there at once.
    let ball = impasto_bevy::mesh(&Sphere::new(0.6).mesh().uv(48, 24))?;
    let other = PaintSample::load(assets.join("strip_red_yellow.png"))?;
    let method = Method::Object { params: ObjectParams::default(), range: ShadeRange::default() };
    commands.spawn((Painted::new(ball, &other, method)?, Ball, Transform::from_xyz(1.0, 0.6, -0.6)));
    film.palette = Some(checks::Palette::new(&[strip, other]));

    let mut thing = |mesh: Mesh, color: Color, place: Transform| {
        let material = StandardMaterial { base_color: color, perceptual_roughness: 0.9, ..default() };
        commands.spawn((Mesh3d(meshes.add(mesh)), MeshMaterial3d(materials.add(material)), place));
    };
    let post = |width, height| Cuboid::new(width, height, width).into();
    let grey = Color::srgb(0.45, 0.43, 0.45);
    thing(Plane3d::new(Vec3::Y, Vec2::splat(4.0)).into(), Color::srgb(0.62, 0.60, 0.56), Transform::IDENTITY);
    thing(Cuboid::new(1.0, 0.5, 1.2).into(), grey, Transform::from_xyz(0.0, 0.25, 0.3));
    thing(post(0.16, 2.4), Color::srgb(0.10, 0.25, 0.75), Transform::from_xyz(0.35, 1.2, 1.4));
    thing(post(0.4, 3.2), Color::srgb(0.75, 0.12, 0.10), Transform::from_xyz(-0.4, 1.6, -1.4));
    let ring = Transform::from_xyz(0.0, 1.8, 0.0).with_rotation(Quat::from_rotation_z(0.3));
    thing(Torus::new(1.1, 1.2).into(), grey, ring);

    let light = Transform::from_xyz(-8.0, 5.0, 3.5).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight { illuminance: 8_000.0, ..default() }, light));
    let mut target = Image::new_target_texture(SIZE_PX, SIZE_PX, TextureFormat::Rgba8UnormSrgb, None);
    target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    film.target = images.add(target);
    let target = RenderTarget::Image(film.target.clone().into());
    // The paint's colours stay as they are; Bevy's other things are drawn without a curve, too.
    commands.spawn((Camera3d::default(), target, Msaa::Off, Tonemapping::None));
    Ok(())
}

/// A picture to be taken.
#[derive(Clone, Copy, PartialEq)]
struct Shot {
    angle: usize,
    /// Of the head, degrees.
    turn: f32,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Stage {
    /// The head is there, but nothing of it can be seen yet; the ball is hidden.
    Unready,
    /// Both are hidden.
    Hidden,
    Painted,
    /// Both have been taken away, in the middle of the last picture's frames.
    Gone,
}

#[derive(Resource)]
struct Film {
    out: PathBuf,
    target: Handle<Image>,
    shots: VecDeque<Shot>,
    taken: Vec<(Shot, Picture)>,
    /// The picture that is on its way.
    under_way: bool,
    since: Instant,
    frames: u32,
    palette: Option<checks::Palette>,
}

impl Film {
    fn new(out: PathBuf) -> Self {
        let shot = |stage| move |angle| Shot { angle, turn: 0.0, stage };
        let mut shots = VecDeque::from([shot(Stage::Unready)(0)]);
        shots.extend((0..ANGLES.len()).map(shot(Stage::Hidden)));
        shots.extend((0..ANGLES.len()).map(shot(Stage::Painted)));
        shots.push_back(Shot { turn: 50.0, ..shot(Stage::Painted)(2) });
        shots.push_back(shot(Stage::Gone)(2));
        let (target, taken) = (Handle::default(), Vec::new());
        Film { out, target, shots, taken, under_way: false, since: Instant::now(), frames: 0, palette: None }
    }
}

/// The head, as long as it is there.
type TheHead<'w, 's> = Option<
    Single<
        'w,
        's,
        (Entity, &'static Painted, &'static mut Transform, &'static mut Visibility),
        (With<Head>, Without<Ball>),
    >,
>;

/// Takes one shot after the other. Nothing moves while a picture is on its way.
fn direct(
    mut commands: Commands,
    mut film: ResMut<Film>,
    mut exit: MessageWriter<AppExit>,
    camera: Single<&mut Transform, (With<Camera3d>, Without<Head>)>,
    head: TheHead,
    ball: Option<Single<(Entity, &mut Visibility), With<Ball>>>,
) {
    film.frames += 1;
    if film.under_way || film.frames < FIRST_FRAME {
        return;
    }
    let Some(&shot) = film.shots.front() else {
        exit.write(finish(&film));
        return;
    };
    if let (Some(head), Some(ball)) = (head, ball) {
        let ((head, painted, mut place, mut visibility), (ball, mut of_ball)) = (head.into_inner(), ball.into_inner());
        match film.wait(shot.stage, painted.progress()) {
            Ok(true) => return,
            Ok(false) => {}
            Err(fault) => {
                error!("{fault}");
                exit.write(AppExit::error());
                return;
            }
        }
        if shot.stage == Stage::Gone {
            commands.entity(head).despawn();
            commands.entity(ball).despawn();
        }
        let shown_if = |shown| if shown { Visibility::Inherited } else { Visibility::Hidden };
        *visibility = shown_if(shot.stage != Stage::Hidden);
        *of_ball = shown_if(shot.stage == Stage::Painted);
        place.rotation = Quat::from_rotation_y(shot.turn.to_radians());
    }
    let around = Quat::from_rotation_y(ANGLES[shot.angle].to_radians());
    *camera.into_inner() =
        Transform::from_translation(around * Vec3::new(0.0, 2.0, 5.2)).looking_at(Vec3::new(0.1, 1.4, 0.0), Vec3::Y);
    film.under_way = true;
    commands.spawn(Readback::texture(film.target.clone())).observe(take);
}

impl Film {
    /// Whether a picture has to wait for the preparation.
    fn wait(&self, stage: Stage, progress: f32) -> std::result::Result<bool, String> {
        let first = self.taken.last().is_some_and(|(last, _)| last.stage != Stage::Painted);
        match stage {
            Stage::Unready if progress == 1.0 => Err("ready before the first picture: nothing is proven".to_owned()),
            Stage::Painted if progress < 1.0 && self.since.elapsed() > PATIENCE => {
                Err(format!("the preparation is stuck at {progress}"))
            }
            Stage::Painted if progress < 1.0 => Ok(true),
            Stage::Painted if first => {
                info!("ready after {} frames, {:.1} s", self.frames, self.since.elapsed().as_secs_f32());
                Ok(false)
            }
            _ => Ok(false),
        }
    }
}

fn take(picture: On<ReadbackComplete>, mut commands: Commands, mut film: ResMut<Film>) {
    commands.entity(picture.entity).despawn();
    let Some(shot) = film.shots.pop_front() else { return };
    film.taken.push((shot, Picture(picture.data.clone())));
    film.under_way = false;
}

/// Writes the pictures, and says whether they are right.
fn finish(film: &Film) -> AppExit {
    info!("{} frames in {:.1} s", film.frames, film.since.elapsed().as_secs_f32());
    let mut faults = messages::taken();
    for (number, (shot, picture)) in film.taken.iter().enumerate() {
        let name = format!("{number:02}_{}.png", format!("{:?}", shot.stage).to_lowercase());
        if let Err(error) = picture.save(&film.out.join(name)) {
            faults.push(error.to_string());
        }
    }
    let Some(palette) = &film.palette else { return AppExit::error() };
    let plain = |angle| film.taken.iter().find(|(shot, _)| (shot.angle, shot.stage) == (angle, Stage::Hidden));
    for (shot, picture) in &film.taken {
        let Some((_, plain)) = plain(shot.angle) else { continue };
        match shot.stage {
            Stage::Unready if picture.0 != plain.0 => faults.push("something was seen before it was ready".to_owned()),
            Stage::Painted => faults.extend(checks::faults(plain, picture, palette, shot.angle)),
            Stage::Gone if picture.0 != plain.0 => faults.push("something is left of what was taken away".to_owned()),
            _ => {}
        }
    }
    for fault in &faults {
        error!("{fault}");
    }
    if !faults.is_empty() {
        return AppExit::error();
    }
    info!("all checks passed; the pictures are in {}", film.out.display());
    AppExit::Success
}
