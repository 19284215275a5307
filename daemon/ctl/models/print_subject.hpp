// The print that a command computes of a model's file: as contourd prints it with a printer's configuration,
// or in the middle of a display. Thread-safe (no shared state).
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/cure/pixel_light.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/mask/light_split.hpp"
#include "core/support/supports.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/terminal/command.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/print/rise_forecast.hpp"
#include "daemon/report/plate_copies.hpp"
#include "hw/clock.hpp"

namespace contourd::ctl {

// The arguments as the user typed them.
struct PrintArgs {
  std::filesystem::path model;
  SizeArgs size;
  std::optional<std::string> supports;    // default: as configured; without a configuration none
  std::optional<std::string> undersides;  // default: as the resin's profile and the ticket say

  // Configuration and ticket of a print by contourd.
  std::optional<std::filesystem::path> printer, ticket;
  std::optional<double> hollow_mm;  // default: as the ticket says
  bool follows_temperature = true;  // false: the light is that of the profile
  std::optional<std::string> mode;  // default: as the resin's profile and the ticket say
  // Without a configuration: the resin, the direction that points up, the display and its projector.
  std::optional<std::filesystem::path> resin;
  std::optional<std::string> up;
  DisplayArgs display;
  std::optional<double> layer_height_um;  // default: the resin's, or 50
  ToneCurve tone{};
  std::optional<Mask> uniformity{};
};

// Options that other options of the command may exclude.
struct PrintOptions {
  const Option &printer, &resin;
};
// Adds MODEL and the options that set `args`, apart from tone and uniformity.
PrintOptions add_print_options(Command& command, PrintArgs& args, const char* layer_height_help);

// The exposures of a print that are split.
struct SplitPrint {
  PanelTone panel;
  std::vector<double> shortest;  // by layer, the share of its exposure that a picture lasts at least
};

// The exposures of a print's lowest layer, and of its layers above the fade.
struct LayerExposures {
  Duration first{}, normal{};
};

struct PrintSubject {
  std::unique_ptr<ContourEngine> engine;
  EngineSettings settings;
  std::optional<ResinProfile> resin;  // with the undersides as they are exposed; nullopt: not given
  std::vector<Nanometers> layers;     // thicknesses, from the plate up
  PixelLight pixel_light{};           // on the film
  std::vector<LayerDose> doses;       // of the layers; none without a resin
  std::optional<SplitPrint> split;    // nullopt: each exposure shows one mask
  std::optional<Supports> supports;
  std::vector<PlateCopy> copies{1};  // places of the model
  AnalysisOptions analysis;
  std::optional<LayerExposures> exposures;               // nullopt without a printer's configuration
  std::optional<std::vector<Duration>> layer_durations;  // nullopt without a printer's configuration
  std::optional<PrintForecast> forecast;                 // nullopt without a printer's configuration
  std::optional<ContinuousForecast> continuous;          // nullopt: the print is layered
  std::array<double, 3> size_mm{};                       // of the model, as printed
  std::vector<std::string> warnings;

  // Returns the dimming of the undersides; null if they are exposed plainly.
  [[nodiscard]] std::unique_ptr<UndersideDimming> dimming() const;
  // Returns the masks of the dimmed undersides; null if they are exposed plainly.
  [[nodiscard]] std::unique_ptr<DimmedMasks> dimmed_masks() const;
  // Returns the light that split exposures give; null if none is split.
  [[nodiscard]] std::unique_ptr<GivenLight> given_light() const;
};

// Prepares the print. Throws UsageError, ModelError, ConfigError and ProfileTrouble. Blocks: see
// prepare_job().
[[nodiscard]] PrintSubject print_subject(const PrintArgs& args);

}  // namespace contourd::ctl
