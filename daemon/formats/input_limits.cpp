#include "daemon/formats/input_limits.hpp"

#include <fmt/format.h>

#include "core/model/model.hpp"

namespace contourd {

void refuse_inflation(const InflatedSize& size, std::string_view what) {
  if (size.inflated > kMostInflatedBytes) {
    throw ModelError(
        fmt::format("{} becomes {} bytes when it is unpacked, and the limit is {}: export the "
                    "model as binary STL",
                    what, size.inflated, kMostInflatedBytes));
  }
  if (size.inflated > kAnyRatioBytes && size.inflated / kMostRatio > size.compressed) {
    throw ModelError(
        fmt::format("{} has {} bytes and becomes {} when it is unpacked, more than {} times as "
                    "much, as no model does: download it again, or unpack it yourself",
                    what, size.compressed, size.inflated, kMostRatio));
  }
}

}  // namespace contourd
