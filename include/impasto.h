/*
 * impasto for C and C++: paints 3D models with real paint, inside of a host's own Vulkan frame.
 * Generated from src/capi by `make header`; do not edit.
 *
 * A frame with everything left at its defaults, checks of the statuses left out:
 *
 *     ImpastoHostDevice device = {.struct_size = sizeof device, .get_instance_proc_addr = vkGetInstanceProcAddr};
 *     device.instance = ...; device.physical_device = ...; device.device = ...; device.queue_family = ...;
 *     impasto_context_create(&device, &context);
 *     impasto_mesh_load("model.obj", &mesh);
 *     impasto_paint_load("strip.png", &paint);
 *
 *     ImpastoEffectDesc desc = {.struct_size = sizeof desc};
 *     impasto_effect_desc_init(&desc, IMPASTO_TECHNIQUE_ALIGNED);
 *     const ImpastoPaint *paints[] = {paint};
 *     desc.mesh = mesh; desc.paints = paints; desc.paint_count = 1; desc.width_px = 1280; desc.height_px = 720;
 *     impasto_effect_create(context, &desc, &effect);
 *
 *     for each frame of the host, with its command buffer, outside of a render pass:
 *         impasto_context_advance(context, frame_number, number_of_the_last_frame_that_the_gpu_has_finished);
 *         if (!progress.ready) {
 *             impasto_effect_prepare(effect, commands, &progress);
 *         } else {
 *             ImpastoFrame frame = {.struct_size = sizeof frame, .seed = 1, .lights = &light, .light_count = 1};
 *             (fill in view and projection)
 *             impasto_effect_record(effect, commands, &frame);
 *         }
 *         (draw with the picture of impasto_effect_picture(), or have impasto_composite_record() do it; submit)
 *
 *     when the GPU is done with all of it:
 *     impasto_effect_destroy(effect); impasto_paint_destroy(paint); impasto_mesh_destroy(mesh);
 *     impasto_context_destroy(context);
 *
 * What holds for all calls:
 *
 * Statuses. Every call but three answers with a status, and IMPASTO_STATUS_OK is 0. What failed has changed nothing,
 *   unless it says so. impasto_last_error() tells the details, to each thread its own.
 * Pointers. A pointer is to what its type says, or null; null is refused where something is needed. Arrays are as long
 *   as their counts. Everything that is pointed to is read during the call, and not kept. Texts are UTF-8; paths are
 *   what the system takes for one, on Unix any bytes.
 * Structures. The first field of those that may grow is struct_size, which the caller sets to sizeof. A library that is
 *   newer than the header takes what the header does not have as 0, which is always the default. A library that is
 *   older refuses a structure with anything but zeros in what it does not know (IMPASTO_STATUS_STRUCT_SIZE). So fill
 *   structures with zeros first, best by an initialiser. The library fills in structures no further than struct_size.
 * Handles. They are no addresses: the library looks them up. One that is null, destroyed, of another kind or no handle
 *   at all is refused (IMPASTO_STATUS_NULL_POINTER, IMPASTO_STATUS_HANDLE). To destroy null does nothing.
 * Numbers that name something (uint32_t with "An Impasto...") and switches (0 or 1) are refused when out of range.
 * Vulkan. Handles of Vulkan's are believed. The device needs Vulkan 1.1, no extension and no feature. What is recorded
 *   goes into a primary command buffer of the device and of queue_family that is being recorded, outside of a render
 *   pass, and no other thread uses it meanwhile. Afterwards its pipeline, descriptor sets, push constants and dynamic
 *   state are others. All that was recorded must be submitted, in the order of recording, to one queue.
 *   No call submits or waits for the GPU; impasto_effect_record() and impasto_composite_record() also make no Vulkan
 *   object and take no memory from it.
 * Images. Where a use of an image is told (ImpastoImageUse), the library records the barriers on both sides. The use is
 *   that of the whole image, on the queue of the recording.
 * Threads. Each context, with all that stands on it, is used by one thread at a time; contexts, meshes and paints are
 *   apart from each other. Calls on the same object from two threads wait for each other.
 * Frames. What is destroyed in a frame is freed by impasto_context_advance() when that says that the frame is safe.
 *   When the context itself is destroyed, the GPU must be done with all that was recorded.
 * Faults. A panic inside of the library does not leave it: the call answers IMPASTO_STATUS_PANIC. This needs a library
 *   that was built with unwinding, as it is by default; with `panic = "abort"` a panic ends the program. What throws or
 *   jumps out of a callback of the host's is not caught.
 */

#ifndef IMPASTO_H
#define IMPASTO_H

#include <stdint.h>
#include <vulkan/vulkan_core.h>

/**
 * The version that this header belongs to, as VK_MAKE_API_VERSION makes it. impasto_version() tells that of the
 * library: it must not be lower, and have the same major version (before 1.0 also the same minor one).
 */
#define IMPASTO_VERSION 4096

/**
 * The most arrays of paints, poses, views or targets may hold.
 */
#define IMPASTO_MAX_COUNT 65535

/**
 * What a call answers. impasto_last_error() has the details.
 */
