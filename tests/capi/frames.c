/* Paints with each technique inside of a host, and compares the bytes with those that the Rust library gives.
 *
 *     frames ASSETS EXPECTED            all of it
 *     frames ASSETS EXPECTED plain      one frame by one technique, without the validation layer
 */
#include "host.h"

#include <string.h>

enum { WIDTH = 96, HEIGHT = 80, OBJECTS = 2, PIECE = 2000000 };

static const char *assets, *expected;
static Host host;
static ImpastoContext *context;
static ImpastoMesh *mesh;
static ImpastoPaint *paints[OBJECTS];
static const uint32_t paint_of_object[OBJECTS] = {0, 1};
static const ImpastoQuilt quilt = {16, 4, 0.1f};
static const ImpastoLight lights[] = {{{-0.8f, 0.5f, 0.35f}, 1.0f}, {{1.0f, 1.0f, 1.0f}, 0.25f}};
static float matrices[2][16];
static ImpastoPose poses[OBJECTS];

static void *texels(const char *name) { return host_file(expected, name, WIDTH * HEIGHT * 4); }

static const char *in(const char *folder, const char *name) {
    static char path[1024];
    CHECK(snprintf(path, sizeof path, "%s/%s", folder, name) < (int)sizeof path);
    return path;
}

/* A mesh of the arrays that the loaded one has. */
static ImpastoMesh *built_mesh(void) {
    uint32_t *counts = host_file(expected, "counts", 5 * 4);
    float *positions = host_file(expected, "positions", counts[0] * 12);
    float *normals = host_file(expected, "normals", counts[0] * 12);
    uint32_t *indices = host_file(expected, "indices", counts[1] * 4);
    ImpastoMeshDesc desc = {.struct_size = sizeof desc};
    ImpastoMesh *made;
    CHECK(counts[2] == OBJECTS);
    OK(impasto_mesh_desc_init(&desc));
    desc.vertex_count = counts[0];
    desc.positions = positions;
    desc.normals = normals;
    desc.indices = indices;
    desc.index_count = counts[1];
    desc.object_index_counts = counts + 3;
    desc.object_count = counts[2];
    OK(impasto_mesh_create(&desc, &made));
    free(counts);
    free(positions);
    free(normals);
    free(indices);
    return made;
}

/* A paint of the pixels that the first of the loaded ones has. */
static ImpastoPaint *built_paint(void) {
    uint32_t *size = host_file(expected, "strip_size", 2 * 4);
    unsigned char *rgba = host_file(expected, "strip", (size_t)size[0] * size[1] * 4);
    ImpastoPaintDesc desc = {.struct_size = sizeof desc, .width_px = size[0], .height_px = size[1], .rgba8 = rgba};
    ImpastoPaint *made;
    OK(impasto_paint_create(&desc, &made));
    free(size);
    free(rgba);
    return made;
}

static void load(void) {
    ImpastoMeshInfo info = {.struct_size = sizeof info};
    float *numbers = host_file(expected, "matrices", sizeof matrices + sizeof poses[0]);
    OK(impasto_mesh_load(in(assets, "teapot_on_table.obj"), &mesh));
    OK(impasto_paint_load(in(expected, "strip_red_yellow.png"), &paints[0]));
    OK(impasto_paint_load(in(expected, "strip_green_yellow.png"), &paints[1]));
    OK(impasto_mesh_info(mesh, &info));
    CHECK(info.object_count == OBJECTS && info.triangle_count > 1000 && info.low[1] < info.high[1]);
    memcpy(matrices, numbers, sizeof matrices);
    memcpy(&poses[0], numbers + 32, sizeof poses[0]);
    memset(&poses[1], 0, sizeof poses[1]);
    poses[1].matrix[0] = poses[1].matrix[5] = poses[1].matrix[10] = poses[1].matrix[15] = 1.0f;
    free(numbers);
}

