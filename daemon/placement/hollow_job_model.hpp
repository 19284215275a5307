// Hollows the models of a job as their tickets say. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "core/hollow/hollow_model.hpp"
#include "core/support/support_settings.hpp"
#include "daemon/placement/plate_arrangement.hpp"

namespace contourd {

// A model to be hollowed, turned, scaled and at its height above the plate.
struct ModelToHollow {
  const ModelToPlace& model;
  HollowSettings settings;
  std::span<const Frustum> holes;  // the ticket's drain holes in the model
  Millimeters pixel;
  const SupportSettings& supports;  // have the strength of the resin
};

// Hollows the model; nullopt if `stop` was requested. Throws JobRefused if its walls would be thinner than
// two cells, or would not carry the layers that are peeled off above them. Blocks as hollow_model() does.
[[nodiscard]] std::optional<HollowedModel> hollow_job_model(const ModelToHollow& request,
                                                            const std::stop_token& stop);

// Returns warnings about a model's cavities: that it has none, or that no hole opens some.
[[nodiscard]] std::vector<std::string> hollow_warnings(const HollowedModel& hollowed,
                                                       const HollowSettings& settings);

}  // namespace contourd