enum ImpastoStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * It is done.
   */
  IMPASTO_STATUS_OK = 0,
  /**
   * A pointer or handle that is needed is null.
   */
  IMPASTO_STATUS_NULL_POINTER = 1,
  /**
   * A handle is of another kind, was destroyed, or never was one.
   */
  IMPASTO_STATUS_HANDLE = 2,
  /**
   * A struct_size is none, or the structure uses what this version of the library does not know.
   */
  IMPASTO_STATUS_STRUCT_SIZE = 3,
  /**
   * A value is out of its range, or does not fit the others.
   */
  IMPASTO_STATUS_PARAMETER = 4,
  /**
   * A file was read, but what it holds is not usable; or no triangle of a mesh is.
   */
  IMPASTO_STATUS_FILE = 5,
  /**
   * A file could not be read, or the system has no thread to give.
   */
  IMPASTO_STATUS_IO = 6,
  /**
   * The effect is not prepared yet, or has recorded no frame yet.
   */
  IMPASTO_STATUS_NOT_READY = 7,
  /**
   * Something still stands on what was to be destroyed.
   */
  IMPASTO_STATUS_IN_USE = 8,
  /**
   * The device lacks something that is needed, or a preparation has failed before.
   */
  IMPASTO_STATUS_DEVICE = 9,
  /**
   * The device is lost: all that can be done is to destroy what was made on it.
   */
  IMPASTO_STATUS_DEVICE_LOST = 10,
  /**
   * The memory budget, the device or the system has not enough memory.
   */
  IMPASTO_STATUS_OUT_OF_MEMORY = 11,
  /**
   * A Vulkan call failed in another way.
   */
  IMPASTO_STATUS_VULKAN = 12,
  /**
   * A fault in impasto was caught. What the call was for can only be destroyed.
   */
  IMPASTO_STATUS_PANIC = 13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoStatus ImpastoStatus;
#else
typedef uint32_t ImpastoStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How levels of view-aligned projection are blended.
 */
enum ImpastoBlend
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * With the contrast given back that averaging takes.
   */
  IMPASTO_BLEND_CONTRAST = 0,
  /**
   * As the hardware blends.
   */
  IMPASTO_BLEND_LINEAR = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoBlend ImpastoBlend;
#else
typedef uint32_t ImpastoBlend;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How grave a message to the log is.
 */
enum ImpastoLogLevel
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Something is wrong.
   */
  IMPASTO_LOG_LEVEL_ERROR = 0,
  /**
   * Something looks wrong.
   */
  IMPASTO_LOG_LEVEL_WARNING = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoLogLevel ImpastoLogLevel;
#else
typedef uint32_t ImpastoLogLevel;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How a strip repeats over the surface.
 */
enum ImpastoRepeat
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Its upper edge is cut into its lower one.
   */
  IMPASTO_REPEAT_WRAP = 0,
  /**
   * Every other repeat is mirrored.
   */
  IMPASTO_REPEAT_MIRROR = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoRepeat ImpastoRepeat;
#else
typedef uint32_t ImpastoRepeat;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What happens to object-based paint where a mesh falls apart into pieces.
 */
enum ImpastoSeams
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * It goes on from the closest vertex.
   */
  IMPASTO_SEAMS_CARRY = 0,
  /**
   * Each piece begins anew, which shows the seam.
   */
  IMPASTO_SEAMS_FRESH = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoSeams ImpastoSeams;
#else
typedef uint32_t ImpastoSeams;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a frame shows.
 */
enum ImpastoShow
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Colour and texture.
   */
  IMPASTO_SHOW_PAINTED = 0,
  /**
   * Colour alone.
   */
  IMPASTO_SHOW_COLOR = 1,
  /**
   * The texture alone.
   */
  IMPASTO_SHOW_TEXTURE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoShow ImpastoShow;
#else
typedef uint32_t ImpastoShow;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the colours of a target are.
 */
enum ImpastoTargetColor
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * As its format suggests: light in SRGB and float formats, else stored values.
   */
  IMPASTO_TARGET_COLOR_BY_FORMAT = 0,
  /**
   * Values as files have them.
   */
  IMPASTO_TARGET_COLOR_STORED = 1,
  /**
   * Light.
   */
  IMPASTO_TARGET_COLOR_LIGHT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoTargetColor ImpastoTargetColor;
#else
typedef uint32_t ImpastoTargetColor;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * By which technique an effect paints.
 */
enum ImpastoTechnique
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Object-based texture mapping: the cheapest, with paint that is pinned to the surface.
   */
  IMPASTO_TECHNIQUE_OBJECT = 0,
  /**
   * Image-based texture synthesis: the best picture, synthesised for every frame.
   */
  IMPASTO_TECHNIQUE_IMAGE = 1,
  /**
   * View-aligned 3D texture projection: nearly that picture, in real time.
   */
  IMPASTO_TECHNIQUE_ALIGNED = 2,
  /**
   * View-dependent interpolation: paint that was synthesised for views, in real time.
   */
  IMPASTO_TECHNIQUE_DEPENDENT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoTechnique ImpastoTechnique;
