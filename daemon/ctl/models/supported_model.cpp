#include "daemon/ctl/models/supported_model.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/formats/model_format.hpp"
#include "core/model/placement.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/support/support_lift.hpp"
#include "daemon/prepare/supports_text.hpp"

namespace contourd::ctl {

ContourEngine SupportedModel::engine(const EngineSettings& settings) const {
  return {{model}, settings, supports ? supports->structure : nullptr};
}

SupportedModel lay_on_plate(std::shared_ptr<const HeightIndex> model, const PixelMap& map) {
  return {PlateModel{{std::move(model)}, {map}}, std::nullopt};
}

SupportedModel support_model(std::shared_ptr<const HeightIndex> model, const SupportingOptions& options) {
  const PixelMap map = PixelMap::true_scale(options.display, model->bounds().center());
  SupportedModel supported = lay_on_plate(std::move(model), map);
  supported.model.elevation =
      Elevation(support_lift(*supported.model.model, options.settings, options.layer));
  if (supported.model.top() > kHighestSweep) {
    throw ModelError(fmt::format("the model is {:.0f} mm high: supports are possible up to {:.0f} mm",
                                 supported.model.top().count(), kHighestSweep.count()));
  }
  supported.supports = make_supports({{supported.model}, options.display, options.settings}).value();
  return supported;
}

void scale_facets(std::vector<Facet>& facets, std::optional<double> factor) {
  if (!factor) return;
  Orientation orientation;
  orientation.scale = Scale{*factor};
  orient(facets, orientation);
  const Bounds bounds = bounds_of(facets);
  if (!std::isfinite(bounds.size_x() + bounds.size_y() + bounds.size_z()))
    throw ModelError("the model is too large: its coordinates leave the range of numbers");
}

void warn_of_unheld(const SupportedModel& model) {
  if (!model.supports) return;
  if (const std::string sentence = unheld_sentence(model.supports->unheld); !sentence.empty())
    fmt::print(stderr, "contourctl: warning: {}\n", sentence);
}

}  // namespace contourd::ctl
