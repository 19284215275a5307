// Calls from the event loop when a file descriptor has something to read: how the kernel, or a device's own
// thread by an eventfd, reaches the thread that everything else runs on. Single-threaded.
#pragma once

#include <functional>
#include <memory>

namespace contourd {

class DescriptorWatcher {
 public:
  // Destroying it ends the watching. Safe to destroy from inside its own call.
  class Watch {
   public:
    Watch() = default;
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    virtual ~Watch() = default;
  };

  DescriptorWatcher() = default;
  DescriptorWatcher(const DescriptorWatcher&) = delete;
  DescriptorWatcher& operator=(const DescriptorWatcher&) = delete;
  virtual ~DescriptorWatcher() = default;

  // `call` runs from the event loop for as long as `fd` can be read, or has hung up or failed
  // (level-triggered). The descriptor stays the caller's and must outlive the watch. Throws std::system_error
  // when the kernel refuses.
  [[nodiscard]] virtual std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) = 0;
};

}  // namespace contourd
