/* A host that knows of the library only what impasto.h says: its own Vulkan instance, device, queue and command buffer.
 * Its device has no extension and no feature. Validation, with synchronisation, watches all of it. */
#ifndef HOST_H
#define HOST_H

#include <impasto.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

typedef struct Host {
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    VkDevice device;
    uint32_t family;
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    uint64_t frame;
    unsigned messages;
} Host;

typedef struct HostImage {
    VkImage image;
    VkImageView view;
    VkDeviceMemory memory;
    VkFormat format;
    VkImageUsageFlags usage;
    uint32_t width, height;
} HostImage;

/* Ends the program with a word on where and why, unless it is so. */
#define CHECK(is_so)                                                                     \
    do {                                                                                 \
        if (!(is_so)) {                                                                  \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #is_so);          \
            exit(1);                                                                     \
        }                                                                                \
    } while (0)

/* Ends the program unless a call answers with this status. */
#define EXPECT(status, call) host_expect((status), (call), #call, __FILE__, __LINE__)
#define OK(call) EXPECT(IMPASTO_STATUS_OK, call)
void host_expect(ImpastoStatus expected, ImpastoStatus status, const char *call, const char *file, int line);

/* Without the validation layer where `validated` is 0. */
void host_create(Host *host, int validated);
/* Ends the program if the validation layer has said anything. */
void host_destroy(Host *host);
/* What impasto_context_create() wants, with this get-proc-addr. */
ImpastoHostDevice host_lent(const Host *host, PFN_vkGetInstanceProcAddr get_proc_addr);

/* The command buffer of the next frame, which begins. */
VkCommandBuffer host_begin(Host *host);
/* Submits it and waits. */
void host_submit(Host *host);

HostImage host_image(Host *host, VkFormat format, VkImageUsageFlags usage, uint32_t width, uint32_t height);
void host_destroy_image(Host *host, HostImage *image);
/* Texels of 4 bytes. The image is left as the destination of a copy. */
void host_write(Host *host, const HostImage *image, const void *texels);
/* Texels of 4 bytes of an image that is ready to be copied from. */
void *host_read(Host *host, VkImage image, uint32_t width, uint32_t height);
/* How host_write leaves an image and host_read wants it. */
extern const ImpastoUse HOST_WRITTEN, HOST_TO_BE_READ;
/* How to describe an image to the library. */
ImpastoImage host_described(const HostImage *image);

/* All bytes of a file in `folder`; their number is checked unless it is 0. */
void *host_file(const char *folder, const char *name, size_t bytes);

/* A get-proc-addr whose device makes nothing and allocates nothing from the call on that `host_fail_at` counts down to:
 * the first that makes something is 0. `host_calls` counts them. */
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL host_failing(VkInstance instance, const char *name);
extern unsigned host_fail_at, host_calls;
extern VkResult host_failure;

#endif
