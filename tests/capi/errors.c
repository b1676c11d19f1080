/* What a host may do wrong, and what may go wrong under it: each is told with a status and in words, nothing crashes or
 * leaks, and the context is destroyed in the end.
 *
 *     errors calls          wrong calls
 *     errors failing        calls of Vulkan that fail, each in turn
 *     errors calls plain    without the validation layer
 */
#include "host.h"

#include <math.h>
#include <string.h>

enum { SIDE = 32 };

static Host host;
static ImpastoContext *context;
static ImpastoMesh *mesh;
static ImpastoPaint *paint;
static const ImpastoLight light = {{-0.8f, 0.5f, 0.35f}, 1.0f};
static const float view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -4, 1};
/* 60 degrees, near 1, far 10. */
static const float projection[16] = {1.732f, 0, 0,             0,  0, -1.732f, 0,             0,
                                     0,      0, -10.0f / 9.0f, -1, 0, 0,       -10.0f / 9.0f, 0};

/* The words of the last failure must have this in them. */
#define WORDS(part) CHECK(strstr(impasto_last_error(), part))
#define REFUSED(status, call, part)                                                      \
    do {                                                                                 \
        EXPECT(IMPASTO_STATUS_##status, call);                                           \
        WORDS(part);                                                                     \
    } while (0)

/* A tetrahedron. */
static ImpastoMeshDesc mesh_desc(void) {
    static const float positions[12] = {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1};
    static const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    ImpastoMeshDesc desc = {.struct_size = sizeof desc, .vertex_count = 4, .positions = positions, .indices = indices};
    desc.index_count = 12;
    return desc;
}

/* Stripes, from dark to light. */
static ImpastoPaintDesc paint_desc(void) {
    static float rgb[96 * 48 * 3];
    ImpastoPaintDesc desc = {.struct_size = sizeof desc, .width_px = 96, .height_px = 48, .rgb = rgb};
    unsigned i;
    for (i = 0; i < 96 * 48 * 3; i++) {
        rgb[i] = 0.8f * (float)(i / 3 % 96) / 95.0f + 0.02f * (float)(i / 288 % 7);
    }
    return desc;
}

static ImpastoEffectDesc effect_desc(uint32_t technique) {
    ImpastoEffectDesc desc = {.struct_size = sizeof desc};
    OK(impasto_effect_desc_init(&desc, technique));
    desc.mesh = mesh;
    desc.paints = (const ImpastoPaint *const *)&paint;
    desc.paint_count = 1;
    desc.width_px = desc.height_px = SIDE;
    return desc;
}

static ImpastoFrame frame_of(void) {
    ImpastoFrame frame = {.struct_size = sizeof frame, .lights = &light, .light_count = 1};
    memcpy(frame.view, view, sizeof view);
    memcpy(frame.projection, projection, sizeof projection);
    return frame;
}

/* Prepares as far as it goes. */
static ImpastoStatus prepare(ImpastoEffect *effect) {
    ImpastoProgress progress = {.struct_size = sizeof progress};
    ImpastoStatus status = IMPASTO_STATUS_OK;
    while (status == IMPASTO_STATUS_OK && !progress.ready) {
        VkCommandBuffer commands = host_begin(&host);
        status = impasto_context_advance(context, host.frame, host.frame - 1);
        if (status == IMPASTO_STATUS_OK) {
            status = impasto_effect_prepare(effect, commands, &progress);
        }
        host_submit(&host);
    }
    return status;
}

static void nothing_is_allocated(void) {
    uint64_t bytes = 1;
    host.frame++;
    OK(impasto_context_advance(context, host.frame + 1, host.frame));
    OK(impasto_context_allocated_bytes(context, &bytes));
    CHECK(bytes == 0);
}

static void no_device(void) {
    ImpastoHostDevice lent = host_lent(&host, vkGetInstanceProcAddr), other = lent;
    ImpastoContext *none = NULL;
    ImpastoRequirements needs = {0, 1, 2, 3, 4, 5};
    OK(impasto_device_check(vkGetInstanceProcAddr, host.instance, host.physical, host.family));
    REFUSED(DEVICE, impasto_device_check(vkGetInstanceProcAddr, host.instance, host.physical, 999), "queue family");
    REFUSED(NULL_POINTER, impasto_device_check(NULL, host.instance, host.physical, 0), "is null");
    REFUSED(NULL_POINTER, impasto_device_check(vkGetInstanceProcAddr, NULL, host.physical, 0), "is null");
    REFUSED(NULL_POINTER, impasto_requirements(NULL), "ImpastoRequirements is null");
    REFUSED(STRUCT_SIZE, impasto_requirements(&needs), "sizeof(ImpastoRequirements)");
    CHECK(needs.api_version == 1);
    REFUSED(NULL_POINTER, impasto_context_create(NULL, &none), "ImpastoHostDevice is null");
    REFUSED(NULL_POINTER, impasto_context_create(&lent, NULL), "is null");
    other.struct_size = sizeof other - 8;
    REFUSED(STRUCT_SIZE, impasto_context_create(&other, &none), "sizeof(ImpastoHostDevice)");
    other = lent;
    other.get_instance_proc_addr = NULL;
    REFUSED(NULL_POINTER, impasto_context_create(&other, &none), "get_instance_proc_addr");
    other = lent;
    other.device = VK_NULL_HANDLE;
    REFUSED(NULL_POINTER, impasto_context_create(&other, &none), "device");
    other = lent;
    other.debug_utils = 2;
    REFUSED(PARAMETER, impasto_context_create(&other, &none), "debug_utils is 2, but must be 0 or 1");
    CHECK(none == NULL);
}

static void no_mesh(void) {
    ImpastoMeshDesc desc = mesh_desc();
    ImpastoMesh *none = NULL;
    uint32_t counts[] = {6, 3}, indices[] = {0, 1, 4};
    ImpastoMeshInfo info = {.struct_size = sizeof info};
    REFUSED(NULL_POINTER, impasto_mesh_load(NULL, &none), "path of the mesh is null");
    REFUSED(NULL_POINTER, impasto_mesh_load("x.obj", NULL), "is null");
    REFUSED(IO, impasto_mesh_load("/no/such\xff/model.obj", &none), "model.obj");
    REFUSED(FILE, impasto_mesh_load("/dev/null", &none), "/dev/null");
    REFUSED(NULL_POINTER, impasto_mesh_create(NULL, &none), "ImpastoMeshDesc is null");
    REFUSED(NULL_POINTER, impasto_mesh_create(&desc, NULL), "is null");
    desc.positions = NULL;
    REFUSED(NULL_POINTER, impasto_mesh_create(&desc, &none), "positions is null");
    desc = mesh_desc();
    desc.indices = NULL;
    REFUSED(NULL_POINTER, impasto_mesh_create(&desc, &none), "indices is null");
    desc = mesh_desc();
    desc.vertex_count = UINT32_MAX;
    REFUSED(PARAMETER, impasto_mesh_create(&desc, &none), "positions");
    desc = mesh_desc();
    desc.index_count = 11;
    REFUSED(PARAMETER, impasto_mesh_create(&desc, &none), "three per triangle");
    desc = mesh_desc();
    desc.indices = indices;
    desc.index_count = 3;
    REFUSED(PARAMETER, impasto_mesh_create(&desc, &none), "below the vertex count");
    desc = mesh_desc();
    desc.object_index_counts = counts;
    desc.object_count = 2;
    REFUSED(PARAMETER, impasto_mesh_create(&desc, &none), "objects");
    desc = mesh_desc();
    desc.crease_deg = NAN;
    REFUSED(PARAMETER, impasto_mesh_create(&desc, &none), "crease_deg");
    REFUSED(NULL_POINTER, impasto_mesh_info(NULL, &info), "mesh is null");
    REFUSED(NULL_POINTER, impasto_mesh_info(mesh, NULL), "ImpastoMeshInfo is null");
    REFUSED(NULL_POINTER, impasto_mesh_desc_init(NULL), "ImpastoMeshDesc is null");
    CHECK(none == NULL);
}

static void no_paint(void) {
    ImpastoPaintDesc desc = paint_desc();
    ImpastoPaint *none = NULL;
    static const float bad[3] = {0.5f, NAN, 0.5f};
    static const uint8_t bytes[4] = {0};
    REFUSED(NULL_POINTER, impasto_paint_load(NULL, &none), "path of the paint is null");
    REFUSED(IO, impasto_paint_load("no such.png", &none), "no such.png");
    REFUSED(NULL_POINTER, impasto_paint_create(NULL, &none), "ImpastoPaintDesc is null");
    REFUSED(NULL_POINTER, impasto_paint_create(&desc, NULL), "is null");
    desc.rgb = NULL;
    REFUSED(NULL_POINTER, impasto_paint_create(&desc, &none), "one is needed");
    desc = paint_desc();
    desc.rgba8 = bytes;
    REFUSED(PARAMETER, impasto_paint_create(&desc, &none), "given twice");
    desc = paint_desc();
    desc.width_px = 4097;
    REFUSED(PARAMETER, impasto_paint_create(&desc, &none), "4097x48");
    desc.width_px = desc.height_px = 1;
    desc.rgb = bad;
    REFUSED(PARAMETER, impasto_paint_create(&desc, &none), "0 to 1");
    CHECK(none == NULL);
}

static void no_effect(void) {
    ImpastoEffectDesc desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    ImpastoObjectParams object = {.struct_size = sizeof object};
    ImpastoImageParams image = {.struct_size = sizeof image};
    const ImpastoPaint *gone[] = {(const ImpastoPaint *)mesh, NULL};
    uint32_t of_object[] = {1};
    ImpastoImage shade = {.struct_size = sizeof shade, .width_px = SIDE, .height_px = SIDE};
    ImpastoMemory memory = {.struct_size = sizeof memory};
    ImpastoEffect *none = NULL;
    REFUSED(NULL_POINTER, impasto_effect_memory(NULL, &desc, &memory), "context is null");
    REFUSED(NULL_POINTER, impasto_effect_memory(context, NULL, &memory), "ImpastoEffectDesc is null");
    REFUSED(NULL_POINTER, impasto_effect_memory(context, &desc, NULL), "ImpastoMemory is null");
    REFUSED(PARAMETER, impasto_effect_desc_init(&desc, 4), "technique is 4");
    REFUSED(NULL_POINTER, impasto_effect_create(NULL, &desc, &none), "context is null");
    REFUSED(NULL_POINTER, impasto_effect_create(context, NULL, &none), "ImpastoEffectDesc is null");
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, NULL), "is null");
    desc.technique = 17;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "technique is 17");
    desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    desc.mesh = NULL;
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, &none), "mesh is null");
    desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    desc.paints = NULL;
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, &none), "paints is null");
    desc.paints = gone;
    REFUSED(HANDLE, impasto_effect_create(context, &desc, &none), "the paint is none");
    desc.paints = gone + 1;
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, &none), "paint is null");
    desc.paint_count = UINT32_MAX;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "65535 or less");
    desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    desc.paint_of_object = of_object;
    desc.object_count = 1;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "below the 1 paints");
    desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    desc.width_px = 0;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "size_px is 0x32");
    desc.width_px = 1 << 30;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "size_px");
    /* Parameters. */
    desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    OK(impasto_image_params_init(&image));
    desc.image = &image;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "those of another technique");
    desc.image = NULL;
    desc.object = &object;
    OK(impasto_object_params_init(&object));
    object.repeat = 2;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "repeat is 2");
    object.repeat = 0;
    object.range.low = NAN;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "range is NaN");
    object.struct_size = 4;
    REFUSED(STRUCT_SIZE, impasto_effect_create(context, &desc, &none), "sizeof(ImpastoObjectParams)");
    /* Images. */
    desc = effect_desc(IMPASTO_TECHNIQUE_ALIGNED);
    desc.shade = &shade;
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, &none), "of shade is null");
    CHECK(none == NULL);
    nothing_is_allocated();
}

