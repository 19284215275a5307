// The fit of the lamp's light over the display, which becomes the uniformity mask.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "core/calibration/lamp_fit.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/fit_plot.hpp"
#include "daemon/ctl/calibration/fit_result.hpp"
#include "daemon/ctl/calibration/lamp_readings.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/profile_file.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMaskKey = "/display/uniformity_mask";
constexpr const char* kIrradianceKey = "/projector/irradiance_mw_cm2";

struct LampFitArgs {
  FitArgs fit;
  std::optional<std::string> grid;
  std::vector<std::string> readings;
  std::optional<fs::path> table;
  LampPhotoArgs photo;
  bool through_mask = false;
};

// Fits the light over one printer's display.
class LampCalibration {
 public:
  explicit LampCalibration(const LampFitArgs& args)
      : args_(args), printer_(load_printer_config(args.fit.printer, Places::Elsewhere)) {}

  int run() {
    const std::vector<LampReading> readings = raw(given_readings());
    const LampFit lamp = fit_lamp(readings);
    FitResult result{.kind = "lamp",
                     .given_heading = "x, y mm",
                     .unit = "",
                     .scatter = lamp.surface.fit.scatter,
                     .named = named_mask(lamp)};
    result.values.push_back({kMaskKey, key_of(result.named->file)});
    for (const auto& [place, light] : readings)
      result.points.push_back({{x_mm(place), y_mm(place)}, light, lamp.surface.at(place).value});
    describe(lamp, readings, result.notes);
    change_exposures(lamp, result);
    result.figure = map_of_lamp(lamp, readings, width().count() / height().count());
    return finish_fit(args_.fit, printer_target(args_.fit.printer), result);
  }

 private:
  [[nodiscard]] Millimeters width() const { return length_of(printer_.display_width); }
  [[nodiscard]] Millimeters height() const { return length_of(printer_.display_height); }
  [[nodiscard]] Millimeters length_of(Pixels side) const {
    return Millimeters{side.count() * printer_.pixel_pitch.count() / 1000};
  }
  [[nodiscard]] double x_mm(LampPlace place) const { return (place.x + 1) / 2 * width().count(); }
  [[nodiscard]] double y_mm(LampPlace place) const { return (place.y + 1) / 2 * height().count(); }
  [[nodiscard]] std::string text_of(const LampReading& light) const {
    return fmt::format("{:.4g} at {:.4g}, {:.4g} mm", light.light, x_mm(light.place), y_mm(light.place));
  }

  [[nodiscard]] std::vector<LampReading> given_readings() const {
    if (args_.table) return read_lamp_table(*args_.table, width(), height());
    const LampGrid grid = parse_lamp_grid(args_.grid.value_or(args_.photo.file ? "9x9" : "5x3"));
    if (args_.photo.file) return read_lamp_photo(args_.photo, grid);
    return parse_lamp_readings(args_.readings, grid, printer_.display_width, printer_.display_height);
  }

  // Returns the share of the light that the printer's present mask uses at a place.
  [[nodiscard]] double share_at(LampPlace place) const {
    if (!printer_.uniformity) return 1;
    const auto pixel = [](double at, Pixels side) {
      return std::min(static_cast<std::int32_t>((at + 1) / 2 * side.count()), side.count() - 1);
    };
    const auto row = printer_.uniformity->row(pixel(place.y, printer_.display_height));
    return row[static_cast<std::size_t>(pixel(place.x, printer_.display_width))] / 255.0;
  }

  // Returns the readings as they would be without the present mask.
  [[nodiscard]] std::vector<LampReading> raw(std::vector<LampReading> readings) const {
    if (!args_.through_mask) return readings;
    if (!printer_.uniformity)
      throw UsageError(fmt::format("--through-mask: {} has no display.uniformity_mask",
                                   printable(args_.fit.printer.string())));
    for (LampReading& reading : readings) {
      const double share = share_at(reading.place);
      if (share == 0)
        throw CalibrationRefused(fmt::format(
            "the present mask is black at {:.4g}, {:.4g} mm, so that no reading through it tells the "
            "lamp's light there: measure without the mask",
            x_mm(reading.place), y_mm(reading.place)));
      reading.light /= share;
    }
    return readings;
  }

  // Returns the mask's file: a new one, or an earlier one with the same content.
  [[nodiscard]] NamedFile named_mask(const LampFit& lamp) const {
    const std::vector<std::uint8_t> png =
        encode_png(draw_uniformity_mask(lamp, printer_.display_width, printer_.display_height));
    NamedFile named{{}, {png.begin(), png.end()}};
    const fs::path folder = fs::canonical(args_.fit.printer).parent_path();
    const std::string date = local_time(std::chrono::system_clock::now()).substr(0, 10);
    constexpr int kMost = 1000;
    for (int i = 1; i <= kMost; ++i) {
      named.file = folder / fmt::format("uniformity-{}{}.png", date, i > 1 ? fmt::format("-{}", i) : "");
      const fs::file_status status = fs::symlink_status(named.file);
      if (!fs::exists(status)) return named;
      std::error_code unreadable;
      if (fs::is_regular_file(status) && fs::file_size(named.file, unreadable) == named.content.size() &&
          read_text(named.file) == named.content)
        return named;
    }
    throw CalibrationRefused(fmt::format("{} and the next {} names exist: remove masks that are not used",
                                         named.file.string(), kMost));
  }
  // Returns the mask's name as the printer's file gives it. Names start from the folder through which the
  // printer's file was reached, which may be a link.
  [[nodiscard]] std::string key_of(const fs::path& mask) const {
    const bool is_linked = folder_of(args_.fit.printer).lexically_normal() != mask.parent_path();
    return is_linked ? mask.string() : mask.filename().string();
  }