#else
typedef uint32_t ImpastoTechnique;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * How the levels of view-aligned projection are made to repeat.
 */
enum ImpastoTileable
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /**
   * Blocks are quilted around the edges as well.
   */
  IMPASTO_TILEABLE_WRAP = 0,
  /**
   * The quilt is blended with itself under a circular mask.
   */
  IMPASTO_TILEABLE_MASK = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ImpastoTileable ImpastoTileable;
#else
typedef uint32_t ImpastoTileable;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A pass that lays the picture of an effect over the host's own.
 */
typedef struct ImpastoComposite ImpastoComposite;

/**
 * A device to paint on, borrowed from the host.
 */
typedef struct ImpastoContext ImpastoContext;

/**
 * A mesh that is painted by one technique, picture after picture.
 */
typedef struct ImpastoEffect ImpastoEffect;

/**
 * A model.
 */
typedef struct ImpastoMesh ImpastoMesh;

/**
 * A strip of paint, taken apart into colours and texture.
 */
typedef struct ImpastoPaint ImpastoPaint;

/**
 * What the library needs of instance, device and queue.
 */
typedef struct ImpastoRequirements {
  /**
   * sizeof(ImpastoRequirements), set by the caller.
   */
  uint32_t struct_size;
  /**
   * The least Vulkan version of instance and device.
   */
  uint32_t api_version;
  /**
   * What the family of the queue must do.
   */
  VkQueueFlags queue_flags;
  /**
   * Instance extensions: 0.
   */
  uint32_t instance_extension_count;
  /**
   * Device extensions: 0.
   */
  uint32_t device_extension_count;
  /**
   * Device features that must be enabled: 0.
   */
  uint32_t feature_count;
} ImpastoRequirements;

/**
 * A host's log. `level` is an ImpastoLogLevel; `text` stays for the time of the call. It may be called from any
 * thread, from several at once, and within any call of the library; it must not call the library.
 */
typedef void (*ImpastoLog)(void *user, uint32_t level, const char *text);

/**
 * A host's device, to be borrowed. All of it must outlive the context.
 */
typedef struct ImpastoHostDevice {
  /**
   * sizeof(ImpastoHostDevice).
   */
  uint32_t struct_size;
  /**
   * The family of the queue on which the host will submit; it must draw and compute.
   */
  uint32_t queue_family;
  /**
   * Where all functions come from.
   */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /**
   * The instance, made for Vulkan 1.1 or later.
   */
  VkInstance instance;
  /**
   * The physical device.
   */
  VkPhysicalDevice physical_device;
  /**
   * The device.
   */
  VkDevice device;
  /**
   * The features that were enabled, for faster paths; null: none.
   */
  const VkPhysicalDeviceFeatures *enabled_features;
  /**
   * The host's pipeline cache, or null.
   */
  VkPipelineCache pipeline_cache;
  /**
   * Bytes of GPU memory that the context may take; 0: 4 GiB.
   */
  uint64_t memory_budget;
  /**
   * Where messages go: what no status can carry, and that the device was lost; null: nowhere.
   */
  ImpastoLog log;
  /**
   * What the log is called with.
   */
  void *log_user;
  /**
   * 1 if the instance has VK_EXT_debug_utils: objects are named and passes labelled then.
   */
  uint32_t debug_utils;
  /**
   * 0.
   */
  uint32_t reserved;
} ImpastoHostDevice;

/**
 * Geometry at hand.
 */
typedef struct ImpastoMeshDesc {
  /**
   * sizeof(ImpastoMeshDesc).
   */
  uint32_t struct_size;
  /**
   * Vertices.
   */
  uint32_t vertex_count;
  /**
   * Three numbers for each vertex.
   */
  const float *positions;
  /**
   * Three numbers for each vertex; those that are 0 or not finite are computed, and all if this is null.
   */
  const float *normals;
  /**
   * Three for each triangle, counter-clockwise seen from the front.
   */
  const uint32_t *indices;
  /**
   * How many indices each object has, one object after the other; null makes everything one object.
   */
  const uint32_t *object_index_counts;
  /**
   * Indices in all.
   */
  uint32_t index_count;
  /**
   * Objects that object_index_counts tells of.
   */
  uint32_t object_count;
  /**
   * Where normals have to be computed, faces that meet at a sharper angle keep a hard edge: 0 to 180 degrees,
   * usually 60.
   */
  float crease_deg;
  /**
   * 0.
   */
  uint32_t reserved;
} ImpastoMeshDesc;

/**
 * What a mesh is.
 */
typedef struct ImpastoMeshInfo {
  /**
   * sizeof(ImpastoMeshInfo), set by the caller.
   */
  uint32_t struct_size;
  /**
   * Objects, each with paint and pose of its own.
   */
  uint32_t object_count;
  /**
   * Triangles.
   */
  uint32_t triangle_count;
  /**
   * The lowest coordinates of all vertices.
   */
  float low[3];
  /**
   * The highest.
   */
  float high[3];
} ImpastoMeshInfo;

