//! A run made up by hand, with every field filled, for tests.

use super::results::*;
use std::collections::BTreeMap;

/// Two devices, all kinds of measurement; one result of the second device is wrong, and its name is hard to write.
pub fn example() -> Results {
    let numbers = [("frames".to_owned(), 200.0), ("warm_up_frames".to_owned(), 20.0)];
    Results {
        schema: SCHEMA,
        tool: Tool {
            name: "impasto".into(),
            version: "0.1.0".into(),
            commit: Some("1234abc+".into()),
            profile: "release".into(),
        },
        started: "2025-11-26T08:17:00Z".into(),
        seconds: 93.25,
        system: System {
            os: "Debian GNU/Linux 12 (bookworm), linux 6.1.0".into(),
            arch: "x86_64".into(),
            cpu: Some("A Processor | at 3 GHz".into()),
            cores: 8,
        },
        parameters: Parameters { set: "quick".into(), seed: 1, numbers: BTreeMap::from(numbers) },
        devices: vec![device(0, "A Fast GPU", 1.0), device(1, "A <Slow> \"GPU\", | old", 2.5)],
    }
}

fn device(index: usize, name: &str, slow: f64) -> DeviceResults {
    let mut measurements = Vec::new();
    for (technique, factor) in [("image", 4.0), ("aligned", 1.0)] {
        for (width, height) in [(640, 360), (1280, 720), (1920, 1080)] {
            let ms = f64::from(width * height) * 1e-6 * factor * slow;
            measurements.push(frame(Kind::Frame, technique, [width, height], vec![ms * 1.25, ms, ms * 0.9]));
        }
    }
    let settling = (0..1000).map(|frame| slow * (4.0 + (-f64::from(frame) / 150.0).exp() * f64::from(frame % 3)));
    measurements.push(frame(Kind::Sustained, "image", [1280, 720], settling.collect()));
    for in_flight in 1..=3 {
        let rate = 100.0 * f64::from(in_flight).sqrt() / slow;
        let mut one = frame(Kind::Throughput, "image", [512, 512], vec![rate, rate * 1.01]);
        one.id += &format!("/{in_flight}");
        one.in_flight = Some(in_flight);
        measurements.push(rated(one, "frames/s"));
    }
    let mut synthesis = frame(Kind::Synthesis, "image", [512, 512], vec![25_000.0 / slow, 26_000.0 / slow]);
    (synthesis.technique, synthesis.scene, synthesis.motion) = (None, None, None);
    synthesis.id = "synthesis/512x512".into();
    measurements.push(rated(synthesis, "blocks/s"));
    measurements.push(frame(Kind::Preparation, "aligned", [1280, 720], vec![310.0 * slow]));
    if slow > 1.0 {
        measurements[0].check.verdict = "bytes change from round to round | twice".into();
    }
    let failed = FailedMeasurement {
        id: "frame/image/head/cut/3840x2160".into(),
        error: "canvas needs 5 bytes, but 4 | are left".into(),
    };
    DeviceResults {
        device: Device {
            index,
            name: name.into(),
            kind: "discrete".into(),
            uuid: format!("0000-{index}"),
            pci: Some(format!("0000:0{index}:00.0")),
            vendor_id: 0x10de,
            device_id: 0x2330,
            api_version: "1.3.280".into(),
            driver_version: 7,
            driver_name: Some("a driver".into()),
            driver_info: Some("1.2.3".into()),
        },
        open_ms: 120.0,
        compile_ms: BTreeMap::from([("image".to_owned(), 30.5), ("aligned".to_owned(), 12.25)]),
        measurements,
        failures: if slow > 1.0 { vec![failed] } else { Vec::new() },
        error: (slow > 1.0).then(|| "the device was lost".to_owned()),
    }
}

fn frame(kind: Kind, technique: &str, size_px: [u32; 2], raw: Vec<f64>) -> Measurement {
    let word = format!("{kind:?}").to_lowercase();
    // Numbers of few digits are the same when they are read again.
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let wall = raw.iter().map(|value| rounded(value + 0.5)).collect();
    let raw: Vec<f64> = raw.into_iter().map(rounded).collect();
    Measurement {
        id: format!("{word}/{technique}/head/light-orbit/{}x{}", size_px[0], size_px[1]),
        kind,
        technique: Some(technique.into()),
        scene: Some("head".into()),
        motion: Some("light-orbit".into()),
        size_px,
        in_flight: None,
        unit: "ms".into(),
        more_is_better: false,
        // Rounds of ten.
        round_p50: raw.chunks(10).filter_map(|round| Samples::of(round.to_vec())).map(|round| round.p50).collect(),
        gpu: Samples::of(raw),
        wall: Samples::of(wall),
        memory_bytes: 48 << 20,
        check: Check { hash: "00ff".into(), verdict: "ok".into() },
        telemetry: Some(Telemetry {
            core_mhz: Some(1980.0),
            memory_mhz: Some(2619.0),
            celsius: Some(41.0),
            watts: Some(305.5),
        }),
    }
}

fn rated(one: Measurement, unit: &str) -> Measurement {
    Measurement { unit: unit.into(), more_is_better: true, wall: one.gpu, gpu: None, ..one }
}
