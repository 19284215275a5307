#include "daemon/config/resin_profile.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/config/support_figures.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "daemon/json/json_schema.hpp"
#include "daemon/json/json_section.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

struct ExposureSeconds {
  double normal;
  double bottom;
};

// Returns the exposures at this layer height. Curing to the depth Cd needs the energy E = Ec exp(Cd / Dp),
// and the light delivers it in E / irradiance.
ExposureSeconds exposures_s(const ResinProfile& resin, Nanometers layer_height, double irradiance_mw_cm2) {
  if (const auto* fixed = std::get_if<FixedExposure>(&resin.exposure)) {
    const auto seconds = [](Duration d) { return std::chrono::duration<double>(d).count(); };
    return {seconds(fixed->exposure), seconds(fixed->bottom_exposure)};
  }
  const auto& by_curve = std::get<CurveExposure>(resin.exposure);
  const WorkingCurve& curve = resin.cure.value().curve;
  const Micrometers layer{in_mm(layer_height) * 1000};
  const auto seconds = [&](Micrometers overcure) {
    return curve.dose_for(layer + overcure).count() / irradiance_mw_cm2;
  };
  return {seconds(by_curve.overcure), seconds(by_curve.bottom_overcure)};
}

// Returns the exposure of a normal layer whose middle is at a height, if the job has one of its own for it.
std::optional<Duration> step_exposure(const ResinProfile& resin, Nanometers middle) {
  std::optional<Duration> exposure;
  if (const auto* fixed = std::get_if<FixedExposure>(&resin.exposure))
    for (const ExposureStep& step : fixed->steps)
      if (step.from <= middle) exposure = step.exposure;
  return exposure;
}

// Returns a time to three digits.
std::string readable_exposure(double seconds) {
  constexpr double kDayS = 86'400;
  if (!(seconds <= kDayS)) return "more than a day";
  if (seconds >= 1) return fmt::format("{:.4g} s", seconds);
  return seconds >= 1e-6 ? fmt::format("{:.3g} ms", seconds * 1000) : "less than a microsecond";
}

// Returns the words that distinguish a critical energy from that in the profile; empty if it is that one.
std::string_view at_this_light(const ResinProfile& resin) {
  const bool follows = resin.cure_irradiance && resin.cure_irradiance->exponent != 1;
  return follows ? " (at this irradiance)" : "";
}

// Returns the reason why the exposures at this layer height are outside their limits, with all figures that
// they follow from; nullopt if they are within.
std::optional<std::string> exposure_problem(const ResinProfile& resin, Nanometers layer_height,
                                            double irradiance_mw_cm2, Irradiance of) {
  const auto [normal, bottom] = exposures_s(resin, layer_height, irradiance_mw_cm2);
  const double shortest = std::chrono::duration<double>(kShortestExposure).count();
  const double longest = std::chrono::duration<double>(kLongestExposure).count();
  const auto is_outside = [&](double seconds) { return !(seconds >= shortest && seconds <= longest); };
  if (!is_outside(normal) && !is_outside(bottom)) return std::nullopt;
  std::string problem =
      fmt::format("{} of {:g} um would last {}", is_outside(normal) ? "a layer" : "a bottom layer",
                  in_mm(layer_height) * 1000, readable_exposure(is_outside(normal) ? normal : bottom));
  if (is_outside(normal) && is_outside(bottom) && bottom != normal)
    problem += fmt::format(", a bottom layer {}", readable_exposure(bottom));
  problem += "; an exposure must last 1 ms to 120 s";
  const auto* by_curve = std::get_if<CurveExposure>(&resin.exposure);
  if (by_curve == nullptr) return problem;
  const WorkingCurve& curve = resin.cure.value().curve;
  const Micrometers overcure = is_outside(normal) ? by_curve->overcure : by_curve->bottom_overcure;
  return problem +
         fmt::format(
             ": it follows from penetration_depth_um {:g}, critical_energy_mj_cm2 {:g}{} and {} {:g} "
             "of the resin, and {}: correct the one that is wrong{}",
             curve.penetration_depth.count(), curve.critical_dose.count(), at_this_light(resin),
             is_outside(normal) ? "overcure_um" : "bottom_overcure_um", overcure.count(),
             of == Irradiance::OfPrinter
                 ? fmt::format("irradiance_mw_cm2 {:g} of the projector", irradiance_mw_cm2)
                 : fmt::format("an irradiance of {:g} mW/cm², assumed because no printer is given",
                               irradiance_mw_cm2),
             (is_outside(normal) ? normal : bottom) > longest ? ", or print thinner layers" : "");
}

