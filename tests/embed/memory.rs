//! What is told of memory, against what is taken.

use super::*;
use host::memory::Pieces;
use impasto::gpu::HostDevice;

/// Prepares an effect; what it takes when it is ready, and the most that was seen on the way.
fn taken(host: &Host, context: &Context, desc: EffectDesc) -> (u64, u64) {
    let before = context.allocated_bytes();
    let mut effect = Effect::new(context, desc).expect("an effect");
    let (mut frame, mut most) = (1000, 0);
    while !effect.progress().ready {
        frame += 1;
        context.advance(frame, frame - 1);
        host.run(|commands| {
            effect.prepare(&mut recorder(context, commands)).expect("a preparation");
        });
        most = most.max(context.allocated_bytes() - before);
    }
    context.advance(frame + 2, frame + 1);
    let kept = context.allocated_bytes() - before;
    drop(effect);
    context.advance(frame + 4, frame + 3);
    assert_eq!(context.allocated_bytes(), before);
    (kept, most)
}

/// A model that takes many textures of views, being full of hollows.
fn head() -> Arc<Mesh> {
    let asset = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/head.obj");
    Arc::new(Mesh::load(asset, &MeshOptions::default()).expect("a mesh").mesh)
}

#[test]
fn memory_is_told_before_it_is_taken() {
    let (host, mesh) = (Host::new(), head());
    let context = borrow(&host);
    for (name, method) in methods() {
        for size_px in [(90, 70), (333, 201)] {
            let desc = EffectDesc { size_px, ..desc(&mesh, &method) };
            host::calls::take();
            let told = Effect::memory(&context, &desc).expect("a description");
            let called = host::calls::take();
            assert!(called.keys().all(|call| call.contains("Buffer") || call.contains("Image")), "{called:?}");
            assert_eq!(context.allocated_bytes(), 0);
            let (kept, most) = taken(&host, &context, desc);
            assert_eq!(told.frame_bytes, 0);
            assert!(told.preparation_bytes >= told.persistent_bytes);
            if matches!(method, Method::Dependent { .. }) {
                let (low, high) = (told.persistent_bytes / 4, told.persistent_bytes);
                assert!((low..=high).contains(&kept), "{name}: {kept} of {told:?}");
                assert!(most <= told.preparation_bytes, "{name}: {most} of {told:?}");
            } else {
                assert_eq!(kept, told.persistent_bytes, "{name} at {size_px:?}");
                assert_eq!(most, told.preparation_bytes, "{name} at {size_px:?}");
            }
        }
    }
    drop(context);
    assert_silent(&host.destroy());
}

#[test]
fn what_the_host_draws_is_not_counted() {
    use impasto::embed::Inputs;
    use impasto::gpu::Uploads;
    use impasto::scene::GuidePass;
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let mut uploads = Uploads::default();
    let pass = GuidePass::new(&context, &mut uploads, &mesh, SIZE).expect("guides");
    host.run(|commands| uploads.record(&mut recorder(&context, commands)));
    context.advance(1000, 999);
    let (_, aligned) = methods().into_iter().nth(3).expect("a method");
    let own = Effect::memory(&context, &desc(&mesh, &aligned)).expect("a description");
    let inputs = Inputs { guides: Some((&pass).into()), vectors: None };
    let led = EffectDesc { inputs, ..desc(&mesh, &aligned) };
    let told = Effect::memory(&context, &led).expect("a description");
    assert!(told.persistent_bytes < own.persistent_bytes, "{told:?}, {own:?}");
    assert_eq!(taken(&host, &context, led).0, told.persistent_bytes);
    drop((pass, uploads, context));
    assert_silent(&host.destroy());
}

#[test]
fn a_budget_that_is_too_small_is_told_before_too() {
    let (host, mesh) = (Host::new(), ball());
    let context = borrow(&host);
    let (_, image) = methods().into_iter().nth(1).expect("a method");
    let needs = Effect::memory(&context, &desc(&mesh, &image)).expect("a description");
    drop(context);
    for (budget, enough) in [(needs.preparation_bytes, true), (needs.preparation_bytes - 1, false)] {
        let mut lent = host.lent();
        lent.memory_budget = Some(budget);
        // SAFETY: as in `borrow`.
        let context = unsafe { Context::from_host(lent) }.expect("a context");
        let told = Effect::memory(&context, &desc(&mesh, &image));
        assert_eq!(told.is_ok(), enough, "{told:?}");
        if enough {
            taken(&host, &context, desc(&mesh, &image));
        } else {
            assert!(matches!(told, Err(impasto::Error::Memory { .. })), "{told:?}");
        }
    }
    assert_silent(&host.destroy());
}

#[test]
fn memory_of_the_hosts_paints_the_same_and_comes_back() {
    let (host, mesh) = (Host::new(), head());
    let memory = Arc::new(Pieces::new(&host));
    for (name, method) in methods() {
        let frames = [host.lent(), HostDevice { memory: Some(memory.clone()), ..host.lent() }].map(|lent| {
            // SAFETY: as in `borrow`.
            let context = unsafe { Context::from_host(lent) }.expect("a context");
            let mut effect = Effect::new(&context, desc(&mesh, &method)).expect("an effect");
            let mut frame = 0;
            prepare(&host, &context, &mut effect, &mut frame);
            [0, 1].map(|number| picture(&host, &context, &mut effect, &EffectFrame::next(&moment(&mesh, number))))
        });
        assert!(frames[0] == frames[1], "{name}");
        assert_eq!(memory.now(), (0, 0), "{name} keeps memory");
    }
    assert!(memory.counts()["image"] > 20, "{:?}", memory.counts());
    drop(memory);
    assert_silent(&host.destroy());
}