/**
 * A strip of paint at hand, dark on the left, light on the right; rows from the top, tightly packed. One of the two
 * arrays is given.
 */
typedef struct ImpastoPaintDesc {
  /**
   * sizeof(ImpastoPaintDesc).
   */
  uint32_t struct_size;
  /**
   * Width, 1 to 4096 pixels.
   */
  uint32_t width_px;
  /**
   * Height, 1 to 4096 pixels.
   */
  uint32_t height_px;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Four bytes for each pixel, the last of which is not looked at; or null.
   */
  const uint8_t *rgba8;
  /**
   * Three numbers from 0 to 1 for each pixel, or null.
   */
  const float *rgb;
} ImpastoPaintDesc;

/**
 * A range of shade that is spread over the whole strip; all of it is 0 to 1. Plain: never grows.
 */
typedef struct ImpastoShadeRange {
  /**
   * The shade that takes the strip's dark end.
   */
  float low;
  /**
   * The shade that takes its light end.
   */
  float high;
} ImpastoShadeRange;

/**
 * How object-based texture mapping paints.
 */
typedef struct ImpastoObjectParams {
  /**
   * sizeof(ImpastoObjectParams).
   */
  uint32_t struct_size;
  /**
   * How often the strip repeats over the mesh, 0.01 to 1000.
   */
  float repeats;
  /**
   * The most by which it changes at random from a vertex to the next, 0 to 1 repeats.
   */
  float variation;
  /**
   * The direction along which the strip repeats, of any length but 0.
   */
  float axis[3];
  /**
   * An ImpastoSeams.
   */
  uint32_t seams;
  /**
   * An ImpastoRepeat.
   */
  uint32_t repeat;
  /**
   * Enters the random choices.
   */
  uint32_t seed;
  /**
   * 1: keep the paint visible where the mapping loses it.
   */
  uint32_t keep_paint;
  /**
   * The range of shade that is spread over the strip.
   */
  struct ImpastoShadeRange range;
} ImpastoObjectParams;

/**
 * How blocks of a strip are quilted. Plain: never grows.
 */
typedef struct ImpastoQuilt {
  /**
   * Side of the square blocks, 4 to 64 pixels.
   */
  uint32_t block_px;
  /**
   * By how much neighbours overlap, 1 pixel to half of block_px.
   */
  uint32_t overlap_px;
  /**
   * How much worse than the best a position may fit and still be chosen, 0 to 10 of the least error.
   */
  float tolerance;
} ImpastoQuilt;

/**
 * How image-based texture synthesis paints.
 */
typedef struct ImpastoImageParams {
  /**
   * sizeof(ImpastoImageParams).
   */
  uint32_t struct_size;
  /**
   * How to quilt.
   */
  struct ImpastoQuilt quilt;
  /**
   * How many block sizes a block may be from its shade's place on the strip, 0 to 1000; negative: by the strip.
   */
  float k;
  /**
   * The range of shade that is spread over the strip.
   */
  struct ImpastoShadeRange range;
  /**
   * How much each block must match the last frame, 0.25 to 3 in steps of 0.25; 0: not at all.
   */
  float previous_weight;
  /**
   * 1: let texture follow the surface from frame to frame, and repair it where it no longer fits.
   */
  uint32_t carry;
  /**
   * By what factor carried texture may be stretched, 1.05 to 1.5.
   */
  float stretch;
  /**
   * How much worse than the best a repaired position may fit, 0 to 10.
   */
  float repair_tolerance;
  /**
   * How many block sizes beyond its place carried texture may be from, 0 to 100.
   */
  float slack;
} ImpastoImageParams;

/**
 * How view-aligned 3D texture projection paints.
 */
typedef struct ImpastoAlignedParams {
  /**
   * sizeof(ImpastoAlignedParams).
   */
  uint32_t struct_size;
  /**
   * Levels of shade, 1 to 64.
   */
  uint32_t levels;
  /**
   * Side of each level's texture, 16 to 2048 pixels.
   */
  uint32_t size_px;
  /**
   * An ImpastoTileable.
   */
  uint32_t tileable;
  /**
   * How to quilt.
   */
  struct ImpastoQuilt quilt;
  /**
   * Texels of the texture to a pixel of the picture, 0.05 to 4.
   */
  float density;
  /**
   * Where the texture lies, pixels of the picture to the left and up.
   */
  float offset_px[2];
  /**
   * An ImpastoBlend.
   */
  uint32_t blend;
  /**
   * The range of shade that is spread over the strip.
   */
  struct ImpastoShadeRange range;
  /**
   * 1: let each object's texture follow it.
   */
  uint32_t follow;
} ImpastoAlignedParams;

/**
 * A direction from which a model is looked at. Plain: never grows.
 */
typedef struct ImpastoDirection {
  /**
   * 0 looks from +z, 90 from +x; degrees.
   */
  float yaw_deg;
  /**
   * How far above the horizon the eye is, -90 to 90 degrees.
   */
  float pitch_deg;
} ImpastoDirection;

/**
 * Parallel light from one direction. Plain: never grows.
 */