// Checks that the number at `lower` is at most the number at `upper`.
void check_order(JsonDocument& document, const std::string& lower, const std::string& upper) {
  const auto low = document.valid_number("/" + lower);
  const auto high = document.valid_number("/" + upper);
  if (low && high && *low > *high) {
    document.add_violation("/" + lower, decimal(*low) + " is more than " + upper + ", " + decimal(*high));
  }
}

std::string limits_place(std::string_view key) {
  return "/ticket_limits/" + std::string(key);
}

// Checks that the plate has room for a first and a second stage of the lift.
void check_travel(JsonDocument& document, const char* place, std::optional<double> lift_mm,
                  const ResinMachine& machine) {
  const double second_mm = document.valid_number("/second_lift_mm").value_or(0);
  if (!lift_mm || !machine.travel || *lift_mm + second_mm < to_millimeters(*machine.travel).count()) return;
  document.add_violation(
      place,
      decimal(*lift_mm) + (second_mm > 0 ? " and second_lift_mm, " + decimal(second_mm) + ", are" : " is") +
          " not less than the printer's travel, " + decimal(to_millimeters(*machine.travel).count()) + " mm");
}

// Checks that the plate comes down slowly no farther than it was lifted.
void check_slow_retract(JsonDocument& document) {
  const auto slow_mm = document.valid_number("/slow_retract_mm"), lift_mm = document.valid_number("/lift_mm"),
             second_mm = document.valid_number("/second_lift_mm");
  if (!slow_mm || !lift_mm || *slow_mm <= *lift_mm + second_mm.value_or(0)) return;
  document.add_violation("/slow_retract_mm", decimal(*slow_mm) + " is more than the whole lift, " +
                                                 decimal(*lift_mm + second_mm.value_or(0)) + " mm");
}

// Checks the speeds of the slow stages. The fast ones only save time: an axis moves no faster than it can.
void check_speeds(JsonDocument& document, const ResinMachine& machine) {
  const auto check = [&](const char* key) {
    const auto speed = document.valid_number(key);
    if (!speed || !machine.top_speed || *speed <= machine.top_speed->count()) return;
    document.add_violation(key, decimal(*speed) + " is more than the printer's top speed, " +
                                    decimal(machine.top_speed->count()) + " mm/s");
  };
  check("/lift_speed_mm_s");
  if (document.valid_number("/slow_retract_mm").value_or(0) > 0) check("/slow_retract_speed_mm_s");
}

void check_ticket_limits(JsonDocument& document, const ResinMachine& machine) {
  for (const std::string_view key : kTicketSettings) {
    const std::string place = limits_place(key);
    const auto least = document.valid_number(place + "/0"), most = document.valid_number(place + "/1");
    if (!least || !most) continue;
    if (*least > *most) {
      document.add_violation(place,
                             "the least, " + decimal(*least) + ", is more than the most, " + decimal(*most));
      continue;
    }
    const auto own = document.valid_number("/" + std::string(key));
    if (own && (*own < *least || *own > *most)) {
      document.add_violation(place, decimal(*least) + " to " + decimal(*most) +
                                        " exclude the profile's own " + std::string(key) + ", " +
                                        decimal(*own));
    }
  }
  check_travel(document, "/ticket_limits/lift_mm", document.valid_number("/ticket_limits/lift_mm/1"),
               machine);
}

// Checks that the resin's ingredients give a curve within the limits of a measured one.
void check_ingredients(JsonDocument& document) {
  const auto absorptivity = document.valid_number("/working_curve/absorptivity_l_mol_cm"),
             initiator = document.valid_number("/working_curve/initiator_mmol_l"),
             gel_dose = document.valid_number("/working_curve/gel_dose_mj_cm2");
  if (!absorptivity || !initiator || !gel_dose) return;
  const WorkingCurve curve =
      curve_of_ingredients(*absorptivity, *initiator / 1000, MillijoulesPerCm2{*gel_dose});
  const double depth = curve.penetration_depth.count(), dose = curve.critical_dose.count();
  if (depth >= 1 && depth <= 5000 && dose >= 0.01 && dose <= 1000) return;
  document.add_violation(
      "/working_curve/initiator_mmol_l",
      fmt::format("{:g} mmol/L give a penetration depth of {:.4g} um and a critical energy of "
                  "{:.4g} mJ/cm²; they must be 1 to 5000 um and 0.01 to 1000 mJ/cm²",
                  *initiator, depth, dose));
}