static ImpastoEffectDesc described(uint32_t technique) {
    ImpastoEffectDesc desc = {.struct_size = sizeof desc};
    OK(impasto_effect_desc_init(&desc, technique));
    CHECK(desc.technique == technique && desc.piece > 0);
    desc.mesh = mesh;
    desc.paints = (const ImpastoPaint *const *)paints;
    desc.paint_count = OBJECTS;
    desc.paint_of_object = paint_of_object;
    desc.object_count = OBJECTS;
    desc.width_px = WIDTH;
    desc.height_px = HEIGHT;
    desc.piece = PIECE;
    desc.seed = 3;
    return desc;
}

/* Prepares beside frames of the host's, which all run. */
static ImpastoEffect *prepared(const ImpastoEffectDesc *desc) {
    ImpastoProgress progress = {.struct_size = sizeof progress};
    ImpastoMemory memory = {.struct_size = sizeof memory};
    ImpastoEffect *effect;
    float done = 0.0f;
    OK(impasto_effect_memory(context, desc, &memory));
    CHECK(memory.persistent_bytes > 0 && memory.preparation_bytes >= memory.persistent_bytes && !memory.frame_bytes);
    OK(impasto_effect_create(context, desc, &effect));
    while (!progress.ready) {
        VkCommandBuffer commands = host_begin(&host);
        OK(impasto_context_advance(context, host.frame, host.frame - 1));
        OK(impasto_effect_prepare(effect, commands, &progress));
        host_submit(&host);
        CHECK(progress.done >= done && progress.done <= 1.0f && progress.step[0]);
        done = progress.done;
    }
    CHECK(done == 1.0f && !strcmp(progress.step, "ready"));
    return effect;
}

/* What is told of each frame; pose 0 turns the first object. */
static ImpastoFrame frame_of(uint32_t pose_count) {
    ImpastoFrame frame = {.struct_size = sizeof frame, .seed = 5, .pose_count = pose_count, .poses = poses};
    memcpy(frame.view, matrices[0], sizeof frame.view);
    memcpy(frame.projection, matrices[1], sizeof frame.projection);
    frame.lights = lights;
    frame.light_count = 2;
    return frame;
}

static void check_picture(ImpastoEffect *effect, const char *name) {
    ImpastoPicture picture = {.struct_size = sizeof picture};
    void *wanted = texels(name), *got;
    OK(impasto_effect_picture(effect, &picture));
    CHECK(picture.format == VK_FORMAT_R8G8B8A8_UNORM && picture.width_px == WIDTH && picture.height_px == HEIGHT);
    CHECK(picture.image && picture.view && picture.layout == HOST_TO_BE_READ.layout);
    CHECK(picture.near_plane > 0.0f && picture.far_plane > picture.near_plane);
    got = host_read(&host, picture.image, WIDTH, HEIGHT);
    if (memcmp(got, wanted, WIDTH * HEIGHT * 4)) {
        fprintf(stderr, "%s is another picture than the Rust library's\n", name);
        exit(1);
    }
    free(wanted);
    free(got);
}

static void record(ImpastoEffect *effect, ImpastoFrame *frame, const char *name) {
    ImpastoImageUse use = {.after = HOST_TO_BE_READ};
    VkCommandBuffer commands = host_begin(&host);
    frame->picture = &use;
    OK(impasto_context_advance(context, host.frame, host.frame - 1));
    OK(impasto_effect_record(effect, commands, frame));
    host_submit(&host);
    check_picture(effect, name);
}

/* Two frames, in the second of which an object has turned. */
static void record_two(ImpastoEffect *effect, const char *technique) {
    char name[64];
    uint32_t i;
    for (i = 0; i < 2; i++) {
        ImpastoFrame frame = frame_of(i ? OBJECTS : 0);
        snprintf(name, sizeof name, "%s.%u", technique, (unsigned)i);
        record(effect, &frame, name);
    }
}

