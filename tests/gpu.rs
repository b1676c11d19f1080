//! The GPU layer: what validation notices, memory and lifetimes, the choice of a device, the pipeline cache, timers,
//! and what is said when something is missing.

mod common;

use ash::vk;
use common::{noise, Validated};
use impasto::gpu::{
    list_devices, Buffer, BufferKind, Context, ContextOptions, DeviceChoice, Image, ImageDesc, PipelineCacheFile,
    Runner, Uploads, Uuid,
};
use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt::{Quilt, QuiltStages, SampleTexels};
use impasto::Error;
use std::path::Path;

const SAMPLE: (u32, u32) = (40, 40);
const OUTPUT: (u32, u32) = (60, 60);
const PARAMS: QuiltParams = QuiltParams { block_px: 16, overlap_px: 4, tolerance: 0.1, seed: 3, tileable: false };

fn quilting(context: &Context, uploads: &mut Uploads) -> Quilt {
    let stages = QuiltStages::new(context);
    let sample = noise(SAMPLE.0, SAMPLE.1, 31);
    let texels = SampleTexels::new(context, uploads, &sample, SAMPLE).expect("sample");
    Quilt::new(context, uploads, &stages, &texels, OUTPUT, &PARAMS, None).expect("quilt")
}

/// Quilts and reads the canvas.
fn canvas(context: &Context, runner: &mut Runner) -> Vec<u8> {
    let mut uploads = Uploads::default();
    let quilt = quilting(context, &mut uploads);
    let run = runner.run(|recorder| {
        uploads.record(recorder);
        quilt.record(recorder, PARAMS.seed, 0);
        Ok(())
    });
    run.expect("run");
    runner.read_image(quilt.canvas()).expect("canvas")
}

// What validation notices. Silence in the other tests means something only because of these.

/// Two waves, with the barrier between the second one's search and its placing left out or not.
fn messages_of_two_waves(omit: bool) -> Vec<String> {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mut uploads = Uploads::default();
    let quilt = quilting(&gpu.context, &mut uploads);
    let run = runner.run(|recorder| {
        uploads.record(recorder);
        // Clearing, search and placing of the first wave, search of the second.
        quilt.record_part(recorder, 0..3, PARAMS.seed, 0);
        if omit {
            recorder.omit_barriers();
        }
        quilt.record_part(recorder, 3..4, PARAMS.seed, 0);
        Ok(())
    });
    run.expect("run");
    gpu.take_messages()
}

/// All layouts are right here; only the one memory dependency is missing.
#[test]
fn one_missing_barrier_is_noticed() {
    assert_eq!(messages_of_two_waves(false), Vec::<String>::new());
    let messages = messages_of_two_waves(true);
    assert!(messages.iter().all(|m| m.contains("SYNC-HAZARD")), "{messages:?}");
    for (hazard, resource) in [
        ("READ_AFTER_WRITE", "quilt errors"),
        ("READ_AFTER_WRITE", "quilt group minima"),
        ("WRITE_AFTER_READ", "quilt blocks"),
    ] {
        let named = messages.iter().any(|m| m.contains(hazard) && m.contains(resource));
        assert!(named, "no {hazard} of {resource}: {messages:?}");
    }
}

#[test]
fn a_recording_without_any_barrier_is_noticed() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    canvas(&gpu.context, &mut runner);
    let mut uploads = Uploads::default();
    let quilt = quilting(&gpu.context, &mut uploads);
    let run = runner.run(|recorder| {
        recorder.omit_barriers();
        uploads.record(recorder);
        quilt.record(recorder, PARAMS.seed, 0);
        Ok(())
    });
    run.expect("run");
    let messages = gpu.take_messages();
    assert!(messages.iter().any(|m| m.contains("SYNC-HAZARD")), "no hazard: {messages:?}");
    assert!(messages.iter().any(|m| m.contains("layout")), "no wrong layout: {messages:?}");
}

// Memory and lifetimes.

