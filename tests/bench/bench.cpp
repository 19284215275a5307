#include "tests/bench/bench.hpp"

#include <fstream>
#include <random>
#include <stdexcept>

#include "core/formats/model_reader.hpp"
#include "tests/models/models.hpp"

namespace contourd::bench {
namespace {

constexpr double kRadiusMm = 20, kPeriodMm = 10;
constexpr int kCells = 110, kAsciiCells = 53, kQuickCells = 12;

// Writes the model under a temporary name first, so that an interrupted run leaves no incomplete model for
// the next one.
template <typename Write>
std::filesystem::path make_once(const std::filesystem::path& path, Write&& write) {
  if (std::filesystem::exists(path)) return path;
  std::filesystem::create_directories(path.parent_path());
  const std::filesystem::path unfinished = path.string() + ".part";
  write(unfinished);
  std::filesystem::rename(unfinished, path);
  return path;
}

}  // namespace

std::optional<std::filesystem::path> Models::shared(const std::string& name) const {
  const std::filesystem::path path = shared_ / "models" / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}

std::filesystem::path Models::gyroid() const {
  const int cells = quick_ ? kQuickCells : kCells;
  return make_once(folder_ / ("gyroid-" + std::to_string(cells) + ".stl"), [&](const auto& path) {
    models::write_binary_stl(path, models::gyroid_sphere(kRadiusMm, kPeriodMm, cells));
  });
}

std::filesystem::path Models::ascii_gyroid() const {
  const int cells = quick_ ? kQuickCells : kAsciiCells;
  return make_once(folder_ / ("gyroid-" + std::to_string(cells) + "-ascii.stl"), [&](const auto& path) {
    std::ofstream file(path, std::ios::binary);
    file << models::to_ascii_stl(models::gyroid_sphere(kRadiusMm, kPeriodMm, cells));
    file.close();
    if (!file) throw std::runtime_error("cannot write " + path.string());
  });
}

ContourEngine fitted_engine(const std::filesystem::path& model, Pixels width, Pixels height) {
  const DisplayGeometry display{width, height};
  HeightIndex index(read_model_file(model).facets);
  const PixelMap map = PixelMap::fit(display, index.bounds());
  return ContourEngine(std::move(index), EngineSettings{display, AntiAliasing::On}, {map});
}

std::vector<Millimeters> random_heights(const Bounds& bounds, int count) {
  std::mt19937_64 random(kSeed);
  std::vector<Millimeters> heights;
  for (int i = 0; i < count; ++i) {
    const double part = static_cast<double>(random() >> 11) * 0x1p-53;  // [0, 1), the same in every library
    heights.emplace_back(bounds.min_z + part * bounds.size_z());
  }
  return heights;
}

std::vector<Row> skipped_rows(const std::vector<std::string>& ids, const std::string& model) {
  std::vector<Row> rows;
  for (const std::string& id : ids) {
    Row row{id, id, ""};
    row.skipped = "no model " + model;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace contourd::bench
