#include "daemon/report/plate_copies.hpp"

#include <fmt/format.h>

#include <utility>

namespace contourd {

std::vector<PlateCopy> copies_of(const JobSummary& summary, const std::string& job) {
  std::vector<PlateCopy> copies;
  for (std::size_t i = 0; i < summary.models.size(); ++i) {
    const ModelSummary& model = summary.models[i];
    const std::string& name = model.file.empty() ? job : model.file;
    const std::size_t count = model.centers.size();
    for (std::size_t copy = 0; copy < count; ++copy)
      copies.push_back(
          {i, copy, count > 1 ? fmt::format("{} (copy {})", name, copy + 1) : name, model.centers[copy]});
  }
  return copies;
}

std::function<std::shared_ptr<const SectionSource>()> supports_left(const JobSummary& summary,
                                                                    const std::set<std::size_t>& excluded) {
  if (!summary.supports || !summary.supports->structure) return {};
  std::vector<CopyOutline> outlines;
  for (const ModelSummary& model : summary.models) {
    for (const Point& center : model.centers) {
      const double x = model.size_x_mm / 2, y = model.size_y_mm / 2;
      outlines.push_back(
          {{center.x - x, center.y - y}, {center.x + x, center.y + y}, !excluded.contains(outlines.size())});
    }
  }
  return [structure = summary.supports->structure, outlines = std::move(outlines)] {
    return supports_of_printed(*structure, outlines);
  };
}

}  // namespace contourd
