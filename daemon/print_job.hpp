// From a model's file and its ticket to a print that can begin: read, placed, checked against the machine,
// its first mask computed. Thread-safe (no shared state): runs on the worker's thread.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh_report.hpp"
#include "core/stl_reader.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/print_process.hpp"

namespace contourd {

struct JobFiles {
  std::string name;  // unique among all jobs in the spool; fit for a file's name
  std::filesystem::path model;
  std::optional<std::filesystem::path> ticket;
};

// The job cannot be printed. what() is for the owner: what, where, why.
class JobRefused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What a job is, for the log and the report.
struct JobSummary {
  StlFormat format = StlFormat::Binary;
  MeshReport mesh;                                     // as in the file
  double size_x_mm = 0, size_y_mm = 0, size_z_mm = 0;  // as placed
  double scale = 1;
  RotationDegrees rotation_deg;
  PlateOffset position;
  int copies = 1;
  ResinProfile resin;
  ToneCurve tone;          // of the printer
  bool lamp_mask = false;  // whether the printer evens out its lamp
  LayerStack layers;
  Duration reading{};     // the file, to facets
  Duration indexing{};    // placement and height index
  Duration first_mask{};  // from the first facet to the mask of layer 1
  std::vector<std::string> warnings;
};

// What is done to contours and masks beyond slicing, for a person: "contours moved outwards by 50 um, ...".
// Empty when nothing is.
[[nodiscard]] std::string describe_correction(const JobSummary& summary);

struct PreparedJob {
  PrintPlan plan;
  JobSummary summary;
  TimePoint first_mask_at{};  // CLOCK_MONOTONIC, whatever clock the machine runs by
};

// Blocks: a few hundred milliseconds for a million facets. Throws JobRefused.
[[nodiscard]] PreparedJob prepare_job(const JobFiles& files, const PrinterConfig& printer);

}  // namespace contourd
