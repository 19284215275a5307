// Compares masks of dirty models with those of the clean originals: prints a line with the worst overlap for
// each part and defect, and exits with 1 if an overlap is too small. Without arguments it uses generated
// parts, otherwise the given STL files, if they are watertight.
#include <algorithm>
#include <cstdio>
#include <exception>

#include "core/formats/model_reader.hpp"
#include "core/model/mesh_report.hpp"
#include "core/model/placement.hpp"
#include "tests/models/damage.hpp"
#include "tests/reference/dirty_layers.hpp"
#include "tests/reference/dirty_parts.hpp"

namespace contourd::reference {
namespace {

constexpr double kHeights[] = {0.11, 0.37, 0.5, 0.73, 0.9};

// Returns false if a layer is worse than it should be and does not report it.
bool check(const Part& part) {
  bool right = true;
  for (const Dirt& dirt : all_dirt()) {
    if (part.joined && dirt.heavy) continue;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      models::Dice dice(seed);
      models::Facets dirty = part.facets;
      dirt.add(dirty, dice);
      const WorstLayer worst = worst_layer(part.facets, dirty, dirt.wanted, kHeights);
      const bool good = worst.overlap >= dirt.wanted || (dirt.may_be_told && worst.told);
      std::printf("%-6s %s, %s, %d layers: %.5f\n", good ? "ok" : "WRONG", part.name.c_str(), dirt.name,
                  worst.layers, worst.overlap);
      right = right && good;
    }
  }
  return right;
}

// Checks a model scaled to the display's size. A file that is not watertight is skipped, since it has no
// clean original.
bool check_file(const char* path) {
  models::Facets facets = read_model_file(path).facets;
  if (!inspect_mesh(facets).watertight) {
    std::printf("       %s is not watertight\n", path);
    return true;
  }
  const Bounds bounds = bounds_of(facets);
  orient(facets, {0, 0, 0, Scale(30 / std::max({bounds.size_x(), bounds.size_y(), bounds.size_z()}))});
  return check({path, facets});
}

int run(int count, char** paths) {
  bool right = true;
  for (int i = 0; i < count; ++i)
    right = check_file(paths[i]) && right;
  if (count == 0) {
    for (const Part& part : clean_parts())
      right = check(part) && right;
  }
  return right ? 0 : 1;
}

}  // namespace
}  // namespace contourd::reference

int main(int argc, char** argv) {
  try {
    return contourd::reference::run(argc - 1, argv + 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dirty-masks: %s\n", error.what());
    return 1;
  }
}