typedef struct ImpastoLight {
  /**
   * From the surface towards the light, in world space, of any length but 0.
   */
  float direction[3];
  /**
   * Its weight among the others, 1e-6 to 1e6.
   */
  float intensity;
} ImpastoLight;

/**
 * How view-dependent interpolation paints.
 */
typedef struct ImpastoDependentParams {
  /**
   * sizeof(ImpastoDependentParams).
   */
  uint32_t struct_size;
  /**
   * Width and height of a view's texture, pixels.
   */
  uint32_t view_px;
  /**
   * The views; null: fourteen around the model.
   */
  const struct ImpastoDirection *views;
  /**
   * The lights that the views are synthesised for; null: the library's default.
   */
  const struct ImpastoLight *lights;
  /**
   * How many views.
   */
  uint32_t view_count;
  /**
   * How many lights, at most 8.
   */
  uint32_t light_count;
  /**
   * How to quilt.
   */
  struct ImpastoQuilt quilt;
  /**
   * How many block sizes a block may be from its shade's place on the strip, 0 to 1000; negative: by the strip.
   */
  float k;
  /**
   * 1: give back the contrast that blending takes.
   */
  uint32_t keep_contrast;
  /**
   * The range of shade that is spread over the strip.
   */
  struct ImpastoShadeRange range;
  /**
   * By how many degrees a frame a face's texture follows the camera, 0 to 180.
   */
  float follow_deg;
} ImpastoDependentParams;

/**
 * An image of the host's: 2D, with one level and one layer. It and its view must live until whatever was made with it
 * is destroyed and the GPU is done with it.
 */
typedef struct ImpastoImage {
  /**
   * sizeof(ImpastoImage).
   */
  uint32_t struct_size;
  /**
   * Its format.
   */
  VkFormat format;
  /**
   * The image.
   */
  VkImage image;
  /**
   * A view of the whole of it.
   */
  VkImageView view;
  /**
   * Its width, pixels.
   */
  uint32_t width_px;
  /**
   * Its height, pixels.
   */
  uint32_t height_px;
  /**
   * What it was made for.
   */
  VkImageUsageFlags usage;
  /**
   * 0.
   */
  uint32_t reserved;
} ImpastoImage;

/**
 * What is painted, with what, and how.
 */
typedef struct ImpastoEffectDesc {
  /**
   * sizeof(ImpastoEffectDesc).
   */
  uint32_t struct_size;
  /**
   * An ImpastoTechnique.
   */
  uint32_t technique;
  /**
   * The model.
   */
  const struct ImpastoMesh *mesh;
  /**
   * The paints.
   */
  const struct ImpastoPaint *const *paints;
  /**
   * For each object of the mesh which of the paints it has; null: all have the first.
   */
  const uint32_t *paint_of_object;
  /**
   * How many paints.
   */
  uint32_t paint_count;
  /**
   * How many objects paint_of_object tells of.
   */
  uint32_t object_count;
  /**
   * Width of the picture, pixels.
   */
  uint32_t width_px;
  /**
   * Height of the picture, pixels.
   */
  uint32_t height_px;
  /**
   * Pixel comparisons of one recording of the preparation; 0: 25 million, less than a millisecond of a large GPU.
   */
  uint64_t piece;
  /**
   * Parameters of the technique, at most one of these four; null: the defaults.
   */
  const struct ImpastoObjectParams *object;
  /**
   * See above.
   */
  const struct ImpastoImageParams *image;
  /**
   * See above.
   */
  const struct ImpastoAlignedParams *aligned;
  /**
   * See above.
   */
  const struct ImpastoDependentParams *dependent;
  /**
   * The host's own image of shades, for IMPASTO_TECHNIQUE_IMAGE and IMPASTO_TECHNIQUE_ALIGNED, together with id and
   * depth; null: the library draws all three. VK_FORMAT_R32_SFLOAT, made for STORAGE; 0 dark to 1 light.
   */
  const struct ImpastoImage *shade;
  /**
   * Object index + 1, and 0 in the background. VK_FORMAT_R32_UINT, made for STORAGE, and for TRANSFER_SRC where
   * texture is carried.
   */
  const struct ImpastoImage *id;
  /**
   * 0 near to 1 far by the projection of the frame, 1 where id is 0. VK_FORMAT_D32_SFLOAT or
   * VK_FORMAT_X8_D24_UNORM_PACK32, made for DEPTH_STENCIL_ATTACHMENT, for SAMPLED where the picture is laid over
   * others, and for SAMPLED and TRANSFER_SRC where texture is carried.
   */
  const struct ImpastoImage *depth;
  /**
   * The host's motion vectors, where IMPASTO_TECHNIQUE_IMAGE carries texture; null: the library follows the poses.
   * Two or four channels of floats, made for SAMPLED.
   */
  const struct ImpastoImage *vectors;
  /**
   * What a vector is multiplied by to be the way from a pixel to its surface's place in the previous frame, in
   * pixels to the right and down.
   */
  float vectors_scale[2];
  /**
   * How much the distance of a surface may change in a frame, 0 to 1 of it.
   */
  float vectors_depth_tolerance;
  /**
   * The seed of what is synthesised once.
   */
  uint32_t seed;
} ImpastoEffectDesc;