static void object(void) {
    ImpastoObjectParams params = {.struct_size = sizeof params};
    ImpastoEffectDesc desc = described(IMPASTO_TECHNIQUE_OBJECT);
    ImpastoMesh *loaded = mesh, *built = built_mesh();
    ImpastoPaint *first = paints[0], *painted = built_paint();
    ImpastoEffect *effect;
    OK(impasto_object_params_init(&params));
    desc.object = &params;
    effect = prepared(&desc);
    record_two(effect, "object");
    OK(impasto_effect_destroy(effect));
    /* The same of arrays, and with defaults by null. */
    mesh = built;
    paints[0] = painted;
    desc = described(IMPASTO_TECHNIQUE_OBJECT);
    effect = prepared(&desc);
    OK(impasto_mesh_destroy(built));
    OK(impasto_paint_destroy(painted));
    record_two(effect, "object");
    OK(impasto_effect_destroy(effect));
    mesh = loaded;
    paints[0] = first;
}

static void image(void) {
    ImpastoImageParams params = {.struct_size = sizeof params};
    ImpastoEffectDesc desc = described(IMPASTO_TECHNIQUE_IMAGE);
    ImpastoEffect *effect;
    OK(impasto_image_params_init(&params));
    params.quilt = quilt;
    desc.image = &params;
    effect = prepared(&desc);
    record_two(effect, "image");
    OK(impasto_effect_destroy(effect));
}

static void dependent(void) {
    static const ImpastoDirection views[] = {{20.0f, 10.0f}, {200.0f, 0.0f}};
    ImpastoDependentParams params = {.struct_size = sizeof params};
    ImpastoEffectDesc desc = described(IMPASTO_TECHNIQUE_DEPENDENT);
    ImpastoEffect *effect;
    OK(impasto_dependent_params_init(&params));
    params.quilt = quilt;
    params.views = views;
    params.view_count = 2;
    params.view_px = 512;
    desc.dependent = &params;
    effect = prepared(&desc);
    record_two(effect, "dependent");
    OK(impasto_effect_destroy(effect));
}

/* Lays the picture of the last frame over an image with a depth. */
static void composite(ImpastoEffect *effect) {
    VkImageUsageFlags copied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    HostImage color = host_image(&host, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | copied, WIDTH,
                                 HEIGHT);
    HostImage depth = host_image(&host, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | copied,
                                 WIDTH, HEIGHT);
    ImpastoImage images[] = {host_described(&color), host_described(&depth)};
    ImpastoTarget target = {&images[0], &images[1]};
    ImpastoCompositeDesc desc = {.struct_size = sizeof desc, .target_count = 1, .targets = &target};
    ImpastoImageUse use = {HOST_WRITTEN, HOST_TO_BE_READ};
    ImpastoCompositeFrame frame = {.struct_size = sizeof frame, .color = &use, .depth = &use};
    ImpastoComposite *made;
    VkCommandBuffer commands;
    void *under = texels("under"), *under_depth = texels("under_depth"), *wanted = texels("composite"), *got;
    uint32_t i;
    OK(impasto_composite_create(effect, &desc, &made));
    for (i = 0; i < 2; i++) {
        /* The distances told by the matrix, and by two numbers. */
        frame.projection = i ? NULL : matrices[1];
        frame.depth_a = matrices[1][10] / matrices[1][11];
        frame.depth_b = matrices[1][14];
        host_write(&host, &color, under);
        host_write(&host, &depth, under_depth);
        commands = host_begin(&host);
        OK(impasto_composite_record(made, commands, &frame));
        host_submit(&host);
        got = host_read(&host, color.image, WIDTH, HEIGHT);
        CHECK(!memcmp(got, wanted, WIDTH * HEIGHT * 4));
        free(got);
    }
    OK(impasto_composite_destroy(made));
    free(under);
    free(under_depth);
    free(wanted);
    host_destroy_image(&host, &color);
    host_destroy_image(&host, &depth);
}

