#include "daemon/history/reminders.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

namespace contourd {
namespace {

// Returns the day in this computer's time zone.
std::string day_of(std::chrono::system_clock::time_point when) {
  const std::time_t time = std::chrono::system_clock::to_time_t(when);
  std::tm local{};
  return ::localtime_r(&time, &local) != nullptr ? fmt::format("{:%Y-%m-%d}", local) : "?";
}

}  // namespace

std::string reminder_of(const WearPartUse& use, const WearLimits& limits) {
  std::vector<std::string> reached;
  if (limits.lamp_h && use.lamp_h >= *limits.lamp_h)
    reached.push_back(fmt::format("{:.1f} h of light (limit {:.10g})", use.lamp_h, *limits.lamp_h));
  if (limits.layers && use.layers >= *limits.layers)
    reached.push_back(fmt::format("{} layers (limit {})", use.layers, *limits.layers));
  if (limits.prints && use.prints >= *limits.prints)
    reached.push_back(
        fmt::format("{} {} (limit {})", use.prints, use.prints == 1 ? "print" : "prints", *limits.prints));
  if (reached.empty()) return {};
  return fmt::format("the {0} is due: {1} {2}; when it is replaced: contourctl replaced {0}",
                     name_of(use.part), fmt::join(reached, ", "),
                     use.replaced ? "since " + day_of(*use.replaced) : "since the history began");
}

bool Reminders::wanted() const {
  return std::ranges::any_of(kWearParts, [this](WearPart part) {
    const WearLimits& each = limits(part);
    return each.lamp_h || each.layers || each.prints;
  });
}

const WearLimits& Reminders::limits(WearPart part) const {
  switch (part) {
    case WearPart::Lamp:
      return config_.lamp;
    case WearPart::Film:
      return config_.film;
    case WearPart::Vat:
      break;
  }
  return config_.vat;
}

void Reminders::update(const std::vector<WearPartUse>& uses) {
  due_.clear();
  for (const WearPartUse& use : uses)
    if (std::string sentence = reminder_of(use, limits(use.part)); !sentence.empty())
      due_.push_back(std::move(sentence));
}

}  // namespace contourd