void check_reciprocity(JsonDocument& document) {
  const auto exponent = document.valid_number("/working_curve/reciprocity_exponent");
  if (!exponent || *exponent == 1 || document.valid_number("/working_curve/irradiance_mw_cm2")) return;
  document.add_violation("/working_curve/reciprocity_exponent",
                         decimal(*exponent) + " needs irradiance_mw_cm2, at which the curve was measured");
}

void check_rules(JsonDocument& document, const ResinMachine& machine) {
  check_ingredients(document);
  check_reciprocity(document);
  // Check the range first: with minimum and maximum swapped, every default would be a violation too.
  check_order(document, "layer_height_min_um", "layer_height_max_um");
  check_order(document, "layer_height_min_um", "layer_height_um");
  check_order(document, "layer_height_um", "layer_height_max_um");
  check_order(document, "exposure_ms", "bottom_exposure_ms");
  check_order(document, "working_curve/overcure_um", "working_curve/bottom_overcure_um");

  const auto bottom = document.valid_number("/bottom_layers");
  const auto fade = document.valid_number("/fade_layers");
  if (bottom && fade && *bottom == 0 && *fade > 0) {
    document.add_violation(
        "/fade_layers",
        decimal(*fade) + " layers to fade, but bottom_layers is 0: there is no bottom exposure to fade from");
  }
  const auto foot = document.valid_number("/elephant_foot_um");
  const auto foot_height = document.valid_number("/elephant_foot_height_um");
  if (foot && foot_height && (*foot > 0) != (*foot_height > 0)) {
    document.add_violation("/elephant_foot_um", decimal(*foot) + " um, but elephant_foot_height_um is " +
                                                    decimal(*foot_height) + ": both are 0 or neither is");
  }
  check_travel(document, "/lift_mm", document.valid_number("/lift_mm"), machine);
  check_slow_retract(document);
  check_speeds(document, machine);
  check_ticket_limits(document, machine);
  check_continuous(document);
}

// Checks the ticket limits against the working curve's exposures, which are known only after the profile has
// been read.
void check_limits_of_curve(JsonDocument& document, const ResinProfile& resin, double irradiance_mw_cm2) {
  if (!std::holds_alternative<CurveExposure>(resin.exposure)) return;
  const auto [normal, bottom] = exposures_s(resin, resin.layer_height, irradiance_mw_cm2);
  const auto check = [&document](const char* key, const std::optional<Limits<Duration>>& limits,
                                 double seconds) {
    if (!limits) return;
    const double own_ms = std::round(seconds * 1e6) / 1e3;
    const double least_ms = figure_of(limits->least), most_ms = figure_of(limits->most);
    if (own_ms >= least_ms && own_ms <= most_ms) return;
    document.add_violation(limits_place(key), decimal(least_ms) + " to " + decimal(most_ms) +
                                                  " exclude the exposure by the working curve, " +
                                                  decimal(own_ms));
  };
  check("exposure_ms", resin.limits.exposure, normal);
  check("bottom_exposure_ms", resin.limits.bottom_exposure, bottom);
}

std::variant<FixedExposure, CurveExposure> read_exposure(const JsonSection& profile) {
  if (!profile.has("working_curve")) {
    return FixedExposure{profile.duration("exposure_ms"), profile.duration("bottom_exposure_ms")};
  }
  const JsonSection curve = profile.section("working_curve");
  return CurveExposure{Micrometers{curve.number("overcure_um")},
                       Micrometers{curve.number("bottom_overcure_um")}};
}

WorkingCurve read_curve(const JsonSection& curve) {
  if (!curve.has("initiator_mmol_l"))
    return {Micrometers{curve.number("penetration_depth_um")},
            MillijoulesPerCm2{curve.number("critical_energy_mj_cm2")}};
  return curve_of_ingredients(curve.number("absorptivity_l_mol_cm"), curve.number("initiator_mmol_l") / 1000,
                              MillijoulesPerCm2{curve.number("gel_dose_mj_cm2")});
}

std::optional<CureIrradiance> read_cure_irradiance(const JsonSection& profile) {
  if (!profile.has("working_curve") || !profile.section("working_curve").has("irradiance_mw_cm2"))
    return std::nullopt;
  const JsonSection curve = profile.section("working_curve");
  return CureIrradiance{MilliwattsPerCm2{curve.number("irradiance_mw_cm2")},
                        curve.number("reciprocity_exponent")};
}

