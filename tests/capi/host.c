#include "host.h"

#include <string.h>

const ImpastoUse HOST_WRITTEN = {
    VK_PIPELINE_STAGE_TRANSFER_BIT,
    VK_ACCESS_TRANSFER_WRITE_BIT,
    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
};
const ImpastoUse HOST_TO_BE_READ = {
    VK_PIPELINE_STAGE_TRANSFER_BIT,
    VK_ACCESS_TRANSFER_READ_BIT,
    VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
};

void host_expect(ImpastoStatus expected, ImpastoStatus status, const char *call, const char *file, int line) {
    if (status != expected) {
        fprintf(stderr, "%s:%d: %s\nanswered \"%s\" and not \"%s\": %s\n", file, line, call,
                impasto_status_text(status), impasto_status_text(expected), impasto_last_error());
        exit(1);
    }
}

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
    (void)severity;
    (void)types;
    ++*(unsigned *)user;
    fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

/* Takes the place of the system's function: drivers and layers stay loaded, so that what looks for leaks can tell
 * whose they are. */
int dlclose(void *handle);
int dlclose(void *handle) {
    (void)handle;
    return 0;
}

static void make_instance(Host *host, int validated) {
    const char *layers[] = {"VK_LAYER_KHRONOS_validation"};
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkDebugUtilsMessengerCreateInfoEXT messenger = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = &host->messages,
    };
    VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .pNext = &messenger,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures = &enabled,
    };
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app};
    if (validated) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = layers;
        info.enabledExtensionCount = 2;
        info.ppEnabledExtensionNames = extensions;
    }
    CHECK(vkCreateInstance(&info, NULL, &host->instance) == VK_SUCCESS);
    if (validated) {
        PFN_vkCreateDebugUtilsMessengerEXT create = (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            host->instance, "vkCreateDebugUtilsMessengerEXT");
        CHECK(create(host->instance, &messenger, NULL, &host->messenger) == VK_SUCCESS);
    }
}

/* The first device with a queue that does what the library asks for. */
static void make_device(Host *host) {
    ImpastoRequirements needs = {.struct_size = sizeof needs};
    VkPhysicalDevice devices[16];
    uint32_t count = 16, families = 16, i;
    VkQueueFamilyProperties properties[16];
    OK(impasto_requirements(&needs));
    CHECK(needs.api_version == VK_API_VERSION_1_1 && needs.instance_extension_count == 0);
    CHECK(needs.device_extension_count == 0 && needs.feature_count == 0);
    CHECK(vkEnumeratePhysicalDevices(host->instance, &count, devices) >= 0 && count > 0);
    host->physical = devices[0];
    vkGetPhysicalDeviceQueueFamilyProperties(host->physical, &families, properties);
    for (i = 0; i < families && (properties[i].queueFlags & needs.queue_flags) != needs.queue_flags; i++) {
    }
    CHECK(i < families);
    host->family = i;
    {
        float priority = 1.0f;
        VkDeviceQueueCreateInfo queue = {
            .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
            .queueFamilyIndex = i,
            .queueCount = 1,
            .pQueuePriorities = &priority,
        };
        VkDeviceCreateInfo info = {
            .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
            .queueCreateInfoCount = 1,
            .pQueueCreateInfos = &queue,
        };
        CHECK(vkCreateDevice(host->physical, &info, NULL, &host->device) == VK_SUCCESS);
        vkGetDeviceQueue(host->device, i, 0, &host->queue);
    }
}

void host_create(Host *host, int validated) {
    VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
    };
    VkCommandBufferAllocateInfo commands = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandBufferCount = 1,
    };
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    memset(host, 0, sizeof *host);
    make_instance(host, validated);
    make_device(host);
    pool.queueFamilyIndex = host->family;
    CHECK(vkCreateCommandPool(host->device, &pool, NULL, &host->pool) == VK_SUCCESS);
    commands.commandPool = host->pool;
    CHECK(vkAllocateCommandBuffers(host->device, &commands, &host->commands) == VK_SUCCESS);
    CHECK(vkCreateFence(host->device, &fence, NULL, &host->fence) == VK_SUCCESS);
}

