#include "daemon/ctl/models/job_picture.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace contourd {
namespace {

std::vector<PreviewPart> parts_of(const JobSummary& summary, const ContourEngine& engine) {
  constexpr std::uint64_t kMaxFacets = 5'000'000;  // drawing takes some seconds
  std::uint64_t facets = 0;
  for (std::size_t i = 0; i < summary.models.size(); ++i)
    facets += engine.models()[i].model->facets().size() * summary.models[i].centers.size();
  const bool all = facets <= kMaxFacets;
  std::vector<PreviewPart> parts;
  for (std::size_t i = 0; i < summary.models.size(); ++i) {
    const PlateModel& standing = engine.models()[i];
    const HeightIndex& model = *standing.model;
    const std::vector<Point>& centers = summary.models[i].centers;
    const Point middle = model.bounds().center();
    const double lift_mm = standing.elevation.lift(model.bounds()).count();
    for (std::size_t copy = 0; copy < (all ? centers.size() : 1); ++copy) {
      parts.push_back({model.facets(), centers[copy].x - middle.x, centers[copy].y - middle.y, lift_mm});
    }
  }
  return parts;
}

}  // namespace

Mask draw_job_picture(const JobSummary& summary, const ContourEngine& engine) {
  const Millimeters all{std::numeric_limits<double>::infinity()};
  return render_preview(parts_of(summary, engine), all, kJobPictureSide, kJobPictureSide);
}

}  // namespace contourd