// Returns curve and memory at an irradiance, if it is known.
std::optional<CureSettings> read_cure(const JsonSection& profile, std::optional<double> irradiance_mw_cm2) {
  if (!profile.has("working_curve")) return std::nullopt;
  const JsonSection curve = profile.section("working_curve");
  CureSettings cure{.curve = read_curve(curve),
                    .oxygen_dose = MillijoulesPerCm2{curve.number("oxygen_dose_mj_cm2")},
                    .dead_zone = Micrometers{curve.number("dead_zone_um")}};
  if (curve.has("peel_memory")) cure.peel_memory = curve.number("peel_memory");
  const std::optional<CureIrradiance> measured = read_cure_irradiance(profile);
  if (!measured || !irradiance_mw_cm2) return cure;
  const MilliwattsPerCm2 irradiance{*irradiance_mw_cm2};
  cure.curve = at_irradiance(cure.curve, *measured, irradiance);
  cure.dead_zone = dead_zone_at(cure.dead_zone, measured->measured_at, irradiance);
  return cure;
}

std::optional<CureTemperature> read_cure_temperature(const JsonSection& profile) {
  if (!profile.has("working_curve") || !profile.section("working_curve").has("temperature_c"))
    return std::nullopt;
  const JsonSection curve = profile.section("working_curve");
  return CureTemperature{curve.number("temperature_c"), curve.number("activation_energy_kj_mol")};
}

// Returns the factors by which a model is enlarged so that it has its size after shrinking.
Scale read_shrinkage(const JsonSection& profile) {
  const JsonSection percent = profile.section("shrinkage_percent");
  const auto factor = [&](const char* axis) { return 1 / (1 - percent.number(axis) / 100); };
  return {factor("x"), factor("y"), factor("z")};
}

OrientationWeights read_orientation_weights(const JsonSection& profile) {
  const JsonSection weights = profile.section("orientation_weights");
  return {.support = weights.number("support"),
          .contacts = weights.number("contacts"),
          .peel = weights.number("peel"),
          .height = weights.number("height"),
          .standing = weights.number("standing"),
          .keep_clean = weights.number("keep_clean")};
}

struct MotionSetting {
  std::string_view key;
  std::variant<Nanometers LayerMotion::*, MillimetersPerSecond LayerMotion::*, Duration LayerMotion::*> field;
};

constexpr std::array kMotionSettings{
    MotionSetting{"lift_mm", &LayerMotion::lift},
    MotionSetting{"lift_speed_mm_s", &LayerMotion::lift_speed},
    MotionSetting{"second_lift_mm", &LayerMotion::second_lift},
    MotionSetting{"second_lift_speed_mm_s", &LayerMotion::second_lift_speed},
    MotionSetting{"retract_speed_mm_s", &LayerMotion::retract_speed},
    MotionSetting{"slow_retract_mm", &LayerMotion::slow_retract},
    MotionSetting{"slow_retract_speed_mm_s", &LayerMotion::slow_retract_speed},
    MotionSetting{"settle_ms", &LayerMotion::settle},
    MotionSetting{"rest_ms", &LayerMotion::rest}};

void read(const JsonSection& profile, std::string_view key, Nanometers& length) {
  length = profile.length(key);
}
void read(const JsonSection& profile, std::string_view key, MillimetersPerSecond& speed) {
  speed = MillimetersPerSecond{profile.number(key)};
}
void read(const JsonSection& profile, std::string_view key, Duration& time) {
  time = profile.duration(key);
}

LayerMotion read_motion(const JsonSection& profile) {
  LayerMotion motion;
  for (const auto& [key, field] : kMotionSettings)
    std::visit([&, key = key](auto member) { read(profile, key, motion.*member); }, field);
  return motion;
}

std::optional<Limits<Duration>> read_time_limits(const JsonSection& limits, std::string_view key) {
  if (!limits.has(key)) return std::nullopt;
  const std::vector<Duration> both = limits.durations(key);
  return Limits<Duration>{both.at(0), both.at(1)};
}

TicketLimits read_ticket_limits(const JsonSection& profile) {
  if (!profile.has("ticket_limits")) return {};
  const JsonSection limits = profile.section("ticket_limits");
  TicketLimits read{.exposure = read_time_limits(limits, "exposure_ms"),
                    .bottom_exposure = read_time_limits(limits, "bottom_exposure_ms"),
                    .lift = {},
                    .settle = read_time_limits(limits, "settle_ms"),
                    .rest = read_time_limits(limits, "rest_ms")};
  if (limits.has("lift_mm")) {
    const std::vector<Nanometers> both = limits.lengths("lift_mm");
    read.lift = {both.at(0), both.at(1)};
  }
  return read;
}

