#include "daemon/report/printed_light.hpp"

#include <chrono>

namespace contourd {

std::optional<PrintedLight> printed_light(std::span<const LayerRecord> records, double irradiance_mw_cm2) {
  PrintedLight light;
  Nanometers beneath{};
  for (const LayerRecord& record : records) {
    if (record.layer != static_cast<std::int32_t>(light.layers.size()) || record.plate_height <= beneath)
      return std::nullopt;
    const std::chrono::duration<double> least = record.exposure_least, most = record.exposure_most;
    const auto lit = record.dark_confirmed ? (least + most) / 2 : least;
    light.layers.push_back({record.plate_height, record.plate_height - beneath,
                            MillijoulesPerCm2{lit.count() * irradiance_mw_cm2}});
    light.mask_heights.push_back(record.mask_height);
    beneath = record.plate_height;
  }
  return light;
}

}  // namespace contourd
