// Callbacks from the event loop when a file descriptor becomes readable. Through them the kernel, or a
// device's own thread with an eventfd, reaches the thread that everything else runs on. Single-threaded.
#pragma once

#include <functional>
#include <memory>

#include "hw/interface.hpp"

namespace contourd {

class DescriptorWatcher : public Interface {
 public:
  // A watch on one descriptor; destroying the watch ends it. Safe to destroy from inside its own call.
  class Watch : public Interface {};

  // Runs `call` from the event loop for as long as `fd` can be read, or has hung up or failed
  // (level-triggered). The caller keeps the descriptor, which must outlive the watch. Throws
  // std::system_error if the kernel refuses.
  [[nodiscard]] virtual std::unique_ptr<Watch> when_readable(int fd, std::function<void()> call) = 0;
};

}  // namespace contourd
