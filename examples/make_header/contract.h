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
