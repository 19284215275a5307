#include "daemon/config/ticket_overrides.hpp"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/config/support_figures.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

struct Overriding {
  const OverrideFiles& files;
  OverriddenSettings overridden{};
  std::vector<Violation> refused{};

  template <typename Quantity>
  void set(std::string_view key, const std::optional<Quantity>& asked,
           const std::optional<Limits<Quantity>>& limits, Quantity& setting) {
    if (!asked || !allows(key, *asked, limits)) return;
    overridden.push_back({key, figure_of(*asked), figure_of(setting)});
    setting = *asked;
  }
  // Returns whether the profile allows a value. Notes a refusal at the value's place in the ticket.
  template <typename Quantity>
  bool allows(std::string_view place, Quantity asked, const std::optional<Limits<Quantity>>& limits) {
    const std::string wanted = decimal(figure_of(asked)) + " is asked for, but ";
    if (!limits) {
      refuse(place, wanted + "the resin's profile names no ticket_limits for it: " + files.profile.string());
    } else if (!limits->contain(asked)) {
      refuse(place, wanted + "the resin's profile allows tickets " + decimal(figure_of(limits->least)) +
                        " to " + decimal(figure_of(limits->most)) + ": " + files.profile.string());
    } else {
      return true;
    }
    return false;
  }
  void refuse(std::string_view key, std::string message) {
    refused.push_back({files.ticket, "/" + std::string(key), std::move(message)});
  }
};

// Returns the exposures at this layer height, fixed or from the working curve.
FixedExposure exposures_at(const ResinProfile& resin, Nanometers layer_height, double irradiance_mw_cm2) {
  if (const auto* fixed = std::get_if<FixedExposure>(&resin.exposure)) return *fixed;
  const int first_normal_layer = resin.bottom_layers + resin.fade_layers;
  ResinProfile with_bottom = resin;
  with_bottom.bottom_layers = 1;
  return {exposure_time(resin, layer_height, first_normal_layer, irradiance_mw_cm2),
          exposure_time(with_bottom, layer_height, 0, irradiance_mw_cm2)};
}

void override_exposures(ResinProfile& resin, const JobTicket& ticket, double irradiance_mw_cm2,
                        Overriding& overriding) {
  const TicketOverrides& asked = ticket.overrides;
  if (!asked.exposure && !asked.bottom_exposure && asked.exposure_steps.empty()) return;
  const Nanometers layer_height = ticket.layer_height.value_or(resin.layer_height);
  const std::vector<std::string> problems = layer_height_problems(resin, layer_height, irradiance_mw_cm2);
  for (const std::string& problem : problems)
    overriding.refuse("layer_height_um", problem);
  if (!problems.empty()) return;
  FixedExposure exposures = exposures_at(resin, layer_height, irradiance_mw_cm2);
  overriding.set("exposure_ms", asked.exposure, resin.limits.exposure, exposures.exposure);
  overriding.set("bottom_exposure_ms", asked.bottom_exposure, resin.limits.bottom_exposure,
                 exposures.bottom_exposure);
  // A profile is checked by the same rule.
  if (exposures.exposure > exposures.bottom_exposure) {
    overriding.refuse(asked.exposure ? "exposure_ms" : "bottom_exposure_ms",
                      "an exposure of " + decimal(figure_of(exposures.exposure)) +
                          " ms would be more than the bottom exposure, " +
                          decimal(figure_of(exposures.bottom_exposure)) + " ms");
  }
  for (const ExposureStep& step : asked.exposure_steps) {
    const std::string place = "exposure_steps/" + std::to_string(exposures.steps.size()) + "/exposure_ms";
    if (overriding.allows(place, step.exposure, resin.limits.exposure))
      overriding.overridden.push_back(
          {kExposureSteps, figure_of(step.exposure), figure_of(exposures.exposure)});
    exposures.steps.push_back(step);
  }
  resin.exposure = exposures;
}

// Overrides the supports. They need no limits, because no shape of a support can damage the machine.
void override_supports(ResinProfile& resin, const JobTicket& ticket, Overriding& overriding) {
  if (!ticket.supports || ticket.supports->figures.empty()) return;
  std::ranges::copy(override_supports(resin.supports, ticket.supports->figures),
                    std::back_inserter(overriding.overridden));
  for (const SupportContradiction& found : contradictions_of(resin.supports))
    overriding.refuse("supports/" + std::string(found.key), found.sentence);
}

}  // namespace

OverriddenSettings override_settings(ResinProfile& resin, const JobTicket& ticket, double irradiance_mw_cm2,
                                     const OverrideFiles& files) {
  expects(irradiance_mw_cm2 > 0, "there is light");
  const TicketOverrides& asked = ticket.overrides;
  Overriding overriding{files};
  override_exposures(resin, ticket, irradiance_mw_cm2, overriding);
  overriding.set("lift_mm", asked.lift, resin.limits.lift, resin.motion.lift);
  overriding.set("settle_ms", asked.settle, resin.limits.settle, resin.motion.settle);
  overriding.set("rest_ms", asked.rest, resin.limits.rest, resin.motion.rest);
  override_supports(resin, ticket, overriding);
  resin.undersides = ticket.undersides.value_or(resin.undersides);
  resin.mode = ticket.mode.value_or(resin.mode);
  if (!overriding.refused.empty()) throw ConfigError(overriding.refused);
  return std::move(overriding.overridden);
}

}  // namespace contourd
