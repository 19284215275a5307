#include "core/cure/pixel_light.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Light beyond this many standard deviations is below a 1000th of the middle's.
constexpr double kReach = 3.75;

std::int32_t reach_of(double sigma) {
  return static_cast<std::int32_t>(std::ceil(kReach * sigma));
}

// Returns the light at the middle of a pixel from each pixel on its line: a Gaussian's part over that pixel.
std::vector<float> weights_for(double sigma) {
  std::vector<double> weights(static_cast<std::size_t>(reach_of(sigma)) + 1);
  const auto beyond = [sigma](double pixels) {
    return std::erfc(pixels / (sigma * std::numbers::sqrt2)) / 2;
  };
  weights[0] = 1 - 2 * beyond(0.5);
  for (std::size_t distance = 1; distance < weights.size(); ++distance) {
    const auto pixels = static_cast<double>(distance);
    weights[distance] = beyond(pixels - 0.5) - beyond(pixels + 0.5);
  }
  const double sum = 2 * std::accumulate(weights.begin(), weights.end(), 0.0) - weights.front();
  std::vector<float> scaled(weights.size());
  std::ranges::transform(weights, scaled.begin(),
                         [sum](double weight) { return static_cast<float>(weight / sum); });
  return scaled;
}

// Returns in how many standard deviations a Gaussian has this part of itself, over sqrt(2), within 0.3 %
// (Winitzki 2008). `rest` is 1 - part, which may be too small to be found by that.
double deviations(double part, double rest) {
  constexpr double kA = 0.147, kB = 2 / (std::numbers::pi * kA);
  const double inverse = part - rest;  // of the error function
  const double log_beside =
      std::abs(inverse) < 0.5 ? std::log1p(-inverse * inverse) : std::log(4 * part * rest);
  const double sum = kB + log_beside / 2;
  return std::copysign(std::sqrt(std::sqrt(sum * sum - log_beside / kA) - sum), inverse);
}

}  // namespace

std::int32_t PixelLight::reach() const {
  std::int32_t reach = 0;
  for (const Gaussian& gaussian : gaussians)
    reach = std::max(reach, reach_of(gaussian.sigma_pixels));
  return reach;
}

double wall_between(double bright, double dark, double least) {
  expects(bright >= least && least > dark, "the dose falls below the least between the pixels");
  if (dark <= 0) return 0.5;  // light that stays within its pixel
  // The light of both pixels together is that within the area.
  const double within = bright + dark;
  const double end = deviations(bright / within, dark / within);
  const double at = deviations(least / within, (within - least) / within);
  return std::clamp((end - at) / (2 * end), 0.0, 1.0);
}

LightSpread::LightSpread(const PixelLight& light, std::size_t width, std::size_t height)
    : width_(width), height_(height) {
  double sum = 0;
  for (const auto& gaussian : light.gaussians) {
    expects(
        gaussian.sigma_pixels > 0 && gaussian.sigma_pixels <= PixelLight::kWidestPixels && gaussian.share > 0,
        "a Gaussian has a width of at most 16 pixels and a share");
    sum += gaussian.share;
  }
  for (const auto& gaussian : light.gaussians)
    kernels_.push_back({weights_for(gaussian.sigma_pixels), static_cast<float>(gaussian.share / sum)});
  if (kernels_.empty()) return;
  source_.resize(width * height);
  rows_.resize(width * height);
}

void LightSpread::apply(std::span<float> picture) {
  expects(picture.size() == width_ * height_, "the picture has the size that was given");
  if (kernels_.empty()) return;
  std::ranges::copy(picture, source_.begin());
  std::ranges::fill(picture, 0.0F);
  for (const Kernel& kernel : kernels_) {
    spread_rows(source_, kernel);
    add_columns(picture, kernel);
  }
}

void LightSpread::spread_rows(std::span<const float> from, const Kernel& kernel) {
  for (std::size_t y = 0; y < height_; ++y) {
    const auto row = from.subspan(y * width_, width_);
    const auto spread = std::span(rows_).subspan(y * width_, width_);
    std::ranges::transform(row, spread.begin(), [&](float light) { return light * kernel.weights[0]; });
    for (std::size_t distance = 1; distance < std::min(kernel.weights.size(), width_); ++distance) {
      const float weight = kernel.weights[distance];
      for (std::size_t x = 0; x + distance < width_; ++x) {
        spread[x] += weight * row[x + distance];
        spread[x + distance] += weight * row[x];
      }
    }
  }
}

void LightSpread::add_columns(std::span<float> to, const Kernel& kernel) {
  const auto add_row = [&](std::size_t from_y, std::size_t to_y, float weight) {
    const float* from = rows_.data() + from_y * width_;
    float* sum = to.data() + to_y * width_;
    for (std::size_t x = 0; x < width_; ++x)
      sum[x] += weight * from[x];
  };
  for (std::size_t y = 0; y < height_; ++y) {
    add_row(y, y, kernel.share * kernel.weights[0]);
    for (std::size_t distance = 1; distance < kernel.weights.size(); ++distance) {
      const float weight = kernel.share * kernel.weights[distance];
      if (y >= distance) add_row(y - distance, y, weight);
      if (y + distance < height_) add_row(y + distance, y, weight);
    }
  }
}

}  // namespace contourd
