#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "core/model/model.hpp"
#include "daemon/ctl/models/cure_page.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/layer_measurements.hpp"
#include "daemon/ctl/models/model_commands.hpp"
#include "daemon/ctl/models/print_record_file.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/report/cured_part_text.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct CureOptions {
  PrintArgs print;
  bool json = false;
  std::optional<std::filesystem::path> stl;     // of the part's surface
  std::optional<std::filesystem::path> html;    // one self-contained page
  std::optional<std::filesystem::path> report;  // of a finished print, whose light is taken
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

// Takes undersides, layers and doses of a finished print.
PrintSubject subject_of(const CureOptions& options, const std::optional<RecordedPrint>& recorded) {
  if (!recorded) return print_subject(options.print);
  PrintArgs args = options.print;
  args.follows_temperature = false;
  if (!args.undersides) args.undersides = recorded->undersides == Undersides::Dose ? "dose" : "plain";
  return print_subject(args);
}

// Returns a sentence about masks that are not those of the print; empty if all are.
std::string other_masks(const PrintSubject& subject, const RecordedPrint& recorded, const PrintedLight& light,
                        std::span<const double> lit_pixels) {
  const double pixel_mm = to_millimeters(subject.settings.display.pixel_pitch).count();
  const double pixel_mm2 = pixel_mm * pixel_mm;
  std::size_t others = 0, worst = 0;
  double most = 0;
  for (std::size_t layer = 0; layer < light.layers.size(); ++layer) {
    const std::size_t number = light.sources[layer].record;
    if (recorded.layers[number].rises) continue;  // several masks lit it
    const double off = std::abs(lit_pixels[layer] * pixel_mm2 - recorded.layers[number].area_mm2);
    if (off <= pixel_mm2) continue;
    ++others;
    if (off <= most) continue;
    most = off;
    worst = number;
  }
  if (others == 0) return "";
  return fmt::format(
      "the masks of {} of {} layers are not those of the print, that of layer {} is off by {:.2f} mm²: give "
      "the "
      "model, the ticket and the configuration of the print",
      others, recorded.layers.size(), worst + 1, most);
}

void print_text(const PrintSubject& subject, const std::optional<RecordedPrint>& recorded,
                const CureResult& result) {
  const CureSettings cure = cure_of(*subject.resin);
  fmt::print("layers        {}\n", layers_text(subject.layers));
  if (recorded)
    fmt::print("print         {}, {}, {} with light\n", printable(recorded->job),
               printable(recorded->outcome), count_of(recorded->layers.size(), "layer", "layers"));
  fmt::print("resin         {}: Dp {:.4g} um, Ec {:.4g} mJ/cm², memory {:.3g}\n",
             printable(subject.resin->name), cure.curve.penetration_depth.count(),
             cure.curve.critical_dose.count(), cure.peel_memory);
  if (!subject.pixel_light.gaussians.empty())
    fmt::print("pixel light   {}\n", pixel_light_text(subject.pixel_light));
  std::vector<CureLine> lines = cured_part_lines(result.part);
  if (result.rise) lines.push_back(rise_light_line(*result.rise));
  for (const CureLine& line : lines)
    fmt::print("{:<13} {}\n", line.name, line.text);
  if (result.surface)
    fmt::print("surface       {} facets, from lines {} pixel{} apart\n", result.surface->facets,
               result.surface->step, result.surface->step == 1 ? "" : "s");
  for (const std::string& warning : result.warnings)
    fmt::print("warning       {}\n", printable(warning));
}

void print_json(const PrintSubject& subject, const std::optional<RecordedPrint>& recorded,
                const CureResult& result) {
  const CureSettings cure = cure_of(*subject.resin);
  Json json{{"layers", subject.layers.size()},
            {"resin",
             {{"name", subject.resin->name},
              {"penetration_depth_um", cure.curve.penetration_depth.count()},
              {"critical_energy_mj_cm2", cure.curve.critical_dose.count()},
              {"peel_memory", cure.peel_memory},
              {"peel_memory_measured", subject.resin->peel_memory_measured}}}};
  if (recorded)
    json["print"] = {{"job", recorded->job},
                     {"outcome", recorded->outcome},
                     {"layers_with_light", recorded->layers.size()}};
  json["pixel_light"] = pixel_light_json(subject.pixel_light);
  json.update(cured_part_json(result.part));
  if (result.rise) json["rise"] = rise_light_json(*result.rise);
  if (result.surface)
    json["surface"] = {{"facets", result.surface->facets}, {"step_pixels", result.surface->step}};
  json["warnings"] = result.warnings;
  fmt::print("{}\n", json.dump(2, ' ', true, Json::error_handler_t::replace));
}

