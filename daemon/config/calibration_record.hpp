// Calibrations in a JSON file: the values that they set in a resin profile or a printer's configuration, kept
// in its array `calibrations`, so that the last one can be undone. Thread-safe (no shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace contourd {

// A value of the file, by its JSON pointer.
struct CalibratedValue {
  std::string key;                      // "/working_curve/peel_memory"; at most two levels deep
  nlohmann::ordered_json value;         // a number or a text; null removes the key
  std::optional<double> uncertainty{};  // standard uncertainty, in the value's unit
  std::optional<double> correlation{};  // of its error with that of the calibration's first value
};

struct Calibration {
  std::string kind;  // as in contourctl fit
  std::string date;  // YYYY-MM-DD
  std::optional<double> lamp_hours{};
  std::vector<CalibratedValue> values{};
};

// Returns the text of a JSON object with the calibration's values, and the calibration as the last of its
// `calibrations`; of more than a hundred the oldest are dropped. Keys keep their order. This and the
// functions below throw nlohmann::json::exception if the text is no valid profile or configuration.
[[nodiscard]] std::string with_calibration(const std::string& text, const Calibration& calibration);

// The error of a value that a calibration set.
struct CalibratedError {
  double uncertainty = 0;
  double correlation = 0;  // with the error of the calibration's first value; 0 if it is not known
};
// Returns the error of the value at that key: of the last calibration that set it, if the value has not been
// changed since; else nullopt.
[[nodiscard]] std::optional<CalibratedError> calibrated_error(const std::string& text,
                                                              const std::string& key);

struct UndoneCalibration {
  std::string text;  // of the file without it
  std::string kind, date;
};

// Returns the text of a JSON object with the values from before its last calibration. Throws
// std::runtime_error with a sentence if there is none, or if one of its values was changed since.
[[nodiscard]] UndoneCalibration without_last_calibration(const std::string& text);

}  // namespace contourd