/* Images of the host's that do not fit an effect. */
static void no_guides(void) {
    VkImageUsageFlags storage = VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    HostImage images[] = {
        host_image(&host, VK_FORMAT_R32_SFLOAT, storage, SIDE, SIDE),
        host_image(&host, VK_FORMAT_R32_UINT, storage, SIDE, SIDE),
        host_image(&host, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, SIDE, SIDE),
    };
    ImpastoImage shade = host_described(&images[0]), id = host_described(&images[1]);
    ImpastoImage depth = host_described(&images[2]);
    ImpastoEffectDesc desc = effect_desc(IMPASTO_TECHNIQUE_ALIGNED);
    ImpastoEffect *none = NULL;
    desc.shade = &shade;
    desc.id = &id;
    REFUSED(NULL_POINTER, impasto_effect_create(context, &desc, &none), "ImpastoImage is null");
    desc.depth = &shade;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "guide depth is R32_SFLOAT");
    desc.depth = &depth;
    id.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "made for STORAGE");
    id = host_described(&images[1]);
    shade.width_px = SIDE / 2;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "32x32, but must be 16x32");
    shade = host_described(&images[0]);
    desc.width_px = SIDE / 2;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "guides is 32x32, but must be 16x32");
    desc.width_px = SIDE;
    desc.vectors = &shade;
    REFUSED(PARAMETER, impasto_effect_create(context, &desc, &none), "vectors is given");
    CHECK(none == NULL);
    host_destroy_image(&host, &images[0]);
    host_destroy_image(&host, &images[1]);
    host_destroy_image(&host, &images[2]);
}