ResinProfile read_profile(const JsonSection& profile, std::string name,
                          std::optional<double> irradiance_mw_cm2) {
  return {
      .name = std::move(name),
      .layer_height = profile.length("layer_height_um"),
      .layer_height_min = profile.length("layer_height_min_um"),
      .layer_height_max = profile.length("layer_height_max_um"),
      .exposure = read_exposure(profile),
      .cure = read_cure(profile, irradiance_mw_cm2),
      .curve_measured =
          !profile.has("working_curve") || !profile.section("working_curve").has("initiator_mmol_l"),
      .cure_irradiance = read_cure_irradiance(profile),
      .cure_temperature = read_cure_temperature(profile),
      .peel_memory_measured =
          profile.has("working_curve") && profile.section("working_curve").has("peel_memory"),
      .undersides = undersides_of(profile.text("undersides")),
      .shrinkage_factors = read_shrinkage(profile),
      .bottom_layers = profile.integer<int>("bottom_layers"),
      .fade_layers = profile.integer<int>("fade_layers"),
      .compensation = {.growth = Micrometers{profile.number("growth_um")},
                       .elephant_foot = Micrometers{profile.number("elephant_foot_um")},
                       .elephant_foot_height = profile.length("elephant_foot_height_um")},
      .support = {static_cast<std::uint8_t>(profile.integer<int>("support_grey")),
                  profile.number("support_area_mm2")},
      .supports = read_support_settings(profile.section("supports")),
      .orientation = read_orientation_weights(profile),
      .motion = read_motion(profile),
      .viscosity_mpa_s = profile.find("viscosity_mpa_s", &JsonSection::number),
      .mode = print_way_of(profile.text("mode")),
      .continuous = read_continuous(profile),
      .tolerance = {.bounds = profile.duration("exposure_tolerance_ms"),
                    .policy = profile.text("exposure_doubt") == "interrupt"
                                  ? ExposureTolerance::Policy::Interrupt
                                  : ExposureTolerance::Policy::Warn},
      .limits = read_ticket_limits(profile),
  };
}

ResinProfile checked_profile(JsonDocument document, std::string name, const ResinMachine& machine) {
  resin_schema().check(document);
  check_rules(document, machine);
  document.throw_if_violated();
  ResinProfile resin = read_profile(JsonSection(document), std::move(name), machine.irradiance_mw_cm2);
  for (SupportContradiction& found : contradictions_of(resin.supports))
    document.add_violation("/supports/" + std::string(found.key), std::move(found.sentence));
  if (machine.irradiance_mw_cm2) {
    for (std::string& problem :
         layer_height_problems(resin, resin.layer_height, *machine.irradiance_mw_cm2)) {
      document.add_violation("/working_curve", std::move(problem));
    }
    document.throw_if_violated();
    check_limits_of_curve(document, resin, *machine.irradiance_mw_cm2);
  }
  document.throw_if_violated();
  return resin;
}

}  // namespace

ResinProfile load_resin_profile(const std::filesystem::path& path, const ResinMachine& machine) {
  return checked_profile(JsonDocument::from_file(path), path.stem().string(), machine);
}

ResinProfile read_resin_profile(std::string_view text, const std::filesystem::path& path,
                                const ResinMachine& machine) {
  return checked_profile(JsonDocument::from_text(text, path.string()), path.stem().string(), machine);
}

