// Figures and settings of a job, for the log and the report. Values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/cure/pixel_light.hpp"
#include "core/layers/adaptive_layers.hpp"
#include "core/model/mesh_report.hpp"
#include "core/model/shell_report.hpp"
#include "core/repair/mesh_repair.hpp"
#include "core/support/supports.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "daemon/print/rise_forecast.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The cavities of a hollowed model.
struct HollowSummary {
  HollowSettings settings{};
  std::size_t cavities = 0;
  double volume_mm3 = 0;
  Millimeters cell{};            // within which the walls are right
  std::vector<Frustum> holes{};  // added for the cavities, in the model's own millimetres
};

// One of a job's models.
struct ModelSummary {
  std::string file;         // in the plate's folder and in an archive; empty for a job of one file
  std::string_view format;  // name of the file format
  MeshReport mesh;          // as placed and repaired
  MeshRepairs repairs;
  ShellReport shells;
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;  // as placed
  Scale scale;                                         // without the resin's shrinkage
  RotationDegrees rotation_deg;
  std::optional<Direction> up;
  std::size_t drain_holes = 0;  // the ticket's
  std::optional<HollowSummary> hollow{};
  bool carries_supports = false;                // as its name in an archive, or the ticket, says
  std::optional<ModelOrientation> orientation;  // the search that found `up`; nullopt if there was none
  std::vector<Point> centers;                   // one for each copy, from the plate's centre, in millimetres
};

// Estimates made before the print, which decides layer by layer.
struct LayerSummary {
  std::int32_t count = 0;
  Nanometers thinnest{}, thickest{};  // equal if all layers are alike
  std::optional<AdaptiveLayers> adaptive;
};

// The light that follows the resin's temperature.
struct FollowedTemperature {
  double resin_c = 0, curve_c = 0;  // now, and when the resin's working curve was measured
  double light = 1;                 // over that for curve_c
};

// Figures and settings of a job and its models.
struct JobSummary {
  std::vector<ModelSummary> models;  // at least one
  bool plate = false;
  bool sliced = false;            // the file holds finished layers; the model is the box around them
  bool dry = false;               // printed without light
  bool confirm = false;           // the ticket has it wait until a user accepts it
  double height_mm = 0;           // top of the highest model above the plate
  ResinProfile resin;             // as the job is printed
  OverriddenSettings overridden;  // values of `resin` that the ticket sets
  std::optional<FollowedTemperature> temperature;  // nullopt if the light is that of the profile
  double irradiance_mw_cm2 = 0;                    // the printer's, as are the next four
  ToneCurve tone;                                  // by which the resin cures
  PixelLight pixel_light{};                        // on the film
  int grey_bits = 8;                               // of the panel
  bool uniformity_mask = false;                    // true if the printer has one
  LayerSummary layers;
  std::optional<ContinuousForecast> continuous;  // nullopt: the print is layered
  std::optional<Supports> supports;              // nullopt if the job has supports off
  Duration reading{};                            // time to read the files
  Duration supporting{};                         // time to generate the supports
  Duration indexing{};                           // time for placement and height index
  Duration first_mask{};                         // time to build the engine and compute the mask of layer 1
  bool prepared_before = false;  // true if the job was prepared while it waited, not at its turn
  std::vector<std::string> warnings;
  std::string temperature_warning{};         // from follow_temperature(); a warning, too
  std::vector<std::string> rise_warnings{};  // from plan_rises_of(); warnings, too
  std::string unit_hint;  // from unit_hint(), of the first model that has one; a warning, too
  std::string
      unit_question;  // the first unit_hint() about a model whose ticket names no unit; a warning, too
  // A sentence about the first model that gets supports although its name says that it carries some in its
  // file; a warning, too.
  std::string supports_question{};
  std::string left_out;   // a sentence about an archive's models without room on the plate; a warning, too
  std::string wide_gaps;  // a sentence about the first model with gaps far wider than a pixel; a warning, too
};

// Returns what the layers of a sliced file are: "pictures of layers".
[[nodiscard]] std::string layers_text(const ModelSummary& model);

// Returns the corrections of contours and masks, for a person: "contours moved outwards by 50 um, ...". Empty
// if there are none.
[[nodiscard]] std::string describe_correction(const JobSummary& summary);

// Returns the settings that the job is printed with, for a person: "standard: exposure 3000 ms, ...".
// Settings from the ticket are named at the end.
[[nodiscard]] std::string describe_settings(const JobSummary& summary);

// Returns the overridden settings as a list of objects: setting, asked, profile.
[[nodiscard]] nlohmann::ordered_json overrides_json(const OverriddenSettings& overridden);

}  // namespace contourd
