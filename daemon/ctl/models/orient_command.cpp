#include "daemon/ctl/models/orient_command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/ctl/models/layer_folder.hpp"
#include "daemon/ctl/models/orient_page.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/models/slice_files.hpp"
#include "daemon/ctl/models/turned_facets.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

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
                    to_millimeters(printer.travel - resin.lift)};
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

}  // namespace

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

}  // namespace contourd::ctl
