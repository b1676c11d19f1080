/* A device that does not make what is asked for, from a certain call on. */
#include "host.h"

#include <string.h>

unsigned host_fail_at = UINT32_MAX, host_calls;
VkResult host_failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;

static int fails(void) { return host_calls++ >= host_fail_at; }

#define FAILING(name, parameters, ...) \
    static VKAPI_ATTR VkResult VKAPI_CALL failing_##name parameters { \
        return fails() ? host_failure : name(__VA_ARGS__); \
    }
#define MAKING(name, Info, Object) \
    FAILING(name, (VkDevice device, const Info *info, const VkAllocationCallbacks *callbacks, Object *object), \
            device, info, callbacks, object)
#define MAKING_PIPELINES(name, Info) \
    static VKAPI_ATTR VkResult VKAPI_CALL failing_##name(VkDevice device, VkPipelineCache cache, uint32_t count, \
                                                         const Info *infos, const VkAllocationCallbacks *callbacks, \
                                                         VkPipeline *pipelines) { \
        if (fails()) { \
            memset(pipelines, 0, count * sizeof *pipelines); \
            return host_failure; \
        } \
        return name(device, cache, count, infos, callbacks, pipelines); \
    }

MAKING(vkAllocateMemory, VkMemoryAllocateInfo, VkDeviceMemory)
MAKING(vkCreateBuffer, VkBufferCreateInfo, VkBuffer)
MAKING(vkCreateImage, VkImageCreateInfo, VkImage)
MAKING(vkCreateImageView, VkImageViewCreateInfo, VkImageView)
MAKING(vkCreateSampler, VkSamplerCreateInfo, VkSampler)
MAKING(vkCreateShaderModule, VkShaderModuleCreateInfo, VkShaderModule)
MAKING(vkCreatePipelineLayout, VkPipelineLayoutCreateInfo, VkPipelineLayout)
MAKING(vkCreateDescriptorSetLayout, VkDescriptorSetLayoutCreateInfo, VkDescriptorSetLayout)
MAKING(vkCreateDescriptorPool, VkDescriptorPoolCreateInfo, VkDescriptorPool)
MAKING(vkCreateRenderPass, VkRenderPassCreateInfo, VkRenderPass)
MAKING(vkCreateFramebuffer, VkFramebufferCreateInfo, VkFramebuffer)
MAKING_PIPELINES(vkCreateComputePipelines, VkComputePipelineCreateInfo)
MAKING_PIPELINES(vkCreateGraphicsPipelines, VkGraphicsPipelineCreateInfo)
FAILING(vkAllocateDescriptorSets, (VkDevice device, const VkDescriptorSetAllocateInfo *info, VkDescriptorSet *sets),
        device, info, sets)
FAILING(vkBindBufferMemory, (VkDevice device, VkBuffer buffer, VkDeviceMemory memory, VkDeviceSize at), device, buffer,
        memory, at)
FAILING(vkBindImageMemory, (VkDevice device, VkImage image, VkDeviceMemory memory, VkDeviceSize at), device, image,
        memory, at)
FAILING(vkMapMemory,
        (VkDevice device, VkDeviceMemory memory, VkDeviceSize at, VkDeviceSize size, VkMemoryMapFlags flags, void **to),
        device, memory, at, size, flags, to)

#define HOOK(name) {#name, (PFN_vkVoidFunction)failing_##name}
static const struct {
    const char *name;
    PFN_vkVoidFunction function;
} HOOKS[] = {
    HOOK(vkAllocateMemory),         HOOK(vkCreateBuffer),           HOOK(vkCreateImage),
    HOOK(vkCreateImageView),        HOOK(vkCreateSampler),          HOOK(vkCreateShaderModule),
    HOOK(vkCreatePipelineLayout),   HOOK(vkCreateDescriptorPool),   HOOK(vkCreateDescriptorSetLayout),
    HOOK(vkCreateRenderPass),       HOOK(vkCreateFramebuffer),      HOOK(vkCreateComputePipelines),
    HOOK(vkAllocateDescriptorSets), HOOK(vkCreateGraphicsPipelines), HOOK(vkBindBufferMemory),
    HOOK(vkBindImageMemory),        HOOK(vkMapMemory),
};

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char *name) {
    size_t i;
    for (i = 0; i < sizeof HOOKS / sizeof *HOOKS; i++) {
        if (!strcmp(name, HOOKS[i].name)) {
            return HOOKS[i].function;
        }
    }
    return vkGetDeviceProcAddr(device, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL host_failing(VkInstance instance, const char *name) {
    if (!strcmp(name, "vkGetDeviceProcAddr")) {
        return (PFN_vkVoidFunction)of_device;
    }
    return vkGetInstanceProcAddr(instance, name);
}
