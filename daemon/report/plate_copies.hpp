// The copies of models on a print's plate, each of which can be excluded from the rest of the print; and what
// a print has left dark of them.
// Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/cure/dark_copies.hpp"
#include "core/support/supports_of_copies.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/report/printed_light.hpp"

namespace contourd {

struct PlateCopy {
  std::size_t model = 0, copy = 0;  // numbers in the print's engine, from 0
  std::string name;                 // "tower.stl (copy 2)", as messages about the plate name it
  Point center;                     // from the plate's centre, in millimetres
  Point size;                       // along x and y, in millimetres
};

// Returns the copies in the order of the report's models and positions. `job` names the model of a job that
// is no plate.
[[nodiscard]] std::vector<PlateCopy> copies_of(const JobSummary& summary, const std::string& job);

// Returns the function that computes the supports of the copies that are not excluded, by their numbers in
// copies_of(); an empty one if the print has no supports.
[[nodiscard]] std::function<std::shared_ptr<const SupportStructure>()> supports_left(
    const std::optional<Supports>& supports, std::span<const PlateCopy> copies,
    const std::set<std::size_t>& excluded);

// Returns the copies that a print has left dark, by its recorded light. REQUIRES: exclusions by rising
// layers, each of one of the copies.
[[nodiscard]] std::vector<DarkCopy> dark_copies(std::span<const Exclusion> exclusions,
                                                std::span<const PlateCopy> copies,
                                                const std::optional<Supports>& supports,
                                                const PrintedLight& light);

}  // namespace contourd