static void no_frame(ImpastoEffect *effect, VkCommandBuffer commands) {
    ImpastoFrame frame = frame_of();
    ImpastoPose pose = {{2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    ImpastoLight dark = {{0, 0, 0}, 1};
    ImpastoImageUse use = {.after = {0, VK_ACCESS_SHADER_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}};
    REFUSED(NULL_POINTER, impasto_effect_record(NULL, commands, &frame), "effect is null");
    REFUSED(NULL_POINTER, impasto_effect_record(effect, VK_NULL_HANDLE, &frame), "command buffer is null");
    REFUSED(NULL_POINTER, impasto_effect_record(effect, commands, NULL), "ImpastoFrame is null");
    frame.struct_size += 4096;
    REFUSED(STRUCT_SIZE, impasto_effect_record(effect, commands, &frame), "sizeof(ImpastoFrame)");
    frame = frame_of();
    frame.light_count = 0;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "lights is 0");
    frame.light_count = 9;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "8 or less");
    frame = frame_of();
    frame.lights = &dark;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "direction");
    frame.lights = NULL;
    REFUSED(NULL_POINTER, impasto_effect_record(effect, commands, &frame), "lights is null");
    frame = frame_of();
    frame.show = 3;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "show is 3");
    frame = frame_of();
    frame.reset = 7;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "reset is 7");
    frame = frame_of();
    frame.view[5] = NAN;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "not finite");
    frame = frame_of();
    frame.projection[0] *= 2;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "aspect of the projection is 0.5");
    frame = frame_of();
    frame.width_px = frame.height_px = SIDE + 1;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "size_px is 33x33");
    frame.width_px = 0;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "size_px is 0x33");
    frame = frame_of();
    frame.pose_count = 1;
    REFUSED(NULL_POINTER, impasto_effect_record(effect, commands, &frame), "poses is null");
    frame.poses = &pose;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "a turn and a move");
    frame.pose_count = 2;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "1 or less");
    frame = frame_of();
    frame.picture = &use;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "by no stage");
    use.after.stages = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
    use.after.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "is in DEPTH_STENCIL_ATTACHMENT_OPTIMAL");
    use.after.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "made for TRANSFER_DST");
    use.after.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "picture is in UNDEFINED");
    use.after.layout = (VkImageLayout)77;
    REFUSED(PARAMETER, impasto_effect_record(effect, commands, &frame), "picture is in 77");
}

