#include "daemon/ctl/models/cured_surface_file.hpp"

#include <fmt/format.h>

#include "daemon/ctl/models/stl_file.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"

namespace contourd::ctl {
namespace {

constexpr std::int32_t kWidestStep = 1 << 14;  // wider than any display

struct TooManyFacets {};

}  // namespace

WrittenSurface write_cured_surface(const std::filesystem::path& path, PrintCure& print) {
  for (std::int32_t step = 1; step <= kWidestStep; step *= 2) {
    StlFile file(path, "cured part");
    try {
      print.make_surface(step, [&](const Facet& facet) {
        if (file.facets() == kMostSurfaceFacets) throw TooManyFacets();
        file.add(facet);
      });
    } catch (const TooManyFacets&) {
      continue;
    }
    file.appear();
    return {file.facets(), step};
  }
  throw OutputError(
      fmt::format("cannot write {}: the surface has more than {} facets with lines through every "
                  "{}-th pixel, because there are too many layers",
                  path.string(), kMostSurfaceFacets, kWidestStep));
}

}  // namespace contourd::ctl
