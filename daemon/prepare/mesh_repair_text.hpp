// Formats the repairs of a model's mesh as text and as JSON. Thread-safe (no shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/repair/mesh_repair.hpp"

namespace contourd {

// Returns "17 facets turned round, 2 inner wall facets removed"; empty if nothing was repaired.
[[nodiscard]] std::string describe(const MeshRepairs& repairs);

// Returns the repairs as a warning, a sentence.
[[nodiscard]] std::string repair_warning(const MeshRepairs& repairs);

// Returns the number of facets by kind of repair.
[[nodiscard]] nlohmann::ordered_json repairs_json(const MeshRepairs& repairs);

}  // namespace contourd