void host_destroy(Host *host) {
    vkDestroyFence(host->device, host->fence, NULL);
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    if (host->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy = (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            host->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(host->instance, host->messenger, NULL);
    }
    vkDestroyInstance(host->instance, NULL);
    CHECK(host->messages == 0);
}

ImpastoHostDevice host_lent(const Host *host, PFN_vkGetInstanceProcAddr get_proc_addr) {
    ImpastoHostDevice lent = {
        .struct_size = sizeof lent,
        .queue_family = host->family,
        .get_instance_proc_addr = get_proc_addr,
        .instance = host->instance,
        .physical_device = host->physical,
        .device = host->device,
        .debug_utils = host->messenger != VK_NULL_HANDLE,
    };
    return lent;
}

VkCommandBuffer host_begin(Host *host) {
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    CHECK(vkBeginCommandBuffer(host->commands, &begin) == VK_SUCCESS);
    host->frame++;
    return host->commands;
}

void host_submit(Host *host) {
    VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
        .commandBufferCount = 1,
        .pCommandBuffers = &host->commands,
    };
    CHECK(vkEndCommandBuffer(host->commands) == VK_SUCCESS);
    CHECK(vkQueueSubmit(host->queue, 1, &submit, host->fence) == VK_SUCCESS);
    CHECK(vkWaitForFences(host->device, 1, &host->fence, VK_TRUE, UINT64_MAX) == VK_SUCCESS);
    CHECK(vkResetFences(host->device, 1, &host->fence) == VK_SUCCESS);
}

static VkDeviceMemory memory(Host *host, VkMemoryRequirements needs, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties have;
    VkDeviceMemory made;
    uint32_t i;
    vkGetPhysicalDeviceMemoryProperties(host->physical, &have);
    for (i = 0; i < have.memoryTypeCount; i++) {
        if ((needs.memoryTypeBits >> i & 1) && (have.memoryTypes[i].propertyFlags & wanted) == wanted) {
            VkMemoryAllocateInfo info = {
                .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                .allocationSize = needs.size,
                .memoryTypeIndex = i,
            };
            CHECK(vkAllocateMemory(host->device, &info, NULL, &made) == VK_SUCCESS);
            return made;
        }
    }
    CHECK(!"memory of this kind");
    return VK_NULL_HANDLE;
}

static VkImageAspectFlags aspect(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

HostImage host_image(Host *host, VkFormat format, VkImageUsageFlags usage, uint32_t width, uint32_t height) {
    HostImage made = {.format = format, .usage = usage, .width = width, .height = height};
    VkMemoryRequirements needs;
    VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {width, height, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = usage,
    };
    VkImageViewCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format,
        .subresourceRange = {aspect(format), 0, 1, 0, 1},
    };
    CHECK(vkCreateImage(host->device, &info, NULL, &made.image) == VK_SUCCESS);
    vkGetImageMemoryRequirements(host->device, made.image, &needs);
    made.memory = memory(host, needs, 0);
    CHECK(vkBindImageMemory(host->device, made.image, made.memory, 0) == VK_SUCCESS);
    view.image = made.image;
    CHECK(vkCreateImageView(host->device, &view, NULL, &made.view) == VK_SUCCESS);
    return made;
}

void host_destroy_image(Host *host, HostImage *image) {
    vkDestroyImageView(host->device, image->view, NULL);
    vkDestroyImage(host->device, image->image, NULL);
    vkFreeMemory(host->device, image->memory, NULL);
}

ImpastoImage host_described(const HostImage *image) {
    ImpastoImage described = {
        .struct_size = sizeof described,
        .format = image->format,
        .image = image->image,
        .view = image->view,
        .width_px = image->width,
        .height_px = image->height,
        .usage = image->usage,
    };
    return described;
}

