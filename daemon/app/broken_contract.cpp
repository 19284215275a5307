#include "daemon/app/broken_contract.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

#include "core/contract/expects.hpp"
#include "hw/watchdog/last_light_off.hpp"

namespace contourd {
namespace {

// Writes the line to stderr; drops it if that would block, because no one reads stderr.
void report(const BrokenContract& broken) noexcept {
  std::array<char, 512> line{};
  const int length = std::snprintf(
      line.data(), line.size(),
      "contourd aborts because of a bug, light off sent, motor still: broken contract in %s, line "
      "%d: %s\n",
      broken.file(), broken.line, broken.requirement);
  pollfd stderr_now{STDERR_FILENO, POLLOUT, 0};
  if (::poll(&stderr_now, 1, 0) != 1) return;
  const auto bytes = std::min(static_cast<std::size_t>(std::max(length, 0)), line.size() - 1);
  (void)!::write(STDERR_FILENO, line.data(), bytes);
}

void end_safely(const BrokenContract& broken) noexcept {
  make_safe_at_once();
  report(broken);
}

}  // namespace

void make_safe_on_broken_contract() noexcept {
  on_broken_contract(end_safely);
}

}  // namespace contourd
