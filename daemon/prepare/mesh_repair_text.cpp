#include "daemon/prepare/mesh_repair_text.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "core/model/height_index.hpp"

namespace contourd {

std::string describe(const MeshRepairs& repairs) {
  std::string text;
  const auto add = [&text](std::uint64_t count, std::string_view kind, std::string_view repair) {
    if (count == 0) return;
    text += fmt::format("{}{} {}{} {}", text.empty() ? "" : ", ", count, kind,
                        count == 1 ? "facet" : "facets", repair);
  };
  add(repairs.turned, "", "turned round");
  add(repairs.doubled, "duplicate ", "removed");
  add(repairs.reversed, "reversed duplicate ", "removed");
  add(repairs.inner_walls, "inner wall ", "removed");
  return text;
}

std::vector<std::string> mesh_warnings(bool turned_outwards, const MeshRepairs& repairs) {
  std::vector<std::string> warnings;
  if (turned_outwards) warnings.emplace_back(kTurnedOutwardsWarning);
  if (repairs != MeshRepairs{})
    warnings.push_back("the model's facets disagree with each other: " + describe(repairs));
  return warnings;
}

nlohmann::ordered_json repairs_json(const MeshRepairs& repairs) {
  return {{"turned_facets", repairs.turned},
          {"doubled_facets", repairs.doubled},
          {"reversed_facets", repairs.reversed},
          {"inner_wall_facets", repairs.inner_walls}};
}

}  // namespace contourd
