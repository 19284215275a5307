// The drain holes of a ticket, as they lie in the model that is turned and scaled by it, and whether each of
// them takes something away. Thread-safe (no shared state).
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

// Cylinders in the coordinates of the model that was turned by its ticket, scaled by these factors of its and
// the resin's, in the ticket's order. Throws JobRefused for one that has no length there.
[[nodiscard]] std::vector<Frustum> drain_cylinders(const ModelTicket& ticket, const Scale& scale,
                                                   const Scale& shrinkage);
// As the engine takes them out of the model. Null where there are none.
[[nodiscard]] std::shared_ptr<const SectionSource> holes_of(std::span<const Frustum> cylinders);

// Where holes are looked for in a model.
struct DrilledModel {
  const PlateModel& model;  // its own holes do not count
  const ModelTicket& ticket;
  std::span<const Frustum> cylinders;  // the ticket's holes in it
};
// How they are looked for: what is not known by the deadline is believed.
struct HoleSearch {
  EngineSettings settings;
  std::vector<Nanometers> heights;  // where the print cuts its layers
  MaskBudget::Clock::time_point deadline;
};
// At the holes of a whole job. One that is good shows in the first layers that it reaches.
inline constexpr std::chrono::seconds kLongestHoleSearch{5};

// Throws JobRefused for the first hole that takes nothing away from any layer; `name` is the model's. Blocks
// for two masks of each layer that a hole reaches, up to the first that it cuts.
void refuse_holes_beside(const DrilledModel& drilled, const std::string& name, const HoleSearch& search);

}  // namespace contourd
