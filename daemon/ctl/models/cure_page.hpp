// The page of `contourctl cure --html`: a picture of the part with its worst places, figures, the section
// through the worst place, and plots of the distances. One self-contained file. Thread-safe.
#pragma once

#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/ctl/models/print_subject.hpp"

namespace contourd::ctl {

// Returns the page of a part. `name` is the model's, `warnings` are listed.
[[nodiscard]] std::string cure_page(const std::string& name, const PrintSubject& subject,
                                    const CuredPart& part, const std::vector<std::string>& warnings);

}  // namespace contourd::ctl
