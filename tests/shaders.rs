//! The shaders that are built in: no binary older than its source, none that asks for more than plain Vulkan 1.1, and
//! none that differs from the tables and structures that Rust keeps of it.
//!
//! That a binary is valid as a whole is checked by the validation layer whenever a pipeline is made from it in the
//! other tests.

mod spirv;

#[path = "../examples/compile_shaders/sources.rs"]
mod sources;

use impasto::gpu::{Access, BindingKind, RasterShader};
use impasto::shader_table;
use impasto::synthesis::quilt_stages::shared_structs;
use spirv::{Binary, Member, Resource};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn glsl() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl")
}

fn files_below(dir: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(dir).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(files_below(&path));
        } else {
            files.push(path);
        }
    }
    files
}

fn binaries() -> Vec<(String, Binary)> {
    let shaders = sources::shaders(&glsl()).expect("the folder of shaders");
    assert!(shaders.len() >= 4, "the folder of shaders is nearly empty");
    shaders
        .iter()
        .map(|shader| {
            let bytes = std::fs::read(shader.binary(&glsl())).unwrap_or_else(|e| panic!("{}: {e}", shader.name));
            (shader.name.clone(), Binary::parse(&bytes))
        })
        .collect()
}

#[test]
fn no_binary_is_older_than_its_source() {
    let kept = std::fs::read_to_string(glsl().join("spirv/fingerprints.txt")).expect("the list of fingerprints");
    let now = sources::listing(&glsl()).expect("fingerprints");
    assert_eq!(kept, now, "shaders have changed since they were compiled");
}

#[test]
fn every_source_has_a_binary_and_every_binary_a_source() {
    let expected: BTreeSet<_> =
        sources::shaders(&glsl()).expect("shaders").iter().map(|shader| shader.binary(&glsl())).collect();
    let spirv = glsl().join("spirv");
    let there: BTreeSet<_> = files_below(&spirv).into_iter().filter(|f| !f.ends_with("fingerprints.txt")).collect();
    assert_eq!(there, expected);
}

/// Copies the shaders' sources, for changes to be planted in.
fn copy_of_sources(to: &Path) {
    for file in files_below(&glsl()) {
        if file.extension().is_some_and(|e| e != "spv") {
            let copy = to.join(file.strip_prefix(glsl()).expect("a file below glsl"));
            std::fs::create_dir_all(copy.parent().expect("a folder")).expect("a folder");
            std::fs::copy(&file, copy).expect("a copy");
        }
    }
}

/// The names whose line in the list differs after `change` was made to the text of `file`.
fn stale_after(file: &str, change: impl Fn(&str) -> String) -> Vec<String> {
    let copy = tempfile::tempdir().expect("a folder");
    copy_of_sources(copy.path());
    let before = sources::listing(copy.path()).expect("fingerprints");
    let path = copy.path().join(file);
    let text = std::fs::read_to_string(&path).expect(file);
    let changed = change(&text);
    assert_ne!(text, changed, "the change of {file} changes nothing");
    std::fs::write(&path, changed).expect(file);
    let after = sources::listing(copy.path()).expect("fingerprints");
    let name = |line: &str| line.split_whitespace().nth(1).unwrap_or_default().to_owned();
    before.lines().zip(after.lines()).filter(|(a, b)| a != b).map(|(a, _)| name(a)).collect()
}

#[test]
fn one_byte_changed_is_noticed() {
    let quilting = [
        "synthesis/quilt_aim.comp",
        "synthesis/quilt_bound.comp",
        "synthesis/quilt_compare.comp",
        "synthesis/quilt_guide.comp",
        "synthesis/quilt_match.comp",
        "synthesis/quilt_place.comp",
        "synthesis/quilt_search.comp",
        "synthesis/repair_fit.comp",
        "technique/image_blend.comp",
        "technique/image_carry.frag",
    ];
    assert_eq!(stale_after("synthesis/quilt_place.comp", |t| t.replacen('<', ">", 1)), ["synthesis/quilt_place.comp"]);
    assert_eq!(stale_after("synthesis/tile_mask.comp", |t| format!("{t}\n")), ["synthesis/tile_mask.comp"]);
    // An included file is part of every shader that includes it.
    assert_eq!(stale_after("synthesis/quilt.glsl", |t| t.replacen("TILE = 8", "TILE = 4", 1)), quilting);
}