static void no_composite(ImpastoEffect *effect, VkCommandBuffer commands) {
    VkImageUsageFlags copied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    VkImageUsageFlags drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | copied;
    HostImage color = host_image(&host, VK_FORMAT_R8G8B8A8_UNORM, drawn, SIDE, SIDE);
    HostImage deep = host_image(&host, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, SIDE, SIDE);
    ImpastoImage images[] = {host_described(&color), host_described(&deep)};
    ImpastoTarget target = {&images[0], &images[1]};
    ImpastoCompositeDesc desc = {.struct_size = sizeof desc, .target_count = 1, .targets = &target};
    ImpastoImageUse use = {HOST_WRITTEN, HOST_TO_BE_READ};
    ImpastoCompositeFrame frame = {.struct_size = sizeof frame, .projection = projection};
    ImpastoComposite *made = NULL;
    REFUSED(NULL_POINTER, impasto_composite_create(NULL, &desc, &made), "effect is null");
    REFUSED(NULL_POINTER, impasto_composite_create(effect, NULL, &made), "ImpastoCompositeDesc is null");
    REFUSED(NULL_POINTER, impasto_composite_create(effect, &desc, NULL), "is null");
    desc.target_count = 0;
    REFUSED(PARAMETER, impasto_composite_create(effect, &desc, &made), "targets is 0");
    desc.target_count = 1;
    desc.color = 3;
    REFUSED(PARAMETER, impasto_composite_create(effect, &desc, &made), "color is 3");
    desc.color = 0;
    images[0].width_px = 31;
    REFUSED(PARAMETER, impasto_composite_create(effect, &desc, &made), "32x32, but must be 31x32");
    images[0] = host_described(&color);
    images[0].format = VK_FORMAT_R8_UNORM;
    REFUSED(PARAMETER, impasto_composite_create(effect, &desc, &made), "target's colour is R8_UNORM");
    images[0] = host_described(&color);
    images[0].usage = copied;
    REFUSED(PARAMETER, impasto_composite_create(effect, &desc, &made), "made for COLOR_ATTACHMENT");
    images[0] = host_described(&color);
    CHECK(made == NULL);
    OK(impasto_composite_create(effect, &desc, &made));
    REFUSED(IN_USE, impasto_context_destroy(context), "not destroyed yet");
    REFUSED(NULL_POINTER, impasto_composite_record(NULL, commands, &frame), "composite is null");
    REFUSED(NULL_POINTER, impasto_composite_record(made, commands, NULL), "ImpastoCompositeFrame is null");
    REFUSED(NOT_READY, impasto_composite_record(made, commands, &frame), "no frame yet");
    {
        ImpastoFrame of_effect = frame_of();
        OK(impasto_effect_record(effect, commands, &of_effect));
    }
    REFUSED(NULL_POINTER, impasto_composite_record(made, commands, &frame), "use of color is null");
    frame.color = &use;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "made for TRANSFER_DST");
    use.before.layout = use.after.layout = VK_IMAGE_LAYOUT_GENERAL;
    REFUSED(NULL_POINTER, impasto_composite_record(made, commands, &frame), "use of depth is null");
    frame.depth = &use;
    frame.target = 1;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "below the 1 targets");
    frame.target = 0;
    frame.projection = NULL;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "depth is 0 + 0 / z");
    frame.depth_a = 0.0f;
    frame.depth_b = 1.0f;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "nearer is more");
    frame.projection = projection;
    frame.x_px = 1;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "at_px is (1, 0)");
    frame.x_px = 0;
    use.before.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    REFUSED(PARAMETER, impasto_composite_record(made, commands, &frame), "color is in UNDEFINED");
    use.before.layout = VK_IMAGE_LAYOUT_GENERAL;
    REFUSED(NULL_POINTER, impasto_composite_record(made, VK_NULL_HANDLE, &frame), "command buffer is null");
    OK(impasto_composite_destroy(made));
    REFUSED(HANDLE, impasto_composite_record(made, commands, &frame), "the composite is none");
    host_submit(&host);
    OK(impasto_context_advance(context, host.frame + 1, host.frame));
    host_destroy_image(&host, &color);
    host_destroy_image(&host, &deep);
}