#[test]
fn all_memory_comes_back() {
    let gpu = Validated::new();
    let context = &gpu.context;
    assert_eq!(context.allocated_bytes(), 0);
    let buffer = Buffer::new(context, "buffer", BufferKind::Storage, 5000).expect("a buffer");
    let one = context.allocated_bytes();
    assert!(one >= 5000);
    let clone = buffer.clone();
    drop(buffer);
    context.advance(2, 1);
    assert_eq!(context.allocated_bytes(), one, "a clone still holds it");
    drop(clone);
    context.advance(3, 1);
    assert_eq!(context.allocated_bytes(), one, "it was dropped in frame 2");
    context.advance(4, 2);
    assert_eq!(context.allocated_bytes(), 0);

    let mut runner = gpu.runner();
    canvas(context, &mut runner);
    drop(runner);
    context.advance(100, 99);
    assert_eq!(context.allocated_bytes(), 0);
}

#[test]
fn the_budget_is_kept_and_what_broke_it_is_named() {
    let gpu = Validated::with(ContextOptions { memory_budget: Some(1 << 20), ..Default::default() });
    let context = &gpu.context;
    let kept = Buffer::new(context, "first", BufferKind::Storage, 700_000).expect("it fits");
    match Buffer::new(context, "second", BufferKind::Storage, 400_000).map(|_| ()) {
        Err(Error::Memory { what, needed, available }) => {
            assert_eq!(what, "second");
            assert!(needed >= 400_000 && available <= (1 << 20) - 700_000, "{needed} {available}");
        }
        other => panic!("over the budget: {other:?}"),
    }
    let desc = ImageDesc::storage_2d(512, 512, vk::Format::R32_UINT);
    let error = Image::new(context, "a picture", &desc).map(|_| ()).expect_err("over the budget");
    assert!(error.to_string().starts_with("a picture needs "), "{error}");
    // What failed has left nothing behind, and what was freed can be had again.
    drop(kept);
    context.advance(2, 1);
    assert_eq!(context.allocated_bytes(), 0);
    Buffer::new(context, "third", BufferKind::Storage, 1_000_000).expect("it fits now");

    let mut uploads = Uploads::default();
    let stages = QuiltStages::new(context);
    context.advance(4, 3);
    let sample = noise(500, 500, 1);
    let error = SampleTexels::new(context, &mut uploads, &sample, (500, 500)).map(|_| ()).expect_err("2 MB");
    assert!(matches!(error, Error::Memory { .. }), "{error}");
    let small = SampleTexels::new(context, &mut uploads, &sample[..6400], (80, 80)).expect("26 kB");
    let quilt = Quilt::new(context, &mut uploads, &stages, &small, (700, 700), &PARAMS, None);
    assert!(matches!(quilt, Err(Error::Memory { .. })), "a canvas of 2 MB");
}

#[test]
fn sizes_beyond_the_devices_limits_are_refused() {
    let gpu = Validated::new();
    let (context, caps) = (&gpu.context, gpu.context.caps().clone());
    let most = caps.max_image_2d_px;
    let most_3d = caps.max_image_3d_px;
    let refused = [
        [0, 8, 1],
        [8, 0, 1],
        [8, 8, 0],
        [most + 1, 1, 1],
        [1, most + 1, 1],
        [u32::MAX, u32::MAX, 1],
        [8, 8, most_3d + 1],
        [most_3d + 1, 8, 2],
        [8, most_3d + 1, 2],
    ];
    for size_px in refused {
        let desc = ImageDesc { size_px, ..ImageDesc::storage_2d(1, 1, vk::Format::R32_UINT) };
        let error = Image::new(context, "odd", &desc).map(|_| ()).expect_err("an impossible size");
        assert!(matches!(error, Error::Parameter { .. }), "{size_px:?}: {error}");
    }
    for size_px in [[most, 1, 1], [1, 1, 1], [3, 2, 5]] {
        let desc = ImageDesc { size_px, ..ImageDesc::storage_2d(1, 1, vk::Format::R32_UINT) };
        assert_eq!(Image::new(context, "fits", &desc).expect("it fits").size_px(), size_px);
    }
    for bytes in [caps.max_storage_buffer_bytes + 1, u64::MAX] {
        let error = Buffer::new(context, "errors", BufferKind::Storage, bytes).map(|_| ()).expect_err("too large");
        let text = error.to_string();
        assert!(matches!(error, Error::Device(_)), "{text}");
        assert!(text.contains("errors") && text.contains(&caps.max_storage_buffer_bytes.to_string()), "{text}");
    }
    for kind in [BufferKind::Upload, BufferKind::Readback, BufferKind::Geometry] {
        let error = Buffer::new(context, "huge", kind, 1 << 40).map(|_| ()).expect_err("a terabyte");
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }
    assert_eq!(Buffer::new(context, "empty", BufferKind::Storage, 0).expect("a buffer").bytes(), 4);
}

