// contourctl analyze. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
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

  // As contourd would print it: with this configuration, and a job's ticket.
  std::optional<std::filesystem::path> printer, ticket;
  // Without a printer: turned so, in the middle of this display, and so much time for every layer.
  std::optional<UpOption> up;
  DisplayGeometry display;
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Nanometers layer_height{50'000};
  Duration layer_time{};

  std::optional<SupportPolicy> supports;  // as the printer does without it; without a printer none
  std::optional<double> scale;            // factor on the model's size
};
int analyze(const AnalyzeOptions& options);

}  // namespace contourd::ctl