#[test]
fn binaries_ask_for_nothing_beyond_plain_vulkan_1_1() {
    for (name, binary) in binaries() {
        // Made into a pipeline only where `Caps::integer_dot_product` is on.
        let optional: &[&str] = match name.as_str() {
            "gpu/dot8_packed_rate.comp" => {
                &["DotProductInput4x8BitPacked", "DotProduct", "SPV_KHR_integer_dot_product"]
            }
            _ => &[],
        };
        assert_eq!(beyond_vulkan_1_1(&binary), optional, "{name}");
    }
}

/// What a device that offers Vulkan 1.1 with no feature enabled need not be able to do.
fn beyond_vulkan_1_1(binary: &Binary) -> Vec<String> {
    let mut faults = Vec::new();
    if binary.version > (1, 3) {
        faults.push(format!("SPIR-V {:?}", binary.version));
    }
    // Those of Vulkan's table "capabilities" that depend on no feature.
    let plain = [
        "Matrix",
        "Shader",
        "InputAttachment",
        "Sampled1D",
        "Image1D",
        "SampledBuffer",
        "ImageBuffer",
        "ImageQuery",
        "DerivativeControl",
    ];
    faults.extend(binary.capabilities.iter().filter(|c| !plain.contains(&c.as_str())).cloned());
    faults.extend(binary.extensions.iter().filter(|e| *e != "GLSL.std.450").cloned());
    let (invocations, sides_fit) = match binary.local_size {
        None => (0, true),
        Some([x, y, z]) => (x * y * z, x <= 128 && y <= 128 && z <= 64),
    };
    if invocations > 128 || !sides_fit {
        faults.push(format!("workgroups of {:?}", binary.local_size));
    }
    if binary.shared_bytes > 16_384 {
        faults.push(format!("{} bytes of shared memory", binary.shared_bytes));
    }
    if binary.push_bytes() > 128 {
        faults.push(format!("{} bytes of push constants", binary.push_bytes()));
    }
    if binary.entry_points != ["main"] {
        faults.push(format!("entry points {:?}", binary.entry_points));
    }
    if binary.resources.iter().any(|r| r.set != 0) {
        faults.push("a descriptor set other than 0".to_owned());
    }
    faults
}

/// Storage images and colour attachments of fragment shaders, of which Vulkan promises few.
#[test]
fn a_host_is_told_of_as_many_fragment_outputs_as_there_are() {
    let outputs = shader_table::raster_shaders().into_iter().map(|(_, fragment, shader)| {
        let source = std::fs::read_to_string(glsl().join(fragment)).expect(fragment);
        let colors = source.lines().filter(|l| l.starts_with("layout(location") && l.contains(") out ")).count();
        let stored = shader.bindings.iter().filter(|kind| !matches!(kind, BindingKind::Sampled(_))).count();
        (colors as u32, (colors + stored) as u32)
    });
    let (colors, outputs): (Vec<u32>, Vec<u32>) = outputs.unzip();
    let limits = impasto::gpu::requirements().limits;
    assert_eq!(colors.into_iter().max(), Some(limits.color_attachments));
    assert_eq!(outputs.into_iter().max(), Some(limits.fragment_outputs));
}