static void wrong_calls(void) {
    ImpastoEffectDesc desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    ImpastoProgress progress = {.struct_size = sizeof progress};
    ImpastoPicture picture = {.struct_size = sizeof picture};
    ImpastoFrame frame = frame_of();
    ImpastoCompositeDesc over = {.struct_size = sizeof over};
    ImpastoComposite *composite;
    ImpastoEffect *effect;
    VkCommandBuffer commands;
    uint64_t bytes;
    no_device();
    no_mesh();
    no_paint();
    no_effect();
    no_guides();
    REFUSED(NULL_POINTER, impasto_context_advance(NULL, 2, 1), "context is null");
    REFUSED(PARAMETER, impasto_context_advance(context, 2, 2), "safe_frame is 2");
    REFUSED(NULL_POINTER, impasto_context_allocated_bytes(context, NULL), "bytes is null");
    REFUSED(HANDLE, impasto_context_allocated_bytes((ImpastoContext *)mesh, &bytes), "the context is none");
    REFUSED(HANDLE, impasto_context_destroy((ImpastoContext *)&bytes), "the context is none");
    OK(impasto_effect_create(context, &desc, &effect));
    REFUSED(IN_USE, impasto_context_destroy(context), "1 are not destroyed yet");
    /* Before it is ready. */
    commands = host_begin(&host);
    REFUSED(NOT_READY, impasto_effect_record(effect, commands, &frame), "not ready");
    REFUSED(NOT_READY, impasto_effect_picture(effect, &picture), "not ready");
    REFUSED(NOT_READY, impasto_effect_depth(effect, &picture), "not ready");
    REFUSED(NOT_READY, impasto_composite_create(effect, &over, &composite), "not ready");
    REFUSED(NULL_POINTER, impasto_effect_prepare(NULL, commands, &progress), "effect is null");
    REFUSED(NULL_POINTER, impasto_effect_prepare(effect, VK_NULL_HANDLE, &progress), "command buffer is null");
    REFUSED(NULL_POINTER, impasto_effect_progress(effect, NULL), "ImpastoProgress is null");
    OK(impasto_effect_progress(effect, &progress));
    CHECK(!progress.ready);
    host_submit(&host);
    OK(prepare(effect));
    REFUSED(NULL_POINTER, impasto_effect_picture(effect, NULL), "ImpastoPicture is null");
    commands = host_begin(&host);
    no_frame(effect, commands);
    no_composite(effect, commands);
    OK(impasto_effect_destroy(effect));
    REFUSED(HANDLE, impasto_effect_destroy(effect), "the effect is none: it was destroyed");
    REFUSED(HANDLE, impasto_effect_picture(effect, &picture), "the effect is none: it was destroyed");
    OK(impasto_effect_destroy(NULL));
    OK(impasto_composite_destroy(NULL));
    OK(impasto_mesh_destroy(NULL));
    OK(impasto_paint_destroy(NULL));
    OK(impasto_context_destroy(NULL));
    CHECK(!strcmp(impasto_status_text(IMPASTO_STATUS_DEVICE_LOST), "the device is lost"));
    CHECK(!strcmp(impasto_status_text(99), "an unknown status"));
    nothing_is_allocated();
}

