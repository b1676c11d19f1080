//! Which path a search goes by.

use crate::common::noise;
use crate::{difference, params, Bench, Case};
use impasto::gpu::PassTime;
use impasto::synthesis::calibrate::calibrate;
use impasto::synthesis::quilt::{QuiltStages, SearchPath};

/// A path is a plain value that can be given by hand or found by trying; it decides which stages run, and no byte.
#[test]
fn given_and_calibrated_paths_give_the_same_bytes() {
    let mut bench = Bench::new();
    let sample = noise(64, 48, 12);
    let params = params(16, 5, 0.1, 4, false);
    let case = Case { sample: &sample, size: (64, 48), output: (90, 70), params, guide: None };
    let whole = bench.check(&case, "the device's path");
    let calibrated = calibrate(&mut bench.runner).expect("paths that agree");
    assert!(SearchPath::PARTS.contains(&calibrated.parts), "{calibrated:?}");
    for (path, pruned) in [
        (calibrated, None),
        (SearchPath { parts: 8, prune_from: SearchPath::NEVER }, Some(false)),
        (SearchPath { parts: 2, prune_from: 1 << 40 }, Some(false)),
        (SearchPath { parts: 4, prune_from: 0 }, Some(true)),
    ] {
        let stages = QuiltStages::with_path(&bench.gpu.context, path).expect("a path");
        assert_eq!(stages.path(), path);
        bench.runner.take_times();
        let got = case.gpu(&mut bench.runner, &bench.gpu.context, &stages, u64::MAX);
        assert_eq!(difference(&got, &whole), Ok(()), "{path:?}");
        let ran = |name: &str, times: &[PassTime]| times.iter().any(|time| time.name == name);
        let times = bench.runner.take_times();
        if let Some(pruned) = pruned {
            assert_eq!((ran("quilt_compare", &times), ran("quilt_search", &times)), (pruned, !pruned), "{path:?}");
        }
    }
    for parts in [0, 3, 16] {
        let refused = QuiltStages::with_path(&bench.gpu.context, SearchPath { parts, prune_from: 0 });
        let message = refused.err().expect("no such path").to_string();
        assert!(message.contains(&format!("parts of a search is {parts}, but must be 1, 2, 4 or 8")), "{message}");
    }
}
