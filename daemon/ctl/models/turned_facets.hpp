// A model that is turned by --up before a command looks at it. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/facet.hpp"
#include "daemon/ctl/models/up_option.hpp"
#include "daemon/prepare/model_orientation.hpp"

namespace contourd::ctl {

// Where no printer is known everything fits, and supports hold what does not stand 5 mm high.
inline constexpr OrientationLimits kAnyPrinter{
    {Millimeters{1e9}, Millimeters{1e9}, Millimeters{1e9}}, Scale{}, {}, Millimeters{5}};

// Without `up` they stay as they are. Where the best way up is to be found, stderr is told what that is; no
// printer is known then, and everything fits. `scale`: how much larger they will be.
void turn_facets(std::vector<Facet>& facets, const std::optional<UpOption>& up, double scale = 1);

}  // namespace contourd::ctl