/**
 * How much GPU memory an effect takes.
 */
typedef struct ImpastoMemory {
  /**
   * sizeof(ImpastoMemory), set by the caller.
   */
  uint32_t struct_size;
  /**
   * 0.
   */
  uint32_t reserved;
  /**
   * Bytes that it keeps once it is ready.
   */
  uint64_t persistent_bytes;
  /**
   * Bytes that it takes at the most while it is prepared.
   */
  uint64_t preparation_bytes;
  /**
   * Bytes that a frame takes besides: 0.
   */
  uint64_t frame_bytes;
} ImpastoMemory;

/**
 * How far a preparation is.
 */
typedef struct ImpastoProgress {
  /**
   * sizeof(ImpastoProgress), set by the caller.
   */
  uint32_t struct_size;
  /**
   * 1: frames can be recorded.
   */
  uint32_t ready;
  /**
   * 0 to 1, never less than before.
   */
  float done;
  /**
   * 1: the last call of impasto_effect_prepare() has recorded something.
   */
  uint32_t recorded;
  /**
   * What is being done.
   */
  char step[48];
} ImpastoProgress;

/**
 * An image of an effect.
 */
typedef struct ImpastoPicture {
  /**
   * sizeof(ImpastoPicture), set by the caller.
   */
  uint32_t struct_size;
  /**
   * Its format.
   */
  VkFormat format;
  /**
   * The image; it lives as long as the effect.
   */
  VkImage image;
  /**
   * A view of the whole of it.
   */
  VkImageView view;
  /**
   * Its width, pixels.
   */
  uint32_t width_px;
  /**
   * Its height, pixels.
   */
  uint32_t height_px;
  /**
   * What it was made for.
   */
  VkImageUsageFlags usage;
  /**
   * The layout that it lies in after all that was recorded.
   */
  VkImageLayout layout;
  /**
   * The distances that depth 0 and depth 1 stand for in the last frame; 0 before the first.
   */
  float near_plane;
  /**
   * See above.
   */
  float far_plane;
} ImpastoPicture;

/**
 * Where an object is: a column-major matrix from the mesh to world space that turns and moves, and does nothing else.
 * Plain: never grows.
 */
typedef struct ImpastoPose {
  /**
   * The columns, one after the other.
   */
  float matrix[16];
} ImpastoPose;

/**
 * How an image is used at a point of the command buffer. Plain: never grows.
 */
typedef struct ImpastoUse {
  /**
   * The stages that use it, or have used it.
   */
  VkPipelineStageFlags stages;
  /**
   * The accesses.
   */
  VkAccessFlags access;
  /**
   * The layout that it lies in.
   */
  VkImageLayout layout;
} ImpastoUse;

/**
 * How an image was used before a call records, and how it will be after. The library records the barriers on both
 * sides. Plain: never grows.
 */
typedef struct ImpastoImageUse {
  /**
   * What the host has done last. All zero: what the library knows of it.
   */
  struct ImpastoUse before;
  /**
   * What the host will do next. All zero: the library leaves it as it is, and where impasto_effect_picture() says.
   */
  struct ImpastoUse after;
} ImpastoImageUse;

/**
 * A frame, as the host wants it. Matrices are column-major. Where everything was in the frame before the effect
 * remembers; a host may shift the origin of its world in between, as long as camera and poses move with it.
 */
typedef struct ImpastoFrame {
  /**
   * sizeof(ImpastoFrame).
   */
  uint32_t struct_size;
  /**
   * The seed of what is synthesised for this frame; the same in all frames is what a sequence wants.
   */
  uint32_t seed;
  /**
   * World space to view space: a turn and a move. The view may look along -z or +z.
   */
  float view[16];
  /**
   * View space to clip space with depth 0 to 1, without jitter. Depth may be reversed, and far at infinity.
   */
  float projection[16];
  /**
   * The poses, in the order of the objects.
   */
  const struct ImpastoPose *poses;
  /**
   * The lights.
   */
  const struct ImpastoLight *lights;
  /**
   * How many objects have a pose; the others are where the mesh has them.
   */
  uint32_t pose_count;
  /**
   * How many lights, 1 to 8.
   */
  uint32_t light_count;
  /**
   * An ImpastoShow.
   */
  uint32_t show;
  /**
   * 1: the frame has nothing to do with the one before: a cut, or a jump of the camera.
   */
  uint32_t reset;
  /**
   * Width and height of what is drawn, pixels, in the picture's upper left corner: for a host that changes its
   * resolution from frame to frame. 0 and 0: all of the picture. Image-based painting knows no other.
   */
  uint32_t width_px;
  /**
   * See above.
   */
  uint32_t height_px;
  /**
   * The use of the picture; null: nothing to tell.
   */
  const struct ImpastoImageUse *picture;
  /**
   * The use of the picture's depth. Where it is the host's image it must be told, as for the others below.
   */
  const struct ImpastoImageUse *depth;
  /**
   * The use of the host's image of shades, if it has one.
   */
  const struct ImpastoImageUse *shade;
  /**
   * The use of the host's image of IDs, if it has one.
   */
  const struct ImpastoImageUse *id;
  /**
   * The use of the host's motion vectors, if it has any.
   */
  const struct ImpastoImageUse *vectors;
} ImpastoFrame;

