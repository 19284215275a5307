#include "daemon/progress/interrupted_print.hpp"

#include <fmt/format.h>

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
  }
  return "?";
}

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

}  // namespace contourd
