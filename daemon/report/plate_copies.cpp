#include "daemon/report/plate_copies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {

std::vector<PlateCopy> copies_of(const JobSummary& summary, const std::string& job) {
  std::vector<PlateCopy> copies;
  for (std::size_t i = 0; i < summary.models.size(); ++i) {
    const ModelSummary& model = summary.models[i];
    const std::string& name = model.file.empty() ? job : model.file;
    const std::size_t count = model.centers.size();
    for (std::size_t copy = 0; copy < count; ++copy)
      copies.push_back({i,
                        copy,
                        count > 1 ? fmt::format("{} (copy {})", name, copy + 1) : name,
                        model.centers[copy],
                        {model.size_x_mm, model.size_y_mm}});
  }
  return copies;
}

std::function<std::shared_ptr<const SupportStructure>()> supports_left(
    const std::optional<Supports>& supports, std::span<const PlateCopy> copies,
    const std::set<std::size_t>& excluded) {
  if (!supports || !supports->structure) return {};
  std::vector<CopyOutline> outlines;
  for (const PlateCopy& copy : copies) {
    const Point half{copy.size.x / 2, copy.size.y / 2};
    outlines.push_back({{copy.center.x - half.x, copy.center.y - half.y},
                        {copy.center.x + half.x, copy.center.y + half.y},
                        !excluded.contains(outlines.size())});
  }
  return [structure = supports->structure, outlines = std::move(outlines)] {
    return supports_of_printed(*structure, outlines);
  };
}

std::vector<DarkCopy> dark_copies(std::span<const Exclusion> exclusions, std::span<const PlateCopy> copies,
                                  const std::optional<Supports>& supports, const PrintedLight& light) {
  expects(
      std::ranges::is_sorted(exclusions, {}, &Exclusion::layer) &&
          std::ranges::all_of(exclusions, [&](const Exclusion& each) { return each.number < copies.size(); }),
      "exclusions are those of copies, by rising layers");
  std::vector<DarkCopy> dark;
  std::set<std::size_t> excluded;
  for (const Exclusion& each : exclusions) {
    excluded.insert(each.number);
    const auto first = std::ranges::lower_bound(light.sources, static_cast<std::size_t>(each.layer), {},
                                                &PrintedLight::Source::record);
    const auto left = supports_left(supports, copies, excluded);
    const PlateCopy& copy = copies[each.number];
    dark.push_back({copy.model, copy.copy, static_cast<std::size_t>(first - light.sources.begin()),
                    left ? left() : nullptr});
  }
  return dark;
}

}  // namespace contourd
