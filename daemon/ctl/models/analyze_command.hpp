// contourctl analyze: forecasts a whole print. Prints its result and returns the exit code. Problems with the
// data are thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "core/engine/contour_engine.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/ctl/models/up_option.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

struct AnalyzeOptions {
  std::filesystem::path model;
  bool json = false;
  std::optional<std::filesystem::path> html;  // one self-contained page

  // Configuration and ticket of a print by contourd.
  std::optional<std::filesystem::path> printer, ticket;
  // Without a configuration: the direction that points up, the display, and the time of each layer.
  std::optional<UpOption> up;
  DisplayGeometry display;
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Nanometers layer_height{50'000};
  Duration layer_time{};

  std::optional<SupportPolicy> supports;  // nullopt: as configured; without a configuration none
  std::optional<double> scale;            // factor for the model's size
};
int analyze(const AnalyzeOptions& options);

}  // namespace contourd::ctl
