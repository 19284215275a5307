// Formats the repairs of a model's mesh as text and as JSON. Thread-safe (no shared state).
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/model/shell_report.hpp"
#include "core/repair/mesh_repair.hpp"

namespace contourd {

// Returns "17 facets turned round, 2 inner wall facets removed"; empty if nothing was repaired.
[[nodiscard]] std::string describe(const MeshRepairs& repairs);

// Returns a warning, a sentence, for each thing that a HeightIndex has done to its facets.
[[nodiscard]] std::vector<std::string> mesh_warnings(bool turned_outwards, const MeshRepairs& repairs);

// Returns a warning, a sentence, for each kind of shell that was found. `place_of` describes a vertex: "1.00,
// 2.00 mm from the plate's centre".
[[nodiscard]] std::vector<std::string> shell_warnings(
    const ShellReport& shells, const std::function<std::string(const Vertex&)>& place_of);

// Returns the number of facets by kind of repair.
[[nodiscard]] nlohmann::ordered_json repairs_json(const MeshRepairs& repairs);

}  // namespace contourd