// Devices.

#[test]
fn devices_are_listed_and_chosen() {
    let devices = list_devices().expect("devices");
    let first = devices.first().expect("a device").clone();
    for choice in [
        DeviceChoice::Index(first.index),
        DeviceChoice::Uuid(first.uuid),
        DeviceChoice::Name(first.name.to_uppercase()),
    ] {
        let gpu = Validated::with(ContextOptions { device: choice, ..Default::default() });
        assert_eq!(gpu.context.device_info(), &first);
    }
    for (choice, wanted) in [
        (DeviceChoice::Index(99), "device 99"),
        (DeviceChoice::Name("GeForce 256".to_owned()), "\"GeForce 256\""),
        (DeviceChoice::Uuid(Uuid([0xab; 16])), "abababab-abab-abab-abab-abababababab"),
    ] {
        let options = ContextOptions { device: choice, ..Default::default() };
        let error = Context::new(&options).map(|_| ()).expect_err("no such device").to_string();
        assert!(error.contains(wanted) && error.contains(&first.name), "{error}");
    }
}

#[test]
fn child_asks_for_a_context() {
    if !common::is_child() {
        return;
    }
    let validation = std::env::var_os("IMPASTO_TEST_VALIDATION").is_some();
    match Context::new(&ContextOptions { validation, ..Default::default() }) {
        Ok(_) => println!("context: fine"),
        Err(error) => println!("context: {error} ({error:?})"),
    }
    match list_devices() {
        Ok(devices) => println!("list: {}", devices.len()),
        Err(error) => println!("list: {error}"),
    }
}

#[test]
fn what_is_missing_is_said() {
    let empty = tempfile::tempdir().expect("a folder");
    let folder = empty.path().to_str().expect("a name");
    let child = |environment: &[(&str, &str)]| {
        let output = common::run_child("child_asks_for_a_context", environment);
        let line = |word: &str| {
            let found = output.lines().find_map(|line| line.split_once(word).map(|(_, rest)| rest.to_owned()));
            found.unwrap_or_else(|| panic!("no line with {word} in {output}"))
        };
        (line("context: "), line("list: "))
    };
    assert_eq!(child(&[("IMPASTO_TEST_VALIDATION", "1")]).0, "fine");

    let no_layer = [("IMPASTO_TEST_VALIDATION", "1"), ("VK_LAYER_PATH", folder)];
    let (context, list) = child(&no_layer);
    assert!(context.contains("VK_LAYER_KHRONOS_validation is not installed"), "{context}");
    assert_ne!(list, "0");

    let no_driver = [("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")];
    let (context, list) = child(&no_driver);
    assert!(context.contains("no Vulkan driver") && context.contains("Device("), "{context}");
    assert!(list.contains("no Vulkan driver"), "{list}");

    // A file that is no library stands before the loader's.
    std::fs::write(empty.path().join("libvulkan.so.1"), "").expect("a file");
    let (context, list) = child(&[("LD_LIBRARY_PATH", folder)]);
    assert!(context.contains("no Vulkan loader") && list.contains("no Vulkan loader"), "{context}; {list}");
}

// The pipeline cache.

fn with_cache(dir: &Path) -> Validated {
    Validated::with(ContextOptions { pipeline_cache_dir: Some(dir.to_owned()), ..Default::default() })
}