static void on_log(void *user, uint32_t level, const char *text) {
    CHECK(level == IMPASTO_LOG_LEVEL_ERROR && text[0]);
    ++*(unsigned *)user;
}

/* A host that is told by its own calls that the device is lost, before and after the preparation. */
static void device_lost(uint32_t ready) {
    ImpastoEffectDesc desc = effect_desc(IMPASTO_TECHNIQUE_OBJECT);
    ImpastoHostDevice lent = host_lent(&host, vkGetInstanceProcAddr);
    ImpastoProgress progress = {.struct_size = sizeof progress};
    ImpastoFrame frame = frame_of();
    ImpastoEffect *effect, *none = NULL;
    VkCommandBuffer commands;
    unsigned logged = 0;
    uint64_t bytes = 1;
    lent.log = on_log;
    lent.log_user = &logged;
    OK(impasto_context_create(&lent, &context));
    OK(impasto_effect_create(context, &desc, &effect));
    if (ready) {
        OK(prepare(effect));
    }
    OK(impasto_context_device_lost(context));
    CHECK(logged == 1);
    commands = host_begin(&host);
    REFUSED(DEVICE_LOST, impasto_effect_create(context, &desc, &none), "the GPU is lost");
    REFUSED(DEVICE_LOST, impasto_effect_prepare(effect, commands, &progress), "the GPU is lost");
    if (ready) {
        REFUSED(DEVICE_LOST, impasto_effect_record(effect, commands, &frame), "the GPU is lost");
    }
    host_submit(&host);
    OK(impasto_effect_destroy(effect));
    OK(impasto_context_allocated_bytes(context, &bytes));
    CHECK(bytes == 0 && none == NULL);
    OK(impasto_context_destroy(context));
}

static void begin(PFN_vkGetInstanceProcAddr get_proc_addr, uint64_t budget) {
    ImpastoHostDevice lent = host_lent(&host, get_proc_addr);
    lent.memory_budget = budget;
    OK(impasto_context_create(&lent, &context));
}

