// An output that counts its rising edges. Safe with one thread that sets and others that read.
#pragma once

#include <atomic>

#include "hw/gpio/digital_line.hpp"

namespace contourd::testing {

class CountingLine final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active) ++rises;
    return true;
  }
  std::atomic<int> rises{0};
};

}  // namespace contourd::testing
