#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/client/control_defaults.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/models/layer_files.hpp"
#include "daemon/ctl/models/slicer_settings.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/profile_file.hpp"

namespace contourd::ctl {
namespace {

struct ExportArguments {
  std::filesystem::path file = kDefaultConfig;
  std::optional<std::filesystem::path> output;  // nullopt: standard output
  std::optional<std::string> host;
};

// Limits of PrusaSlicer's setting faded_layers.
constexpr int kFewestFaded = 3, kMostFaded = 20;

// Returns the name of a profile, with characters only that PrusaSlicer takes in names of profiles.
std::string profile_name(std::string_view name) {
  std::string safe(name);
  constexpr std::string_view kUnsafe = "[]<>:/\\|?*\"@;=#";
  std::ranges::replace_if(
      safe,
      [&](char c) {
        return static_cast<unsigned char>(c) < ' ' || kUnsafe.find(c) != std::string_view::npos;
      },
      '_');
  return safe;
}

// A profile of the bundle.
std::string section(std::string_view kind, std::string_view name, SlicerSettings settings) {
  std::ranges::sort(settings);
  return fmt::format("[{}:{}]\n{}\n", kind, name, ini_text(settings));
}

// Returns a list with one name, as PrusaSlicer writes lists of names.
std::string list_of_one(std::string_view name) {
  return fmt::format("\"{}\"", name);
}

// The profiles of a printer and its resins.
class SlicerBundle {
 public:
  explicit SlicerBundle(const PrinterConfig& printer)
      : printer_(printer), name_(profile_name(printer.name)) {}

  // Adds a resin: a material and a print profile, since PrusaSlicer keeps the layer height in the latter.
  void add(const ResinProfile& resin) {
    const SlicerLayers layers = layers_of(resin);
    const std::string material = material_name(resin.name);
    const std::string print = fmt::format("{} {} mm", material, slicer_mm(layers.height));
    SlicerSettings of_print{{"compatible_printers", list_of_one(name_)}}, of_material = of_print;
    for (const auto& setting : layer_settings(layers)) {
      const bool is_of_print = setting.first == "layer_height" || setting.first == "faded_layers";
      (is_of_print ? of_print : of_material).push_back(setting);
    }
    const Scale& shrinkage = resin.shrinkage_factors;
    of_material.insert(of_material.end(),
                       {{"compatible_prints", list_of_one(print)},
                        {"material_correction", fmt::format("{},{},{}", decimal(shrinkage.x),
                                                            decimal(shrinkage.y), decimal(shrinkage.z))},
                        {"material_correction_x", decimal(shrinkage.x)},
                        {"material_correction_y", decimal(shrinkage.y)},
                        {"material_correction_z", decimal(shrinkage.z)}});
    profiles_ += section("sla_print", print, of_print) + section("sla_material", material, of_material);
    if (resin.name != printer_.resin) return;
    print_ = print;
    material_ = material;
    lift_ = resin.motion.whole_lift();
  }

  [[nodiscard]] std::string text(const std::optional<std::string>& host) const {
    std::string text = fmt::format(
        "# PrusaSlicer's profiles of the printer {}, by \"contourctl export prusaslicer\".\n"
        "# Import them in PrusaSlicer: File > Import > Import Config Bundle.\n\n{}{}",
        name_, section("printer", name_, of_printer()), profiles_);
    std::string active =
        fmt::format("printer = {}\nsla_print = {}\nsla_material = {}\n", name_, print_, material_);
    if (host) {
      const std::string physical = name_ + " (contourd)";
      text += section("physical_printer", physical,
                      {{"preset_names", list_of_one(name_)},
                       {"print_host", *host},
                       {"printer_technology", "SLA"},
                       {"printhost_authorization_type", "key"}});
      active += fmt::format("physical_printer = {}\n", physical);
    }
    return text + "[presets]\n" + active;
  }

