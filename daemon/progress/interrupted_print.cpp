#include "daemon/progress/interrupted_print.hpp"

#include <fmt/format.h>

#include <cmath>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

std::string describe_phase(PrintPhase phase) {
  switch (phase) {
    case PrintPhase::Starting:
      return "before its first layer";
    case PrintPhase::Lowering:
      return "while the plate came down";
    case PrintPhase::BeforeLight:
      return "before, during or just after its light";
    case PrintPhase::Lit:
      return "after its light";
    case PrintPhase::Lifting:
      return "while the plate rose";
    case PrintPhase::Raising:
      return "while the plate rose for a pause";
    case PrintPhase::Paused:
      return "in a pause";
    case PrintPhase::Parking:
      return "while the plate rose at the end";
    case PrintPhase::Rising:
      return "within its rise";
    case PrintPhase::Moved:
      return "and moved by hand since";
  }
  return "?";
}

// Returns why the recorded position cannot be trusted; empty if it can.
std::string why_not_trusted(const InterruptedPrint& interrupted) {
  if (!interrupted.is_latest)
    return "the recorded position cannot be trusted: the latest record is damaged, and the plate may have "
           "moved after the one before";
  if (!is_at_rest(interrupted.progress.print))
    return "the recorded position cannot be trusted: the plate was moving";
  return "";
}

constexpr const char* kWaysOut =
    "; \"contourctl rescue\" lifts the part out, \"contourctl plate-cleared\" gives the print up";

double millimetres(Nanometers height) {
  return to_millimeters(height).count();
}

}  // namespace

std::string describe(const JobProgress& progress) {
  const PrintProgress& print = progress.print;
  std::string text =
      fmt::format("in layer {} of {}, {}", print.layer + 1, progress.layers, describe_phase(print.phase));
  if (!print.plate) return text;
  if (is_at_rest(print))
    return text + fmt::format(", with the plate at {:.3f} mm", millimetres(print.plate->least));
  return text + fmt::format(", with the plate between {:.3f} and {:.3f} mm", millimetres(print.plate->least),
                            millimetres(print.plate->most));
}

std::string why_not_resumable(const InterruptedPrint& interrupted, bool homes_upwards, bool trusted) {
  const PrintProgress& print = interrupted.progress.print;
  if (print.phase == PrintPhase::Moved)
    return "the plate was moved by hand since the power cut; \"contourctl plate-cleared\" gives the print up";
  if (print.phase == PrintPhase::Parking || (print.exposed && print.layer + 1 >= interrupted.progress.layers))
    return "the print was over, or cancelled: all that it lacks is the plate's way up";
  if (print.phase == PrintPhase::Rising)
    return "where the light of a continuous print ended within its rise is not known; \"contourctl rescue\" "
           "lifts "
           "its part out";
  if (!interrupted.progress.changes.complete)
    return "more copies were left dark than the record of the print holds";
  if (!trusted && homes_upwards) return "";
  const std::string distrust = why_not_trusted(interrupted);
  if (trusted) return distrust.empty() ? "" : distrust + kWaysOut;
  return "the plate's position is unknown, and the limit switch is at the bottom, where the part would be "
         "crushed; " +
         (distrust.empty() ? "\"contourctl resume --trust-position\" trusts the recorded position"
                           : distrust + kWaysOut);
}

std::string describe_way_on(const InterruptedPrint& interrupted, bool homes_upwards) {
  const std::string tried = interrupted.trouble.empty() ? ""
                                                        : fmt::format("the print did not go on: {}; ",
                                                                      printable(interrupted.trouble));
  if (why_not_resumable(interrupted, homes_upwards, false).empty())
    return tried + "\"contourctl resume\" continues the print";
  if (why_not_resumable(interrupted, homes_upwards, true).empty())
    return tried + "\"contourctl resume --trust-position\" continues the print";
  return tried + "the print cannot go on";
}

void move_by_hand(PrintProgress& print, std::optional<Nanometers> distance) {
  print.phase = PrintPhase::Moved;
  if (!distance) print.plate.reset();
  if (!print.plate) return;
  auto& [least, most] = *print.plate;
  (*distance < Nanometers{} ? least : most) += *distance;
}

ResumePoint resume_point(const JobProgress& progress, bool trusted) {
  const PrintProgress& print = progress.print;
  ResumePoint point{print.layer, print.bottom};
  if (print.exposed) point = {print.layer + 1, print.bottom + print.thickness};
  if (trusted && print.plate) point.height = print.plate->least;
  return point;
}

std::string describe_trust(const JobProgress& progress, double microsteps_per_mm) {
  constexpr double kTwoFullSteps = 2 * 16;  // in microsteps
  const double height = progress.print.plate ? millimetres(progress.print.plate->least) : 0;
  return fmt::format(
      "the plate has stood at {:.3f} mm since {}, was not turned by hand, and the motor "
      "settles within 2 full steps of where it stood ({:.0f} um for this screw at 16 microsteps a step)",
      height, iso_time(progress.written), 1000 * kTwoFullSteps / microsteps_per_mm);
}

std::string describe_seam(const JobProgress& progress, std::optional<Micrometers> penetration) {
  const PrintProgress& print = progress.print;
  if (print.exposed)
    return fmt::format("a power cut interrupted the print after layer {}: a seam may show there",
                       print.layer + 1);
  const double ln2 = std::log(2.0);
  const bool dark = print.phase == PrintPhase::Lowering && print.light == Duration{};
  const std::string deeper =
      dark          ? "a seam may show there"
      : penetration ? fmt::format("the layer was lit again in full, and cures up to {:.0f} um deeper",
                                  penetration->count() * ln2)
                    : "the layer was lit again in full, and cures deeper by up to 0.69 of the resin's "
                      "penetration depth";
  return fmt::format("a power cut interrupted the print in layer {}: {}", print.layer + 1, deeper);
}

}  // namespace contourd