/* Everything that an effect makes, up to a frame over an image. */
static ImpastoStatus paint_once(uint32_t technique, const HostImage *color) {
    ImpastoEffectDesc desc = effect_desc(technique);
    ImpastoDependentParams dependent = {.struct_size = sizeof dependent};
    ImpastoAlignedParams aligned = {.struct_size = sizeof aligned};
    ImpastoDirection front = {0, 0};
    ImpastoImage image = host_described(color);
    ImpastoTarget target = {&image, NULL};
    ImpastoCompositeDesc over = {.struct_size = sizeof over, .target_count = 1, .targets = &target};
    ImpastoComposite *composite = NULL;
    ImpastoEffect *effect = NULL;
    ImpastoStatus status;
    OK(impasto_dependent_params_init(&dependent));
    OK(impasto_aligned_params_init(&aligned));
    dependent.view_px = 512;
    dependent.views = &front;
    dependent.view_count = 1;
    aligned.levels = 1;
    aligned.size_px = 64;
    desc.dependent = technique == IMPASTO_TECHNIQUE_DEPENDENT ? &dependent : NULL;
    desc.aligned = technique == IMPASTO_TECHNIQUE_ALIGNED ? &aligned : NULL;
    status = impasto_effect_create(context, &desc, &effect);
    if (status == IMPASTO_STATUS_OK) {
        status = prepare(effect);
    }
    if (status == IMPASTO_STATUS_OK) {
        status = impasto_composite_create(effect, &over, &composite);
    }
    OK(impasto_composite_destroy(composite));
    OK(impasto_effect_destroy(effect));
    return status;
}

/* Lets every `step`th call and all after it fail, until there is none left to fail. */
static void fail_in_turn(uint32_t technique, const HostImage *color, unsigned step) {
    unsigned at;
    ImpastoStatus status = IMPASTO_STATUS_OUT_OF_MEMORY;
    for (at = 0; status != IMPASTO_STATUS_OK; at += step) {
        host_fail_at = UINT32_MAX;
        begin(host_failing, 0);
        host_fail_at = at;
        host_calls = 0;
        status = paint_once(technique, color);
        if (status != IMPASTO_STATUS_OK) {
            EXPECT(IMPASTO_STATUS_OUT_OF_MEMORY, status);
            CHECK(host_calls > at && impasto_last_error()[0]);
        }
        nothing_is_allocated();
        OK(impasto_context_destroy(context));
    }
    CHECK(at > 20 * step);
}

static void failing(void) {
    HostImage color = host_image(&host, VK_FORMAT_R8G8B8A8_UNORM, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, SIDE, SIDE);
    uint64_t budget;
    fail_in_turn(IMPASTO_TECHNIQUE_OBJECT, &color, 1);
    fail_in_turn(IMPASTO_TECHNIQUE_IMAGE, &color, 3);
    fail_in_turn(IMPASTO_TECHNIQUE_ALIGNED, &color, 1);
    fail_in_turn(IMPASTO_TECHNIQUE_DEPENDENT, &color, 9);
    /* The budget of the context. */
    for (budget = 1; budget < 1 << 20; budget *= 4) {
        ImpastoStatus status;
        begin(vkGetInstanceProcAddr, budget);
        status = paint_once(IMPASTO_TECHNIQUE_IMAGE, &color);
        CHECK(status == IMPASTO_STATUS_OUT_OF_MEMORY || (status == IMPASTO_STATUS_OK && budget > 1024));
        nothing_is_allocated();
        OK(impasto_context_destroy(context));
    }
    host_destroy_image(&host, &color);
}

int main(int count, char **arguments) {
    ImpastoMeshDesc tetrahedron = mesh_desc();
    ImpastoPaintDesc stripes = paint_desc();
    int validated = count == 2;
    CHECK(count == 2 || count == 3);
    CHECK(!strcmp(impasto_last_error(), ""));
    host_create(&host, validated);
    OK(impasto_mesh_create(&tetrahedron, &mesh));
    OK(impasto_paint_create(&stripes, &paint));
    if (!strcmp(arguments[1], "calls")) {
        begin(vkGetInstanceProcAddr, 0);
        wrong_calls();
        OK(impasto_context_destroy(context));
        REFUSED(HANDLE, impasto_context_destroy(context), "the context is none: it was destroyed");
        device_lost(0);
        device_lost(1);
    } else {
        failing();
    }
    OK(impasto_mesh_destroy(mesh));
    OK(impasto_paint_destroy(paint));
    host_destroy(&host);
    printf("done\n");
    return 0;
}
