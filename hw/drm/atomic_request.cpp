#include "hw/drm/atomic_request.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <span>

#include "hw/owned.hpp"

namespace contourd {
namespace {

using KernelProperties = Owned<drmModeObjectProperties, drmModeFreeObjectProperties>;
using KernelProperty = Owned<drmModePropertyRes, drmModeFreeProperty>;

// Returns the address in the form that the kernel expects in its structs.
std::uint64_t address_of(const void* memory) {
  return reinterpret_cast<std::uintptr_t>(memory);
}

}  // namespace

ObjectProperties::ObjectProperties(int fd, std::uint32_t object, std::uint32_t type) : object_(object) {
  const KernelProperties all(drmModeObjectGetProperties(fd, object, type));
  for (std::uint32_t i = 0; all && i < all->count_props; ++i) {
    const KernelProperty property(drmModeGetProperty(fd, all->props[i]));
    if (!property) continue;
    Named& read = properties_.emplace_back(Named{property->name, {all->props[i], all->prop_values[i]}, {}});
    for (const auto& value : std::span(property->enums, static_cast<std::size_t>(property->count_enums)))
      read.values.emplace_back(value.name, value.value);
  }
}

std::optional<ObjectProperties::Property> ObjectProperties::find(const std::string& name) const {
  const Named* found = named(name);
  if (found == nullptr) return std::nullopt;
  return found->property;
}

std::optional<std::uint64_t> ObjectProperties::value_called(const std::string& name,
                                                            const std::string& value) const {
  const Named* property = named(name);
  if (property == nullptr) return std::nullopt;
  const auto found =
      std::ranges::find(property->values, value, &std::pair<std::string, std::uint64_t>::first);
  if (found == property->values.end()) return std::nullopt;
  return found->second;
}

const ObjectProperties::Named* ObjectProperties::named(const std::string& name) const {
  const auto found = std::ranges::find(properties_, name, &Named::name);
  return found == properties_.end() ? nullptr : &*found;
}

void AtomicRequest::set(const ObjectProperties& object, const std::string& name, std::uint64_t value) {
  const auto property = object.find(name);
  set(object.object(), property ? property->id : 0, value);
}

void AtomicRequest::set_if_other(const ObjectProperties& object, const std::string& name,
                                 std::uint64_t value) {
  const auto property = object.find(name);
  if (property && property->value != value) set(object.object(), property->id, value);
}

void AtomicRequest::set(std::uint32_t object, std::uint32_t property, std::uint64_t value) {
  if (objects_.empty() || objects_.back() != object) {
    objects_.push_back(object);
    counts_.push_back(0);
  }
  ++counts_.back();
  properties_.push_back(property);
  values_.push_back(value);
}

int AtomicRequest::commit(int fd, std::uint32_t flags, std::uint64_t user_data) noexcept {
  drm_mode_atomic atomic{};
  atomic.flags = flags;
  atomic.count_objs = static_cast<std::uint32_t>(objects_.size());
  atomic.objs_ptr = address_of(objects_.data());
  atomic.count_props_ptr = address_of(counts_.data());
  atomic.props_ptr = address_of(properties_.data());
  atomic.prop_values_ptr = address_of(values_.data());
  atomic.user_data = user_data;
  return drmIoctl(fd, DRM_IOCTL_MODE_ATOMIC, &atomic) == 0 ? 0 : errno;
}

}  // namespace contourd
