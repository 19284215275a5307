#include "daemon/ctl/models/supported_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/model/placement.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/support/support_lift.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/supports_text.hpp"

namespace contourd::ctl {
namespace {

Direction best_up(const std::vector<Facet>& facets, OrientationPreset preset, double scale) {
  ModelTicket ticket;
  ticket.orientation = OrientationTicket{preset, {}};
  ticket.scale = Scale{scale};
  const ModelOrientation found = find_orientation(facets, ticket, kAnyPrinter).value();
  fmt::print(stderr, "contourctl: {}\n", describe(found));
  return found.choice.chosen().up;
}

}  // namespace

Model read_turned_model(const std::filesystem::path& path, const std::optional<UpOption>& up,
                        const SizeArgs& size) {
  ModelOfFile read = read_model(path);
  const std::optional<double> scale = size_of(read, size);
  Model& model = read.model;
  if (!up && model.y_is_up) orient(model.facets, {.up = Direction{0, 1, 0}});
  if (up && !model.facets.empty()) {
    const auto* const preset = std::get_if<OrientationPreset>(&*up);
    orient(model.facets, {.up = preset != nullptr ? best_up(model.facets, *preset, scale.value_or(1))
                                                  : std::get<Direction>(*up)});
  }
  if (!scale) return std::move(model);
  orient(model.facets, {.scale = Scale{*scale}});
  const Bounds bounds = bounds_of(model.facets);
  if (!std::isfinite(bounds.size_x() + bounds.size_y() + bounds.size_z()))
    throw ModelError("the model is too large: its coordinates leave the range of numbers");
  return std::move(model);
}

std::vector<std::string> SupportedModel::warnings() const {
  std::vector<std::string> warnings{own_supports_sentence("the model", own_supports, "contourctl"), tilt};
  if (supports) std::ranges::move(supports_warnings(*supports), std::back_inserter(warnings));
  std::erase(warnings, "");
  return warnings;
}

ContourEngine SupportedModel::engine(const EngineSettings& settings) const {
  return {{model}, settings, supports ? supports->structure : nullptr};
}

PrintLayers print_layers(const StandingModel& model, Nanometers layer,
                         const std::optional<AdaptiveLayers>& adaptive) {
  return adaptive ? PrintLayers({model}, *adaptive) : PrintLayers(layers_for(model.top(), layer));
}

SupportedModel lay_on_plate(std::shared_ptr<const HeightIndex> model, const PixelMap& map) {
  return {.model = PlateModel{{std::move(model)}, {map}}};
}

SupportedModel support_model(std::shared_ptr<const HeightIndex> model, const SupportingOptions& options) {
  const PixelMap map = PixelMap::true_scale(options.display, model->bounds().center());
  SupportSettings settings;
  const Nanometers thickest = options.adaptive ? options.adaptive->thickest : options.layer;
  settings.closed_gap =
      closed_gap(kBottomLayers, options.adaptive ? options.adaptive->thinnest : options.layer);
  SupportedModel supported = lay_on_plate(std::move(model), map);
  supported.own_supports = find_own_supports(supported.model.model, settings, options.policy);
  if (supported.own_supports == OwnSupports::Kept) {
    supported.supports.emplace().carriers = 1;
    return supported;
  }
  supported.model.elevation = Elevation(support_lift(*supported.model.model, settings, thickest));
  if (supported.model.elevation.above_plate() > Nanometers{})
    supported.tilt = tilted_base_sentence("the model", *supported.model.model, settings, thickest,
                                          "--up auto turns it, and \"contourctl orient\" shows how");
  if (supported.model.top() > kHighestSweep) {
    throw ModelError(fmt::format("the model is {:.0f} mm high: supports are possible up to {:.0f} mm",
                                 supported.model.top().count(), kHighestSweep.count()));
  }
  const PrintedLayers printed{print_layers(supported.model, options.layer, options.adaptive).all(),
                              options.compensation, options.anti_aliasing,
                              std::max(CarryingSupport{}.least_grey, options.threshold)};
  supported.supports = make_supports({{supported.model}, options.display, settings, {}, printed}).value();
  return supported;
}

}  // namespace contourd::ctl
