#include "daemon/config/sliced_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {
namespace {

// Returns the ticket's keys that finished layers cannot have.
std::vector<std::string_view> keys_for_models(const JobTicket& ticket) {
  const ModelTicket& model = ticket.models.front();
  std::vector<std::string_view> keys;
  const auto add = [&keys](bool is_asked, std::string_view key) {
    if (is_asked) keys.push_back(key);
  };
  add(ticket.adaptive.has_value(), "adaptive_layers");
  add(ticket.undersides == Undersides::Dose, "undersides");
  add(ticket.mode == PrintWay::Continuous, "mode");
  add(ticket.cracks.has_value(), "cracks");
  add(ticket.supports && ticket.supports->policy == SupportPolicy::On, "supports");
  add(model.unit.has_value(), "unit");
  add(model.rotation != RotationDegrees{}, "rotation_deg");
  add(model.up || model.orientation, "up");
  add(model.scale.has_value(), "scale");
  add(model.fit, "fit");
  add(model.position.has_value(), "position_mm");
  add(model.copies != 1, "copies");
  add(!model.drain.empty(), "drain");
  add(model.hollow.has_value(), "hollow");
  return keys;
}

std::string um_text(Nanometers height) {
  return decimal(static_cast<double>(height.count()) / 1e3) + " um";
}

bool sets_exposures(const JobTicket& ticket) {
  const TicketOverrides& asked = ticket.overrides;
  return asked.exposure || asked.bottom_exposure || !asked.exposure_steps.empty();
}

std::string refuse_layer_height(Nanometers of_file, const JobTicket& ticket, const ResinProfile& resin) {
  if (ticket.layer_height && *ticket.layer_height != of_file)
    return fmt::format(
        "the ticket asks for layers of {}, and the layers of the file are {} thick: leave out "
        "layer_height_um, or slice the model again",
        um_text(*ticket.layer_height), um_text(of_file));
  if (sets_exposures(ticket) && !ticket.layer_height && of_file != resin.layer_height)
    return fmt::format(
        "the ticket sets exposures, which are for the profile's layers of {}, and the layers of the "
        "file are {} thick: add \"layer_height_um\": {} to the ticket",
        um_text(resin.layer_height), um_text(of_file), decimal(static_cast<double>(of_file.count()) / 1e3));
  return "";
}

// An exposure of the file, and the key of the profile's limits for it.
struct AskedExposure {
  std::string_view key;
  Duration asked, of_profile;
  const std::optional<Limits<Duration>>& limits;

  [[nodiscard]] std::string refusal(const ResinProfile& resin) const {
    if (!limits)
      return fmt::format(
          "the resin profile {} has no ticket_limits for {}, so that the file's exposures cannot be "
          "taken: leave out exposure_from, or add the limits",
          in_quotes(resin.name), key);
    if (limits->contain(asked)) return "";
    return fmt::format(
        "the file's {} is {}, and ticket_limits of the resin profile {} allow {} to {}: leave out "
        "exposure_from, or slice the model again",
        key, decimal(figure_of(asked)), in_quotes(resin.name), decimal(figure_of(limits->least)),
        decimal(figure_of(limits->most)));
  }
};

std::string take_exposures(const FileLayers& layers, double irradiance_mw_cm2, ResinProfile& resin,
                           OverriddenSettings& overridden) {
  if (!layers.exposures)
    return "the ticket takes the exposures from the file, which names none (expTime and expTimeFirst in "
           "config.ini, CureTime in profile.json): leave out exposure_from";
  const FileExposures& file = *layers.exposures;
  const int normal_layer = resin.bottom_layers + resin.fade_layers;
  const auto of_profile = [&](int layer) {
    return exposure_time(resin, layers.thickness, layer, irradiance_mw_cm2);
  };
  for (const AskedExposure& each :
       {AskedExposure{kTicketSettings[0], file.normal, of_profile(normal_layer), resin.limits.exposure},
        AskedExposure{kTicketSettings[1], file.first, of_profile(0), resin.limits.bottom_exposure}}) {
    if (std::string refusal = each.refusal(resin); !refusal.empty()) return refusal;
    overridden.push_back({each.key, figure_of(each.asked), figure_of(each.of_profile)});
  }
  resin.exposure = FixedExposure{file.normal, file.first, {}};
  resin.bottom_layers = file.first_layers;
  resin.fade_layers = file.fading_layers;
  return "";
}

}  // namespace

std::string refusal_for_layers(const JobTicket& ticket) {
  const auto keys = keys_for_models(ticket);
  if (keys.empty()) return "";
  return fmt::format(
      "the file holds finished layers, and the ticket asks for {}, which need{} a model: leave {} out, or "
      "print "
      "the model itself",
      fmt::join(keys, ", "), keys.size() == 1 ? "s" : "", keys.size() == 1 ? "it" : "them");
}

std::string settle_for_layers(const FileLayers& layers, double irradiance_mw_cm2, JobTicket& ticket,
                              ResinProfile& resin, OverriddenSettings& overridden) {
  expects(irradiance_mw_cm2 > 0, "there is light");
  if (std::string refusal = refusal_for_layers(ticket); !refusal.empty()) return refusal;
  if (std::string refusal = refuse_layer_height(layers.thickness, ticket, resin); !refusal.empty())
    return refusal;
  ticket.layer_height = layers.thickness;
  if (!layers.outlines) resin.compensation = {};
  resin.shrinkage_factors = {};
  resin.undersides = Undersides::Plain;
  resin.mode = PrintWay::Layered;
  return ticket.exposures_of_file ? take_exposures(layers, irradiance_mw_cm2, resin, overridden) : "";
}

}  // namespace contourd