/**
 * A host's image that is painted into, as large as the picture or larger. Plain: never grows.
 */
typedef struct ImpastoTarget {
  /**
   * Its colours: R8G8B8A8 or B8G8R8A8, UNORM or SRGB, A2B10G10R10_UNORM_PACK32 or R16G16B16A16_SFLOAT, made for
   * COLOR_ATTACHMENT.
   */
  const struct ImpastoImage *color;
  /**
   * Its depth, in any format of Vulkan's for depth but D16_UNORM_S8_UINT, made for DEPTH_STENCIL_ATTACHMENT; null:
   * nothing hides the picture.
   */
  const struct ImpastoImage *depth;
} ImpastoTarget;

/**
 * What a picture is laid over.
 */
typedef struct ImpastoCompositeDesc {
  /**
   * sizeof(ImpastoCompositeDesc).
   */
  uint32_t struct_size;
  /**
   * How many targets, as of a swapchain; all of the same formats.
   */
  uint32_t target_count;
  /**
   * The targets.
   */
  const struct ImpastoTarget *targets;
  /**
   * An ImpastoTargetColor.
   */
  uint32_t color;
  /**
   * 1: in the targets' depth nearer is more.
   */
  uint32_t reversed;
} ImpastoCompositeDesc;

/**
 * How a picture is laid over a target.
 */
typedef struct ImpastoCompositeFrame {
  /**
   * sizeof(ImpastoCompositeFrame).
   */
  uint32_t struct_size;
  /**
   * The number of the target.
   */
  uint32_t target;
  /**
   * 16 numbers: the projection that the host has drawn the target's depth with; null: depth_a and depth_b tell.
   */
  const float *projection;
  /**
   * The depth that the host has for a surface at distance z is depth_a + depth_b / z.
   */
  float depth_a;
  /**
   * See above.
   */
  float depth_b;
  /**
   * Where the picture's upper left corner comes to lie in the target, pixels to the right.
   */
  uint32_t x_px;
  /**
   * And down.
   */
  uint32_t y_px;
  /**
   * The use of the target's colours, before and after.
   */
  const struct ImpastoImageUse *color;
  /**
   * The use of the target's depth, if it has one.
   */
  const struct ImpastoImageUse *depth;
} ImpastoCompositeFrame;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of the library, as IMPASTO_VERSION.
 */
uint32_t impasto_version(void);

/**
 * A few words on a status, which stay for ever.
 */
const char *impasto_status_text(uint32_t status);

/**
 * What went wrong in the last call of this thread that failed, with the details; "" if none has. It stays until the
 * next one fails.
 */
const char *impasto_last_error(void);

/**
 * Tells what the library needs, before there is a device.
 */
ImpastoStatus impasto_requirements(struct ImpastoRequirements *requirements);

/**
 * Tells whether a device, which need not be made yet, and a family of its queues do: IMPASTO_STATUS_OK, or
 * IMPASTO_STATUS_DEVICE and in words what is missing. impasto_context_create() looks too.
 */
ImpastoStatus impasto_device_check(PFN_vkGetInstanceProcAddr get_instance_proc_addr,
                                   VkInstance instance,
                                   VkPhysicalDevice physical_device,
                                   uint32_t queue_family);

/**
 * Borrows a device.
 */
ImpastoStatus impasto_context_create(const struct ImpastoHostDevice *device, struct ImpastoContext **context);

/**
 * Tells where the GPU is: what is recorded from here on belongs to `current_frame`, and everything recorded in frames
 * up to and including `safe_frame` has run. What was destroyed in safe frames is freed now. Once a frame, and before
 * each call of impasto_effect_prepare().
 */
ImpastoStatus impasto_context_advance(const struct ImpastoContext *context,
                                      uint64_t current_frame,
                                      uint64_t safe_frame);

/**
 * Tells that the device is lost, as the host has learnt from its own calls; what the library's calls answer it notes
 * itself. From here on calls that would call Vulkan answer with IMPASTO_STATUS_DEVICE_LOST. What was made on the
 * context can be destroyed as always, without a wait.
 */
ImpastoStatus impasto_context_device_lost(const struct ImpastoContext *context);

/**
 * The bytes of GPU memory that what stands on the context takes now.
 */
ImpastoStatus impasto_context_allocated_bytes(const struct ImpastoContext *context, uint64_t *bytes);

/**
 * Gives the device back; null is fine. The GPU must be done with all that was recorded. What stands on the context
 * must be destroyed before, else nothing happens and the answer is IMPASTO_STATUS_IN_USE.
 */
ImpastoStatus impasto_context_destroy(struct ImpastoContext *context);

/**
 * Fills in the defaults of the library; what has none is 0. The caller has set struct_size.
 */
