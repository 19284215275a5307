// An input whose edges come through a pipe, like those of the kernel. One thread at a time may set it.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <optional>
#include <span>
#include <stdexcept>

#include "hw/gpio/axis_inputs.hpp"

namespace contourd::testing {

class PipeInput final : public InputLine {
 public:
  PipeInput() {
    if (::pipe2(ends_.data(), O_NONBLOCK) != 0) throw std::runtime_error("no pipe");
  }
  ~PipeInput() override {
    for (const int end : ends_)
      ::close(end);
  }
  void set(bool level) noexcept {
    if (level_.exchange(level) == level) return;
    const LineEdge edge{level, monotonic_now()};
    lost_ += ::write(ends_[1], &edge, sizeof edge) != sizeof edge ? 1 : 0;
  }
  [[nodiscard]] int descriptor() const noexcept override { return ends_[0]; }
  [[nodiscard]] std::optional<bool> level() noexcept override { return level_; }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge> edges) noexcept override {
    const ssize_t bytes = ::read(ends_[0], edges.data(), edges.size_bytes());
    return bytes > 0 ? static_cast<std::size_t>(bytes) / sizeof(LineEdge) : 0;
  }

 private:
  std::array<int, 2> ends_{};
  std::atomic<bool> level_{false};
  std::atomic<int> lost_{0};
};

}  // namespace contourd::testing