/* A buffer of the texels of an image. */
static VkBuffer staging(Host *host, VkDeviceSize bytes, VkDeviceMemory *bound) {
    VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = bytes,
        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
    };
    VkMemoryRequirements needs;
    VkBuffer buffer;
    CHECK(vkCreateBuffer(host->device, &info, NULL, &buffer) == VK_SUCCESS);
    vkGetBufferMemoryRequirements(host->device, buffer, &needs);
    *bound = memory(host, needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    CHECK(vkBindBufferMemory(host->device, buffer, *bound, 0) == VK_SUCCESS);
    return buffer;
}

static VkBufferImageCopy whole(VkImageAspectFlags aspect, uint32_t width, uint32_t height) {
    VkBufferImageCopy region = {.imageSubresource = {aspect, 0, 0, 1}, .imageExtent = {width, height, 1}};
    return region;
}

void host_write(Host *host, const HostImage *image, const void *texels) {
    size_t bytes = (size_t)image->width * image->height * 4;
    VkDeviceMemory bound;
    VkBuffer buffer = staging(host, bytes, &bound);
    VkBufferImageCopy region = whole(aspect(image->format), image->width, image->height);
    VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .dstAccessMask = HOST_WRITTEN.access,
        .newLayout = HOST_WRITTEN.layout,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image->image,
        .subresourceRange = {aspect(image->format), 0, 1, 0, 1},
    };
    void *mapped;
    CHECK(vkMapMemory(host->device, bound, 0, bytes, 0, &mapped) == VK_SUCCESS);
    memcpy(mapped, texels, bytes);
    vkUnmapMemory(host->device, bound);
    host_begin(host);
    vkCmdPipelineBarrier(host->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, HOST_WRITTEN.stages, 0, 0, NULL, 0, NULL,
                         1, &barrier);
    vkCmdCopyBufferToImage(host->commands, buffer, image->image, HOST_WRITTEN.layout, 1, &region);
    host_submit(host);
    vkDestroyBuffer(host->device, buffer, NULL);
    vkFreeMemory(host->device, bound, NULL);
}

void *host_read(Host *host, VkImage image, uint32_t width, uint32_t height) {
    size_t bytes = (size_t)width * height * 4;
    VkDeviceMemory bound;
    VkBuffer buffer = staging(host, bytes, &bound);
    VkBufferImageCopy region = whole(VK_IMAGE_ASPECT_COLOR_BIT, width, height);
    VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
    };
    void *mapped, *texels = malloc(bytes);
    CHECK(texels);
    host_begin(host);
    vkCmdCopyImageToBuffer(host->commands, image, HOST_TO_BE_READ.layout, buffer, 1, &region);
    vkCmdPipelineBarrier(host->commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                         NULL, 0, NULL);
    host_submit(host);
    CHECK(vkMapMemory(host->device, bound, 0, bytes, 0, &mapped) == VK_SUCCESS);
    memcpy(texels, mapped, bytes);
    vkDestroyBuffer(host->device, buffer, NULL);
    vkFreeMemory(host->device, bound, NULL);
    return texels;
}

void *host_file(const char *folder, const char *name, size_t bytes) {
    char path[1024];
    FILE *file;
    char *content = NULL;
    size_t size = 0, room = 0, count;
    CHECK(snprintf(path, sizeof path, "%s/%s", folder, name) < (int)sizeof path);
    file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "no %s\n", path);
        exit(1);
    }
    do {
        if (size == room) {
            room = room ? 2 * room : 4096;
            content = realloc(content, room);
            CHECK(content);
        }
        count = fread(content + size, 1, room - size, file);
        size += count;
    } while (count > 0);
    fclose(file);
    CHECK(bytes == 0 || size == bytes);
    return content;
}