ImpastoStatus impasto_mesh_desc_init(struct ImpastoMeshDesc *desc);

/**
 * Reads a Wavefront OBJ file.
 */
ImpastoStatus impasto_mesh_load(const char *file, struct ImpastoMesh **mesh);

/**
 * Makes a mesh of geometry at hand, which is copied.
 */
ImpastoStatus impasto_mesh_create(const struct ImpastoMeshDesc *desc, struct ImpastoMesh **mesh);

/**
 * Tells what a mesh is.
 */
ImpastoStatus impasto_mesh_info(const struct ImpastoMesh *mesh, struct ImpastoMeshInfo *info);

/**
 * Destroys a mesh; null is fine. Effects that were made with it keep what they need.
 */
ImpastoStatus impasto_mesh_destroy(struct ImpastoMesh *mesh);

/**
 * Reads a picture of a strip (PNG, JPEG, BMP, GIF or TIFF).
 */
ImpastoStatus impasto_paint_load(const char *file, struct ImpastoPaint **paint);

/**
 * Makes a paint of pixels at hand, which are copied.
 */
ImpastoStatus impasto_paint_create(const struct ImpastoPaintDesc *desc, struct ImpastoPaint **paint);

/**
 * Destroys a paint; null is fine. Effects that were made with it keep what they need.
 */
ImpastoStatus impasto_paint_destroy(struct ImpastoPaint *paint);

/**
 * Fills in the defaults of the library. The caller has set struct_size.
 */
ImpastoStatus impasto_object_params_init(struct ImpastoObjectParams *params);

/**
 * Fills in the defaults of the library. The caller has set struct_size.
 */
ImpastoStatus impasto_image_params_init(struct ImpastoImageParams *params);

/**
 * Fills in the defaults of the library. The caller has set struct_size.
 */
ImpastoStatus impasto_aligned_params_init(struct ImpastoAlignedParams *params);

/**
 * Fills in the defaults of the library. The caller has set struct_size.
 */
ImpastoStatus impasto_dependent_params_init(struct ImpastoDependentParams *params);

/**
 * Fills in the defaults of the library for a technique; what has none is 0. The caller has set struct_size.
 */
ImpastoStatus impasto_effect_desc_init(struct ImpastoEffectDesc *desc, uint32_t technique);

/**
 * Tells how much GPU memory an effect would take, without making it.
 */
ImpastoStatus impasto_effect_memory(const struct ImpastoContext *context,
                                    const struct ImpastoEffectDesc *desc,
                                    struct ImpastoMemory *memory);

/**
 * Starts to prepare an effect, on a thread of its own. Mesh and paints may be destroyed then.
 */
ImpastoStatus impasto_effect_create(const struct ImpastoContext *context,
                                    const struct ImpastoEffectDesc *desc,
                                    struct ImpastoEffect **effect);

/**
 * Records the next piece of the preparation, if one is due. Once a frame, or more often, until it is ready. `progress`
 * may be null.
 */
ImpastoStatus impasto_effect_prepare(const struct ImpastoEffect *effect,
                                     VkCommandBuffer commands,
                                     struct ImpastoProgress *progress);

/**
 * Tells how far the preparation is.
 */
ImpastoStatus impasto_effect_progress(const struct ImpastoEffect *effect, struct ImpastoProgress *progress);

/**
 * Tells of the picture: VK_FORMAT_R8G8B8A8_UNORM, straight alpha, background 0.
 */
ImpastoStatus impasto_effect_picture(const struct ImpastoEffect *effect, struct ImpastoPicture *picture);

/**
 * Tells of the picture's depth, 0 near to 1 far, and 1 where nothing is; the host's own where it draws the guides.
 */
ImpastoStatus impasto_effect_depth(const struct ImpastoEffect *effect, struct ImpastoPicture *depth);

/**
 * Destroys an effect; null is fine. What the GPU still uses is freed when the frame is safe. A preparation that is
 * under way is given up, and waited for on the CPU.
 */
ImpastoStatus impasto_effect_destroy(struct ImpastoEffect *effect);

/**
 * Records a frame of an effect that is ready, and nothing if it fails. It must be submitted.
 */
ImpastoStatus impasto_effect_record(const struct ImpastoEffect *effect,
                                    VkCommandBuffer commands,
                                    const struct ImpastoFrame *frame);

/**
 * Prepares to lay the picture of an effect that is ready over a host's images.
 */
ImpastoStatus impasto_composite_create(const struct ImpastoEffect *effect,
                                       const struct ImpastoCompositeDesc *desc,
                                       struct ImpastoComposite **composite);

/**
 * Records the picture of the effect's last frame into a target, and nothing if it fails. It must be submitted.
 */
ImpastoStatus impasto_composite_record(const struct ImpastoComposite *composite,
                                       VkCommandBuffer commands,
                                       const struct ImpastoCompositeFrame *frame);

/**
 * Destroys a composite; null is fine. What the GPU still uses is freed when the frame is safe.
 */
ImpastoStatus impasto_composite_destroy(struct ImpastoComposite *composite);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* IMPASTO_H */