// Throws ModelError if the print cannot have excluded these copies of the model.
void check_exclusions(const PrintSubject& subject, const RecordedPrint& recorded) {
  constexpr const char* kGive = "give the model, the ticket and the configuration of the print";
  const std::size_t copies = subject.copies.size();
  for (const Exclusion& each : recorded.exclusions) {
    if (each.number >= copies)
      throw ModelError(fmt::format("the print excluded copy {}, and there {} only {} of the model: {}",
                                   each.number + 1, copies == 1 ? "is" : "are", copies, kGive));
    if (static_cast<std::size_t>(each.layer) >= subject.layers.size())
      throw ModelError(fmt::format(
          "the print excluded copy {} from layer {} on, and the model has only {}: {}", each.number + 1,
          each.layer + 1, count_of(subject.layers.size(), "layer", "layers"), kGive));
  }
  if (!recorded.exclusions.empty() && recorded.exclusions.size() == copies)
    throw ModelError(fmt::format("the print excluded {}, but a print keeps one copy at least: {}",
                                 copies == 1 ? "the only copy of the model" : "all copies of the model",
                                 kGive));
}

CureResult compute(const PrintSubject& subject, const std::optional<RecordedPrint>& recorded,
                   const std::optional<std::filesystem::path>& stl) {
  const std::unique_ptr<UndersideDimming> undersides = subject.dimming();
  const std::unique_ptr<GivenLight> given = subject.given_light();
  PrintLight light{.layers = subject.doses,
                   .cure = cure_of(*subject.resin),
                   .pixel = subject.pixel_light,
                   .undersides = undersides.get(),
                   .given = given.get()};
  std::optional<PrintedLight> printed;
  std::vector<DarkCopy> dark;
  if (recorded) {
    light.cure.curve.critical_dose = light.cure.curve.critical_dose * recorded->temperature_factor;
    if (recorded->layers.size() > subject.layers.size())
      throw ModelError(
          fmt::format("the print has {} layers, and the model only {}: give the model, the ticket "
                      "and the configuration of the print",
                      recorded->layers.size(), subject.layers.size()));
    printed = light_of(*recorded, light.cure);
    light.layers = printed->layers;
    light.mask_heights = printed->mask_heights;
    check_exclusions(subject, *recorded);
    dark = dark_copies(recorded->exclusions, subject.copies, subject.supports, *printed);
    light.dark = dark;
  }
  PrintCure print(*subject.engine, subject.settings.display, light, subject.analysis.mask_budget);
  CureResult result{
      print.compare(subject.supports ? &*subject.supports : nullptr).value(), {}, {}, subject.warnings};
  if (recorded) {
    result.part.unfound_undersides = recorded->unfound_undersides;
    if (std::string other = other_masks(subject, *recorded, *printed, print.lit_pixels()); !other.empty())
      result.warnings.push_back(std::move(other));
    if (!recorded->frames.why_none.empty()) result.warnings.push_back(recorded->frames.why_none);
    if (result.part.weakest_bond > 0)
      result.part.weakest_bond_layer = layer_of(*printed, result.part.weakest_bond_layer);
    result.rise = printed->rise;
  }
  if (!recorded && subject.continuous)
    result.warnings.emplace_back(
        "the plate of this print rises without a stop in the light, and these are the figures of the same "
        "part "
        "in layers: after the print, --report gives those of the rise");
  std::ranges::move(cured_part_warnings(result.part, subject.resin->peel_memory_measured),
                    std::back_inserter(result.warnings));
  if (stl) result.surface = write_cured_surface(*stl, print);
  return result;
}

int cure(const CureOptions& options) {
  if (!options.print.printer && !options.print.resin)
    throw UsageError("cure needs --printer, or --resin with the resin's profile");
  refuse_to_overwrite_model(options.print.model, "--stl", options.stl);
  refuse_to_overwrite_model(options.print.model, "--html", options.html);
  if (options.stl && options.stl == options.html) throw UsageError("--stl and --html name the same file");
  std::optional<RecordedPrint> recorded;
  if (options.report) recorded = read_recorded_print(*options.report);
  const PrintSubject subject = subject_of(options, recorded);
  if (subject.engine->models().front().has_finished_layers())
    throw ModelError(
        fmt::format("{}: the file holds finished layers and no model to compare the cured part "
                    "with: give the "
                    "model that it was made from",
                    options.print.model.string()));
  const CureResult result = compute(subject, recorded, options.stl);
  if (options.html)
    write_text(*options.html, cure_page(options.print.model.filename().string(), subject, result));
  if (options.json) {
    print_json(subject, recorded, result);
  } else {
    print_text(subject, recorded, result);
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
  command.option("--report", options.report, "Take the light from a finished print's NAME.report.json");
  command.run = [&options] { return cure(options); };
}

}  // namespace contourd::ctl
