#include "daemon/prepare/mesh_repair_text.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "core/model/height_index.hpp"
#include "daemon/system/readable.hpp"

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

std::vector<std::string> shell_warnings(const ShellReport& shells,
                                        const std::function<std::string(const Vertex&)>& place_of) {
  std::vector<std::string> warnings;
  const auto warn = [&](std::uint64_t count, const char* one, const char* many, const Vertex& at,
                        const char* consequence) {
    if (count == 0) return;
    warnings.push_back(fmt::format("{}{} at {}: {}", count_of(count, one, many),
                                   count == 1 ? "," : ", the first", place_of(at), consequence));
  };
  warn(shells.inside_out, "shell of the model is inside out though it lies in no solid or overlaps a cavity",
       "shells of the model are inside out though they lie in no solid or overlap a cavity",
       shells.inside_out_at,
       "such a shell is filled there, but where it overlaps a solid, nothing is printed; turn its facets "
       "outwards if it is a body, or unite it with the cavity that it overlaps");
  warn(shells.within, "shell of the model faces outwards within a solid",
       "shells of the model face outwards within a solid", shells.within_at,
       "such a shell is filled; turn its facets inwards if it is a cavity");
  warn(shells.filled, "cavity of the model lies where solids overlap",
       "cavities of the model lie where solids overlap", shells.filled_at,
       "such a cavity is filled there; unite the solids before the cavity is cut out of them");
  return warnings;
}

nlohmann::ordered_json repairs_json(const MeshRepairs& repairs) {
  return {{"turned_facets", repairs.turned},
          {"doubled_facets", repairs.doubled},
          {"reversed_facets", repairs.reversed},
          {"inner_wall_facets", repairs.inner_walls}};
}

}  // namespace contourd
