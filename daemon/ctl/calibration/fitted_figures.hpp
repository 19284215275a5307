// The result of a fit. Values.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/calibration_record.hpp"

namespace contourd::ctl {

// A measurement beside the fit.
struct FittedPoint {
  std::vector<double> given;
  double measured = 0, fitted = 0;
};

// A new file that a value names, beside the file that gets the value.
struct NamedFile {
  std::filesystem::path file;
  std::string content;
};

struct FitResult {
  std::string kind;                       // as in the group `fit`
  std::vector<CalibratedValue> values{};  // to be written
  std::string given_heading{};            // heading of FittedPoint::given: "dose mJ/cm²"
  std::vector<FittedPoint> points{};
  std::string unit = "um";           // of measured and fitted values; empty: that of a meter
  double scatter = 0;                // of the measurements about the fit, in the unit
  std::vector<std::string> notes{};  // sentences
  std::optional<NamedFile> named{};
  std::string figure{};  // plot or map for the page, HTML

  // Returns a difference, or the scatter, without the noise of rounding: to a ten thousandth of the
  // largest measurement, rounded down to a power of ten.
  [[nodiscard]] double without_noise(double difference) const;
};

}  // namespace contourd::ctl
