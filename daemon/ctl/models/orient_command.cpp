#include "daemon/ctl/models/model_commands.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image/preview.hpp"
#include "core/orientation/orientation_figures.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/supported_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "daemon/report/html_page.hpp"
#include "daemon/system/base64.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

struct OrientOptions {
  std::filesystem::path model;
  SizeArgs size;
  std::string preset = "auto";
  // Configuration of contourd, for build volume and resin.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> resin;     // profile instead of the printer's resin
  std::optional<std::filesystem::path> html;      // one self-contained page
  std::optional<std::filesystem::path> pictures;  // a folder of PNGs
  bool force = false;                             // replace the pictures of an earlier call
  bool json = false;
};

using Json = nlohmann::ordered_json;

OrientationLimits limits_of(const OrientOptions& options) {
  OrientationLimits limits = kAnyPrinter;
  const auto take = [&limits](const ResinProfile& resin) {
    limits.weights = resin.orientation;
    limits.shrinkage = resin.shrinkage_factors;
    limits.supports = resin.supports;
  };
  if (options.printer) {
    const PrinterConfig printer = load_printer_config(*options.printer, Places::Elsewhere);
    const ResinProfile resin = find_resin(printer, printer.resin);
    const DisplayGeometry display{printer.display_width, printer.display_height, printer.pixel_pitch};
    limits.build = {Millimeters{display.width_mm()}, Millimeters{display.height_mm()},
                    to_millimeters(printer.travel - resin.motion.whole_lift())};
    take(resin);
  }
  if (options.resin) take(load_resin_profile(*options.resin, {}));
  return limits;
}

void print_table(const ModelOrientation& orientation) {
  fmt::print("{}\n\n", describe(orientation));
  fmt::print("{:<24}{:>7}{:>10}{:>13}{:>12}{:>14}\n", "up", "score", "contacts", "supports ml", "height mm",
             "largest mm²");
  for (const OrientationFigures& each : reported(orientation.choice)) {
    std::string notes;
    if (each.up == Direction{0, 0, 1})
      notes += orientation.choice.own_supports ? "  as drawn, on its own supports" : "  as drawn";
    if (each.stands) notes += "  stands";
    if (!each.fits) notes += "  does not fit";
    fmt::print("{:<24}{:>7.2f}{:>10.0f}{:>13.3f}{:>12.2f}{:>14.1f}{}\n", text_of(each.up), each.score,
               std::ceil(each.contacts), each.support_mm3 / 1000, each.size_z_mm, each.largest_mm2, notes);
  }
  const Direction& up = orientation.choice.chosen().up;
  fmt::print("\nticket  {}\n", Json{{"up", {{"x", up.x}, {"y", up.y}, {"z", up.z}}}}.dump());
}

// --- pictures

constexpr Pixels kSide{360};

constexpr std::string_view kStyle = R"(
.ways { display: grid; grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)); gap: 1.5rem; margin-top: 1rem; }
figure { margin: 0; } figure img { width: 100%; border-radius: 6px; background: #000; }
figure.chosen img { outline: 3px solid var(--accent); }
)";

std::string figure(const OrientationFigures& figures, const Mask& picture, bool chosen) {
  const std::string up = text_of(figures.up);
  const bool drawn = figures.up == Direction{0, 0, 1};
  return fmt::format(
      "<figure{0}><img alt=\"The model with {1} up\" width=\"{2}\" height=\"{2}\" "
      "src=\"data:image/png;base64,{3}\">\n<figcaption><b>{1}</b>{4}<br>{5}; score "
      "{6:.2f}</figcaption></figure>\n",
      chosen ? " class=\"chosen\"" : "", up, kSide.count(), base64(encode_png(picture)),
      drawn ? ", as drawn" : "", describe(figures), figures.score);
}

// Draws the model as `contourctl preview` does, in each of the best orientations.
std::vector<Mask> pictures_of(const std::vector<Facet>& facets, const ModelOrientation& orientation) {
  constexpr Millimeters kAll{std::numeric_limits<double>::infinity()};
  std::vector<Mask> pictures;
  for (const OrientationFigures& each : reported(orientation.choice)) {
    std::vector<Facet> turned = facets;
    contourd::orient(turned, {.up = each.up});
    pictures.push_back(render_preview(turned, kAll, kSide, kSide));
  }
  return pictures;
}

// Returns the page: the best orientations, each with its picture and figures. One self-contained file.
std::string orientation_page(const std::string& name, const ModelOrientation& orientation,
                             std::span<const Mask> pictures) {
  std::string html =
      page_start(fmt::format("{}: orientations", escaped(name)), kStyle) +
      fmt::format("<h1>{}</h1>\n<p>{}</p>\n<div class=\"ways\">\n", escaped(name), describe(orientation));
  const auto told = reported(orientation.choice);
  for (std::size_t i = 0; i < told.size(); ++i)
    html += figure(told[i], pictures[i], i == 0);
  return html + "</div>\n</html>\n";
}

int orient(const OrientOptions& options) {
  (void)parse_size(options.size);
  if (options.force && !options.pictures) throw UsageError("--force needs --pictures");
  refuse_to_overwrite_model(options.model, "--html", options.html);
  const OrientationLimits limits = limits_of(options);
  ModelOfFile read = read_model(options.model);
  const std::optional<double> scale = size_of(read, options.size);
  const Model& model = read.model;
  print_warnings(model.warnings);
  const std::vector<Facet>& facets = model.facets;
  if (facets.empty()) throw ModelError(options.model.string() + ": the file holds no facets");
  if (options.pictures)
    open_layer_folder(*options.pictures, ".png", options.force ? Earlier::Replace : Earlier::Refuse);
  ModelTicket ticket;
  ticket.orientation = OrientationTicket{orientation_preset(options.preset).value(), {}};
  if (scale) ticket.scale = Scale{*scale};
  const ModelOrientation orientation = find_orientation(facets, ticket, limits).value();
  if (options.html || options.pictures) {
    const std::vector<Mask> pictures = pictures_of(facets, orientation);
    if (options.pictures) {
      for (std::size_t i = 0; i < pictures.size(); ++i)
        write_mask(*options.pictures / layer_file(i + 1, ".png"), pictures[i]);
    }
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
  auto& options = command.arguments<OrientOptions>();
  command.option("MODEL", options.model, "Model file").required().allow_empty();
  command.option("--preset", options.preset, "Weights: auto (from the resin's profile), fast, clean or safe")
      .one_of(up_presets());
  add_size_options(command, options.size);
  command.option("--printer", options.printer, kLikePrinterHelp);
  command.option("--profile", options.resin, "Resin profile, instead of the printer's resin");
  command.option("--html", options.html, "Write a page with pictures");
  command.option("--pictures", options.pictures, "Write one PNG picture per orientation to this folder");
  command.option("--force", options.force, "Replace the pictures of an earlier run");
  command.option("--json", options.json, "Print JSON");
  command.run = [&options] { return orient(options); };
}

}  // namespace contourd::ctl
