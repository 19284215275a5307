#include "hw/drm/mode.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <vector>

#include "hw/hardware_error.hpp"

namespace contourd {
namespace {

constexpr double kRefreshTolerance = 0.5;  // Hz
constexpr double kSquare = 0.01;           // tolerance of a pixel's width over its height
constexpr double kEdidRounding = 5.0;      // mm: EDID's base block has whole centimetres

struct FlagName {
  std::uint32_t flag;
  const char* name;
};
// Flags of modes that do not send each pixel of each picture once.
constexpr FlagName kFlagNames[] = {{DRM_MODE_FLAG_INTERLACE, "interlaced"},
                                   {DRM_MODE_FLAG_DBLSCAN, "each line twice"},
                                   {DRM_MODE_FLAG_DBLCLK, "each pixel twice"},
                                   {DRM_MODE_FLAG_CLKDIV2, "half the pixel clock"}};

struct Ratio {
  int width, height;
};
std::optional<Ratio> named_picture_ratio(const Mode& mode) {
  switch (mode.flags & DRM_MODE_FLAG_PIC_AR_MASK) {
    case DRM_MODE_FLAG_PIC_AR_4_3:
      return Ratio{4, 3};
    case DRM_MODE_FLAG_PIC_AR_16_9:
      return Ratio{16, 9};
    case DRM_MODE_FLAG_PIC_AR_64_27:
      return Ratio{64, 27};
    case DRM_MODE_FLAG_PIC_AR_256_135:
      return Ratio{256, 135};
    default:
      return std::nullopt;
  }
}

// Returns a pixel's width over its height if the whole picture has this width and height.
double pixel_ratio(const Mode& mode, double width, double height) {
  return width / height * mode.vdisplay / mode.hdisplay;
}

std::string format(const char* text, double value) {
  char buffer[96];
  std::snprintf(buffer, sizeof buffer, text, value);
  return buffer;
}

std::optional<std::string> unsquare_by_name(const Mode& mode) {
  const auto ratio = named_picture_ratio(mode);
  if (!ratio) return std::nullopt;
  const double pixel = pixel_ratio(mode, ratio->width, ratio->height);
  if (std::fabs(pixel - 1) <= kSquare) return std::nullopt;
  return "its pixels are not square: in a picture of " + std::to_string(ratio->width) + ":" +
         std::to_string(ratio->height) + " they are " + format("%.2f", pixel) + " times as wide as high";
}

std::optional<std::string> unsquare_by_size(const Mode& mode, PictureSize size) {
  if (size.width_mm <= 0 || size.height_mm <= 0) return std::nullopt;
  const double width = size.width_mm, height = size.height_mm;
  const double widest = pixel_ratio(mode, width + kEdidRounding, std::max(height - kEdidRounding, 0.5));
  const double narrowest = pixel_ratio(mode, std::max(width - kEdidRounding, 0.5), height + kEdidRounding);
  if (narrowest <= 1 + kSquare && widest >= 1 - kSquare) return std::nullopt;
  return "its pixels are not square: on a picture of " + std::to_string(size.width_mm) + "x" +
         std::to_string(size.height_mm) + " mm they are " + format("%.2f", pixel_ratio(mode, width, height)) +
         " times as wide as high";
}

bool has_size(const Mode& mode, const DrmDisplayConfig& config) {
  return mode.hdisplay == config.width.count() && mode.vdisplay == config.height.count();
}

bool is_preferred(const Mode& mode) {
  return (mode.type & DRM_MODE_TYPE_PREFERRED) != 0;
}

}  // namespace

double refresh_hz(const Mode& mode) {
  if (mode.htotal == 0 || mode.vtotal == 0) return mode.vrefresh;
  double hz = mode.clock * 1000.0 / (static_cast<double>(mode.htotal) * mode.vtotal);
  if ((mode.flags & DRM_MODE_FLAG_INTERLACE) != 0) hz *= 2;
  if ((mode.flags & DRM_MODE_FLAG_DBLSCAN) != 0) hz /= 2;
  return mode.vscan > 1 ? hz / mode.vscan : hz;
}

std::string describe(const Mode& mode) {
  std::string text = std::to_string(mode.hdisplay) + "x" + std::to_string(mode.vdisplay) +
                     format(" at %.2f Hz", refresh_hz(mode));
  for (const FlagName& named : kFlagNames) {
    if ((mode.flags & named.flag) != 0) text += std::string(", ") + named.name;
  }
  return text;
}

std::string describe(std::span<const Mode> modes) {
  std::vector<std::string> texts;
  for (const Mode& mode : modes) {
    std::string text = describe(mode);
    if (std::ranges::find(texts, text) == texts.end()) texts.push_back(std::move(text));
  }
  std::string all;
  for (const std::string& text : texts)
    all += (all.empty() ? "" : "; ") + text;
  return all.empty() ? "none" : all;
}

bool same_timing(const Mode& a, const Mode& b) {
  const auto timing = [](const Mode& mode) {
    return std::tuple(mode.clock, mode.hdisplay, mode.hsync_start, mode.hsync_end, mode.htotal, mode.hskew,
                      mode.vdisplay, mode.vsync_start, mode.vsync_end, mode.vtotal, mode.vscan, mode.flags);
  };
  return timing(a) == timing(b);
}

std::optional<std::string> why_unsuitable(const Mode& mode, PictureSize size) {
  for (const FlagName& named : kFlagNames) {
    if ((mode.flags & named.flag) != 0) return "it does not send each pixel of each picture once";
  }
  if ((mode.flags & DRM_MODE_FLAG_3D_MASK) != 0) return "it has a picture for each eye";
  if (auto why = unsquare_by_name(mode)) return why;
  return unsquare_by_size(mode, size);
}

Mode choose_mode(std::span<const Mode> modes, PictureSize size, const DrmDisplayConfig& config,
                 const std::string& output) {
  const PictureSize known = config.ignore_edid_size ? PictureSize{} : size;
  const auto distance = [&](const Mode& mode) {
    // Whole millihertz, so that modes with smaller differences, which no clock can tell apart, are equally
    // near.
    return std::llround(std::fabs(refresh_hz(mode) - config.refresh_hz) * 1000);
  };
  const Mode* best = nullptr;
  std::string unfit;
  for (const Mode& mode : modes) {
    if (!has_size(mode, config) || static_cast<double>(distance(mode)) > kRefreshTolerance * 1000) continue;
    if (const auto why = why_unsuitable(mode, known)) {
      if (unfit.empty()) unfit = output + " cannot show masks with its mode " + describe(mode) + ": " + *why;
      continue;
    }
    const bool nearer = best == nullptr || distance(mode) < distance(*best);
    const bool preferred =
        best != nullptr && distance(mode) == distance(*best) && is_preferred(mode) && !is_preferred(*best);
    if (nearer || preferred) best = &mode;
  }
  if (best != nullptr) return *best;
  const std::string modes_there_are = "; modes: " + describe(modes);
  if (!unfit.empty()) throw HardwareError(unfit + modes_there_are);
  throw HardwareError(output + " has no mode of " + std::to_string(config.width.count()) + "x" +
                      std::to_string(config.height.count()) + format(" at %.2f Hz", config.refresh_hz) +
                      modes_there_are);
}

}  // namespace contourd
