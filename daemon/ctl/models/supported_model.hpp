// A model that contourctl prepares without a printer's configuration: scaled, in the middle of a display,
// with supports if wanted. Thread-safe (no shared state).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/routing/support_layout.hpp"

namespace contourd::ctl {

struct SupportedModel {
  PlateModel model;                  // one copy
  std::optional<Supports> supports;  // nullopt: not wanted

  [[nodiscard]] ContourEngine engine(const EngineSettings& settings) const;
};

struct SupportingOptions {
  DisplayGeometry display;
  Nanometers layer{50'000};  // the model is lifted by whole layers
  SupportSettings settings{};
};

// Prepares a model with supports. Does not move it in x or y. Blocks: see make_supports().
[[nodiscard]] SupportedModel support_model(std::shared_ptr<const HeightIndex> model,
                                           const SupportingOptions& options);
// Prepares a model without supports.
[[nodiscard]] SupportedModel lay_on_plate(std::shared_ptr<const HeightIndex> model, const PixelMap& map);

// Scales the facets if there is a factor. Throws ModelError if coordinates leave the range of numbers.
void scale_facets(std::vector<Facet>& facets, std::optional<double> factor);

// Prints a warning about places that cannot be supported, if there are any.
void warn_of_unheld(const SupportedModel& model);

}  // namespace contourd::ctl
