#include "daemon/config/continuous_resin.hpp"

#include <fmt/format.h>

#include <string_view>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"

namespace contourd {
namespace {

constexpr double kSecondsPerHour = 3600;

MissedMasks missed_masks_of(std::string_view name) {
  if (name == "slow") return MissedMasks::Slow;
  return name == "pause" ? MissedMasks::Pause : MissedMasks::Keep;
}

}  // namespace

std::optional<ContinuousResin> read_continuous(const JsonSection& profile) {
  if (!profile.has("continuous")) return std::nullopt;
  const JsonSection section = profile.section("continuous");
  const auto speed = [&](std::string_view key) {
    return MillimetersPerSecond{section.number(key) / kSecondsPerHour};
  };
  return ContinuousResin{.margin = section.number("margin"),
                         .refill_pressure_kpa = section.number("refill_pressure_kpa"),
                         .window = section.duration("window_s"),
                         .recovery = section.duration("recovery_s"),
                         .layered = section.length("layered_mm"),
                         .mask_step = Micrometers{section.number("mask_step_um")},
                         .slowest = speed("least_speed_mm_h"),
                         .fastest = speed("most_speed_mm_h"),
                         .missed = missed_masks_of(section.text("missed_masks"))};
}

void check_continuous(JsonDocument& profile) {
  const auto least = profile.valid_number("/continuous/least_speed_mm_h");
  const auto most = profile.valid_number("/continuous/most_speed_mm_h");
  if (!least || !most || *least <= *most) return;
  profile.add_violation("/continuous/least_speed_mm_h",
                        fmt::format("{:g} is more than most_speed_mm_h, {:g}", *least, *most));
}

}  // namespace contourd