 private:
  // Returns the resin's name in the bundle. PrusaSlicer takes no bundle with two profiles of one name, and
  // names may differ only in characters that are replaced.
  std::string material_name(std::string_view resin) {
    const std::string name = profile_name(resin);
    std::string unique = name;
    for (int number = 2; std::ranges::find(materials_, unique) != materials_.end(); ++number)
      unique = fmt::format("{} ({})", name, number);
    materials_.push_back(unique);
    return unique;
  }

  [[nodiscard]] SlicerLayers layers_of(const ResinProfile& resin) const {
    const auto exposure = [&](int layer) {
      return exposure_time(resin, resin.layer_height, layer, printer_.irradiance_mw_cm2);
    };
    return {resin.layer_height, exposure(resin.bottom_layers + resin.fade_layers), exposure(0),
            std::clamp(resin.fade_layers, kFewestFaded, kMostFaded)};
  }

  [[nodiscard]] SlicerSettings of_printer() const {
    SlicerSettings settings = display_settings({printer_.display_width, printer_.display_height,
                                                printer_.pixel_pitch, printer_.mirror_x, printer_.mirror_y});
    const std::string longest = slicer_seconds(kLongestExposure);
    settings.insert(settings.end(), {{"absolute_correction", "0"},
                                     {"default_sla_material_profile", list_of_one(material_)},
                                     {"default_sla_print_profile", print_},
                                     {"elefant_foot_compensation", "0"},
                                     {"gamma_correction", "1"},
                                     {"max_exposure_time", longest},
                                     {"max_initial_exposure_time", longest},
                                     {"max_print_height", slicer_mm(printer_.travel - lift_)},
                                     {"min_exposure_time", "0"},
                                     {"min_initial_exposure_time", "0"},
                                     {"printer_model", "contourd"},
                                     {"printer_technology", "SLA"},
                                     {"printer_variant", "default"},
                                     {"relative_correction", "1,1"},
                                     {"relative_correction_x", "1"},
                                     {"relative_correction_y", "1"},
                                     {"relative_correction_z", "1"},
                                     {"sla_archive_format", "SL1SVG"},
                                     {"sla_output_precision", "0.001"},
                                     {"thumbnails", "400x400,800x480"}});
    return settings;
  }

  const PrinterConfig& printer_;
  std::string name_;
  std::string profiles_;                // sections of the resins
  std::vector<std::string> materials_;  // names of the resins
  std::string print_, material_;        // profiles of the printer's own resin
  Nanometers lift_{};
};

int export_prusaslicer(const ExportArguments& given) {
  if (given.host && std::ranges::any_of(*given.host, [](char c) { return c <= ' ' || c > '~'; }))
    throw UsageError(
        fmt::format("--host {}: expected an address such as 192.168.1.20:8080", in_quotes(*given.host)));
  const PrinterConfig printer = load_printer_config(given.file, Places::Elsewhere);
  SlicerBundle bundle(printer);
  for (const std::string& name : profiles_in(printer.resins_folder)) {
    try {
      bundle.add(find_resin(printer, name));
    } catch (const ConfigError& error) {
      if (name == printer.resin) throw;
      fmt::print(stderr, "contourctl: warning: the resin {} is left out: {}\n", in_quotes(name),
                 error.in_one_line());
    }
  }
  const std::string text = bundle.text(given.host);
  if (!given.output) {
    fmt::print("{}", text);
    return kOk;
  }
  write_text(*given.output, text);
  return kOk;
}

}  // namespace

void add_export(Command& program) {
  Command& group = program.add("export", "Export the printer's settings for slicers");
  Command& command = group.add("prusaslicer", "Write PrusaSlicer profiles of the printer and its resins");
  auto& given = command.arguments<ExportArguments>();
  command.option("FILE", given.file, "Configuration file");
  command.option("-o,--output", given.output, "Write the config bundle (.ini) to this file");
  command.option("--host", given.host, "Address of the printer's web page, to which PrusaSlicer sends");
  command.run = [&given] { return export_prusaslicer(given); };
}

}  // namespace contourd::ctl
