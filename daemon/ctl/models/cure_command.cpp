#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "core/model/model.hpp"
#include "daemon/ctl/models/cure_page.hpp"
#include "daemon/ctl/models/cured_surface_file.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/report/cured_part_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct CureOptions {
  PrintArgs print;
  bool json = false;
  std::optional<std::filesystem::path> stl;   // of the part's surface
  std::optional<std::filesystem::path> html;  // one self-contained page
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
  std::ranges::move(cured_part_warnings(part, subject.resin.value().peel_memory_measured),
                    std::back_inserter(warnings));
  return warnings;
}

struct CureResult {
  CuredPart part;
  std::optional<WrittenSurface> surface;  // nullopt: not wanted
};

void print_text(const PrintSubject& subject, const CureResult& result) {
  const CureSettings cure = cure_of(*subject.resin);
  fmt::print("layers        {}\n", layers_text(subject.layers));
  fmt::print("resin         {}: Dp {:.4g} um, Ec {:.4g} mJ/cm², memory {:.3g}\n",
             printable(subject.resin->name), cure.curve.penetration_depth.count(),
             cure.curve.critical_dose.count(), cure.peel_memory);
  for (const CureLine& line : cured_part_lines(result.part))
    fmt::print("{:<13} {}\n", line.name, line.text);
  if (result.surface)
    fmt::print("surface       {} facets, from lines {} pixel{} apart\n", result.surface->facets,
               result.surface->step, result.surface->step == 1 ? "" : "s");
  for (const std::string& warning : warnings_of(subject, result.part))
    fmt::print("warning       {}\n", printable(warning));
}

void print_json(const PrintSubject& subject, const CureResult& result) {
  const CureSettings cure = cure_of(*subject.resin);
  Json json{{"layers", subject.layers.size()},
            {"resin",
             {{"name", subject.resin->name},
              {"penetration_depth_um", cure.curve.penetration_depth.count()},
              {"critical_energy_mj_cm2", cure.curve.critical_dose.count()},
              {"peel_memory", cure.peel_memory},
              {"peel_memory_measured", subject.resin->peel_memory_measured}}}};
  json.update(cured_part_json(result.part));
  if (result.surface)
    json["surface"] = {{"facets", result.surface->facets}, {"step_pixels", result.surface->step}};
  json["warnings"] = warnings_of(subject, result.part);
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

int cure(const CureOptions& options) {
  if (!options.print.printer && !options.print.resin)
    throw UsageError("cure needs --printer, or --resin with the resin's profile");
  refuse_to_overwrite_model(options.print.model, "--stl", options.stl);
  refuse_to_overwrite_model(options.print.model, "--html", options.html);
  if (options.stl && options.stl == options.html) throw UsageError("--stl and --html name the same file");
  const PrintSubject subject = print_subject(options.print);
  const std::unique_ptr<UndersideDimming> undersides = subject.dimming();
  PrintCure print(*subject.engine, subject.settings.display,
                  {subject.doses, cure_of(*subject.resin), {}, undersides.get()},
                  subject.analysis.mask_budget);
  CureResult result{print.compare(subject.supports ? &*subject.supports : nullptr), {}};
  if (options.stl) result.surface = write_cured_surface(*options.stl, print);
  if (options.html)
    write_text(*options.html, cure_page(options.print.model.filename().string(), subject, result.part,
                                        warnings_of(subject, result.part)));
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
  command.option("--html", options.html, "Write a page with plots and pictures");
  command.run = [&options] { return cure(options); };
}

}  // namespace contourd::ctl
