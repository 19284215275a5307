#include "core/hollow/cavity.hpp"

#include <cstddef>
#include <span>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {

Cavity::Cavity(const CavityGrid& grid, std::vector<std::uint32_t> starts, std::vector<CavityRun> runs,
               std::shared_ptr<const SectionSource> holes)
    : grid_(grid), starts_(std::move(starts)), runs_(std::move(runs)), holes_(std::move(holes)) {
  expects(starts_.size() == static_cast<std::size_t>(grid_.slices) + 1 && starts_.back() == runs_.size(),
          "every slice has its runs");
}

void Cavity::section_at(Nanometers z, Contours& contours) const {
  contours.points.clear();
  contours.loops.clear();
  if (holes_) holes_->section_at(z, contours);
  const double slice = grid_.slice_at(to_millimeters(z));
  if (!(slice >= 0 && slice < grid_.slices)) return;
  const auto k = static_cast<std::size_t>(slice);
  for (const CavityRun& run : std::span(runs_).subspan(starts_[k], starts_[k + 1] - starts_[k])) {
    const double left = grid_.left_of(run.first), right = grid_.left_of(run.end);
    const double top = grid_.top_of(run.row), bottom = grid_.top_of(run.row + 1);
    contours.loops.push_back({static_cast<std::uint32_t>(contours.points.size()), 4});
    contours.points.insert(contours.points.end(),
                           {{left, bottom}, {right, bottom}, {right, top}, {left, top}});
  }
}

}  // namespace contourd