  void describe(const LampFit& lamp, const std::vector<LampReading>& readings,
                std::vector<std::string>& notes) const {
    notes.push_back(fmt::format("the light differs by {:.3g} % over the display: {}, {}", lamp.spread_percent,
                                text_of(lamp.brightest), text_of(lamp.darkest)));
    double least = 0, most = 0, mean = 0;
    for (const auto& [place, light] : readings) {
      const double difference = 100 * (light / lamp.surface.at(place).value - 1);
      least = std::min(least, difference);
      most = std::max(most, difference);
      mean += light / static_cast<double>(readings.size());
    }
    notes.push_back(fmt::format(
        "with the mask it is expected to differ by less than {:.2g} % (two standard deviations), if the "
        "scatter of {:.2g} % about this surface of degree {} is the meter's; if it is the lamp's own, "
        "{:.2g} to {:+.2g} % stay uneven",
        lamp.spread_after_percent, 100 * lamp.surface.fit.scatter / mean, lamp.surface.degree, least, most));
    if (args_.through_mask)
      notes.emplace_back("the readings were taken through the present mask, whose effect was divided out");
    else if (printer_.uniformity)
      notes.emplace_back(
          "the readings are taken as without the present mask, as calibrate lamp shows its pictures");
  }

  // Adds the irradiance that white has with the mask, and notes about exposures. The present value is taken
  // as that of the display's middle, where it is measured and where windows are cured.
  void change_exposures(const LampFit& lamp, FitResult& result) const {
    const LampPlace middle{};
    const double factor = lamp.darkest.light / (lamp.surface.at(middle).value * share_at(middle));
    result.values.push_back({kIrradianceKey, rounded(printer_.irradiance_mw_cm2 * factor)});
    result.notes.push_back(fmt::format(
        "with the mask, a white pixel gives the light of the darkest place everywhere; in the middle, "
        "this is {:.3g} times the present light, so irradiance_mw_cm2 changes by this factor, and "
        "exposures by a working curve become {:.3g} times as long",
        factor, 1 / factor));
    const std::vector<std::string> fixed = fixed_exposures();
    if (!fixed.empty())
      result.notes.push_back(fmt::format(
          "multiply exposure_ms and bottom_exposure_ms by {:.3g} in the profiles with fixed exposures: {}",
          1 / factor, fmt::join(fixed, ", ")));
  }
  // Returns the names of the resins whose exposures do not follow the irradiance; of more than five, the
  // first and an ellipsis.
  [[nodiscard]] std::vector<std::string> fixed_exposures() const {
    constexpr std::size_t kMost = 5;
    std::vector<std::string> names;
    for (const std::string& name : profiles_in(printer_.resins_folder)) {
      try {
        if (!std::holds_alternative<FixedExposure>(find_resin(printer_, name).exposure)) continue;
      } catch (const ConfigError&) {
        continue;  // prints nothing as it is
      }
      names.push_back(names.size() < kMost ? printable(name) : "...");
      if (names.size() > kMost) break;
    }
    return names;
  }

  const LampFitArgs& args_;
  PrinterConfig printer_;
};

}  // namespace

void add_fit_lamp(Command& fit) {
  Command& command =
      fit.add("lamp", "Compute the uniformity mask from readings of the light, a table or a photo");
  auto& args = command.arguments<LampFitArgs>();
  const char* const group = "readings";
  const Option& readings = command
                               .option("READING", args.readings,
                                       "Readings of the fields, row by row; ? for one that was not measured")
                               .in_group(group);
  Option& table = command.option("--table", args.table, "File with lines of x,y,reading; x and y in mm");
  table.in_group(group).suggests({}, {".csv"});
  Option& photo = command.option("--photo", args.photo.file, "Photo of the white picture, a PNG file");
  photo.in_group(group).suggests({}, {".png"});
  const Option& corners = command
                              .option("--corners", args.photo.corners,
                                      "x,y of the picture's corners in the photo, by their dots, pixels: "
                                      "30,20,430,20,430,245,30,245")
                              .needs(photo);
  const Option& encoding =
      command.option("--encoding", args.photo.encoding, "Encoding of the photo: linear in the light, or sRGB")
          .one_of({"linear", "srgb"})
          .needs(photo);
  photo.needs(corners).needs(encoding);
  command.option("--grid", args.grid, "Columns and rows of fields (default: 5x3; of a photo, 9x9)")
      .excludes(table);
  command
      .option("--through-mask", args.through_mask,
              "Treat the readings as taken through the present uniformity mask")
      .needs(readings);
  add_fit_options(command, args.fit);
  command.run = [&args] { return LampCalibration(args).run(); };
}

}  // namespace contourd::ctl