#[test]
fn a_binary_that_asks_for_more_is_noticed() {
    let path = glsl().join("spirv/synthesis/quilt_place.comp.spv");
    let good = Binary::parse(&std::fs::read(path).expect("the binary"));
    assert_eq!(good.local_size, Some([128, 1, 1]));
    // list and in_span 128 each, cumulative 64 * 32, beyond 2 * 64, a block's 11, position 2, nine more; 4 bytes each.
    assert_eq!(good.shared_bytes, 4 * (2 * 128 + 64 * 32 + 2 * 64 + 11 + 2 + 9));
    let faults = |change: &dyn Fn(&mut Binary)| {
        let mut changed = good.clone();
        change(&mut changed);
        beyond_vulkan_1_1(&changed).len()
    };
    assert_eq!(faults(&|_| ()), 0);
    assert_eq!(faults(&|b| b.version = (1, 4)), 1);
    assert_eq!(faults(&|b| b.capabilities.push("Int64".to_owned())), 1);
    assert_eq!(faults(&|b| b.extensions.push("SPV_KHR_16bit_storage".to_owned())), 1);
    assert_eq!(faults(&|b| b.local_size = Some([129, 1, 1])), 1);
    assert_eq!(faults(&|b| b.shared_bytes = 16_385), 1);
    assert_eq!(faults(&|b| b.push.push(Member { offset: 128, bytes: 4 })), 1);
}

/// How a binding of the table would have to look in the SPIR-V.
fn expected(binding: u32, kind: BindingKind) -> Resource {
    let (class, access) = match kind {
        BindingKind::Buffer(access) => ("storage buffer", access),
        BindingKind::Image(access) => ("storage image", access),
        BindingKind::Sampled(access) => ("sampled image", access),
    };
    let (non_writable, non_readable) = match access {
        Access::ComputeRead | Access::FragmentRead => (true, false),
        // A sampler only ever reads.
        Access::FragmentSampled | Access::ComputeSampled => (false, false),
        Access::ComputeWrite => (false, true),
        Access::ComputeReadWrite => (false, false),
        other => panic!("a shader's binding declares {other:?}"),
    };
    Resource { set: 0, binding, class, non_writable, non_readable }
}

#[test]
fn tables_say_what_the_binaries_say() {
    let binaries = binaries();
    let table = shader_table::shaders();
    let compute: BTreeSet<&str> =
        binaries.iter().filter(|(_, b)| b.local_size.is_some()).map(|(name, _)| name.as_str()).collect();
    let listed: BTreeSet<&str> = table.iter().map(|(source, _)| *source).collect();
    assert_eq!(listed, compute, "the table of shaders is not complete");
    for (source, shader) in &table {
        let binary = &binaries.iter().find(|(name, _)| name == source).expect("it is listed").1;
        let stem = Path::new(source).file_stem().and_then(|s| s.to_str());
        assert_eq!(stem, Some(shader.name), "{source}: a shader is named as its file");
        assert_eq!(&Binary::parse(shader.spirv), binary, "{source}: another binary is built in");
        let bindings: Vec<_> = (0..).zip(shader.bindings).map(|(i, &kind)| expected(i, kind)).collect();
        assert_eq!(binary.resources, bindings, "{source}: bindings");
        assert_eq!(binary.push_bytes(), shader.push_bytes, "{source}: push constants");
    }
}

/// What is wrong with a table of a vertex and a fragment shader.
fn raster_faults(source: &str, shader: &RasterShader, vertex: &Binary, fragment: &Binary) -> Vec<String> {
    let mut faults = Vec::new();
    if Path::new(source).file_stem().and_then(|s| s.to_str()) != Some(shader.name) {
        faults.push(format!("{source} is named {}", shader.name));
    }
    if &Binary::parse(shader.vertex_spirv) != vertex || &Binary::parse(shader.fragment_spirv) != fragment {
        faults.push("other binaries are built in".to_owned());
    }
    let bindings: Vec<_> = (0..).zip(shader.bindings).map(|(i, &kind)| expected(i, kind)).collect();
    if fragment.resources != bindings || !vertex.resources.is_empty() {
        faults.push(format!("bindings {:?} and {:?}", vertex.resources, fragment.resources));
    }
    // A stage that reads nothing of the block may leave it out, but both must agree where they have it.
    let blocks: Vec<_> = [vertex, fragment].into_iter().filter(|b| b.push_bytes() > 0).collect();
    if blocks.iter().any(|b| b.push_bytes() != shader.push_bytes || b.push != blocks[0].push) {
        faults.push("push constants".to_owned());
    }
    faults
}

