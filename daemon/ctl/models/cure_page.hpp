// The page of `contourctl cure --html`: a picture of the part with its worst places, figures, the section
// through the worst place, and plots of the distances. One self-contained file. Thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/ctl/models/cured_surface_file.hpp"
#include "daemon/ctl/models/print_subject.hpp"
#include "daemon/report/printed_light.hpp"

namespace contourd::ctl {

struct CureResult {
  CuredPart part;
  std::optional<RiseLight> rise{};          // nullopt: nothing rose
  std::optional<WrittenSurface> surface{};  // nullopt: not wanted
  std::vector<std::string> warnings{};
};

// Returns the page of a part. `name` is the model's.
[[nodiscard]] std::string cure_page(const std::string& name, const PrintSubject& subject,
                                    const CureResult& result);

}  // namespace contourd::ctl
