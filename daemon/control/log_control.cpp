#include "daemon/control/log_control.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using Json = ControlMethod::Json;

constexpr std::size_t kUsual = 100;

std::string_view name_of(LogLevel level) {
  switch (level) {
    case LogLevel::Error:
      return "error";
    case LogLevel::Warning:
      return "warning";
    case LogLevel::Info:
      return "info";
  }
  return "info";
}

}  // namespace

ControlMethods LogControl::methods() {
  return {{"log",
           {.description = "Reports the latest entries of contourd's log since it started.",
            .parameters = {ControlParameter::whole_number("last", 1, Log::kMostRecent,
                                                          "the number of entries; 100 without it")},
            .call = [this](const Json& given, const ControlCaller&) {
              return entries(given.value("last", kUsual));
            }}}};
}

Json LogControl::entries(std::size_t most) const {
  const auto& recent = log_.recent();
  auto first = recent.end();
  for (std::size_t bytes = 0; first != recent.begin() && most > 0; --first, --most) {
    bytes += std::prev(first)->message.size();
    if (bytes > kMostBytes) break;
  }
  Json entries = Json::array();
  for (; first != recent.end(); ++first)
    entries.push_back({{"time", iso_time(first->time)},
                       {"level", name_of(first->level)},
                       {"event", first->event},
                       {"message", first->message}});
  return {{"entries", std::move(entries)}};
}

}  // namespace contourd