#[test]
fn raster_tables_say_what_the_binaries_say() {
    let binaries = binaries();
    let table = shader_table::raster_shaders();
    let find = |name: String| &binaries.iter().find(|(n, _)| *n == name).unwrap_or_else(|| panic!("no {name}")).1;
    let drawn: BTreeSet<String> =
        binaries.iter().filter(|(_, b)| b.local_size.is_none()).map(|(n, _)| n.clone()).collect();
    let listed: BTreeSet<String> =
        table.iter().flat_map(|(vertex, fragment, _)| [(*vertex).to_owned(), (*fragment).to_owned()]).collect();
    assert_eq!(listed, drawn, "the table of raster shaders is not complete");
    for (vertex, source, shader) in &table {
        let (vertex, fragment) = (find((*vertex).to_owned()), find((*source).to_owned()));
        assert_eq!(raster_faults(source, shader, vertex, fragment), [""; 0], "{source}");
        // Planted mistakes are noticed.
        let bytes = RasterShader { push_bytes: shader.push_bytes + 4, ..*shader };
        assert_eq!(raster_faults(source, &bytes, vertex, fragment).len(), 1, "{source}");
        if let [first, ..] = shader.bindings {
            let twice = RasterShader { bindings: Box::leak(Box::new([*first, *first])), ..*shader };
            assert_eq!(raster_faults(source, &twice, vertex, fragment).len(), 1, "{source}");
            let swapped = raster_faults(source, shader, fragment, vertex);
            assert!(swapped.iter().any(|fault| fault.contains("built in")), "{source}: {swapped:?}");
        }
    }
}

/// The members of a structure in GLSL that consists of `uint`s, in order.
fn glsl_members(file: &str, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(glsl().join(file)).expect(file);
    let at = text.find(&format!("{name} {{")).unwrap_or_else(|| panic!("{file} has no {name}"));
    let body = text[at..].split_once('{').and_then(|(_, rest)| rest.split_once('}')).expect("braces").0;
    let code: String = body.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let members = code.split(';').map(str::trim).filter(|m| !m.is_empty());
    members
        .flat_map(|m| {
            let number = m.strip_prefix("uint ").or(m.strip_prefix("float "));
            number.unwrap_or_else(|| panic!("{m} is neither of uint nor of float")).split(',')
        })
        .map(|m| m.trim().to_owned())
        .collect()
}

/// Whether a shader's source is, or includes, the file.
fn declares(source: &str, file: &str) -> bool {
    let name = Path::new(file).file_name().and_then(|name| name.to_str()).expect("a name");
    source == file || std::fs::read_to_string(glsl().join(source)).expect(source).contains(name)
}

/// Names are gone from the binaries, so order is compared with the GLSL text and offsets with the binary.
#[test]
fn structures_are_the_same_in_rust_and_glsl() {
    let binaries = binaries();
    let mut arrays = 0;
    for (file, name, bytes, fields) in shared_structs() {
        let members = glsl_members(file, name);
        assert_eq!(members.len() * 4, bytes, "{file}: {name}");
        for (field, offset) in fields {
            // Rust may have one array where GLSL has several members: output is output_width and output_height.
            let member = &members[offset / 4];
            assert!(member == field || member.starts_with(&format!("{field}_")), "{file}: {field} lies on {member}");
        }
        let offsets: Vec<_> = (0..members.len() as u32).map(|i| Member { offset: i * 4, bytes: 4 }).collect();
        match name {
            "uniform Push" => {
                let users: Vec<_> = binaries.iter().filter(|(source, _)| declares(source, file)).collect();
                assert!(!users.is_empty(), "{file}");
                for (source, binary) in users {
                    assert_eq!(binary.push, offsets, "{source}: {name}");
                }
            }
            _ => {
                let array = (bytes as u32, offsets);
                let users = binaries.iter().filter(|(_, binary)| binary.arrays_of_structs.contains(&array)).count();
                let expected = match name {
                    "struct Block" => 7,
                    _ => 1,
                };
                assert_eq!(users, expected, "stages that have an array of {name}");
                arrays += users;
            }
        }
    }
    let all: usize = binaries.iter().map(|(_, binary)| binary.arrays_of_structs.len()).sum();
    assert_eq!(arrays, all, "every array of structures is shared");
}
