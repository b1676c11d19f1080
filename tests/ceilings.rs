//! The device's ceilings: every kernel runs under validation, gives what the host works out, and is measured.

mod common;

use common::Validated;
use impasto::gpu::ceilings::{measure, Effort, What};

/// `measure` itself compares every result with the host's and fails when they differ.
#[test]
fn every_kernel_gives_what_the_host_works_out() {
    let gpu = Validated::new();
    let effort = Effort { copy_bytes: vec![100_000, 1 << 20], ..Effort::quick() };
    let measured = measure(&mut gpu.runner(), &What::ALL, &effort).expect("right results");
    let copies = [What::CopyBuffer, What::CopyWords, What::CopyTexels];
    let mut expected: Vec<(What, u64)> =
        copies.iter().flat_map(|&what| [(what, 64 * 64 * 16), (what, 1 << 20)]).collect();
    expected.extend(What::ALL[3..].iter().map(|&what| (what, 0)));
    if !gpu.context.caps().integer_dot_product {
        expected.pop();
    }
    let found: Vec<_> = measured.iter().map(|ceiling| (ceiling.what, ceiling.copy_bytes)).collect();
    assert_eq!(found, expected);
    for ceiling in &measured {
        assert_eq!(ceiling.wall_seconds.len(), 3, "{ceiling:?}");
        for rate in [ceiling.rate(), ceiling.wall_rate()] {
            assert!(rate.median > 0.0 && rate.best >= rate.median && rate.best.is_finite(), "{ceiling:?}");
        }
        let moved = ceiling.work % (2 * ceiling.copy_bytes).max(1);
        assert_eq!(moved, 0, "each pass reads and writes all of it: {ceiling:?}");
    }
}

#[test]
fn copies_that_do_not_fit_are_left_out() {
    let gpu = Validated::new();
    let too_large = gpu.context.caps().max_storage_buffer_bytes + 1;
    let effort = Effort { copy_bytes: vec![0, 1000, too_large, u64::MAX], ..Effort::quick() };
    let measured = measure(&mut gpu.runner(), &[What::CopyWords, What::CopyTexels], &effort).expect("nothing to do");
    assert_eq!(measured, []);
}
