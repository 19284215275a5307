// A model as contourctl makes it ready without a printer: scaled, standing in the middle of a display, and
// held by supports where they are wanted. Thread-safe (no shared state).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/routing/support_generation.hpp"

namespace contourd::ctl {

struct HeldModel {
  PlateModel model;                  // one copy
  std::optional<Supports> supports;  // nothing where none are wanted

  [[nodiscard]] ContourEngine engine(const EngineSettings& settings) const;
};

struct HoldingOptions {
  DisplayGeometry display;
  Nanometers layer{50'000};  // the model is lifted by whole ones
  SupportSettings settings{};
};

// Blocks: see make_supports(). Nowhere is the model moved in x or y.
[[nodiscard]] HeldModel hold_model(std::shared_ptr<const HeightIndex> model, const HoldingOptions& options);
// The same without supports.
[[nodiscard]] HeldModel lay_on_plate(std::shared_ptr<const HeightIndex> model, const PixelMap& map);

// The factor, if there is one. Throws ModelError when coordinates leave the range of numbers.
void scale_facets(std::vector<Facet>& facets, std::optional<double> factor);

// What cannot be held, a line each on the standard error, the first ones.
void warn_of_unheld(const HeldModel& model);

}  // namespace contourd::ctl
