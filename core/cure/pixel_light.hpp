// Light of one pixel on the film: how much of it reaches the neighbours. Values and pure functions;
// thread-safe.
//
// A pixel is an evenly lit square, which the optics blur: its light is the square, spread by a Gaussian (Kang
// et al. 2012) of the width that was measured, or by a second one with the wide tail that small features
// show. So the dose is even within a lit area, and half of that at the area's edge, however narrow the
// Gaussian is. Widths are standard deviations in pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace contourd {

struct PixelLight {
  static constexpr double kWidestPixels = 16;
  struct Gaussian {
    double sigma_pixels;  // more than 0, at most kWidestPixels
    double share;         // of the pixel's light
    bool operator==(const Gaussian&) const = default;
  };
  std::vector<Gaussian> gaussians{};  // empty: the light stays within its pixel

  // Returns the number of pixels to each side that get light.
  [[nodiscard]] std::int32_t reach() const;
  bool operator==(const PixelLight&) const = default;
};

// Returns the place of a wall between the middles of two pixels, from the brighter one's, 0 to 1: where the
// dose falls to `least`, as it does between two pixels at the edge of a lit area. REQUIRES: bright >= least >
// dark.
[[nodiscard]] double wall_between(double bright, double dark, double least);

// Spreads the light of a picture's pixels. Keeps its working memory. Not thread-safe.
class LightSpread {
 public:
  static constexpr std::size_t kBytesPerPixel = 2 * sizeof(float);  // of working memory

  // REQUIRES: positive widths of at most 16 pixels, positive shares.
  LightSpread(const PixelLight& light, std::size_t width, std::size_t height);

  // Replaces each pixel's light by the irradiance at the pixel's middle. A picture that is lit evenly stays
  // as it is; beyond the picture it is dark. REQUIRES: a picture of width by height.
  void apply(std::span<float> picture);

 private:
  struct Kernel {
    std::vector<float> weights;  // by distance in pixels, from 0; both sides together add up to 1
    float share;                 // of all light
  };
  void spread_rows(std::span<const float> from, const Kernel& kernel);
  void add_columns(std::span<float> to, const Kernel& kernel);

  std::size_t width_, height_;
  std::vector<Kernel> kernels_;
  std::vector<float> source_, rows_;
};

}  // namespace contourd
