#include "daemon/print/print_mode.hpp"

#include <fmt/format.h>

namespace contourd {

std::string_view name_of(PrintActivity activity) {
  switch (activity) {
    case PrintActivity::Preparing:
      return "preparing";
    case PrintActivity::Exposing:
      return "exposing";
    case PrintActivity::Moving:
      return "moving";
    case PrintActivity::Waiting:
      return "waiting";
    case PrintActivity::Stopped:
      return "stopped";
  }
  return "?";
}

bool is_reached(const PausePoint& point, std::int32_t layer, Nanometers bottom) {
  if (const auto* const height = std::get_if<Nanometers>(&point)) return bottom >= *height;
  return layer >= std::get<std::int32_t>(point);
}

std::string describe(const PausePoint& point) {
  if (const auto* const height = std::get_if<Nanometers>(&point))
    return fmt::format("at {:.3f} mm", to_millimeters(*height).count());
  return fmt::format("before layer {}", std::get<std::int32_t>(point) + 1);
}

std::string describe_resistance(Nanometers met, Nanometers target, const ForcePolicy& force) {
  return fmt::format(
      "the plate met resistance at {:.3f} mm on its way down to {:.3f} mm, where force is expected only "
      "below {:.3f} mm: remove what lies on the film or came off the plate, or check the force line, before "
      "it goes on",
      in_mm(met), in_mm(target), in_mm(target + force.contact_from));
}

void leave_dark(PrintPlan& plan, const ExcludedCopy& copy, std::int32_t layer, Nanometers from) {
  const auto supports = copy.supports_left ? copy.supports_left() : nullptr;
  plan.engine->darken(copy.model, copy.copy, from);
  if (supports) plan.engine->replace_beside(supports, from);
  if (plan.undersides)
    plan.undersides->dimming().exclude(copy.model, copy.copy, supports, static_cast<std::size_t>(layer));
}

std::string_view name_of(PrintOutcome outcome) {
  switch (outcome) {
    case PrintOutcome::Done:
      return "done";
    case PrintOutcome::Canceled:
      return "cancelled";
    case PrintOutcome::Failed:
      return "failed";
  }
  return "?";
}

}  // namespace contourd
