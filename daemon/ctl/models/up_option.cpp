#include "daemon/ctl/models/up_option.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {

UpOption parse_up(const std::string& word) {
  if (const auto preset = orientation_preset(word)) return *preset;
  Direction up;
  int used = 0;
  const int parts = std::sscanf(word.c_str(), "%lf,%lf,%lf%n", &up.x, &up.y, &up.z, &used);
  if (parts != 3 || static_cast<std::size_t>(used) != word.size())
    throw UsageError(fmt::format("--up {}: expected auto, fast, clean, safe or X,Y,Z", printable(word)));
  const bool finite = std::isfinite(up.x) && std::isfinite(up.y) && std::isfinite(up.z);
  if (!finite || up == Direction{0, 0, 0})
    throw UsageError(
        fmt::format("--up {}: expected a direction that is finite and not zero", printable(word)));
  return up;
}

}  // namespace contourd::ctl
