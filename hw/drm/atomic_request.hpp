// Property values that the kernel applies all at once or not at all (DRM_IOCTL_MODE_ATOMIC). A request is
// built once and committed many times; libdrm's own requests allocate at every commit, which page flips must
// not do. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {

// The properties of one kernel object, read by the constructor.
class ObjectProperties {
 public:
  // `type` is DRM_MODE_OBJECT_*. An object that does not exist has no properties.
  ObjectProperties(int fd, std::uint32_t object, std::uint32_t type);

  struct Property {
    std::uint32_t id = 0;
    std::uint64_t value = 0;
  };
  [[nodiscard]] std::optional<Property> find(const std::string& name) const;
  // Returns the number that an enumerated property has for the value of this name: "Full" of "Broadcast RGB".
  [[nodiscard]] std::optional<std::uint64_t> value_called(const std::string& name,
                                                          const std::string& value) const;
  [[nodiscard]] std::uint32_t object() const { return object_; }

 private:
  struct Named {
    std::string name;
    Property property;
    std::vector<std::pair<std::string, std::uint64_t>> values;  // empty if the property is not enumerated
  };
  [[nodiscard]] const Named* named(const std::string& name) const;

  std::uint32_t object_;
  std::vector<Named> properties_;
};

class AtomicRequest {
 public:
  // Adds a value. Every commit fails if the object does not have the property.
  void set(const ObjectProperties& object, const std::string& name, std::uint64_t value);
  void set(std::uint32_t object, std::uint32_t property, std::uint64_t value);
  // Adds the value if the object has the property, with a different value.
  void set_if_other(const ObjectProperties& object, const std::string& name, std::uint64_t value);

  // Replaces the value that was added last. REQUIRES: a property was set.
  void change_last(std::uint64_t value) noexcept {
    expects(!values_.empty(), "a property was set");
    values_.back() = value;
  }

  // Applies all values. `flags` are DRM_MODE_ATOMIC_* and DRM_MODE_PAGE_FLIP_EVENT. Returns 0 or an errno.
  [[nodiscard]] int commit(int fd, std::uint32_t flags, std::uint64_t user_data = 0) noexcept;

 private:
  std::vector<std::uint32_t> objects_, counts_, properties_;
  std::vector<std::uint64_t> values_;
};

}  // namespace contourd
