#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/model/height_index.hpp"
#include "core/model/mesh_report.hpp"
#include "core/model/shell_report.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/placement/model_turn.hpp"
#include "daemon/prepare/mesh_repair_text.hpp"
#include "daemon/prepare/model_checks.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct InspectOptions {
  std::filesystem::path model;
  std::optional<std::string> unit;
  bool json = false;
};

using Json = nlohmann::ordered_json;

// The room in a large resin printer, in which a model is expected to fit.
constexpr SizeMm kUsualRoom{250, 250, 250};

// Converts the model to millimetres, and adds warnings about its unit and its precision.
void convert(Model& model, const ModelUnit& unit) {
  const LengthUnit read_in =
      unit.is_applied ? LengthUnit::Millimeter : unit.asked.value_or(LengthUnit::Millimeter);
  const double factor = millimeters_in(read_in);
  const std::string imprecise = precision_warning(bounds_of(model.facets), factor);
  enlarge(model.facets, Scale{factor});
  const Bounds bounds = bounds_of(model.facets);
  const std::string hint = unit_hint({bounds.size_x(), bounds.size_y(), bounds.size_z()}, unit, kUsualRoom);
  for (const std::string& warning : {unit_conflict(unit), imprecise, hint})
    if (!warning.empty()) model.warnings.push_back(warning);
}

Json to_json(const Model& model, std::string_view format, const MeshReport& report,
             const MeshRepairs& repairs) {
  const Bounds& b = report.bounds;
  Json json;
  json["format"] = format;
  json["facets"] = report.facets;
  json["bounds_mm"] = nullptr;
  if (!b.empty()) {
    json["bounds_mm"] = {{"min", {b.min_x, b.min_y, b.min_z}}, {"max", {b.max_x, b.max_y, b.max_z}}};
  }
  json["size_mm"] = {b.size_x(), b.size_y(), b.size_z()};
  json["volume_mm3"] = report.volume_mm3;
  json["watertight"] = report.watertight;
  json["open_edges"] = report.open_edges;
  json["non_manifold_edges"] = report.non_manifold_edges;
  json["flipped_edges"] = report.flipped_edges;
  json["degenerate_facets"] = report.degenerate_facets;
  json["zero_area_facets"] = report.zero_area_facets;
  json["duplicate_facets"] = report.duplicate_facets;
  json["repairs"] = repairs_json(repairs);
  json["warnings"] = model.warnings;
  return json;
}

void print(const Model& model, std::string_view format, const MeshReport& report) {
  const Bounds& b = report.bounds;
  fmt::print("format       {}\nfacets       {}\n", format, report.facets);
  if (!b.empty()) {
    fmt::print("size         {:.6g} x {:.6g} x {:.6g} mm\n", b.size_x(), b.size_y(), b.size_z());
    fmt::print("bounds       x {:.6g} to {:.6g}, y {:.6g} to {:.6g}, z {:.6g} to {:.6g} mm\n", b.min_x,
               b.max_x, b.min_y, b.max_y, b.min_z, b.max_z);
  }
  fmt::print("volume       {:.6g} mm³\n", report.volume_mm3);
  fmt::print("watertight   {}\n", report.watertight ? "yes" : "no");
  fmt::print("edges        {} open, {} of more than two facets, {} turned against each other\n",
             report.open_edges, report.non_manifold_edges, report.flipped_edges);
  fmt::print("bad facets   {} degenerate, {} without area, {} duplicate\n", report.degenerate_facets,
             report.zero_area_facets, report.duplicate_facets);
  for (const std::string& warning : model.warnings)
    fmt::print("warning      {}\n", printable(warning));
}

int inspect(const InspectOptions& options) {
  auto [model, format] = read_model(options.model);
  convert(model, {parse_unit(options.unit), model.unit, applies_unit(format)});
  MeshReport report = inspect_mesh(model.facets);
  Bounds& b = report.bounds;
  for (double* const coordinate : {&b.min_x, &b.min_y, &b.min_z, &b.max_x, &b.max_y, &b.max_z})
    *coordinate += 0.0;  // makes -0, which some programs write, 0
  const HeightIndex index(std::move(model.facets));
  std::ranges::move(mesh_warnings(report.inside_out, index.repairs()), std::back_inserter(model.warnings));
  const auto place_of = [](const Vertex& at) {
    return fmt::format("{:.4g}, {:.4g}, {:.4g} mm", at.x, at.y, at.z);
  };
  std::ranges::move(shell_warnings(inspect_shells(index.facets()), place_of),
                    std::back_inserter(model.warnings));
  if (options.json) {
    fmt::print(
        "{}\n",
        to_json(model, format, report, index.repairs()).dump(2, ' ', true, Json::error_handler_t::replace));
  } else {
    print(model, format, report);
  }
  return kOk;
}

}  // namespace

void add_inspect(Command& program) {
  Command& command = program.add("inspect", "Show the contents and defects of a model file");
  auto& options = command.arguments<InspectOptions>();
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--unit", options.unit, kUnitHelp).suggests(unit_names);
  command.option("--json", options.json, "Print JSON");
  command.run = [&options] { return inspect(options); };
}

}  // namespace contourd::ctl
