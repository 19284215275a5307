#include "daemon/placement/hollow_job_model.hpp"

#include <fmt/format.h>

#include <numbers>
#include <stdexcept>

#include "daemon/print/job_refused.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Throws JobRefused if the walls are weaker than what hangs on them. One square millimetre of a section
// carries as large a layer as that of a support's tip.
void refuse_weak_walls(const ModelToHollow& request, const HollowedModel& hollowed) {
  const double tip_mm = request.supports.tip_diameter.count();
  const double carried = request.supports.tip_holds_mm2 / (std::numbers::pi / 4 * tip_mm * tip_mm);
  if (hollowed.least_carrying * carried >= 1) return;
  throw JobRefused(fmt::format(
      "the walls of {} would tear when the layers above them are peeled off: where they are weakest, they "
      "have "
      "{:.2g} % of the area of the largest layer above, and {:.2g} % carry it; give \"hollow\" a greater "
      "wall_mm than {:g}, or an infill",
      request.model.name, 100 * hollowed.least_carrying, 100 / carried, request.settings.wall.count()));
}

}  // namespace

std::optional<HollowedModel> hollow_job_model(const ModelToHollow& request, const std::stop_token& stop) {
  try {
    std::optional<HollowedModel> hollowed =
        hollow_model({request.model.standing(), request.settings, request.holes, request.pixel}, stop);
    if (hollowed) refuse_weak_walls(request, *hollowed);
    return hollowed;
  } catch (const std::range_error& error) {
    throw JobRefused(fmt::format("{} cannot be made hollow with walls of {:g} mm: {}", request.model.name,
                                 request.settings.wall.count(), error.what()));
  }
}

std::vector<std::string> hollow_warnings(const HollowedModel& hollowed, const HollowSettings& settings) {
  std::vector<std::string> warnings;
  if (hollowed.cavities == 0)
    warnings.push_back(
        fmt::format("not made hollow: with walls of {:g} mm, there is no room for a cavity of {:g} mm3",
                    settings.wall.count(), kLeastCavityMm3));
  if (hollowed.closed > 0)
    warnings.push_back(fmt::format("no hole opens {}: {}", count_of(hollowed.closed, "cavity", "cavities"),
                                   settings.hole == Millimeters{}
                                       ? "the ticket's hole_mm is 0, and none of its drain holes does"
                                       : "another cavity lies around it"));
  return warnings;
}

}  // namespace contourd
