#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "core/model/model.hpp"
#include "daemon/ctl/models/cured_surface_file.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct CureOptions {
  PrintArgs print;
  bool json = false;
  std::optional<std::filesystem::path> stl;  // of the part's surface
};

using Json = nlohmann::ordered_json;

CureSettings cure_of(const ResinProfile& resin) {
  if (resin.cure) return *resin.cure;
  throw ModelError(fmt::format(
      "the resin {} has no working_curve, so the part that its light cures is not known; measure the "
      "penetration depth and the critical energy, or take them from the resin's data sheet, and add them to "
      "its profile",
      printable(resin.name)));
}

std::vector<std::string> warnings_of(const PrintSubject& subject, const CuredPart& part) {
  std::vector<std::string> warnings = subject.warnings;
  if (!subject.resin->peel_memory_measured)
    warnings.push_back(
        "the resin's peel_memory was not measured: all light is taken to be remembered, so undersides are "
        "the lowest that they can be");
  if (part.weakest_bond > 0 && part.weakest_bond < 1)
    warnings.push_back(fmt::format(
        "layer {} does not cure down to the layer beneath, which gets {:.2f} of the dose at which resin gels",
        part.weakest_bond_layer + 1, part.weakest_bond));
  if (part.abandoned_layers > 0)
    warnings.push_back(
        fmt::format("{} masks exceeded their time budget and count as dark", part.abandoned_layers));
  if (part.unfound_undersides > 0)
    warnings.push_back(
        fmt::format("undersides of {} layers kept all their light, because they were not found within the "
                    "time budget of a mask",
                    part.unfound_undersides));
  return warnings;
}

std::string place_text(const CurePlace& place) {
  return fmt::format("at {:.2f}, {:.2f} mm, {:.2f} mm above the plate", place.plate_mm.x, place.plate_mm.y,
                     place.height_mm);
}

void print_distances(const char* name, const SurfaceDistances& distances) {
  if (distances.places + distances.missing == 0) {
    fmt::print("{:<13} none\n", name);
    return;
  }
  fmt::print("{:<13} ", name);
  if (distances.places > 0)
    fmt::print("median {:+.0f} um, 95 % within {:.0f} um, worst {:+.0f} um {}", distances.median_um,
               distances.p95_um, distances.worst_um, place_text(distances.worst));
  if (distances.missing > 0)
    fmt::print("{}{:.2f} % missing", distances.places > 0 ? ", " : "",
               100.0 * static_cast<double>(distances.missing) /
                   static_cast<double>(distances.missing + distances.places));
  fmt::print("\n");
}

struct CureResult {
  CuredPart part;
  std::optional<WrittenSurface> surface;  // nullopt: not wanted
};

void print_text(const PrintSubject& subject, const CureResult& result) {
  const CuredPart& part = result.part;
  const CureFigures& found = part.figures;
  const CureSettings cure = cure_of(*subject.resin);
  fmt::print("layers        {}\n", layers_text(subject.layers));
  fmt::print("resin         {}: Dp {:.4g} um, Ec {:.4g} mJ/cm², memory {:.3g}\n",
             printable(subject.resin->name), cure.curve.penetration_depth.count(),
             cure.curve.critical_dose.count(), cure.peel_memory);
  print_distances("undersides", found.undersides);
  print_distances("tops", found.tops);
  print_distances("walls", found.walls);
  fmt::print("volume        {:.2f} mm³; {:.2f} mm³ too much, {:.2f} mm³ missing\n", found.model_mm3,
             found.too_much_mm3, found.too_little_mm3);
  if (found.closed_mm2 > 0)
    fmt::print("closed gaps   {:.2f} mm², the tallest {:.3f} mm {}\n", found.closed_mm2,
               found.tallest_closed_mm, place_text(found.closed));
  if (part.weakest_bond > 0)
    fmt::print("weakest bond  {:.2f} of the dose at which resin gels, layer {}\n", part.weakest_bond,
               part.weakest_bond_layer + 1);
  if (result.surface)
    fmt::print("surface       {} facets, from lines {} pixel{} apart\n", result.surface->facets,
               result.surface->step, result.surface->step == 1 ? "" : "s");
  for (const std::string& warning : warnings_of(subject, part))
    fmt::print("warning       {}\n", printable(warning));
}

Json place_json(const CurePlace& place) {
  return {place.plate_mm.x, place.plate_mm.y, place.height_mm};
}

Json distances_json(const SurfaceDistances& distances) {
  Json json{{"places", distances.places}, {"missing", distances.missing}};
  if (distances.places == 0) return json;
  json["median_um"] = distances.median_um;
  json["p95_um"] = distances.p95_um;
  json["worst_um"] = distances.worst_um;
  json["worst_mm"] = place_json(distances.worst);
  return json;
}

void print_json(const PrintSubject& subject, const CureResult& result) {
  const CuredPart& part = result.part;
  const CureFigures& found = part.figures;
  const CureSettings cure = cure_of(*subject.resin);
  Json json{{"layers", subject.layers.size()},
            {"resin",
             {{"name", subject.resin->name},
              {"penetration_depth_um", cure.curve.penetration_depth.count()},
              {"critical_energy_mj_cm2", cure.curve.critical_dose.count()},
              {"peel_memory", cure.peel_memory},
              {"peel_memory_measured", subject.resin->peel_memory_measured}}},
            {"undersides", distances_json(found.undersides)},
            {"tops", distances_json(found.tops)},
            {"walls", distances_json(found.walls)},
            {"model_mm3", found.model_mm3},
            {"too_much_mm3", found.too_much_mm3},
            {"missing_mm3", found.too_little_mm3},
            {"closed_gaps_mm2", found.closed_mm2},
            {"tallest_closed_gap_mm", found.tallest_closed_mm}};
  if (found.closed_mm2 > 0) json["tallest_closed_gap_at_mm"] = place_json(found.closed);
  json["weakest_bond"] = part.weakest_bond;
  json["weakest_bond_layer"] = part.weakest_bond > 0 ? Json(part.weakest_bond_layer + 1) : Json();
  if (result.surface)
    json["surface"] = {{"facets", result.surface->facets}, {"step_pixels", result.surface->step}};
  json["warnings"] = warnings_of(subject, part);
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

int cure(const CureOptions& options) {
  if (!options.print.printer && !options.print.resin)
    throw UsageError("cure needs --printer, or --resin with the resin's profile");
  refuse_to_overwrite_model(options.print.model, "--stl", options.stl);
  const PrintSubject subject = print_subject(options.print);
  const std::unique_ptr<UndersideDimming> undersides = subject.dimming();
  PrintCure print(*subject.engine, subject.settings.display,
                  {subject.doses, cure_of(*subject.resin), {}, undersides.get()},
                  subject.analysis.mask_budget);
  CureResult result{print.compare(subject.supports ? &*subject.supports : nullptr), {}};
  if (options.stl) result.surface = write_cured_surface(*options.stl, print);
  if (options.json) {
    print_json(subject, result);
  } else {
    print_text(subject, result);
  }
  return kOk;
}

}  // namespace

void add_cure(Command& program) {
  Command& command =
      program.add("cure", "Compute the part that the light cures, and its distance from the model");
  auto& options = command.arguments<CureOptions>();
  add_print_options(command, options.print, "Layer height, um (default: the resin's)");
  command.option("--json", options.json, "Print JSON");
  command.option("--stl", options.stl, "Write the part's surface to this STL file");
  command.run = [&options] { return cure(options); };
}

}  // namespace contourd::ctl