#[test]
fn the_pipeline_cache_is_kept_and_damage_is_ignored() {
    let dir = tempfile::tempdir().expect("a folder");
    // A folder that does not exist yet.
    let dir = dir.path().join("some/cache");
    let gpu = with_cache(&dir);
    let file = PipelineCacheFile::new(&dir, gpu.context.caps());
    assert_eq!(file.load(), None);
    QuiltStages::new(&gpu.context);
    drop(gpu);
    let good = std::fs::read(file.path()).expect("it was written");
    let data = file.load().expect("it is whole");
    assert!(good.ends_with(&data) && data.len() >= 32);
    assert_eq!(std::fs::read_dir(&dir).expect("the folder").count(), 1, "nothing else is left there");

    // The sum over the data, as the file's head holds it: FNV-1a.
    let sum = |data: &[u8]| {
        let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        data.iter().fold(0xcbf2_9ce4_8422_2325, step).to_le_bytes()
    };
    assert_eq!(good[8..16], sum(&data), "the sum of the unharmed data");
    let mut damaged: Vec<(String, Vec<u8>)> = Vec::new();
    for length in [0, 1, 8, 15, 16, 20, 31, 32, 47, good.len() - 1] {
        damaged.push((format!("cut to {length}"), good[..length.min(good.len() - 1)].to_vec()));
    }
    for at in (0..48).chain([good.len() - 1]) {
        let mut file = good.clone();
        file[at] ^= 0x10;
        damaged.push((format!("byte {at} changed"), file));
    }
    // Another device's or driver's cache, unharmed in itself.
    for (at, what) in [(4, "version"), (8, "vendor"), (12, "device"), (16, "UUID"), (31, "UUID's end")] {
        let mut foreign = data.clone();
        foreign[at] ^= 1;
        let file = [&good[..8], &sum(&foreign)[..], &foreign[..]].concat();
        damaged.push((format!("another {what}"), file));
    }
    damaged.push(("something after it".to_owned(), [&good[..], &[0]].concat()));
    damaged.push(("another kind of file".to_owned(), b"\x89PNG\r\n\x1a\n and so on, and so on, and so on".to_vec()));
    for (what, bytes) in &damaged {
        std::fs::write(file.path(), bytes).expect("write");
        assert_eq!(file.load(), None, "{what}");
    }
    // A whole start and end with some of them; no message comes, and a good file stands there again afterwards.
    for (what, bytes) in damaged.iter().step_by(9).chain(damaged.iter().rev().take(7)) {
        std::fs::write(file.path(), bytes).expect("write");
        let gpu = with_cache(&dir);
        QuiltStages::new(&gpu.context);
        drop(gpu);
        assert!(file.load().is_some(), "{what}: no new file was written");
    }

    // A file larger than any cache is not even read, and a folder in its place is left alone.
    std::fs::write(file.path(), &good).expect("write");
    std::fs::OpenOptions::new().write(true).open(file.path()).and_then(|f| f.set_len(65 << 20)).expect("a large file");
    assert_eq!(file.load(), None);
    std::fs::remove_file(file.path()).expect("remove");
    std::fs::create_dir(file.path()).expect("a folder");
    drop(with_cache(&dir));
    assert!(file.path().is_dir());
    assert_eq!(std::fs::read_dir(&dir).expect("the folder").count(), 1, "a temporary file is left");
}

// Timers and threads.

#[test]
fn passes_are_timed_by_name() {
    let gpu = Validated::new();
    let mut runner = gpu.runner();
    let mut uploads = Uploads::default();
    let quilt = quilting(&gpu.context, &mut uploads);
    // Sample, its squares, blocks and order.
    let uploaded = 4;
    let waves = quilt.layout().waves.len() as u32;
    for round in 0..2 {
        let run = runner.run(|recorder| {
            uploads.record(recorder);
            quilt.record(recorder, PARAMS.seed, round);
            Ok(())
        });
        run.expect("run");
    }
    let times = runner.take_times();
    let counts: Vec<_> = times.iter().map(|time| (time.name, time.count)).collect();
    let expected = [
        ("upload", uploaded),
        ("quilt_clear", 2),
        ("quilt_guide", 2),
        ("quilt_search", 2 * waves),
        ("quilt_place", 2 * waves),
    ];
    assert_eq!(counts, expected);
    let search = times.iter().find(|time| time.name == "quilt_search").expect("it is there");
    assert!(search.total_ns > 1000 && search.total_ns < 60_000_000_000, "{search:?}");
    assert!(runner.take_times().is_empty(), "taken times are forgotten");
}

#[test]
fn contexts_in_two_threads_do_not_disturb_each_other() {
    let alone = {
        let gpu = Validated::new();
        canvas(&gpu.context, &mut gpu.runner())
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..2)
            .map(|_| {
                scope.spawn(|| {
                    let gpu = Validated::new();
                    let mut runner = gpu.runner();
                    (0..4).map(|_| canvas(&gpu.context, &mut runner)).collect::<Vec<_>>()
                })
            })
            .collect();
        for thread in threads {
            for got in thread.join().expect("no panic") {
                assert!(got == alone, "the canvas differs");
            }
        }
    });
}
