// Turns a model by --up before a command uses it. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/facet.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/prepare/model_orientation.hpp"

namespace contourd::ctl {

// Limits without a printer's configuration: every size fits, and supports lift the model by 5 mm.
inline constexpr OrientationLimits kAnyPrinter{
    {Millimeters{1e9}, Millimeters{1e9}, Millimeters{1e9}}, Scale{}, {}, Millimeters{5}};

// Turns the facets so that `up` points up; does nothing without `up`. If the best orientation is to be found,
// uses kAnyPrinter and prints the orientation on stderr. `scale`: factor by which the facets will be scaled
// later.
void turn_facets(std::vector<Facet>& facets, const std::optional<UpOption>& up, double scale = 1);

}  // namespace contourd::ctl
