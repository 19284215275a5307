// What a job is, for the log and the report. Values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/layers/adaptive_layers.hpp"
#include "core/model/mesh_report.hpp"
#include "core/repair/mesh_repair.hpp"
#include "core/support/supports.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/prepare/model_orientation.hpp"
#include "hw/clock.hpp"

namespace contourd {

// One of a job's models.
struct ModelSummary {
  std::string file;         // in the plate's folder; empty for a job of one model
  std::string_view format;  // its name
  MeshReport mesh;          // as placed and repaired
  MeshRepairs repairs;
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;  // as placed
  Scale scale;                                         // the resin's shrinkage not included
  RotationDegrees rotation_deg;
  std::optional<Direction> up;
  std::size_t drain_holes = 0;
  std::optional<ModelOrientation> orientation;  // by which `up` was found
  std::vector<Point> centers;                   // by copy, from the plate's centre, in millimetres
};

// Figures of layers that are still to come: the print decides as it goes.
struct LayerSummary {
  std::int32_t count = 0;
  Nanometers thinnest{}, thickest{};  // the same when all are alike
  std::optional<AdaptiveLayers> adaptive;
};

struct JobSummary {
  std::vector<ModelSummary> models;  // at least one
  bool plate = false;
  double height_mm = 0;           // of the highest model's top, above the plate
  ResinProfile resin;             // as the job is printed
  OverriddenSettings overridden;  // what of it is the ticket's
  double irradiance_mw_cm2 = 0;   // of the printer, and the next two
  ToneCurve tone;
  bool uniformity_mask = false;  // whether the printer has one
  LayerSummary layers;
  std::optional<Supports> supports;  // nothing where none are wanted
  Duration reading{};                // the files, to facets
  Duration supporting{};             // its models, where that is wanted
  Duration indexing{};               // placement and height index
  Duration first_mask{};             // from the first facet to the mask of layer 1
  bool prepared_before = false;      // while it waited, and not again when its turn came
  std::vector<std::string> warnings;
};

// What is done to contours and masks beyond slicing, for a person: "contours moved outwards by 50 um, ...".
// Empty when nothing is.
[[nodiscard]] std::string describe_correction(const JobSummary& summary);

// The values that the job is printed with, for a person: "standard: light of 3000 ms, ...". At the end, which
// of them are the ticket's.
[[nodiscard]] std::string describe_settings(const JobSummary& summary);

}  // namespace contourd
