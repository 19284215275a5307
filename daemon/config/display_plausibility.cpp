#include "daemon/config/display_plausibility.hpp"

#include <cmath>
#include <string>

namespace contourd {
namespace {

// Projectors' pictures are wider than high: 5:4 to 21:9.
constexpr double kMinAspect = 1.2, kMaxAspect = 2.4;
// Projectors focused on a film have pixels of 47 to 100 um.
constexpr double kMinPitchUm = 10, kMaxPitchUm = 200;

std::string whole_number(double whole) {
  return std::to_string(std::llround(whole));
}

}  // namespace

void warn_of_implausible_display(JsonDocument& printer) {
  const auto width = printer.valid_number("/display/width_px"),
             height = printer.valid_number("/display/height_px");
  if (width && height && *height > *width) {
    printer.add_warning("/display/height_px",
                        whole_number(*height) + " is more than width_px, " + whole_number(*width) +
                            ": projectors' pictures are wider than high; are the two swapped?");
  } else if (width && height && (*width < kMinAspect * *height || *width > kMaxAspect * *height)) {
    printer.add_warning("/display/width_px",
                        whole_number(*width) + " by " + whole_number(*height) +
                            " pixels is a shape that no projector's picture has: 5:4 to 21:9 are usual");
  }
  const auto pitch = printer.valid_number("/display/pixel_pitch_um");
  if (pitch && (*pitch < kMinPitchUm || *pitch > kMaxPitchUm)) {
    printer.add_warning(
        "/display/pixel_pitch_um",
        nlohmann::json(*pitch).dump() + " um are implausible: pixels of 30 to 100 um are usual");
  }
}

}  // namespace contourd
