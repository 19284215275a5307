#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "core/orientation/orientation_figures.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/ctl/models/layer_folder.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/orient_page.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/slice_files.hpp"
#include "daemon/ctl/models/turned_facets.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

struct OrientOptions {
  std::filesystem::path model;
  std::optional<double> scale;
  OrientationPreset preset = OrientationPreset::Auto;
  // Configuration of contourd, for build volume and resin.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> resin;     // profile instead of the printer's resin
  std::optional<std::filesystem::path> html;      // one self-contained page
  std::optional<std::filesystem::path> pictures;  // a folder of PNGs
  bool force = false;                             // replace the pictures of an earlier call
  bool json = false;
};

struct OrientArgs {
  OrientOptions options;
  std::string preset = "auto";
};

OrientOptions parse_orient(const OrientArgs& args) {
  OrientOptions options = args.options;
  options.preset = orientation_preset(args.preset).value_or(OrientationPreset::Auto);
  check_scale(options.scale);
  if (options.force && !options.pictures) throw UsageError("--force needs --pictures");
  refuse_to_overwrite_model(options.model, "--html", options.html);
  return options;
}

using Json = nlohmann::ordered_json;

OrientationLimits limits_of(const OrientOptions& options) {
  OrientationLimits limits = kAnyPrinter;
  const auto take = [&limits](const ResinProfile& resin) {
    limits.weights = resin.orientation;
    limits.shrinkage = resin.shrinkage_factors;
  };
  if (options.printer) {
    const PrinterConfig printer = load_printer_config(*options.printer, Places::Elsewhere);
    const ResinProfile resin = find_resin(printer, printer.resin);
    const DisplayGeometry display{printer.display_width, printer.display_height, printer.pixel_pitch};
    limits.build = {Millimeters{display.width_mm()}, Millimeters{display.height_mm()},
                    to_millimeters(printer.travel - resin.motion.lift)};
    take(resin);
  }
  if (options.resin) take(load_resin_profile(*options.resin, {}));
  return limits;
}

std::string contacts_text(const OrientationFigures& figures) {
  return fmt::format("{:.0f}", std::ceil(figures.contacts));
}

void print_table(const ModelOrientation& orientation) {
  fmt::print("{}\n\n", describe(orientation));
  fmt::print("{:<24}{:>7}{:>10}{:>13}{:>12}{:>14}\n", "up", "score", "contacts", "supports ml", "height mm",
             "largest mm2");
  for (const OrientationFigures& each : reported(orientation.choice)) {
    std::string notes;
    if (each.up == Direction{0, 0, 1}) notes += "  as drawn";
    if (each.stands) notes += "  stands";
    if (!each.fits) notes += "  does not fit";
    fmt::print("{:<24}{:>7.2f}{:>10}{:>13.3f}{:>12.2f}{:>14.1f}{}\n", text_of(each.up), each.score,
               contacts_text(each), each.support_mm3 / 1000, each.size_z_mm, each.largest_mm2, notes);
  }
  const Direction& up = orientation.choice.chosen().up;
  fmt::print("\nticket  {}\n", Json{{"up", {{"x", up.x}, {"y", up.y}, {"z", up.z}}}}.dump());
}

std::vector<Mask> pictures_of(const std::vector<Facet>& facets, const ModelOrientation& orientation) {
  std::vector<Mask> pictures;
  for (const OrientationFigures& each : reported(orientation.choice))
    pictures.push_back(picture_of(facets, each.up));
  return pictures;
}

void write_pictures(const std::filesystem::path& folder, std::span<const Mask> pictures) {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    try {
      write_png(folder / layer_file(i + 1, ".png"), pictures[i]);
    } catch (const std::system_error& error) {
      throw OutputError(error.what());
    }
  }
}

int orient(const OrientOptions& options) {
  const OrientationLimits limits = limits_of(options);
  const std::vector<Facet> facets = read_model(options.model).facets;
  if (facets.empty()) throw ModelError(options.model.string() + ": the file holds no facets");
  if (options.pictures)
    open_layer_folder(*options.pictures, ".png", options.force ? Earlier::Replace : Earlier::Refuse);
  ModelTicket ticket;
  ticket.orientation = OrientationTicket{options.preset, {}};
  if (options.scale) ticket.scale = Scale{*options.scale};
  const ModelOrientation orientation = find_orientation(facets, ticket, limits).value();
  if (options.html || options.pictures) {
    const std::vector<Mask> pictures = pictures_of(facets, orientation);
    if (options.pictures) write_pictures(*options.pictures, pictures);
    if (options.html)
      write_text(*options.html, orientation_page(options.model.filename().string(), orientation, pictures));
  }
  if (options.json) {
    fmt::print("{}\n", orientation_json(orientation).dump(2));
  } else {
    print_table(orientation);
  }
  return kOk;
}

}  // namespace

void add_orient(Command& program) {
  Command& command = program.add("orient", "Find the orientation in which a model prints best");
  auto& args = command.arguments<OrientArgs>();
  OrientOptions& options = args.options;
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--preset", args.preset, "Weights: auto (from the resin's profile), fast, clean or safe")
      .one_of({"auto", "fast", "clean", "safe"});
  command.option("--scale", options.scale, kScaleHelp);
  command.option("--printer", options.printer, kLikePrinterHelp);
  command.option("--profile", options.resin, "Resin profile, instead of the printer's resin");
  command.option("--html", options.html, "Write a page with pictures");
  command.option("--pictures", options.pictures, "Write one PNG picture per orientation to this folder");
  command.option("--force", options.force, "Replace the pictures of an earlier run");
  command.option("--json", options.json, "Print JSON");
  command.run = [&args] { return orient(parse_orient(args)); };
}

}  // namespace contourd::ctl
