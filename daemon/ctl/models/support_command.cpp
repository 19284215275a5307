#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/support/support_mesh.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/stl_file.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/job_supports.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/first_items.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

struct SupportOptions {
  std::filesystem::path model;
  bool json = false;
  SizeArgs size;
  std::optional<std::string> up;  // direction that points up; nullopt: as drawn
  DisplayArgs display;            // the model is in its middle
  double layer_height_um = 50;
  std::string supports = "auto";
  // Binary STL file to write: x and y as in the model's file, z above the plate.
  std::optional<std::filesystem::path> stl;
  bool with_model = false;  // write the model to this file, too
};

using Json = nlohmann::ordered_json;

// Limits of the lines about contacts, and of the lines about places that are not supported.
constexpr std::size_t kMostLines = 40;

void move(Facet& facet, double x, double y, double z) {
  for (Vertex& vertex : facet.vertices) {
    vertex.x = static_cast<float>(vertex.x + x);
    vertex.y = static_cast<float>(vertex.y + y);
    vertex.z = static_cast<float>(vertex.z + z);
  }
}

std::vector<Facet> facets_of(const SupportedModel& supported, bool with_model) {
  const Bounds& bounds = supported.model.model->bounds();
  std::vector<Facet> facets;
  if (supported.supports->structure) facets = support_mesh(supported.supports->structure->primitives());
  const Point middle = bounds.center();
  for (Facet& facet : facets)
    move(facet, middle.x, middle.y, 0);
  if (!with_model) return facets;
  const double lift = supported.model.elevation.lift(bounds).count();
  for (Facet facet : supported.model.model->facets()) {
    move(facet, 0, 0, lift);
    facets.push_back(facet);
  }
  return facets;
}

void print_text(const SupportedModel& supported) {
  const Supports& supports = *supported.supports;
  const SupportCounts counts = counts_of(supports);
  fmt::print("supports   {}\n", supports_line(counts));
  fmt::print("lift       {:.6g} mm\n", to_millimeters(supported.model.elevation.above_plate()).count());
  for (const SupportContact& contact : first_items(supports.contacts, kMostLines)) {
    fmt::print("{:<10} at {} mm, {} mm above the plate, holds {:.3g} mm²\n", name_of(contact.cause),
               coordinates({contact.place.x, contact.place.y}), coordinates({contact.place.z}),
               contact.load_mm2);
  }
  if (supports.contacts.size() > kMostLines)
    fmt::print("and {} more contacts; --json has all\n", supports.contacts.size() - kMostLines);
  for (const UnheldPlace& place : first_items(supports.unheld, kMostLines))
    fmt::print("not held   {}\n", unheld_text(place));
  if (supports.unheld.size() > kMostLines)
    fmt::print("and {} more places that are not held\n", supports.unheld.size() - kMostLines);
}

int support(const SupportOptions& options) {
  const std::optional<UpOption> up = parse_up(options.up);
  const SupportingOptions supporting{.display = parse_display(options.display),
                                     .layer = parse_um("--layer-height-um", options.layer_height_um, 1),
                                     .policy = support_policy(options.supports)};
  (void)parse_size(options.size);
  refuse_to_overwrite_model(options.model, "--stl", options.stl);
  if (options.with_model && !options.stl) throw UsageError("--with-model needs --stl");
  Model model = read_turned_model(options.model, up, options.size);
  print_warnings(model.warnings);
  const SupportedModel supported =
      support_model(std::make_shared<const HeightIndex>(std::move(model.facets)), supporting);
  if (supported.own_supports == OwnSupports::Overruled)
    fmt::print(stderr, "contourctl: warning: {}\n",
               own_supports_sentence("the model", supported.own_supports, "contourctl"));
  print_warnings(staying_sentences(*supported.supports));
  if (!supported.tilt.empty()) fmt::print(stderr, "contourctl: warning: {}\n", supported.tilt);
  if (options.stl) write_text(*options.stl, binary_stl(facets_of(supported, options.with_model), "supports"));
  if (options.json) {
    Json json = supports_json(*supported.supports);
    json["carries_supports"] = supported.own_supports != OwnSupports::None;
    json["lift_mm"] = to_millimeters(supported.model.elevation.above_plate()).count();
    fmt::print("{}\n", json.dump(2));
  } else {
    print_text(supported);
  }
  return kOk;
}

}  // namespace

void add_support(Command& program) {
  Command& command = program.add("support", "Generate supports and report what they hold");
  auto& options = command.arguments<SupportOptions>();
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--stl", options.stl, "Write the supports to this STL file");
  command.option("--with-model", options.with_model, "Also write the lifted model to the STL file");
  command.option("--supports", options.supports, "Generate supports: auto, or on if the file has its own")
      .one_of({"auto", "on"});
  add_size_options(command, options.size);
  command.option("--up", options.up, kUpHelp).suggests(up_presets);
  command.option("--layer-height-um", options.layer_height_um,
                 "Layer height, um; the model is lifted by whole layers");
  command.option("--display", options.display.display, "Build area in pixels, WIDTHxHEIGHT");
  command.option("--pixel-pitch-um", options.display.pixel_pitch_um, "Side of a pixel on the plate, um");
  command.option("--json", options.json, "Print JSON");
  command.run = [&options] { return support(options); };
}

}  // namespace contourd::ctl
