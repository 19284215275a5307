#include "daemon/prepare/job_summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/json/config_error.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

// Returns "exposure_ms 4000 instead of 3000, lift_mm 8 instead of 6"; empty if nothing is overridden.
std::string describe_overrides(const OverriddenSettings& overridden) {
  std::string text;
  for (const OverriddenSetting& each : overridden) {
    text += text.empty() ? "" : ", ";
    text += std::string(each.setting) + " " + decimal(each.asked) + " instead of " + decimal(each.profile);
  }
  return text;
}

// Returns ", 4000 ms from 2.5 mm, 3500 ms from 5 mm"; empty if all normal layers have one exposure.
std::string describe_exposure_steps(const ResinProfile& resin) {
  std::string text;
  if (const auto* fixed = std::get_if<FixedExposure>(&resin.exposure))
    for (const auto& [from, exposure] : fixed->steps)
      text += fmt::format(", {:g} ms from {:g} mm", milliseconds(exposure), in_mm(from));
  return text;
}

}  // namespace

std::string layers_text(const ModelSummary& model) {
  return model.format == "sl1_svg" ? "outlines of layers" : "pictures of layers";
}

std::string describe_correction(const JobSummary& summary) {
  const Compensation& c = summary.resin.compensation;
  std::string text;
  const auto add = [&text](const std::string& clause) { text += (text.empty() ? "" : ", ") + clause; };
  if (c.growth != Micrometers{}) {
    add(fmt::format("contours moved {} by {:g} um", c.growth > Micrometers{} ? "outwards" : "inwards",
                    std::fabs(c.growth.count())));
  }
  if (c.elephant_foot != Micrometers{}) {
    add(fmt::format("elephant foot of {:g} um compensated over {:g} um of height", c.elephant_foot.count(),
                    to_millimeters(c.elephant_foot_height).count() * 1000));
  }
  if (summary.uniformity_mask) add("uniformity mask applied");
  if (summary.tone.gamma != 1.0) add(fmt::format("gamma {:g}", summary.tone.gamma));
  if (summary.grey_bits < 8) add(fmt::format("exposures split for {} bits of grey", summary.grey_bits));
  if (summary.tone.threshold != 0) add(fmt::format("grey below {} left dark", summary.tone.threshold));
  return text;
}

// Returns "; lift 2 mm at 1.5 mm/s, then 4 mm at 5 mm/s, retract at 2.5 mm/s, the last 0.5 mm at 1 mm/s; wait
// 1000 ms before exposure, 500 ms after".
std::string describe_motion(const ResinProfile& resin) {
  const LayerMotion& motion = resin.motion;
  std::string text =
      fmt::format("; lift {:g} mm at {:g} mm/s", figure_of(motion.lift), figure_of(motion.lift_speed));
  if (motion.second_lift > Nanometers{})
    text += fmt::format(", then {:g} mm at {:g} mm/s", figure_of(motion.second_lift),
                        figure_of(motion.second_lift_speed));
  text += fmt::format(", retract at {:g} mm/s", figure_of(motion.retract_speed));
  if (motion.slow_retract > Nanometers{})
    text += fmt::format(", the last {:g} mm at {:g} mm/s", figure_of(motion.slow_retract),
                        figure_of(motion.slow_retract_speed));
  text += fmt::format("; wait {:g} ms before exposure", figure_of(motion.settle));
  if (resin.viscosity_mpa_s)
    text += fmt::format(", longer after large layers ({:g} mPa s)", *resin.viscosity_mpa_s);
  return text + fmt::format(", {:g} ms after", figure_of(motion.rest));
}

std::string describe_settings(const JobSummary& summary) {
  const ResinProfile& resin = summary.resin;
  const auto exposure_ms = [&](Nanometers thickness, std::int32_t layer) {
    return milliseconds(exposure_time(resin, thickness, layer, summary.irradiance_mw_cm2));
  };
  const LayerSummary& layers = summary.layers;
  // The first layer after the bottom layers and the fade.
  const std::int32_t normal = resin.bottom_layers + resin.fade_layers;
  const double least = exposure_ms(layers.thinnest, normal), most = exposure_ms(layers.thickest, normal);
  std::string text = least == most
                         ? fmt::format("{}: exposure {:g} ms", printable(resin.name), least)
                         : fmt::format("{}: exposure {:g} to {:g} ms", printable(resin.name), least, most);
  text += describe_exposure_steps(resin);
  if (resin.bottom_layers > 0)
    text += fmt::format(", {:g} ms in {} bottom layers, fading over {}", exposure_ms(layers.thinnest, 0),
                        resin.bottom_layers, resin.fade_layers);
  text += describe_motion(resin);
  if (const auto& followed = summary.temperature)
    text += fmt::format("; light for resin of {:.1f} degrees C, {:.3g} of that at {:g} degrees",
                        followed->resin_c, followed->light, followed->curve_c);
  if (const auto& measured = resin.cure_irradiance; measured && measured->exponent != 1)
    text += fmt::format(
        "; light for {:g} mW/cm² by the reciprocity exponent {:g}, {:.3g} of the dose at {:g}",
        summary.irradiance_mw_cm2, measured->exponent,
        std::pow(summary.irradiance_mw_cm2 / measured->measured_at.count(), 1 - measured->exponent),
        measured->measured_at.count());
  if (summary.dry) text += "; dry run, without light";
  if (resin.undersides == Undersides::Dose) text += "; undersides by dose";
  if (resin.mode == PrintWay::Continuous) text += "; continuous";
  if (!summary.overridden.empty()) text += "; by its ticket: " + describe_overrides(summary.overridden);
  return text;
}

nlohmann::ordered_json overrides_json(const OverriddenSettings& overridden) {
  auto list = nlohmann::ordered_json::array();
  for (const OverriddenSetting& each : overridden)
    list.push_back({{"setting", each.setting}, {"asked", each.asked}, {"profile", each.profile}});
  return list;
}

}  // namespace contourd
