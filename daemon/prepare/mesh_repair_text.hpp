// What was repaired in a model's mesh, in words and as JSON. Thread-safe (no shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/repair/mesh_repair.hpp"

namespace contourd {

// "17 facets turned round, 2 facets of walls inside left out"; empty when nothing was.
[[nodiscard]] std::string describe(const MeshRepairs& repairs);

// The same as a warning.
[[nodiscard]] std::string repair_warning(const MeshRepairs& repairs);

[[nodiscard]] nlohmann::ordered_json repairs_json(const MeshRepairs& repairs);

}  // namespace contourd