double figure_of(Nanometers length) {
  return to_millimeters(length).count();
}
double figure_of(MillimetersPerSecond speed) {
  return speed.count();
}
double figure_of(Duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

std::vector<std::pair<std::string_view, double>> motion_figures(const LayerMotion& motion) {
  std::vector<std::pair<std::string_view, double>> figures;
  for (const auto& [key, field] : kMotionSettings)
    figures.emplace_back(key, std::visit([&](auto member) { return figure_of(motion.*member); }, field));
  return figures;
}

Duration exposure_time(const ResinProfile& resin, Nanometers layer_height, int layer_index,
                       double irradiance_mw_cm2) {
  expects(layer_index >= 0 && layer_height > Nanometers{}, "the layer is one of a print");
  expects(irradiance_mw_cm2 > 0, "there is light");
  auto [normal, bottom] = exposures_s(resin, layer_height, irradiance_mw_cm2);
  if (const auto step = step_exposure(resin, layer_height * layer_index + layer_height / 2))
    normal = std::chrono::duration<double>(*step).count();
  double seconds = normal;
  if (layer_index < resin.bottom_layers) {
    seconds = bottom;
  } else if (layer_index - resin.bottom_layers < resin.fade_layers) {
    const int gone = layer_index - resin.bottom_layers + 1;
    seconds = bottom + (normal - bottom) * gone / (resin.fade_layers + 1);
  }
  constexpr double kHundredYearsS = 3.2e9;  // int64 nanoseconds overflow after 292 years
  if (!(seconds <= kHundredYearsS)) throw std::range_error("the exposure is longer than a hundred years");
  return Duration{std::llround(seconds * 1e9)};
}

std::string missing_for_dimming(const ResinProfile& resin) {
  if (!resin.cure) return "the profile of the resin " + resin.name + " has no working_curve";
  if (!resin.curve_measured)
    return "the working_curve of the resin " + resin.name +
           " is computed by its ingredients, and undersides need a measured one";
  if (resin.peel_memory_measured) return "";
  return "the working_curve of the resin " + resin.name +
         " has no peel_memory, and with a wrong one a part of the model would be missing";
}

std::string missing_for_continuous(const ResinProfile& resin) {
  std::string lacks;
  const auto need = [&](bool there, std::string_view key) {
    if (!there) lacks += (lacks.empty() ? "" : ", ") + std::string(key);
  };
  need(resin.cure.has_value(), "working_curve");
  need(resin.cure && resin.cure->dead_zone > Micrometers{}, "working_curve/dead_zone_um above 0");
  need(resin.viscosity_mpa_s.has_value(), "viscosity_mpa_s");
  need(resin.continuous.has_value(), "continuous");
  if (lacks.empty()) return "";
  return "the profile of the resin " + resin.name + " lacks what continuous printing needs: " + lacks +
         "; add it to the profile, or print in layers";
}

std::string settle_undersides(ResinProfile& resin) {
  if (resin.undersides == Undersides::Plain) return "";
  const std::string missing = missing_for_dimming(resin);
  if (missing.empty()) return "";
  resin.undersides = Undersides::Plain;
  return "undersides are exposed plainly, not by dose: " + printable(missing);
}

std::vector<LayerDose> layer_doses(const ResinProfile& resin, std::span<const Nanometers> thicknesses,
                                   double irradiance_mw_cm2) {
  std::vector<LayerDose> layers;
  Nanometers top{};
  for (int layer = 0; const Nanometers thickness : thicknesses) {
    top += thickness;
    const std::chrono::duration<double> light = exposure_time(resin, thickness, layer++, irradiance_mw_cm2);
    layers.push_back({top, thickness, MillijoulesPerCm2{light.count() * irradiance_mw_cm2}});
  }
  return layers;
}

std::vector<std::string> layer_height_problems(const ResinProfile& resin, Nanometers layer_height,
                                               double irradiance_mw_cm2, Irradiance of) {
  expects(layer_height > Nanometers{} && irradiance_mw_cm2 > 0,
          "the layer has a thickness, and there is light");
  const auto um = [](Nanometers height) {
    return decimal(static_cast<double>(height.count()) / 1e3) + " um";
  };
  std::vector<std::string> problems;
  if (layer_height < resin.layer_height_min || layer_height > resin.layer_height_max) {
    problems.push_back("the layer height of " + um(layer_height) + " is outside what resin " +
                       in_quotes(resin.name) + " allows, " + um(resin.layer_height_min) + " to " +
                       um(resin.layer_height_max));
  }
  if (std::optional<std::string> problem = exposure_problem(resin, layer_height, irradiance_mw_cm2, of))
    problems.push_back(*std::move(problem));
  const auto* by_curve = std::get_if<CurveExposure>(&resin.exposure);
  if (by_curve == nullptr) return problems;
  const double cured_um = in_mm(layer_height) * 1000 + by_curve->overcure.count();
  if (const double dead_um = resin.cure.value().dead_zone.count(); dead_um >= cured_um)
    problems.push_back(fmt::format(
        "the dead zone of {:.4g} um{} is as thick as the {:g} um that the light of a layer reaches, "
        "so that nothing would harden: correct dead_zone_um or irradiance_mw_cm2 of the resin",
        dead_um, resin.cure_irradiance ? " at this irradiance" : "", cured_um));
  return problems;
}

}  // namespace contourd
