// What every measurement of the benchmark gets to know, and the list of them. Each returns its rows.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "tests/bench/report.hpp"

namespace contourd::bench {

// The models' files. Those that formulas give are made when first asked for and kept in `folder`. Not
// thread-safe.
class Models {
 public:
  Models(std::filesystem::path folder, std::filesystem::path shared, bool quick)
      : folder_(std::move(folder)), shared_(std::move(shared)), quick_(quick) {}

  // A model that the project cannot make, where it is at hand.
  [[nodiscard]] std::optional<std::filesystem::path> shared(const std::string& name) const;
  // 1.3 million facets (2,400 for a quick run), binary. Throws std::runtime_error when it cannot be written.
  [[nodiscard]] std::filesystem::path gyroid() const;
  // 294,000 facets of the same shape (also 2,400), ASCII. Throws as gyroid().
  [[nodiscard]] std::filesystem::path ascii_gyroid() const;

 private:
  std::filesystem::path folder_, shared_;
  bool quick_;
};

struct Bench {
  bool quick = false;  // see that everything works; the figures say nothing
  bool peers = true;   // run other programs too
  const Models& models;

  // As many repetitions as the figures need, or as few as will do.
  [[nodiscard]] int runs(int thorough) const { return quick ? std::min(thorough, 3) : thorough; }
};

inline constexpr const char* kPlate = "plate-figurines-935k.stl";
inline constexpr const char* kLiver = "minetto-liver.stl";
inline constexpr const char* kFemur = "minetto-femur.stl";
inline constexpr const char* kBunny = "bunny-stanford-x4-278k.stl";
inline constexpr std::uint64_t kSeed = 2019;  // of random heights

// The model fitted to a display, as the thesis does.
[[nodiscard]] ContourEngine fitted_engine(const std::filesystem::path& model, Pixels width, Pixels height);

// Heights within a model, as good as uniform and the same in every run.
[[nodiscard]] std::vector<Millimeters> random_heights(const Bounds& bounds, int count);

// A row for every id, for a model that is not at hand.
[[nodiscard]] std::vector<Row> skipped_rows(const std::vector<std::string>& ids, const std::string& model);

// contour_rows.cpp: linked contours of all layers.
[[nodiscard]] std::vector<Row> contour_rows(const Bench& bench);
// print_rows.cpp: all masks of a model, in memory and as files.
[[nodiscard]] std::vector<Row> print_rows(const Bench& bench);
// mask_rows.cpp: one mask, at random and rising heights.
[[nodiscard]] std::vector<Row> mask_rows(const Bench& bench);
// support_rows.cpp: what supports add to a mask.
[[nodiscard]] std::vector<Row> support_rows(const Bench& bench);
// load_rows.cpp: from a file to the first mask; reading; memory.
[[nodiscard]] std::vector<Row> load_rows(const Bench& bench);
// The child's part of it: prints the peak memory of this process after a model's first mask.
void print_memory_of_first_mask(const std::filesystem::path& model);
// display_rows.cpp: a mask into a picture for the screen, as it is written to a card's memory.
[[nodiscard]] std::vector<Row> display_rows(const Bench& bench);
// allocation_rows.cpp: operator new's calls.
[[nodiscard]] std::vector<Row> allocation_rows(const Bench& bench);
// growth_rows.cpp: time against facets, and against segments.
[[nodiscard]] std::vector<Row> growth_rows(const Bench& bench);
// instruction_rows.cpp: instructions, counted by callgrind in a child of this program.
[[nodiscard]] std::vector<Row> instruction_rows(const Bench& bench);
// The child's part of it: prints how many times the thing was done, and on how many segments, facets or
// bytes.
void do_measured(const std::string& thing, const std::filesystem::path& model);

}  // namespace contourd::bench
