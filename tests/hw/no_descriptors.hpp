// An event loop for tests whose descriptors are never readable.
#pragma once

#include <functional>
#include <memory>

#include "hw/descriptor_watcher.hpp"

namespace contourd::testing {

class NoDescriptors final : public DescriptorWatcher {
 public:
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int, std::function<void()>) override {
    return std::make_unique<Watch>();
  }
};

}  // namespace contourd::testing
