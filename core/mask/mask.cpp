#include "core/mask/mask.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::int32_t kLargestSide = 16384;

std::size_t checked_area(Pixels width, Pixels height) {
  for (const Pixels side : {width, height}) {
    if (side.count() < 1 || side.count() > kLargestSide) {
      throw std::invalid_argument("a mask is 1 to " + std::to_string(kLargestSide) +
                                  " pixels wide and high, not " + std::to_string(width.count()) + "x" +
                                  std::to_string(height.count()));
    }
  }
  return static_cast<std::size_t>(width.count()) * static_cast<std::size_t>(height.count());
}

}  // namespace

Mask::Mask(Pixels width, Pixels height)
    : width_(width), height_(height), pixels_(checked_area(width, height)) {}

std::span<std::uint8_t> Mask::row(std::int32_t y) {
  expects(0 <= y && y < height_.count(), "the row is in the mask");
  const auto stride = static_cast<std::size_t>(width_.count());
  return std::span(pixels_).subspan(static_cast<std::size_t>(y) * stride, stride);
}

std::span<const std::uint8_t> Mask::row(std::int32_t y) const {
  expects(0 <= y && y < height_.count(), "the row is in the mask");
  const auto stride = static_cast<std::size_t>(width_.count());
  return std::span(pixels_).subspan(static_cast<std::size_t>(y) * stride, stride);
}

std::int64_t Mask::lit_pixels() const {
  return std::count_if(pixels_.begin(), pixels_.end(), [](std::uint8_t grey) { return grey != 0; });
}

double Mask::lit_area() const {
  std::uint64_t sum = 0;
  for (const std::uint8_t grey : pixels_)
    sum += grey;
  return static_cast<double>(sum) / 255.0;
}

}  // namespace contourd
