// The facets of a 3MF model: the objects of its build, with their components, transformed. Thread-safe (no
// shared state).
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/model/model.hpp"
#include "daemon/formats/threemf_part.hpp"
#include "daemon/formats/threemf_side_files.hpp"

namespace contourd {

// A model with all its files.
struct ThreeMfModel {
  std::map<std::string, ThreeMfPart> parts;  // by their names in the archive
  std::string root;                          // the name of the root model's part, which is among them
};

// Removes the meshes that the side file calls modifiers and the like. Returns how many of each kind.
[[nodiscard]] std::map<std::string, std::size_t> leave_out(ThreeMfModel& model,
                                                           const ThreeMfSideFile& side_file);

// Removes the items and components that are objects of a kind that is no part of the model. Returns how many
// of each kind.
[[nodiscard]] std::map<std::string, std::size_t> leave_out_kinds(ThreeMfModel& model);

// Returns the facets in millimetres, with a warning for everything that is left out. Throws ModelError if the
// build names an object that does not exist, has more than `most_facets` facets, or nothing to print.
[[nodiscard]] Model facets_of(const ThreeMfModel& model, std::uint64_t most_facets);

}  // namespace contourd
