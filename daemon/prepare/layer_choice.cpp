#include "daemon/prepare/layer_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

void check_layer_height(Nanometers thickness, const ResinProfile& resin, const PrinterConfig& printer) {
  const auto problems = layer_height_problems(resin, thickness, printer.irradiance_mw_cm2);
  if (problems.empty()) return;
  throw JobRefused(fmt::format("the layer height cannot be printed: {}", fmt::join(problems, "; ")));
}

AdaptiveLayers adaptive_limits(const AdaptiveTicket& ticket, const ResinProfile& resin,
                               const PrinterConfig& printer) {
  if (std::holds_alternative<FixedExposure>(resin.exposure)) {
    throw JobRefused(fmt::format(
        "adaptive layers need a resin with a working curve: the exposure times of {} are valid only "
        "for its layer height of {:g} um",
        in_quotes(resin.name), to_millimeters(resin.layer_height).count() * 1000));
  }
  const AdaptiveLayers limits{ticket.thinnest.value_or(resin.layer_height_min),
                              ticket.thickest.value_or(resin.layer_height_max), ticket.cusp};
  for (const Nanometers thickness : {limits.thinnest, limits.thickest})
    check_layer_height(thickness, resin, printer);
  if (limits.thinnest > limits.thickest) {
    throw JobRefused(fmt::format(
        "the thinnest adaptive layer, {:g} um, is thicker than the thickest, {:g} um",
        to_millimeters(limits.thinnest).count() * 1000, to_millimeters(limits.thickest).count() * 1000));
  }
  return limits;
}

}  // namespace

Nanometers layer_beneath(const JobTicket& ticket, const ResinProfile& resin) {
  if (ticket.adaptive) return ticket.adaptive->thickest.value_or(resin.layer_height_max);
  return ticket.layer_height.value_or(resin.layer_height);
}

Millimeters closed_gap(const JobTicket& ticket, const ResinProfile& resin) {
  const Nanometers layer = ticket.adaptive ? ticket.adaptive->thinnest.value_or(resin.layer_height_min)
                                           : ticket.layer_height.value_or(resin.layer_height);
  return closed_gap(resin.bottom_layers, layer);
}

PrintLayers choose_layers(const JobTicket& ticket, const PrinterConfig& printer,
                          const std::vector<ModelToPlace>& models, JobSummary& summary) {
  const ResinProfile& resin = summary.resin;
  if (ticket.adaptive) {
    summary.layers.adaptive = adaptive_limits(*ticket.adaptive, resin, printer);
    summary.layers.thinnest = summary.layers.adaptive->thinnest;
    std::vector<StandingModel> standing;
    for (const ModelToPlace& model : models)
      standing.push_back(model.standing());
    return {std::move(standing), *summary.layers.adaptive};
  }
  const Nanometers thickness = ticket.layer_height.value_or(resin.layer_height);
  check_layer_height(thickness, resin, printer);
  summary.layers.thinnest = thickness;
  return PrintLayers(layers_for(Millimeters{summary.height_mm}, thickness));
}

void count_layers(PrintPlan& plan, JobSummary& summary) {
  plan.expected_layers = plan.layers.all();
  if (plan.expected_layers.empty())
    throw JobRefused(fmt::format("the model is {:.6g} mm high, too thin for a layer", summary.height_mm));
  summary.layers.count = static_cast<std::int32_t>(plan.expected_layers.size());
  const auto [thinnest, thickest] = std::ranges::minmax(plan.expected_layers);
  summary.layers.thinnest = thinnest;
  summary.layers.thickest = thickest;
}

}  // namespace contourd
