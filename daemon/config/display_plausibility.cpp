#include "daemon/config/display_plausibility.hpp"

#include <cmath>
#include <string>

namespace contourd {
namespace {

// Projectors' pictures lie: 5:4 to 21:9.
constexpr double kLeastAspect = 1.2, kMostAspect = 2.4;
// As they are focused on a film, their pixels have 47 to 100 um.
constexpr double kLeastPitchUm = 10, kMostPitchUm = 200;

std::string plain(double whole) {
  return std::to_string(std::llround(whole));
}

}  // namespace

void warn_of_doubtful_display(JsonDocument& printer) {
  const auto width = printer.sound_number("/display/width_px"),
             height = printer.sound_number("/display/height_px");
  if (width && height && *height > *width) {
    printer.add_warning("/display/height_px",
                        plain(*height) + " is more than width_px, " + plain(*width) +
                            ": projectors' pictures are wider than high, are the two exchanged?");
  } else if (width && height && (*width < kLeastAspect * *height || *width > kMostAspect * *height)) {
    printer.add_warning("/display/width_px",
                        plain(*width) + " by " + plain(*height) +
                            " pixels is a shape that no projector's picture has: 5:4 to 21:9 are usual");
  }
  const auto pitch = printer.sound_number("/display/pixel_pitch_um");
  if (pitch && (*pitch < kLeastPitchUm || *pitch > kMostPitchUm)) {
    printer.add_warning(
        "/display/pixel_pitch_um",
        nlohmann::json(*pitch).dump() + " um are hardly meant: pixels of 30 to 100 um are usual");
  }
}

}  // namespace contourd