static void aligned(int all) {
    ImpastoAlignedParams params = {.struct_size = sizeof params};
    ImpastoEffectDesc desc = described(IMPASTO_TECHNIQUE_ALIGNED);
    ImpastoEffect *effect;
    OK(impasto_aligned_params_init(&params));
    params.quilt = quilt;
    params.levels = 3;
    params.size_px = 64;
    desc.aligned = &params;
    effect = prepared(&desc);
    record_two(effect, "aligned");
    if (all) {
        composite(effect);
    }
    OK(impasto_effect_destroy(effect));
}

/* Paints over guides that the host has drawn, and follows the host's motion vectors. */
static void over_guides(void) {
    VkImageUsageFlags storage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    VkImageUsageFlags sampled = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    struct {
        const char *file;
        VkFormat format;
        VkImageUsageFlags usage;
    } inputs[] = {
        {"shade", VK_FORMAT_R32_SFLOAT, storage},
        {"id", VK_FORMAT_R32_UINT, storage},
        {"depth", VK_FORMAT_D32_SFLOAT, sampled | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT},
        {"vectors", VK_FORMAT_R16G16_SFLOAT, sampled},
    };
    ImpastoImageParams params = {.struct_size = sizeof params};
    ImpastoEffectDesc desc = described(IMPASTO_TECHNIQUE_IMAGE);
    ImpastoFrame frame = frame_of(0);
    ImpastoImageUse use = {HOST_WRITTEN, HOST_TO_BE_READ};
    ImpastoImage images[4];
    HostImage made[4];
    ImpastoEffect *effect;
    char name[64];
    uint32_t i, k;
    for (i = 0; i < 4; i++) {
        made[i] = host_image(&host, inputs[i].format, inputs[i].usage | VK_IMAGE_USAGE_TRANSFER_DST_BIT, WIDTH, HEIGHT);
        images[i] = host_described(&made[i]);
    }
    OK(impasto_image_params_init(&params));
    params.quilt = quilt;
    desc.image = &params;
    desc.shade = &images[0];
    desc.id = &images[1];
    desc.depth = &images[2];
    desc.vectors = &images[3];
    frame.shade = frame.id = frame.depth = frame.vectors = &use;
    effect = prepared(&desc);
    for (k = 0; k < 2; k++) {
        for (i = 0; i < 4; i++) {
            void *drawn = texels(inputs[i].file);
            host_write(&host, &made[i], drawn);
            free(drawn);
        }
        snprintf(name, sizeof name, "over_guides.%u", (unsigned)k);
        record(effect, &frame, name);
    }
    OK(impasto_effect_destroy(effect));
    OK(impasto_context_advance(context, host.frame + 1, host.frame));
    for (i = 0; i < 4; i++) {
        host_destroy_image(&host, &made[i]);
    }
}

int main(int count, char **arguments) {
    int all = count == 3;
    ImpastoHostDevice lent;
    uint64_t bytes;
    CHECK(count == 3 || count == 4);
    assets = arguments[1];
    expected = arguments[2];
    CHECK(impasto_version() == IMPASTO_VERSION);
    host_create(&host, all);
    lent = host_lent(&host, vkGetInstanceProcAddr);
    OK(impasto_context_create(&lent, &context));
    load();
    aligned(all);
    if (all) {
        object();
        image();
        dependent();
        over_guides();
    }
    OK(impasto_mesh_destroy(mesh));
    OK(impasto_paint_destroy(paints[0]));
    OK(impasto_paint_destroy(paints[1]));
    OK(impasto_context_advance(context, host.frame + 1, host.frame));
    OK(impasto_context_allocated_bytes(context, &bytes));
    CHECK(bytes == 0);
    OK(impasto_context_destroy(context));
    host_destroy(&host);
    printf("done\n");
    return 0;
}
