// How one model is to be printed, as the file beside it says. Value types; thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/units.hpp"

namespace contourd {

// About the x axis first, then y, then z; right-handed.
struct RotationDegrees {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

// Of the model's centre from the plate's centre.
struct PlateOffset {
  Millimeters x;
  Millimeters y;
};

// What is to become of a model whose contours cannot be closed without a guess.
enum class CrackPolicy {
  Repair,  // close them all the same, and warn
  Refuse,  // print nothing
};

// A default-made ticket is what a model without a file gets.
struct JobTicket {
  std::optional<std::string> resin;        // profile name; not yet known to exist
  std::optional<Nanometers> layer_height;  // not yet checked against the resin
  RotationDegrees rotation;
  std::optional<double> scale;  // factor; never together with fit
  bool fit = false;             // fill the display
  PlateOffset position;
  int copies = 1;
  CrackPolicy cracks = CrackPolicy::Repair;
};

// Reads NAME.json from beside NAME.stl. Throws ConfigError with everything that is wrong with it.
[[nodiscard]] JobTicket load_job_ticket(const std::filesystem::path& path);

}  // namespace contourd
