// Places a ticket's drain holes in the turned and scaled model, and checks that each hole removes something
// from it. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/support/support_primitive.hpp"
#include "daemon/config/job_ticket.hpp"

namespace contourd {

// Returns the ticket's holes as cylinders, in the ticket's order and in the coordinates of the turned and
// scaled model. `scale` is the model's, `shrinkage` the resin's. Throws JobRefused if a scaled hole is too
// small, too large or too far away.
[[nodiscard]] std::vector<Frustum> drain_cylinders(const ModelTicket& ticket, const Scale& scale,
                                                   const Scale& shrinkage);
// Returns the cylinders as the engine subtracts them from the model; null if there are none.
[[nodiscard]] std::shared_ptr<const SectionSource> holes_of(std::span<const Frustum> cylinders);

// A model and the holes to check in it.
struct DrilledModel {
  const PlateModel& model;  // the member `holes` is ignored
  const ModelTicket& ticket;
  std::span<const Frustum> cylinders;  // the ticket's holes in it
};
// Layers and deadline of the check. A hole whose check has not ended by the deadline counts as good.
struct HoleSearch {
  EngineSettings settings;
  std::vector<Nanometers> heights;  // at which the print cuts its layers
  MaskBudget::Clock::time_point deadline;
};
// Time limit for all holes of a job. A hole that cuts the model usually does so in the first layers that it
// reaches, so its check is short.
inline constexpr std::chrono::seconds kLongestHoleSearch{5};

// Throws JobRefused for the first hole that removes nothing from any layer; `name` is the model's. Blocks for
// two masks of each layer that a hole reaches, up to the first layer that it cuts.
void refuse_holes_beside(const DrilledModel& drilled, const std::string& name, const HoleSearch& search);

}  // namespace contourd
