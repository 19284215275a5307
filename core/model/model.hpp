// A model, whatever file format it was read from.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/length_unit.hpp"

namespace contourd {

struct Model {
  std::vector<Facet> facets;          // as in the file; all coordinates are finite
  std::vector<std::string> warnings;  // oddities that do not change the shape, one sentence each
  std::optional<LengthUnit> unit{};  // the file's unit, if it names one; only 3MF and AMF files are converted
  bool lacks_facets = false;         // the file says that it has more: it may be a copy that broke off
  bool y_is_up = false;  // the format leaves open which way is up, and the shape suggests y; not applied
};

// Thrown if data is not a usable model. what() is one sentence: what, where (byte or line), why.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace contourd
