// The copies of models on a print's plate, each of which can be excluded from the rest of the print.
// Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/support/supports_of_copies.hpp"
#include "daemon/prepare/job_summary.hpp"

namespace contourd {

struct PlateCopy {
  std::size_t model = 0, copy = 0;  // numbers in the print's engine, from 0
  std::string name;                 // "tower.stl (copy 2)", as messages about the plate name it
  Point center;                     // from the plate's centre, in millimetres
};

// Returns the copies in the order of the report's models and positions. `job` names the model of a job that
// is no plate.
[[nodiscard]] std::vector<PlateCopy> copies_of(const JobSummary& summary, const std::string& job);

// Returns the function that computes the supports of the copies that are not excluded, by their numbers in
// copies_of(); an empty one if the print has no supports.
[[nodiscard]] std::function<std::shared_ptr<const SectionSource>()> supports_left(
    const JobSummary& summary, const std::set<std::size_t>& excluded);

}  // namespace contourd
