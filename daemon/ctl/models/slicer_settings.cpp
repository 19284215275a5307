#include "daemon/ctl/models/slicer_settings.hpp"

#include <fmt/format.h>

#include "daemon/json/config_error.hpp"

namespace contourd::ctl {

SlicerSettings display_settings(const DisplayGeometry& display) {
  const auto flag = [](bool is_set) { return is_set ? "1" : "0"; };
  const auto side = [](double mm) { return slicer_mm(to_nanometers(Millimeters{mm}).value()); };
  const std::string width = side(display.width_mm()), height = side(display.height_mm());
  return {{"bed_shape", fmt::format("0x0,{0}x0,{0}x{1},0x{1}", width, height)},
          {"display_height", height},
          {"display_mirror_x", flag(display.mirror_x)},
          {"display_mirror_y", flag(display.mirror_y)},
          {"display_orientation", "landscape"},
          {"display_pixels_x", std::to_string(display.width.count())},
          {"display_pixels_y", std::to_string(display.height.count())},
          {"display_width", width}};
}

SlicerSettings layer_settings(const SlicerLayers& layers) {
  return {{"exposure_time", slicer_seconds(layers.exposure)},
          {"faded_layers", std::to_string(layers.fading_layers)},
          {"initial_exposure_time", slicer_seconds(layers.first_exposure)},
          {"initial_layer_height", slicer_mm(layers.height)},
          {"layer_height", slicer_mm(layers.height)}};
}

std::string slicer_mm(Nanometers length) {
  return decimal(in_mm(length));
}

std::string slicer_seconds(Duration time) {
  return decimal(std::chrono::duration<double>(time).count());
}

std::string ini_text(const SlicerSettings& settings) {
  std::string text;
  for (const auto& [key, value] : settings)
    text += fmt::format("{} = {}\n", key, value);
  return text;
}

}  // namespace contourd::ctl
